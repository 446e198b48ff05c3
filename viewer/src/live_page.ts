import { Box3, CircleGeometry, Mesh, MeshBasicMaterial, RingGeometry, Vector3 } from 'three';
import { roleColor } from './colors';
import { Data } from './data';
import { element, press } from './dom';
import { LiveBody, LiveGhosts } from './live_body';
import { Hello, Link, Point } from './live_link';
import { Picks } from './live_pick';
import { Menu } from './menu';
import { facing, makePeople } from './people';
import { Bodies } from './person';
import { Room } from './room';
import { Stage, Theme } from './stage';

type Mode = 'go' | 'left' | 'right' | 'pose';
const MODES: Mode[] = ['go', 'left', 'right', 'pose'];
const ACTIONS = ['stands', 'walks', 'sits'];
const CLICK = 6; // pixels that a click may move
const DRAG_EVERY = 50; // milliseconds between two messages of a handle that is dragged

/** A room, the person in it that the server moves, and what one tells them. */
export class LivePage {
  readonly link: Link;
  readonly ghosts: LiveGhosts;
  readonly picks: Picks;
  readonly body: LiveBody;
  contacts: [Point | null, Point | null] = [null, null];
  chair = '';
  hello?: Hello;
  mode: Mode = 'go';
  file = '';
  frames = 0; // drawn
  private readonly stage = new Stage(element<HTMLCanvasElement>('view'));
  private readonly room: Room;
  private readonly mark: Mesh;
  private readonly arrow: Mesh;
  private readonly menu = new Menu(() => undefined);
  private readonly focus = new Vector3();
  private readonly trans = new Float32Array(3);
  private readonly rotations = new Float32Array(22 * 4);
  private theme: Theme = matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : 'light';
  private following = true;
  private looking = { forecast: false, futures: false };
  private down?: { x: number; y: number; hand: number; at?: Vector3 };
  private dragged = 0; // when the last message of a drag went
  private hiding = 0;

  constructor(data: Data) {
    const { scene } = this.stage;
    const bodies = new Bodies(data);
    this.room = new Room(data);
    scene.add(this.room.group);
    this.body = new LiveBody(data, bodies, roleColor.motion);
    scene.add(this.body.group);
    const [first] = makePeople(data, bodies);
    first.setTime(0);
    this.ghosts = new LiveGhosts(data, bodies, scene);
    this.picks = new Picks(element('view'), this.stage.camera, this.room.group, scene);
    const marking = (geometry: RingGeometry | CircleGeometry) => {
      const mesh = new Mesh(geometry.rotateX(-Math.PI / 2), new MeshBasicMaterial({ color: roleColor.prediction, transparent: true, opacity: 0.75, depthWrite: false }));
      mesh.visible = false;
      scene.add(mesh);
      return mesh;
    };
    this.mark = marking(new RingGeometry(0.13, 0.17, 40));
    this.arrow = marking(new CircleGeometry(0.09, 3, -Math.PI / 2));

    const box = this.room.box.isEmpty() ? new Box3(new Vector3(-3, 0, -3), new Vector3(3, 2, 3)) : this.room.box;
    const middle = box.getCenter(new Vector3());
    this.stage.setGround(0, middle, Math.max(6, box.getSize(new Vector3()).length() / 2 + 4), !this.room.hasFloor);
    this.setTheme(this.theme);
    this.addControls();
    this.resize();
    addEventListener('resize', () => this.resize());
    const at = new Vector3().fromArray(first.now);
    this.stage.frame(at.setY(0.75), 1.75, facing(first) + 0.6);
    this.link = new Link(`ws://${location.host}/live`, {
      hello: (hello) => this.begin(hello),
      contacts: (chair, contacts) => this.setContacts(chair, contacts),
      said: (text, error) => this.say(text, error),
      recorded: (frames, file) => this.offer(frames, file),
      ghosts: (kind, ghosts) => {
        this.ghosts.set(kind, ghosts);
        if (kind === 2) this.mark.visible &&= ghosts.length > 0;
      },
      lost: () => this.lose(),
    });
  }

  start() {
    let before = performance.now();
    const tick = (now: number) => {
      this.draw(Math.min(0.1, (now - before) / 1000));
      before = now;
      requestAnimationFrame(tick);
    };
    this.room.settle(this.stage.camera);
    requestAnimationFrame(tick);
  }

  setCamera(x: number, y: number, z: number, target: [number, number, number]) {
    this.following = false;
    press('follow', false);
    this.stage.controls.target.fromArray(target);
    this.stage.camera.position.set(x, y, z);
    this.stage.controls.update();
  }

  /** Where a point of the world is on the page, pixels. */
  onScreen(x: number, y: number, z: number): [number, number] {
    this.stage.camera.updateMatrixWorld();
    const at = new Vector3(x, y, z).project(this.stage.camera);
    return [((at.x + 1) / 2) * innerWidth, ((1 - at.y) / 2) * innerHeight];
  }

  private begin(hello: Hello) {
    this.hello = hello;
    element('draw').hidden = !hello.contacts;
    element('forecast').hidden = !hello.forecast;
    element('futures').hidden = !hello.futures;
    for (const id of ['mode-pose', 'pose']) element(id).hidden = hello.poses.length === 0;
    element('pose').replaceChildren(...hello.poses.map((name) => new Option(name, name)));
    for (const what of ['forecast', 'futures'] as const) if (this.looking[what]) this.link.send({ do: what, on: true });
    this.setContacts('', [null, null]);
    this.recording(false);
    this.resize();
    this.say(hello.chairs.length > 0 ? 'Click the floor to walk there, a chair to sit on it.' : 'Click the floor to walk there. Nothing here can be sat on.', false);
  }

  private lose() {
    this.hello = undefined;
    this.ghosts.clear();
    this.mark.visible = false;
    element('note').textContent = 'not connected';
    this.say('No connection: the server has ended, or has as many pages as it takes. Trying again.', true);
  }

  private say(text: string, error: boolean) {
    const said = element('said');
    said.textContent = text;
    said.className = error ? 'error' : '';
    clearTimeout(this.hiding);
    this.hiding = window.setTimeout(() => said.classList.add('gone'), 6000);
  }

  private setContacts(chair: string, contacts: [Point | null, Point | null]) {
    this.chair = chair;
    this.contacts = contacts;
    contacts.forEach((contact, hand) => {
      if (this.down?.hand === hand) return; // it is where it is dragged to
      this.picks.handles[hand].visible = contact !== null;
      if (contact) this.picks.handles[hand].position.fromArray(contact);
    });
  }

  private offer(frames: number, file: string) {
    this.recording(false);
    this.file = file;
    for (const kind of ['bvh', 'glb', 'npz']) element<HTMLAnchorElement>(kind).href = `${file}.${kind}`;
    element('files').hidden = false;
    this.resize();
    this.say(`${(frames / 30).toFixed(1)} s were recorded.`, false);
  }

  private recording(on: boolean) {
    press('record', on);
    element('record').querySelector('span')!.textContent = on ? 'Stop' : 'Record';
    if (on) element('files').hidden = true;
  }

  private setMode(mode: Mode) {
    this.mode = mode;
    for (const other of MODES) press(`mode-${other}`, other === mode);
  }

  private setTheme(next: Theme) {
    this.theme = next;
    document.documentElement.dataset.theme = next;
    element('theme').textContent = next === 'dark' ? 'Light' : 'Dark';
    this.stage.setTheme(next);
  }

  private addControls() {
    const { menu } = this;
    MODES.forEach((mode, i) => {
      const choose = () => element(`mode-${mode}`).hidden || this.setMode(mode);
      element(`mode-${mode}`).onclick = choose;
      menu.on(String(i + 1), choose);
    });
    this.setMode('go');
    const button = (id: string, key: string, action: () => void) => {
      element(id).onclick = action;
      if (key) menu.on(key, () => element(id).hidden || action());
    };
    button('draw', 'c', () => this.link.send({ do: 'draw' }));
    button('free', 'x', () => {
      for (const hand of ['left', 'right']) this.link.send({ do: 'contact', hand, at: null });
    });
    button('stand', 's', () => this.link.send({ do: 'stand' }));
    button('restart', '', () => this.link.send({ do: 'restart' }));
    button('record', 'r', () => {
      const on = element('record').getAttribute('aria-pressed') !== 'true';
      this.link.send({ do: 'record', on });
      if (on) this.recording(true);
    });
    element('pose').onchange = () => this.setMode('pose');
    menu.toggle('follow', 'f', () => (this.following = !this.following));
    press('follow', true);
    for (const [what, key] of [['forecast', 'o'], ['futures', 'u']] as const) {
      menu.toggle(what, key, () => {
        const on = (this.looking[what] = !this.looking[what]);
        this.link.send({ do: what, on });
        return on;
      });
    }
    menu.toggle('theme', 'd', () => {
      this.setTheme(this.theme === 'dark' ? 'light' : 'dark');
      return false;
    });
    this.addPointer(element('view'));
  }

  private addPointer(view: HTMLElement) {
    // Before the camera's own listener: who drags a handle does not orbit.
    view.addEventListener('pointerdown', (event) => {
      if (event.button !== 0) return;
      const hand = this.picks.handle(event.clientX, event.clientY);
      const at = this.mode === 'pose' && hand < 0 ? this.picks.hit(event.clientX, event.clientY) : undefined;
      this.down = { x: event.clientX, y: event.clientY, hand, at: at?.level ? at.point : undefined };
      if (hand >= 0 || this.down.at) {
        this.stage.controls.enabled = false;
        view.setPointerCapture(event.pointerId);
      }
    }, true);
    view.addEventListener('pointermove', (event) => {
      const { down } = this;
      if (down && down.hand >= 0) this.drag(down.hand, event, true);
      else if (down?.at) this.rotate(down.at, event);
      else if (event.buttons === 0) {
        const hit = this.picks.handle(event.clientX, event.clientY) < 0 ? this.picks.hit(event.clientX, event.clientY) : undefined;
        view.classList.toggle('over', !hit || this.isChair(hit.object));
      }
    });
    const up = (event: PointerEvent) => {
      const { down } = this;
      this.down = undefined;
      this.stage.controls.enabled = true;
      if (!down || event.type === 'pointercancel') return;
      if (down.hand >= 0) this.drag(down.hand, event, false);
      else if (down.at) this.placePose(down.at, event);
      else if (Math.hypot(event.clientX - down.x, event.clientY - down.y) < CLICK) this.click(event.clientX, event.clientY);
    };
    view.addEventListener('pointerup', up);
    view.addEventListener('pointercancel', up);
  }

  private isChair(name: string) {
    return this.hello?.chairs.some((chair) => chair.name === name) ?? false;
  }

  private drag(hand: number, event: PointerEvent, moving: boolean) {
    const hit = this.picks.hit(event.clientX, event.clientY, this.chair);
    const handle = this.picks.handles[hand];
    if (hit) handle.position.copy(hit.point);
    if (moving && (!hit || performance.now() - this.dragged < DRAG_EVERY)) return;
    this.dragged = performance.now();
    this.link.send({ do: 'contact', hand: hand === 0 ? 'left' : 'right', at: handle.position.toArray() });
  }

  /** Heading from a place to where the pointer is on the floor; NaN where that is too near to tell. */
  private headingTo(at: Vector3, event: PointerEvent) {
    const to = this.picks.hit(event.clientX, event.clientY)?.point;
    return to && Math.hypot(to.x - at.x, to.z - at.z) > 0.15 ? Math.atan2(to.x - at.x, to.z - at.z) : NaN;
  }

  private rotate(at: Vector3, event: PointerEvent) {
    const heading = this.headingTo(at, event);
    this.showMark(at);
    this.arrow.visible = !Number.isNaN(heading);
    this.arrow.position.set(at.x + 0.28 * Math.sin(heading), 0.012, at.z + 0.28 * Math.cos(heading));
    this.arrow.rotation.y = heading;
  }

  private placePose(at: Vector3, event: PointerEvent) {
    const from = this.body.joint(0, new Vector3());
    let heading = this.headingTo(at, event);
    if (Number.isNaN(heading)) heading = Math.atan2(at.x - from.x, at.z - from.z);
    this.arrow.visible = false;
    this.showMark(at);
    this.link.send({ do: 'pose', pose: element<HTMLSelectElement>('pose').value, at: [at.x, at.z], heading });
  }

  private showMark(at: Vector3) {
    this.mark.position.set(at.x, 0.01, at.z);
    this.mark.visible = true;
  }

  private click(x: number, y: number) {
    const hit = this.picks.hit(x, y);
    if (!hit) return;
    const point = hit.point.toArray();
    const { mode } = this;
    if (mode === 'left' || mode === 'right') {
      if (this.isChair(hit.object)) this.link.send({ do: 'contact', hand: mode, at: point, chair: hit.object });
      else this.say(`${mode} contact: click on a chair`, true);
    } else if (this.isChair(hit.object)) {
      if (this.link.pose?.seated && hit.object === this.chair) this.touch(hit.point);
      else this.link.send({ do: 'sit', chair: hit.object });
      this.mark.visible = false;
    } else if (hit.level) {
      this.showMark(hit.point);
      this.link.send({ do: 'walk', to: [hit.point.x, hit.point.z] });
    } else {
      this.say(`${hit.object || 'that'} is neither floor nor seat`, true);
    }
  }

  /** A contact for the hand on whose side of the seat it is. */
  private touch(point: Vector3) {
    const chair = this.hello!.chairs.find(({ name }) => name === this.chair)!;
    const left = (point.x - chair.seat[0]) * Math.cos(chair.heading) - (point.z - chair.seat[2]) * Math.sin(chair.heading) > 0;
    this.link.send({ do: 'contact', hand: left ? 'left' : 'right', at: point.toArray() });
  }

  private resize() {
    const deck = element('deck').getBoundingClientRect();
    document.documentElement.style.setProperty('--deck', `${deck.height}px`);
    const pixels = this.stage.resize(innerWidth, innerHeight, 0, innerHeight - deck.top);
    this.room.points?.setHeight(pixels);
  }

  private status() {
    const { pose } = this.link;
    if (!pose || !this.hello) return;
    const doing = pose.filling ? 'moves to the pose' : pose.seated ? `sits on ${this.chair}` : ACTIONS[pose.action] ?? '';
    const hands = ['left', 'right'].map((hand, i) => (pose.distance[i] >= 0 ? `, ${hand} hand ${(100 * pose.distance[i]).toFixed(0)} cm off` : ''));
    element('note').textContent = doing + hands.join('');
    if (!pose.recording && element('record').getAttribute('aria-pressed') === 'true' && element('files').hidden === false) this.recording(false);
  }

  private draw(seconds: number) {
    const { stage, room, focus } = this;
    ++this.frames;
    if (this.link.sample(this.trans, this.rotations)) this.body.pose(this.trans, this.rotations);
    this.body.joint(0, focus);
    this.ghosts.standAside(focus);
    if (this.mark.visible && !this.down && Math.hypot(focus.x - this.mark.position.x, focus.z - this.mark.position.z) < 0.2 && this.ghosts.count(2) === 0)
      this.mark.visible = false;
    focus.y = Math.max(0.72, Math.min(focus.y, 1.05)) * 0.95;
    if (this.following && !this.down) stage.follow(focus, Math.min(1, seconds * 4));
    room.focus.value.copy(focus);
    stage.lightAround(focus);
    stage.controls.update();
    room.update(stage.camera, seconds);
    this.status();
    stage.render();
  }
}
