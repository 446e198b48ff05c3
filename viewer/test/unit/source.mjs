// A module of the page's source for node: `await source('open_npz.ts')`.
import { build } from 'esbuild';
import { fileURLToPath } from 'node:url';

export async function source(name) {
  const entry = fileURLToPath(new URL(`../../src/${name}`, import.meta.url));
  const { outputFiles } = await build({ entryPoints: [entry], bundle: true, write: false, format: 'esm', target: 'es2022', logLevel: 'error' });
  return import(`data:text/javascript;base64,${Buffer.from(outputFiles[0].contents).toString('base64')}`);
}

/** SMPL's first 22 joints, and where they are in somebody who stands with arms stretched sideways (metres, about). */
export const standard = {
  names: ['pelvis', 'left_hip', 'right_hip', 'spine1', 'left_knee', 'right_knee', 'spine2', 'left_ankle', 'right_ankle', 'spine3', 'left_foot',
    'right_foot', 'neck', 'left_collar', 'right_collar', 'head', 'left_shoulder', 'right_shoulder', 'left_elbow', 'right_elbow', 'left_wrist', 'right_wrist'],
  parents: [-1, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 9, 9, 12, 13, 14, 16, 17, 18, 19],
};
export const standing = [[0, 0.95, 0], [0.07, 0.86, 0], [-0.07, 0.86, 0], [0, 1.05, 0], [0.1, 0.48, 0], [-0.1, 0.48, 0], [0, 1.2, 0], [0.1, 0.08, 0],
  [-0.1, 0.08, 0], [0, 1.25, 0], [0.1, 0.02, 0.13], [-0.1, 0.02, 0.13], [0, 1.47, 0], [0.08, 1.37, 0], [-0.08, 1.37, 0], [0, 1.6, 0.03],
  [0.19, 1.4, 0], [-0.19, 1.4, 0], [0.45, 1.4, 0], [-0.45, 1.4, 0], [0.7, 1.4, 0], [-0.7, 1.4, 0]];

// Which of the standard joints Human3.6M's 17 are, in its order.
const OF_HUMAN36M = [0, 2, 5, 8, 1, 4, 7, 6, 9, 12, 15, 16, 18, 20, 17, 19, 21];
export const standing17 = OF_HUMAN36M.map((j) => standing[j]);

standard.offsets = standing.flatMap((place, j) => place.map((x, k) => (j === 0 ? 0 : x - standing[standard.parents[j]][k])));
