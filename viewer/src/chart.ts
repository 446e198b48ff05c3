import type { ChartData, PanelData, SeriesData } from './data';
import { make } from './dom';

const WIDTH = 360;
const HEIGHT = 210;
const LEFT = 52;
const BOTTOM = 24;
const TOP = 10;
const RIGHT = 12;
const NOISY = 60; // points beyond which a curve is smoothed, and seen faintly as it is

const readable = (text: string) => text.replace(/_/g, ' ');

function svg(tag: string, attributes: Record<string, string | number>, ...children: (Node | string)[]) {
  const made = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, String(value));
  made.append(...children);
  return made;
}

/** A number with about three digits that matter. */
export function short(x: number): string {
  const size = Math.abs(x);
  if (size !== 0 && (size < 1e-3 || size >= 1e6)) return x.toExponential(1).replace('e+', 'e');
  if (size >= 1e4) return `${Number((x / 1000).toPrecision(3))}k`;
  return String(Number(x.toPrecision(3)));
}

/** Round numbers from low to high, some four of them. */
export function ticksOf(low: number, high: number): number[] {
  const rough = (high - low) / 4 || 1;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * ([1, 2, 5, 10].find((factor) => factor * power >= rough) ?? 10);
  const ticks: number[] = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + step * 1e-9; ++k) ticks.push(k * step);
  return ticks;
}

const numbers = (series: SeriesData[]) => series.flatMap(({ y, interval }) =>
  y.flatMap((value, i) => (value === null ? [] : [value, value - (interval?.[i] ?? 0), value + (interval?.[i] ?? 0)])));

/** Means of the values about each. */
function smoothed(values: number[]): number[] {
  const most = Math.ceil(values.length / 40);
  return values.map((_, i) => {
    const near = values.slice(Math.max(0, i - most), i + most + 1);
    return near.reduce((sum, value) => sum + value, 0) / near.length;
  });
}

/** Curves over x, or over the panel's ticks; on a logarithmic scale where the values span it. */
function curves(panel: PanelData, x: string, color: (name: string) => string): SVGElement {
  const { series, ticks } = panel;
  const xs = ticks ? ticks.map(Number.parseFloat) : series.flatMap((one) => one.x ?? []);
  const ys = numbers(series);
  const [left, right] = [Math.min(...xs), Math.max(...xs)];
  let [low, high] = [Math.min(...ys), Math.max(...ys)];
  const logarithmic = low > 0 && high / low > 30;
  const scaled = (value: number) => (logarithmic ? Math.log10(value) : value);
  if (!logarithmic && low > 0 && low < 0.6 * high) low = 0;
  [low, high] = [scaled(low), scaled(high)];
  const room = (high - low || Math.abs(high) || 1) * 0.05;
  high += room;
  if (low !== 0) low -= room;
  const px = (value: number) => LEFT + ((value - left) / (right - left || 1)) * (WIDTH - LEFT - RIGHT);
  const py = (value: number) => HEIGHT - BOTTOM - ((scaled(value) - low) / (high - low)) * (HEIGHT - BOTTOM - TOP);
  const out = svg('svg', { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: 'img', 'aria-label': summary(panel) });
  const decades = Array.from({ length: Math.max(0, Math.floor(high) - Math.ceil(low) + 1) }, (_, k) => Math.ceil(low) + k);
  const ticksY = logarithmic ? (decades.length > 1 ? decades : ticksOf(low, high)).map((power) => 10 ** power) : ticksOf(low, high);
  for (const value of ticksY) {
    out.append(svg('line', { class: 'grid', x1: LEFT, x2: WIDTH - RIGHT, y1: py(value), y2: py(value) }),
      svg('text', { x: LEFT - 6, y: py(value) + 4, 'text-anchor': 'end' }, short(value)));
  }
  for (const value of ticks ? xs : ticksOf(left, right)) {
    out.append(svg('text', { x: px(value), y: HEIGHT - 8, 'text-anchor': px(value) > WIDTH - RIGHT - 12 ? 'end' : 'middle' }, ticks ? ticks[xs.indexOf(value)] : short(value)));
  }
  if (!ticks) out.append(svg('text', { x: LEFT - 6, y: HEIGHT - 8, 'text-anchor': 'end' }, x));
  if (logarithmic) out.append(svg('text', { x: LEFT + 4, y: TOP + 9 }, 'log'));
  for (const { name, x: own, y, interval } of series) {
    const places = y.flatMap((value, i): [number, number, number][] => (value === null ? [] : [[(own ?? xs)[i], value, interval?.[i] ?? 0]]));
    const path = (values: number[]) => values.map((value, i) => `${i > 0 ? 'L' : 'M'}${px(places[i][0]).toFixed(1)} ${py(value).toFixed(1)}`).join('');
    const values = places.map(([, value]) => value);
    const noisy = places.length > NOISY;
    if (noisy) out.append(svg('path', { class: 'raw', d: path(values), stroke: color(name) }));
    out.append(svg('path', { class: 'curve', d: path(noisy ? smoothed(values) : values), stroke: color(name) }, svg('title', {}, readable(name))));
    if (places.length > 24) continue;
    for (const [at, value, half] of places) {
      if (half > 0 && (!logarithmic || value - half > 0)) out.append(svg('line', { class: 'whisker', stroke: color(name), x1: px(at), x2: px(at), y1: py(value - half), y2: py(value + half) }));
      out.append(svg('circle', { cx: px(at), cy: py(value), r: 2.6, fill: color(name) }, svg('title', {}, `${readable(name)}, ${at}: ${short(value)}`)));
    }
  }
  return out;
}

/** A bar for each series, tick by tick. */
function bars(panel: PanelData, color: (name: string) => string): SVGElement {
  const ticks = panel.ticks ?? [''];
  const rows = ticks.flatMap((tick, k) => panel.series.flatMap((one) => (one.y[k] === null ? [] : [{ tick, k, one, value: one.y[k] }])));
  const most = Math.max(...rows.map(({ value, one, k }) => Math.abs(value) + (one.interval?.[k] ?? 0)), 1e-12);
  const negative = rows.some(({ value }) => value < 0);
  const zero = negative ? WIDTH / 2 : 8;
  const reach = (negative ? WIDTH / 2 : WIDTH - 8) - 56;
  const several = ticks.length > 1;
  const height = 17;
  const out = svg('svg', { role: 'img', 'aria-label': summary(panel) });
  let y = 4;
  rows.forEach(({ tick, k, one, value }, i) => {
    if (several && (i === 0 || rows[i - 1].tick !== tick)) {
      out.append(svg('text', { x: 8, y: y + 12 }, readable(tick)));
      y += 17;
    }
    const end = zero + (value / most) * reach;
    const half = ((one.interval?.[k] ?? 0) / most) * reach;
    out.append(svg('rect', { x: Math.min(zero, end), y, width: Math.max(1, Math.abs(end - zero)), height: height - 4, rx: 2, fill: color(one.name) },
      svg('title', {}, `${readable(one.name)}: ${short(value)}${half > 0 ? ` ± ${short(one.interval![k])}` : ''}`)));
    if (half > 0) out.append(svg('line', { class: 'whisker ink', x1: end - half, x2: end + half, y1: y + 6.5, y2: y + 6.5 }));
    out.append(svg('text', { x: Math.max(zero, end + half) + 5, y: y + 11 }, short(value)));
    y += height;
  });
  out.setAttribute('viewBox', `0 0 ${WIDTH} ${y + 4}`);
  return out;
}

function summary({ title, series, ticks }: PanelData): string {
  const said = series.slice(0, 6).map(({ name, y }) => {
    const known = y.filter((value) => value !== null);
    if (known.length === 0) return `${readable(name)} unknown`;
    if (known.length === 1) return `${readable(name)} ${short(known[0])}`;
    return `${readable(name)} from ${short(known[0])} to ${short(known.at(-1)!)}${ticks ? '' : `, lowest ${short(Math.min(...known))}`}`;
  });
  return `${readable(title)}: ${said.join('; ')}`;
}

/** The panels' numbers in words: curves by their first, lowest and last values. */
function table(panels: PanelData[]): HTMLElement {
  const rows: string[][] = [];
  for (const { title, ticks, series } of panels) for (const { name, y, interval } of series) {
    const known = y.filter((value) => value !== null);
    const value = (i: number) => (y[i] === null ? '–' : short(y[i]) + ((interval?.[i] ?? 0) > 0 ? ` ± ${short(interval![i])}` : ''));
    const cells = ticks ? ticks.map((tick, i) => (ticks.length > 1 ? `${readable(tick)} ` : '') + value(i))
      : known.length === 0 ? [] : [`first ${short(known[0])}`, `lowest ${short(Math.min(...known))}`, `last ${short(known.at(-1)!)}`];
    rows.push([readable(title), readable(name), cells.join(', ')]);
  }
  const head = make('tr', {}, ...['What', 'Of', 'Value'].map((text) => make('th', { scope: 'col', textContent: text })));
  return make('details', {}, make('summary', { textContent: 'Numbers' }),
    make('div', { className: 'wide', tabIndex: 0, role: 'group', ariaLabel: 'Numbers' }, make('table', {}, make('thead', {}, head), make('tbody', {}, ...rows.map((row) => make('tr', {}, ...row.map((cell) => make('td', { textContent: cell }))))))));
}

// Told apart by hue and lightness, on light and on dark ground.
const TONES = ['#2f74d6', '#d9730d', '#2a9265', '#c0418f', '#8a63d2', '#a8851a', '#c94b3f', '#2794a8', '#6d7f2c', '#7a7f89'];

/** All panels of a chart, and the numbers below; of several groups the one that is chosen. */
export function chartOf(chart: ChartData): HTMLElement {
  const groups = [...new Set(chart.panels.map(({ group }) => group))];
  const names = [...new Set(chart.panels.flatMap(({ series }) => series.map(({ name }) => name)))];
  const color = (name: string) => TONES[names.indexOf(name) % TONES.length];
  const inside = make('div', { className: 'panels' });
  const numbersBelow = make('div');
  const draw = (group: string) => {
    const panels = chart.panels.filter((panel) => panel.group === group && numbers(panel.series).length > 0);
    inside.replaceChildren(...panels.map((panel) => make('figure', {}, make('figcaption', { textContent: readable(panel.title) }),
      panel.bars ? bars(panel, color) : curves(panel, chart.x, color))));
    numbersBelow.replaceChildren(table(panels));
  };
  const keys = names.map((name) => {
    const dot = make('i');
    dot.style.background = color(name);
    return make('span', {}, dot, readable(name));
  });
  const out = make('div', { className: 'chart' });
  if (groups.length > 1) {
    const select = make('select', { ariaLabel: 'Which rows' }, ...groups.map((group) => new Option(readable(group), group)));
    select.onchange = () => draw(select.value);
    out.append(select);
  }
  out.append(make('p', { className: 'key' }, ...keys), inside, numbersBelow);
  draw(groups[0]);
  return out;
}
