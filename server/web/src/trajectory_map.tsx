// SPDX-License-Identifier: Apache-2.0
// The trajectory of a sequence in the plane, reconstructed from its turns (the paper's fig. 10).
import type { Orientation } from "./api";
import { Sign } from "./parts";
import { boxOf, type Vec2 } from "./pose_view";
import type { Stretch } from "./types";

const kWidth = 600; // of the drawing, in its own units
const kHeight = 420; // at most
const kMargin = 30;
const kTick = 16; // of the heading at a node

interface Point {
  x: number;
  y: number;
}

// Where the drawing has the frames of a stretch: y up, as on a floor plan.
function frameOf({ frames }: Orientation, { first, last }: Stretch) {
  const places = frames.x.slice(first, last + 1).map((x, i): Vec2 => [x, frames.y[first + i]]);
  const { low: [left, bottom], high: [right, top] } = boxOf(places, []);
  const scale = Math.min(
    (kWidth - 2 * kMargin) / Math.max(right - left, 1),
    (kHeight - 2 * kMargin) / Math.max(top - bottom, 1),
  );
  const margin = (kWidth - scale * (right - left)) / 2;
  const height = scale * (top - bottom) + 2 * kMargin;
  const at = (row: number): Point => ({
    x: margin + scale * (frames.x[row] - left),
    y: kMargin + scale * (top - frames.y[row]),
  });
  return { at, height };
}

export function TrajectoryMap(props: {
  layer: Orientation;
  stretch: Stretch;
  row: number; // chosen, of the layer's columns
  choose: (row: number) => void;
}) {
  const { layer, stretch, row, choose } = props;
  const { frames } = layer;
  const rowOf = new Map<number, number>();
  for (let i = stretch.first; i <= stretch.last; ++i) rowOf.set(frames.id[i], i);
  const { at, height } = frameOf(layer, stretch);
  const line = (first: number, last: number) =>
    Array.from({ length: last - first + 1 }, (_, i) => at(first + i))
      .map((p) => `${p.x.toFixed(1)},${p.y.toFixed(1)}`).join(" ");
  const here = <T extends { a: number; b: number }>(edge: T) => rowOf.has(edge.a) && rowOf.has(edge.b);
  const nodes = layer.nodes.filter((n) => rowOf.has(n.id));
  const falseTurns = layer.turns.filter((t) => !t.confirmed && rowOf.has(t.frame));
  const chosen = at(row);
  return (
    <figure>
      <svg class="plot trajectory-map" viewBox={`0 0 ${kWidth} ${height.toFixed(0)}`} role="img"
        aria-label={`Trajectory by turns: ${nodes.length} nodes in ${rowOf.size} frames`}>
        {layer.corridors.filter((c) => rowOf.has(c.first)).map((c) => (
          <polyline key={c.id} class="corridor" points={line(rowOf.get(c.first)!, rowOf.get(c.last)!)}>
            <title>corridor {c.id}</title>
          </polyline>
        ))}
        <polyline class="path" points={line(stretch.first, stretch.last)} />
        {layer.edges.filter((e) => e.kind === "loop" && here(e)).map((e) => {
          const [a, b] = [at(rowOf.get(e.a)!), at(rowOf.get(e.b)!)];
          return <line key={`${e.a} ${e.b}`} class="loop" x1={a.x} y1={a.y} x2={b.x} y2={b.y} />;
        })}
        {nodes.map((n) => {
          const p = at(rowOf.get(n.id)!);
          const heading = n.heading_rad;
          return (
            <g key={n.id} class={n.kind} onClick={() => choose(rowOf.get(n.id)!)}>
              <title>{n.kind === "turn" ? "turn" : "node"} at frame {frames.frame[rowOf.get(n.id)!]}</title>
              {heading !== null && (
                <line x1={p.x} y1={p.y} x2={p.x + kTick * Math.cos(heading)} y2={p.y - kTick * Math.sin(heading)} />
              )}
              {n.kind === "turn"
                ? <path class="mark" d={`M ${p.x} ${p.y - 9} l 9 9 l -9 9 l -9 -9 z`} />
                : <circle class="mark" cx={p.x} cy={p.y} r="5" />}
            </g>
          );
        })}
        {falseTurns.map((t) => {
          const p = at(rowOf.get(t.frame)!);
          return (
            <circle key={t.frame} class="false-turn" cx={p.x} cy={p.y} r="6"
              onClick={() => choose(rowOf.get(t.frame)!)}>
              <title>camera-only turn at frame {frames.frame[rowOf.get(t.frame)!]}</title>
            </circle>
          );
        })}
        <circle class="chosen" cx={chosen.x} cy={chosen.y} r="11" />
      </svg>
      <figcaption>
        <Sign colour="var(--red)" shape="diamond">turn</Sign>
        <Sign colour="var(--green)" shape="circle">view break</Sign>
        <Sign colour="var(--blue)" shape="ring">camera-only turn</Sign>
        <Sign colour="var(--accent)" shape="dashed">loop closure</Sign>
        <Sign colour="var(--weak)">corridor.</Sign>
        Drawn from headings alone with one step per frame, so loops need not close. Strokes show the heading.
      </figcaption>
    </figure>
  );
}
