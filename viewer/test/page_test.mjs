// Opens the pages that tests/view/page_test.cpp wrote into FOLDER in headless Chromium: node page_test.mjs FOLDER
// Exit code 77: no Chromium here.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { join } from 'node:path';
import { findChromium, until, withBrowser } from '../browser.mjs';
import { coarse, distance, joints, look, openListening, setWindow } from './look.mjs';

if (!findChromium()) {
  console.log('no Chromium');
  process.exit(77);
}
const folder = process.argv[2];
const expected = JSON.parse(await readFile(join(folder, 'expected.json'), 'utf8'));

const open = (context, name) => openListening(context, join(folder, name));

await withBrowser({ ...coarse, viewport: { width: 700, height: 480 } }, async (context) => {
  {
    const { page, complaints } = await open(context, 'forecast.html');
    assert.equal(await page.title(), 'Forecast in a room');
    assert.ok(Math.abs(await page.evaluate('inhabit.duration') - (1 + 59 / 30)) < 1e-6);

    // The timeline moves the person, and to where it is.
    const early = await look(page, 0.2, 'off');
    const before = await joints(page, 0);
    const later = await look(page, 0.8);
    const after = await joints(page, 0);
    assert.ok(Math.abs(distance(before[0], after[0]) - 0.6) < 0.01, 'the pelvis walks 0.6 m in 0.6 s');
    assert.ok(before.every((p, j) => distance(p, after[j]) > 0.05), 'every joint moves');
    assert.notEqual(early.hash, later.hash);
    assert.ok(early.deviation > 8, `the view is blank (deviation ${early.deviation})`);
    for (const shape of ['body', 'skeleton']) {
      await page.evaluate((s) => inhabit.setShape(s), shape);
      const picture = await look(page, 1.5);
      assert.ok(picture.deviation > 8);
      const drawn = await joints(page, 2);
      drawn.forEach((p, j) => assert.ok(distance(p, expected.joints[j]) < 0.002, `${shape}: joint ${j} is ${distance(p, expected.joints[j])} m off`));
    }
    assert.deepEqual(await page.evaluate('[0, 1, 2].map(inhabit.visible)'), [false, true, true]);
    await look(page, 0.5);
    assert.deepEqual(await page.evaluate('[0, 1, 2].map(inhabit.visible)'), [true, false, false]);

    // Contact maps: a foot's is painted, another time and another joint look different.
    await look(page, 1.5, 'off');
    assert.equal((await look(page, 1.5, 'off')).painted, 0);
    const foot = await look(page, 1.5, 'left_foot');
    assert.ok(foot.painted > 30, `only ${foot.painted} pixels are painted`);
    const head = await look(page, 1.5, 'head');
    assert.notEqual(foot.hash, head.hash);
    await page.evaluate('inhabit.setCamera(0, 6, 0.1, [0, 0, 0])');
    assert.notEqual((await look(page, 1.2, 'left_foot')).hash, (await look(page, 2.6)).hash);

    // Controls as a visitor uses them.
    await page.evaluate('inhabit.setTime(1)');
    await page.keyboard.press('ArrowRight');
    assert.ok(Math.abs(await page.evaluate('inhabit.time()') - 31 / 30) < 1e-6);
    await page.keyboard.press('ArrowLeft');
    await page.keyboard.press('ArrowLeft');
    assert.ok(Math.abs(await page.evaluate('inhabit.time()') - 29 / 30) < 1e-6);
    await page.locator('#time').fill('2');
    assert.equal(await page.evaluate('inhabit.time()'), 2);
    await page.selectOption('#speed', '0.1');
    await page.click('#play');
    await until(page, 'inhabit.time() > 2.01');
    await page.click('#play');
    assert.equal(await page.evaluate('inhabit.playing()'), false);
    await page.selectOption('#joint', { label: 'right foot' });
    assert.deepEqual(await page.locator('#actions span').allTextContents(), ['walk', 'turn']);
    assert.equal(await page.locator('#legend button').count(), 3);

    // A telephone held upright: nothing beyond its edges.
    await setWindow(page, 360, 680);
    for (const id of ['#bar', '#tools', '#head']) {
      const box = await page.locator(id).boundingBox();
      assert.ok(box.x >= 0 && box.x + box.width <= 361 && box.y >= 0 && box.y + box.height <= 681, `${id} is off the screen`);
    }
    assert.deepEqual(complaints, []);
    await page.close();
  }
  {
    // Key frames are ticks and still copies, collisions a stretch; the body turns red in these.
    const { page, complaints } = await open(context, 'filled.html');
    assert.equal(await page.locator('#spans .key').count(), 3);
    const box = await page.locator('#spans .collision').boundingBox();
    const track = await page.locator('#spans').boundingBox();
    assert.ok(Math.abs((box.x - track.x) / track.width - 30 / 59) < 0.02, 'the stretch begins at frame 30');
    assert.ok(Math.abs(box.width / track.width - 10 / 59) < 0.02, 'and has ten frames');
    assert.match(await page.locator('#spans .collision').getAttribute('title'), /66 mm in table_0/);
    await look(page, 0.9);
    const red = await look(page, 1.1);
    assert.ok(red.painted > 100, `only ${red.painted} pixels turned red`);
    await look(page, 1.1);
    assert.equal((await look(page, 1.5)).painted, 0);
    assert.deepEqual(complaints, []);
    await page.close();
  }
  {
    // Keys that gave other poses than came out stand where they gave them, of partial ones only what they gave.
    const { page, complaints } = await open(context, 'partial.html');
    await look(page, 0.9);
    const places = await page.evaluate('inhabit.keyPlaces()');
    assert.deepEqual(places.map((joints) => joints.length), [22, 1, 22]);
    assert.ok(distance(places[1][0], expected.wrist) < 0.002, 'the mark is where the wrist was given');
    assert.equal(await page.locator('#spans .collision').count(), 2);
    assert.deepEqual(complaints, []);
    await page.close();
  }
  {
    const { page, complaints } = await open(context, 'hostile.html');
    assert.equal(await page.evaluate('window.hacked'), undefined);
    assert.equal(await page.locator('img').count(), 0);
    assert.match(await page.title(), /<script>/);
    assert.match(await page.locator('#legend').textContent(), /<img/);
    assert.deepEqual(complaints, []);
    await page.close();
  }
  {
    const { page, complaints } = await open(context, 'crowd.html');
    assert.equal((await page.evaluate('inhabit.people')).length, 51);
    const picture = await look(page, 1);
    assert.ok(picture.deviation > 4);
    await page.click('#spread');
    assert.notEqual((await look(page, 1)).hash, picture.hash);
    assert.deepEqual(complaints, []);
  }
});
console.log('pages are as they should be');
