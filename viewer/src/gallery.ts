import * as THREE from 'three';
import { intentionColors } from './colors';
import type { Header } from './data';
import { isFigure, Person } from './person';
import type { Stage } from './stage';
import { Strip, stripOfPerson, Strips, stripsOfRecordings } from './strips';
import { Wall } from './wall';

const LEAST_HEIGHT = 120; // pixels
const NEAR = 45; // pixels from the pointer to a figure that it chooses

/** Many small figures: side by side, or overlaid where they go; and the strips of their intentions. */
export class Gallery {
  /** Side by side. */
  apart = true;
  /** The camera is placed for all figures; false once it has been moved by hand. */
  automatic = true;
  /** Only overlaid futures go anywhere. */
  readonly canOverlay: boolean;
  private readonly figures: Person[];
  private readonly colors: string[];
  private readonly wall: Wall;
  private readonly strips?: Strips;
  private readonly stripOf = new Map<Person, number>();
  private hovered?: Person;
  private chosen?: Person;
  private reach = 0;
  private readonly gone = new AbortController();
  private readonly free = { left: 0, top: 0, right: 1, bottom: 1 };
  private readonly target = new THREE.Vector3();
  private readonly v = new THREE.Vector3();
  private readonly root = new THREE.Vector3();

  constructor(header: Header, private readonly people: Person[], private readonly stage: Stage, private readonly heading: number,
    ground: number, begin: number, end: number, private readonly names: HTMLElement, apart: boolean, private readonly changed: () => void) {
    this.figures = people.filter((person) => isFigure(person.data_));
    this.canOverlay = this.figures.every((person) => person.data_.role === 'future');
    const recordings = stripsOfRecordings(header.recordings);
    const own = this.figures.filter((person) => person.data_.intentions);
    own.forEach((person, i) => this.stripOf.set(person, i));
    const rows: Strip[] = recordings.length > 0 ? recordings : own.map((person) => stripOfPerson(person.data_));
    const labels = [...rows, ...own.map((person) => stripOfPerson(person.data_))].flatMap(({ parts }) => parts.map(({ label }) => label));
    const used = [...new Set(labels)].sort((a, b) => a - b);
    this.colors = intentionColors((used.at(-1) ?? -1) + 1);

    const past = people.find((person) => person.data_.role === 'past');
    const floors = this.figures.map((person) => this.canOverlay ? ground : lowest(person));
    this.figures.forEach((person, i) => {
      if (past && past.parents.length === person.parents.length) person.past = past;
      person.labelColors = this.colors;
      person.setFloor(floors[i] + 0.004);
    });
    this.wall = new Wall(this.figures, heading + 0.6, floors, names);

    if (rows.length > 0) {
      const last = recordings.length > 0 ? Math.max(...rows.map(({ parts }) => parts.at(-1)!.to)) : end;
      this.strips = new Strips(rows, recordings.length > 0 ? 0 : begin, last, this.colors, recordings.length === 0);
      document.getElementById(recordings.length > 0 ? 'bar' : 'line')!.append(this.strips.element);
      if (recordings.length === 0) {
        this.strips.onHover = (row) => this.hover(own[row]);
        this.strips.onPick = (row) => this.choose(own[row]);
        this.addKey(used);
      }
    }
    this.watchPointer();
    stage.controls.addEventListener('start', this.taken);
    stage.controls.maxDistance = 150;
    this.setApart(apart || !this.canOverlay);
  }

  /** The camera is moved by hand. */
  private readonly taken = () => {
    this.automatic = false;
    this.changed();
  };

  /** Lets go of the stage, which shows something else next. */
  end() {
    this.gone.abort();
    this.stage.controls.removeEventListener('start', this.taken);
  }

  /** Who was chosen, if anybody. */
  get picked() {
    return this.chosen;
  }

  setApart(on: boolean) {
    this.apart = on;
    this.automatic = true;
    this.names.hidden = !on;
    this.stage.setLens(on ? 14 : 36);
    if (!on) for (const person of this.figures) person.group.position.set(0, 0, 0);
    this.emphasise();
  }

  isVisible(person: Person, time: number) {
    if (!isFigure(person.data_)) return !this.apart && person.enabled && time <= person.end + 0.5 / person.data_.rate;
    return person.enabled && time >= (this.apart && person.past ? person.past.start : person.start) - 1e-6;
  }

  showsTrail(person: Person) {
    const active = this.hovered ?? this.chosen;
    return !this.apart && person.enabled && (active === undefined || active === person || !isFigure(person.data_));
  }

  setTime(time: number) {
    if (this.apart) this.wall.place();
    this.strips?.setTime(time);
  }

  choose(person?: Person) {
    this.chosen = person === this.chosen ? undefined : person;
    this.emphasise();
  }

  redraw() {
    this.strips?.draw();
  }

  /** Fits the wall to what the controls leave free of the window. */
  resize(width: number, height: number) {
    const box = (id: string) => document.getElementById(id)!.getBoundingClientRect();
    const [bar, tools, head] = ['bar', 'tools', 'head'].map(box);
    const below = tools.top > height / 2;
    this.free.top = (head.height > 0 ? head.bottom : 0) + 8;
    this.free.right = tools.width > 0 && !below ? tools.left - 8 : width;
    this.free.bottom = bar.height === 0 ? height : below ? tools.top : bar.top;
    if (this.free.bottom - this.free.top < LEAST_HEIGHT) this.free.top = 0; // behind the head rather than too small to see
    const { left, top, right, bottom } = this.free;
    this.wall.arrange((right - left) / Math.max(50, bottom - top));
    if (this.apart) this.stage.resize(width, height, width - right, height - bottom - top);
    else this.stage.resize(width, height, 0, height - bottom);
  }

  /** Places the camera, `seconds` after it was placed before, where it has not been moved by hand. */
  placeCamera(seconds: number, time: number) {
    const { stage, wall } = this;
    if (this.automatic && this.apart) {
      const { left, top, right, bottom } = this.free;
      const visible = 2 * Math.tan((stage.camera.fov * Math.PI) / 360); // heights of the window a metre away
      const size = Math.max(wall.height / Math.max(50, bottom - top), wall.width / (right - left)) * innerHeight;
      stage.look(wall.middle, (1.04 * size) / visible, this.heading + 0.6, 0.16);
    } else if (this.automatic) {
      const visible = Math.max(0.4, this.free.bottom / innerHeight);
      const active = this.hovered ?? this.chosen;
      const shown = active && this.isVisible(active, time) ? [active] : this.people.filter((person) => this.isVisible(person, time));
      if (shown.length > 0) {
        this.v.set(0, 0, 0);
        for (const { now } of shown) this.v.add(this.root.fromArray(now));
        this.v.divideScalar(shown.length);
        this.v.y -= 0.12; // from the root to the middle of the body
        const far = Math.max(...shown.map(({ now }) => Math.hypot(now[0] - this.v.x, now[2] - this.v.z)));
        const first = this.reach === 0;
        this.reach += (Math.min(1.5 + 0.8 * far, 14) - this.reach) * (first ? 1 : Math.min(1, 3 * seconds));
        this.target.lerp(this.v, first ? 1 : Math.min(1, 5 * seconds));
        stage.frame(this.target, this.reach / visible, this.heading);
      }
    }
    if (this.apart) return wall.placeLabels(stage.camera, innerWidth, innerHeight);
    // Seen through each other, from the farthest to the nearest; through all others, the one that stands out.
    const active = this.hovered ?? this.chosen;
    for (const person of this.figures) {
      const depth = -this.v.fromArray(person.now).applyMatrix4(stage.camera.matrixWorldInverse).z;
      person.renderOrder = person === active ? 2 : 10_000 - Math.round(10 * depth);
    }
  }

  private hover(person?: Person) {
    if (person === this.hovered) return;
    this.hovered = person;
    this.emphasise();
  }

  private emphasise() {
    const active = this.hovered ?? this.chosen;
    const usual = this.apart || this.figures.length === 1 ? 1 : this.figures.length > 12 ? 0.5 : 0.65;
    this.figures.forEach((person, i) => {
      person.setOpacity(active === undefined ? usual : person === active ? 1 : this.apart ? 0.3 : 0.12);
      person.castShadow = !this.apart && (active === undefined || person === active);
      this.wall.labels[i].classList.toggle('now', person === active);
    });
    if (this.strips && this.strips.active !== (this.strips.active = active ? this.stripOf.get(active) ?? -1 : -1)) this.strips.draw();
    this.changed();
  }

  /** Which colour is which intention, below the legend. */
  private addKey(labels: number[]) {
    const key = document.createElement('p');
    key.id = 'key';
    key.append('Intention');
    for (const label of labels) {
      const mark = document.createElement('b');
      mark.style.borderLeftColor = this.colors[label];
      mark.textContent = String(label);
      key.append(mark);
    }
    document.getElementById('head')!.append(key);
  }

  private watchPointer() {
    const canvas = this.stage.renderer.domElement;
    const { signal } = this.gone;
    let pressed = [0, 0];
    canvas.addEventListener('pointermove', (event) => event.buttons === 0 && this.canOverlay && this.hover(this.under(event)), { signal });
    canvas.addEventListener('pointerleave', () => this.hover(), { signal });
    canvas.addEventListener('pointerdown', (event) => (pressed = [event.clientX, event.clientY]), { signal });
    canvas.addEventListener('click', (event) => {
      if (this.canOverlay && Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) < 4) this.choose(this.under(event));
    }, { signal });
  }

  private under(event: MouseEvent): Person | undefined {
    let nearest = NEAR;
    let found: Person | undefined;
    for (const person of this.figures) {
      if (!person.group.visible) continue;
      this.v.fromArray(person.now).add(person.group.position).project(this.stage.camera);
      const away = Math.hypot(((this.v.x + 1) / 2) * innerWidth - event.clientX, ((1 - this.v.y) / 2) * innerHeight - event.clientY);
      if (away < nearest) [nearest, found] = [away, person];
    }
    return found;
  }
}

function lowest({ joints }: Person) {
  let y = Infinity;
  for (let i = 1; i < joints.length; i += 3) y = Math.min(y, joints[i]);
  return y;
}
