// Arrays of joint positions as docs/files.md has them: what the page reads of a dropped .npz, as clip_npz.cpp does.
import assert from 'node:assert/strict';
import test from 'node:test';
import { source, standard, standing, standing17 } from './source.mjs';

const { openNpz } = await source('open_npz.ts');

/** An array of nested lists. */
const array = (nested) => {
  const shape = [];
  for (let part = nested; Array.isArray(part); part = part[0]) shape.push(part.length);
  return { shape, values: Float64Array.from([nested].flat(Infinity)) };
};

/** Frames of a person who goes 10 cm a frame along x. */
const frames = (pose, change = (place) => place, count = 4) => Array.from({ length: count }, (_, t) => pose.map(([x, y, z]) => change([x + 0.1 * t, y, z])));
const read = (named) => openNpz(new Map([['fps', array(25)], ...Object.entries(named)]), 'walk', standard);
const scaled = (factor) => (place) => place.map((x) => x * factor);
const onZ = ([x, y, z]) => [x, -z, y];

function near(motion, expected) {
  const places = expected.flat(2);
  assert.equal(motion.joints.length, places.length);
  places.forEach((x, i) => assert.ok(Math.abs(motion.joints[i] - x) < 1e-4, `number ${i} is ${motion.joints[i]}, not ${x}`));
}

test('joints have any of the names that networks and data sets give them', () => {
  const names = ['joints', 'keypoints', 'positions', 'poses_3d', 'joint_positions', 'joints_3d', 'joints3d', 'pose_3d', 'poses3d', 'keypoints_3d',
    'keypoints3d', 'kpts', 'kpts_3d', 'joints_pos', 'joint_position', 'arr_0', 'xyz', 'motion', 'pred', 'Joints', 'XYZ', 'poses_3D'];
  for (const name of names) {
    const { motions, notes } = read({ [name]: array(frames(standing)) });
    assert.equal(motions.length, 1, name);
    assert.equal(motions[0].rate, 25);
    assert.deepEqual(motions[0].names, standard.names);
    near(motions[0], frames(standing));
    assert.deepEqual(notes, ["joint positions without rotations, taken for SMPL's first 22 joints"]);
  }
});

test('of several arrays of joints `joints` is read, and else the first of the usual names', () => {
  near(read({ Joints: array(frames(standing, scaled(1.1))), joints: array(frames(standing)) }).motions[0], frames(standing));
  near(read({ pred: array(frames(standing, scaled(1.1))), Keypoints: array(frames(standing)) }).motions[0], frames(standing));
});

test('rotations go before positions, and rows of a few numbers are no joints', () => {
  const still = array(frames(standing).map(() => Array(66).fill(0)));
  assert.ok(read({ poses: still, keypoints: array(frames(standing)) }).motions[0].rotations);
  assert.throws(() => read({ keypoints: array(frames(standing.slice(0, 4))) }), /holds no motion/);
  for (const name of ['positions', 'xyz', 'Joints']) assert.throws(() => read({ [name]: array([[1, 2, 3], [4, 5, 6]]) }), /holds no motion/);
  assert.throws(() => read({ positions: array([Array.from({ length: 300 }, () => [0, 1, 2])]) }), /holds no motion/);
});

test('flattened arrays, more joints than 22, and several motions in one array', () => {
  near(read({ keypoints: array(frames(standing).map((frame) => frame.flat())) }).motions[0], frames(standing));
  near(read({ joints: array(frames(standing).map((frame) => frame.flat())) }).motions[0], frames(standing));
  const more = [...standing, [0, 0, 0], [9, 9, 9]];
  near(read({ positions: array(frames(more)) }).motions[0], frames(standing));
  const { motions, notes } = read({ poses_3d: array([frames(standing), frames(standing, scaled(1.1))]) });
  assert.deepEqual(motions.map(({ name }) => name), ['walk 0', 'walk 1']);
  near(motions[1], frames(standing, scaled(1.1)));
  assert.equal(notes.length, 1, 'said once');
});

test('centimetres and millimetres are told by the size of the person', () => {
  for (const [factor, name] of [[100, 'centimetres'], [1000, 'millimetres']]) {
    const { motions, notes } = read({ joints_3d: array(frames(standing, scaled(factor))) });
    near(motions[0], frames(standing));
    assert.ok(notes.includes(`lengths taken for ${name} by the size of the person`));
  }
  // Neither a child nor somebody far away is in another unit, and what fits none stays.
  for (const change of [scaled(0.6), ([x, y, z]) => [x + 4000, y, z], scaled(20)]) {
    const { motions, notes } = read({ joints: array(frames(standing, change)) });
    assert.ok(Math.abs(motions[0].joints[1] - frames(standing, change)[0][0][1]) < 1e-4);
    assert.equal(notes.length, 1);
  }
});

test('+Z is up where the back points along it', () => {
  const { motions, notes } = read({ keypoints3d: array(frames(standing, (place) => scaled(1000)(onZ(place)))) });
  near(motions[0], frames(standing));
  assert.ok(notes.includes('+Z is up in the file: rotated to +Y'));
});

test("Human3.6M's 17 and 32 joints are known by their hips", () => {
  const rows = [0, 1, 2, 3, 6, 7, 8, 12, 13, 14, 15, 17, 18, 19, 25, 26, 27];
  const standing32 = Array.from({ length: 32 }, (_, row) => standing17[rows.indexOf(row)] ?? [5, 5, 5]);
  for (const pose of [standing17, standing32]) {
    const { motions, notes } = read({ poses_3d: array(frames(pose, (place) => scaled(1000)(onZ(place)))) });
    near(motions[0], frames(standing17));
    assert.equal(motions[0].names[10], 'Head');
    motions[0].parents.forEach((parent, j) => assert.ok(parent < j));
    assert.deepEqual(notes, ["joint positions without rotations, taken for Human3.6M's 17 joints", 'lengths taken for millimetres by the size of the person',
      '+Z is up in the file: rotated to +Y']);
  }
});

test("others with few joints are refused, COCO's 17 among them", () => {
  const coco = [15, 15, 15, 15, 15, 16, 17, 18, 19, 20, 21, 1, 2, 4, 5, 7, 8].map((j, k) => standing[j].map((x) => x + 0.01 * (k % 3)));
  assert.throws(() => read({ keypoints: array(frames(coco)) }), /are of 17 joints: .*Human3\.6M's 17/);
  assert.throws(() => read({ keypoints: array(frames(standing.slice(0, 15))) }), /are of 15 joints/);
  assert.throws(() => read({ joints: { shape: [2, 3], values: new Float32Array(6) } }), /are not \(T, J, 3\)/);
  assert.throws(() => read({ joints: { shape: [0, 22, 3], values: new Float32Array() } }), /has no frames/);
});

test('a rate that is not there is assumed and said', () => {
  const { motions, notes } = openNpz(new Map([['kpts', array(frames(standing))]]), 'walk', standard);
  assert.equal(motions[0].rate, 30);
  assert.equal(notes[0], 'no frame rate in the file: 30 a second assumed');
});
