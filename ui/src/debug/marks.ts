// Marks of the debugger in the source.
import { Cell, type LineMarks } from "../state";
import { debugSession } from "./session";

const marks = new Cell<ReadonlyMap<string, string>>(new Map());
const paused = new Cell("");

debugSession.breakpoints.subscribe((found) => {
  marks.value = new Map(found.map((each) => [`${each.file}:${each.line}`, each.isVerified ? "●" : "○"]));
});
debugSession.status.subscribe((status) => {
  if (status !== "paused") paused.value = "";
});

/** Breakpoints, and the line at which the run is paused. */
export const lineMarks: LineMarks = {
  marks,
  paused,
  toggle: (file, line) => void debugSession.toggle(file, line).catch(() => undefined), // the panel shows breakpoints
};
