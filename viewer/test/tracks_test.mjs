// Opens FOLDER/sit.html, which tests/interact/label_tracks_test.cpp made, in headless Chromium: node tracks_test.mjs FOLDER
// Exit code 77: no Chromium here.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { join } from 'node:path';
import { findChromium, withBrowser } from '../browser.mjs';
import { coarse, openListening } from './look.mjs';

if (!findChromium()) {
  console.log('no Chromium');
  process.exit(77);
}
const folder = process.argv[2];
const { held, seconds } = JSON.parse(await readFile(join(folder, 'expected.json'), 'utf8'));

await withBrowser({ ...coarse, viewport: { width: 900, height: 640 } }, async (context) => {
  const { page, complaints } = await openListening(context, join(folder, 'sit.html'));
  const canvas = page.locator('.strips.tracks canvas');
  assert.equal(await canvas.count(), 1);
  const box = await canvas.boundingBox();
  assert.ok(Math.abs(box.height - 6 * 14) < 1, `six strips are ${box.height} pixels high`);
  const track = await page.locator('#spans').boundingBox();
  assert.ok(Math.abs(box.x - track.x) < 2 && Math.abs(box.width - track.width) < 2, 'strips lie under the timeline');

  /** What is said of a strip at a time. */
  const said = async (row, time) => {
    await page.mouse.move(box.x + (time / seconds) * box.width, box.y + 14 * row + 7);
    return canvas.getAttribute('title');
  };
  assert.match(await said(0, held + 0.3), /^left hand · 1\.00 · /);
  assert.match(await said(0, 0.1), /^left hand · 0\.00 · /);
  assert.match(await said(2, 1), /^phase · \d\.\d\d · /);
  assert.match(await said(3, seconds - 0.2), /^action · (idle|walk|sit) · /);
  assert.match(await said(3, held + 0.3), /^action · sit · /);
  assert.match(await said(4, held + 0.3), /^left contact · -?\d\.\d\d -?\d\.\d\d -?\d\.\d\d · /);
  assert.equal(await said(4, 0.1), 'left contact');

  // Strips are painted, and the line of the present moves over them.
  const colours = await page.evaluate(() => {
    const canvas = document.querySelector('.strips.tracks canvas');
    const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    const seen = new Set();
    for (let i = 0; i < data.length; i += 4) if (data[i + 3] === 255) seen.add(data.slice(i, i + 3).join());
    return seen.size;
  });
  assert.ok(colours > 5, `only ${colours} colours`);
  await page.evaluate((t) => inhabit.setTime(t), seconds / 2);
  await page.evaluate(() => new Promise((next) => requestAnimationFrame(() => requestAnimationFrame(next))));
  const left = parseFloat(await page.locator('.strips.tracks i').evaluate((line) => line.style.left));
  assert.ok(Math.abs(left - 50) < 1, `the line is at ${left} %`);
  assert.deepEqual(complaints, []);
});
console.log('strips are as they should be');
