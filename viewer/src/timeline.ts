import { actionTones, css } from './colors';
import { element } from './dom';
import type { Person } from './person';

const PLAY = '<svg viewBox="0 0 16 16" aria-hidden="true"><path d="M4 2.2v11.6c0 .5.5.8.9.5l9-5.8c.4-.2.4-.8 0-1l-9-5.8c-.4-.3-.9 0-.9.5z"/></svg>';
const PAUSE = '<svg viewBox="0 0 16 16" aria-hidden="true"><rect x="3" y="2" width="3.6" height="12" rx="1"/><rect x="9.4" y="2" width="3.6" height="12" rx="1"/></svg>';

/** The time that is shown: slider, clock, play button and speed, and beside them who is there when and what they do. */
export class Timeline {
  readonly begin: number; // seconds
  readonly end: number;
  readonly rate: number; // frames a second
  time: number;
  playing = false;
  private readonly slider = element<HTMLInputElement>('time');
  private readonly speed = element<HTMLSelectElement>('speed');
  private readonly clock = document.createTextNode('');
  private readonly frame = document.createElement('small');
  private readonly actions: { from: number; to: number; mark: HTMLElement }[] = [];

  constructor(people: Person[], private readonly onChange: () => void) {
    this.begin = this.time = Math.min(0, ...people.map((person) => person.start));
    this.end = Math.max(this.begin + 1e-3, ...people.map((person) => person.end));
    this.rate = people[0]?.data_.rate ?? 30;
    this.slider.min = String(this.begin);
    this.slider.max = String(this.end);
    this.slider.oninput = () => {
      this.setPlaying(false);
      this.setTime(Number(this.slider.value));
    };
    element('clock').replaceChildren(this.clock, this.frame);
    element('play').onclick = () => this.setPlaying(!this.playing);
    this.markPeople(people);
    this.markActions(people);
    this.show();
  }

  setTime(t: number) {
    this.time = Math.min(Math.max(t, this.begin), this.end);
    this.show();
    this.onChange();
  }

  setPlaying(on: boolean) {
    if (on && this.time >= this.end - 1e-6) this.time = this.begin;
    this.playing = on;
    const button = element('play');
    button.innerHTML = on ? PAUSE : PLAY;
    button.setAttribute('aria-label', on ? 'Pause' : 'Play');
    this.onChange();
  }

  /** So many frames on, and stands still there. */
  step(frames: number) {
    this.setPlaying(false);
    this.setTime(this.begin + (Math.round((this.time - this.begin) * this.rate) + frames) / this.rate);
  }

  /** While it plays, `seconds` have gone by. */
  advance(seconds: number) {
    if (!this.playing) return;
    const { begin, end } = this;
    const time = this.time + seconds * Number(this.speed.value);
    this.setTime(time > end ? begin + ((time - begin) % (end - begin)) : time);
  }

  private show() {
    const { time, begin, end, rate } = this;
    this.slider.value = String(time);
    this.clock.data = `${time.toFixed(2)} s`;
    this.slider.setAttribute('aria-valuetext', `${time.toFixed(2)} seconds of ${end.toFixed(2)}`);
    this.frame.textContent = `frame ${Math.round((time - begin) * rate)} / ${Math.round((end - begin) * rate)}`;
    for (const { from, to, mark } of this.actions) mark.classList.toggle('now', time >= from && time < to);
  }

  private place(node: HTMLElement, from: number, to: number) {
    node.style.left = `${(100 * (from - this.begin)) / (this.end - this.begin)}%`;
    node.style.width = `${(100 * (to - from)) / (this.end - this.begin)}%`;
  }

  /** A line where people are there; of several over the same time the first one's colour. */
  private markPeople(people: Person[]) {
    const roles = new Set(people.map((person) => person.data_.role));
    const halves = roles.has('truth') && roles.has('prediction'); // upper and lower half of the line
    const covered = new Set<string>();
    people.forEach((person, i) => {
      const { role } = person.data_;
      if (role === 'intention') return; // starts over
      const key = `${role} ${person.start} ${person.end}`;
      if (covered.has(key)) return;
      covered.add(key);
      const span = document.createElement('i');
      if (halves && (role === 'truth' || role === 'prediction')) {
        span.style.height = '50%';
        if (role === 'prediction') span.style.top = '50%';
      }
      span.style.background = css(person.color);
      // Up to where the next motion begins, so that no gap of one frame shows.
      const next = people.find((other, k) => k !== i && Math.abs(other.start - person.end) < 2 / this.rate);
      this.place(span, person.start, next ? Math.max(next.start, person.end) : person.end);
      element('spans').append(span);
    });
  }

  /** Names of actions, of one person at a time. */
  private markActions(people: Person[]) {
    const tones = new Map<string, string>();
    let labelled = -Infinity;
    for (const person of [...people].sort((p, r) => p.start - r.start)) {
      const { actions, rate, frames } = person.data_;
      if (!actions || person.start < labelled - 1e-6) continue;
      labelled = person.end;
      actions.spans.forEach(([first, label], k) => {
        const name = actions.names[label];
        if (!name) return;
        const last = k + 1 === actions.spans.length;
        const from = person.start + first / rate;
        const to = person.start + (last ? frames - 1 : actions.spans[k + 1][0]) / rate;
        const mark = document.createElement('span');
        if (!tones.has(name)) tones.set(name, actionTones[tones.size % actionTones.length]);
        mark.style.backgroundColor = tones.get(name)!;
        mark.textContent = mark.title = name.replace(/_/g, ' ');
        this.place(mark, from, to);
        element('actions').append(mark);
        this.actions.push({ from, to: last ? to + 1e-3 : to, mark });
      });
    }
  }
}
