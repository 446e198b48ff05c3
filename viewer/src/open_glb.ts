import { Matrix4, Quaternion, Vector3 } from 'three';
import type { Motion, Opened, Part } from './opened';

// Not three.js's GLTFLoader: it would add 66 KiB (18 compressed) to each page that is written, a tenth of an empty one's program, and replace
// less than half of this file, for what is shown are joints sampled over time and plain meshes. It takes ':' and '.' out of the names of
// joints, fetches textures, which the page's content policy forbids, and believes an index beyond the vertices.

const RATE = 30; // frames a second at which animations are sampled
const MOST_SECONDS = 3600;
const GREY: [number, number, number] = [0.75, 0.73, 0.7];

interface GltfNode { name?: string; mesh?: number; skin?: number; children?: number[]; matrix?: number[]; translation?: number[]; rotation?: number[]; scale?: number[] }
interface Gltf {
  scene?: number;
  scenes?: { nodes?: number[] }[];
  nodes?: GltfNode[];
  meshes?: { name?: string; primitives: { attributes: Record<string, number>; indices?: number; mode?: number; material?: number; extensions?: object }[] }[];
  materials?: { pbrMetallicRoughness?: { baseColorFactor?: number[] } }[];
  accessors?: { bufferView?: number; byteOffset?: number; componentType: number; normalized?: boolean; count: number; type: string; sparse?: object }[];
  bufferViews?: { buffer: number; byteOffset?: number; byteLength: number; byteStride?: number }[];
  skins?: { joints: number[] }[];
  animations?: { channels: { sampler: number; target: { node?: number; path: string } }[]; samplers: { input: number; output: number; interpolation?: string }[] }[];
  extensionsRequired?: string[];
}

const WIDTHS: Record<string, number> = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4, MAT4: 16 };
type Reader = [number, (view: DataView, at: number) => number, number]; // bytes, read, divisor where normalized
const COMPONENTS: Record<number, Reader> = {
  5120: [1, (view, at) => view.getInt8(at), 127],
  5121: [1, (view, at) => view.getUint8(at), 255],
  5122: [2, (view, at) => view.getInt16(at, true), 32767],
  5123: [2, (view, at) => view.getUint16(at, true), 65535],
  5125: [4, (view, at) => view.getUint32(at, true), 4294967295],
  5126: [4, (view, at) => view.getFloat32(at, true), 1],
};

/** A .glb: its JSON, and numbers from its one buffer. */
class Glb {
  readonly json: Gltf;
  private readonly binary: DataView;

  constructor(bytes: Uint8Array) {
    const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    if (bytes.length < 20 || view.getUint32(0, true) !== 0x46546c67) throw new Error('is no .glb');
    if (view.getUint32(4, true) !== 2) throw new Error('is glTF of another version than 2');
    const length = view.getUint32(12, true);
    if (view.getUint32(8, true) > bytes.length || 20 + length > bytes.length) throw new Error('is cut short');
    try {
      this.json = JSON.parse(new TextDecoder().decode(bytes.subarray(20, 20 + length))) as Gltf;
    } catch {
      throw new Error('has JSON that is damaged');
    }
    const at = 20 + length;
    const size = at + 8 <= bytes.length ? view.getUint32(at, true) : 0;
    if (at + 8 + size > bytes.length) throw new Error('is cut short');
    this.binary = size > 0 ? new DataView(bytes.buffer, bytes.byteOffset + at + 8, size) : new DataView(new ArrayBuffer(0));
    const packed = (this.json.extensionsRequired ?? []).filter((name) => /draco|meshopt/i.test(name));
    if (packed.length > 0) throw new Error(`is compressed (${packed[0]}), which is not read here`);
  }

  numbers(index: number | undefined, type: string): Float64Array {
    const accessor = this.json.accessors?.[index ?? -1];
    if (!accessor || accessor.type !== type) throw new Error('refers to data that it does not have');
    if (accessor.sparse) throw new Error('has sparse data, which is not read here');
    const [bytes, read, most] = COMPONENTS[accessor.componentType] ?? [];
    const width = WIDTHS[type];
    const { count } = accessor;
    const buffer = this.json.bufferViews?.[accessor.bufferView ?? -1];
    if (!bytes || !Number.isSafeInteger(count) || count < 0 || !buffer || buffer.buffer !== 0) throw new Error('refers to data that it does not have');
    const stride = buffer.byteStride ?? bytes * width;
    const start = (buffer.byteOffset ?? 0) + (accessor.byteOffset ?? 0);
    if (!(stride >= 0 && start >= 0) || (count > 0 && start + (count - 1) * stride + bytes * width > this.binary.byteLength)) throw new Error('is cut short: data lies outside its buffer');
    const out = new Float64Array(count * width);
    const scale = accessor.normalized ? 1 / most! : 1;
    for (let i = 0; i < count; ++i) for (let k = 0; k < width; ++k) out[i * width + k] = read!(this.binary, start + i * stride + k * bytes) * scale;
    return out;
  }
}

/** Nodes as a tree, where each stands, and what moves them. */
class Nodes {
  readonly parents: number[];
  readonly order: number[] = []; // parents first; only what the scene shows
  readonly world: Matrix4[];
  readonly start: number = Infinity;
  readonly end: number = -Infinity;
  private readonly nodes: GltfNode[];
  private readonly tracks: { node: number; path: string; times: Float64Array; values: Float64Array; step: boolean; cubic: boolean }[] = [];

  constructor(glb: Glb) {
    const { json } = glb;
    this.nodes = json.nodes ?? [];
    this.parents = this.nodes.map(() => -1);
    this.world = this.nodes.map(() => new Matrix4());
    this.nodes.forEach(({ children = [] }, i) => {
      for (const child of children) {
        if (this.parents[child] !== -1) throw new Error('has nodes that form no tree');
        this.parents[child] = i;
      }
    });
    const roots = json.scenes?.[json.scene ?? 0]?.nodes ?? this.nodes.flatMap((_, i) => (this.parents[i] < 0 ? [i] : []));
    const seen = new Set<number>();
    const waiting = [...roots].reverse();
    while (waiting.length > 0) {
      const i = waiting.pop()!;
      if (!this.nodes[i] || seen.has(i)) throw new Error('has nodes that form no tree');
      seen.add(i);
      this.order.push(i);
      waiting.push(...[...(this.nodes[i].children ?? [])].reverse());
    }
    for (const { channels, samplers } of (json.animations ?? []).slice(0, 1)) {
      for (const { sampler, target } of channels) {
        const { path, node } = target;
        const width = { translation: 'VEC3', scale: 'VEC3', rotation: 'VEC4' }[path];
        if (node === undefined || !width || !samplers[sampler]) continue;
        const { input, output, interpolation } = samplers[sampler];
        const track = { node, path, times: glb.numbers(input, 'SCALAR'), values: glb.numbers(output, width), step: interpolation === 'STEP', cubic: interpolation === 'CUBICSPLINE' };
        if (track.times.length === 0 || track.values.length !== track.times.length * WIDTHS[width] * (track.cubic ? 3 : 1)) throw new Error('has an animation that is damaged');
        this.start = Math.min(this.start, track.times[0]);
        this.end = Math.max(this.end, track.times.at(-1)!);
        this.tracks.push(track);
      }
    }
    this.pose(undefined);
  }

  get moved() {
    return new Set(this.tracks.map(({ node }) => node));
  }

  /** Places all nodes as they are at a time of the animation; undefined: as the file has them at rest. */
  pose(t?: number) {
    const places = new Map<number, GltfNode>();
    if (t !== undefined) for (const track of this.tracks) {
      const node = places.get(track.node) ?? { ...this.nodes[track.node], matrix: undefined };
      places.set(track.node, { ...node, [track.path]: valueAt(track, t) });
    }
    for (const i of this.order) {
      const node = places.get(i) ?? this.nodes[i];
      const own = this.world[i];
      if (node.matrix) own.fromArray(node.matrix);
      else own.compose(new Vector3(...(node.translation ?? [0, 0, 0])), new Quaternion(...(node.rotation ?? [0, 0, 0, 1])), new Vector3(...(node.scale ?? [1, 1, 1])));
      if (this.parents[i] >= 0) own.premultiply(this.world[this.parents[i]]);
    }
  }

  name(i: number) {
    return this.nodes[i].name ?? '';
  }
}

function valueAt({ path, times, values, step, cubic }: { path: string; times: Float64Array; values: Float64Array; step: boolean; cubic: boolean }, t: number): number[] {
  const width = path === 'rotation' ? 4 : 3;
  let i = 0; // the last key that is not after t
  for (let high = times.length - 1; i < high;) {
    const middle = Math.ceil((i + high) / 2);
    if (times[middle] <= t) i = middle;
    else high = middle - 1;
  }
  const n = Math.min(i + 1, times.length - 1);
  const u = step || n === i ? 0 : Math.min(1, Math.max(0, (t - times[i]) / (times[n] - times[i] || 1)));
  const at = (key: number) => Array.from(values.subarray((cubic ? 3 * key + 1 : key) * width, (cubic ? 3 * key + 1 : key) * width + width));
  const [from, to] = [at(i), at(n)];
  if (path === 'rotation') return new Quaternion(...from).normalize().slerp(new Quaternion(...to).normalize(), u).toArray();
  return from.map((x, k) => x + u * (to[k] - x));
}

function partsOf(glb: Glb, nodes: Nodes): Part[] {
  const { json } = glb;
  const parts: Part[] = [];
  for (const i of nodes.order) {
    const { mesh, skin } = json.nodes![i];
    if (mesh === undefined || skin !== undefined) continue; // bodies are shown by their motion
    const { primitives, name } = json.meshes?.[mesh] ?? { primitives: [] };
    primitives.forEach(({ attributes, indices, mode = 4, material }, k) => {
      if (mode !== 4 && mode !== 0) return;
      const vertices = Float32Array.from(glb.numbers(attributes.POSITION, 'VEC3'));
      const v = new Vector3();
      for (let at = 0; at < vertices.length; at += 3) v.fromArray(vertices, at).applyMatrix4(nodes.world[i]).toArray(vertices, at);
      const count = vertices.length / 3;
      let faces: Uint32Array | undefined;
      if (mode === 4) {
        faces = indices === undefined ? Uint32Array.from({ length: count - (count % 3) }, (_, at) => at) : Uint32Array.from(glb.numbers(indices, 'SCALAR'));
        if (faces.some((corner) => corner >= count)) throw new Error('names a vertex that it does not have');
        faces = faces.subarray(0, faces.length - (faces.length % 3));
      }
      if (count === 0 || faces?.length === 0) return;
      const [r, g, b] = json.materials?.[material ?? -1]?.pbrMetallicRoughness?.baseColorFactor ?? GREY;
      const called = nodes.name(i) || name || 'mesh';
      parts.push({ name: k > 0 && k < 100 ? `${called}.${k}` : called, color: [r, g, b], vertices, faces });
    });
  }
  return parts;
}

/** The joints of a skin, or without skins what an animation moves that has no mesh, over the time of the animation. */
function motionOf(nodes: Nodes, joints: number[], name: string): Motion {
  const inside = new Set(joints);
  const parentOf = (i: number, list: number[]) => {
    let parent = nodes.parents[i];
    while (parent >= 0 && !inside.has(parent)) parent = nodes.parents[parent];
    return list.indexOf(parent);
  };
  // As the skin lists them where parents come first there.
  const order = joints.every((i, j) => parentOf(i, joints) < j) ? joints : nodes.order.filter((i) => inside.has(i));
  const parents = order.map((i) => parentOf(i, order));
  const animated = nodes.end > nodes.start;
  if (animated && nodes.end - nodes.start > MOST_SECONDS) throw new Error('has an animation of more than an hour');
  const frames = animated ? Math.floor((nodes.end - nodes.start) * RATE + 1e-3) + 1 : 1;
  const count = order.length;
  const places = new Float32Array(frames * count * 3);
  const rotations = new Float32Array(frames * count * 4);
  const p = new Vector3();
  const s = new Vector3();
  const global = order.map(() => new Quaternion());
  const q = new Quaternion();
  const above = new Quaternion();
  for (let t = 0; t < frames; ++t) {
    nodes.pose(animated ? nodes.start + t / RATE : undefined);
    order.forEach((node, j) => {
      nodes.world[node].decompose(p, global[j], s);
      p.toArray(places, (t * count + j) * 3);
      q.copy(global[j]);
      if (parents[j] >= 0) q.premultiply(above.copy(global[parents[j]]).invert());
      rotations.set([q.w, q.x, q.y, q.z], (t * count + j) * 4);
    });
  }
  nodes.pose(undefined);
  return { name, rate: RATE, names: order.map((i) => nodes.name(i) || `joint ${i}`), parents, joints: places, ...rigid(places, rotations, parents, frames) };
}

/** Rotations and bones, where bones keep their lengths and rotate with their joints. */
function rigid(places: Float32Array, rotations: Float32Array, parents: number[], frames: number) {
  const count = parents.length;
  const offsets = new Float32Array(count * 3);
  const v = new Vector3();
  const q = new Quaternion();
  for (let t = 0; t < frames; ++t) {
    const global = parents.map(() => new Quaternion());
    for (let j = 0; j < count; ++j) {
      const i = (t * count + j) * 4;
      global[j].set(rotations[i + 1], rotations[i + 2], rotations[i + 3], rotations[i]);
      const parent = parents[j];
      if (parent < 0) continue;
      global[j].premultiply(global[parent]);
      v.fromArray(places, (t * count + j) * 3);
      for (const [k, axis] of (['x', 'y', 'z'] as const).entries()) v[axis] -= places[(t * count + parent) * 3 + k];
      v.applyQuaternion(q.copy(global[parent]).invert());
      if (t === 0) v.toArray(offsets, j * 3);
      else if (Math.hypot(v.x - offsets[j * 3], v.y - offsets[j * 3 + 1], v.z - offsets[j * 3 + 2]) > 0.003) return {};
    }
  }
  return { rotations, offsets };
}

/** The scene and the people of a .glb; compressed ones, and buffers outside the file, are refused. */
export function openGlb(bytes: Uint8Array, name: string): Opened {
  const glb = new Glb(bytes);
  const nodes = new Nodes(glb);
  const parts = partsOf(glb, nodes);
  const skins = (glb.json.skins ?? []).map(({ joints }) => joints.filter((i) => nodes.order.includes(i))).filter((joints) => joints.length > 1);
  const bare = nodes.order.filter((i) => glb.json.nodes![i].mesh === undefined && nodes.moved.has(i));
  const people = skins.length > 0 ? skins : bare.length > 1 ? [bare] : [];
  const different = people.filter((joints, k) => people.findIndex((other) => other.length === joints.length && other.every((i) => joints.includes(i))) === k);
  return { parts, notes: [], motions: different.map((joints, k) => motionOf(nodes, joints, different.length > 1 ? `${name} ${k}` : name)) };
}
