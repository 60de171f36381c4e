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

/** Read a frame of a server: length of the JSON text, the text, columns. */
export function decodeFrame(data: ArrayBuffer): Frame {
  const length = new DataView(data).getUint32(0, true);
  const meta = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, length))) as Partial<Meta>;
  return { meta, columns: new Columns(new Uint8Array(data, 4 + length), meta.layout ?? {}) };
}
