// Bytes and columns of a run.

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

export type Column = Int32Array<ArrayBuffer> | Float64Array<ArrayBuffer> | Uint8Array<ArrayBuffer>;
const WIDTHS: Record<string, number> = { i4: 4, f8: 8, u1: 1 };

/** Columns by name; see `seoro/report/columns.py`. */
export class Columns {
  private readonly columns = new Map<string, Column>();

  constructor(data: Uint8Array<ArrayBuffer>, layout: { [name: string]: [string, number] }) {
    let offset = 0;
    for (const [name, [code, length]] of Object.entries(layout)) {
      const isConstant = code.startsWith("="); // it has only one value
      const type = isConstant ? code.slice(1) : code;
      const count = isConstant ? 1 : length;
      const size = (WIDTHS[type] ?? 1) * count;
      const found = decode(data.subarray(offset, offset + size), type, count);
      this.columns.set(name, isConstant ? repeated(found, length) : found);
      offset += size;
    }
  }

  integers(name: string): Int32Array<ArrayBuffer> {
    return (this.columns.get(name) as Int32Array<ArrayBuffer> | undefined) ?? new Int32Array(0);
  }

  reals(name: string): Float64Array<ArrayBuffer> {
    return (this.columns.get(name) as Float64Array<ArrayBuffer> | undefined) ?? new Float64Array(0);
  }

  bytes(name: string): Uint8Array<ArrayBuffer> {
    return (this.columns.get(name) as Uint8Array<ArrayBuffer> | undefined) ?? new Uint8Array(0);
  }

  has(name: string): boolean {
    return this.columns.has(name);
  }
}

function repeated(column: Column, length: number): Column {
  const make = column.constructor as new (size: number) => Column;
  return new make(length).fill(column[0]!);
}

function decode(raw: Uint8Array<ArrayBuffer>, type: string, length: number): Column {
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

/**
 * Append values to a column. Returns the longer column, which may share memory with the given one: use that one no
 * longer.
 */
export function grown<T extends Column>(column: T, more: T): T {
  if (more.length === 0) return column;
  if (column.length === 0) return more;
  const make = column.constructor as new (size: number | ArrayBuffer, offset?: number, length?: number) => T;
  const length = column.length + more.length;
  const hasRoom = column.byteOffset + length * column.BYTES_PER_ELEMENT <= column.buffer.byteLength;
  const found = hasRoom ? new make(column.buffer, column.byteOffset, length) : (new make(2 * length).subarray(0, length) as T);
  if (!hasRoom) found.set(column);
  found.set(more, column.length);
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
