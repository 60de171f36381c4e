// Axis of the timeline: times, and marks of events.
import type { RunModel } from "../data/model";
import { after } from "../data/unpack";
import { toTime, toX, type Window } from "./bars";
import { niceStep, prepare, type Theme } from "./theme";

export function drawAxis(
  canvas: HTMLCanvasElement,
  run: RunModel,
  view: Window,
  height: number,
  colours: Theme,
): void {
  const context = prepare(canvas, view.width, height);
  context.font = colours.font;
  context.textBaseline = "top";
  const step = niceStep(view.end - view.start, view.width / 90);
  const places = Math.max(0, Math.min(9, -Math.floor(Math.log10(step) + 1e-9)));
  for (let mark = Math.ceil(view.start / step) * step; mark <= view.end; mark += step) {
    const x = toX(view, mark);
    context.fillStyle = colours.line;
    context.fillRect(x, 16, 1, height - 16);
    context.fillStyle = colours.muted;
    context.fillText(`${(Math.abs(mark) < step / 2 ? 0 : mark).toFixed(places)} s`, x + 3, 2);
  }
  drawEvents(context, run, view, height, colours);
}

/** One mark for the events of a pixel. */
function drawEvents(context: CanvasRenderingContext2D, run: RunModel, view: Window, height: number, colours: Theme): void {
  const times = run.eventTimes;
  context.fillStyle = colours.strong;
  let at = after(times, view.start);
  while (at < times.length && times[at]! <= view.end) {
    const x = Math.floor(toX(view, times[at]!));
    context.fillRect(x, height - 14, 2, 8);
    at = after(times, toTime(view, x + 3));
  }
}
