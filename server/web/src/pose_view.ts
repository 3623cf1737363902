// SPDX-License-Identifier: Apache-2.0
// A map with poses as seen from above: points of its frame in the plane of the picture, and where the
// drawing has them. Lengths are in the unit of the frame; pure functions.
import type { Appearance, FloorPlan, Pose, PoseLayer } from "./api";

export type Vec2 = [number, number];
export type Vec3 = [number, number, number];

const kAxes: Vec3[] = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];

const dot = (a: Vec3, b: Vec3) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const sum = (a: Vec3, b: Vec3): Vec3 => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const times = (s: number, a: Vec3): Vec3 => [s * a[0], s * a[1], s * a[2]];
const unit = (a: Vec3): Vec3 => times(1 / Math.hypot(...a), a);
const cross = (a: Vec3, b: Vec3): Vec3 => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];

// A vector turned by a unit quaternion x, y, z, w.
export function turned([x, y, z, w]: Pose["orientation"], v: Vec3): Vec3 {
  const t = times(2, cross([x, y, z], v));
  return sum(sum(v, times(w, t)), cross([x, y, z], t));
}

// Unit vectors of the frame that point to the right, to the top and out of the picture.
export interface Above {
  right: Vec3;
  top: Vec3;
  up: Vec3;
}

const kClose = Math.cos(20 * (Math.PI / 180));

// The axis of the frame along `up` where there is one: most frames have one along gravity, and the mean
// direction of the tops of images is off by the pitch of the camera.
function nearAxis(up: Vec3): Vec3 {
  const axis = kAxes.find((a) => Math.abs(dot(a, up)) > kClose);
  return axis ? times(Math.sign(dot(axis, up)), axis) : unit(up);
}

// x is to the right, unless it points up. Where up is unknown, z is taken for it.
export function viewFromAbove(known: Vec3 | null): Above {
  const up = nearAxis(known ?? [0, 0, 1]);
  const sideways = kAxes.find((a) => Math.abs(dot(a, up)) < 0.8)!;
  const right = unit(sum(sideways, times(-dot(sideways, up), up)));
  return { right, top: cross(up, right), up };
}

// Where the picture has a point, or a direction: to the right and to the top.
export const seen = ({ right, top }: Above, p: Vec3): Vec2 => [dot(right, p), dot(top, p)];

// A direction as a unit vector of the picture; null for one that is nearly along the line of sight.
export function directionSeen(view: Above, direction: Vec3): Vec2 | null {
  const kLeast = 0.2;
  const [x, y] = seen(view, direction);
  const length = Math.hypot(x, y);
  return length < kLeast ? null : [x / length, y / length];
}

// The viewing direction of a camera.
export const headingSeen = (view: Above, orientation: Pose["orientation"]): Vec2 | null =>
  directionSeen(view, turned(orientation, [0, 0, 1]));

// The axes of the frame that lie in the picture.
export function axesSeen(view: Above): { name: string; direction: Vec2 }[] {
  const kFlat = 0.95; // length of what is seen of a unit vector
  return ["x", "y", "z"]
    .map((name, i) => ({ name, direction: seen(view, kAxes[i]) }))
    .filter(({ direction }) => Math.hypot(...direction) > kFlat);
}

// The ellipse of two standard deviations of a position: semi-axes, and the angle of the long one from
// the right towards the top.
export function ellipseSeen(view: Above, covariance: number[][]) {
  const along = (a: Vec3, b: Vec3) =>
    a.reduce((s, ai, i) => s + ai * dot(covariance[i].slice(0, 3) as Vec3, b), 0);
  const [xx, xy, yy] = [along(view.right, view.right), along(view.right, view.top), along(view.top, view.top)];
  const mean = (xx + yy) / 2;
  const apart = Math.hypot((xx - yy) / 2, xy);
  return {
    long: 2 * Math.sqrt(mean + apart),
    short: 2 * Math.sqrt(Math.max(0, mean - apart)),
    angle_rad: Math.atan2(2 * xy, xx - yy) / 2,
  };
}

// The line that an upright plane is from above: along it, as far as its outline.
function lineSeen(view: Above, normal: Vec3, outline: Vec2[]): Vec2[] {
  const [x, y] = unit([...seen(view, normal), 0]);
  const offset = outline.reduce((s, p) => s + x * p[0] + y * p[1], 0) / outline.length;
  const places = outline.map((p) => -y * p[0] + x * p[1]);
  return [Math.min(...places), Math.max(...places)].map((s): Vec2 => [x * offset - y * s, y * offset + x * s]);
}

// A plane from above: a line (two points) if it is upright, else its outline; empty if it has none.
export function planeSeen(view: Above, { normal, outline }: PoseLayer["planes"][number]): Vec2[] {
  const kUpright = 0.3; // cosine of the angle between its normal and up
  const points = outline.map((p) => seen(view, p));
  const upright = Math.abs(dot(normal, view.up)) < kUpright;
  if (points.length < (upright ? 2 : 3)) return [];
  return upright ? lineSeen(view, normal, points) : points;
}

export interface Box {
  low: Vec2;
  high: Vec2;
}

// The box of all that must be seen, and of most of what else there is: a few points far away would make
// the rest small.
export function boxOf(must: Vec2[], others: Vec2[]): Box {
  const kLeftOut = 0.02; // share, on each side
  const skipped = Math.floor(kLeftOut * others.length);
  const range = (axis: 0 | 1): Vec2 => {
    const most = others.map((p) => p[axis]).sort((a, b) => a - b).slice(skipped, others.length - skipped);
    const all = [...must.map((p) => p[axis]), ...most.slice(0, 1), ...most.slice(-1)];
    return [all.reduce((a, b) => Math.min(a, b)), all.reduce((a, b) => Math.max(a, b))];
  };
  const [x, y] = [range(0), range(1)];
  return { low: [x[0], y[0]], high: [x[1], y[1]] };
}

export interface Room {
  width: number;
  height: number; // at most
  margin: number;
  strip: number; // left free at the bottom
}

// The box, or that of one unit around a single position.
function widened(box: Box): Box {
  const kLeast = 1e-6; // extent, in units
  const extent = Math.max(...box.high.map((v, axis) => v - box.low[axis]));
  if (extent > kLeast) return box;
  return { low: [box.low[0] - 0.5, box.low[1] - 0.5], high: [box.high[0] + 0.5, box.high[1] + 0.5] };
}

// A drawing of a box: pixels per unit, its height, where it has a point (y down), and the reverse.
export function layOut(box: Box, room: Room) {
  const { low, high } = widened(box);
  const { width, margin, strip } = room;
  const [dx, dy] = [high[0] - low[0], high[1] - low[1]];
  const least = Math.max(dx, dy) / 1e3;
  const scale = Math.min(
    (width - 2 * margin) / Math.max(dx, least),
    (room.height - 2 * margin - strip) / Math.max(dy, least),
  );
  const height = scale * dy + 2 * margin + strip;
  const left = (width - scale * dx) / 2;
  const at = ([x, y]: Vec2): Vec2 => [left + scale * (x - low[0]), margin + scale * (high[1] - y)];
  const from = ([x, y]: Vec2): Vec2 => [low[0] + (x - left) / scale, high[1] - (y - margin) / scale];
  return { scale, height, at, from };
}

// The corners of a plan's image in the frame, in order.
export function planCorners({ plan_from_frame: [[a, b, c], [d, e, f]], width, height }: FloorPlan): Vec2[] {
  const area = a * e - b * d;
  const back = ([x, y]: Vec2): Vec2 =>
    [(e * (x - c) - b * (y - f)) / area, (a * (y - f) - d * (x - c)) / area];
  return [back([0, 0]), back([width, 0]), back([width, height]), back([0, height])];
}

// The matrix of an SVG transform from the pixels of a plan to a drawing that has points of the frame at `at`.
export function planTransform(plan: FloorPlan, at: (p: Vec2) => Vec2): string {
  const [o, x, , y] = planCorners(plan).map(at);
  const { width, height } = plan;
  return `matrix(${[(x[0] - o[0]) / width, (x[1] - o[1]) / width, (y[0] - o[0]) / height, (y[1] - o[1]) / height,
    ...o].join(" ")})`;
}

// Panoramas of a map without poses as keyframes in the frame of their layer, to be drawn in the same way.
export function asPoseLayer({ nodes, metres_per_unit }: Appearance): PoseLayer {
  const looking = (heading_rad: number): Pose["orientation"] => {
    const [s, c] = [Math.sin(heading_rad / 2), Math.cos(heading_rad / 2)];
    return [(-c - s) / 2, (c - s) / 2, (s - c) / 2, (s + c) / 2]; // about z, of a camera that looks along x
  };
  return {
    frame: "layer",
    unit: metres_per_unit === 1 ? "metres" : "unknown",
    noise: { position_deviation: null, rotation_deviation_rad: null },
    up: [0, 0, 1],
    keyframes: {
      id: nodes.map((n) => n.id),
      position: nodes.map((n) => [n.x, n.y, 0]),
      orientation: nodes.map((n) => looking(n.heading_rad)),
    },
    nodes: { id: [], position: [], orientation: [] },
    planes: [],
  };
}

// By the even-odd rule.
export function holds(polygon: Vec2[], [x, y]: Vec2): boolean {
  let inside = false;
  polygon.forEach(([ax, ay], i) => {
    const [bx, by] = polygon[(i + 1) % polygon.length];
    if (ay > y !== by > y && x < bx + ((y - by) / (ay - by)) * (ax - bx)) inside = !inside;
  });
  return inside;
}

// A point inside a polygon, near its middle: that where the corners' mean is one, else the nearest to it of
// the middles of three corners in a row, of which some are, as for any polygon.
export function pointInside(polygon: Vec2[]): Vec2 {
  const mean = (corners: Vec2[]): Vec2 => [
    corners.reduce((sum, [x]) => sum + x, 0) / corners.length,
    corners.reduce((sum, [, y]) => sum + y, 0) / corners.length,
  ];
  const middle = mean(polygon);
  const away = ([x, y]: Vec2) => Math.hypot(x - middle[0], y - middle[1]);
  const corner = (i: number) => polygon[i % polygon.length];
  const others = polygon.map((_, i) => mean([corner(i), corner(i + 1), corner(i + 2)]))
    .sort((a, b) => away(a) - away(b));
  return [middle, ...others].find((point) => holds(polygon, point)) ?? middle;
}

export function areaOf(polygon: Vec2[]): number {
  const [ox, oy] = polygon[0] ?? [0, 0];
  return Math.abs(polygon.reduce((sum, [ax, ay], i) => {
    const [bx, by] = polygon[(i + 1) % polygon.length];
    return sum + (ax - ox) * (by - oy) - (ay - oy) * (bx - ox);
  }, 0)) / 2;
}

// A round length that is at most `most_px` long at `scale` pixels per unit.
export function barLength(scale: number, most_px: number): number {
  const most = most_px / scale;
  const power = 10 ** Math.floor(Math.log10(most));
  return power * ([5, 2].find((n) => n * power <= most) ?? 1);
}
