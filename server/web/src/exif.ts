// SPDX-License-Identifier: Apache-2.0
// EXIF orientation. The server takes the pixels of every format as they are stored, and browsers don't agree
// on which formats they turn: the page asks them for stored pixels, turns those itself, and transforms what
// the server answers to the upright image once, so that all views draw in its pixels.
import type { Answer, Candidate, Point } from "./api";

const kApp1 = 0xffe1;
const kScan = 0xffda;
const kNamed = 0x45786966; // "Exif", before the TIFF structure in JPEG and some WebP files
const kPngExif = 0x65584966; // "eXIf"
const kWebpExif = 0x45584946; // "EXIF"
const kOrientation = 0x0112;

// The value of the orientation tag in a TIFF structure at `start`.
function orientationInTiff(data: DataView, start: number): number {
  const little = data.getUint16(start) === 0x4949;
  const directory = start + data.getUint32(start + 4, little);
  const entries = data.getUint16(directory, little);
  for (let i = 0; i < entries; ++i) {
    const entry = directory + 2 + 12 * i;
    if (data.getUint16(entry, little) === kOrientation) return data.getUint16(entry + 8, little);
  }
  return 1;
}

function orientationInJpeg(data: DataView): number {
  for (let at = 2; data.getUint16(at) !== kScan; at += 2 + data.getUint16(at + 2)) {
    const exif = data.getUint16(at) === kApp1 && data.getUint32(at + 4) === kNamed;
    if (exif) return orientationInTiff(data, at + 10);
  }
  return 1;
}

function orientationInPng(data: DataView): number {
  let at = 8;
  while (data.getUint32(at + 4) !== kPngExif) at += 12 + data.getUint32(at);
  return orientationInTiff(data, at + 8);
}

function orientationInWebp(data: DataView): number {
  let at = 12;
  while (data.getUint32(at) !== kWebpExif) {
    const size = data.getUint32(at + 4, true);
    at += 8 + size + (size % 2);
  }
  return orientationInTiff(data, data.getUint32(at + 8) === kNamed ? at + 14 : at + 8);
}

function orientationIn(data: DataView): number {
  if (data.getUint16(0) === 0xffd8) return orientationInJpeg(data);
  if (data.getUint32(0) === 0x89504e47) return orientationInPng(data); // "\x89PNG"
  if (data.getUint32(8) === 0x57454250) return orientationInWebp(data); // "WEBP"
  return 1;
}

// The EXIF orientation of a JPEG, PNG or WebP file, 1 to 8; 1 (upright) for files without one.
export async function readOrientation(file: File): Promise<number> {
  const data = new DataView(await file.arrayBuffer());
  try {
    const value = orientationIn(data);
    return value >= 1 && value <= 8 ? value : 1;
  } catch (error) {
    if (error instanceof RangeError) return 1; // the file ends before there is one
    throw error;
  }
}

// CSS transforms about the upper left corner that turn a stored image upright, by EXIF orientation.
const kTurns = [
  "none",
  "translate(100%, 0) scale(-1, 1)",
  "translate(100%, 100%) scale(-1, -1)",
  "translate(0, 100%) scale(1, -1)",
  "matrix(0, 1, 1, 0, 0, 0)",
  "rotate(90deg) translate(0, -100%)",
  "matrix(0, -1, -1, 0, 0, 0) translate(-100%, -100%)",
  "rotate(-90deg) translate(-100%, 0)",
];

const isOnSide = (orientation: number) => orientation >= 5;

// The style of a stored image in a frame that is as large as the upright one of width x height.
export function turnedStyle(orientation: number, width: number, height: number) {
  const percent = (share: number) => `${100 * share}%`;
  const onSide = isOnSide(orientation);
  return {
    width: percent(onSide ? height / width : 1),
    height: percent(onSide ? width / height : 1),
    transform: kTurns[orientation - 1],
  };
}

// Where a pixel (x, y) of a stored image of w x h is in the upright one, by EXIF orientation.
const kUpright: ((x: number, y: number, w: number, h: number) => Point)[] = [
  (x, y) => [x, y],
  (x, y, w) => [w - x, y],
  (x, y, w, h) => [w - x, h - y],
  (x, y, _, h) => [x, h - y],
  (x, y) => [y, x],
  (x, y, _, h) => [h - y, x],
  (x, y, w, h) => [h - y, w - x],
  (x, y, w) => [y, w - x],
];

// The same answer in pixels of the upright image.
export function uprightAnswer(answer: Answer, orientation: number): Answer {
  const why = answer.explanation;
  if (orientation === 1 || !why) return answer;
  const { width, height } = why.image;
  const onSide = isOnSide(orientation);
  const place = (x: number, y: number) => kUpright[orientation - 1](x, y, width, height);
  const upright = <Matched extends { points: Candidate["points"] }>(matched: Matched): Matched => ({
    ...matched,
    points: matched.points.map(([x, y, u, v]): Candidate["points"][number] => [...place(x, y), u, v]),
  });
  return {
    ...answer,
    planes: answer.planes.map((p) => ({ ...p, outline: p.outline.map(([x, y]) => place(x, y)) })),
    explanation: {
      ...why,
      image: { ...why.image, width: onSide ? height : width, height: onSide ? width : height },
      candidates: why.candidates.map(upright),
      keyframes: why.keyframes.map(upright),
    },
  };
}
