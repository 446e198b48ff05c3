import type { NumpyArray } from './npz';

export type NpzArrays = Map<string, NumpyArray>;

// Names of joint positions besides `joints`, and how many joints a person has (inhabit/io/joint_array.cpp).
const NAMES = ['keypoints', 'positions', 'poses_3d', 'joint_positions', 'joints_3d', 'joints3d', 'pose_3d', 'keypoints_3d', 'keypoints3d', 'poses3d',
  'kpts', 'kpts_3d', 'arr_0', 'joints_pos', 'joint_position', 'pose3d', 'kp3d', 'joint_pos', 'joints_position', 'positions_3d',
  'joint_coords', 'jointpositions', 'global_positions', 'pred_joints', 'new_joints'];
// Of these, rows of numbers may be anything: features, rotations.
const VAGUE_NAMES = ['xyz', 'motion', 'motions', 'pred', 'preds', 'prediction', 'predictions', 'output'];
const LEAST = 5;
const MOST = 256;

const isCount = (joints: number) => Number.isInteger(joints) && joints >= LEAST && joints <= MOST;

const isFlattened = ({ shape }: NumpyArray) => shape.length === 2 && isCount(shape[1] / 3);

const areRows = ({ shape, words }: NumpyArray) =>
  !words && (shape.length === 3 || shape.length === 4) && shape.at(-1) === 3 && isCount(shape.at(-2)!);

const isJoints = (array: NumpyArray) => areRows(array) || (!array.words && isFlattened(array));

function nameOfJoints(arrays: NpzArrays): string | undefined {
  if (arrays.has('joints')) return 'joints';
  const named = (names: string[], accepted: (array: NumpyArray) => boolean) => names
    .flatMap((name) => [...arrays.keys()].filter((key) => key.toLowerCase() === name && accepted(arrays.get(key)!)))[0] as string | undefined;
  return named(['joints', ...NAMES], isJoints) ?? named(VAGUE_NAMES, areRows);
}

/** The arrays with that of joint positions, whatever its name, as `joints`: (T, J, 3), or (S, T, J, 3) of several motions, also where
 *  it was flattened. As they are where there is none. */
export function withJointArray(arrays: NpzArrays): NpzArrays {
  const name = nameOfJoints(arrays);
  if (name === undefined) return arrays;
  const array = arrays.get(name)!;
  const out = new Map(arrays);
  out.delete(name);
  return out.set('joints', isFlattened(array) ? { ...array, shape: [array.shape[0], array.shape[1] / 3, 3] } : array);
}
