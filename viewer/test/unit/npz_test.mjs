// NumPy's ways to lay out numbers: the page reads those that the command reads (inhabit/io/npz.cpp).
import assert from 'node:assert/strict';
import test from 'node:test';
import { source } from './source.mjs';

const { readNpz } = await source('npz.ts');

/** A .npy file. @param write (view, index of the element in the file) */
function npy(type, width, shape, fortran, write) {
  const text = `{'descr': '${type}', 'fortran_order': ${fortran ? 'True' : 'False'}, 'shape': (${shape.join(', ')},), }`;
  const head = text.padEnd(117) + '\n';
  const count = shape.reduce((product, size) => product * size, 1);
  const out = Buffer.alloc(10 + head.length + count * width);
  out.write('\x93NUMPY\x01\x00', 0, 'latin1');
  out.writeUInt16LE(head.length, 8);
  out.write(head, 10, 'latin1');
  for (let i = 0; i < count; ++i) write(out, 10 + head.length + i * width, i);
  return out;
}

/** A zip archive of one stored file. */
function zipped(name, content) {
  const file = Buffer.from(name);
  const local = Buffer.alloc(30);
  local.writeUInt32LE(0x04034b50, 0);
  local.writeUInt16LE(file.length, 26);
  const central = Buffer.alloc(46);
  central.writeUInt32LE(0x02014b50, 0);
  central.writeUInt32LE(content.length, 20);
  central.writeUInt32LE(content.length, 24);
  central.writeUInt16LE(file.length, 28);
  const end = Buffer.alloc(22);
  end.writeUInt32LE(0x06054b50, 0);
  end.writeUInt16LE(1, 10);
  end.writeUInt32LE(30 + file.length + content.length, 16);
  return new Uint8Array(Buffer.concat([local, file, content, central, file, end]));
}

const read = async (...layout) => (await readNpz(zipped('trans.npy', npy(...layout)))).get('trans');

test("Fortran's order is read as C's", async () => {
  // The element [i][j][k] is 100 i + 10 j + k; in the file the first index runs fastest.
  const at = (n) => 100 * (n % 2) + 10 * (Math.floor(n / 2) % 3) + Math.floor(n / 6);
  const array = await read('<f4', 4, [2, 3, 4], true, (out, place, n) => out.writeFloatLE(at(n), place));
  assert.deepEqual(array.shape, [2, 3, 4]);
  const wanted = [0, 1].flatMap((i) => [0, 1, 2].flatMap((j) => [0, 1, 2, 3].map((k) => 100 * i + 10 * j + k)));
  assert.deepEqual([...array.values], wanted);
  const row = await read('<f8', 8, [3], true, (out, place, n) => out.writeDoubleLE(n, place));
  assert.deepEqual([...row.values], [0, 1, 2]);
});

test('numbers of any byte order and of half precision', async () => {
  assert.deepEqual([...(await read('>f4', 4, [2], false, (out, place, n) => out.writeFloatBE(n + 0.5, place))).values], [0.5, 1.5]);
  assert.deepEqual([...(await read('>i2', 2, [2], false, (out, place, n) => out.writeInt16BE(n - 300, place))).values], [-300, -299]);
  const halves = [0x3c00, 0xc000, 0x3555, 0x0001, 0x7c00, 0xfc00, 0x8000];
  const { values } = await read('<f2', 2, [7], false, (out, place, n) => out.writeUInt16LE(halves[n], place));
  assert.deepEqual([...values].map((x) => Math.fround(x)), [1, -2, Math.fround(0.333251953125), 2 ** -24, Infinity, -Infinity, -0]);
});

test('objects and complex numbers are left out', async () => {
  assert.equal(await read('|O', 8, [1], false, () => {}), undefined);
  assert.equal(await read('<c8', 8, [1], false, () => {}), undefined);
});
