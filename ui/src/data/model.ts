// A run: what all views show. It may grow while it is shown.
import { Cell } from "../state";
import { Behaviors } from "./behaviors";
import { type BlockSource, embedded, embeddedFrame, type Frame } from "./frames";
import { Records } from "./records";
import { type Row, Rows } from "./rows";
import { Tracks } from "./tracks";
import type { Meta, SeriesData } from "./types";
import { type Columns, grown } from "./unpack";

export interface Series extends SeriesData {
  times: Float64Array<ArrayBuffer>;
  values: Float64Array<ArrayBuffer>;
}

const NOTHING: Meta = {
  ...{ start: null, end: null, scene: null, sources: [], tree: [], time: 0, count: 0, kinds: [], counts: {}, statuses: [] },
  ...{ step: 1, rows: [], strings: [], entities: [], beams: [], links: [], series: [], blocks: [], layout: {}, margins: [] },
  ...{ samples: [], notes: [], command: "", measurements: {}, coverage: {} },
};

export class RunModel {
  readonly meta: Meta = { ...NOTHING };
  readonly behaviors = new Behaviors();
  readonly rows = new Rows();
  readonly series: Series[] = [];
  readonly tracks = new Tracks();
  readonly records: Records;
  /** Number of frames so far: views that follow it see new data. */
  readonly revision = new Cell(0);
  eventTimes = new Float64Array(0);
  eventNames = new Int32Array(0);
  eventSeqs = new Int32Array(0);

  /**
   * @param frame The first frame.
   * @param source Source of the records.
   * @param isLive Whether the run may grow.
   */
  constructor(
    frame: Frame,
    source: BlockSource,
    readonly isLive = false,
  ) {
    this.records = new Records(source);
    this.append(frame);
  }

  /** Time of the last record [s]. */
  get end(): number {
    return Math.max(this.meta.time, 0);
  }

  /** Whether the run may go on. */
  get isActive(): boolean {
    return this.isLive && this.meta.end === null && this.meta.status !== "killed";
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

  /** Let the time of an active run on the real clock pass, also without new records. */
  advance(time: number): void {
    if (!this.isActive || time <= this.meta.time) return;
    this.meta.time = time;
    this.behaviors.extend(time);
    this.revision.value++;
  }

  /** Take what is new. */
  append({ meta, columns }: Frame): void {
    this.mergeMeta(meta);
    const first = this.behaviors.count;
    if ((meta.rows ?? []).length > 0 || meta.tree) this.rows.append(meta.rows ?? [], this.meta.tree);
    this.behaviors.append(columns, this.end, (index, status) => {
      if (index < first) this.rows.end(this.behaviors.row[index]!, status);
    });
    this.rows.count(this.behaviors, first);
    this.appendSeries(meta.series ?? [], columns);
    this.tracks.append(this.meta, meta, columns);
    this.records.append(meta.blocks ?? [], columns.bytes("records.kind"));
    this.eventTimes = grown(this.eventTimes, columns.reals("events.t"));
    this.eventNames = grown(this.eventNames, columns.integers("events.name"));
    this.eventSeqs = grown(this.eventSeqs, columns.integers("events.seq"));
    this.revision.value++;
  }

  private mergeMeta(more: Partial<Meta>): void {
    const { rows: _rows, blocks: _blocks, layout: _layout, strings, entities, margins, samples, ...whole } = more;
    const time = more.end || !more.time ? more.time : Math.max(more.time, this.meta.time);
    Object.assign(this.meta, whole, time === undefined ? {} : { time });
    if (strings?.length) this.meta.strings = [...this.meta.strings, ...strings];
    if (entities?.length) this.meta.entities = [...this.meta.entities, ...entities];
    if (margins?.length) this.meta.margins = [...this.meta.margins, ...margins];
    if (samples?.length) this.meta.samples = [...this.meta.samples, ...samples];
  }

  private appendSeries(more: SeriesData[], columns: Columns): void {
    for (const series of more) this.series.push({ ...series, times: new Float64Array(0), values: new Float64Array(0) });
    this.series.forEach((series, index) => {
      series.times = grown(series.times, columns.reals(`series.${index}.t`));
      series.values = grown(series.values, columns.reals(`series.${index}.v`));
    });
  }

  /** Read the run of a report. */
  static async embedded(): Promise<RunModel> {
    return new RunModel(await embeddedFrame(), embedded);
  }
}
