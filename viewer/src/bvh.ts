import { Matrix4, Quaternion, Vector3 } from 'three';
import type { Data, PersonData } from './data';

const CENTIMETRES = 100;
const DEGREES = 180 / Math.PI;
const LEAF = 0.05; // metres of an end site
const RIGID = 0.0004; // metres by which a bone may differ from itself before its joint carries positions

const text = (numbers: ArrayLike<number>) => Array.from(numbers, (x) => x.toFixed(6)).join(' ');

/** Angles (degrees) about z, y, x with R = Rz Ry Rx, the nearer of the two solutions to `before`, without jumps of 360 degrees. */
function eulerAngles(q: Quaternion, before: number[], m: Matrix4): number[] {
  const e = m.makeRotationFromQuaternion(q).elements; // column by column
  const cosine = Math.hypot(e[0], e[1]);
  let first = [Math.atan2(e[1], e[0]), Math.atan2(-e[2], cosine), Math.atan2(e[6], e[10])];
  if (cosine < 1e-7) { // z and x rotate about one axis: x stays where it was
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

/** A person's motion as a Biovision hierarchy, in centimetres and degrees, +Y up, as `write_bvh` of inhabit/io/bvh.h has it: a
 *  joint whose bone changes from frame to frame, and every joint where rotations are not known, carries positions too. */
export function bvhOf(data: Data, person: PersonData): string {
  const { names, parents, frames, rate } = person;
  const count = parents.length;
  if (parents.filter((parent) => parent < 0).length !== 1) throw new Error(`${person.name}: a .bvh holds one root, this skeleton has others`);
  const joints = person.motion ? data.motion(person.motion) : data.floats(person.joints!);
  const wxyz = person.rotations && data.floats(person.rotations);
  const posed = wxyz ? wxyz.length / frames / 4 : 0; // joints with rotations
  const local = (t: number, j: number, out: Quaternion) => {
    const i = (t * posed + j) * 4;
    return j < posed ? out.set(wxyz![i + 1], wxyz![i + 2], wxyz![i + 3], wxyz![i]).normalize() : out.identity();
  };

  // Joints in the order of the file, each below its parent.
  const order: number[] = [];
  const walk = (j: number) => {
    order.push(j);
    parents.forEach((parent, child) => parent === j && walk(child));
  };
  walk(parents.findIndex((parent) => parent < 0));

  // Places as seen from the parent, in its frame.
  const places = new Float32Array(frames * count * 3);
  const global = names.map(() => new Quaternion());
  const q = new Quaternion();
  const v = new Vector3();
  const from = new Vector3();
  for (let t = 0; t < frames; ++t) {
    for (const j of order) {
      v.fromArray(joints, (t * count + j) * 3);
      local(t, j, global[j]);
      if (parents[j] >= 0) {
        const above = global[parents[j]];
        v.sub(from.fromArray(joints, (t * count + parents[j]) * 3)).applyQuaternion(q.copy(above).invert());
        global[j].premultiply(above);
      }
      v.toArray(places, (t * count + j) * 3);
    }
  }
  const given = person.offsets && data.floats(person.offsets);
  const steps = person.joints?.scale ?? [0.001];
  const offsets = names.map((_, j) => {
    if (given && j < posed) return given.slice(j * 3, j * 3 + 3);
    return places.slice(j * 3, j * 3 + 3);
  });
  const moves = names.map((_, j) => {
    if (parents[j] < 0) return true;
    const tolerance = RIGID + 2 * Math.max(...steps);
    for (let t = 0; t < frames; ++t) for (let k = 0; k < 3; ++k) {
      if (Math.abs(places[(t * count + j) * 3 + k] - offsets[j][k]) > tolerance) return true;
    }
    return false;
  });

  const lines = ['HIERARCHY'];
  const write = (j: number, depth: number) => {
    const indent = '\t'.repeat(depth);
    const offset = parents[j] < 0 ? [0, 0, 0] : Array.from(offsets[j], (x) => x * CENTIMETRES);
    lines.push(`${indent}${parents[j] < 0 ? 'ROOT' : 'JOINT'} ${names[j].replace(/[\s{}]/g, '_') || `joint${j}`}`, `${indent}{`, `${indent}\tOFFSET ${text(offset)}`,
      `${indent}\tCHANNELS ${moves[j] ? '6 Xposition Yposition Zposition ' : '3 '}Zrotation Yrotation Xrotation`);
    const children = parents.flatMap((parent, child) => (parent === j ? [child] : []));
    for (const child of children) write(child, depth + 1);
    if (children.length === 0) {
      const length = Math.hypot(...offset);
      const end = length > 1e-4 ? offset.map((x) => (x / length) * LEAF * CENTIMETRES) : [0, LEAF * CENTIMETRES, 0];
      lines.push(`${indent}\tEnd Site`, `${indent}\t{`, `${indent}\t\tOFFSET ${text(end)}`, `${indent}\t}`);
    }
    lines.push(`${indent}}`);
  };
  write(order[0], 0);
  lines.push('MOTION', `Frames: ${frames}`, `Frame Time: ${(1 / rate).toFixed(9)}`);
  const before = names.map(() => [0, 0, 0]);
  const m = new Matrix4();
  for (let t = 0; t < frames; ++t) {
    lines.push(order.map((j) => {
      before[j] = eulerAngles(local(t, j, q), before[j], m);
      const place = places.subarray((t * count + j) * 3, (t * count + j) * 3 + 3);
      return (moves[j] ? text(place.map((x) => x * CENTIMETRES)) + ' ' : '') + text(before[j]);
    }).join(' '));
  }
  return lines.join('\n') + '\n';
}
