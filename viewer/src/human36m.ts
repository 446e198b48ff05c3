// Human3.6M's joints (inhabit/motion/human36m_joints.cpp): row among the 32 of its files, name, parent among the 17 that move.
const JOINTS: [row: number, name: string, parent: number][] = [
  [0, 'Hips', -1], [1, 'RightUpLeg', 0], [2, 'RightLeg', 1], [3, 'RightFoot', 2], [6, 'LeftUpLeg', 0], [7, 'LeftLeg', 4], [8, 'LeftFoot', 5],
  [12, 'Spine', 0], [13, 'Spine1', 7], [14, 'Neck', 8], [15, 'Head', 9], [17, 'LeftArm', 8], [18, 'LeftForeArm', 11], [19, 'LeftHand', 12],
  [25, 'RightArm', 8], [26, 'RightForeArm', 14], [27, 'RightHand', 15],
];
const RIGHT_HIP = 1;
const LEFT_HIP = 4;
const HEAD = 10;

/** The skeleton of the 17, parents first, and which of the `count` (17 or 32) joints of a file these are. */
export function human36m(count: number) {
  return {
    names: JOINTS.map(([, name]) => name),
    parents: JOINTS.map(([, , parent]) => parent),
    rows: JOINTS.map(([row], j) => (count === 32 ? row : j)),
    head: HEAD,
  };
}

/** Whether joints (T, J, 3) lie as Human3.6M numbers them: hips on both sides of the first joint, near it as seen from the head. */
export function inHuman36mOrder(joints: ArrayLike<number>, count: number): boolean {
  if (count !== 17 && count !== 32) return false;
  const { rows } = human36m(count);
  const stride = count * 3;
  const fromPelvis = (joint: number) => {
    const at = rows[joint] * 3;
    let sum = 0;
    for (let i = 0; i < joints.length; i += stride) sum += Math.hypot(joints[i + at] - joints[i], joints[i + at + 1] - joints[i + 1], joints[i + at + 2] - joints[i + 2]);
    return sum / (joints.length / stride);
  };
  const [right, left, head] = [RIGHT_HIP, LEFT_HIP, HEAD].map(fromPelvis);
  return right > 0.08 * head && right < 0.4 * head && left > 0.6 * right && left < 1.7 * right;
}
