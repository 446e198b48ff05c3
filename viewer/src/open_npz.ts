import type { StandardData } from './data';
import { NpzArrays as Arrays, withJointArray } from './joint_array';
import { positionsMotion } from './joint_positions';
import { jointsOf, pointsUpright, quaternionsOf, rotationsUpright } from './kinematics';
import type { NumpyArray } from './npz';
import type { Motion, Opened } from './opened';

// Where the pelvis of the mean body of each model rests, metres: trans is measured from there (inhabit/io/clip_npz.cpp).
const PELVIS: Record<string, number[]> = { smplx: [0.003, -0.351, 0.012], smplh: [-0.002, -0.223, 0.028] };

const floats = (array: NumpyArray) => Float32Array.from(array.values);

function first(arrays: Arrays, ...names: string[]) {
  const found = names.find((name) => arrays.has(name));
  return found === undefined ? undefined : arrays.get(found);
}

function rateOf(arrays: Arrays, notes: string[]) {
  const rate = first(arrays, 'mocap_framerate', 'mocap_frame_rate', 'fps', 'framerate', 'frame_rate')?.values[0];
  if (rate === undefined) notes.push('no frame rate in the file: 30 a second assumed');
  return rate ?? 30;
}

/** Whether it has a skeleton of its own. */
const isOwn = (arrays: Arrays) => arrays.has('parents') && arrays.has('offsets');

/** Rotations (T, J, 4) of an array (T, 3J), (T, J, 3) or (T, J, 3, 3). */
function rotationsIn(array: NumpyArray | undefined, what: string) {
  if (!array) return undefined;
  const { shape } = array;
  const matrices = shape.length >= 3 && shape.at(-1) === 3 && shape.at(-2) === 3 && (shape.length === 4 || shape[0] * 9 === array.values.length);
  const frames = shape[0];
  const joints = array.values.length / frames / (matrices ? 9 : 3);
  if (!(frames > 0) || shape.length < 2 || !Number.isInteger(joints)) throw new Error(`its array ${what} is not (T, J, 3)`);
  return { frames, joints, wxyz: quaternionsOf(array.values, matrices) };
}

function actionsOf(arrays: Arrays) {
  const labels = arrays.get('action');
  const names = arrays.get('action_names')?.words;
  if (!labels || !names) return undefined;
  const spans: [number, number][] = [];
  labels.values.forEach((label, t) => spans.at(-1)?.[1] === label || spans.push([t, label]));
  return { names, spans };
}

/** Objects that the clip moves. */
function objectsOf(arrays: Arrays, frames: number): Motion['objects'] {
  const poses = arrays.get('object_pose');
  const names = arrays.get('object_names')?.words ?? [];
  if (!poses || poses.shape.length !== 3 || poses.shape[0] !== frames || poses.shape[1] !== names.length || poses.shape[2] !== 6) return undefined;
  return names.map((name, o) => {
    const of = (from: number) => Float32Array.from({ length: frames * 3 }, (_, i) => poses.values[(Math.floor(i / 3) * names.length + o) * 6 + from + (i % 3)]);
    return { name, places: of(0), rotations: quaternionsOf(of(3), false) };
  });
}

/** One of several motions in one file. */
function sample(arrays: Arrays, s: number, count: number): Arrays {
  const rows = ['trans', 'root_orient', 'pose_body', 'poses', 'joints', 'action', 'object_pose'];
  return new Map([...arrays].map(([name, array]) => {
    const { shape, values, words } = array;
    if (!rows.includes(name) || words || shape[0] !== count) return [name, array];
    const size = values.length / count;
    return [name, { shape: shape.slice(1), values: values.slice(s * size, (s + 1) * size) }];
  }));
}

/** Motion with a skeleton of its own, as inhabit writes it. */
function ownMotion(arrays: Arrays, name: string, rate: number): Motion {
  const names = arrays.get('joint_names')?.words;
  const parents = Array.from(arrays.get('parents')!.values);
  const offsets = floats(arrays.get('offsets')!);
  if (!names || names.length !== parents.length || offsets.length !== 3 * names.length) throw new Error('its skeleton is damaged');
  parents.forEach((parent, j) => {
    if (!Number.isInteger(parent) || parent < -1 || parent >= j) throw new Error('a joint comes before its parent');
  });
  let rotations = rotationsIn(arrays.get('poses'), 'poses')?.wxyz;
  const root = rotationsIn(arrays.get('root_orient'), 'root_orient');
  const body = rotationsIn(arrays.get('pose_body'), 'pose_body');
  if (!rotations && root && body) rotations = together(root, body);
  const given = arrays.get('joints');
  const trans = arrays.get('trans');
  if (!given && !(rotations && trans)) throw new Error('has neither joints nor both rotations and trans');
  const frames = given ? given.shape[0] : trans!.shape[0];
  if (rotations && rotations.length !== frames * names.length * 4) throw new Error('its pose and its skeleton differ in joints');
  const joints = given ? floats(given) : jointsOf(rotations!, rootsOf(trans!, offsets), offsets, parents);
  if (joints.length !== frames * names.length * 3) throw new Error('its joints and its skeleton differ in number');
  const objects = objectsOf(arrays, frames);
  if (arrays.get('up')?.words?.[0] === 'z') {
    pointsUpright(joints);
    if (rotations) rotationsUpright(rotations, names.length);
    for (const { places, rotations: own } of objects ?? []) {
      pointsUpright(places);
      rotationsUpright(own, 1);
    }
  }
  return { name, rate, names, parents, joints, rotations, offsets, actions: actionsOf(arrays), objects };
}

const rootsOf = (trans: NumpyArray, offset: ArrayLike<number>) => floats(trans).map((x, i) => x + offset[i % 3]);

function together(root: { frames: number; joints: number; wxyz: Float32Array }, body: typeof root) {
  if (root.joints !== 1 || root.frames !== body.frames) throw new Error('root_orient and pose_body differ in their frames');
  const count = body.joints + 1;
  const out = new Float32Array(root.frames * count * 4);
  for (let t = 0; t < root.frames; ++t) {
    out.set(root.wxyz.subarray(t * 4, t * 4 + 4), t * count * 4);
    out.set(body.wxyz.subarray(t * body.joints * 4, (t + 1) * body.joints * 4), (t * count + 1) * 4);
  }
  return out;
}

/** Motion of the AMASS and SMPL families, on the built-in skeleton. */
function smplMotion(arrays: Arrays, name: string, rate: number, standard: StandardData, notes: string[]): Motion {
  const whole = rotationsIn(first(arrays, 'poses', 'pose'), 'poses');
  const root = rotationsIn(first(arrays, 'root_orient', 'global_orient', 'orient', 'human_orient'), 'root_orient');
  const body = rotationsIn(first(arrays, 'pose_body', 'body_pose', 'human_pose'), 'pose_body');
  const count = standard.names.length;
  let all: Float32Array;
  let inFile: number;
  if (root && body) [all, inFile] = [together(root, body), body.joints + 1];
  else if (whole) [all, inFile] = [whole.wxyz, whole.joints];
  else throw new Error('holds no motion: neither poses, nor root_orient and pose_body, nor joints');
  const frames = all.length / 4 / inFile;
  if (inFile < count) throw new Error(`its pose has ${inFile} joints, ${count} are needed`);
  const rotations = new Float32Array(frames * count * 4);
  for (let t = 0; t < frames; ++t) rotations.set(all.subarray(t * inFile * 4, (t * inFile + count) * 4), t * count * 4);
  const given = first(arrays, 'trans', 'transl', 'translation', 'human_transl');
  if (!given) notes.push('no translation in the file: the pelvis stays in place');
  const trans = given ?? { shape: [frames, 3], values: new Float32Array(frames * 3) };
  if (trans.values.length !== frames * 3) throw new Error('trans is not (T, 3) for the frames of the pose');
  const model = arrays.get('surface_model_type')?.words?.[0]?.toLowerCase() ?? '';
  const isX = model ? /smpl-?x/.test(model) : inFile === 55 || arrays.has('pose_jaw') || arrays.has('jaw_pose');
  const roots = rootsOf(trans, PELVIS[isX ? 'smplx' : 'smplh']);
  // The mean of where the pelvis' own up points; of who lies, the axis along which the pelvis moves least.
  let [y, z] = [0, 0];
  for (let i = 0; i < rotations.length; i += 4 * count) {
    const [w, a, b, c] = rotations.subarray(i, i + 4);
    y += (1 - 2 * (a * a + c * c)) / frames;
    z += (2 * (b * c + w * a)) / frames;
  }
  const spread = (axis: number) => {
    const along = roots.filter((_, i) => i % 3 === axis);
    return along.reduce((most, x) => Math.max(most, x), -Infinity) - along.reduce((least, x) => Math.min(least, x), Infinity);
  };
  if (Math.max(y, z) < 0.4 ? spread(2) < spread(1) : z > y) {
    pointsUpright(roots);
    rotationsUpright(rotations, count);
    notes.push('+Z is up in the file: rotated to +Y');
  }
  const offsets = Float32Array.from(standard.offsets);
  const joints = jointsOf(rotations, roots, offsets, standard.parents);
  return { name, rate, names: standard.names, parents: standard.parents, joints, rotations, offsets };
}

const MOST_SAMPLES = 50;

// What a file of the SMPL family has.
const POSES = ['poses', 'pose', 'root_orient', 'global_orient', 'orient', 'human_orient', 'pose_body', 'body_pose', 'human_pose'];

/** One motion; what is assumed goes to `notes`. */
function motionIn(arrays: Arrays, name: string, standard: StandardData, notes: string[]): Motion {
  const rate = rateOf(arrays, notes);
  if (isOwn(arrays)) return ownMotion(arrays, name, rate);
  const joints = first(arrays, ...POSES) ? undefined : arrays.get('joints');
  return joints ? positionsMotion(joints, name, rate, standard, notes) : smplMotion(arrays, name, rate, standard, notes);
}

/** The motions in the arrays of an .npz (inhabit/io/clip_npz.h). */
export function openNpz(arrays: Arrays, name: string, standard: StandardData): Opened {
  const all = isOwn(arrays) || first(arrays, ...POSES) ? arrays : withJointArray(arrays);
  const joints = all.get('joints');
  const count = joints?.shape.length === 4 ? joints.shape[0] : 0;
  const samples = count > 0 ? Array.from({ length: Math.min(count, MOST_SAMPLES) }, (_, s) => sample(all, s, count)) : [all];
  const notes: string[] = []; // of the first: others are as it is
  const motions = samples.map((one, s) => motionIn(one, count > 1 ? `${name} ${s}` : name, standard, s === 0 ? notes : []));
  return { motions, parts: [], notes };
}
