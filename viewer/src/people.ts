import { Box3, Vector3 } from 'three';
import { futureColor, intentionColors, motionTones, roleColor } from './colors';
import type { Data, PersonData } from './data';
import { Bodies, isFigure, Person } from './person';

/** The colour of the k-th person of its role: roles have one each, several plain motions and futures a tone each. */
function colorOf({ role, intentions }: PersonData, k: number): number {
  if (role === 'motion') return motionTones[k % motionTones.length];
  if (role === 'future') return futureColor(k);
  if (role === 'intention' && intentions) return Number.parseInt(intentionColors(intentions[0][1] + 1).at(-1)!.slice(1), 16);
  return roleColor[role];
}

/** Everybody on the page. Crowds are see-through. */
export function makePeople(data: Data, bodies: Bodies): Person[] {
  const sources = data.header.people;
  const figures = sources.some(isFigure); // small ones
  return sources.map((source, i) => {
    const ofRole = (other: PersonData) => other.role === source.role;
    const opacity = sources.filter(ofRole).length > 6 ? 0.45 : 1;
    return new Person(data, bodies, source, colorOf(source, sources.slice(0, i).filter(ofRole).length), opacity, figures || source.motion !== undefined || source.full);
  });
}

/** Height of what people stand on: the scene's floor y = 0 or, away from it, below the lowest foot. */
export function groundUnder(people: Person[]): number {
  let lowest = Infinity;
  for (const person of people) for (let i = 1; i < person.joints.length; i += 3) lowest = Math.min(lowest, person.joints[i]);
  return !Number.isFinite(lowest) || Math.abs(lowest) < 0.35 ? 0 : lowest - 0.02;
}

/** Where the first four people are at the start, in the middle and at the end of their motion, `height` metres up. */
export function placesOf(people: Person[], height: number): Vector3[] {
  return people.slice(0, 4).flatMap(({ joints, parents }) => {
    const stride = parents.length * 3;
    const frames = joints.length / stride;
    return [0, Math.floor(frames / 2), frames - 1].map((f) => new Vector3(joints[f * stride], height, joints[f * stride + 2]));
  });
}

/** Where the people's roots go. */
export function extentOf(people: Person[]): Box3 {
  const extent = new Box3();
  const v = new Vector3();
  for (const person of people) {
    for (let f = 0; f < person.joints.length; f += person.parents.length * 3) extent.expandByPoint(v.fromArray(person.joints, f));
  }
  return extent;
}

/** The direction (angle about +Y from +Z) in which a person looks at first: from the hips. */
export function facing(person: Person): number {
  const names = person.data_.names.map((name) => name.toLowerCase());
  const left = names.findIndex((name) => /^(left_hip|lefthip|l_?hip|leftupleg|lhipjoint)$/.test(name));
  const right = names.findIndex((name) => /^(right_hip|righthip|r_?hip|rightupleg|rhipjoint)$/.test(name));
  if (left < 0 || right < 0) return 0;
  const x = person.joints[left * 3] - person.joints[right * 3];
  const z = person.joints[left * 3 + 2] - person.joints[right * 3 + 2];
  return Math.atan2(-z, x); // left is +X when the person faces +Z
}
