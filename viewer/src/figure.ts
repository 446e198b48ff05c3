import * as THREE from 'three';

// Sizes in metres of what stands at a joint (ball: across, along the bone, deep; `ahead` of the joint) and of the limb
// from its parent to it (across, deep).
interface Part { limb: [number, number]; ball: [number, number, number]; ahead?: number }

const round = (limb: number, ball: number): Part => ({ limb: [limb, limb], ball: [ball, ball, ball] });
const trunk = (...ball: [number, number, number]): Part => ({ limb: [0, 0], ball });
const parts: [RegExp, Part][] = [
  [/^pelvis|^hips$/, trunk(0.128, 0.115, 0.1)],
  [/^spine1/, trunk(0.117, 0.135, 0.093)],
  [/^spine2/, trunk(0.127, 0.15, 0.1)],
  [/^spine3/, trunk(0.142, 0.15, 0.104)],
  [/^neck/, { limb: [0.08, 0.07], ball: [0.054, 0.054, 0.054] }],
  [/^head/, { limb: [0.052, 0.052], ball: [0.082, 0.115, 0.095], ahead: 0.075 }],
  [/hip$/, round(0.1, 0.088)],
  [/knee$/, round(0.088, 0.066)],
  [/ankle$/, round(0.064, 0.048)],
  [/foot$/, round(0.047, 0.042)],
  [/collar$/, round(0.06, 0.07)],
  [/shoulder$/, round(0.066, 0.058)],
  [/elbow$/, round(0.057, 0.0435)],
  [/wrist$/, { limb: [0.043, 0.043], ball: [0.036, 0.075, 0.036], ahead: 0.055 }],
];
const other = round(0.03, 0.035);
const thin = round(0.016, 0.026);
const thinHead = round(0.016, 0.05);

const BALL = new THREE.SphereGeometry(1, 14, 10);
const SMALL_BALL = new THREE.SphereGeometry(1, 10, 8);
const STICK = new THREE.CylinderGeometry(1, 1, 1, 10, 1, true).translate(0, 0.5, 0);
const LIMB = new THREE.CylinderGeometry(0.78, 1, 1, 10, 1, true).translate(0, 0.5, 0);

// Before a see-through figure is painted its nearest surface is laid down, so that no limb shows through another.
const SURFACE = new THREE.MeshBasicMaterial({ colorWrite: false, transparent: true });

// Scratch, so that a frame allocates nothing.
const at = new THREE.Vector3();
const from = new THREE.Vector3();
const along = new THREE.Vector3();
const across = new THREE.Vector3();
const deep = new THREE.Vector3();
const side = new THREE.Vector3();
const x = new THREE.Vector3();
const y = new THREE.Vector3();
const z = new THREE.Vector3();
const m = new THREE.Matrix4();

/** A person from joints alone: a thin skeleton, or a full figure of rounded limbs. */
export class Figure {
  private readonly balls: THREE.InstancedMesh;
  private readonly limbs: THREE.InstancedMesh;
  private readonly surface: THREE.InstancedMesh[];
  private readonly parts: Part[];
  private readonly left: number; // joints the lateral axis is taken from
  private readonly right: number;

  constructor(private readonly parents: number[], names: string[], material: THREE.Material, full: boolean) {
    const plain = names.map((name) => name.toLowerCase());
    this.left = plain.indexOf('left_hip');
    this.right = plain.indexOf('right_hip');
    this.parts = plain.map((name) => {
      if (!full) return name === 'head' ? thinHead : thin;
      return parts.find(([pattern]) => pattern.test(name))?.[1] ?? other;
    });
    this.balls = new THREE.InstancedMesh(full ? SMALL_BALL : BALL, material, parents.length);
    this.limbs = new THREE.InstancedMesh(full ? LIMB : STICK, material, parents.length);
    this.surface = !full ? [] : [this.balls, this.limbs].map((painted) => {
      const mesh = new THREE.InstancedMesh(painted.geometry, SURFACE, parents.length);
      mesh.instanceMatrix = painted.instanceMatrix;
      mesh.renderOrder = -0.5;
      return mesh;
    });
    for (const mesh of this.meshes) {
      mesh.frustumCulled = false;
      mesh.instanceMatrix.setUsage(THREE.DynamicDrawUsage);
    }
    this.castShadow = true;
  }

  get meshes() {
    return [this.balls, this.limbs, ...this.surface];
  }

  set castShadow(on: boolean) {
    this.balls.castShadow = this.limbs.castShadow = on;
  }

  set renderOrder(order: number) {
    this.balls.renderOrder = this.limbs.renderOrder = order;
    for (const mesh of this.surface) mesh.renderOrder = order - 0.5;
  }

  set visible(on: boolean) {
    for (const mesh of this.meshes) mesh.visible = on;
  }

  /** Poses it by joints (J, 3). */
  pose(joints: Float32Array) {
    side.set(1, 0, 0);
    if (this.left >= 0 && this.right >= 0)
      side.fromArray(joints, this.left * 3).sub(at.fromArray(joints, this.right * 3)).normalize();
    for (let j = 0; j < this.parents.length; ++j) {
      const { limb, ball, ahead } = this.parts[j];
      const parent = this.parents[j];
      at.fromArray(joints, j * 3);
      from.fromArray(joints, Math.max(parent, 0) * 3);
      along.subVectors(at, from);
      const length = along.length();
      if (length > 1e-6) along.divideScalar(length);
      else along.set(0, 1, 0);
      across.copy(side).addScaledVector(along, -side.dot(along));
      if (across.lengthSq() < 1e-4) across.set(-along.y, along.x, 0); // a bone along the lateral axis
      across.normalize();
      deep.crossVectors(across, along);

      m.makeBasis(x.copy(across).multiplyScalar(limb[0]), y.copy(along).multiplyScalar(length), z.copy(deep).multiplyScalar(limb[1]));
      if (parent < 0) m.makeScale(0, 0, 0);
      this.limbs.setMatrixAt(j, m.setPosition(from));
      m.makeBasis(x.copy(across).multiplyScalar(ball[0]), y.copy(along).multiplyScalar(ball[1]), z.copy(deep).multiplyScalar(ball[2]));
      this.balls.setMatrixAt(j, m.setPosition(at.addScaledVector(along, ahead ?? 0)));
    }
    this.balls.instanceMatrix.needsUpdate = true;
    this.limbs.instanceMatrix.needsUpdate = true;
  }
}
