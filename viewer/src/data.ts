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
  collides?: [number, number][]; // stretches: first frame, 1 where the body is inside the scene
  tracks?: TrackData[];
  hands?: { places: ArrayRef; on: ArrayRef }; // (T, 2, 3) and (T, 2)
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

export interface Header {
  note: string;
  bodies: BodyData[];
  people: PersonData[];
  scene?: { meshes: MeshData[]; points?: ArrayRef };
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
