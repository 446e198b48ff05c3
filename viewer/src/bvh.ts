import { Matrix4, Quaternion, Vector3 } from 'three';
import type { Data, PersonData } from './data';

const CENTIMETRES = 100;
const DEGREES = 180 / Math.PI;
const LEAF = 0.05; // metres of an end site
const RIGID = 0.0004; // metres by which a bone may differ from itself before its joint carries positions

const text = (numbers: ArrayLike<number>) => Array.from(numbers, (x) => x.toFixed(6)).join(' ');
const centimetres = (metres: ArrayLike<number>) => Array.from(metres, (x) => x * CENTIMETRES);

/** Angles (degrees) about z, y, x with R = Rz Ry Rx, the nearer of the two solutions to `before`, without jumps of 360 degrees. */
function eulerAngles(q: Quaternion, before: number[], m: Matrix4): number[] {
  const e = m.makeRotationFromQuaternion(q).elements; // column by column
  const cosine = Math.hypot(e[0], e[1]);
  let first = [Math.atan2(e[1], e[0]), Math.atan2(-e[2], cosine), Math.atan2(e[6], e[10])];
  if (cosine < 1e-7) { // gimbal lock, z and x rotate about one axis: x stays where it was
    const x = before[2] / DEGREES;
    first = [Math.atan2(-e[4], e[5]) + (e[2] < 0 ? x : -x), first[1], x];
  }
  first = first.map((angle) => angle * DEGREES);
  const second = [first[0] + 180, 180 - first[1], first[2] + 180];
  const near = (angles: number[]) => angles.map((angle, k) => angle - 360 * Math.round((angle - before[k]) / 360));
  const far = (angles: number[]) => angles.reduce((sum, angle, k) => sum + (angle - before[k]) ** 2, 0);
  const [one, other] = [near(first), near(second)];
  return far(one) <= far(other) ? one : other;
}

/** A person's joints as a .bvh holds them: rotations and places as seen from the parent. */
class Bones {
  readonly order: number[] = []; // of joints in the file: each below its parent
  readonly offsets: Float32Array[]; // from the parent at rest, metres
  readonly moves: boolean[]; // whether a joint carries positions
  private readonly count: number;
  private readonly wxyz?: Float32Array; // (T, posed, 4)
  private readonly posed: number; // joints with rotations
  private readonly places: Float32Array; // (T, J, 3) metres from the parent, in its frame

  constructor(data: Data, private readonly person: PersonData) {
    const { parents, frames } = person;
    this.count = parents.length;
    this.wxyz = person.rotations && data.floats(person.rotations);
    this.posed = this.wxyz ? this.wxyz.length / frames / 4 : 0;
    this.descend(parents.findIndex((parent) => parent < 0));
    this.places = this.placesFromParents(person.motion ? data.motion(person.motion) : data.floats(person.joints!));
    const given = person.offsets && data.floats(person.offsets);
    this.offsets = parents.map((_, j) => (given && j < this.posed ? given.slice(j * 3, j * 3 + 3) : this.place(0, j)));
    const tolerance = RIGID + 2 * Math.max(...(person.joints?.scale ?? [0.001]));
    this.moves = parents.map((parent, j) => parent < 0 || this.leavesItsOffset(j, tolerance));
  }

  children(joint: number) {
    return this.person.parents.flatMap((parent, child) => (parent === joint ? [child] : []));
  }

  place(t: number, j: number) {
    return this.places.slice((t * this.count + j) * 3, (t * this.count + j) * 3 + 3);
  }

  /** Rotation from the parent's frame; none where it is not known. */
  rotation(t: number, j: number, out: Quaternion) {
    const i = (t * this.posed + j) * 4;
    const { wxyz } = this;
    return wxyz && j < this.posed ? out.set(wxyz[i + 1], wxyz[i + 2], wxyz[i + 3], wxyz[i]).normalize() : out.identity();
  }

  private descend(joint: number) {
    this.order.push(joint);
    for (const child of this.children(joint)) this.descend(child);
  }

  private placesFromParents(joints: Float32Array) {
    const { count, order, person: { parents, frames } } = this;
    const out = new Float32Array(frames * count * 3);
    const global = parents.map(() => new Quaternion());
    const inverse = new Quaternion();
    const v = new Vector3();
    const from = new Vector3();
    for (let t = 0; t < frames; ++t) {
      for (const j of order) {
        v.fromArray(joints, (t * count + j) * 3);
        this.rotation(t, j, global[j]);
        if (parents[j] >= 0) {
          const above = global[parents[j]];
          v.sub(from.fromArray(joints, (t * count + parents[j]) * 3)).applyQuaternion(inverse.copy(above).invert());
          global[j].premultiply(above);
        }
        v.toArray(out, (t * count + j) * 3);
      }
    }
    return out;
  }

  private leavesItsOffset(j: number, tolerance: number) {
    for (let t = 0; t < this.person.frames; ++t) {
      if (this.place(t, j).some((x, k) => Math.abs(x - this.offsets[j][k]) > tolerance)) return true;
    }
    return false;
  }
}

/** The lines of a joint and of those below it. */
function jointLines(bones: Bones, names: string[], j: number, depth: number): string[] {
  const indent = '\t'.repeat(depth);
  const offset = depth === 0 ? [0, 0, 0] : centimetres(bones.offsets[j]);
  const children = bones.children(j);
  return [
    `${indent}${depth === 0 ? 'ROOT' : 'JOINT'} ${names[j].replace(/[\s{}]/g, '_') || `joint${j}`}`, `${indent}{`, `${indent}\tOFFSET ${text(offset)}`,
    `${indent}\tCHANNELS ${bones.moves[j] ? '6 Xposition Yposition Zposition ' : '3 '}Zrotation Yrotation Xrotation`,
    ...children.flatMap((child) => jointLines(bones, names, child, depth + 1)),
    ...(children.length === 0 ? endSiteLines(offset, indent) : []),
    `${indent}}`,
  ];
}

/** An end site that goes on as the bone to its joint does, of which `offset` is (centimetres). */
function endSiteLines(offset: number[], indent: string): string[] {
  const length = Math.hypot(...offset);
  const end = length > 1e-4 ? offset.map((x) => (x / length) * LEAF * CENTIMETRES) : [0, LEAF * CENTIMETRES, 0];
  return [`${indent}\tEnd Site`, `${indent}\t{`, `${indent}\t\tOFFSET ${text(end)}`, `${indent}\t}`];
}

function frameLines(bones: Bones, frames: number): string[] {
  const angles = bones.offsets.map(() => [0, 0, 0]);
  const q = new Quaternion();
  const m = new Matrix4();
  return Array.from({ length: frames }, (_, t) => bones.order.map((j) => {
    angles[j] = eulerAngles(bones.rotation(t, j, q), angles[j], m);
    return (bones.moves[j] ? text(centimetres(bones.place(t, j))) + ' ' : '') + text(angles[j]);
  }).join(' '));
}

/** A person's motion as a Biovision hierarchy, in centimetres and degrees, +Y up, as `write_bvh` of inhabit/io/bvh.h has it: a
 *  joint whose bone changes from frame to frame, and every joint where rotations are not known, carries positions too. */
export function bvhOf(data: Data, person: PersonData): string {
  const { name, names, parents, frames, rate } = person;
  if (parents.filter((parent) => parent < 0).length !== 1) throw new Error(`${name}: a .bvh holds one root, this skeleton has others`);
  const bones = new Bones(data, person);
  return ['HIERARCHY', ...jointLines(bones, names, bones.order[0], 0),
    'MOTION', `Frames: ${frames}`, `Frame Time: ${(1 / rate).toFixed(9)}`, ...frameLines(bones, frames)].join('\n') + '\n';
}
