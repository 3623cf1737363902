// SPDX-License-Identifier: Apache-2.0
// The graph of planes with the planes of one surface as one node.
import type { Overview } from "./api";

export interface Surface {
  id: number; // the lowest of its planes
  planes: number[];
  features: number; // of them all
  reference: number; // keyframe that shows its plane with most features
}

export interface SurfaceGraph {
  surfaces: Surface[];
  ofPlane: Map<number, number>; // id of the surface
  edges: [number, number][]; // ids of surfaces, each pair once
}

export function surfaceGraph({ planes, edges }: Overview): SurfaceGraph {
  const byId = new Map<number, Surface & { most: number }>();
  const ofPlane = new Map<number, number>();
  planes.id.forEach((plane, i) => {
    const id = planes.surface[i];
    const surface = byId.get(id) ?? { id, planes: [], features: 0, reference: planes.reference[i], most: 0 };
    surface.planes.push(plane);
    surface.features += planes.features[i];
    if (planes.features[i] > surface.most) {
      surface.most = planes.features[i];
      surface.reference = planes.reference[i];
    }
    byId.set(id, surface);
    ofPlane.set(plane, id);
  });
  const pairs = new Map<string, [number, number]>();
  edges.a.forEach((plane, i) => {
    const ends = [ofPlane.get(plane)!, ofPlane.get(edges.b[i])!];
    const [a, b] = ends.sort((x, y) => x - y);
    if (a !== b) pairs.set(`${a} ${b}`, [a, b]);
  });
  return { surfaces: [...byId.values()], ofPlane, edges: [...pairs.values()] };
}
