import * as THREE from 'three';
import { actionTones, css, futureColor, intentionColors, motionTones, roleColor, roleName } from './colors';
import { Contacts } from './contacts';
import { Data } from './data';
import { Gallery } from './gallery';
import { Keys } from './keys';
import { Bodies, isFigure, Person, Shape } from './person';
import { Room } from './room';
import { Stage, Theme } from './stage';
import { makeTrails } from './trails';

/** What scripts and tests may use: window.inhabit. */
export interface Hooks {
  ready: boolean;
  error: string;
  duration: number;
  people: string[];
  setTime(seconds: number): void;
  time(): number;
  play(): void;
  pause(): void;
  playing(): boolean;
  setShape(shape: Shape): void;
  setFollow(on: boolean): void;
  setGhosts(on: boolean): void;
  setTheme(theme: Theme): void;
  setJoint(name: string): void;
  setCamera(x: number, y: number, z: number, target?: [number, number, number]): void;
  /** World positions (J, 3) of a person's joints as drawn now. */
  jointPositions(person: number): number[][];
  visible(person: number): boolean;
  /** Many figures: side by side (true) or overlaid where they go. */
  setApart(on: boolean): void;
  /** Makes one of many figures stand out; -1: none. */
  choose(person: number): void;
}

const element = <T extends HTMLElement>(id: string) => document.getElementById(id) as T;
const hooks = { ready: false, error: '' } as Hooks;
(window as unknown as { inhabit: Hooks }).inhabit = hooks;

const PLAY = '<svg viewBox="0 0 16 16"><path d="M4 2.2v11.6c0 .5.5.8.9.5l9-5.8c.4-.2.4-.8 0-1l-9-5.8c-.4-.3-.9 0-.9.5z"/></svg>';
const PAUSE = '<svg viewBox="0 0 16 16"><rect x="3" y="2" width="3.6" height="12" rx="1"/><rect x="9.4" y="2" width="3.6" height="12" rx="1"/></svg>';

function fail(reason: unknown) {
  hooks.error = String(reason instanceof Error ? reason.message : reason);
  const message = element('message');
  message.hidden = false;
  message.textContent = 'This page could not be shown: ' + hooks.error;
  throw reason;
}

async function start() {
  const data = await Data.read();
  const { header } = data;
  const stage = new Stage(element<HTMLCanvasElement>('view'));
  const room = new Room(data);
  const bodies = new Bodies(data);
  stage.scene.add(room.group);

  // People. Roles have one colour each; several plain motions get a tone each; crowds are see-through.
  const perRole = new Map<string, number>();
  for (const source of header.people) perRole.set(source.role, (perRole.get(source.role) ?? 0) + 1);
  const seen = new Map<string, number>();
  const figures = header.people.some(isFigure); // small ones
  const people = header.people.map((source) => {
    const k = seen.get(source.role) ?? 0;
    seen.set(source.role, k + 1);
    const color = source.role === 'motion' ? motionTones[k % motionTones.length]
      : source.role === 'future' ? futureColor(k)
        : source.role === 'intention' && source.intentions ? Number.parseInt(intentionColors(source.intentions[0][1] + 1).at(-1)!.slice(1), 16)
          : roleColor[source.role];
    const crowd = perRole.get(source.role)! > 6;
    return new Person(data, bodies, source, color, crowd ? 0.45 : 1, figures);
  });
  for (const person of people) stage.scene.add(person.group);
  const begin = Math.min(0, ...people.map((person) => person.start));
  const end = Math.max(begin + 1e-3, ...people.map((person) => person.end));
  const rate = people[0]?.data_.rate ?? 30;

  // Ground: the floor of the scene, or a grid below the lowest foot.
  let lowest = Infinity;
  for (const person of people) for (let i = 1; i < person.joints.length; i += 3) lowest = Math.min(lowest, person.joints[i]);
  const ground = !Number.isFinite(lowest) || Math.abs(lowest) < 0.35 ? 0 : lowest - 0.02;
  const extent = new THREE.Box3();
  const v = new THREE.Vector3();
  for (const person of people) {
    for (let f = 0; f < person.joints.length; f += person.parents.length * 3) extent.expandByPoint(v.fromArray(person.joints, f));
  }
  if (extent.isEmpty()) extent.copy(room.box);
  const middle = extent.getCenter(new THREE.Vector3());
  stage.setGround(ground, middle, Math.max(6, extent.getSize(v).length() / 2 + 4), !room.hasFloor);

  // Still, see-through copies of each person along the way.
  const ghosts: { of: Person; ghost: Person; at: number }[] = [];
  const makeGhosts = () => {
    const gap = Math.max(0.5, (end - begin) / 12);
    for (const person of people) {
      for (let t = Math.ceil((person.start + 1e-6) / gap) * gap; t <= person.end + 1e-6; t += gap) {
        const ghost = new Person(data, bodies, person.data_, person.color, 0.42);
        ghost.group.traverse((part) => (part.castShadow = false));
        ghost.show(shape);
        ghost.setTime(t);
        stage.scene.add(ghost.group);
        ghosts.push({ of: person, ghost, at: t });
      }
    }
  };

  const keyed = people.filter((person) => person.data_.keys)
    .map((person) => new Keys(data, bodies, person, element('spans'), begin, end));
  for (const { copies } of keyed) for (const copy of copies) stage.scene.add(copy.group);

  const trails = people.map((person) => makeTrails(person, ground, !figures));
  trails.forEach((trail, i) => people[i].group.add(trail));

  let contacts: Contacts | undefined;
  if (header.contacts) {
    contacts = new Contacts(data, header.contacts);
    stage.scene.add(contacts.points.object);
  }

  // In a frame of another page (an index of pages) the motion plays by itself, without controls.
  const framed = window.self !== window.top;
  document.documentElement.classList.toggle('framed', framed);

  // State
  let time = begin;
  let playing = false;
  let following = true;
  let showTrails = true;
  let apart = false;
  let showGhosts = false;
  let shape: Shape = people.some((person) => person.hasBody) ? 'body' : 'skeleton';
  let dirty = true;
  let painted = NaN; // time the scene was last posed at
  const focus = new THREE.Vector3();
  const heading = people.length > 0 ? facing(people[0]) : 0.5;
  const gallery = figures ? new Gallery(header, people, stage, heading, ground, begin, end, element('names'), () => {
    painted = NaN;
    dirty = true;
  }) : undefined;

  /** A person is there from its first frame on; an observed past leaves when what comes after it starts. */
  const lastStart = Math.max(...people.map((person) => person.start));
  const isVisible = (person: Person) => gallery ? gallery.isVisible(person, time) : person.enabled && time >= person.start - 1e-6 &&
    !(person.data_.role === 'past' && time > person.end + 0.5 / rate && lastStart > person.start);

  const setFocus = () => {
    focus.set(0, 0, 0);
    let n = 0;
    for (const person of people) {
      if (!isVisible(person)) continue;
      focus.x += person.now[0] + person.group.position.x;
      focus.y += person.now[1] + person.group.position.y;
      focus.z += person.now[2] + person.group.position.z;
      ++n;
    }
    if (n > 0) focus.divideScalar(n);
    else focus.copy(middle);
    focus.y = Math.max(ground + 0.75, Math.min(focus.y, ground + 1.1)) * 0.95;
  };

  const pose = () => {
    for (let i = 0; i < people.length; ++i) {
      const person = people[i];
      person.group.visible = person.enabled;
      const there = isVisible(person);
      for (const child of person.group.children) child.visible = there;
      trails[i].visible = person.enabled && showTrails && (!gallery || gallery.showsTrail(person));
      if (!there) continue;
      person.show(shape);
      person.setTime(time);
    }
    for (const { of, ghost } of ghosts) {
      ghost.group.visible = showGhosts && of.enabled;
      ghost.group.position.copy(of.group.position);
    }
    for (const keys of keyed) keys.setTime(time);
    gallery?.setTime(time);
    contacts?.setTime(time);
    painted = time;
  };

  // Controls
  const slider = element<HTMLInputElement>('time');
  const clock = element('clock');
  const playButton = element('play');
  slider.min = String(begin);
  slider.max = String(end);
  const clockTime = document.createTextNode('');
  const clockFrame = document.createElement('small');
  clock.replaceChildren(clockTime, clockFrame);
  const frames = Math.round((end - begin) * rate) + 1;
  const actionMarks: { from: number; to: number; mark: HTMLElement }[] = [];

  const showTime = () => {
    slider.value = String(time);
    clockTime.data = `${time.toFixed(2)} s`;
    clockFrame.textContent = `frame ${Math.round((time - begin) * rate)} / ${frames - 1}`;
    for (const { from, to, mark } of actionMarks) mark.classList.toggle('now', time >= from && time < to);
  };
  const setTime = (t: number) => {
    time = Math.min(Math.max(t, begin), end);
    dirty = true;
    showTime();
  };
  const setPlaying = (on: boolean) => {
    if (on && time >= end - 1e-6) time = begin;
    playing = on;
    playButton.innerHTML = on ? PAUSE : PLAY;
    playButton.setAttribute('aria-label', on ? 'Pause' : 'Play');
    dirty = true;
  };
  const step = (k: number) => {
    setPlaying(false);
    setTime(begin + (Math.round((time - begin) * rate) + k) / rate);
  };
  playButton.onclick = () => setPlaying(!playing);
  slider.oninput = () => {
    setPlaying(false);
    setTime(Number(slider.value));
  };
  const speed = element<HTMLSelectElement>('speed');

  const place = (node: HTMLElement, from: number, to: number) => {
    node.style.left = `${(100 * (from - begin)) / (end - begin)}%`;
    node.style.width = `${(100 * (to - from)) / (end - begin)}%`;
  };
  const covered = new Set<string>();
  people.forEach((person, i) => {
    const { role } = person.data_;
    if (role === 'intention') return; // starts over
    const key = `${role} ${person.start} ${person.end}`;
    if (covered.has(key)) return;
    covered.add(key);
    const span = document.createElement('i');
    // A truth beside a prediction: upper and lower half of the line.
    const halves = perRole.has('truth') && perRole.has('prediction');
    if (halves && (role === 'truth' || role === 'prediction')) {
      span.style.height = '50%';
      if (role === 'prediction') span.style.top = '50%';
    }
    span.style.background = css(person.color);
    // Up to where the next motion begins, so that no gap of one frame shows.
    const next = people.find((other, k) => k !== i && Math.abs(other.start - person.end) < 2 / rate);
    place(span, person.start, next ? Math.max(next.start, person.end) : person.end);
    element('spans').append(span);
  });

  const labelTone = new Map<string, string>();
  let labelled = -Infinity;
  for (const person of [...people].sort((p, r) => p.start - r.start)) {
    const { actions, rate: own, frames: count } = person.data_;
    if (!actions || person.start < labelled - 1e-6) continue;
    labelled = person.end;
    actions.spans.forEach(([first, label], k) => {
      const name = actions.names[label];
      if (!name) return;
      const from = person.start + first / own;
      const to = person.start + (k + 1 < actions.spans.length ? actions.spans[k + 1][0] : count - 1) / own;
      const mark = document.createElement('span');
      if (!labelTone.has(name)) labelTone.set(name, actionTones[labelTone.size % actionTones.length]);
      mark.style.backgroundColor = labelTone.get(name)!;
      mark.textContent = mark.title = name.replace(/_/g, ' ');
      place(mark, from, to);
      element('actions').append(mark);
      actionMarks.push({ from, to: k + 1 < actions.spans.length ? to : to + 1e-3, mark });
    });
  }

  // Legend: a chip per person, or per role where there are many.
  const groups = people.length <= 8 ? people.map((person) => [person])
    : [...perRole.keys()].map((role) => people.filter((person) => person.data_.role === role));
  for (const group of groups) {
    if (group[0].data_.role === 'intention') continue; // named under its figure
    const chip = document.createElement('button');
    const dot = document.createElement('i');
    const label = document.createElement('span');
    chip.type = 'button';
    chip.setAttribute('aria-pressed', 'true');
    dot.style.background = css(group[0].color);
    const { name, role } = group[0].data_;
    label.textContent = group.length > 1 ? `${roleName[role]} × ${group.length}` : name || roleName[role];
    chip.append(dot, label);
    chip.onclick = () => {
      const on = !group[0].enabled;
      for (const person of group) person.enabled = on;
      chip.setAttribute('aria-pressed', String(on));
      painted = NaN;
      dirty = true;
    };
    element('legend').append(chip);
  }
  element('note').textContent = header.note;

  const toggle = (id: string, key: string, set: () => boolean) => {
    const button = element(id);
    const press = () => {
      button.setAttribute('aria-pressed', String(set()));
      painted = NaN;
      dirty = true;
    };
    button.onclick = press;
    keys.set(key, press);
    return button;
  };
  const keys = new Map<string, () => void>([
    [' ', () => setPlaying(!playing)],
    ['k', () => setPlaying(!playing)],
    ['arrowright', () => step(1)],
    ['arrowleft', () => step(-1)],
    ['home', () => setTime(begin)],
    ['end', () => setTime(end)],
  ]);

  const setShape = (next: Shape) => {
    shape = people.some((person) => person.hasBody) ? next : 'skeleton';
    shapeButton.textContent = shape === 'body' ? 'Skeleton' : 'Body';
    shapeButton.title = (shape === 'body' ? 'Show the skeleton' : 'Show the body') + ' (B)';
    for (const marks of keyed) marks.show(shape);
    for (const { ghost, at } of ghosts) {
      ghost.show(shape);
      ghost.setTime(at);
    }
    painted = NaN;
    dirty = true;
  };
  const shapeButton = toggle('shape', 'b', () => {
    setShape(shape === 'body' ? 'skeleton' : 'body');
    return false;
  });
  setShape(shape);
  shapeButton.hidden = !people.some((person) => person.hasBody);
  toggle('follow', 'f', () => {
    if (gallery) return (gallery.automatic = !gallery.automatic);
    return (following = !following);
  }).setAttribute('aria-pressed', 'true');
  toggle('trails', 't', () => (showTrails = !showTrails)).setAttribute('aria-pressed', 'true');

  const setGhosts = (on: boolean) => {
    showGhosts = on;
    if (on && ghosts.length === 0) makeGhosts();
    painted = NaN;
    dirty = true;
  };
  const ghostButton = toggle('ghosts', 'g', () => {
    setGhosts(!showGhosts);
    return showGhosts;
  });
  ghostButton.hidden = figures || people.length > 8;

  const spread = toggle('spread', 's', () => {
    if (gallery) {
      gallery.setApart(!gallery.apart);
      stage.showGround(!gallery.apart && !room.hasFloor);
      resize();
      return gallery.apart;
    }
    apart = !apart;
    people.forEach((person, i) => {
      const columns = Math.ceil(Math.sqrt(people.length * 1.6));
      const x = ((i % columns) - (columns - 1) / 2) * 1.6;
      const z = -Math.floor(i / columns) * 1.8;
      person.group.position.set(apart ? middle.x + x - person.joints[0] : 0, 0, apart ? middle.z + z - person.joints[2] : 0);
    });
    if (following) setFocus();
    return apart;
  });
  spread.hidden = people.length < 2;
  if (gallery) {
    spread.setAttribute('aria-pressed', 'true');
    stage.showGround(false);
    for (const id of ['follow', 'trails', 'spread']) element(id).hidden = !gallery.canOverlay;
  }

  let theme: Theme = matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : 'light';
  const themeButton = toggle('theme', 'd', () => {
    setTheme(theme === 'dark' ? 'light' : 'dark');
    return false;
  });
  const setTheme = (next: Theme) => {
    theme = next;
    document.documentElement.dataset.theme = theme;
    themeButton.textContent = theme === 'dark' ? 'Light' : 'Dark';
    stage.setTheme(theme);
    gallery?.redraw();
    dirty = true;
  };
  setTheme(theme);

  const jointSelect = element<HTMLSelectElement>('joint');
  const chooseJoint = (j: number) => {
    contacts?.choose(j);
    element('scale').hidden = j < 0;
    jointSelect.value = String(j);
    painted = NaN;
    dirty = true;
  };
  if (contacts) {
    element('joint-label').hidden = false;
    jointSelect.append(new Option('off', '-1'));
    contacts.names.forEach((name, j) => jointSelect.append(new Option(name.replace(/_/g, ' '), String(j))));
    jointSelect.onchange = () => chooseJoint(Number(jointSelect.value));
    chooseJoint(contacts.busiest());
  }

  addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target instanceof HTMLSelectElement) return;
    if (event.key === ' ' && event.target instanceof HTMLButtonElement) return;
    const action = keys.get(event.key.toLowerCase());
    if (!action) return;
    event.preventDefault();
    action();
  });

  // Size
  const resize = () => {
    const width = innerWidth;
    const height = innerHeight;
    dirty = true;
    const bar = element('bar').getBoundingClientRect();
    document.documentElement.style.setProperty('--bar-top', `${height - bar.top}px`);
    if (gallery) return gallery.resize(width, height);
    const pixels = stage.resize(width, height, 0, framed ? 0 : height - bar.top);
    contacts?.points.setHeight(pixels);
    room.points?.setHeight(pixels);
  };
  addEventListener('resize', resize);
  showTime();
  resize();
  stage.controls.addEventListener('change', () => (dirty = true));

  // First view: the whole way if it is short, the first person otherwise.
  pose();
  setFocus();
  const reach = Math.min(3.2, Math.max(header.scene ? 1.6 : 1.35, extent.getSize(v).setY(0).length() * 0.36 + 0.85));
  const first = new THREE.Vector3(middle.x, ground + 0.82, middle.z);
  const wanders = reach >= 3.2;
  following = wanders;
  element('follow').setAttribute('aria-pressed', String(following));
  stage.frame(wanders ? focus : first, reach, heading);

  const draw = (seconds: number) => {
    if (painted !== time) pose();
    setFocus();
    if (gallery) {
      gallery.placeCamera(seconds, time);
      element('follow').setAttribute('aria-pressed', String(gallery.automatic));
    } else if (following) stage.follow(focus, playing ? Math.min(1, seconds * 6) : 1);
    room.focus.value.copy(focus);
    stage.lightAround(focus);
    stage.controls.update();
    const fading = room.update(stage.camera, seconds);
    stage.render();
    return fading;
  };

  let before = performance.now();
  const tick = (now: number) => {
    const seconds = Math.min(0.1, (now - before) / 1000);
    before = now;
    if (playing) {
      time += seconds * Number(speed.value);
      if (time > end) time = begin + ((time - begin) % (end - begin));
      showTime();
      dirty = true;
    }
    stage.controls.update();
    if (dirty) dirty = draw(seconds);
    requestAnimationFrame(tick);
  };

  Object.assign(hooks, {
    duration: end - begin,
    people: people.map((person) => person.data_.name),
    setTime: (t: number) => {
      setPlaying(false);
      setTime(t);
      room.settle(stage.camera);
      draw(1);
    },
    time: () => time,
    play: () => setPlaying(true),
    pause: () => setPlaying(false),
    playing: () => playing,
    setShape,
    setFollow: (on: boolean) => {
      following = on;
      element('follow').setAttribute('aria-pressed', String(on));
      dirty = true;
    },
    setGhosts: (on: boolean) => {
      setGhosts(on);
      ghostButton.setAttribute('aria-pressed', String(on));
    },
    setTheme,
    setJoint: (name: string) => chooseJoint(contacts ? contacts.names.indexOf(name) : -1),
    setCamera: (x: number, y: number, z: number, target?: [number, number, number]) => {
      following = false;
      if (gallery) gallery.automatic = false;
      if (target) stage.controls.target.fromArray(target);
      stage.camera.position.set(x, y, z);
      stage.controls.update();
      dirty = true;
    },
    jointPositions: (i: number) =>
      people[i].parents.map((_, j) => people[i].joint(j, new THREE.Vector3()).toArray()),
    visible: (i: number) => isVisible(people[i]),
    setApart: (on: boolean) => {
      if (gallery && gallery.apart !== on) spread.click();
    },
    choose: (i: number) => gallery?.choose(people[i]),
  } satisfies Partial<Hooks>);
  setPlaying(framed);
  room.settle(stage.camera);
  draw(1);
  hooks.ready = true;
  requestAnimationFrame(tick);
}

/** The direction (angle about +Y from +Z) in which a person looks at first: from the hips. */
function facing(person: Person): number {
  const names = person.data_.names.map((name) => name.toLowerCase());
  const left = names.findIndex((name) => /^(left_hip|lefthip|l_?hip|leftupleg|lhipjoint)$/.test(name));
  const right = names.findIndex((name) => /^(right_hip|righthip|r_?hip|rightupleg|rhipjoint)$/.test(name));
  if (left < 0 || right < 0) return 0;
  const x = person.joints[left * 3] - person.joints[right * 3];
  const z = person.joints[left * 3 + 2] - person.joints[right * 3 + 2];
  return Math.atan2(-z, x); // left is +X when the person faces +Z
}

start().catch(fail);
