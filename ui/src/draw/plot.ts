// A number over time, as a line with axes.
import type { Series } from "../data/model";
import { after } from "../data/unpack";
import { digits } from "../text";
import { niceStep, prepare, type Theme } from "./theme";

const LEFT = 52; // [px] for the numbers of the vertical axis
const RIGHT = 8;
const TOP = 6;
const BOTTOM = 20;
const FEW = 60; // samples that are drawn as points, too

/** Part of the canvas inside the axes, and what it shows. */
export interface Frame {
  width: number;
  height: number;
  /** Latest time [s]; the first one is 0. */
  end: number;
  least: number;
  most: number;
}

/** Frame of a series, with some room above and below. */
export function frameOf(series: Series, end: number, width: number, height: number): Frame {
  let [least, most] = [Infinity, -Infinity];
  for (const value of series.values) {
    if (value < least) least = value;
    if (value > most) most = value;
  }
  if (least > most) [least, most] = [0, 1];
  const room = most > least ? 0.06 * (most - least) : Math.max(Math.abs(most) * 0.1, 0.5);
  return { width: Math.max(width, LEFT + RIGHT + 10), height, end: end || 1, least: least - room, most: most + room };
}

export function plotX(frame: Frame, time: number): number {
  return LEFT + (time / frame.end) * (frame.width - LEFT - RIGHT);
}

export function plotTime(frame: Frame, x: number): number {
  return Math.max(0, Math.min(1, (x - LEFT) / (frame.width - LEFT - RIGHT))) * frame.end;
}

function plotY(frame: Frame, value: number): number {
  return TOP + ((frame.most - value) / (frame.most - frame.least)) * (frame.height - TOP - BOTTOM);
}

/** Draw axes and line; the line of a variable has steps. */
export function drawPlot(canvas: HTMLCanvasElement, series: Series, frame: Frame, colours: Theme): void {
  const context = prepare(canvas, frame.width, frame.height);
  context.font = colours.font;
  drawAxes(context, frame, colours);
  context.save();
  context.beginPath();
  context.rect(LEFT, 0, frame.width - LEFT, frame.height);
  context.clip();
  context.strokeStyle = context.fillStyle = colours.strong;
  context.lineWidth = 1.5;
  context.lineJoin = "round";
  context.beginPath();
  trace(context, series, frame);
  context.stroke();
  if (series.times.length < FEW) {
    series.times.forEach((time, index) => {
      context.beginPath();
      context.arc(plotX(frame, time), plotY(frame, series.values[index]!), 2.5, 0, 2 * Math.PI);
      context.fill();
    });
  }
  context.restore();
}

function drawAxes(context: CanvasRenderingContext2D, frame: Frame, colours: Theme): void {
  context.textBaseline = "top";
  const stepX = niceStep(frame.end, frame.width / 90);
  for (let count = 0; count * stepX <= frame.end; count++) {
    const x = plotX(frame, count * stepX);
    context.fillStyle = colours.line;
    context.fillRect(x, TOP, 1, frame.height - TOP - BOTTOM);
    context.fillStyle = colours.muted;
    const text = `${digits(count * stepX, 6)} s`;
    const width = context.measureText(text).width;
    context.fillText(text, Math.min(x - width / 2, frame.width - width), frame.height - BOTTOM + 4);
  }
  context.textBaseline = "middle";
  context.textAlign = "right";
  const stepY = niceStep(frame.most - frame.least, (frame.height - TOP - BOTTOM) / 28);
  for (let count = Math.ceil(frame.least / stepY); count * stepY <= frame.most; count++) {
    const y = plotY(frame, count * stepY);
    context.fillStyle = colours.line;
    context.fillRect(LEFT, y, frame.width - LEFT - RIGHT, 1);
    context.fillStyle = colours.muted;
    context.fillText(digits(count * stepY, 4), LEFT - 6, y);
  }
  context.textAlign = "left";
}

/** Line through the samples; of those in one pixel, the first, least, greatest and last. */
function trace(context: CanvasRenderingContext2D, { kind, times, values }: Series, frame: Frame): void {
  const pixel = frame.end / (frame.width - LEFT - RIGHT);
  let last = NaN;
  for (let index = 0; index < times.length; ) {
    const x = plotX(frame, times[index]!);
    const next = Math.max(index + 1, after(times, times[index]! + pixel / 2));
    if (kind === "variable" && index > 0) context.lineTo(x, plotY(frame, last));
    if (index === 0) context.moveTo(x, plotY(frame, values[0]!));
    let [least, most] = [Infinity, -Infinity];
    for (let at = index; at < next; at++) {
      least = Math.min(least, values[at]!);
      most = Math.max(most, values[at]!);
    }
    last = values[next - 1]!;
    for (const value of next - index > 1 ? [values[index]!, least, most, last] : [last]) context.lineTo(x, plotY(frame, value));
    index = next;
  }
  if (kind === "variable" && times.length > 0) context.lineTo(plotX(frame, frame.end), plotY(frame, last));
}
