// Bars of behaviors on the canvas of the timeline.
import type { RunModel } from "../data/model";
import type { Row } from "../data/rows";
import { duration } from "../text";
import type { Theme } from "./theme";

export const ROW_HEIGHT = 24;

/** Visible part of the time [s] and its width [px]. */
export interface Window {
  start: number;
  end: number;
  width: number;
}

export function toX(view: Window, time: number): number {
  return ((time - view.start) / (view.end - view.start)) * view.width;
}

export function toTime(view: Window, x: number): number {
  return view.start + (x / view.width) * (view.end - view.start);
}

const failures = new WeakMap<Row, Int32Array>();

/** Executions of a row that failed. */
function failedRuns(run: RunModel, row: Row): Int32Array {
  let found = failures.get(row);
  if (found?.length !== row.counts[2]) {
    found = row.runs.filter((index) => run.behaviors.status[index] === 2);
    failures.set(row, found);
  }
  return found;
}

/** Draw the bars of a row. Of executions that share a pixel, one is drawn, and every failed one. */
export function drawRow(
  context: CanvasRenderingContext2D,
  run: RunModel,
  row: Row,
  view: Window,
  y: number,
  colours: Theme,
): void {
  if (row.runs.length === 0) {
    context.fillStyle = colours.muted;
    context.fillText("never ran", 6, y + ROW_HEIGHT / 2);
    return;
  }
  drawRuns(context, run, row, row.runs, view, y, colours);
  const isMixed = row.counts[2] > 0 && row.counts[2] < row.runs.length;
  if (isMixed) drawRuns(context, run, row, failedRuns(run, row), view, y, colours);
}

function drawRuns(
  context: CanvasRenderingContext2D,
  run: RunModel,
  row: Row,
  runs: Int32Array,
  view: Window,
  y: number,
  colours: Theme,
): void {
  const { start, end } = run.behaviors;
  // The last one that starts before the window may reach into it; earlier ones rarely overlap it.
  let at = Math.max(0, firstFrom(runs, start, view.start) - 1);
  while (at < runs.length) {
    const index = runs[at]!;
    if (start[index]! > view.end) break;
    const from = toX(view, start[index]!);
    const to = toX(view, end[index]!);
    if (to >= 0) drawBar(context, run, row, index, from, Math.max(to - from, 2), view, y, colours);
    // Skip executions that begin in the same pixel.
    at = Math.max(at + 1, to - from < 1 ? firstFrom(runs, start, toTime(view, from + 1)) : 0);
  }
}

function firstFrom(runs: Int32Array, start: Float64Array, time: number): number {
  let low = 0;
  let high = runs.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (start[runs[middle]!]! >= time) high = middle;
    else low = middle + 1;
  }
  return low;
}

const LEAVES = new Set(["action", "wait", "emit", "call"]);
const GLYPHS = ["▸", "✓", "✗", "–"];

function drawBar(
  context: CanvasRenderingContext2D,
  run: RunModel,
  row: Row,
  index: number,
  x: number,
  width: number,
  view: Window,
  y: number,
  colours: Theme,
): void {
  const status = run.behaviors.status[index] as 0 | 1 | 2 | 3;
  const colour = colours.status[status];
  const isLeaf = LEAVES.has(row.type);
  const height = isLeaf ? 14 : 8;
  const top = y + (ROW_HEIGHT - height) / 2;
  const from = Math.max(x, -4);
  const shown = Math.min(x + width, view.width + 4) - from;
  context.fillStyle = colour;
  context.strokeStyle = colour;
  if (status === 3 || (row.type === "wait" && status !== 2)) {
    // Outlines: what waits, and what was cancelled, with dashes.
    context.globalAlpha = 0.22;
    context.fillRect(from, top, shown, height);
    context.globalAlpha = 1;
    context.setLineDash(status === 3 ? [4, 3] : []);
    context.strokeRect(from + 0.5, top + 0.5, Math.max(shown - 1, 0.5), height - 1);
    context.setLineDash([]);
  } else {
    context.globalAlpha = isLeaf || status === 2 ? 1 : 0.55;
    context.fillRect(from, top, shown, height);
    context.globalAlpha = 1;
  }
  const time = run.behaviors.end[index]! - run.behaviors.start[index]!;
  const label = `${GLYPHS[status]} ${duration(time)}`;
  const right = x + width + 4;
  if (isLeaf && shown > 74) {
    context.fillStyle = status === 3 || row.type === "wait" ? colours.text : colours.surface;
    if (status === 2) context.fillStyle = colours.surface;
    context.fillText(label, Math.max(from, 0) + 5, y + ROW_HEIGHT / 2);
  } else if ((status === 2 || row.runs.length === 1) && right < view.width - 50) {
    context.fillStyle = status === 2 ? colour : colours.muted;
    context.fillText(label, Math.max(right, 2), y + ROW_HEIGHT / 2);
  }
}
