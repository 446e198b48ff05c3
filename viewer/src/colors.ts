import { Color } from 'three';
import type { Role } from './data';

/** sRGB of a person by what its motion is. */
export const roleColor: Record<Role, number> = {
  motion: 0xdfbfa5,
  past: 0x9ca1a9,
  truth: 0xec8a2b,
  prediction: 0x3c7fe6,
  future: 0x3c7fe6,
  intention: 0xdfbfa5,
  filled: 0x9467d6,
};

/** Key frames, and frames in which a body is inside the scene. */
export const keyColor = 0x3c7fe6;
export const collisionColor = 0xd23b2f;

export const roleName: Record<Role, string> = {
  motion: 'Motion',
  past: 'Observed',
  truth: 'Truth',
  prediction: 'Prediction',
  future: 'Futures',
  intention: 'Intentions',
  filled: 'Filled in',
};

/** Further tones for several plain motions, the first being the role's own. */
export const motionTones = [0xdfbfa5, 0x8fb3ab, 0xb58bb0, 0xa3ac6a, 0x8b9cc9, 0xcf8a86];

export const actionTones = ['#f2c879', '#9fc9b1', '#a9bfe8', '#e5a9a0', '#c9b3dd', '#d3cf8d', '#9ccbd6', '#e0b892'];

export const css = (color: number) => '#' + color.toString(16).padStart(6, '0');

/** Futures: hues and tones about the prediction's blue, neighbours far apart. */
export function futureColor(i: number): number {
  if (i === 0) return roleColor.future;
  const fraction = (i * 0.618034) % 1;
  return new Color().setHSL((160 + 140 * fraction) / 360, 0.62, 0.42 + 0.24 * ((i * 0.381966) % 1)).getHex();
}

const intentionTones = ['#e9a23b', '#3f9e97', '#c9533f', '#7d6bc0', '#86b04a', '#d873a5', '#4d88d8', '#94704f', '#c9b92f', '#5c6b7a', '#41b5d1', '#a63d77'];

/** A colour for each of `count` intention labels. */
export const intentionColors = (count: number) => Array.from({ length: count }, (_, i) =>
  intentionTones[i] ?? '#' + new Color().setHSL((i * 0.618034) % 1, 0.5, 0.55).getHexString());
