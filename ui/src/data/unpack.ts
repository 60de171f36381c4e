// Bytes and columns of a report.

/** Decompress zlib data. */
export async function inflate(data: Uint8Array<ArrayBuffer>): Promise<Uint8Array<ArrayBuffer>> {
  const stream = new Blob([data]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Decode base64. */
export function fromBase64(text: string): Uint8Array<ArrayBuffer> {
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let index = 0; index < binary.length; index++) bytes[index] = binary.charCodeAt(index);
  return bytes;
}

/** Read the data of an element of the page. */
export async function embedded(id: string): Promise<Uint8Array<ArrayBuffer>> {
  const element = document.getElementById(id);
  if (element === null) throw new Error(`the report is incomplete: ${id} is missing`);
  return inflate(fromBase64(element.textContent ?? ""));
}

export type Column = Int32Array | Float64Array | Uint8Array;
const WIDTHS: Record<string, number> = { i4: 4, f8: 8, u1: 1 };

/** Columns by name; see `seoro/report/columns.py`. */
export class Columns {
  private readonly columns = new Map<string, Column>();

  constructor(data: Uint8Array<ArrayBuffer>, layout: { [name: string]: [string, number] }) {
    let offset = 0;
    for (const [name, [type, length]] of Object.entries(layout)) {
      const width = WIDTHS[type] ?? 1;
      this.columns.set(name, decode(data.subarray(offset, offset + width * length), type, length));
      offset += width * length;
    }
  }

  integers(name: string): Int32Array {
    return (this.columns.get(name) as Int32Array | undefined) ?? new Int32Array(0);
  }

  reals(name: string): Float64Array {
    return (this.columns.get(name) as Float64Array | undefined) ?? new Float64Array(0);
  }

  bytes(name: string): Uint8Array {
    return (this.columns.get(name) as Uint8Array | undefined) ?? new Uint8Array(0);
  }

  has(name: string): boolean {
    return this.columns.has(name);
  }
}

function decode(raw: Uint8Array, type: string, length: number): Column {
  if (type === "u1") return raw.slice();
  const width = WIDTHS[type] ?? 1;
  const bytes = new Uint8Array(raw.length);
  for (let part = 0; part < width; part++) {
    const from = part * length;
    for (let index = 0; index < length; index++) bytes[index * width + part] = raw[from + index]!;
  }
  if (type === "f8") return new Float64Array(bytes.buffer);
  const found = new Int32Array(bytes.buffer);
  for (let index = 1; index < length; index++) found[index] = found[index]! + found[index - 1]!;
  return found;
}

/** Index of the first value that is greater than `limit`, in a sorted column. */
export function after(column: ArrayLike<number>, limit: number): number {
  let low = 0;
  let high = column.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (column[middle]! > limit) high = middle;
    else low = middle + 1;
  }
  return low;
}
