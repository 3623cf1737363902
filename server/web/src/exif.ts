// SPDX-License-Identifier: Apache-2.0
// EXIF orientation. The server takes pixels as stored, the browser shows the image upright: what the
// server answers is transformed to the upright image once, so that all views draw in its pixels.
import type { Answer, Point } from "./api";

const kHeadBytes = 256 * 1024; // of the file; EXIF precedes the image data
const kApp1 = 0xffe1;
const kScan = 0xffda;
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
  if (data.getUint16(0) !== 0xffd8) return 1;
  for (let at = 2; data.getUint16(at) !== kScan; at += 2 + data.getUint16(at + 2)) {
    const exif = data.getUint16(at) === kApp1 && data.getUint32(at + 4) === 0x45786966; // "Exif"
    if (exif) return orientationInTiff(data, at + 10);
  }
  return 1;
}

// The EXIF orientation of a JPEG file, 1 to 8; 1 (upright) for files without one.
export async function readOrientation(file: File): Promise<number> {
  const data = new DataView(await file.slice(0, kHeadBytes).arrayBuffer());
  try {
    const value = orientationInJpeg(data);
    return value >= 1 && value <= 8 ? value : 1;
  } catch (error) {
    if (error instanceof RangeError) return 1; // truncated or not a JPEG
    throw error;
  }
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
  const turned = orientation >= 5;
  const place = (x: number, y: number) => kUpright[orientation - 1](x, y, width, height);
  return {
    ...answer,
    planes: answer.planes.map((p) => ({ ...p, outline: p.outline.map(([x, y]) => place(x, y)) })),
    explanation: {
      ...why,
      image: { ...why.image, width: turned ? height : width, height: turned ? width : height },
      candidates: why.candidates.map((c) => ({
        ...c,
        points: c.points.map(([x, y, u, v]): typeof c.points[number] => [...place(x, y), u, v]),
      })),
    },
  };
}
