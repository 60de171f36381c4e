// Where the data of a run comes from: frames of columns, and blocks of records.
import type { Meta } from "./types";
import { Columns, fromBase64, inflate } from "./unpack";

/** Everything of a run until now, or what is new since the frame before. */
export interface Frame {
  meta: Partial<Meta>;
  columns: Columns;
}

/** Source of the records of a run. */
export interface BlockSource {
  /** Lines of a block of records, as text. */
  block(number: number): Promise<string>;
}

/** Data in the page itself: that of a report. */
export const embedded: BlockSource = {
  block: async (number) => new TextDecoder().decode(await read(`seoro-block-${number}`)),
};

/** Read the only frame of a report. */
export async function embeddedFrame(): Promise<Frame> {
  const [meta, columns] = await Promise.all([read("seoro-meta"), read("seoro-columns")]);
  const found = JSON.parse(new TextDecoder().decode(meta)) as Meta;
  return { meta: found, columns: new Columns(columns, found.layout) };
}

async function read(id: string): Promise<Uint8Array<ArrayBuffer>> {
  let element = document.getElementById(id);
  // While the page is loading, the last element may be incomplete.
  if (document.readyState === "loading" && !element?.nextSibling) {
    await new Promise((resolve) => document.addEventListener("DOMContentLoaded", resolve, { once: true }));
    element = document.getElementById(id);
  }
  if (element === null) throw new Error(`the report is incomplete: ${id} is missing`);
  return inflate(fromBase64(element.textContent ?? ""));
}

/** Frames of a server, which come in pieces: the first byte is 1 if more pieces of the same frame follow. */
export class FramePieces {
  private pieces: Uint8Array<ArrayBuffer>[] = [];

  /** Add a piece; returns the frame with its last one. */
  add(data: ArrayBuffer): Frame | null {
    this.pieces.push(new Uint8Array(data, 1));
    if (new Uint8Array(data)[0] === 1) return null;
    const found = joined(this.pieces);
    this.pieces = [];
    return decodeFrame(found);
  }

  /** Forget the pieces of a connection that was lost. */
  clear(): void {
    this.pieces = [];
  }
}

function joined(pieces: readonly Uint8Array<ArrayBuffer>[]): Uint8Array<ArrayBuffer> {
  const found = new Uint8Array(pieces.reduce((size, piece) => size + piece.length, 0));
  let offset = 0;
  for (const piece of pieces) {
    found.set(piece, offset);
    offset += piece.length;
  }
  return found;
}

/** Read a frame: columns, the JSON text, and its length. */
function decodeFrame(data: Uint8Array<ArrayBuffer>): Frame {
  const end = data.length - 4;
  const start = end - new DataView(data.buffer).getUint32(data.byteOffset + end, true);
  const meta = JSON.parse(new TextDecoder().decode(data.subarray(start, end))) as Partial<Meta>;
  return { meta, columns: new Columns(data.subarray(0, start), meta.layout ?? {}) };
}
