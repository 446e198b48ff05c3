// Opens the pages that tests/view/futures_page_test.cpp wrote into FOLDER in headless Chromium: node futures_test.mjs FOLDER
// Exit code 77: no Chromium here.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { join } from 'node:path';
import { findChromium, withBrowser } from '../browser.mjs';
import { coarse, distance, joints, look, openListening } from './look.mjs';

if (!findChromium()) {
  console.log('no Chromium');
  process.exit(77);
}
const folder = process.argv[2];
const expected = JSON.parse(await readFile(join(folder, 'expected.json'), 'utf8'));
const open = (context, name) => openListening(context, join(folder, name));

/** The colours of a row of the strips: [r, g, b] in the middle of `parts` equal parts of it. */
const stripColors = (page, row, rows, parts) => page.evaluate(([i, n, k]) => {
  const canvas = document.querySelector('.strips canvas');
  const context = Object.assign(document.createElement('canvas'), { width: canvas.width, height: canvas.height })
    .getContext('2d', { willReadFrequently: true });
  context.drawImage(canvas, 0, 0);
  return Array.from({ length: k }, (_, part) => [...context.getImageData(
    Math.round((canvas.width * (part + 0.5)) / k), Math.round((canvas.height * (i + 0.5)) / n), 1, 1).data.slice(0, 3)]);
}, [row, rows, parts]);

await withBrowser({ ...coarse, viewport: { width: 560, height: 400 } }, async (context) => {
  let alone;
  {
    const { page, complaints } = await open(context, 'futures.html');
    assert.ok(Math.abs(await page.evaluate('inhabit.duration') - (1 + 49 / 25)) < 1e-6);
    const everyone = Array.from({ length: 10 }, (_, i) => i);
    const visible = () => page.evaluate('Array.from({ length: 10 }, (_, i) => inhabit.visible(i))');

    // Side by side: everyone in a cell of its own and kept there; the past leads each.
    const apart = await look(page, 2);
    alone = apart.deviation;
    assert.ok(apart.deviation > 2, `the view is blank (deviation ${apart.deviation})`);
    const cells = await Promise.all(everyone.slice(1).map(async (i) => (await joints(page, i))[0]));
    cells.forEach((a, i) => cells.slice(0, i).forEach((b) => assert.ok(distance(a, b) > 1, 'figures stand in one place')));
    await look(page, 0.5);
    assert.deepEqual(await visible(), everyone.map((i) => i > 0));
    const before = await joints(page, 9);
    assert.ok(Math.hypot(before[0][0] - cells[8][0], before[0][2] - cells[8][2]) < 1e-3, 'the root stays in its cell');
    assert.ok(before.slice(20).some((p, k) => distance(p, before[0]) > 0.1), 'the past has joints');

    // Overlaid: where they go; the past is there once, before them.
    await page.click('#spread');
    assert.deepEqual(await visible(), everyone.map((i) => i === 0));
    const overlaid = await look(page, 2);
    assert.notEqual(overlaid.hash, apart.hash);
    assert.ok(overlaid.deviation > 2);
    assert.deepEqual(await visible(), everyone.map((i) => i > 0));
    (await joints(page, 9)).forEach((p, j) => assert.ok(distance(p, expected[j]) < 0.003, `joint ${j} is ${distance(p, expected[j])} m off`));
    await page.keyboard.press('s');
    await look(page, 2);
    assert.ok(distance((await joints(page, 9))[0], cells[8]) < 0.01, 'back in its cell');

    // Strips: nothing before a future starts, then 0, then 2 from 5 i + 1 frames on; the playhead goes along.
    const last = await stripColors(page, 8, 9, 12);
    const first = await stripColors(page, 0, 9, 12);
    assert.deepEqual(last[1], [0, 0, 0]);
    assert.deepEqual(last[5], first[5].map((_, k) => last[6][k]));
    assert.notDeepEqual(last[5], first[5]);
    assert.deepEqual(last[11], first[11]);
    assert.equal(await page.locator('#key b').count(), 2);
    const playhead = async () => (await page.locator('.strips i').boundingBox()).x;
    const at = await playhead();
    await look(page, 2.5);
    assert.ok(await playhead() > at + 20);

    // One stands out: under the pointer in the strips, or clicked.
    const plain = await look(page, 2);
    const strip = await page.locator('.strips canvas').boundingBox();
    await page.mouse.move(strip.x + strip.width / 2, strip.y + 2);
    assert.equal(await page.locator('#names .now').textContent(), '0');
    assert.notEqual((await look(page, 2)).hash, plain.hash);
    await page.mouse.move(5, 390);
    assert.equal(await page.locator('#names .now').count(), 0);
    await page.evaluate('inhabit.choose(4)');
    assert.equal(await page.locator('#names .now').textContent(), '3');
    await page.evaluate('inhabit.choose(4)');
    assert.equal((await look(page, 2)).hash, plain.hash);

    await page.setViewportSize({ width: 360, height: 680 });
    for (const id of ['#bar', '#tools', '#head']) {
      const box = await page.locator(id).boundingBox();
      assert.ok(box.x >= 0 && box.x + box.width <= 361 && box.y >= 0 && box.y + box.height <= 681, `${id} is off the screen`);
    }
    assert.deepEqual(complaints, []);
    await page.close();
  }
  {
    // In a room: where they go, in it; side by side without it, as if there were none.
    const { page, complaints } = await open(context, 'in_room.html');
    const pressed = () => page.getAttribute('#spread', 'aria-pressed');
    assert.equal(await pressed(), 'false');
    const inside = await look(page, 2);
    (await joints(page, 9)).forEach((p, j) => assert.ok(distance(p, expected[j]) < 0.003, `joint ${j} is ${distance(p, expected[j])} m off`));
    await page.click('#spread');
    assert.equal(await pressed(), 'true');
    const outside = await look(page, 2);
    assert.ok(Math.abs(outside.deviation - alone) < 0.5, `the room is still seen: ${outside.deviation}, ${alone} without one`);
    await page.click('#spread');
    assert.ok((await look(page, 2)).deviation > 2);
    assert.ok(Math.abs(inside.deviation - alone) > 1, `no room is seen: ${inside.deviation}, ${alone} without one`);
    assert.deepEqual(complaints, []);
    await page.close();
  }
  {
    // Intentions: recordings by action, motions that start over.
    const { page, complaints } = await open(context, 'intentions.html');
    assert.ok((await look(page, 0.4)).deviation > 2);
    assert.deepEqual(await page.locator('.strips b').allTextContents(), ['walk', 'jump']);
    assert.deepEqual(await page.locator('#names span').allTextContents(), ['0 · walk about', '1 · walk about', '2 · walk about']);
    const colors = await stripColors(page, 0, 3, 3);
    assert.equal(new Set(colors.map(String)).size, 3);
    const early = await joints(page, 0);
    await look(page, 0.4 + 19 / 25); // the first motion's length later
    (await joints(page, 0)).forEach((p, j) => assert.ok(distance(p, early[j]) < 1e-3, `joint ${j} does not start over`));
    assert.equal(await page.locator('#spread').isVisible(), false);
    assert.deepEqual(complaints, []);
  }
});
console.log('pages of many figures are as they should be');
