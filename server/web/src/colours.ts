// SPDX-License-Identifier: Apache-2.0

const kTurnPerId = (Math.sqrt(5) - 1) / 2;

const channel = (turn: number): string =>
  Math.trunc(150 + 105 * Math.cos(2 * Math.PI * turn)).toString(16).padStart(2, "0");

// Colours that tell things apart, those of the report of a build (builder/report/colours.h): with the golden
// ratio, any run of numbers is spread evenly over the colour wheel. Each reads on a light and on a dark ground and
// on photos.
export function colourOf(number: number): string {
  const hue = number * kTurnPerId;
  return `#${channel(hue)}${channel(hue - 1 / 3)}${channel(hue - 2 / 3)}`;
}

// A colour of the style sheet, for what is drawn on a canvas.
export const cssColour = (name: string): string =>
  getComputedStyle(document.documentElement).getPropertyValue(name).trim();
