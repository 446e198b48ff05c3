import { actionTones } from './colors';
import type { Data, PersonData, RecordingsData } from './data';

export interface Strip {
  name: string;
  group: string;
  parts: { from: number; to: number; label: number }[]; // seconds
  marked: [number, number][]; // seconds
  names?: string[]; // of labels, negative ones being nothing; written on the strip
  curve?: { start: number; rate: number; values: ArrayLike<number> }; // values of 0 to 255
}

function strip(name: string, group: string, start: number, rate: number, frames: number, spans: [number, number][]): Strip {
  const parts = spans.map(([first, label], k) => ({
    from: start + first / rate, to: start + (k + 1 < spans.length ? spans[k + 1][0] : frames) / rate, label,
  }));
  return { name, group, parts, marked: [] };
}

export const stripOfPerson = (person: PersonData) =>
  strip(person.name, '', person.start, person.rate, person.frames, person.intentions ?? []);

/** Rows of one group stand together, groups in the order of their first rows. */
export function stripsOfRecordings(recordings?: RecordingsData): Strip[] {
  const { rate, rows } = recordings ?? { rate: 1, rows: [] };
  const groups = [...new Set(rows.map(({ group }) => group))];
  return groups.flatMap((group) => rows.filter((row) => row.group === group)).map(({ name, group, frames, spans, marked }) => ({
    ...strip(name, group, 0, rate, frames, spans), marked: marked.map(([a, b]): [number, number] => [a / rate, b / rate]),
  }));
}

/** What is known of every frame of a person: its tracks. */
export const stripsOfTracks = (data: Data, person: PersonData): Strip[] =>
  (person.tracks ?? []).map(({ name, values, names, spans }) => ({
    ...strip(name, '', person.start, person.rate, person.frames, spans ?? []), names: names ?? [],
    curve: values && { start: person.start, rate: person.rate, values: data.raw(values) },
  }));

const GAP = 10; // pixels between groups
const TALLEST = 10;
const NAMED = 14; // of strips that have their name on them

/** Strips of intention labels, one above the other; a row that is looked at is drawn taller. */
export class Strips {
  readonly element = document.createElement('div');
  /** Called with the row under the pointer, or -1; and with a row that was clicked. */
  onHover = (_row: number) => {};
  onPick = (_row: number) => {};
  active = -1;
  private readonly canvas = document.createElement('canvas');
  private readonly playhead = document.createElement('i');
  private readonly grouped: boolean;
  private tops: number[] = []; // pixels, one more than rows
  private height = 0;

  constructor(private readonly rows: Strip[], private readonly begin: number, private readonly end: number,
    private readonly colors: string[], playhead: boolean) {
    this.element.className = 'strips';
    this.grouped = rows.some((row) => row.group !== '');
    this.playhead.hidden = !playhead;
    const lanes = document.createElement('div');
    lanes.append(this.canvas, this.playhead);
    this.element.append(lanes);
    if (this.grouped) {
      this.element.classList.add('grouped');
      const scale = document.createElement('p');
      for (const text of ['0 s', `${(end - begin).toFixed(0)} s`]) scale.append(Object.assign(document.createElement('span'), { textContent: text }));
      this.element.append(scale);
    }
    this.measure();
    rows.forEach((row, i) => {
      if (!this.startsGroup(i)) return;
      const name = document.createElement('b');
      name.textContent = name.title = row.group.replace(/_/g, ' ');
      name.style.top = `${this.tops[i]}px`;
      lanes.append(name);
    });
    this.canvas.onpointermove = (event) => this.hover(this.rowAt(event.offsetY), event.offsetX);
    this.canvas.onpointerleave = () => this.hover(-1, 0);
    this.canvas.onclick = (event) => this.onPick(this.rowAt(event.offsetY));
    new ResizeObserver(() => this.draw()).observe(lanes);
  }

  setTime(t: number) {
    this.playhead.style.left = `${(100 * (t - this.begin)) / (this.end - this.begin)}%`;
  }

  draw() {
    this.measure();
    const width = this.canvas.parentElement!.clientWidth;
    if (width === 0) return;
    const ratio = Math.min(devicePixelRatio, 2);
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(this.height * ratio);
    this.canvas.style.height = `${this.height}px`;
    const context = this.canvas.getContext('2d')!;
    context.scale(ratio, ratio);
    const x = (t: number) => ((t - this.begin) / (this.end - this.begin)) * width;
    this.rows.forEach((row, i) => {
      const top = this.tops[i];
      const height = this.rowHeight(i);
      const gap = height > 5 ? 1 : height > 3 ? 0.5 : 0;
      context.globalAlpha = this.active < 0 || this.active === i ? 1 : 0.4;
      if (row.names) this.drawNamed(context, row, row.names, x, top, height - gap, width);
      else for (const { from, to, label } of row.parts) {
        context.fillStyle = this.colors[label];
        context.fillRect(x(from), top, x(to) - x(from), height - gap);
      }
      context.globalAlpha = 1;
      context.strokeStyle = getComputedStyle(this.element).color;
      context.lineWidth = 1.5;
      for (const [from, to] of row.marked) context.strokeRect(x(from), top, x(to) - x(from), height - gap);
    });
  }

  /** A curve or stretches with their names, and the strip's own name at its left end. */
  private drawNamed(context: CanvasRenderingContext2D, row: Strip, names: string[], x: (t: number) => number, top: number,
    height: number, width: number) {
    const ink = getComputedStyle(this.element).color;
    const tone = actionTones[this.rows.indexOf(row) % actionTones.length];
    context.fillStyle = ink;
    context.globalAlpha = 0.07;
    context.fillRect(0, top, width, height);
    context.globalAlpha = 1;
    context.font = '500 10px system-ui, sans-serif';
    context.textBaseline = 'middle';
    const middle = top + height / 2 + 0.5;
    const left = context.measureText(row.name).width + 10;
    context.fillStyle = tone;
    if (row.curve) {
      const { start, rate, values } = row.curve;
      context.beginPath();
      context.moveTo(x(start), top + height);
      for (let f = 0; f < values.length; ++f) context.lineTo(x(start + f / rate), top + height - (values[f] / 255) * height);
      context.lineTo(x(start + (values.length - 1) / rate), top + height);
      context.fill();
    }
    for (const { from, to, label } of row.parts) {
      if (label < 0) continue;
      context.fillStyle = names.length > 1 ? actionTones[label % actionTones.length] : tone;
      context.fillRect(x(from), top, x(to) - x(from), height);
      const at = Math.max(x(from) + 4, left);
      if (x(to) - at < context.measureText(names[label]).width + 4) continue;
      context.fillStyle = '#222';
      context.fillText(names[label], at, middle);
    }
    context.globalAlpha = 0.85; // over whatever colour is there
    context.fillStyle = getComputedStyle(document.documentElement).getPropertyValue('--ground');
    context.fillRect(0, top, left - 2, height);
    context.globalAlpha = 1;
    context.fillStyle = ink;
    context.fillText(row.name, 4, middle);
  }

  private startsGroup(i: number) {
    return this.grouped && (i === 0 || this.rows[i].group !== this.rows[i - 1].group);
  }

  private rowHeight(i: number) {
    if (this.grouped) return 8;
    if (this.rows[i].names) return NAMED;
    const n = this.rows.length;
    const even = Math.max(1.5, Math.min(TALLEST, 100 / n));
    return i === this.active ? TALLEST : this.active < 0 || n < 2 ? even : (n * even - TALLEST) / (n - 1);
  }

  private measure() {
    this.tops = [];
    let y = 0;
    let groupTop = 0;
    for (let i = 0; i < this.rows.length; ++i) {
      if (i > 0 && this.startsGroup(i)) y = Math.max(y + GAP / 2, groupTop + 16); // room for the group's name
      if (this.startsGroup(i)) groupTop = y;
      this.tops.push(y);
      y += this.rowHeight(i);
    }
    this.height = this.grouped ? Math.max(y, groupTop + 16) : y;
    this.tops.push(y);
  }

  private rowAt(y: number) {
    for (let i = 0; i < this.rows.length; ++i) if (y >= this.tops[i] && y < this.tops[i] + this.rowHeight(i)) return i;
    return -1;
  }

  private hover(row: number, x: number) {
    const t = this.begin + (x / this.canvas.clientWidth) * (this.end - this.begin);
    const part = this.rows[row]?.parts.find(({ from, to }) => t >= from && t < to);
    const { name, names, curve } = this.rows[row] ?? {};
    let what = part ? `intention ${part.label}` : '';
    if (names) what = part && part.label >= 0 ? names[part.label] : '';
    if (curve) what = (curve.values[Math.min(Math.round((t - curve.start) * curve.rate), curve.values.length - 1)] / 255 || 0).toFixed(2);
    this.canvas.title = row < 0 ? '' : name + (what ? ` · ${what} · ${t.toFixed(1)} s` : '');
    this.onHover(row);
  }
}
