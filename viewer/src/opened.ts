import { Arrays, Data, PersonData, SceneData, StandardData } from './data';
import { reasonOf } from './dom';
import { readNpz } from './npz';
import { openGlb } from './open_glb';
import { openNpz } from './open_npz';
import { isFigure } from './person';

/** A motion that was opened on the page. */
export interface Motion {
  name: string;
  rate: number;
  names: string[];
  parents: number[];
  joints: Float32Array; // (T, J, 3) metres, +Y up
  rotations?: Float32Array; // (T, J, 4) w x y z
  offsets?: Float32Array; // (J, 3), with rotations
  actions?: PersonData['actions'];
  objects?: { name: string; places: Float32Array; rotations: Float32Array }[];
}

/** A mesh, or points where there are no faces. */
export interface Part {
  name: string;
  color: [number, number, number];
  vertices: Float32Array;
  faces?: Uint32Array;
}

export interface Opened {
  motions: Motion[];
  parts: Part[];
  notes: string[]; // what was assumed of it
}

const LARGEST = 512 << 20; // bytes of a file
const MOST_FRAMES = 200_000;

function check(condition: boolean, reason: string): asserts condition {
  if (!condition) throw new Error(reason);
}

const isFinite = (values: Float32Array) => values.every(Number.isFinite);

/** What a file that was dropped holds. Throws Error with the file's name and the reason, in one line. */
export async function openFile(file: File, standard: StandardData): Promise<Opened> {
  try {
    const kind = /\.([a-z0-9]+)$/i.exec(file.name)?.[1].toLowerCase() ?? '';
    check(['npz', 'glb'].includes(kind), 'is neither .npz nor .glb; `inhabit convert` makes these of others');
    check(file.size > 0, 'is empty');
    check(file.size < LARGEST, 'is larger than 512 MiB, too large for a page');
    const bytes = new Uint8Array(await file.arrayBuffer());
    const name = file.name.slice(0, -kind.length - 1);
    const opened = kind === 'npz' ? openNpz(await readNpz(bytes), name, standard) : openGlb(bytes, name);
    for (const { joints, rotations, rate, parents } of opened.motions) {
      const frames = joints.length / 3 / parents.length;
      check(frames >= 1, 'has no frames');
      check(frames <= MOST_FRAMES, `has ${frames} frames, more than ${MOST_FRAMES}`);
      check(rate > 0 && rate <= 1000, 'has no frame rate in (0, 1000]');
      check(isFinite(joints) && (!rotations || isFinite(rotations)), 'has a number that is not finite');
    }
    for (const { vertices } of opened.parts) check(isFinite(vertices), 'has a number that is not finite');
    check(opened.motions.length + opened.parts.length > 0, 'holds neither a motion nor a scene');
    return { ...opened, notes: opened.notes.length > 0 ? [`${file.name}: ${opened.notes.join('; ')}.`] : [] };
  } catch (reason) {
    const known = reason instanceof Error && !(reason instanceof TypeError) && !(reason instanceof RangeError);
    throw new Error(`${file.name}: ${known ? reasonOf(reason) : 'is damaged'}`);
  }
}

/** What the page shows, with what was opened beside it. */
export function withOpened(data: Data, { motions, parts, notes }: Opened): Data {
  const arrays = new Arrays(data.end);
  const { standard, bodies } = data.header;
  const body = bodies.findIndex(({ joints }) => joints === standard.names.length);
  // Among many small figures it is one of them.
  const role = data.header.people.find(isFigure)?.role ?? 'motion';
  const people = motions.map(({ rotations, offsets, objects, ...motion }): PersonData => {
    const frames = motion.joints.length / 3 / motion.parents.length;
    const { name, rate, names, parents, actions } = motion;
    const person: PersonData = { name, role, start: 0, rate, frames, names, parents, actions, joints: arrays.add(motion.joints) };
    const same = <T>(a: T[], b: T[]) => a.length === b.length && a.every((x, i) => x === b[i]);
    const known = same(names, standard.names) && same(parents, standard.parents);
    if (known && body < 0) person.full = true;
    if (known && rotations && offsets && body >= 0) {
      const trans = new Float32Array(frames * 3);
      for (let i = 0; i < trans.length; ++i) trans[i] = motion.joints[Math.floor(i / 3) * names.length * 3 + (i % 3)] - offsets[i % 3];
      Object.assign(person, { body, rotations: arrays.add(rotations), trans: arrays.add(trans), offsets: arrays.add(offsets) });
    }
    if (objects?.length) {
      person.objects = objects.map(({ name: called, places, rotations: own }) => ({ name: called, places: arrays.add(places), turns: arrays.add(own) }));
    }
    return person;
  });
  const meshes = parts.filter(({ faces }) => faces);
  const clouds = parts.filter(({ faces }) => !faces);
  let scene: SceneData | undefined;
  if (parts.length > 0) {
    scene = { meshes: meshes.map(({ name, color, vertices, faces }) => ({ name, color, vertices: arrays.add(vertices), faces: arrays.add(faces!) })) };
    if (clouds.length > 0) {
      const points = new Float32Array(clouds.reduce((sum, { vertices }) => sum + vertices.length, 0));
      clouds.reduce((at, { vertices }) => (points.set(vertices, at), at + vertices.length), 0);
      scene.points = arrays.add(points);
    }
  }
  return data.joined(people, scene, arrays, [data.header.note, ...notes].filter(Boolean).join('\n'));
}
