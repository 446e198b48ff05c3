// Uses the pages that tests/view/page_use_test.cpp wrote into FOLDER as visitors do: node use_test.mjs FOLDER
// Exit code 77: no Chromium here.
import assert from 'node:assert/strict';
import { mkdir, readFile } from 'node:fs/promises';
import { basename, join } from 'node:path';
import { findChromium, until, withBrowser } from '../browser.mjs';
import { coarse, distance, joints, look, openListening, setWindow } from './look.mjs';

if (!findChromium()) {
  console.log('no Chromium');
  process.exit(77);
}
const folder = process.argv[2];
const saved = join(folder, 'saved');
await mkdir(saved, { recursive: true });
const expected = JSON.parse(await readFile(join(folder, 'expected.json'), 'utf8'));
const open = (context, name) => openListening(context, join(folder, name));

/** Drops files on the page as a visitor does, those of each list at once, and waits until all are opened or refused. */
async function dropInTurn(page, ...lists) {
  const content = async (path) => [basename(path), (await readFile(path)).toString('base64')];
  const drops = await Promise.all(lists.map((paths) => Promise.all(paths.map(content))));
  const before = await page.evaluate('inhabit.opened ?? 0');
  await page.evaluate((all) => {
    for (const files of all) {
      const dropped = new DataTransfer();
      for (const [name, text] of files) dropped.items.add(new File([Uint8Array.from(atob(text), (c) => c.charCodeAt(0))], name));
      const event = (type) => document.body.dispatchEvent(new DragEvent(type, { bubbles: true, cancelable: true, dataTransfer: dropped }));
      event('dragover');
      event('drop');
    }
  }, drops);
  await until(page, `(inhabit.opened ?? 0) === ${before + lists.flat().length}`);
}
const drop = (page, ...paths) => dropInTurn(page, paths);

const message = (page) => page.locator('#message').evaluate((node) => (node.hidden ? '' : node.textContent));
const at = (page, name) => page.evaluate((wanted) => inhabit.objects().find((object) => object.name === wanted), name);

async function download(page, click) {
  const [file] = await Promise.all([page.waitForEvent('download'), click()]);
  const path = join(saved, file.suggestedFilename());
  await file.saveAs(path);
  return path;
}

async function keysAndNames(context) {
  const { page, complaints } = await open(context, 'two.html');
  // Every control has a name, and Tab goes through those that are shown from the head to the timeline.
  const seen = [];
  await page.evaluate('document.activeElement.blur()');
  for (let i = 0; i < 25; ++i) {
    await page.keyboard.press('Tab');
    const id = await page.evaluate('document.activeElement.id || document.activeElement.textContent');
    if (seen.includes(id)) break;
    seen.push(id);
  }
  const order = ['first', 'second', 'shape', 'follow', 'list', 'file', 'theme', 'helper', 'view', 'play', 'time', 'speed'];
  assert.deepEqual(seen.filter((id) => order.includes(id)), order, `focus went ${seen}`);
  assert.match(await page.locator('#view').getAttribute('aria-label'), /first, second, .*scene of 3 objects/);
  assert.match(await page.locator('#time').getAttribute('aria-valuetext'), /seconds of/);

  // The help lists the keys; the keys do nothing behind it; Escape closes it.
  await page.locator('#view').focus();
  await page.keyboard.press('?');
  assert.equal(await page.locator('#help').evaluate((node) => node.open), true);
  const said = await page.locator('#help dl').textContent();
  for (const words of ['Play, pause', 'Frame by frame', 'Root path', 'Light or dark', 'What is in the scene', 'pinch', 'Save what is seen']) assert.ok(said.includes(words), `the help does not tell of "${words}"`);
  const theme = () => page.evaluate('document.documentElement.dataset.theme');
  const before = await theme();
  await page.keyboard.press('d');
  assert.equal(await theme(), before);
  await page.keyboard.press('Escape');
  assert.equal(await page.locator('#help').evaluate((node) => node.open), false);

  // Dark and light: as the visitor's system is, until it is switched by hand.
  await page.emulateMedia({ colorScheme: 'dark' });
  await until(page, 'document.documentElement.dataset.theme === "dark"');
  await page.emulateMedia({ colorScheme: 'light' });
  await until(page, 'document.documentElement.dataset.theme === "light"');
  await page.keyboard.press('d');
  assert.equal(await theme(), 'dark');
  await page.keyboard.press('d');

  // The camera by keys.
  const camera = await page.evaluate('inhabit.camera()');
  await page.keyboard.press(']');
  await page.keyboard.press('+');
  const after = await page.evaluate('inhabit.camera()');
  assert.ok(distance(camera, after) > 0.1, 'the camera stays where it is');
  assert.ok(distance(after.slice(0, 3), after.slice(3)) < distance(camera.slice(0, 3), camera.slice(3)), 'and is no nearer');
  assert.deepEqual(complaints, []);
  await page.close();
}

async function telephone(browserContext) {
  const { page, complaints } = await open(browserContext, 'two.html');
  for (const [width, height] of [[844, 390], [390, 844]]) {
    await setWindow(page, width, height);
    const beyond = await page.evaluate(() => [...document.querySelectorAll('button, select, input, h1, #head, #tools, #bar')]
      .filter((node) => node.checkVisibility()).map((node) => [node.id || node.textContent, node.getBoundingClientRect()])
      .filter(([, box]) => box.width > 0 && (box.left < 0 || box.right > innerWidth || box.top < 0 || box.bottom > innerHeight)).map(([id]) => id));
    assert.deepEqual(beyond, [], `controls are off the screen of ${width} x ${height}`);
    assert.ok(await page.evaluate('document.documentElement.scrollWidth <= innerWidth'));
    // What a finger presses is there and not under something else.
    const covered = await page.evaluate(() => [...document.querySelectorAll('#tools button, #bar button, #legend button, #bar select')]
      .filter((node) => node.checkVisibility()).filter((node) => {
        const box = node.getBoundingClientRect();
        return !node.contains(document.elementFromPoint(box.x + box.width / 2, box.y + box.height / 2)) || box.height < 24;
      }).map((node) => node.id || node.textContent));
    assert.deepEqual(covered, [], 'controls that cannot be pressed');
  }

  // One finger orbits, two pinch.
  const touch = await browserContext.newCDPSession(page);
  const send = (type, ...points) => touch.send('Input.dispatchTouchEvent', { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });
  const camera = () => page.evaluate('inhabit.camera()');
  const away = ([x, y, z, a, b, c]) => distance([x, y, z], [a, b, c]);
  const before = await camera();
  await send('touchStart', [150, 300]);
  for (let x = 160; x <= 240; x += 20) await send('touchMove', [x, 300]);
  await send('touchEnd');
  await page.waitForTimeout(400);
  const turned = await camera();
  assert.ok(distance(before, turned) > 0.2, 'a finger does not orbit');
  assert.ok(Math.abs(away(before) - away(turned)) < 0.05, 'it only orbits');
  await send('touchStart', [180, 300], [220, 300]);
  for (let d = 25; d <= 85; d += 15) await send('touchMove', [200 - d, 300], [200 + d, 300]);
  await send('touchEnd');
  await page.waitForTimeout(400);
  assert.ok(away(await camera()) < 0.8 * away(turned), 'two fingers do not zoom');
  // Panels fit too.
  await page.locator('#list').tap();
  const box = await page.locator('#objects').boundingBox();
  assert.ok(box.x >= 0 && box.x + box.width <= 390 && box.y >= 0, 'the list of objects is off the screen');
  assert.deepEqual(complaints, []);
  await page.close();
}

async function saving(context) {
  const { page, complaints } = await open(context, 'two.html');
  await page.evaluate('inhabit.setTime(0.5)');
  await page.click('#file');
  const picture = await readFile(await download(page, () => page.click('#picture')));
  assert.equal(picture.subarray(1, 4).toString(), 'PNG');
  const size = await page.evaluate('[document.getElementById("view").width, document.getElementById("view").height]');
  assert.deepEqual([picture.readUInt32BE(16), picture.readUInt32BE(20)], size);
  // The picture is what is seen: compared pixel by pixel with the canvas.
  const same = await page.evaluate(async (text) => {
    const image = await createImageBitmap(new Blob([Uint8Array.from(atob(text), (c) => c.charCodeAt(0))]));
    inhabit.setTime(0.5);
    const pixels = (source) => {
      const context = Object.assign(document.createElement('canvas'), { width: image.width, height: image.height }).getContext('2d');
      context.drawImage(source, 0, 0);
      return context.getImageData(0, 0, image.width, image.height).data;
    };
    const [a, b] = [pixels(image), pixels(document.getElementById('view'))];
    let different = 0;
    for (let i = 0; i < a.length; ++i) different += Math.abs(a[i] - b[i]) > 2;
    return [different / a.length, new Set(a).size];
  }, picture.toString('base64'));
  assert.ok(same[0] < 0.001 && same[1] > 50, `the picture differs from the view (${same})`);
  for (const name of ['first', 'second']) assert.equal(basename(await download(page, () => page.getByRole('button', { name: `Save motion of ${name}` }).click())), `${name}.bvh`);
  await page.keyboard.press('Escape');
  assert.equal(await page.locator('#files').isVisible(), false);
  assert.deepEqual(complaints, []);
  await page.close();
  const chain = await open(context, 'chain.html');
  assert.equal(basename(await download(chain.page, () => chain.page.keyboard.press('m'))), 'chain.bvh');
  assert.deepEqual(chain.complaints, []);
  await chain.page.close();
}

async function opening(context) {
  const { page, complaints } = await open(context, 'empty.html');
  assert.ok(await page.locator('#welcome').isVisible());
  assert.equal(await page.locator('#bar').isVisible(), false);

  // What cannot be read is said in a line, and the page stays as it was.
  for (const [bad, reason] of [['bad.npz', /bad\.npz: is no \.npz/], ['cut.glb', /cut\.glb: is cut short/], ['cut.npz', /cut\.npz: /], ['notes.txt', /notes\.txt: is neither \.npz nor \.glb/]]) {
    await drop(page, join(folder, bad));
    const said = await message(page);
    assert.match(said, reason);
    assert.ok(!said.includes('\n'));
    assert.ok(await page.locator('#welcome').isVisible());
  }
  // A motion, then a scene, then another motion beside it.
  await drop(page, join(folder, 'walk.npz'));
  assert.equal(await message(page), '');
  assert.deepEqual(await page.evaluate('inhabit.people'), ['walk']);
  assert.deepEqual(await page.evaluate('inhabit.bodies()'), [true], 'it is shown as a body');
  const placed = async (person) => {
    await page.evaluate('inhabit.setTime(1)');
    (await joints(page, person)).forEach((p, j) => assert.ok(distance(p, expected.joints[j]) < 0.002, `joint ${j} of person ${person} is ${distance(p, expected.joints[j])} m off`));
  };
  await placed(0);
  const picture = await look(page, 1);
  assert.ok(picture.deviation > 2, 'the view is blank');
  await drop(page, join(folder, 'room.glb'));
  assert.ok((await page.evaluate('inhabit.objects().length')) > 5);
  assert.notEqual((await look(page, 1)).hash, picture.hash);
  await drop(page, join(folder, 'z_up.npz'), join(folder, 'bad.npz'));
  assert.deepEqual(await page.evaluate('inhabit.people'), ['walk', 'z_up']);
  assert.match(await message(page), /bad\.npz/);
  await placed(1);
  // Bare joints, of which name, unit, axes and rate are told by what they are; what was assumed is said.
  await drop(page, join(folder, 'bare.npz'));
  assert.deepEqual(await page.evaluate('inhabit.people'), ['walk', 'z_up', 'bare']);
  await placed(2);
  const note = await page.locator('#note').textContent();
  for (const words of ['bare.npz: ', '30 a second assumed', "SMPL's first 22 joints", 'taken for millimetres', '+Z is up in the file']) assert.ok(note.includes(words), `"${words}" is not in "${note}"`);
  await setWindow(page, 1000, 700); // low windows show no note
  assert.ok(await page.locator('#note').isVisible());
  assert.deepEqual(complaints, []);
  await page.close();

  // What is dropped while other files are read comes beside them. One person alone is not put apart by a key.
  const empty = await open(context, 'empty.html');
  await dropInTurn(empty.page, [join(folder, 'walk.npz')], [join(folder, 'room.glb')], [join(folder, 'z_up.npz')]);
  assert.deepEqual(await empty.page.evaluate('inhabit.people'), ['walk', 'z_up']);
  assert.ok((await empty.page.evaluate('inhabit.objects().length')) > 5);
  await empty.page.close();
  const one = await open(context, 'empty.html');
  await drop(one.page, join(folder, 'walk.npz'));
  await one.page.evaluate('inhabit.setTime(1)');
  await one.page.keyboard.press('s');
  (await joints(one.page, 0)).forEach((p, j) => assert.ok(distance(p, expected.joints[j]) < 0.002, `joint ${j} was moved`));
  assert.deepEqual([...empty.complaints, ...one.complaints], []);
  await one.page.close();

  // The file button does the same, on any page; a .glb brings people and scene.
  const two = await open(context, 'two.html');
  await two.page.click('#file');
  const [chooser] = await Promise.all([two.page.waitForEvent('filechooser'), two.page.click('#open')]);
  await chooser.setFiles([join(folder, 'walk.glb')]);
  await until(two.page, 'inhabit.opened === 1');
  assert.deepEqual(await two.page.evaluate('inhabit.people'), ['first', 'second', 'walk']);
  await two.page.evaluate('inhabit.setTime(1)');
  (await joints(two.page, 2)).forEach((p, j) => assert.ok(distance(p, expected.joints[j]) < 0.003, `joint ${j} from the .glb is ${distance(p, expected.joints[j])} m off`));
  assert.equal(await two.page.locator('#legend button').count(), 3);
  // Still a working page: it plays, and its controls are there once.
  await two.page.evaluate('inhabit.setTime(0)');
  await two.page.click('#play');
  await until(two.page, 'inhabit.time() > 0.05');
  assert.equal(await two.page.locator('#play').count(), 1);
  assert.deepEqual(two.complaints, []);
  await two.page.close();
}

async function objectsAndPeople(context) {
  const { page, complaints } = await open(context, 'two.html');
  assert.deepEqual((await page.evaluate('inhabit.objects()')).map(({ name }) => name).sort(), ['box_0', 'floor', 'stool_1']);
  // An object goes where the clip has it: a metre along +X, about its own axis; what does not move stays.
  await page.evaluate('inhabit.setTime(0)');
  const [start, stool] = [await at(page, 'box_0'), await at(page, 'stool_1')];
  await page.evaluate('inhabit.setTime(59 / 30)');
  const end = await at(page, 'box_0');
  // A rotation by 90 degrees about (1, 2) takes what lies at z + 0.1 to x + 0.1.
  assert.ok(distance(start.middle, [1, 0.25, 2.1]) < 0.01, `it starts at ${start.middle}`);
  assert.ok(distance(end.middle, [2.1, 0.25, 2]) < 0.01, `it ends at ${end.middle}`);
  assert.deepEqual((await at(page, 'stool_1')).middle, stool.middle);

  // The list hides and highlights.
  await page.evaluate('inhabit.setTime(0); inhabit.setCamera(3, 3, 5, [0, 0.5, 0])');
  const plain = await look(page, 0);
  await page.click('#list');
  await page.getByLabel('Show stool 1').uncheck();
  assert.equal((await at(page, 'stool_1')).shown, false);
  const hidden = await look(page, 0);
  assert.notEqual(hidden.hash, plain.hash);
  await page.getByLabel('Show stool 1').check();
  assert.equal((await look(page, 0)).hash, plain.hash);
  const button = page.getByRole('button', { name: 'box 0' });
  await button.click();
  assert.equal(await button.getAttribute('aria-pressed'), 'true');
  assert.notEqual((await look(page, 0)).hash, plain.hash);
  await button.click();
  assert.equal((await look(page, 0)).hash, plain.hash);
  await page.getByRole('button', { name: 'Hide all' }).click();
  assert.ok((await page.evaluate('inhabit.objects()')).every(({ shown }) => !shown));

  // Several people: a name and a colour each, over their heads and in the legend, which hides them.
  const tags = page.locator('#names span');
  assert.deepEqual(await tags.allTextContents(), ['first', 'second']);
  const colors = await page.locator('#legend i').evaluateAll((dots) => dots.map((dot) => dot.style.background));
  assert.equal(new Set(colors).size, 2);
  await page.locator('#legend button').first().click();
  assert.deepEqual(await page.evaluate('[0, 1].map(inhabit.visible)'), [false, true]);
  await until(page, 'document.querySelector("#names span").hidden');
  await page.keyboard.press('n');
  await until(page, 'document.getElementById("names").hidden');
  assert.deepEqual(complaints, []);
  await page.close();
}

/** The first view is not from behind a cabinet. */
async function firstView(context) {
  const aside = async (name) => {
    const { page } = await open(context, name);
    const [x, , z, atX, , atZ] = await page.evaluate('inhabit.camera()');
    await page.close();
    const off = Math.atan2(x - atX, z - atZ) - Math.atan2(1.4 - atX, 1.4 - atZ);
    return Math.abs(Math.atan2(Math.sin(off), Math.cos(off)));
  };
  assert.ok((await aside('two.html')) < 0.6, 'where nothing hides, the camera does not stand there');
  assert.ok((await aside('hidden.html')) > 0.9, 'a cabinet hides the walker');
}

await withBrowser({ ...coarse, viewport: { width: 700, height: 520 }, colorScheme: 'light', acceptDownloads: true, hasTouch: true }, async (context) => {
  for (const part of [keysAndNames, telephone, saving, opening, objectsAndPeople, firstView]) await part(context);
});
console.log('pages can be used');
