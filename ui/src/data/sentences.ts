// Records as sentences, and the chain of their causes.
import { clip, duration, plain, seconds, shown } from "../text";
import type { RunModel } from "./model";
import { lineOf } from "./rows";
import type { Json, TraceRecord } from "./types";
import { after } from "./unpack";

const LONGEST = 400; // characters of a value
const MOST_CAUSES = 200;

const ENDS: Record<string, string> = { succeeded: "succeeded", failed: "failed", cancelled: "was cancelled" };

/** Describe a record in one sentence, without its time. */
export function sentence(run: RunModel, record: TraceRecord): string {
  return clip(plain(describe(run, record)), 3 * LONGEST);
}

function describe(run: RunModel, record: TraceRecord): string {
  const text = (name: string) => clip(shown(record[name] ?? ""), LONGEST);
  switch (record.kind) {
    case "run.start":
      return `The run of ${text("scenario")} started`;
    case "run.end":
      return `The run ${record["status"] === "error" ? "ended with an error" : text("status")}${because(record)}`;
    case "behavior.start":
      return `${title(text("type"), text("name"))} started`;
    case "behavior.end": {
      const [name, time] = nameAndTime(run, record);
      const took = time > 0 ? ` after ${duration(time)}` : "";
      return `${name} ${ENDS[text("status")] ?? text("status")}${took}${because(record)}`;
    }
    case "behavior.cancel":
      return `${nameOf(run, record["id"], record.seq)} is being cancelled and cleans up`;
    case "attempt.start":
      return `${nameOf(run, record["modifier"], record.seq)} ran ${text("path")}`;
    case "attempt.end":
      return `An attempt of ${nameOf(run, record["modifier"], record.seq)} ${ENDS[text("status")] ?? text("status")}${because(record)}`;
    case "instance":
      return `${text("of")} got its values${values(record["values"])}`;
    case "event":
      return `Event ${text("name")}${values(record["arguments"])}`;
    case "variable":
      return `${text("path")} = ${text("value")}`;
    case "log":
      return text("message");
    case "cover":
    case "record":
      return `${text("item")} = ${text("value")}${record["unit"] ? ` ${text("unit")}` : ""}`;
    case "margin":
      return `${text("check")} had a margin of ${text("value")} (${text("distance")} to its limit ${text("limit")})`;
    default:
      return clip(JSON.stringify(record), LONGEST);
  }
}

function because(record: TraceRecord): string {
  return record["reason"] ? `: ${clip(shown(record["reason"]), LONGEST)}` : "";
}

function title(type: string, name: string): string {
  return type === name || type === "action" || type === "scenario" ? name : `${type} ${name}`;
}

function values(found: Json | undefined): string {
  if (found === null || typeof found !== "object" || Array.isArray(found) || Object.keys(found).length === 0) return "";
  const parts = Object.entries(found).map(([name, value]) => `${name}: ${briefly(value)}`);
  return ` (${clip(parts.join(", "), LONGEST)})`;
}

/** Values of structs and actors without their encoding in the trace. */
function briefly(value: Json | undefined): string {
  if (value === null || typeof value !== "object" || Array.isArray(value)) return shown(value);
  if ("fields" in value && value["fields"] !== null && typeof value["fields"] === "object") {
    if (typeof value["actor"] === "string") return value["actor"];
    return `{${Object.entries(value["fields"]).map(([name, part]) => `${name}: ${briefly(part)}`).join(", ")}}`;
  }
  if (typeof value["member"] === "string") return value["member"];
  if (typeof value["variable"] === "string") return value["variable"];
  return shown(value);
}

function nameAndTime(run: RunModel, record: TraceRecord): [string, number] {
  const { behaviors } = run;
  const index = indexOf(run, record["id"], record.seq);
  if (index < 0) return [`behavior ${shown(record["id"])}`, 0];
  const row = run.rows.started[behaviors.row[index]!]!;
  return [title(row.type, row.name), record.t - behaviors.start[index]!];
}

function nameOf(run: RunModel, id: Json | undefined, seq: number): string {
  const index = indexOf(run, id, seq);
  if (index < 0) return `behavior ${shown(id)}`;
  const row = run.rows.started[run.behaviors.row[index]!]!;
  return title(row.type, row.name);
}

/** Index of a behavior by its `id`, which counts starts in traces of seoro. */
function indexOf(run: RunModel, id: Json | undefined, seq: number): number {
  if (typeof id !== "number") return -1;
  const { startSeq, count } = run.behaviors;
  const started = after(startSeq, seq);
  return id >= 0 && id < Math.min(count, started) ? id : -1;
}

/** Place in the scenario that a record is about; empty for none. */
export function placeOf(run: RunModel, record: TraceRecord): string {
  if (typeof record["source"] === "string" && record["source"] !== "") return record["source"];
  const index = indexOf(run, record["id"] ?? record["behavior"] ?? record["modifier"], record.seq);
  return index < 0 ? "" : run.rows.started[run.behaviors.row[index]!]!.source;
}

/** A record, and why it happened. */
export interface Cause {
  record: TraceRecord;
  text: string;
}

/** Follow causes back to the beginning: the record itself first. */
export async function causes(run: RunModel, record: TraceRecord): Promise<Cause[]> {
  const found: Cause[] = [];
  let current: TraceRecord | null = record;
  while (current !== null && found.length < MOST_CAUSES) {
    found.push({ record: current, text: sentence(run, current) });
    const cause: Json | undefined = current["cause"];
    current = typeof cause === "number" && cause < current.seq ? await run.records.find(cause) : null;
  }
  return found;
}

/** Text of a source line; empty if the report has no source. */
export function sourceLine(run: RunModel, source: string): string {
  const [file, line] = lineOf(source);
  const text = run.meta.sources.find((found) => found.name === file)?.text;
  return text?.split("\n")[line - 1]?.trim() ?? "";
}

/** Text between two places of a line, or from a place to the end of its line; empty without a source. */
export function sourceText(run: RunModel, source: string, end: string): string {
  const [file, line, column] = lineOf(source);
  const text = run.meta.sources.find((found) => found.name === file)?.text?.split("\n")[line - 1];
  const [, endLine, endColumn] = /^(\d+):(\d+)$/.exec(end) ?? [];
  const isOneLine = Number(endLine) === line;
  return text?.slice(column - 1, isOneLine ? Number(endColumn) - 1 : undefined).trim() ?? "";
}

/** Time of a record, for people. */
export function when(record: TraceRecord): string {
  return seconds(record.t);
}
