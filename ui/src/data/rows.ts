// Rows of the timeline: a behavior of the scenario, with all its executions.
import type { Behaviors } from "./behaviors";
import type { RowData, StaticBehavior } from "./types";
import { grown } from "./unpack";

export interface Row {
  /** Number; negative for behaviors that never started. */
  index: number;
  parent: Row | null;
  depth: number;
  type: string;
  name: string;
  path: string;
  source: string;
  sourceEnd: string;
  /** Number in the static tree; -1 if unknown. */
  node: number;
  children: Row[];
  /** Indices of behaviors, in the order of their starts. */
  runs: Int32Array<ArrayBuffer>;
  counts: [running: number, succeeded: number, failed: number, cancelled: number];
}

export class Rows {
  /** Rows of behaviors that started, by their numbers. */
  readonly started: Row[] = [];
  /** Rows of behaviors of the static tree that never started. */
  missing: Row[] = [];

  get all(): Row[] {
    return [...this.started, ...this.missing];
  }

  get roots(): Row[] {
    return this.started.filter((row) => row.parent === null);
  }

  /** Append new rows, and complete the tree with behaviors that never started. */
  append(more: RowData[], tree: StaticBehavior[]): void {
    for (const row of this.missing) if (row.parent !== null) row.parent.children = row.parent.children.filter((child) => child !== row);
    for (const [parent, type, name, path, source, sourceEnd, node] of more) {
      const around = this.started[parent] ?? null;
      const row: Row = {
        ...{ index: this.started.length, parent: around, depth: around === null ? 0 : around.depth + 1 },
        ...{ type, name, path, source, sourceEnd, node, children: [], runs: new Int32Array(0), counts: [0, 0, 0, 0] },
      };
      this.started.push(row);
      around?.children.push(row);
    }
    this.missing = missingRows(this.started, tree);
    if (tree.length > 0) for (const row of this.all) row.children.sort(byPlace);
  }

  /** Add executions: the behaviors from `first` on. */
  count(behaviors: Behaviors, first: number): void {
    const sizes = new Int32Array(this.started.length);
    for (let index = first; index < behaviors.count; index++) sizes[behaviors.row[index]!]!++;
    const filled = new Int32Array(this.started.length);
    sizes.forEach((size, number) => {
      const row = this.started[number]!;
      filled[number] = row.runs.length;
      if (size > 0) row.runs = grown(row.runs, new Int32Array(size));
    });
    for (let index = first; index < behaviors.count; index++) {
      const row = this.started[behaviors.row[index]!]!;
      row.runs[filled[row.index]!++] = index;
      row.counts[behaviors.status[index] as 0 | 1 | 2 | 3]++;
    }
  }

  /** Count the end of a behavior. */
  end(row: number, status: number): void {
    const { counts } = this.started[row]!;
    counts[0]--;
    counts[status as 0 | 1 | 2 | 3]++;
  }
}

function missingRows(started: Row[], tree: StaticBehavior[]): Row[] {
  const ofNode = new Map<number, Row>();
  for (const row of started) if (row.node >= 0 && !ofNode.has(row.node)) ofNode.set(row.node, row);
  if (ofNode.size === 0) return [];
  const found: Row[] = [];
  for (const node of tree) {
    if (typeof node.id !== "number" || ofNode.has(node.id)) continue;
    const around = node.parent === null ? undefined : ofNode.get(node.parent);
    const parent = around === undefined ? null : innermost(around);
    const row: Row = {
      ...{ index: -1 - found.length, parent, depth: (parent?.depth ?? -1) + 1, type: node.type, name: node.name, path: "" },
      ...{ source: node.source, sourceEnd: node.source_end ?? "", node: node.id, children: [], runs: new Int32Array(0) },
      counts: [0, 0, 0, 0],
    };
    found.push(row);
    parent?.children.push(row); // one without is shown in the source only
    ofNode.set(node.id, row);
  }
  return found;
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

function byPlace(a: Row, b: Row): number {
  const [fileA, lineA, columnA] = lineOf(a.source);
  const [fileB, lineB, columnB] = lineOf(b.source);
  return (fileA === fileB ? lineA - lineB || columnA - columnB : 0) || order(a) - order(b);
}

/** Rows that never started come behind the others of their place. */
function order(row: Row): number {
  return row.index >= 0 ? row.index : 1e9 - row.index;
}
