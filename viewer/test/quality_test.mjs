// What Lighthouse would look at, in all pages (*.html) of FOLDER: contrast, names of controls, errors, time to the first picture and
// weight: node quality_test.mjs FOLDER. Exit code 77: no Chromium here.
// Time is asserted as the page's own work (processor time of its main thread), and by the clock where the machine has a core to spare.
import assert from 'node:assert/strict';
import { readdir, stat } from 'node:fs/promises';
import { availableParallelism, loadavg } from 'node:os';
import { join } from 'node:path';
import { gzipSync } from 'node:zlib';
import { readFileSync } from 'node:fs';
import { findChromium, withBrowser } from '../browser.mjs';
import { faint, nameless, openListening, setWindow } from './look.mjs';

if (!findChromium()) {
  console.log('no Chromium');
  process.exit(77);
}
const folder = process.argv[2];
const FIRST = 1000; // milliseconds to the first picture, the best of some loads
const pages = (await readdir(folder)).filter((name) => name.endsWith('.html')).sort();
assert.ok(pages.length > 0);

const sessions = new WeakMap();
const measured = async (page) => {
  sessions.set(page, (async () => {
    const session = await page.context().newCDPSession(page);
    await session.send('Performance.enable');
    return session;
  })());
};

/** Milliseconds of processor time that the page's main thread has taken so far. */
async function workOf(page) {
  const { metrics } = await (await sessions.get(page)).send('Performance.getMetrics');
  return 1000 * metrics.find(({ name }) => name === 'ThreadTime').value;
}

await withBrowser({ viewport: { width: 1280, height: 800 } }, async (context) => {
  for (const name of pages) {
    const path = join(folder, name);
    const bytes = (await stat(path)).size;
    let [first, work] = [Infinity, Infinity];
    const idle = loadavg()[0] < availableParallelism() - 1;
    for (let run = 0; run < 5 && (run < 2 || work > FIRST || (idle && first > FIRST)); ++run) {
      const { page, complaints } = await openListening(context, path, measured);
      first = Math.min(first, await page.evaluate('inhabit.firstPicture'));
      work = Math.min(work, await workOf(page));
      if (run > 0) {
        assert.deepEqual(complaints, []);
        await page.close();
        continue;
      }
      assert.equal(await page.evaluate('document.documentElement.lang'), 'en');
      assert.ok((await page.title()).length > 0);
      assert.equal(await page.evaluate('[...document.querySelectorAll("h1")].filter((node) => node.checkVisibility()).length'), 1, 'one heading of the first level is shown');
      const ids = await page.evaluate('[...document.querySelectorAll("[id]")].map(({ id }) => id)');
      assert.deepEqual(ids.filter((id, i) => ids.indexOf(id) !== i), [], 'ids that are there twice');
      for (const [width, height] of [[1280, 800], [390, 844]]) {
        await setWindow(page, width, height);
        for (const colorScheme of ['light', 'dark']) {
          await page.emulateMedia({ colorScheme });
          for (const panel of ['', '#list', '#file', '#helper']) {
            if (panel && (width < 1000 || !(await page.locator(panel).isVisible()))) continue; // panels once
            if (panel) await page.click(panel);
            const { found, looked } = await faint(page);
            assert.ok(looked > 2, 'no text was found');
            assert.deepEqual(found, [], `${name}, ${width} px, ${colorScheme} ${panel}: faint text`);
            assert.deepEqual(await nameless(context, page), [], `${name} ${panel}: controls without a name`);
            if (panel === '#helper') await page.keyboard.press('Escape');
          }
          await page.evaluate('document.querySelectorAll("details").forEach((details) => (details.open = true))');
          assert.deepEqual((await faint(page)).found, []);
          assert.ok(await page.evaluate('document.documentElement.scrollWidth <= innerWidth && document.getElementById("sheet").scrollWidth <= innerWidth'), `${name} is wider than ${width} px`);
        }
      }
      assert.deepEqual(complaints, [], `${name} complains`);
      await page.close();
    }
    console.log(`${name}: ${(bytes / 1024).toFixed(0)} KiB (${(gzipSync(readFileSync(path)).length / 1024).toFixed(0)} KiB compressed), first picture after ${work.toFixed(0)} ms of work, ${first.toFixed(0)} ms by the clock (load ${loadavg()[0].toFixed(1)} on ${availableParallelism()} cores)`);
    assert.ok(work < FIRST, `${name}: the first picture took ${work} ms of work`);
    if (idle) assert.ok(first < FIRST, `${name}: the first picture took ${first} ms`);
  }
});
