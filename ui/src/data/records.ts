// Records of the trace, decompressed in blocks when they are shown.
import type { BlockSource } from "./frames";
import type { BlockData, TraceRecord } from "./types";
import { after, grown } from "./unpack";

const KEPT = 12; // blocks
const PAUSE = 400; // [ms] between two requests for a block that grows

export class Records {
  /** Number of the kind of each record. */
  kinds = new Uint8Array(0);
  private readonly firstSeq: number[] = [];
  private readonly firstTime: number[] = [];
  private readonly firstPosition: number[] = [];
  private readonly lines: number[] = [];
  private readonly cache = new Map<number, Promise<TraceRecord[]>>();
  private readonly loaded = new Map<number, TraceRecord[]>();
  private readonly loadedAt = new Map<number, number>(); // [ms]
  private readonly stale = new Set<number>();
  private readonly waiting = new Set<number>(); // blocks that will be requested after a pause

  constructor(private readonly source: BlockSource) {}

  get count(): number {
    return this.kinds.length;
  }

  /** Add blocks, and replace those that grew. */
  append(blocks: BlockData[], kinds: Uint8Array<ArrayBuffer>): void {
    this.kinds = grown(this.kinds, kinds);
    for (const [seq, time, lines, number] of blocks) {
      const before = number > 0 ? this.firstPosition[number - 1]! + this.lines[number - 1]! : 0;
      [this.firstSeq[number], this.firstTime[number], this.firstPosition[number], this.lines[number]] = [seq, time, before, lines];
      this.stale.add(number); // what is loaded stays visible until the longer block is here
    }
  }

  /** Record at a position, counted from 0. */
  async at(position: number): Promise<TraceRecord | null> {
    const number = after(this.firstPosition, position) - 1;
    const block = await this.block(number);
    return block[position - (this.firstPosition[number] ?? 0)] ?? null;
  }

  /** Record at a position if its block is there; otherwise null, and a call when it is. */
  ready(position: number, onReady: () => void): TraceRecord | null {
    const number = after(this.firstPosition, position) - 1;
    const block = this.loaded.get(number);
    const record = block?.[position - (this.firstPosition[number] ?? 0)];
    if (record !== undefined) return record;
    const isComplete = block !== undefined && !this.stale.has(number) && block.length >= (this.lines[number] ?? 0);
    if (!isComplete) void this.block(number).then(onReady);
    return null;
  }

  /** Record with a number. */
  async find(seq: number): Promise<TraceRecord | null> {
    const block = await this.block(after(this.firstSeq, seq) - 1);
    return block.find((record) => record.seq === seq) ?? null;
  }

  /** Position of the last record until a time. */
  async until(time: number): Promise<number> {
    const number = after(this.firstTime, time) - 1;
    if (number < 0) return 0;
    const block = await this.block(number);
    const index = after(block.map((record) => record.t), time) - 1;
    return (this.firstPosition[number] ?? 0) + Math.max(index, 0);
  }

  /** Position of a record with a number. */
  async position(seq: number): Promise<number> {
    const number = after(this.firstSeq, seq) - 1;
    const index = (await this.block(number)).findIndex((record) => record.seq === seq);
    return (this.firstPosition[number] ?? 0) + Math.max(index, 0);
  }

  /** Number of blocks. */
  get blocks(): number {
    return this.firstSeq.length;
  }

  /** Records of a block, and the position of its first one. */
  async blockAt(number: number): Promise<[number, TraceRecord[]]> {
    return [this.firstPosition[number] ?? 0, await this.block(number)];
  }

  private block(number: number): Promise<TraceRecord[]> {
    if (number < 0 || number >= this.blocks) return Promise.resolve([]);
    let found = this.cache.get(number);
    const isOld = this.stale.has(number) && !this.waiting.has(number);
    if (found === undefined || isOld) found = this.load(number);
    else this.cache.delete(number); // it becomes the latest one
    this.cache.set(number, found);
    if (this.cache.size > KEPT) {
      const oldest = this.cache.keys().next().value!;
      this.cache.delete(oldest);
      this.loaded.delete(oldest);
    }
    return found;
  }

  private async load(number: number): Promise<TraceRecord[]> {
    const pause = PAUSE + (this.loadedAt.get(number) ?? -PAUSE) - performance.now();
    this.waiting.add(number);
    if (pause > 0) await new Promise((resume) => setTimeout(resume, pause));
    this.waiting.delete(number);
    this.stale.delete(number);
    this.loadedAt.set(number, performance.now());
    const text = await this.source.block(number);
    let seq = (this.firstSeq[number] ?? 0) - 1;
    const records = text.split("\n", this.lines[number]).map((line) => {
      const record = parse(line);
      seq = record.seq > seq ? record.seq : seq + 1;
      record.seq = seq;
      return record;
    });
    if (this.cache.has(number)) this.loaded.set(number, records);
    return records;
  }
}

function parse(line: string): TraceRecord {
  try {
    return JSON.parse(line) as TraceRecord;
  } catch {
    // NaN and infinity, which traces of other writers may have.
    return JSON.parse(line.replace(/(?<=[:[,]\s*)(NaN|-?Infinity)(?=\s*[,}\]])/g, '"$1"')) as TraceRecord;
  }
}
