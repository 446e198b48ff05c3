import type { Shape } from './person';
import type { Theme } from './stage';

/** What scripts and tests may use: window.inhabit. */
export interface Hooks {
  ready: boolean;
  error: string;
  duration: number;
  people: string[];
  setTime(seconds: number): void;
  time(): number;
  play(): void;
  pause(): void;
  playing(): boolean;
  setShape(shape: Shape): void;
  setFollow(on: boolean): void;
  setGhosts(on: boolean): void;
  setTheme(theme: Theme): void;
  setJoint(name: string): void;
  setCamera(x: number, y: number, z: number, target?: [number, number, number]): void;
  /** World positions (J, 3) of a person's joints as drawn now. */
  jointPositions(person: number): number[][];
  /** Of each still key, world positions of what is given: of every joint, or of those that are. */
  keyPlaces(): number[][][];
  visible(person: number): boolean;
  /** Many figures: side by side (true) or overlaid where they go. */
  setApart(on: boolean): void;
  /** Makes one of many figures stand out; -1: none. */
  choose(person: number): void;
}
