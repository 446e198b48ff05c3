import { Bone, Group, MeshStandardMaterial, Scene, Vector3 } from 'three';
import type { Data } from './data';
import type { GhostPose } from './live_link';
import { Bodies, skinned } from './person';
import { futureColor, roleColor } from './colors';

/** A body that is posed by whoever holds it. */
export class LiveBody {
  readonly group = new Group();
  readonly material: MeshStandardMaterial;
  private readonly bones: Bone[];
  private readonly root: Vector3; // rest position of the root joint

  constructor(data: Data, bodies: Bodies, color: number, opacity = 1) {
    const person = data.header.people[0];
    const offsets = data.floats(person.offsets!);
    this.material = new MeshStandardMaterial({ color, transparent: opacity < 1, opacity, roughness: 0.62, metalness: 0 });
    const body = skinned(bodies, person, offsets, this.material);
    body.castShadow = opacity === 1;
    this.bones = body.skeleton.bones;
    this.root = new Vector3().fromArray(offsets);
    this.group.add(body);
  }

  /** @param trans (3) metres; @param rotations (J, 4) x y z w, relative to the parent. */
  pose(trans: Float32Array, rotations: Float32Array) {
    this.bones.forEach((bone, j) => bone.quaternion.fromArray(rotations, j * 4).normalize());
    this.bones[0].position.fromArray(trans).add(this.root);
  }

  joint(j: number, out: Vector3) {
    this.group.updateMatrixWorld();
    return this.bones[j].getWorldPosition(out);
  }
}

const KINDS = [
  { color: () => roleColor.prediction, opacity: (seconds: number) => 0.5 - 0.16 * seconds },
  { color: (track: number) => futureColor(track + 1), opacity: (seconds: number) => 0.44 - 0.1 * seconds },
  { color: () => roleColor.filled, opacity: () => 0.5 },
];

const NEAR = 0.22; // metres between pelvises

/** See-through bodies: a forecast, futures, the pose that is moved to. */
export class LiveGhosts {
  private readonly shown: LiveBody[][] = KINDS.map(() => []);
  private readonly counts = KINDS.map(() => 0);

  constructor(private readonly data: Data, private readonly bodies: Bodies, private readonly scene: Scene) {}

  set(kind: number, ghosts: GhostPose[]) {
    const bodies = this.shown[kind];
    if (!bodies) return;
    const { color, opacity } = KINDS[kind];
    ghosts.forEach((ghost, i) => {
      if (!bodies[i]) {
        bodies[i] = new LiveBody(this.data, this.bodies, color(ghost.track), 0.4);
        this.scene.add(bodies[i].group);
      }
      bodies[i].material.color.set(color(ghost.track));
      bodies[i].material.opacity = opacity(ghost.seconds);
      bodies[i].pose(ghost.trans, ghost.rotations);
    });
    bodies.forEach((body, i) => (body.group.visible = i < ghosts.length));
    this.counts[kind] = ghosts.length;
  }

  /** Those that are where the person is would only hide them. */
  standAside(person: Vector3) {
    for (const kind of [0, 1])
      for (let i = 0; i < this.counts[kind]; ++i) {
        const { group } = this.shown[kind][i];
        group.visible = this.place(kind, i).distanceTo(person) > NEAR;
      }
  }

  clear() {
    KINDS.forEach((_, kind) => this.set(kind, []));
  }

  count(kind: number) {
    return this.counts[kind];
  }

  /** Pelvis of a ghost. */
  place(kind: number, i: number) {
    return this.shown[kind][i].joint(0, new Vector3());
  }
}
