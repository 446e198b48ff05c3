// NumPy's .npz: a zip archive of .npy arrays, stored or deflated.

const MOST = 1 << 30; // bytes of all arrays together

export interface NumpyArray {
  shape: number[];
  values: Float32Array | Float64Array; // numbers of any kind, in C order
  words?: string[]; // instead of them, where the array is of text
}

async function inflated(packed: Uint8Array<ArrayBuffer>, size: number): Promise<Uint8Array<ArrayBuffer>> {
  const out = new Uint8Array(size);
  const reader = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate-raw')).getReader();
  let at = 0;
  for (;;) {
    const { done, value } = await reader.read();
    if (done) break;
    if (at + value.length > size) throw new Error('an array is longer than its archive says');
    out.set(value, at);
    at += value.length;
  }
  if (at !== size) throw new Error('an array is shorter than its archive says');
  return out;
}

/** The files of a zip archive whose names `wanted` accepts. */
async function unzipped(bytes: Uint8Array<ArrayBuffer>, wanted: (name: string) => boolean) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const least = Math.max(0, bytes.length - 65_557);
  let end = bytes.length - 22;
  while (end >= least && view.getUint32(end, true) !== 0x06054b50) --end;
  if (end < least) throw new Error('is no .npz: no zip archive, or one that is cut short');
  const files = new Map<string, Uint8Array<ArrayBuffer>>();
  let total = 0;
  let at = view.getUint32(end + 16, true);
  for (let i = view.getUint16(end + 10, true); i > 0; --i) {
    if (view.getUint32(at, true) !== 0x02014b50) throw new Error('its archive is damaged');
    const method = view.getUint16(at + 10, true);
    const packed = view.getUint32(at + 20, true);
    const size = view.getUint32(at + 24, true);
    const nameLength = view.getUint16(at + 28, true);
    const name = new TextDecoder().decode(bytes.subarray(at + 46, at + 46 + nameLength));
    const head = view.getUint32(at + 42, true);
    at += 46 + nameLength + view.getUint16(at + 30, true) + view.getUint16(at + 32, true);
    if (!wanted(name)) continue;
    if (packed === 0xffffffff || size === 0xffffffff) throw new Error('arrays of 4 GiB are not read here');
    if ((total += size) > MOST) throw new Error('holds more than 1 GiB of arrays, too many for a page');
    const start = head + 30 + view.getUint16(head + 26, true) + view.getUint16(head + 28, true);
    if (start + packed > bytes.length) throw new Error('its archive is cut short');
    const content = bytes.subarray(start, start + packed);
    if (method !== 0 && method !== 8) throw new Error('its archive is packed by a method that is not known');
    files.set(name, method === 0 ? content.slice() : await inflated(content, size));
  }
  return files;
}

type Read = (view: DataView, at: number, little: boolean) => number;

function half(bits: number) {
  const sign = bits & 0x8000 ? -1 : 1;
  const exponent = (bits >> 10) & 0x1f;
  const fraction = bits & 0x3ff;
  if (exponent === 0x1f) return fraction ? NaN : sign * Infinity;
  return exponent ? sign * 2 ** (exponent - 15) * (1 + fraction / 1024) : sign * 2 ** -24 * fraction;
}

const KINDS: Record<string, [number, Read]> = {
  f2: [2, (view, at, little) => half(view.getUint16(at, little))],
  f4: [4, (view, at, little) => view.getFloat32(at, little)],
  f8: [8, (view, at, little) => view.getFloat64(at, little)],
  i8: [8, (view, at, little) => Number(view.getBigInt64(at, little))],
  u8: [8, (view, at, little) => Number(view.getBigUint64(at, little))],
  i4: [4, (view, at, little) => view.getInt32(at, little)],
  u4: [4, (view, at, little) => view.getUint32(at, little)],
  i2: [2, (view, at, little) => view.getInt16(at, little)],
  u2: [2, (view, at, little) => view.getUint16(at, little)],
  i1: [1, (view, at) => view.getInt8(at)],
  u1: [1, (view, at) => view.getUint8(at)],
  b1: [1, (view, at) => view.getUint8(at)],
};

/** For every element in C order the place where Fortran's order has it. */
function placesInFortranOrder(shape: number[], count: number) {
  const places = new Uint32Array(count);
  const at = shape.map(() => 0);
  const step: number[] = [];
  shape.reduce((product, size, axis) => ((step[axis] = product), product * size), 1);
  let place = 0;
  for (let i = 0; i < count; ++i) {
    places[i] = place;
    for (let axis = shape.length - 1; axis >= 0; --axis) {
      place += step[axis];
      if (++at[axis] < shape[axis]) break;
      place -= step[axis] * shape[axis];
      at[axis] = 0;
    }
  }
  return places;
}

function parseNpy(bytes: Uint8Array, name: string): NumpyArray | undefined {
  const damaged = new Error(`its array ${name} is damaged`);
  if (bytes.length < 12 || bytes[0] !== 0x93 || String.fromCharCode(...bytes.subarray(1, 6)) !== 'NUMPY') throw damaged;
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const long = bytes[6] > 1;
  const start = long ? 12 : 10;
  const length = long ? view.getUint32(8, true) : view.getUint16(8, true);
  if (start + length > bytes.length) throw damaged;
  const head = new TextDecoder('latin1').decode(bytes.subarray(start, start + length));
  const type = /'descr':\s*'([^']+)'/.exec(head)?.[1];
  const sizes = /'shape':\s*\(([^)]*)\)/.exec(head)?.[1];
  if (!type || sizes === undefined) return undefined; // tables are left out
  const shape = sizes.split(',').map((part) => part.trim()).filter(Boolean).map(Number);
  const count = shape.reduce((product, size) => product * size, 1);
  const at = start + length;
  const text = /^([<|])([US])(\d+)$/.exec(type);
  const [width, read] = text ? [Number(text[3]) * (text[2] === 'U' ? 4 : 1), undefined] : KINDS[type.slice(1)] ?? [0, undefined];
  if (!text && !read) return undefined; // objects, complex numbers
  if (!Number.isSafeInteger(count) || count < 0 || at + count * width > bytes.length) throw damaged;
  const places = shape.length > 1 && /'fortran_order':\s*True/.test(head) ? placesInFortranOrder(shape, count) : undefined;
  const startOf = (i: number) => at + (places ? places[i] : i) * width;
  if (read) {
    const little = type[0] !== '>';
    const values = width === 4 && type[1] === 'f' ? new Float32Array(count) : new Float64Array(count);
    for (let i = 0; i < count; ++i) values[i] = read(view, startOf(i), little);
    return { shape, values };
  }
  const words = Array.from({ length: count }, (_, i) => {
    const here = startOf(i);
    let word = '';
    if (text![2] === 'S') word = new TextDecoder().decode(bytes.subarray(here, here + width));
    else for (let k = 0; k < width; k += 4) {
      const code = view.getUint32(here + k, true);
      if (code > 0x10ffff) throw damaged;
      word += String.fromCodePoint(code);
    }
    return word.replace(/\0+$/, '');
  });
  return { shape, values: new Float32Array(), words };
}

/** The arrays of numbers and of text of an .npz file; others are left out. */
export async function readNpz(bytes: Uint8Array<ArrayBuffer>): Promise<Map<string, NumpyArray>> {
  const arrays = new Map<string, NumpyArray>();
  for (const [file, content] of await unzipped(bytes, (name) => name.endsWith('.npy'))) {
    const name = file.slice(0, -4);
    const array = parseNpy(content, name);
    if (array) arrays.set(name, array);
  }
  return arrays;
}
