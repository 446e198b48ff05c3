import * as THREE from 'three';
import type { Data, ObjectMotionData } from './data';

/** The object of a mesh: "chair_0" of "chair_0.2", and "chair.002" of itself (inhabit/scene/objects.h). */
export const objectOf = (name: string) => name.replace(/\.\d{1,2}$/, '');

const HIGHLIGHT = 0x2f7bff;

/** One object of the scene: all meshes of its name. */
export interface SceneObject {
  name: string;
  color: number; // sRGB, of its first mesh
  meshes: THREE.Mesh[];
  shown: boolean;
  marked: boolean; // stands out
}

/** What is in a scene by name; each can be hidden, made to stand out, and moved over time. */
export class SceneObjects {
  readonly list: SceneObject[] = [];
  private readonly moving: { meshes: THREE.Mesh[]; motion: ObjectMotion }[] = [];

  constructor(meshes: THREE.Mesh[]) {
    const byName = new Map<string, SceneObject>();
    for (const mesh of meshes) {
      const name = objectOf(mesh.name) || 'unnamed';
      let object = byName.get(name);
      if (!object) {
        const color = (mesh.material as THREE.MeshStandardMaterial).color.getHex();
        byName.set(name, (object = { name, color, meshes: [], shown: true, marked: false }));
        this.list.push(object);
      }
      object.meshes.push(mesh);
    }
  }

  find(name: string) {
    return this.list.find((object) => object.name === name);
  }

  show(object: SceneObject, on: boolean) {
    object.shown = on;
    for (const mesh of object.meshes) mesh.visible = on;
  }

  mark(object: SceneObject, on: boolean) {
    object.marked = on;
    for (const { material } of object.meshes) {
      (material as THREE.MeshStandardMaterial).emissive.set(on ? HIGHLIGHT : 0);
      (material as THREE.MeshStandardMaterial).emissiveIntensity = 0.45;
    }
  }

  /** The middle of its box as it stands now. */
  middle({ meshes }: SceneObject) {
    const box = new THREE.Box3();
    for (const mesh of meshes) {
      mesh.updateMatrixWorld(true);
      box.union(new THREE.Box3().copy(mesh.geometry.boundingBox!).applyMatrix4(mesh.matrixWorld));
    }
    return box.getCenter(new THREE.Vector3());
  }

  /** Lets a person's clip move what it names; what somebody moves already stays theirs. */
  move(data: Data, objects: ObjectMotionData[], start: number, rate: number) {
    for (const source of objects) {
      const { meshes } = this.find(source.name) ?? {};
      if (!meshes || this.moving.some((other) => other.meshes === meshes)) continue;
      for (const mesh of meshes) mesh.matrixAutoUpdate = false;
      this.moving.push({ meshes, motion: new ObjectMotion(data, source, start, rate) });
    }
  }

  setTime(t: number) {
    for (const { meshes, motion } of this.moving) {
      const moved = motion.at(t);
      for (const mesh of meshes) {
        mesh.matrix.copy(moved);
        mesh.matrixWorldNeedsUpdate = true;
      }
    }
  }
}

/** How an object moves away from where it is in the first frame. */
class ObjectMotion {
  private readonly places: Float32Array;
  private readonly rotations: Float32Array; // w x y z
  private readonly back = new THREE.Matrix4();
  private readonly from = new THREE.Vector3();
  private readonly to = new THREE.Vector3();
  private readonly rotation = new THREE.Quaternion();
  private readonly next = new THREE.Quaternion();
  private readonly pose = new THREE.Matrix4();
  private readonly one = new THREE.Vector3(1, 1, 1);

  constructor(data: Data, source: ObjectMotionData, private readonly start: number, private readonly rate: number) {
    this.places = data.floats(source.places);
    this.rotations = data.floats(source.turns);
    this.back.copy(this.poseAt(0)).invert();
  }

  at(t: number) {
    return this.poseAt((t - this.start) * this.rate).multiply(this.back);
  }

  private poseAt(frame: number) {
    const last = this.places.length / 3 - 1;
    const at = Math.min(Math.max(frame, 0), last);
    const i = Math.floor(at);
    const n = Math.min(i + 1, last);
    const quaternion = (q: THREE.Quaternion, k: number) => q.set(this.rotations[k * 4 + 1], this.rotations[k * 4 + 2], this.rotations[k * 4 + 3], this.rotations[k * 4]).normalize();
    this.from.fromArray(this.places, i * 3).lerp(this.to.fromArray(this.places, n * 3), at - i);
    quaternion(this.rotation, i).slerp(quaternion(this.next, n), at - i);
    return this.pose.compose(this.from, this.rotation, this.one);
  }
}
