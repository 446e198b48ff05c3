import type { StandardData } from './data';
import { human36m, inHuman36mOrder } from './human36m';
import { pointsUpright } from './kinematics';
import type { NumpyArray } from './npz';
import type { Motion } from './opened';

// Metres from the root to the farthest joint along the bones of a person (unit_of_person in inhabit/io/clip_npz.cpp).
const LEAST_REACH = 0.5;
const MOST_REACH = 2.6;

/** Of joints (T, J, 3), the joints in `rows`. */
function picked(values: ArrayLike<number>, count: number, rows: number[]): Float32Array {
  const frames = values.length / count / 3;
  const out = new Float32Array(frames * rows.length * 3);
  for (let t = 0, at = 0; t < frames; ++t) {
    for (const row of rows) for (let k = 0; k < 3; ++k) out[at++] = values[(t * count + row) * 3 + k];
  }
  return out;
}

/** From the root to the farthest joint along bones of their mean lengths; parents come before their children. */
export function longestReach(joints: Float32Array, parents: number[]): number {
  const stride = parents.length * 3;
  const reach: number[] = [];
  parents.forEach((parent, j) => {
    if (parent < 0) return reach.push(0);
    let sum = 0;
    for (let i = 0; i < joints.length; i += stride) {
      const [a, b] = [i + j * 3, i + parent * 3];
      sum += Math.hypot(joints[a] - joints[b], joints[a + 1] - joints[b + 1], joints[a + 2] - joints[b + 2]);
    }
    return reach.push(reach[parent] + sum / (joints.length / stride));
  });
  return Math.max(...reach);
}

/** The unit that makes a person of somebody who is too large in metres; metres where none does. */
export function unitOf(reach: number): { metres: number; name: string } {
  const units = [{ metres: 0.01, name: 'centimetres' }, { metres: 0.001, name: 'millimetres' }];
  const fits = ({ metres }: { metres: number }) => reach > MOST_REACH && reach * metres > LEAST_REACH && reach * metres < MOST_REACH;
  return units.find(fits) ?? { metres: 1, name: 'metres' };
}

/** Whether the back, from the root (the first joint) to the head, points along +Z rather than +Y, as the mean of unit vectors. */
export function isZUp(joints: Float32Array, count: number, head: number): boolean {
  let [y, z] = [0, 0];
  for (let i = 0; i < joints.length; i += count * 3) {
    const back = [0, 1, 2].map((k) => joints[i + head * 3 + k] - joints[i + k]);
    const length = Math.max(1e-9, Math.hypot(...back));
    y += back[1] / length;
    z += back[2] / length;
  }
  return z > y;
}

/** Motion of joint positions alone, (T, 22+, 3), the first 22 in SMPL's order, or Human3.6M's 17 or 32, in metres, centimetres or
 *  millimetres, +Y or +Z up. What is assumed goes to `notes`. */
export function positionsMotion(array: NumpyArray, name: string, rate: number, standard: StandardData, notes: string[]): Motion {
  const { shape } = array;
  if (array.words || shape.length !== 3 || shape[2] !== 3) throw new Error('its joint positions are not (T, J, 3)');
  const [frames, count] = shape;
  if (frames === 0) throw new Error('has no frames');
  const known = inHuman36mOrder(array.values, count);
  if (!known && count < standard.names.length) {
    throw new Error(`its joint positions are of ${count} joints: without joint_names, parents and offsets SMPL's first 22 are needed, or Human3.6M's 17 in their order`);
  }
  const { names, parents, rows, head } = known ? human36m(count)
    : { names: standard.names, parents: standard.parents, rows: standard.names.map((_, j) => j), head: standard.names.indexOf('head') };
  notes.push(`joint positions without rotations, taken for ${known ? "Human3.6M's 17" : "SMPL's first 22"} joints`);
  const joints = picked(array.values, count, rows);
  const unit = unitOf(longestReach(joints, parents));
  if (unit.metres !== 1) {
    for (let i = 0; i < joints.length; ++i) joints[i] *= unit.metres;
    notes.push(`lengths taken for ${unit.name} by the size of the person`);
  }
  if (isZUp(joints, parents.length, head)) {
    pointsUpright(joints);
    notes.push('+Z is up in the file: rotated to +Y');
  }
  return { name, rate, names, parents, joints };
}
