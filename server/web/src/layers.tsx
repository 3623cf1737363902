// SPDX-License-Identifier: Apache-2.0
// View: the trajectory, layer by layer: poses, revisits, and the poses of the appearance layer.
import type { ComponentChildren } from "preact";
import { type Appearance, type AppearanceNode, type FloorPlan, type FloorPlans, mapPath, type Overview } from "./api";
import { colourOf } from "./colours";
import type { ViewProps } from "./types";
import { Facts, Failure, GoTo, KeyframeLink, Panorama, PlaneLink, Sign, Waiting } from "./parts";
import { openOn, PlanChooser, PlanImage, PoseFigure, usePlan } from "./pose_map";
import { boxOf, planCorners, type Vec2 } from "./pose_view";
import { href } from "./route";
import { Sessions } from "./sessions";
import { useGet } from "./use";
import { counted, degrees } from "./words";

const kFewSteps = 10; // keyframes out of view, from which on a plane counts as revisited

interface Revisit {
  plane: number;
  from: number; // index of the keyframe
  to: number;
}

// Planes that left the view for a while and were seen again.
export function revisits(overview: Overview): Revisit[] {
  const at = new Map(overview.keyframes.id.map((id, i) => [id, i]));
  const found: Revisit[] = [];
  overview.planes.id.forEach((plane, i) => {
    const seen = overview.planes.keyframes[i].map((k) => at.get(k)!).sort((a, b) => a - b);
    for (let j = 1; j < seen.length; ++j) {
      if (seen[j] - seen[j - 1] >= kFewSteps) found.push({ plane, from: seen[j - 1], to: seen[j] });
    }
  });
  return found;
}

const kArcWidth = 960;
const kArcHeight = 220;
const kMargin = 16;

// The keyframes in a row, by stretches, and an arc for each plane that was seen again.
function Arcs({ overview, found }: { overview: Overview; found: Revisit[] }) {
  const { id, sequence, stretch } = overview.keyframes;
  const n = id.length;
  const begins = id.map((_, i) => i).filter((i) => i > 0 && (stretch[i] !== stretch[i - 1] || sequence[i] !== sequence[i - 1]));
  const x = (i: number) => kMargin + ((kArcWidth - 2 * kMargin) * i) / Math.max(1, n - 1);
  const base = kArcHeight - 28;
  const arc = ({ from, to }: Revisit) => {
    const radius = (x(to) - x(from)) / 2;
    const height = (Math.min(1, radius / (kArcWidth / 2)) * (base - 12)) / radius;
    return `M ${x(from)} ${base} A ${radius} ${radius * height} 0 0 1 ${x(to)} ${base}`;
  };
  return (
    <svg class="plot" viewBox={`0 0 ${kArcWidth} ${kArcHeight}`} role="img"
      aria-label={`${n} keyframes in order and ${found.length} arcs between observations of the same plane`}>
      {found.map((r, i) => <path key={i} class="arc" d={arc(r)} />)}
      {begins.map((i) => <path key={`b${i}`} class="break" d={`M ${(x(i - 1) + x(i)) / 2} ${base - 9} v 18`} />)}
      {stretch.map((s, i) => (
        <circle key={i} cx={x(i)} cy={base} r="3" fill={colourOf(s)} />
      ))}
      <text x={kMargin} y={kArcHeight - 6}>first keyframe</text>
      <text x={kArcWidth - kMargin} y={kArcHeight - 6} text-anchor="end">last</text>
    </svg>
  );
}

function SeenAgain({ map, overview }: { map: string; overview: Overview }) {
  const found = revisits(overview);
  const { id } = overview.keyframes;
  return (
    <section>
      <h2>Revisits (plane layer)</h2>
      <p class="quiet">
        A plane seen again after {kFewSteps} or more keyframes connects two passes through the same
        place. Keyframes are drawn in order, not at their positions; strokes between them separate stretches.
      </p>
      {found.length > 0 && <Arcs overview={overview} found={found} />}
      {found.length === 0
        ? <p>No revisits: the trajectory has no loop, or its loops were not detected.</p>
        : (
          <details>
            <summary>{counted(found.length, "revisit")}</summary>
            <ul class="columns">
              {found.map((r, i) => (
                <li key={i}>
                  plane <PlaneLink map={map} id={r.plane} />: keyframe{" "}
                  <KeyframeLink map={map} id={id[r.from]} />, then{" "}
                  <KeyframeLink map={map} id={id[r.to]} />
                </li>
              ))}
            </ul>
          </details>
        )}
    </section>
  );
}

interface Drawn {
  id: number;
  x: number;
  y: number;
}

// Nodes at their estimated positions, and the edges between them.
function Trajectory(props: {
  layer: Appearance;
  plan: FloorPlan | null;
  chosen: number;
  choose: (index: number) => void;
}) {
  const { layer, plan, chosen, choose } = props;
  const at = ([x, y]: Vec2): Vec2 => [x, -y]; // y up, as on a floor plan
  const corners = plan ? planCorners(plan) : [];
  const { low: [left, top], high: [right, bottom] } = boxOf([...layer.nodes.map((n): Vec2 => [n.x, n.y]), ...corners].map(at), []);
  const unit = Math.max(right - left, bottom - top, 1e-6) / 100;
  const byId = new Map<number, Drawn>(layer.nodes.map((n) => [n.id, { id: n.id, x: n.x, y: -n.y }]));
  const box = [left - 4 * unit, top - 4 * unit, right - left + 8 * unit, bottom - top + 8 * unit];
  return (
    <svg class="plot trajectory" viewBox={box.join(" ")} role="img"
      aria-label={`Trajectory of ${layer.nodes.length} nodes`}>
      {plan && <PlanImage plan={plan} at={at} />}
      {layer.edges.map((e, i) => {
        const [a, b] = [byId.get(e.a), byId.get(e.b)];
        return a && b && (
          <line key={i} class={e.kind} x1={a.x} y1={a.y} x2={b.x} y2={b.y} stroke-width={unit / 3}
            stroke-dasharray={e.kind === "loop" ? `${unit} ${unit / 2}` : undefined} />
        );
      })}
      {layer.nodes.map((n, i) => (
        <circle key={n.id} class={i === chosen ? "chosen" : ""} cx={n.x} cy={-n.y}
          r={unit * (i === chosen ? 1.6 : 0.8)} onClick={() => choose(i)} />
      ))}
    </svg>
  );
}

// One panorama of the layer.
function Node({ map, id }: { map: string; id: number }) {
  const node = useGet<AppearanceNode>(`${mapPath(map)}/appearance/nodes/${id}`);
  if (node.error) return <Failure error={node.error} />;
  if (!node.value) return <Waiting what={`node ${id}`} />;
  const { source, sequence, frame, time_s, x, y, heading_rad, keyframe, image } = node.value;
  return (
    <>
      <Facts
        rows={[
          ["Node", keyframe === null ? id : <>{id}, keyframe <KeyframeLink map={map} id={keyframe} /></>],
          ["Source", `${source} of sequence ${sequence}`],
          ["Frame", time_s === null ? frame : `${frame} at ${time_s.toFixed(2)} s`],
          ["Position", `${x.toFixed(2)}, ${y.toFixed(2)}; heading ${degrees(heading_rad)}`],
        ]}
      />
      {image ? <Panorama path={image} /> : <p class="quiet">The map was built without images.</p>}
    </>
  );
}

// `planned` if floor plans are in the frame of this layer.
function AppearanceLayer({ map, planned, id }: { map: string; planned: boolean; id: number | null }) {
  const plans = useGet<FloorPlans>(planned ? `${mapPath(map)}/plan` : null);
  const under = usePlan(plans.value?.plans ?? []);
  const layer = useGet<Appearance>(`${mapPath(map)}/appearance`);
  if (layer.error) return <Failure error={layer.error} />;
  if (!layer.value) return <Waiting what="the appearance layer" />;
  const { nodes } = layer.value;
  if (nodes.length === 0) return <p class="missing">The layer has no panoramas.</p>;
  const shown = id ?? nodes[0].id;
  const chosen = nodes.findIndex((n) => n.id === shown);
  const choose = (to: number) => {
    location.hash = href(map, "layers", nodes[to].id);
  };
  const loops = layer.value.edges.filter((e) => e.kind === "loop").length;
  return (
    <>
      <p class="legend">
        <Sign colour="var(--text)" shape="line">odometry</Sign>
        <Sign colour="var(--accent)" shape="dashed">{counted(loops, "loop closure")}.</Sign>
        {layer.value.scale === "metric" ? "Units: metres." : "The scale is arbitrary."}
      </p>
      <Trajectory layer={layer.value} plan={under.plan} chosen={chosen} choose={choose} />
      <PlanChooser plans={plans.value?.plans ?? []} plan={under.plan} choose={under.choose} />
      <p class="steps">
        <button disabled={chosen <= 0} onClick={() => choose(chosen - 1)}>← Previous</button>{" "}
        <button disabled={chosen + 1 >= nodes.length} onClick={() => choose(chosen + 1)}>Next →</button>
      </p>
      <GoTo what="Node" numbers={nodes.map((n) => n.id)} choose={choose} />
      <Node map={map} id={shown} />
    </>
  );
}

function Layer(props: { name: string; has: boolean; children: ComponentChildren; missing: string }) {
  return (
    <section>
      <h2>{props.name}</h2>
      {props.has ? props.children : <p class="missing">{props.missing}</p>}
    </section>
  );
}

function Poses({ map, overview, query }: { map: string; overview: Overview; query: ViewProps["query"] }) {
  const { keyframes, planes } = overview;
  return (
    <section>
      <h2>Poses</h2>
      <p class="quiet">Click on a keyframe or a plane to open it, or enter its number.</p>
      <PoseFigure map={map} answer={query?.answer ?? null} />
      <div class="steps">
        <GoTo what="Keyframe" numbers={keyframes.id} choose={(i) => openOn(map, "keyframes")(keyframes.id[i])} />
        <GoTo what="Plane" numbers={planes.id} choose={(i) => openOn(map, "planes")(planes.id[i])} />
      </div>
    </section>
  );
}

export function LayersView({ map, route, query }: ViewProps) {
  const overview = useGet<Overview>(`${mapPath(map.name)}/overview`);
  if (overview.error) return <Failure error={overview.error} />;
  if (!overview.value) return <Waiting what="the layers" />;
  const { layers } = overview.value;
  return (
    <>
      <h1>Trajectory</h1>
      {layers.includes("poses") && <Poses map={map.name} overview={overview.value} query={query} />}
      <Sessions map={map} />
      {map.planes > 0 && <SeenAgain map={map.name} overview={overview.value} />}
      <Layer
        name="Panoramas (appearance layer)"
        has={layers.includes("appearance")}
        missing="This map has no appearance layer. Build a map from panoramas or from a rig that covers the full circle to get one."
      >
        <AppearanceLayer map={map.name} planned={!layers.includes("poses")} id={route.id} />
      </Layer>
      <Layer
        name="Turns and corridors (orientation layer)"
        has={layers.includes("orientation")}
        missing="This map has no orientation layer. Build a map with a calibrated camera in a building with walls at right angles to get one."
      >
        <p>See the <a href={href(map.name, "orientation")}>orientation view</a>.</p>
      </Layer>
    </>
  );
}
