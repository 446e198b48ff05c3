// The page's data: a JSON header that describes arrays in one gzipped, base64 blob (written by inhabit/view/page.cpp).

export interface ArrayRef {
  at: number; // bytes from the blob's start
  count: number;
  type: 'f32' | 'u8' | 'u16' | 'u32' | 'i16';
  min?: number[]; // value = min + scale * stored, cyclic over the last axis
  scale?: number[];
}

export interface MotionRef {
  ref: ArrayRef;
  unit: number; // metres
  frames: number;
}

export interface BodyData {
  joints: number;
  influences: number;
  vertices: ArrayRef;
  faces: ArrayRef;
  weights: ArrayRef;
  bones: ArrayRef;
  rest: ArrayRef;
}

export type Role = 'motion' | 'past' | 'truth' | 'prediction' | 'future' | 'intention' | 'filled';

export interface PersonData {
  name: string;
  role: Role;
  start: number; // seconds
  rate: number;
  frames: number;
  joints?: ArrayRef; // (T, J, 3) metres
  motion?: MotionRef; // the same of a small figure
  full?: boolean; // a figure of rounded limbs where there is no body
  names: string[];
  parents: number[];
  body?: number;
  rotations?: ArrayRef; // (T, J, 4) quaternions w x y z
  trans?: ArrayRef; // (T, 3)
  offsets?: ArrayRef; // (J, 3)
  actions?: { names: string[]; spans: [number, number][] };
  intentions?: [number, number][]; // stretches: first frame, label
  keys?: number[]; // frames that were given
  given?: PersonData; // their poses, a frame each, where the motion's own are others
  only?: number[]; // joints of these that were given; all where it is missing
  collides?: [number, number, string?][]; // stretches: first frame, 1 where the body is inside the scene, how deep in what
  tracks?: TrackData[];
  hands?: { places: ArrayRef; on: ArrayRef }; // (T, 2, 3) and (T, 2)
  objects?: ObjectMotionData[];
}

/** Where an object is that moves: the scene has it as it is in the first frame. */
export interface ObjectMotionData {
  name: string;
  places: ArrayRef; // (T, 3) metres
  rotations: ArrayRef; // (T, 4) quaternions w x y z
}

/** A curve of bytes, 255 being 1, or stretches with names: first frame, label, negative for nothing. */
export interface TrackData {
  name: string;
  values?: ArrayRef; // (T)
  names?: string[];
  spans?: [number, number][];
}

export interface MeshData {
  name: string;
  color: [number, number, number]; // linear RGB
  vertices: ArrayRef;
  faces: ArrayRef;
}

export interface ContactsData {
  names: string[];
  start: number;
  rate: number;
  keys: number;
  points: ArrayRef; // (N, 3)
  first: ArrayRef; // (J + 1): joint j owns pairs [first[j], first[j + 1])
  index: ArrayRef; // point of each pair
  changes: ArrayRef; // (pairs, keys) differences modulo 256
}

export interface RecordingsData {
  rate: number;
  rows: { name: string; group: string; frames: number; spans: [number, number][]; marked: [number, number][] }[];
}

export interface SceneData {
  meshes: MeshData[];
  points?: ArrayRef;
}

/** One curve, or a row of bars: a value for each of the panel's ticks, or for each x. */
export interface SeriesData {
  name: string;
  x?: number[];
  y: (number | null)[];
  interval?: number[]; // half of the 95 % confidence interval
}

export interface PanelData {
  title: string;
  group: string; // of several that one chooses between; empty: all belong together
  ticks?: string[]; // names along x; without them x is a number
  bars: boolean;
  series: SeriesData[];
}

export interface ChartData {
  x: string; // what runs along x
  panels: PanelData[];
}

/** One file of a page of cards. */
export interface CardData {
  name: string;
  note: string;
  person?: PersonData;
  scene?: number; // index into `scenes`
  chart?: ChartData;
}

/** The standard skeleton (inhabit/body/skeleton.h). */
export interface StandardData {
  names: string[];
  parents: number[];
  offsets: number[]; // (J, 3) of the built-in body
}

export interface Header {
  standard: StandardData;
  note: string;
  cards?: CardData[];
  scenes?: SceneData[]; // of cards
  bodies: BodyData[];
  people: PersonData[];
  scene?: SceneData;
  contacts?: ContactsData;
  recordings?: RecordingsData;
}

export class Data {
  private constructor(readonly header: Header, private readonly bytes: ArrayBuffer) {}

  static async read(): Promise<Data> {
    const header = JSON.parse(document.getElementById('header')!.textContent!) as Header;
    const element = document.getElementById('blob')!;
    const text = atob(element.textContent!);
    element.remove();
    const packed = Uint8Array.from(text, (c) => c.charCodeAt(0));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('gzip'));
    return new Data(header, await new Response(stream).arrayBuffer());
  }

  /** The same arrays, of which other things are to be shown. */
  with(header: Partial<Header>) {
    return new Data({ ...this.header, cards: undefined, recordings: undefined, contacts: undefined, ...header }, this.bytes);
  }

  /** With what was opened on the page beside what is there. */
  joined(people: PersonData[], scene: SceneData | undefined, arrays: Arrays, note: string): Data {
    const { header, bytes } = this;
    const start = Math.ceil(bytes.byteLength / 4) * 4;
    const all = new Uint8Array(start + arrays.size);
    all.set(new Uint8Array(bytes));
    arrays.copyTo(all, start);
    const old = header.scene;
    const points = [old?.points, scene?.points].filter((ref) => ref !== undefined);
    const joined = (old || scene) && {
      meshes: [...(old?.meshes ?? []), ...(scene?.meshes ?? [])],
      points: points.length > 1 ? undefined : points[0],
    };
    const data = new Data({ ...header, note, people: [...header.people, ...people], scene: joined }, all.buffer);
    if (points.length > 1) {
      const clouds = points.map((ref) => data.floats(ref));
      const one = new Float32Array(clouds[0].length + clouds[1].length);
      one.set(clouds[0]);
      one.set(clouds[1], clouds[0].length);
      const more = new Arrays(data.bytes.byteLength);
      const ref = more.add(one);
      return data.with({ ...data.header, scene: { ...joined!, points: undefined } }).joined([], { meshes: [], points: ref }, more, note);
    }
    return data;
  }

  /** Bytes from which arrays of what is joined next will begin. */
  get end() {
    return Math.ceil(this.bytes.byteLength / 4) * 4;
  }

  raw(ref: ArrayRef) {
    const Kind = { f32: Float32Array, u8: Uint8Array, u16: Uint16Array, u32: Uint32Array, i16: Int16Array }[ref.type];
    return new Kind(this.bytes, ref.at, ref.count);
  }

  /** Joints (T, J, 3) metres of a small figure: planes of low, middle and high bytes of changes from frame to frame, (J, 3, T),
   *  of `unit` metres; joints after the first are as seen from it. */
  motion({ ref, unit, frames }: MotionRef): Float32Array {
    const bytes = this.raw(ref);
    const size = ref.count / 3;
    const columns = size / frames;
    const out = new Float32Array(size);
    for (let k = 0; k < columns; ++k) {
      for (let t = 0, sum = 0; t < frames; ++t) {
        const i = k * frames + t;
        sum += ((bytes[i] << 8) | (bytes[size + i] << 16) | (bytes[2 * size + i] << 24)) >> 8;
        out[t * columns + k] = sum * unit + (k < 3 ? 0 : out[t * columns + (k % 3)]);
      }
    }
    return out;
  }

  floats(ref: ArrayRef): Float32Array {
    const stored = this.raw(ref);
    const out = new Float32Array(stored);
    if (ref.min && ref.scale) {
      const n = ref.min.length;
      for (let i = 0; i < out.length; ++i) out[i] = ref.min[i % n] + ref.scale[i % n] * stored[i];
    }
    return out;
  }
}

/** Arrays that are made on the page, to be joined to its data. */
export class Arrays {
  size = 0;
  private readonly parts: { at: number; values: ArrayBufferView }[] = [];

  /** @param start where in the data's bytes they will begin */
  constructor(private readonly start: number) {}

  add(values: Float32Array | Uint32Array): ArrayRef {
    const at = this.size;
    this.parts.push({ at, values });
    this.size += values.byteLength;
    return { at: this.start + at, count: values.length, type: values instanceof Float32Array ? 'f32' : 'u32' };
  }

  copyTo(bytes: Uint8Array, start: number) {
    for (const { at, values } of this.parts) bytes.set(new Uint8Array(values.buffer, values.byteOffset, values.byteLength), start + at);
  }
}
