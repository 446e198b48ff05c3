import { Quaternion, Vector3 } from 'three';

/** Quaternions (w x y z) of axis-angle vectors, or of rotation matrices row by row where `matrices` holds. */
export function quaternionsOf(values: ArrayLike<number>, matrices: boolean): Float32Array {
  const width = matrices ? 9 : 3;
  const count = values.length / width;
  const out = new Float32Array(count * 4);
  for (let i = 0; i < count; ++i) {
    const at = (k: number) => values[i * width + k];
    if (!matrices) {
      const angle = Math.hypot(at(0), at(1), at(2));
      const factor = angle > 1e-9 ? Math.sin(angle / 2) / angle : 0.5;
      out.set([Math.cos(angle / 2), factor * at(0), factor * at(1), factor * at(2)], i * 4);
      continue;
    }
    const [a, b, c] = [at(0), at(4), at(8)];
    const sized = (q: number) => Math.sqrt(Math.max(0, q)) / 2;
    const sign = (q: number) => (q < 0 ? -1 : 1);
    out.set([sized(1 + a + b + c), sign(at(7) - at(5)) * sized(1 + a - b - c), sign(at(2) - at(6)) * sized(1 - a + b - c),
      sign(at(3) - at(1)) * sized(1 - a - b + c)], i * 4);
  }
  return out;
}

/** Joints (T, J, 3) of rotations (T, J, 4) w x y z, each joint's relative to its parent's, and root places (T, 3): parents come
 *  before their children. */
export function jointsOf(rotations: Float32Array, roots: Float32Array, offsets: ArrayLike<number>, parents: number[]): Float32Array {
  const count = parents.length;
  const frames = roots.length / 3;
  const out = new Float32Array(frames * count * 3);
  const global = parents.map(() => new Quaternion());
  const place = parents.map(() => new Vector3());
  for (let t = 0; t < frames; ++t) {
    parents.forEach((parent, j) => {
      const i = (t * count + j) * 4;
      global[j].set(rotations[i + 1], rotations[i + 2], rotations[i + 3], rotations[i]).normalize();
      if (parent < 0) place[j].fromArray(roots, t * 3);
      else {
        place[j].set(offsets[j * 3], offsets[j * 3 + 1], offsets[j * 3 + 2]).applyQuaternion(global[parent]).add(place[parent]);
        global[j].premultiply(global[parent]);
      }
      place[j].toArray(out, (t * count + j) * 3);
    });
  }
  return out;
}

/** From +Z up to +Y up, in place: points (n, 3). */
export function pointsUpright(points: Float32Array) {
  for (let i = 0; i < points.length; i += 3) [points[i + 1], points[i + 2]] = [points[i + 2], -points[i + 1]];
}

/** The same of global rotations (T, J, 4), of which every `stride`-th is rotated. */
export function rotationsUpright(wxyz: Float32Array, stride: number) {
  const h = Math.SQRT1_2; // -90 degrees about x, from the left
  for (let i = 0; i < wxyz.length; i += 4 * stride) {
    const [w, x, y, z] = wxyz.subarray(i, i + 4);
    wxyz.set([h * (w + x), h * (x - w), h * (y + z), h * (z - y)], i);
  }
}
