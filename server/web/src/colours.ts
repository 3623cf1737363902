// SPDX-License-Identifier: Apache-2.0
// Colours that tell things apart. Each reads on a light and on a dark ground and on photos.
const kPalette = [
  "#2f9e9e", "#e07b39", "#7a6ff0", "#c94f7c", "#5c9e31", "#b8860b", "#3d85d8", "#a0522d",
];

export const colourOf = (number: number): string =>
  kPalette[((number % kPalette.length) + kPalette.length) % kPalette.length];

// A colour of the style sheet, for what is drawn on a canvas.
export const cssColour = (name: string): string =>
  getComputedStyle(document.documentElement).getPropertyValue(name).trim();
