// What the page's tests share: opening a page, and looking at it.
import { pathToFileURL } from 'node:url';
import { openPage } from '../browser.mjs';

/** Opens a page, and gathers what it says or asks for. `also(page)` comes before it is loaded. */
export async function openListening(context, path, also = () => {}) {
  const complaints = [];
  const listen = (page) => {
    also(page);
    page.on('console', (message) => {
      if (['error', 'warning'].includes(message.type()) && !/GPU stall|ReadPixels|software WebGL|GL Driver Message/i.test(message.text())) complaints.push(message.text());
    });
    page.on('pageerror', (error) => complaints.push(String(error)));
    page.on('request', (request) => {
      if (!/^(file|data|blob):/.test(request.url())) complaints.push('asked for ' + request.url());
    });
  };
  const page = await openPage(context, pathToFileURL(path).href, listen);
  return { page, complaints };
}

/** Makes the window so large, and waits until the page is laid out for it: a frame takes seconds where many share a core. */
export async function setWindow(page, width, height) {
  await page.setViewportSize({ width, height });
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
}

/** Brightness deviation of the view at a time, and how many pixels turned warm since the look before (contact colours). */
export const look = (page, time, joint) => page.evaluate(([at, name]) => {
  if (name) inhabit.setJoint(name);
  inhabit.setTime(at);
  const view = document.getElementById('view');
  const flat = document.createElement('canvas');
  flat.width = view.width;
  flat.height = view.height;
  const context = flat.getContext('2d', { willReadFrequently: true });
  context.drawImage(view, 0, 0);
  const { data } = context.getImageData(0, 0, flat.width, flat.height);
  const before = window.lookedAt?.length === data.length ? window.lookedAt : data;
  window.lookedAt = data;
  let sum = 0, squares = 0, painted = 0, hash = 0;
  for (let i = 0; i < data.length; i += 4) {
    const [r, g, b] = [data[i], data[i + 1], data[i + 2]];
    const y = (r + g + b) / 3;
    sum += y;
    squares += y * y;
    painted += r - b > 60 && (r - b) - (before[i] - before[i + 2]) > 40;
    hash = (hash * 31 + r + 7 * g + 13 * b) | 0;
  }
  const n = data.length / 4;
  return { deviation: Math.sqrt(squares / n - (sum / n) ** 2), painted, hash };
}, [time, joint]);

export const joints = (page, person) => page.evaluate((i) => inhabit.jointPositions(i), person);
export const distance = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
