// SPDX-License-Identifier: Apache-2.0
// The triangles of a flat outline in space, which may be concave.
import { ShapeUtils, Vector2 } from "three";

// Indices of corners, by threes. The outline is triangulated as seen along the axis that is closest to its
// normal.
export function trianglesOf(outline: [number, number, number][], normal: [number, number, number]): number[] {
  const steepness = normal.map(Math.abs);
  const along = steepness.indexOf(Math.max(...steepness));
  const flat = outline.map((corner) => new Vector2(corner[(along + 1) % 3], corner[(along + 2) % 3]));
  return ShapeUtils.triangulateShape(flat, []).flat();
}
