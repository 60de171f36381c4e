// Texts for people: times, numbers with units, and texts of others made safe to read.

const BIDI = /[\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069]/g;
const CONTROLS = /[\u0000-\u0008\u000b-\u001f\u007f-\u009f]/g;

/** Show controls, also those of the direction of text, which could make a text look like another one. */
export function plain(text: string): string {
  return text.replace(BIDI, (found) => `⟨U+${found.charCodeAt(0).toString(16).toUpperCase().padStart(4, "0")}⟩`).replace(
    CONTROLS,
    "\ufffd",
  );
}

/** Shorten a text, for labels. */
export function clip(text: string, most: number): string {
  return text.length <= most ? text : `${text.slice(0, most - 1)}…`;
}

/** Format a number with digits after the point; zero has no sign. */
export function fixed(value: number, places: number): string {
  return value.toFixed(places).replace(/^-(?=[0.]*$)/, "");
}

/** Format a time of the run with milliseconds. */
export function seconds(time: number): string {
  return `${time.toFixed(3)} s`;
}

/** Format a duration with three digits. */
export function duration(time: number): string {
  if (time === 0) return "0 s";
  if (time < 0.001) return `${digits(time * 1e6)} µs`;
  if (time < 1) return `${digits(time * 1000)} ms`;
  if (time < 120) return `${digits(time)} s`;
  const minutes = Math.floor(time / 60);
  if (minutes < 120) return `${minutes} min ${Math.round(time - 60 * minutes)} s`;
  return `${Math.floor(minutes / 60)} h ${minutes % 60} min`;
}

/** Format a number with at most `count` significant digits. */
export function digits(value: number, count = 3): string {
  if (!Number.isFinite(value)) return String(value);
  if (value !== 0 && (Math.abs(value) >= 1e6 || Math.abs(value) < 1e-4)) return value.toExponential(count - 1);
  return String(Number(value.toPrecision(count)));
}

/** Format a whole number with separators. */
export function whole(value: number): string {
  return value.toLocaleString("en");
}

export function plural(count: number, what: string, more = `${what}s`): string {
  return `${whole(count)} ${count === 1 ? what : more}`;
}

/** Place without folders, `file:line`. */
export function shortPlace(source: string): string {
  const found = /([^/\\]*):(\d+):\d+$/.exec(source);
  return found === null ? clip(source, 60) : `${clip(found[1]!, 60)}:${found[2]}`;
}

/** Show any value in one line. */
export function shown(value: unknown): string {
  return typeof value === "string" ? value : (JSON.stringify(value) ?? "");
}
