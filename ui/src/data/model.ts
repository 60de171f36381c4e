// A run: what all views show.
import { Records } from "./records";
import { Tracks } from "./tracks";
import type { Meta, SeriesData, StaticBehavior } from "./types";
import { Columns, embedded } from "./unpack";

/** Row of the timeline: a behavior of the scenario, with all its executions. */
export interface Row {
  index: number;
  parent: Row | null;
  depth: number;
  type: string;
  name: string;
  path: string;
  source: string;
  sourceEnd: string;
  children: Row[];
  /** Indices of behaviors, in the order of their starts. */
  runs: Int32Array;
  counts: [running: number, succeeded: number, failed: number, cancelled: number];
}

/** All behaviors, as columns. */
export interface Behaviors {
  count: number;
  row: Int32Array;
  parent: Int32Array;
  start: Float64Array;
  end: Float64Array;
  status: Uint8Array;
  reason: Int32Array;
  startSeq: Int32Array;
  endSeq: Int32Array;
}

export interface Series extends SeriesData {
  times: Float64Array;
  values: Float64Array;
}

export class RunModel {
  readonly behaviors: Behaviors;
  readonly rows: Row[];
  readonly roots: Row[];
  readonly series: Series[];
  readonly tracks: Tracks;
  readonly records: Records;
  readonly eventTimes: Float64Array;
  readonly eventNames: Int32Array;
  readonly eventSeqs: Int32Array;
  /** Time of the last record [s]. */
  readonly end: number;

  constructor(
    readonly meta: Meta,
    columns: Columns,
  ) {
    this.behaviors = {
      row: columns.integers("behaviors.row"),
      count: columns.integers("behaviors.row").length,
      parent: columns.integers("behaviors.parent"),
      start: columns.reals("behaviors.start"),
      end: columns.reals("behaviors.end"),
      status: columns.bytes("behaviors.status"),
      reason: columns.integers("behaviors.reason"),
      startSeq: columns.integers("behaviors.startSeq"),
      endSeq: columns.integers("behaviors.endSeq"),
    };
    this.rows = makeRows(meta, this.behaviors);
    this.roots = this.rows.filter((row) => row.parent === null);
    addMissing(meta, this.rows);
    this.series = meta.series.map((series, index) => ({
      ...series,
      times: columns.reals(`series.${index}.t`),
      values: columns.reals(`series.${index}.v`),
    }));
    this.tracks = new Tracks(meta, columns);
    this.records = new Records(meta, columns.bytes("records.kind"));
    this.eventTimes = columns.reals("events.t");
    this.eventNames = columns.integers("events.name");
    this.eventSeqs = columns.integers("events.seq");
    this.end = Math.max(meta.time, 0);
  }

  /** Text with a number; empty for -1. */
  text(number: number): string {
    return this.meta.strings[number] ?? "";
  }

  /** Behavior of a row that runs at a time, or the last one before; -1 for none. */
  runAt(row: Row, time: number): number {
    const { start } = this.behaviors;
    let low = 0;
    let high = row.runs.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (start[row.runs[middle]!]! > time) high = middle;
      else low = middle + 1;
    }
    return low > 0 ? row.runs[low - 1]! : -1;
  }

  static async embedded(): Promise<RunModel> {
    const [meta, columns] = await Promise.all([embedded("seoro-meta"), embedded("seoro-columns")]);
    const found = JSON.parse(new TextDecoder().decode(meta)) as Meta;
    return new RunModel(found, new Columns(columns, found.layout));
  }
}

function makeRows(meta: Meta, behaviors: Behaviors): Row[] {
  const rows: Row[] = [];
  const sizes = new Int32Array(meta.rows.length);
  for (const row of behaviors.row) sizes[row]!++;
  for (const [parent, type, name, path, source, sourceEnd] of meta.rows) {
    const around = rows[parent] ?? null;
    const index = rows.length;
    const row: Row = {
      ...{ index, parent: around, depth: around === null ? 0 : around.depth + 1, type, name, path, source, sourceEnd },
      ...{ children: [], runs: new Int32Array(sizes[index]!), counts: [0, 0, 0, 0] },
    };
    rows.push(row);
    around?.children.push(row);
  }
  const filled = new Int32Array(rows.length);
  for (let index = 0; index < behaviors.count; index++) {
    const row = rows[behaviors.row[index]!]!;
    row.runs[filled[row.index]!++] = index;
    row.counts[behaviors.status[index] as 0 | 1 | 2 | 3]++;
  }
  return rows;
}

/** Add rows for behaviors of the static tree that never started. */
function addMissing(meta: Meta, rows: Row[]): void {
  const ofNode = new Map<number, Row>();
  meta.rows.forEach((row, index) => {
    if (row[6] >= 0 && !ofNode.has(row[6])) ofNode.set(row[6], rows[index]!);
  });
  if (ofNode.size === 0) return;
  const nodes: StaticBehavior[] = meta.tree.filter((node) => typeof node.id === "number");
  for (const node of nodes) {
    const around = node.parent === null ? undefined : ofNode.get(node.parent);
    if (ofNode.has(node.id)) continue;
    const parent = around === undefined ? null : innermost(around);
    const row: Row = {
      ...{ index: rows.length, parent, depth: (parent?.depth ?? -1) + 1, type: node.type, name: node.name, path: "" },
      ...{ source: node.source, sourceEnd: node.source_end ?? "", children: [], runs: new Int32Array(0) },
      counts: [0, 0, 0, 0],
    };
    rows.push(row);
    parent?.children.push(row); // one without is shown in the source only
    ofNode.set(node.id, row);
  }
  for (const row of rows) row.children.sort((a, b) => comparePlaces(a.source, b.source) || a.index - b.index);
}

/** The last of the modifiers around the members of a behavior. */
function innermost(row: Row): Row {
  const only = row.children.length === 1 ? row.children[0]! : null;
  return only?.type === "modifier" ? innermost(only) : row;
}

/** Line and column of a place `file:line:column`. */
export function lineOf(source: string): [file: string, line: number, column: number] {
  const found = /^(.*):(\d+):(\d+)$/s.exec(source);
  return found === null ? [source, 0, 0] : [found[1]!, Number(found[2]), Number(found[3])];
}

function comparePlaces(a: string, b: string): number {
  const [fileA, lineA, columnA] = lineOf(a);
  const [fileB, lineB, columnB] = lineOf(b);
  return fileA === fileB ? lineA - lineB || columnA - columnB : 0;
}
