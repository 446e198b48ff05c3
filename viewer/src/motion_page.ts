import { Box3, Group, Vector3 } from 'three';
import { Contacts } from './contacts';
import { Data } from './data';
import { element, press } from './dom';
import { Gallery } from './gallery';
import { Ghosts } from './ghosts';
import type { Hooks } from './hooks';
import { Keys } from './keys';
import { makeLegend } from './legend';
import { Menu } from './menu';
import { extentOf, facing, groundUnder, makePeople } from './people';
import { Bodies, isFigure, Person, Shape } from './person';
import { Room } from './room';
import { Stage, Theme } from './stage';
import { Strips, stripsOfTracks } from './strips';
import { Timeline } from './timeline';
import { makeTrails } from './trails';

/** People in a room over time, and the controls to look at them. */
export class MotionPage {
  private readonly stage = new Stage(element<HTMLCanvasElement>('view'));
  private readonly room: Room;
  private readonly people: Person[];
  private readonly timeline: Timeline;
  private readonly ground: number;
  private readonly extent: Box3;
  private readonly middle: Vector3;
  private readonly trails: Group[];
  private readonly ghosts: Ghosts;
  private readonly keyed: Keys[];
  private readonly contacts?: Contacts;
  private readonly gallery?: Gallery;
  private readonly strips?: Strips;
  private readonly menu = new Menu(() => this.repose());
  private readonly focus = new Vector3();
  private following = true;
  private showsTrails = true;
  private apart = false;
  private shape: Shape;
  private theme: Theme = matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : 'light';
  private dirty = true;
  private painted = NaN; // time the scene was last posed at

  constructor(data: Data, private readonly framed: boolean) {
    const { header } = data;
    const { scene } = this.stage;
    const bodies = new Bodies(data);
    this.room = new Room(data);
    scene.add(this.room.group);

    const figures = header.people.some(isFigure);
    this.people = makePeople(data, bodies);
    for (const person of this.people) scene.add(person.group);
    this.shape = this.people.some((person) => person.hasBody) ? 'body' : 'skeleton';
    this.timeline = new Timeline(this.people, () => (this.dirty = true));
    const { begin, end } = this.timeline;

    this.ground = groundUnder(this.people);
    this.extent = extentOf(this.people);
    if (this.extent.isEmpty()) this.extent.copy(this.room.box);
    this.middle = this.extent.getCenter(new Vector3());
    this.stage.setGround(this.ground, this.middle, Math.max(6, this.extent.getSize(new Vector3()).length() / 2 + 4), !this.room.hasFloor);

    this.ghosts = new Ghosts(data, bodies, this.people, scene, end - begin);
    this.keyed = this.people.filter((person) => person.data_.keys)
      .map((person) => new Keys(data, bodies, person, element('spans'), begin, end));
    for (const { still } of this.keyed) for (const key of still) scene.add(key.group);
    this.trails = this.people.map((person) => makeTrails(person, this.ground, !figures));
    this.trails.forEach((trail, i) => this.people[i].group.add(trail));
    if (header.contacts) {
      this.contacts = new Contacts(data, header.contacts);
      scene.add(this.contacts.points.object);
    }
    if (figures) {
      this.gallery = new Gallery(header, this.people, this.stage, this.heading(), this.ground, begin, end, element('names'),
        () => this.repose());
    }

    const tracked = header.people.find((person) => person.tracks);
    if (tracked) {
      this.strips = new Strips(stripsOfTracks(data, tracked), begin, end, [], true);
      this.strips.element.classList.add('tracks');
      element('line').append(this.strips.element);
    }

    makeLegend(this.people, () => this.repose());
    element('note').textContent = header.note;
    this.addControls();
    this.setTheme(this.theme);
    this.resize();
    addEventListener('resize', () => this.resize());
    this.stage.controls.addEventListener('change', () => (this.dirty = true));
    this.lookFirst(header.scene ? 1.6 : 1.35);
  }

  /** Draws the first picture, and from now on whatever changes. */
  begin() {
    this.timeline.setPlaying(this.framed);
    this.drawSettled();
    let before = performance.now();
    const tick = (now: number) => {
      const seconds = Math.min(0.1, (now - before) / 1000);
      before = now;
      this.timeline.advance(seconds);
      this.stage.controls.update();
      if (this.dirty) this.dirty = this.draw(seconds);
      requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  hooks(): Omit<Hooks, 'ready' | 'error'> {
    const { timeline, people } = this;
    return {
      duration: timeline.end - timeline.begin,
      people: people.map((person) => person.data_.name),
      setTime: (t) => {
        timeline.setPlaying(false);
        timeline.setTime(t);
        this.drawSettled();
      },
      time: () => timeline.time,
      play: () => timeline.setPlaying(true),
      pause: () => timeline.setPlaying(false),
      playing: () => timeline.playing,
      setShape: (shape) => this.setShape(shape),
      setFollow: (on) => this.setFollowing(on),
      setGhosts: (on) => {
        this.setGhosts(on);
        press('ghosts', on);
      },
      setTheme: (theme) => this.setTheme(theme),
      setJoint: (name) => this.chooseJoint(this.contacts ? this.contacts.names.indexOf(name) : -1),
      setCamera: (x, y, z, target) => {
        this.following = false;
        if (this.gallery) this.gallery.automatic = false;
        if (target) this.stage.controls.target.fromArray(target);
        this.stage.camera.position.set(x, y, z);
        this.stage.controls.update();
        this.dirty = true;
      },
      jointPositions: (i) => people[i].parents.map((_, j) => people[i].joint(j, new Vector3()).toArray()),
      keyPlaces: () => this.keyed.flatMap(({ still }) => still.map((key) => key.places().map((place) => place.toArray()))),
      visible: (i) => this.isVisible(people[i]),
      setApart: (on) => {
        if (this.gallery && this.gallery.apart !== on) element('spread').click();
      },
      choose: (i) => this.gallery?.choose(people[i]),
    };
  }

  private heading() {
    return this.people.length > 0 ? facing(this.people[0]) : 0.5;
  }

  /** Something other than the time has changed. */
  private repose() {
    this.painted = NaN;
    this.dirty = true;
  }

  private addControls() {
    const { menu, timeline, people, gallery } = this;
    for (const key of [' ', 'k']) menu.on(key, () => timeline.setPlaying(!timeline.playing));
    menu.on('arrowright', () => timeline.step(1));
    menu.on('arrowleft', () => timeline.step(-1));
    menu.on('home', () => timeline.setTime(timeline.begin));
    menu.on('end', () => timeline.setTime(timeline.end));

    menu.toggle('shape', 'b', () => {
      this.setShape(this.shape === 'body' ? 'skeleton' : 'body');
      return false;
    }).hidden = !people.some((person) => person.hasBody);
    this.setShape(this.shape);
    menu.toggle('follow', 'f', () => {
      if (gallery) return (gallery.automatic = !gallery.automatic);
      return (this.following = !this.following);
    });
    menu.toggle('trails', 't', () => (this.showsTrails = !this.showsTrails));
    press('trails', true);
    menu.toggle('ghosts', 'g', () => {
      this.setGhosts(!this.ghosts.on);
      return this.ghosts.on;
    }).hidden = gallery !== undefined || people.length > 8;
    menu.toggle('spread', 's', () => this.setApart()).hidden = people.length < 2;
    if (gallery) {
      press('spread', true);
      this.stage.showGround(false);
      for (const id of ['follow', 'trails', 'spread']) element(id).hidden = !gallery.canOverlay;
    }
    menu.toggle('theme', 'd', () => {
      this.setTheme(this.theme === 'dark' ? 'light' : 'dark');
      return false;
    });

    if (this.contacts) {
      const select = element<HTMLSelectElement>('joint');
      element('joint-label').hidden = false;
      select.append(new Option('off', '-1'));
      this.contacts.names.forEach((name, j) => select.append(new Option(name.replace(/_/g, ' '), String(j))));
      select.onchange = () => this.chooseJoint(Number(select.value));
      this.chooseJoint(this.contacts.busiest());
    }
  }

  private setShape(next: Shape) {
    this.shape = this.people.some((person) => person.hasBody) ? next : 'skeleton';
    const button = element('shape');
    button.textContent = this.shape === 'body' ? 'Skeleton' : 'Body';
    button.title = (this.shape === 'body' ? 'Show the skeleton' : 'Show the body') + ' (B)';
    for (const marks of this.keyed) marks.show(this.shape);
    this.ghosts.show(this.shape);
    this.repose();
  }

  private setFollowing(on: boolean) {
    this.following = on;
    press('follow', on);
    this.dirty = true;
  }

  private setGhosts(on: boolean) {
    this.ghosts.setOn(on, this.shape);
    this.repose();
  }

  /** Side by side, or back where they go. */
  private setApart() {
    const { gallery, people, middle } = this;
    if (gallery) {
      gallery.setApart(!gallery.apart);
      this.stage.showGround(!gallery.apart && !this.room.hasFloor);
      this.resize();
      return gallery.apart;
    }
    this.apart = !this.apart;
    const columns = Math.ceil(Math.sqrt(people.length * 1.6));
    people.forEach((person, i) => {
      const x = ((i % columns) - (columns - 1) / 2) * 1.6;
      const z = -Math.floor(i / columns) * 1.8;
      if (this.apart) person.group.position.set(middle.x + x - person.joints[0], 0, middle.z + z - person.joints[2]);
      else person.group.position.set(0, 0, 0);
    });
    return this.apart;
  }

  private setTheme(next: Theme) {
    this.theme = next;
    document.documentElement.dataset.theme = next;
    element('theme').textContent = next === 'dark' ? 'Light' : 'Dark';
    this.stage.setTheme(next);
    this.gallery?.redraw();
    this.strips?.draw();
    this.dirty = true;
  }

  private chooseJoint(j: number) {
    this.contacts?.choose(j);
    element('scale').hidden = j < 0;
    element<HTMLSelectElement>('joint').value = String(j);
    this.repose();
  }

  private resize() {
    const width = innerWidth;
    const height = innerHeight;
    this.dirty = true;
    const bar = element('bar').getBoundingClientRect();
    document.documentElement.style.setProperty('--bar-top', `${height - bar.top}px`);
    if (this.gallery) return this.gallery.resize(width, height);
    const pixels = this.stage.resize(width, height, 0, this.framed ? 0 : height - bar.top);
    this.contacts?.points.setHeight(pixels);
    this.room.points?.setHeight(pixels);
  }

  /** A person is there from its first frame on; an observed past leaves when what comes after it starts. */
  private isVisible(person: Person) {
    const { time, rate } = this.timeline;
    if (this.gallery) return this.gallery.isVisible(person, time);
    const goesOn = person.data_.role === 'past' && this.people.some((other) => other.start > person.start);
    return person.enabled && time >= person.start - 1e-6 && !(goesOn && time > person.end + 0.5 / rate);
  }

  /** Brings everything to the time and the state. */
  private pose() {
    const { time } = this.timeline;
    this.people.forEach((person, i) => {
      person.group.visible = person.enabled;
      const there = this.isVisible(person);
      for (const child of person.group.children) child.visible = there;
      this.trails[i].visible = person.enabled && this.showsTrails && (!this.gallery || this.gallery.showsTrail(person));
      if (!there) return;
      person.show(this.shape);
      person.setTime(time);
    });
    this.ghosts.follow();
    for (const keys of this.keyed) keys.setTime(time);
    this.gallery?.setTime(time);
    this.strips?.setTime(time);
    this.contacts?.setTime(time);
    this.painted = time;
  }

  /** The middle of who is there, at the height of the chest. */
  private setFocus() {
    const there = this.people.filter((person) => this.isVisible(person));
    const { focus, ground } = this;
    focus.set(0, 0, 0);
    for (const person of there) {
      for (const [k, axis] of (['x', 'y', 'z'] as const).entries()) focus[axis] += person.now[k] + person.group.position[axis];
    }
    if (there.length > 0) focus.divideScalar(there.length);
    else focus.copy(this.middle);
    focus.y = Math.max(ground + 0.75, Math.min(focus.y, ground + 1.1)) * 0.95;
  }

  /** First view: the whole way if it is short, the first person otherwise. */
  private lookFirst(nearest: number) {
    this.pose();
    this.setFocus();
    const way = this.extent.getSize(new Vector3()).setY(0).length() * 0.36 + 0.85;
    const wanders = Math.max(nearest, way) >= 3.2;
    this.setFollowing(wanders);
    this.stage.frame(wanders ? this.focus : new Vector3(this.middle.x, this.ground + 0.82, this.middle.z),
      Math.min(3.2, Math.max(nearest, way)), this.heading());
  }

  /** @returns whether walls are still fading. */
  private draw(seconds: number) {
    const { stage, room, gallery, timeline } = this;
    if (this.painted !== timeline.time) this.pose();
    this.setFocus();
    if (gallery) {
      gallery.placeCamera(seconds, timeline.time);
      press('follow', gallery.automatic);
    } else if (this.following) stage.follow(this.focus, timeline.playing ? Math.min(1, seconds * 6) : 1);
    room.focus.value.copy(this.focus);
    stage.lightAround(this.focus);
    stage.controls.update();
    const fading = room.update(stage.camera, seconds);
    stage.render();
    return fading;
  }

  private drawSettled() {
    this.room.settle(this.stage.camera);
    this.draw(1);
  }
}
