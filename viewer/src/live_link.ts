// The WebSocket to the server (docs/live.md) and the poses that came, between which the page interpolates.
import { Quaternion } from 'three';

export interface Pose {
  index: number; // frames since the connection began, 30 a second
  number: number; // of the last message that it knows of
  seated: boolean;
  recording: boolean;
  filling: boolean; // moved by in-betweening
  reaching: [boolean, boolean];
  action: number; // idle, walk, sit
  distance: [number, number]; // metres from palms to contacts; negative: none
  trans: Float32Array; // (3)
  rotations: Float32Array; // (22, 4) x y z w
}

export interface GhostPose {
  seconds: number;
  track: number;
  trans: Float32Array;
  rotations: Float32Array;
}

export type Point = [number, number, number];

export interface Hello {
  chairs: { name: string; seat: Point; heading: number }[];
  contacts: boolean;
  forecast: boolean;
  futures: boolean;
  poses: string[];
  recorded: number;
}

export interface Listener {
  hello(hello: Hello): void;
  contacts(chair: string, at: [Point | null, Point | null]): void;
  said(text: string, error: boolean): void;
  recorded(frames: number, file: string): void;
  ghosts(kind: number, ghosts: GhostPose[]): void;
  lost(): void;
}

const RATE = 30;
const JOINTS = 22;
const DELAY = 1 / RATE + 0.015; // seconds that poses are shown after they were made: there is always one to go to

function readPose(view: DataView, at: number) {
  const trans = new Float32Array(3);
  const rotations = new Float32Array(JOINTS * 4);
  for (let a = 0; a < 3; ++a) trans[a] = view.getFloat32(at + 4 * a, true);
  for (let k = 0; k < rotations.length; ++k) rotations[k] = view.getInt16(at + 12 + 2 * k, true) / 32767;
  return { trans, rotations };
}

export class Link {
  pose?: Pose; // the newest
  /** Milliseconds from sending a message to the first pose that knows of it, newest last. */
  readonly latencies: number[] = [];
  frames = 0; // that came
  private socket?: WebSocket;
  private number = 0;
  private readonly sent = new Map<number, number>();
  private readonly poses: Pose[] = [];
  private offset = NaN; // of this clock (s) to the server's frames

  constructor(private readonly url: string, private readonly listener: Listener) {
    this.connect();
  }

  private connect() {
    const socket = new WebSocket(this.url);
    this.socket = socket;
    socket.binaryType = 'arraybuffer';
    socket.onmessage = ({ data }) => (typeof data === 'string' ? this.hear(data) : this.see(new DataView(data as ArrayBuffer)));
    socket.onclose = () => {
      this.poses.length = 0;
      this.offset = NaN;
      this.listener.lost();
      setTimeout(() => this.connect(), 2000);
    };
  }

  send(order: { do: string } & Record<string, unknown>) {
    if (this.socket?.readyState !== WebSocket.OPEN) return;
    this.sent.set(++this.number, performance.now());
    if (this.sent.size > 500) this.sent.clear();
    this.socket.send(JSON.stringify({ ...order, number: this.number }));
  }

  /** Only for tests: what no page sends. */
  sendRaw(text: string) {
    this.socket?.send(text);
  }

  private hear(text: string) {
    const event = JSON.parse(text) as { event: string } & Record<string, unknown>;
    if (event.event === 'hello') this.listener.hello(event as unknown as Hello);
    else if (event.event === 'contacts') this.listener.contacts(event.chair as string, [event.left as Point | null, event.right as Point | null]);
    else if (event.event === 'said') this.listener.said(event.text as string, event.error as boolean);
    else if (event.event === 'recorded') this.listener.recorded(event.frames as number, event.file as string);
  }

  private see(view: DataView) {
    const kind = view.getUint8(0);
    if (kind === 2) {
      const ghosts = Array.from({ length: view.getUint16(2, true) }, (_, i) => {
        const at = 4 + i * 196;
        return { seconds: view.getFloat32(at, true), track: view.getUint8(at + 4), ...readPose(view, at + 8) };
      });
      return this.listener.ghosts(view.getUint8(1), ghosts);
    }
    const flags = view.getUint8(1);
    const pose: Pose = {
      index: view.getUint32(4, true),
      number: view.getUint32(8, true),
      seated: (flags & 1) > 0,
      recording: (flags & 2) > 0,
      filling: (flags & 4) > 0,
      reaching: [(flags & 8) > 0, (flags & 16) > 0],
      action: view.getUint8(2),
      distance: [view.getFloat32(12, true), view.getFloat32(16, true)],
      ...readPose(view, 20),
    };
    ++this.frames;
    const now = performance.now();
    for (const [number, at] of this.sent) {
      if (number > pose.number) continue;
      this.latencies.push(now - at);
      if (this.latencies.length > 200) this.latencies.shift();
      this.sent.delete(number);
    }
    this.pose = pose;
    this.poses.push(pose);
    if (this.poses.length > 12) this.poses.shift();
    // The earliest arrivals tell the clocks' offset; it follows where the server slows down.
    const here = now / 1000 - pose.index / RATE;
    this.offset = !(here >= this.offset) || here - this.offset > 0.5 ? here : this.offset + 0.02 * (here - this.offset);
  }

  /** The pose to be shown now, into `trans` and `rotations`. False where none has come. */
  sample(trans: Float32Array, rotations: Float32Array): boolean {
    const { poses } = this;
    if (poses.length === 0) return false;
    const at = (performance.now() / 1000 - this.offset - DELAY) * RATE;
    let next = poses.findIndex((pose) => pose.index >= at);
    if (next < 0) next = poses.length - 1;
    const to = poses[next];
    const from = poses[Math.max(0, next - 1)];
    const gap = to.index - from.index;
    const u = gap > 0 ? Math.min(1, Math.max(0, (at - from.index) / gap)) : 1;
    for (let a = 0; a < 3; ++a) trans[a] = from.trans[a] + u * (to.trans[a] - from.trans[a]);
    for (let j = 0; j < JOINTS; ++j)
      Quaternion.slerpFlat(rotations as unknown as number[], j * 4, from.rotations as unknown as number[], j * 4,
        to.rotations as unknown as number[], j * 4, u);
    return true;
  }
}
