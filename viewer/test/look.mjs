// What the page's tests share: opening a page, and looking at it.
import assert from 'node:assert/strict';
import { pathToFileURL } from 'node:url';
import { openPage } from '../browser.mjs';

/** Of a browser where the fineness of pictures is not what is tested: software WebGL takes its time pixel by pixel, and these are a quarter as many. */
export const coarse = { deviceScaleFactor: 0.5 };

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

/** Visible texts whose contrast with what is behind them is too low, whether black or white lies behind what is see-through. */
export const faint = (page) => page.evaluate((least) => {
  const rgba = (text) => {
    const context = Object.assign(document.createElement('canvas'), { width: 1, height: 1 }).getContext('2d', { willReadFrequently: true });
    context.fillStyle = text;
    context.fillRect(0, 0, 1, 1);
    const [r, g, b, a] = context.getImageData(0, 0, 1, 1).data;
    return [r, g, b, a / 255];
  };
  const over = ([r, g, b, a], under) => [r, g, b].map((c, k) => a * c + (1 - a) * under[k]);
  const light = (color) => {
    const [r, g, b] = color.map((c) => (c / 255 <= 0.04045 ? c / 255 / 12.92 : ((c / 255 + 0.055) / 1.055) ** 2.4));
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const contrast = (a, b) => (Math.max(light(a), light(b)) + 0.05) / (Math.min(light(a), light(b)) + 0.05);
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  const found = [];
  let looked = 0;
  for (let node = walker.nextNode(); node; node = walker.nextNode()) {
    const owner = node.parentElement;
    if (!node.textContent.trim() || owner.closest('script, style, option, title') || !owner.checkVisibility({ opacityProperty: true, visibilityProperty: true })) continue;
    const style = getComputedStyle(owner);
    const ink = owner.closest('svg') ? style.fill : style.color;
    let worst = Infinity;
    for (const ground of [[0, 0, 0], [255, 255, 255]]) {
      const layers = [];
      for (let up = owner; up; up = up.parentElement) {
        const { backgroundColor } = getComputedStyle(up);
        const color = rgba(backgroundColor);
        if (color[3] > 0) layers.unshift(color);
        if (color[3] === 1 || getComputedStyle(up).position === 'fixed') break;
      }
      const behind = layers.reduce((under, layer) => over(layer, under), ground);
      worst = Math.min(worst, contrast(over(rgba(ink), behind), behind));
    }
    ++looked;
    if (worst < least) found.push(`${worst.toFixed(2)} "${node.textContent.trim().slice(0, 30)}" in ${owner.tagName} ${owner.id || owner.className}`);
  }
  return { found, looked };
}, 4.5); // WCAG 2.2 AA

/** Controls without a name, as the browser tells them to screen readers. */
export async function nameless(context, page) {
  const session = await context.newCDPSession(page);
  const { nodes } = await session.send('Accessibility.getFullAXTree');
  const controls = ['button', 'checkbox', 'combobox', 'slider', 'link', 'searchbox', 'textbox', 'image', 'img', 'dialog', 'toolbar', 'DisclosureTriangle'];
  const shown = nodes.filter(({ ignored, role }) => !ignored && controls.includes(role?.value));
  assert.ok(shown.length >= 2);
  return shown.filter(({ name }) => !name?.value?.trim()).map(({ role }) => role.value);
}
