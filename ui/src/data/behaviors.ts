// All behaviors, as columns.
import { type Columns, grown } from "./unpack";

export class Behaviors {
  row = new Int32Array(0);
  parent = new Int32Array(0);
  start = new Float64Array(0);
  end = new Float64Array(0);
  status = new Uint8Array(0);
  reason = new Int32Array(0);
  startSeq = new Int32Array(0);
  endSeq = new Int32Array(0);
  private readonly running = new Set<number>();

  get count(): number {
    return this.row.length;
  }

  /**
   * Append new behaviors, and end those that ended meanwhile.
   *
   * @param time Time until which bars of running behaviors reach [s].
   * @param onEnd Called for each earlier behavior that ended.
   */
  append(columns: Columns, time: number, onEnd: (index: number, status: number) => void): void {
    const first = this.count;
    this.row = grown(this.row, columns.integers("behaviors.row"));
    this.parent = grown(this.parent, columns.integers("behaviors.parent"));
    this.start = grown(this.start, columns.reals("behaviors.start"));
    this.end = grown(this.end, columns.reals("behaviors.end"));
    this.status = grown(this.status, columns.bytes("behaviors.status"));
    this.reason = grown(this.reason, columns.integers("behaviors.reason"));
    this.startSeq = grown(this.startSeq, columns.integers("behaviors.startSeq"));
    this.endSeq = grown(this.endSeq, columns.integers("behaviors.endSeq"));
    this.close(columns, onEnd);
    for (let index = first; index < this.count; index++) if (this.endSeq[index]! < 0) this.running.add(index);
    this.extend(time);
  }

  /** Let bars of running behaviors reach until a time [s]. */
  extend(time: number): void {
    for (const index of this.running) this.end[index] = Math.max(time, this.start[index]!);
  }

  private close(columns: Columns, onEnd: (index: number, status: number) => void): void {
    const [ends, statuses] = [columns.reals("ended.end"), columns.bytes("ended.status")];
    const [reasons, seqs] = [columns.integers("ended.reason"), columns.integers("ended.endSeq")];
    columns.integers("ended.index").forEach((index, at) => {
      this.end[index] = ends[at]!;
      this.status[index] = statuses[at]!;
      this.reason[index] = reasons[at]!;
      this.endSeq[index] = seqs[at]!;
      if (this.running.delete(index)) onEnd(index, statuses[at]!);
    });
  }
}
