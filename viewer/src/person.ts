import * as THREE from 'three';
import { collisionColor, keyColor } from './colors';
import { Data, PersonData } from './data';
import { Figure } from './figure';

const DISC = new THREE.CircleGeometry(0.3, 28).rotateX(-Math.PI / 2);
const NO_LABEL = 0x8f949c;

const a = new THREE.Vector3(); // scratch, so that a frame allocates nothing

export type Shape = 'body' | 'skeleton';

/** Skinned geometries of the page's bodies, one per shape. */
export class Bodies {
  readonly geometries: THREE.BufferGeometry[];
  readonly rests: Float32Array[];

  constructor(data: Data) {
    this.rests = data.header.bodies.map((body) => data.floats(body.rest));
    this.geometries = data.header.bodies.map((body) => {
      const geometry = new THREE.BufferGeometry();
      const positions = data.floats(body.vertices);
      const count = positions.length / 3;
      const weights = data.raw(body.weights);
      const bones = data.raw(body.bones);
      const weight4 = new Float32Array(count * 4);
      const bone4 = new Uint16Array(count * 4);
      for (let v = 0; v < count; ++v) {
        let sum = 0;
        for (let k = 0; k < body.influences; ++k) sum += weights[v * body.influences + k];
        for (let k = 0; k < body.influences; ++k) {
          weight4[v * 4 + k] = weights[v * body.influences + k] / sum;
          bone4[v * 4 + k] = bones[v * body.influences + k];
        }
      }
      geometry.setAttribute('position', new THREE.BufferAttribute(positions, 3));
      geometry.setAttribute('skinIndex', new THREE.BufferAttribute(bone4, 4));
      geometry.setAttribute('skinWeight', new THREE.BufferAttribute(weight4, 4));
      geometry.setIndex(new THREE.BufferAttribute(data.raw(body.faces), 1));
      geometry.computeVertexNormals();
      return geometry;
    });
  }
}

/** A body that its bones pose, of a person with these bones (J, 3). */
export function skinned(bodies: Bodies, person: PersonData, offsets: Float32Array, material: THREE.Material): THREE.SkinnedMesh {
  const rest = bodies.rests[person.body!];
  const bones: THREE.Bone[] = [];
  const inverses: THREE.Matrix4[] = [];
  for (let j = 0; j < rest.length / 3; ++j) {
    const bone = new THREE.Bone();
    bone.position.fromArray(offsets, j * 3);
    bones.push(bone);
    if (j > 0) bones[person.parents[j]].add(bone);
    inverses.push(new THREE.Matrix4().makeTranslation(-rest[j * 3], -rest[j * 3 + 1], -rest[j * 3 + 2]));
  }
  const body = new THREE.SkinnedMesh(bodies.geometries[person.body!], material);
  body.castShadow = true;
  body.receiveShadow = true;
  body.frustumCulled = false;
  body.add(bones[0]);
  body.bind(new THREE.Skeleton(bones, inverses), new THREE.Matrix4());
  return body;
}

/** Roles shown as small figures on a disc in the colour of the current intention. */
export const isFigure = (data: PersonData) => data.role === 'future' || data.role === 'intention';

/** One person: body and skeleton, posed at a time. */
export class Person {
  readonly group = new THREE.Group();
  readonly parents: number[];
  readonly joints: Float32Array; // (T, J, 3)
  readonly now: Float32Array; // (J, 3) at the time last set
  readonly start: number;
  readonly end: number; // time of the last frame
  readonly material: THREE.MeshStandardMaterial | THREE.MeshLambertMaterial;
  enabled = true; // switched on in the legend
  past?: Person; // what was observed, shown in this one's place until this one starts
  labelColors: string[] = [];
  private readonly frames: number;
  private readonly count: number;
  private readonly figure: Figure;
  private readonly disc?: THREE.Mesh<THREE.BufferGeometry, THREE.MeshBasicMaterial>;
  private readonly body?: THREE.SkinnedMesh;
  private readonly bones: THREE.Bone[] = [];
  private readonly rotations?: Float32Array; // (T, B, 4) x y z w
  private readonly roots?: Float32Array; // (T, 3)
  private readonly targets: THREE.Mesh[] = [];
  private readonly hands?: { places: Float32Array; on: ArrayLike<number> };

  constructor(data: Data, bodies: Bodies, readonly data_: PersonData, readonly color: number, opacity: number, figure = isFigure(data_)) {
    this.parents = data_.parents;
    this.count = this.parents.length;
    this.frames = data_.frames;
    this.joints = data_.motion ? data.motion(data_.motion) : data.floats(data_.joints!);
    this.now = new Float32Array(this.count * 3);
    this.start = data_.start;
    this.end = data_.start + (data_.frames - 1) / data_.rate;
    const look = { color, transparent: figure || opacity < 1, opacity };
    this.material = figure ? new THREE.MeshLambertMaterial(look) : new THREE.MeshStandardMaterial({ ...look, roughness: 0.62, metalness: 0 });

    this.figure = new Figure(this.parents, data_.names, this.material, figure);
    this.group.add(...this.figure.meshes);
    if (isFigure(data_)) {
      this.disc = new THREE.Mesh(DISC, new THREE.MeshBasicMaterial({ transparent: true, depthWrite: false }));
      this.group.add(this.disc);
    }

    if (data_.body !== undefined) {
      const offsets = data.floats(data_.offsets!);
      const wxyz = data.floats(data_.rotations!);
      for (let i = 0; i < wxyz.length; i += 4) {
        const w = wxyz[i];
        wxyz.copyWithin(i, i + 1, i + 4);
        wxyz[i + 3] = w;
      }
      this.rotations = wxyz;
      this.roots = data.floats(data_.trans!);
      for (let i = 0; i < this.roots.length; ++i) this.roots[i] += offsets[i % 3];
      this.body = skinned(bodies, data_, offsets, this.material);
      this.bones.push(...this.body.skeleton.bones);
      this.group.add(this.body);
    }

    if (data_.hands) {
      this.hands = { places: data.floats(data_.hands.places), on: data.raw(data_.hands.on) };
      for (let h = 0; h < 2; ++h) {
        const ring = new THREE.Mesh(
          new THREE.SphereGeometry(0.028, 16, 12),
          new THREE.MeshBasicMaterial({ color: h === 0 ? 0x1fb5a3 : 0xd64c8a, depthTest: false, transparent: true, opacity: 0.85 }),
        );
        ring.renderOrder = 5;
        this.targets.push(ring);
        this.group.add(ring);
      }
    }
  }

  get hasBody() {
    return this.body !== undefined;
  }

  show(shape: Shape) {
    const asBody = shape === 'body' && this.body !== undefined;
    if (this.body) this.body.visible = asBody;
    this.figure.visible = !asBody;
  }

  /** Frame (whole number) shown at time t. */
  frame(t: number) {
    return Math.round(Math.min(Math.max((t - this.start) * this.data_.rate, 0), this.frames - 1));
  }

  /** Intention label at time t; -1 where none is known. */
  label(t: number) {
    const frame = this.frame(t);
    let label = -1;
    if (t >= this.start - 1e-6) for (const [first, here] of this.data_.intentions ?? []) if (first <= frame) label = here;
    return label;
  }

  /** Whether the body is inside the scene at time t. */
  collides(t: number) {
    const frame = this.frame(t);
    let inside = 0;
    for (const [first, here] of this.data_.collides ?? []) if (first <= frame) inside = here;
    return inside > 0;
  }

  private tint(t: number) {
    if (this.data_.keys?.includes(this.frame(t))) return keyColor; // what was asked for keeps its colour
    return this.collides(t) ? collisionColor : this.color;
  }

  /** How much of it is seen, 0 to 1. */
  setOpacity(opacity: number) {
    this.material.opacity = opacity;
    if (this.disc) this.disc.material.opacity = 0.75 * opacity;
  }

  set castShadow(on: boolean) {
    this.figure.castShadow = on;
  }

  set renderOrder(order: number) {
    this.figure.renderOrder = order;
  }

  setFloor(y: number) {
    this.disc?.position.setY(y);
  }

  setTime(t: number) {
    if (this.data_.role === 'intention') t = this.start + ((t - this.start) % (this.end - this.start || 1));
    if (this.past && t < this.start - 1e-6) {
      this.past.sample(t);
      this.now.set(this.past.now);
      this.material.color.set(this.past.color);
      this.poseFigure(-1);
      return;
    }
    this.material.color.set(this.tint(t));
    const { i, next, u } = this.sample(t);
    if (this.body?.visible) this.poseBody(i, next, u);
    else this.poseFigure(this.disc ? this.label(t) : -1);
    if (this.hands) {
      const f = this.frame(t);
      for (let h = 0; h < 2; ++h) {
        this.targets[h].visible = this.hands.on[f * 2 + h] > 0;
        this.targets[h].position.fromArray(this.hands.places, (f * 2 + h) * 3);
      }
    }
  }

  /** Joints now, between frames i and next at u. */
  private sample(t: number) {
    const at = Math.min(Math.max((t - this.start) * this.data_.rate, 0), this.frames - 1);
    const i = Math.min(Math.floor(at), this.frames - 1);
    const next = Math.min(i + 1, this.frames - 1);
    const u = at - i;
    const n = this.count * 3;
    for (let k = 0; k < n; ++k) {
      const from = this.joints[i * n + k];
      this.now[k] = from + u * (this.joints[next * n + k] - from);
    }
    return { i, next, u };
  }

  /** World position of a joint at the time last set: of the drawn body where that is shown. */
  joint(j: number, out: THREE.Vector3) {
    if (this.body?.visible && j < this.bones.length) {
      this.group.updateMatrixWorld();
      return this.bones[j].getWorldPosition(out);
    }
    return out.fromArray(this.now, j * 3).add(this.group.position);
  }

  private poseBody(i: number, next: number, u: number) {
    const count = this.bones.length;
    for (let j = 0; j < count; ++j) {
      const bone = this.bones[j];
      THREE.Quaternion.slerpFlat(
        quaternion, 0, this.rotations! as unknown as number[], (i * count + j) * 4,
        this.rotations! as unknown as number[], (next * count + j) * 4, u);
      bone.quaternion.set(quaternion[0], quaternion[1], quaternion[2], quaternion[3]).normalize();
    }
    const root = this.bones[0].position;
    root.fromArray(this.roots!, i * 3).lerp(a.fromArray(this.roots!, next * 3), u);
  }

  private poseFigure(label: number) {
    this.figure.pose(this.now);
    if (!this.disc) return;
    this.disc.position.x = this.now[0];
    this.disc.position.z = this.now[2];
    this.disc.material.color.set(this.labelColors[label] ?? NO_LABEL);
  }
}

const quaternion: number[] = [0, 0, 0, 1];
