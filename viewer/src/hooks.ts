import type { Shape } from './person';
import type { Theme } from './stage';

/** What scripts and tests may use: window.inhabit. */
export interface Hooks {
  ready: boolean;
  error: string;
  /** Milliseconds from the page's start to its first picture. */
  firstPicture: number;
  /** How many files were opened or refused so far. */
  opened?: number;
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
  /** What is in the scene: by name, whether it is shown and stands out, and the middle of its box as drawn now. */
  objects(): { name: string; shown: boolean; marked: boolean; middle: number[] }[];
  /** Place of the camera, then what it looks at. */
  camera(): number[];
  /** Of each person, whether it has a body to show. */
  bodies(): boolean[];
  /** On a page of cards: how many, and how often their thumbnails were drawn. */
  cards(): number;
  pictures(): number;
}
