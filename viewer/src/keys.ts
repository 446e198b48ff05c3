import { Group, Mesh, MeshBasicMaterial, SphereGeometry, Vector3 } from 'three';
import { collisionColor, css, keyColor } from './colors';
import { Data } from './data';
import { Bodies, Person, Shape } from './person';

const maxCopies = 40;

/** One still key: the pose that was given, or marks where only some joints were. */
class Key {
  readonly group = new Group();
  private readonly marks: Mesh[] = [];
  private readonly pose?: Person;
  private readonly at: number; // time of the pose in what it is taken from

  constructor(data: Data, bodies: Bodies, of: Person, readonly time: number, index: number) {
    const { given, keys = [], ...filled } = of.data_;
    this.at = given ? given.start + index / given.rate : time;
    if (given?.only && index > 0 && index < keys.length - 1) {
      const joints = data.floats(given.joints!);
      const material = new MeshBasicMaterial({ color: keyColor });
      for (const joint of given.only) {
        const mark = new Mesh(new SphereGeometry(0.045, 16, 12), material);
        mark.position.fromArray(joints, 3 * (index * given.names.length + joint));
        this.marks.push(mark);
      }
      this.group.add(...this.marks);
      return;
    }
    this.pose = new Person(data, bodies, given ?? { ...filled, collides: undefined }, keyColor, 0.38);
    this.group.add(this.pose.group);
    this.group.traverse((part) => (part.castShadow = false));
  }

  show(shape: Shape) {
    this.pose?.show(shape);
    this.pose?.setTime(this.at);
  }

  /** World positions of what is given: of every joint, or of those that are. */
  places(): Vector3[] {
    const { pose } = this;
    return pose ? pose.parents.map((_, j) => pose.joint(j, new Vector3())) : this.marks.map((mark) => mark.getWorldPosition(new Vector3()));
  }
}

/** What is marked on a motion that was filled in: still copies at its key frames, ticks and stretches on the timeline. */
export class Keys {
  readonly still: Key[] = [];

  constructor(data: Data, bodies: Bodies, readonly of: Person, spans: HTMLElement, begin: number, end: number) {
    const { keys = [], collides = [], rate, frames } = of.data_;
    const percent = (frame: number) => (100 * (of.start + frame / rate - begin)) / (end - begin);
    const mark = (from: number, to: number, color: number, kind: string, title: string) => {
      const i = document.createElement('i');
      i.className = kind;
      i.title = title;
      i.style.left = `${from}%`;
      i.style.width = kind === 'key' ? '' : `${to - from}%`;
      i.style.background = css(color);
      spans.append(i);
    };
    collides.forEach(([first, inside, where], k) => {
      const last = collides[k + 1]?.[0] ?? frames - 1;
      if (inside) mark(percent(first), percent(last), collisionColor, 'collision', where ? `The body is inside the scene: ${where}` : 'The body is inside the scene');
    });
    for (const key of keys) mark(percent(key), percent(key), keyColor, 'key', `Key frame ${key}`);
    // Keys close together would hide the motion between them, and every copy holds the whole motion.
    const apart = Math.max(rate / 2, frames / maxCopies);
    let last = -Infinity;
    keys.forEach((key, index) => {
      if (key - last < apart && key !== keys.at(-1)) return;
      last = key;
      this.still.push(new Key(data, bodies, of, of.start + key / rate, index));
    });
  }

  show(shape: Shape) {
    for (const key of this.still) key.show(shape);
  }

  /** Copies of the motion's own poses stand aside where it is there itself. */
  setTime(t: number) {
    for (const { group, time } of this.still) {
      group.visible = this.of.enabled && (this.of.data_.given !== undefined || Math.abs(time - t) > 0.15);
      group.position.copy(this.of.group.position);
    }
  }
}
