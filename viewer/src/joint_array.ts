import type { NumpyArray } from './npz';

export type NpzArrays = Map<string, NumpyArray>;

// Names of joint positions in lower case, of which the first that is there counts, and how many joints a person has
// (inhabit/io/joint_array.cpp).
const NAMES = ['joints', 'keypoints', 'positions', 'poses_3d', 'joint_positions', 'joints_3d', 'joints3d', 'pose_3d', 'keypoints_3d', 'keypoints3d',
  'poses3d', 'kpts', 'kpts_3d', 'arr_0', 'joints_pos', 'joint_position', 'xyz', 'motion', 'pred'];
const LEAST = 5;
const MOST = 256;

const isCount = (joints: number) => Number.isInteger(joints) && joints >= LEAST && joints <= MOST;

const isFlattened = ({ shape }: NumpyArray) => shape.length === 2 && isCount(shape[1] / 3);

const isJoints = (array: NumpyArray) => {
  const { shape, words } = array;
  const rows = (shape.length === 3 || shape.length === 4) && shape.at(-1) === 3 && isCount(shape.at(-2)!);
  return !words && (rows || isFlattened(array));
};

function nameOfJoints(arrays: NpzArrays): string | undefined {
  if (arrays.has('joints')) return 'joints';
  for (const usual of NAMES)
    for (const name of [...arrays.keys()].sort()) if (name.toLowerCase() === usual && isJoints(arrays.get(name)!)) return name;
  return undefined;
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
