import { css, motionTones } from './colors';
import type { Data, PersonData, SceneData } from './data';

const AZIMUTH = 0.75; // radians from which it is seen
const ELEVATION = 0.5;
const LIMB = 0.075; // metres
const FAR = 5; // metres: who goes farther is followed
const FINE = 2;

interface SceneMesh { name: string; color: number[]; points: Float32Array; corners: ArrayLike<number> }

/** A triangle's colour (ABGR) in light from above; of linear colour, seen from the front or from behind. */
function shaded(points: Float32Array, [a, b, c]: number[], color: number[], front: boolean): number {
  const [ux, uy, uz] = [0, 1, 2].map((k) => points[b + k] - points[a + k]);
  const [vx, vy, vz] = [0, 1, 2].map((k) => points[c + k] - points[a + k]);
  const n = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
  const toLight = ((n[0] * 0.3 + n[1] * 0.85 + n[2] * 0.43) / (Math.hypot(...n) || 1)) * (front ? 1 : -1);
  const light = 0.62 + 0.38 * Math.max(0, toLight);
  const [r, g, blue] = color.map((part) => Math.round(255 * Math.min(1, light * Math.max(0, part) ** (1 / 2.2))));
  return ((255 << 24) | (blue << 16) | (g << 8) | r) >>> 0;
}

/** A small picture of a person who moves, and of the scene, seen from afar without perspective, on a 2D canvas. */
export class Thumbnail {
  private readonly joints?: Float32Array;
  private readonly scene?: HTMLCanvasElement;
  private readonly count: number = 0;
  private readonly frames: number = 1;
  private readonly scale: number; // pixels a metre
  private readonly middle: [number, number]; // of what is shown, on the picture's plane
  private readonly follows: boolean = false;
  private readonly color: string;

  constructor(private readonly canvas: HTMLCanvasElement, data: Data, private readonly person: PersonData | undefined, scene: SceneData | undefined, index: number) {
    this.color = css(motionTones[index % motionTones.length]);
    const [low, high] = [[Infinity, Infinity], [-Infinity, -Infinity]];
    const include = (values: ArrayLike<number>, stride = 3) => {
      for (let i = 0; i + 2 < values.length; i += stride) this.plane(values, i).forEach((at, k) => {
        low[k] = Math.min(low[k], at);
        high[k] = Math.max(high[k], at);
      });
    };
    if (person) {
      this.joints = person.motion ? data.motion(person.motion) : data.floats(person.joints!);
      this.count = person.parents.length;
      this.frames = person.frames;
      include(this.joints);
      this.follows = !scene && Math.max(high[0] - low[0], high[1] - low[1]) > FAR;
    }
    const meshes = (scene?.meshes ?? []).map((mesh) => ({ ...mesh, points: data.floats(mesh.vertices), corners: data.raw(mesh.faces) }));
    const cloud = scene?.points && data.floats(scene.points);
    for (const { points } of meshes) include(points);
    if (cloud) include(cloud);
    const width = this.follows ? 2.4 : high[0] - low[0] + 0.3;
    const height = this.follows ? 2.4 : high[1] - low[1] + 0.3;
    this.middle = [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2];
    this.scale = Math.min(canvas.width / width, canvas.height / height, canvas.height / 1.2);
    if (scene) {
      this.scene = Object.assign(document.createElement('canvas'), { width: canvas.width, height: canvas.height });
      this.paint(this.scene.getContext('2d')!, meshes, cloud);
    }
  }

  /** Where a point is on the picture's plane, metres right and up. */
  private plane(values: ArrayLike<number>, i: number): [number, number] {
    const [x, y, z] = [values[i], values[i + 1], values[i + 2]];
    const toward = x * Math.sin(AZIMUTH) + z * Math.cos(AZIMUTH);
    return [x * Math.cos(AZIMUTH) - z * Math.sin(AZIMUTH), y * Math.cos(ELEVATION) - toward * Math.sin(ELEVATION)];
  }

  private depth(values: ArrayLike<number>, i: number) {
    const toward = values[i] * Math.sin(AZIMUTH) + values[i + 2] * Math.cos(AZIMUTH);
    return toward * Math.cos(ELEVATION) + values[i + 1] * Math.sin(ELEVATION);
  }

  private meanDepth(points: ArrayLike<number>) {
    let sum = 0;
    for (let i = 0; i < points.length; i += 3) sum += this.depth(points, i);
    return sum / (points.length / 3);
  }

  private pixel([right, up]: [number, number], [x, y] = this.middle): [number, number] {
    return [this.canvas.width / 2 + (right - x) * this.scale, this.canvas.height / 2 - (up - y) * this.scale];
  }

  /** Paints the scene with a depth buffer, at twice the size for smooth edges; walls on this side and ceilings are left out. */
  private paint(out: CanvasRenderingContext2D, meshes: SceneMesh[], cloud?: Float32Array) {
    const [width, height] = [FINE * this.canvas.width, FINE * this.canvas.height];
    const image = new ImageData(width, height);
    const pixels = new Uint32Array(image.data.buffer);
    const nearest = new Float32Array(width * height).fill(-Infinity);
    const place = (points: ArrayLike<number>, at: number) => [...this.pixel(this.plane(points, at)).map((x) => x * FINE), this.depth(points, at)];
    const set = (i: number, z: number, color: number) => {
      if (z <= nearest[i]) return;
      nearest[i] = z;
      pixels[i] = color;
    };
    const depths = meshes.map(({ points }) => this.meanDepth(points));
    const [nearestMesh, farthest] = [Math.max(...depths), Math.min(...depths)];
    for (const { name, color, points, corners } of meshes) {
      if (/ceil|roof/i.test(name) || (/wall/i.test(name) && this.meanDepth(points) > (nearestMesh + farthest) / 2)) continue;
      for (let i = 0; i < corners.length; i += 3) {
        const at = [corners[i] * 3, corners[i + 1] * 3, corners[i + 2] * 3];
        const [[px, py, pz], [qx, qy, qz], [rx, ry, rz]] = at.map((k) => place(points, k));
        const area = (qx - px) * (ry - py) - (qy - py) * (rx - px);
        if (Math.abs(area) < 1e-6) continue;
        const ink = shaded(points, at, color, area < 0);
        const [left, right] = [Math.max(0, Math.floor(Math.min(px, qx, rx))), Math.min(width - 1, Math.ceil(Math.max(px, qx, rx)))];
        const [top, bottom] = [Math.max(0, Math.floor(Math.min(py, qy, ry))), Math.min(height - 1, Math.ceil(Math.max(py, qy, ry)))];
        for (let y = top; y <= bottom; ++y) for (let x = left; x <= right; ++x) {
          const u = ((qx - x) * (ry - y) - (qy - y) * (rx - x)) / area;
          const v = ((rx - x) * (py - y) - (ry - y) * (px - x)) / area;
          if (u >= 0 && v >= 0 && u + v <= 1) set(y * width + x, u * pz + v * qz + (1 - u - v) * rz, ink);
        }
      }
    }
    for (let i = 0; cloud && i + 2 < cloud.length; i += 3) {
      const [x, y, z] = place(cloud, i).map(Math.round);
      if (x < 0 || y < 0 || x >= width - 1 || y >= height - 1) continue;
      for (const k of [0, 1, width, width + 1]) set(y * width + x + k, z, 0xff9c948f);
    }
    const fine = Object.assign(document.createElement('canvas'), { width, height });
    fine.getContext('2d')!.putImageData(image, 0, 0);
    out.imageSmoothingQuality = 'high';
    out.drawImage(fine, 0, 0, this.canvas.width, this.canvas.height);
  }

  /** Draws it `seconds` after its start; it starts over at its end. */
  draw(seconds: number) {
    const { canvas, joints, count, person } = this;
    const context = canvas.getContext('2d')!;
    context.clearRect(0, 0, canvas.width, canvas.height);
    if (this.scene) context.drawImage(this.scene, 0, 0);
    if (!joints || !person) return;
    const frame = Math.floor(seconds * person.rate) % this.frames;
    const start = frame * count * 3;
    const middle: [number, number] = this.follows ? this.plane(joints, start) : this.middle;
    const place = (f: number, j: number) => this.pixel(this.plane(joints, (f * count + j) * 3), middle);
    context.lineCap = context.lineJoin = 'round';
    context.strokeStyle = this.color;
    context.globalAlpha = 0.4;
    context.lineWidth = 2;
    context.beginPath();
    for (let f = 0; f < this.frames; f += 2) {
      const [x, , z] = joints.subarray(f * count * 3, f * count * 3 + 3);
      context.lineTo(...this.pixel(this.plane([x, 0, z], 0), middle));
    }
    context.stroke();
    context.globalAlpha = 1;
    // Dark below, light above: each limb has a rim.
    for (const [color, width] of [['#0008', LIMB + 0.035], [this.color, LIMB]] as const) {
      context.strokeStyle = context.fillStyle = color;
      context.lineWidth = Math.max(1.5, width * this.scale);
      for (let j = 0; j < count; ++j) {
        if (person.parents[j] < 0) continue;
        context.beginPath();
        context.moveTo(...place(frame, person.parents[j]));
        context.lineTo(...place(frame, j));
        context.stroke();
      }
      const head = person.names.findIndex((name) => /^head$/i.test(name));
      if (head < 0) continue;
      context.beginPath();
      context.arc(...place(frame, head), Math.max(2, (width + 0.03) * this.scale), 0, 7);
      context.fill();
    }
  }
}
