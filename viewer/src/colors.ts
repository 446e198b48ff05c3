import type { Role } from './data';

/** sRGB of a person by what its motion is. */
export const roleColor: Record<Role, number> = {
  motion: 0xdfbfa5,
  past: 0x9ca1a9,
  truth: 0xec8a2b,
  prediction: 0x3c7fe6,
};

export const roleName: Record<Role, string> = {
  motion: 'Motion',
  past: 'Observed',
  truth: 'Truth',
  prediction: 'Prediction',
};

/** Further tones for several plain motions, the first being the role's own. */
export const motionTones = [0xdfbfa5, 0x8fb3ab, 0xb58bb0, 0xa3ac6a, 0x8b9cc9, 0xcf8a86];

export const actionTones = ['#f2c879', '#9fc9b1', '#a9bfe8', '#e5a9a0', '#c9b3dd', '#d3cf8d', '#9ccbd6', '#e0b892'];

export const css = (color: number) => '#' + color.toString(16).padStart(6, '0');
