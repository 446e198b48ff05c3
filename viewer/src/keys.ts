import { collisionColor, css, keyColor } from './colors';
import { Data } from './data';
import { Bodies, Person, Shape } from './person';

const maxCopies = 40;

/** What is marked on a motion that was filled in: still blue copies at its key frames, ticks and stretches on the timeline. */
export class Keys {
  readonly copies: Person[] = [];
  private readonly times: number[] = [];

  constructor(data: Data, bodies: Bodies, readonly of: Person, spans: HTMLElement, begin: number, end: number) {
    const { keys = [], collides = [], rate, frames } = of.data_;
    const share = (frame: number) => (100 * (of.start + frame / rate - begin)) / (end - begin);
    const mark = (from: number, to: number, color: number, kind: string, title: string) => {
      const i = document.createElement('i');
      i.className = kind;
      i.title = title;
      i.style.left = `${from}%`;
      i.style.width = kind === 'key' ? '' : `${to - from}%`;
      i.style.background = css(color);
      spans.append(i);
    };
    collides.forEach(([first, inside], k) => {
      const last = collides[k + 1]?.[0] ?? frames - 1;
      if (inside) mark(share(first), share(last), collisionColor, 'collision', 'The body is inside the scene');
    });
    for (const key of keys) mark(share(key), share(key), keyColor, 'key', `Key frame ${key}`);
    // Keys close together would hide the motion between them, and every copy holds the whole motion.
    const apart = Math.max(rate / 2, frames / maxCopies);
    let last = -Infinity;
    for (const key of keys) {
      if (key - last < apart && key !== keys.at(-1)) continue;
      last = key;
      const copy = new Person(data, bodies, { ...of.data_, keys: undefined, collides: undefined }, keyColor, 0.38);
      copy.group.traverse((part) => (part.castShadow = false));
      this.copies.push(copy);
      this.times.push(of.start + key / rate);
    }
  }

  show(shape: Shape) {
    this.copies.forEach((copy, i) => {
      copy.show(shape);
      copy.setTime(this.times[i]);
    });
  }

  /** Copies stand aside where the motion itself is at their pose. */
  setTime(t: number) {
    this.copies.forEach((copy, i) => {
      copy.group.visible = this.of.enabled && Math.abs(this.times[i] - t) > 0.15;
      copy.group.position.copy(this.of.group.position);
    });
  }
}
