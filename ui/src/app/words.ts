// Words and signs of states; a sign and a word go together, so that no state is shown by its colour alone.
import { duration } from "../text";
import type { Status } from "./types";

const STATUSES: Record<string, [sign: string, word: string]> = {
  waiting: ["◷", "Waiting"],
  running: ["▶", "Running"],
  passed: ["✓", "Passed"],
  failed: ["✗", "Failed"],
  error: ["!", "Error"],
  cancelled: ["–", "Cancelled"],
  killed: ["×", "Killed"],
  ended: ["✓", "Ended"],
  paused: ["❚❚", "Paused"],
  complete: ["✓", "Complete"],
  stopped: ["■", "Stopped"],
  unreadable: ["!", "Unreadable"],
};

export const RUN_STATUSES: readonly Status[] = ["waiting", "running", "passed", "failed", "error", "cancelled", "killed"];

export function signOf(status: string): string {
  return STATUSES[status]?.[0] ?? "?";
}

export function wordOf(status: string): string {
  return STATUSES[status]?.[1] ?? status;
}

/** Format a time since 1970 [s], or an ISO text, as time of the day, with the date of other days. */
export function clock(time: number | string | null): string {
  const date = new Date(typeof time === "number" ? time * 1000 : (time ?? NaN));
  if (Number.isNaN(date.getTime())) return "";
  const isToday = date.toDateString() === new Date().toDateString();
  const hours = date.toLocaleTimeString("en-GB");
  return isToday ? hours : `${date.toISOString().slice(0, 10)} ${hours.slice(0, 5)}`;
}

/** Format how long something took, or has taken until now. */
export function took(started: number | null, ended: number | null, now: number): string {
  if (started === null) return "";
  const time = Math.max((ended ?? now) - started, 0);
  return duration(ended === null || time >= 10 ? Math.round(time) : time);
}

/** Format a rest of time [s]. */
export function rest(time: number): string {
  if (time < 1) return "less than 1 s";
  return duration(Math.round(time));
}

/** Name of a campaign: its title, of which paths are shortened to the file. */
export function titleOf({ title }: { title: string }): string {
  return title.split("/").at(-1) || title;
}

/** Name of a run: that of its scenario, else of its file. */
export function nameOf({ scenario, file }: { scenario: string; file: string }): string {
  return scenario || file.split("/").at(-1) || "run";
}
