// Visible part of the time.
import type { RunModel } from "../data/model";

/** Start and end [s]. */
export type Span = [start: number, end: number];

export function wholeSpan(run: RunModel): Span {
  const end = run.end > 0 ? run.end : 1;
  return [-0.01 * end, 1.02 * end];
}

export function zoomed(run: RunModel, [start, end]: Span, factor: number, around: number): Span {
  const [least, most] = wholeSpan(run);
  const centre = around >= start && around <= end ? around : (start + end) / 2;
  const size = Math.max((end - start) * factor, (most - least) * 1e-9, 1e-7);
  const from = centre - ((centre - start) / (end - start)) * size;
  return size >= most - least ? [least, most] : within(run, [from, from + size]);
}

export function panned(run: RunModel, [start, end]: Span, share: number): Span {
  const shift = share * (end - start);
  return within(run, [start + shift, end + shift]);
}

function within(run: RunModel, [start, end]: Span): Span {
  const [least, most] = wholeSpan(run);
  const shift = Math.max(least - start, 0) + Math.min(most - end, 0);
  return [start + shift, end + shift];
}
