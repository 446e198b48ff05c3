import * as THREE from 'three';
import type { Person } from './person';

const PATH_WIDTH = 0.025; // metres
const LIFT = 0.006; // above the ground

/** The root's path on the ground as a ribbon, and (with `prints`) a print wherever a foot stood. */
export function makeTrails(person: Person, ground: number, prints = true): THREE.Group {
  const group = new THREE.Group();
  const joints = person.joints;
  const stride = person.parents.length * 3;
  const frames = joints.length / stride;
  const material = (opacity: number) =>
    new THREE.MeshBasicMaterial({
      color: person.color, transparent: true, opacity, depthWrite: false, side: THREE.DoubleSide,
      polygonOffset: true, polygonOffsetFactor: -2, polygonOffsetUnits: -2,
    });

  // Ribbon: points at least 2 cm apart, each with its normal on the ground.
  const path: number[] = [];
  for (let f = 0; f < frames; ++f) {
    const x = joints[f * stride];
    const z = joints[f * stride + 2];
    const n = path.length;
    if (n === 0 || Math.hypot(x - path[n - 2], z - path[n - 1]) > 0.02) path.push(x, z);
  }
  const points = path.length / 2;
  if (points > 1) {
    const positions = new Float32Array(points * 6);
    const index: number[] = [];
    for (let i = 0; i < points; ++i) {
      const before = Math.max(i - 1, 0);
      const after = Math.min(i + 1, points - 1);
      let nx = -(path[after * 2 + 1] - path[before * 2 + 1]);
      let nz = path[after * 2] - path[before * 2];
      const length = Math.hypot(nx, nz) || 1;
      nx *= PATH_WIDTH / 2 / length;
      nz *= PATH_WIDTH / 2 / length;
      positions.set([path[i * 2] + nx, ground + LIFT, path[i * 2 + 1] + nz, path[i * 2] - nx, ground + LIFT, path[i * 2 + 1] - nz], i * 6);
      if (i > 0) index.push(i * 2 - 2, i * 2 - 1, i * 2, i * 2, i * 2 - 1, i * 2 + 1);
    }
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(positions, 3));
    geometry.setIndex(index);
    group.add(new THREE.Mesh(geometry, material(0.55)));
  }

  const soles = prints ? [...footprints(person, 'left', ground), ...footprints(person, 'right', ground)] : [];
  if (soles.length > 0) {
    // A sole from heel (0) to toe (1), as wide as it is long; a print scales it.
    const sole = new THREE.Shape();
    sole.moveTo(-0.16, 0.02);
    sole.bezierCurveTo(-0.16, -0.22, 0.16, -0.22, 0.16, 0.02);
    sole.bezierCurveTo(0.16, 0.3, 0.22, 0.4, 0.23, 0.62);
    sole.bezierCurveTo(0.23, 1.02, -0.2, 1.02, -0.2, 0.62);
    sole.bezierCurveTo(-0.2, 0.42, -0.14, 0.3, -0.16, 0.02);
    const shape = new THREE.ShapeGeometry(sole, 10).rotateX(Math.PI / 2); // +y of the shape becomes +z
    const mesh = new THREE.InstancedMesh(shape, material(0.4), soles.length);
    soles.forEach((matrix, i) => mesh.setMatrixAt(i, matrix));
    mesh.frustumCulled = false;
    group.add(mesh);
  }
  for (const child of group.children) child.renderOrder = 1;
  return group;
}

/** One matrix per stretch of at least 0.1 s in which the foot's toe joint rests near the ground. */
function footprints(person: Person, side: string, ground: number): THREE.Matrix4[] {
  const names = person.data_.names.map((name) => name.toLowerCase());
  const toe = names.indexOf(side + '_foot');
  const ankle = names.indexOf(side + '_ankle');
  if (toe < 0 || ankle < 0) return [];
  const { joints } = person;
  const rate = person.data_.rate;
  const stride = person.parents.length * 3;
  const frames = joints.length / stride;
  const out: THREE.Matrix4[] = [];
  let first = -1;
  for (let f = 1; f <= frames; ++f) {
    const here = f * stride + toe * 3;
    const rests = f < frames && joints[here + 1] < ground + 0.1 &&
      Math.hypot(joints[here] - joints[here - stride], joints[here + 2] - joints[here + 2 - stride]) * rate < 0.25;
    if (rests && first < 0) first = f;
    if (rests || first < 0) continue;
    if ((f - first) / rate > 0.1) {
      const middle = Math.floor((first + f - 1) / 2) * stride;
      const t = middle + toe * 3;
      const k = middle + ankle * 3;
      const dx = joints[t] - joints[k];
      const dz = joints[t + 2] - joints[k + 2];
      out.push(new THREE.Matrix4().compose(
        new THREE.Vector3(joints[k], ground + LIFT + 0.001, joints[k + 2]),
        new THREE.Quaternion().setFromAxisAngle(new THREE.Vector3(0, 1, 0), Math.atan2(dx, dz)),
        new THREE.Vector3(side === 'left' ? 0.24 : -0.24, 1, 0.23)));
    }
    first = -1;
  }
  return out;
}
