import { Camera, Intersection, Mesh, MeshBasicMaterial, MeshStandardMaterial, Object3D, Raycaster, Scene, SphereGeometry, Vector2, Vector3 } from 'three';
import { objectOf } from './scene_objects';

const HANDS = [0x1fb5a3, 0xd64c8a];
const RADIUS = 0.03;

/** What is under a place on the screen. */
export interface Hit {
  point: Vector3;
  object: string; // of the scene; empty: the floor
  level: boolean; // one could stand there
}

/** Rays from the screen into the room, and the handles of the hands' contacts. */
export class Picks {
  readonly handles: Mesh[];
  private readonly ray = new Raycaster();
  private readonly at = new Vector2();
  private readonly normal = new Vector3();

  constructor(private readonly canvas: HTMLElement, private readonly camera: Camera, private readonly room: Object3D, scene: Scene) {
    this.handles = HANDS.map((color) => {
      const handle = new Mesh(new SphereGeometry(RADIUS, 20, 14),
        new MeshBasicMaterial({ color, depthTest: false, transparent: true, opacity: 0.9 }));
      handle.renderOrder = 6;
      handle.visible = false;
      scene.add(handle);
      return handle;
    });
  }

  private aim(x: number, y: number) {
    const box = this.canvas.getBoundingClientRect();
    this.at.set(((x - box.left) / box.width) * 2 - 1, 1 - ((y - box.top) / box.height) * 2);
    this.ray.setFromCamera(this.at, this.camera);
  }

  /** Hand whose handle is there, or -1. A handle is easier to hit than it looks. */
  handle(x: number, y: number): number {
    this.aim(x, y);
    let best = -1;
    let least = 2.2 * RADIUS;
    this.handles.forEach((handle, hand) => {
      const far = handle.visible ? this.ray.ray.distanceToPoint(handle.position) : Infinity;
      if (far < least) [best, least] = [hand, far];
    });
    return best;
  }

  /** The first surface there. Without any, where the ray meets the ground. @param only of this object */
  hit(x: number, y: number, only = ''): Hit | undefined {
    this.aim(x, y);
    const seen = ({ object }: Intersection) => {
      const material = (object as Mesh).material as MeshStandardMaterial;
      return (object as Mesh).isMesh && (!material.transparent || material.opacity > 0.5);
    };
    const meshes = this.room.children.filter((mesh) => !only || objectOf(mesh.name) === only);
    const first = this.ray.intersectObjects(meshes, false).find(seen);
    if (first) {
      const name = objectOf(first.object.name);
      const up = first.face ? this.normal.copy(first.face.normal).transformDirection(first.object.matrixWorld).y : 0;
      const level = Math.abs(up) > 0.7 && first.point.y < 0.25;
      return { point: first.point, object: /floor|ground|rug|carpet/i.test(name) ? '' : name, level };
    }
    if (only) return undefined;
    const { origin, direction } = this.ray.ray;
    if (direction.y > -1e-3) return undefined;
    return { point: origin.clone().addScaledVector(direction, -origin.y / direction.y), object: '', level: true };
  }
}
