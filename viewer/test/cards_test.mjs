// Opens pages of cards that tests/view/cards_test.cpp wrote into FOLDER: node cards_test.mjs FOLDER. Exit code 77: no Chromium here.
import assert from 'node:assert/strict';
import { join } from 'node:path';
import { findChromium, until, withBrowser } from '../browser.mjs';
import { coarse, joints, openListening } from './look.mjs';

if (!findChromium()) {
  console.log('no Chromium');
  process.exit(77);
}
const folder = process.argv[2];

/** How many different colours a thumbnail has, and a number for its pixels. */
const thumbnail = (page, k) => page.evaluate((i) => {
  const canvas = document.querySelectorAll('.card canvas')[i];
  const copy = Object.assign(document.createElement('canvas'), { width: canvas.width, height: canvas.height }).getContext('2d', { willReadFrequently: true });
  copy.drawImage(canvas, 0, 0);
  const { data } = copy.getImageData(0, 0, canvas.width, canvas.height);
  let hash = 0;
  const colors = new Set();
  for (let at = 0; at < data.length; at += 4) {
    const color = (data[at] << 16) | (data[at + 1] << 8) | data[at + 2];
    if (data[at + 3] > 0) colors.add(color);
    hash = (hash * 31 + color + data[at + 3]) | 0;
  }
  return { colors: colors.size, hash };
}, k);

await withBrowser({ ...coarse, viewport: { width: 1000, height: 700 }, colorScheme: 'light' }, async (context) => {
  {
    const { page, complaints } = await openListening(context, join(folder, 'gallery.html'));
    assert.equal(await page.evaluate('inhabit.cards()'), 5);
    assert.deepEqual(await page.locator('.card h2').allTextContents(), ['a/far.npz', 'a/long.npz', 'b.bvh', 'evil <img src=x onerror=window.hacked=1>.npz', 'room.glb']);
    assert.match(await page.locator('.card p').first().textContent(), /2\.0 s, 30 frames a second, 22 joints/);
    assert.equal(await page.evaluate('window.hacked'), undefined);
    await until(page, 'inhabit.pictures() > 2');
    // Thumbnails of motion move, until they are paused; a scene's is a picture.
    const before = await thumbnail(page, 0);
    assert.ok(before.colors > 2, 'the thumbnail is blank');
    await page.waitForTimeout(500);
    assert.notEqual((await thumbnail(page, 0)).hash, before.hash);
    const room = await thumbnail(page, 4);
    assert.ok(room.colors > 20, `the room has ${room.colors} colours`);
    await page.getByRole('button', { name: 'Pause' }).click();
    const still = await thumbnail(page, 0);
    await page.waitForTimeout(300);
    assert.equal((await thumbnail(page, 0)).hash, still.hash);

    // A card opens in 3D, Escape leads back.
    await page.getByRole('button', { name: 'Open a/far.npz' }).click();
    await until(page, 'document.getElementById("sheet").hidden');
    assert.deepEqual(await page.evaluate('inhabit.people'), ['a/far.npz']);
    await page.evaluate('inhabit.setTime(0.5)');
    const early = await joints(page, 0);
    await page.evaluate('inhabit.setTime(1.5)');
    const late = await joints(page, 0);
    assert.ok(Math.abs(late[0][2] - early[0][2] - 1) < 0.01, 'the pelvis goes a metre in a second');
    await page.keyboard.press('Escape');
    await until(page, '!document.getElementById("sheet").hidden');
    await page.getByRole('button', { name: 'Open room.glb' }).click();
    assert.ok((await page.evaluate('inhabit.objects().length')) > 5);
    assert.equal(await page.locator('#bar').isVisible(), false);
    await page.click('#back');

    await page.getByRole('searchbox').fill('far');
    assert.equal(await page.locator('.card:visible').count(), 1);
    assert.equal(await page.getByRole('status').first().textContent(), '1 of 5');
    assert.deepEqual(complaints, []);
    await page.close();
  }
  {
    const { page, complaints } = await openListening(context, join(folder, 'curves.html'));
    assert.deepEqual(await page.locator('.card h2').allTextContents(), ['m.log.jsonl', 'table.json']);
    const log = page.locator('.card').nth(0);
    assert.deepEqual(await log.locator('figcaption').allTextContents(), ['validation', 'loss: total', 'loss: path', 'learning rate']);
    assert.deepEqual(await log.locator('.key span').allTextContents(), ['first', 'second']);
    // The curve falls as the numbers do: a path with a point for each, its last below its first.
    const total = log.locator('figure').nth(1).locator('path.curve');
    assert.equal(await total.count(), 2);
    const points = (await total.first().getAttribute('d')).split(/[ML]/).filter(Boolean).map((pair) => pair.split(' ').map(Number));
    assert.equal(points.length, 50);
    points.forEach(([x, y], i) => assert.ok(i === 0 || (x > points[i - 1][0] && y > points[i - 1][1]), `point ${i} of the curve is not below the one before`));
    assert.match(await log.locator('figure').nth(0).locator('svg').getAttribute('aria-label'), /validation: first from 0\.5 to 0\.25/);

    const table = page.locator('.card').nth(1);
    assert.deepEqual(await table.locator('figcaption').allTextContents(), ['path error', 'path error, mean', 'windows']);
    assert.equal(await table.locator('figure').nth(0).locator('path.curve').count(), 2);
    // Bars are as long as their numbers: 20 and 10 of "path error, mean".
    const bars = await table.locator('figure').nth(1).locator('rect').evaluateAll((all) => all.map((bar) => bar.width.baseVal.value));
    assert.equal(bars.length, 2);
    assert.ok(Math.abs(bars[0] / bars[1] - 2) < 0.01, `bars are ${bars}`);
    assert.equal(await table.locator('figure').nth(1).locator('line.whisker').count(), 2);
    await table.locator('summary').click();
    assert.match(await table.locator('table').textContent(), /0\.5s 12 ± 1/);
    await table.getByRole('combobox', { name: 'Which rows' }).selectOption('walking');
    assert.match(await table.locator('table').textContent(), /–/); // null: no value
    assert.equal(await page.evaluate('window.hacked'), undefined);
    assert.deepEqual(complaints, []);
  }
});
console.log('cards are as they should be');
