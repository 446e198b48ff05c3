import * as THREE from 'three';
import { toCreasedNormals } from 'three/examples/jsm/utils/BufferGeometryUtils.js';
import type { Data, MeshData } from './data';
import { PointSet } from './points';
import { SceneObjects } from './scene_objects';

const CREASE = 0.7; // radians: edges sharper than this stay sharp
const MAX_CREASED = 60_000; // triangle corners of a mesh beyond which it is shaded face by face
const MAX_CAST = 400_000; // triangles beyond which looking for what hides takes too long
const FADED = 0.07; // opacity of a wall between the camera and the room

function trianglesOf(geometry: THREE.BufferGeometry) {
  return (geometry.index ?? geometry.getAttribute('position')).count / 3;
}

interface Wall {
  mesh: THREE.Mesh;
  material: THREE.MeshStandardMaterial;
  outward: THREE.Vector3;
  center: THREE.Vector3;
}

/** The scene's meshes and scan points, shown so that one looks into a room rather than at its walls. */
export class Room {
  readonly group = new THREE.Group();
  readonly box = new THREE.Box3();
  readonly points?: PointSet;
  readonly hasFloor: boolean;
  readonly objects: SceneObjects;
  /** Where the person is (view target): what is high and between it and the camera is cut away. */
  readonly focus = { value: new THREE.Vector3() };
  private readonly walls: Wall[] = [];
  private readonly toCamera = new THREE.Vector3();

  constructor(data: Data) {
    const scene = data.header.scene;
    const parts: { mesh: THREE.Mesh; box: THREE.Box3; source: MeshData }[] = [];
    for (const source of scene?.meshes ?? []) {
      let geometry = new THREE.BufferGeometry();
      geometry.setAttribute('position', new THREE.BufferAttribute(data.floats(source.vertices), 3));
      geometry.setIndex(new THREE.BufferAttribute(data.raw(source.faces), 1));
      const creased = source.faces.count < MAX_CREASED;
      if (creased) geometry = toCreasedNormals(geometry, CREASE);
      else geometry.computeVertexNormals();
      geometry.computeBoundingBox();
      geometry.computeBoundingSphere();
      const box = geometry.boundingBox!;
      const material = new THREE.MeshStandardMaterial({ roughness: 0.92, metalness: 0, flatShading: !creased });
      material.color.setRGB(...source.color, THREE.LinearSRGBColorSpace);
      const mesh = new THREE.Mesh(geometry, material);
      mesh.name = source.name;
      parts.push({ mesh, box, source });
      this.box.union(box);
      this.group.add(mesh);
    }
    if (scene?.points) {
      this.points = new PointSet(data.floats(scene.points), 0.022);
      this.points.object.geometry.computeBoundingBox();
      this.box.union(this.points.object.geometry.boundingBox!);
      this.group.add(this.points.object);
    }

    const size = new THREE.Vector3();
    const center = new THREE.Vector3();
    const middle = this.box.getCenter(new THREE.Vector3());
    let floor = false;
    for (const { mesh, box, source } of parts) {
      box.getSize(size);
      box.getCenter(center);
      const material = mesh.material as THREE.MeshStandardMaterial;
      const flat = size.y < 0.4 && size.x > 1.5 && size.z > 1.5;
      const ceiling = /ceil|roof/i.test(source.name) || (flat && center.y > this.box.min.y + 1.9);
      const isFloor = !ceiling && (/floor|ground/i.test(source.name) || (flat && box.max.y < this.box.min.y + 0.3));
      const thin = Math.min(size.x, size.z);
      const atEdge = size.x < size.z
        ? Math.abs(center.x - middle.x) > (this.box.max.x - this.box.min.x) / 2 - 0.6
        : Math.abs(center.z - middle.z) > (this.box.max.z - this.box.min.z) / 2 - 0.6;
      const wall = /wall/i.test(source.name) ? thin < 0.8 : thin < 0.45 && size.y > 1.7 && atEdge;
      const shell = size.x > 3 && size.z > 3 && size.y > 1.5; // a whole room or scan in one mesh
      floor ||= isFloor || shell;
      mesh.receiveShadow = true;
      mesh.castShadow = !(wall || ceiling || isFloor || shell);
      // Seen from outside, one-sided shells vanish; furniture may have open surfaces and stays two-sided.
      material.side = shell || isFloor || ceiling ? THREE.FrontSide : THREE.DoubleSide;
      if (wall || ceiling) {
        const outward = ceiling ? new THREE.Vector3(0, 1, 0)
          : size.x < size.z ? new THREE.Vector3(Math.sign(center.x - middle.x), 0, 0)
            : new THREE.Vector3(0, 0, Math.sign(center.z - middle.z));
        material.transparent = true;
        material.side = THREE.FrontSide;
        this.walls.push({ mesh, material, outward, center: center.clone() });
      } else if (!isFloor && size.y > 1.3) {
        this.cutAway(material);
      }
      if (!isFloor && !shell && source.faces.count < 30000) {
        const edges = new THREE.LineSegments(
          new THREE.EdgesGeometry(mesh.geometry, 40),
          new THREE.LineBasicMaterial({ color: 0x000000, transparent: true, opacity: 0.13 }));
        mesh.add(edges);
      }
    }
    this.hasFloor = floor;
    this.objects = new SceneObjects(parts.map(({ mesh }) => mesh));
  }

  /** Fades the walls and ceilings on the camera's side. Returns whether anything still changes. */
  update(camera: THREE.Camera, seconds: number): boolean {
    let moving = false;
    for (const wall of this.walls) {
      this.toCamera.copy(camera.position).sub(wall.center);
      const goal = this.toCamera.dot(wall.outward) > 0 ? FADED : 1;
      const material = wall.material;
      const change = (goal - material.opacity) * Math.min(1, seconds * 9);
      material.opacity = Math.abs(goal - material.opacity) < 0.01 ? goal : material.opacity + change;
      material.depthWrite = material.opacity > 0.9;
      moving ||= material.opacity !== goal;
    }
    return moving;
  }

  /** How many of the places cannot be seen from there; what fades for the camera hides nothing. */
  hidden(from: THREE.Vector3, places: THREE.Vector3[]): number {
    const solid = this.group.children.filter((part) => part instanceof THREE.Mesh && !this.walls.some(({ mesh }) => mesh === part));
    const triangles = solid.reduce((sum, part) => sum + trianglesOf((part as THREE.Mesh).geometry), 0);
    if (triangles > MAX_CAST) return 0;
    const ray = new THREE.Raycaster();
    return places.filter((place) => {
      ray.far = from.distanceTo(place);
      ray.set(from, place.clone().sub(from).normalize());
      return ray.intersectObjects(solid, false).length > 0;
    }).length;
  }

  settle(camera: THREE.Camera) {
    for (let i = 0; i < 60 && this.update(camera, 1); ++i);
  }

  private cutAway(material: THREE.MeshStandardMaterial) {
    material.onBeforeCompile = (shader) => {
      shader.uniforms.focus = this.focus;
      shader.vertexShader = shader.vertexShader
        .replace('#include <common>', '#include <common>\nvarying vec3 atWorld;')
        .replace('#include <project_vertex>', '#include <project_vertex>\natWorld = (modelMatrix * vec4(transformed, 1.0)).xyz;');
      shader.fragmentShader = shader.fragmentShader
        .replace('#include <common>', '#include <common>\nvarying vec3 atWorld;\nuniform vec3 focus;')
        .replace('#include <clipping_planes_fragment>', `#include <clipping_planes_fragment>
          {
            vec3 axis = focus - cameraPosition;
            float far = length(axis);
            axis /= far;
            vec3 here = atWorld - cameraPosition;
            float along = dot(here, axis);
            float aside = length(here - along * axis);
            // A cone that is a metre wide at the person, with a dithered rim; the ground stays.
            float keep = smoothstep(0.75, 1.0, aside / (1.0 * max(along / far, 0.15)));
            keep = max(keep, smoothstep(-0.9, -0.5, along - far));
            keep = max(keep, 1.0 - smoothstep(0.15, 0.4, atWorld.y - (focus.y - 1.0)));
            float dither = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
            if (keep < 0.999 && keep <= dither) discard;
          }`);
    };
  }
}
