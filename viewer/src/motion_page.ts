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
import { ObjectList } from './object_list';
import { Host, Panels } from './panels';
import { extentOf, facing, groundUnder, makePeople, placesOf } from './people';
import { Bodies, isFigure, Person, Shape } from './person';
import { Room } from './room';
import type { SceneObject } from './scene_objects';
import { Stage } from './stage';
import { Strips, stripsOfTracks } from './strips';
import { Tags } from './tags';
import { Timeline } from './timeline';
import { makeTrails } from './trails';

/** People in a room over time, and the controls to look at them. `end` takes it off the page again. */
export class MotionPage {
  private readonly stage: Stage;
  private readonly gone = new AbortController();
  private readonly watcher: ResizeObserver; // of what the view is fitted to
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
  private readonly menu = new Menu(() => this.repose(), this.gone.signal);
  private readonly tags?: Tags;
  private readonly objectList?: ObjectList;
  private panels?: Panels;
  private readonly focus = new Vector3();
  private following = true;
  private showsTrails = true;
  private apart = false;
  private shape: Shape;
  private dirty = true;
  private painted = NaN; // time the scene was last posed at

  constructor(private readonly data: Data, private readonly host: Host) {
    const { header } = data;
    this.stage = host.stage;
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
      // In a room it matters where people go; no room is around figures side by side.
      this.gallery = new Gallery(header, this.people, this.stage, this.heading(), this.ground, begin, end, element('names'),
        header.scene === undefined, () => this.repose());
    }

    const tracked = header.people.find((person) => person.tracks);
    if (tracked) {
      this.strips = new Strips(stripsOfTracks(data, tracked), begin, end, [], true);
      this.strips.element.classList.add('tracks');
      element('line').append(this.strips.element);
    }

    for (const { objects, start, rate } of header.people) if (objects) this.room.objects.move(data, objects, start, rate);
    if (this.room.objects.list.length > 0) this.objectList = new ObjectList(this.room.objects, (object) => this.bringIntoView(object));
    if (!figures && this.people.length > 1 && this.people.length <= 8) this.tags = new Tags(this.people, element('names'));

    makeLegend(this.people, () => this.repose());
    element('note').textContent = header.note;
    element('bar').hidden = this.people.length === 0;
    element('welcome').hidden = this.people.length > 0 || header.scene !== undefined;
    this.addControls();
    this.describe();
    this.themed();
    this.resize();
    const { signal } = this.gone;
    addEventListener('resize', () => this.resize(), { signal });
    this.watcher = new ResizeObserver(() => this.resize());
    for (const id of ['bar', 'tools']) this.watcher.observe(element(id));
    this.stage.controls.addEventListener('change', this.moved);
    this.lookFirst(header.scene ? 1.6 : 1.35);
  }

  private readonly moved = () => (this.dirty = true);

  /** Takes it off the page: what is shown next finds the stage empty. */
  end() {
    this.gone.abort();
    this.watcher.disconnect();
    this.stage.controls.removeEventListener('change', this.moved);
    this.gallery?.end();
    this.stage.clear();
  }

  /** Draws the first picture, and from now on whatever changes. */
  begin() {
    this.timeline.setPlaying(this.host.framed);
    this.drawSettled();
    let before = performance.now();
    const tick = (now: number) => {
      if (this.gone.signal.aborted) return;
      const seconds = Math.min(0.1, (now - before) / 1000);
      before = now;
      this.timeline.advance(seconds);
      this.stage.controls.update();
      if (this.dirty) this.dirty = this.draw(seconds);
      requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  hooks(): Omit<Hooks, 'ready' | 'error' | 'firstPicture' | 'cards' | 'pictures'> {
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
      setTheme: (theme) => this.host.setTheme(theme),
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
      objects: () => this.room.objects.list.map((object) => {
        const { name, shown, marked } = object;
        return { name, shown, marked, middle: this.room.objects.middle(object).toArray() };
      }),
      camera: () => [...this.stage.camera.position.toArray(), ...this.stage.controls.target.toArray()],
      bodies: () => people.map((person) => person.hasBody),
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
    const { menu, timeline, people, gallery, host, data } = this;
    for (const key of [' ', 'k']) menu.on(key, () => timeline.setPlaying(!timeline.playing));
    menu.on('arrowleft', () => timeline.step(-1));
    menu.on('arrowright', () => timeline.step(1));
    menu.on('home', () => timeline.setTime(timeline.begin));
    menu.on('end', () => timeline.setTime(timeline.end));
    menu.on('[', () => this.orbit(-0.15, 0, 1));
    menu.on(']', () => this.orbit(0.15, 0, 1));
    menu.on('pageup', () => this.orbit(0, -0.1, 1));
    menu.on('pagedown', () => this.orbit(0, 0.1, 1));
    for (const key of ['+', '=']) menu.on(key, () => this.orbit(0, 0, 0.85));
    menu.on('-', () => this.orbit(0, 0, 1 / 0.85));
    menu.on('escape', () => this.panels!.escape());
    menu.tell('space K', 'Play, pause');
    menu.tell('← →', 'Frame by frame');
    menu.tell('home end', 'First and last frame');
    menu.tell('[ ]', 'Orbit left and right');
    menu.tell('PgUp PgDn', 'Orbit up and down');
    menu.tell('+ -', 'Zoom');
    menu.tell('esc', 'Close what is open');

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
    if (people.length === 0) for (const id of ['follow', 'trails', 'ghosts']) element(id).hidden = true;
    if (gallery) {
      press('spread', gallery.apart);
      this.showSurroundings(!gallery.apart);
      for (const id of ['follow', 'trails', 'spread']) element(id).hidden = !gallery.canOverlay;
    }
    if (this.tags) {
      menu.toggle('tags', 'n', () => (this.tags!.on = !this.tags!.on)).hidden = false;
      press('tags', this.tags.on);
    }
    menu.press('theme', 'd', () => this.host.setTheme(this.host.theme() === 'dark' ? 'light' : 'dark'));
    this.panels = new Panels(menu, host, data, {
      people, gallery, hasObjects: this.objectList !== undefined,
      picture: () => {
        this.drawSettled();
        return this.stage.renderer.domElement;
      },
      time: () => timeline.time,
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
      this.showSurroundings(!gallery.apart);
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

  private showSurroundings(on: boolean) {
    this.stage.showGround(on && !this.room.hasFloor);
    this.room.group.visible = on;
  }

  /** The list of objects has changed; an object that stands out now should be seen. */
  private bringIntoView(object?: SceneObject) {
    this.repose();
    if (!object) return;
    const middle = this.room.objects.middle(object);
    const seen = middle.clone().project(this.stage.camera);
    if (Math.abs(seen.x) < 0.85 && Math.abs(seen.y) < 0.85 && seen.z < 1) return;
    if (this.following) element('follow').click();
    this.stage.follow(middle, 1);
    this.stage.controls.update();
  }

  private orbit(across: number, up: number, factor: number) {
    this.stage.orbit(across, up, factor);
    if (this.gallery) this.gallery.automatic = false;
    this.dirty = true;
  }

  /** Says in words what the view shows. */
  private describe() {
    const { people, timeline, room } = this;
    const count = room.objects.list.length;
    const who = people.length === 0 ? '' : people.length <= 4 ? people.map(({ data_ }) => data_.name || data_.role).join(', ') : `${people.length} people`;
    const parts = [who && `${who}, ${(timeline.end - timeline.begin).toFixed(1)} seconds`, count > 0 && `a scene of ${count} object${count > 1 ? 's' : ''}`];
    element('view').setAttribute('aria-label', `3D view: ${parts.filter(Boolean).join(', in ') || 'nothing yet'}`);
  }

  /** The page is light or dark now. */
  themed() {
    this.stage.setTheme(this.host.theme());
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
    const bar = this.people.length > 0 ? element('bar').getBoundingClientRect() : { top: height };
    this.layOut('bar-top', height - bar.top);
    const tools = element('tools').getBoundingClientRect(); // below the bar's place, which moves it
    this.layOut('tools-top', height - tools.top);
    this.layOut('tools-bottom', tools.bottom);
    this.layOut('tools-left', width - tools.left);
    if (this.gallery) return this.gallery.resize(width, height);
    const pixels = this.stage.resize(width, height, 0, this.host.framed ? 0 : height - bar.top);
    this.contacts?.points.setHeight(pixels);
    this.room.points?.setHeight(pixels);
  }

  /** Tells the style sheet where something stands. */
  private layOut(what: string, pixels: number) {
    document.documentElement.style.setProperty(`--${what}`, `${pixels}px`);
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
    this.room.objects.setTime(time);
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

  /** First view: the whole path if it is short, the first person otherwise. */
  private lookFirst(nearest: number) {
    this.pose();
    this.setFocus();
    const radius = this.extent.getSize(new Vector3()).setY(0).length() * 0.36 + 0.85;
    const wanders = Math.max(nearest, radius) >= 3.2;
    this.setFollowing(wanders);
    const places = wanders ? [this.focus] : placesOf(this.people, this.ground + 0.82);
    this.stage.frame(wanders ? this.focus : new Vector3(this.middle.x, this.ground + 0.82, this.middle.z),
      Math.min(3.2, Math.max(nearest, radius)), this.heading(), (from) => this.room.hidden(from, places));
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
    this.tags?.place(stage.camera, (person) => this.isVisible(person));
    stage.render();
    return fading;
  }

  private drawSettled() {
    this.room.settle(this.stage.camera);
    this.draw(1);
  }
}
