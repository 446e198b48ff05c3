#!/usr/bin/env node
// Renders a page of `inhabit view` to a PNG, or to an animated WebP (needs img2webp of Debian's package webp):
//   scripts/screenshot.mjs PAGE.html OUT.png|OUT.webp [--time S | --times S,S,... | --film FROM,TO,FPS] [--size WxH] [--camera X,Y,Z] [--target X,Y,Z]
//     [--joint NAME] [--shape body|skeleton] [--theme light|dark] [--poses] [--overlaid] [--choose N] [--bare] [--columns N]
// --poses shows still poses along the path; --times gives one image per time, in rows of N (default: one row); --bare leaves the controls out; --joint NAME
// paints that joint's contact map, --joint off none; --overlaid and --choose N are for pages of many futures. Needs chromium and the packages of viewer/ (npm ci).
import { execFileSync } from 'node:child_process';
import { mkdtemp, rm, writeFile } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { parseArgs } from 'node:util';
import { openPage, withBrowser } from '../viewer/browser.mjs';

const { values, positionals } = parseArgs({
  allowPositionals: true,
  options: {
    time: { type: 'string' }, times: { type: 'string' }, film: { type: 'string' }, size: { type: 'string', default: '1280x800' },
    camera: { type: 'string' }, target: { type: 'string' }, joint: { type: 'string' }, shape: { type: 'string' },
    theme: { type: 'string', default: 'light' }, bare: { type: 'boolean', default: false }, poses: { type: 'boolean', default: false }, columns: { type: 'string' },
    overlaid: { type: 'boolean', default: false }, choose: { type: 'string' },
  },
});
const numbers = (text) => text.split(',').map(Number);
const [width, height] = values.size.split('x').map(Number);
const [from, to, fps] = values.film ? numbers(values.film) : [];
const times = values.film ? Array.from({ length: Math.floor((to - from) * fps) }, (_, i) => from + i / fps)
  : values.times ? numbers(values.times) : [Number(values.time ?? 0)];
const vectors = [values.camera, values.target].filter(Boolean).map(numbers);
if (positionals.length !== 2 || !(width > 0 && height > 0) || times.length === 0 ||
    positionals[1].endsWith('.webp') !== Boolean(values.film) || times.some(Number.isNaN) ||
    vectors.some((v) => v.length !== 3 || v.some(Number.isNaN))) {
  console.error('screenshot: expected PAGE.html OUT.png and options; see the head of scripts/screenshot.mjs');
  process.exit(2);
}
const [source, target] = positionals;

await withBrowser({ viewport: { width, height }, colorScheme: values.theme }, async (context) => {
  const page = await openPage(context, pathToFileURL(resolve(source)).href);
  if (values.bare) await page.addStyleTag({ content: '#head, #tools, #bar, #names { visibility: hidden }' });
  const shots = [];
  for (const time of times) {
    await page.evaluate(([view, at]) => {
      const { inhabit } = window;
      if (view.shape) inhabit.setShape(view.shape);
      if (view.poses) inhabit.setGhosts(true);
      if (view.overlaid) inhabit.setApart(false);
      if (view.choose && at === view.first) inhabit.choose(Number(view.choose));
      if (view.joint) inhabit.setJoint(view.joint);
      inhabit.setTime(at);
      if (view.camera) inhabit.setCamera(...view.camera, view.target);
      inhabit.setTime(at);
    }, [{ shape: values.shape, joint: values.joint, poses: values.poses, overlaid: values.overlaid, choose: values.choose, first: times[0], camera: values.camera && numbers(values.camera), target: values.target && numbers(values.target) }, time]);
    shots.push(await page.screenshot({ timeout: 120_000 }));
  }
  if (values.film) {
    const folder = await mkdtemp(join(tmpdir(), 'film-'));
    const files = shots.map((_, i) => join(folder, `${i}.png`));
    await Promise.all(shots.map((shot, i) => writeFile(files[i], shot)));
    execFileSync('img2webp', ['-loop', '0', '-lossy', '-q', '60', '-m', '6', '-d', String(Math.round(1000 / fps)), ...files, '-o', target]);
    await rm(folder, { recursive: true });
    return;
  }
  if (shots.length === 1) {
    await writeFile(target, shots[0]);
    return;
  }
  const columns = Number(values.columns ?? shots.length);
  const sheet = await context.newPage();
  const images = shots.map((shot) => `<img src="data:image/png;base64,${shot.toString('base64')}" width="${width}" height="${height}">`);
  await sheet.setViewportSize({ width: columns * width, height: Math.ceil(shots.length / columns) * height });
  await sheet.setContent(`<body style="margin:0;display:grid;grid-template-columns:repeat(${columns},${width}px)">${images.join('')}</body>`);
  await writeFile(target, await sheet.screenshot({ timeout: 120_000 }));
});
