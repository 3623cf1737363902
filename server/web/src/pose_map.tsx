// SPDX-License-Identifier: Apache-2.0
// A map with poses, seen from above: keyframes, panoramas, planes, and a query where its pose is known, on a
// floor plan where the map has one.
import { useState } from "preact/hooks";
import {
  type Answer, type FloorPlan, type FloorPlans, mapPath, type NamesFile, type NamesFilePlace, type Overview, type Pose,
  type PoseLayer,
} from "./api";
import { colourOf } from "./colours";
import { Failure, Swatch, Waiting } from "./parts";
import {
  type Above, axesSeen, barLength, boxOf, ellipseSeen, headingSeen, layOut, planCorners, planeSeen, planTransform, seen,
  type Vec2, viewFromAbove,
} from "./pose_view";
import { href } from "./route";
import { useGet, useMedia, usePicture } from "./use";
import { counted, degrees, unitOf } from "./words";

const kWidth = 900; // px
const kNarrowWidth = 340; // of a phone
const kHeight = 416; // px, at most
const kMargin = 20;
const kStrip = 44; // at the bottom, for the scale and the axes
const kMany = 400; // keyframes or panoramas, from which on they are drawn smaller
const kDot = 3; // of a keyframe; half the side of a panorama
const kTick = 11; // of its heading
const kArrow = 30; // of the heading of the query

type Place = (p: Vec2) => Vec2;

const pointList = (points: Vec2[]) => points.map((p) => p.map((v) => v.toFixed(1)).join(",")).join(" ");

export function openOn(map: string, view: "keyframes" | "planes") {
  return (id: number) => {
    location.hash = href(map, view, id);
  };
}

// The image of a floor plan, where the drawing has what it shows.
export function PlanImage({ plan, at }: { plan: FloorPlan; at: Place }) {
  const src = usePicture(plan.image);
  return src && (
    <image class="plan" href={src} width={plan.width} height={plan.height} transform={planTransform(plan, at)}
      preserveAspectRatio="none" />
  );
}

export interface Area {
  name: string;
  corners: Vec2[];
}

export const areasOf = (places: NamesFilePlace[]): Area[] =>
  places.flatMap(({ name, polygons }) => polygons.map(({ corners }) => ({ name, corners })));

// The areas of named places.
function Areas({ areas, at }: { areas: Area[]; at: Place }) {
  return (
    <>
      {areas.map(({ name, corners }, i) => {
        const points = corners.map(at);
        const [x, y] = [0, 1].map((axis) => points.reduce((sum, p) => sum + p[axis], 0) / points.length);
        return (
          <g key={i} class="area">
            <polygon points={pointList(points)} />
            <text x={x} y={y}>{name}</text>
          </g>
        );
      })}
    </>
  );
}

// An area that is being drawn.
function Corners({ corners, at }: { corners: Vec2[]; at: Place }) {
  const points = corners.map(at);
  return (
    <g class="corners">
      <polygon points={pointList(points)} />
      {points.map(([x, y], i) => <circle key={i} cx={x} cy={y} r="4" />)}
    </g>
  );
}

interface SeenPlane {
  id: number;
  points: Vec2[]; // two are a line
}

function Planes(props: {
  planes: SeenPlane[];
  colours: Map<number, string>;
  at: Place;
  choose: (id: number) => void;
}) {
  const { planes, colours, at, choose } = props;
  const drawn = [...planes.filter((p) => !colours.has(p.id)), ...planes.filter((p) => colours.has(p.id))];
  return (
    <>
      {drawn.map(({ id, points }) => {
        const colour = colours.get(id);
        const style = colour && { stroke: colour, fill: colour };
        const shape = points.length > 2 ? "surface" : "wall";
        return (
          <polygon key={id} class={colour ? `${shape} recognized` : shape} style={style}
            points={pointList(points.map(at))} onClick={() => choose(id)}>
            <title>plane {id}</title>
          </polygon>
        );
      })}
    </>
  );
}

// The lines that join the keyframes of each stretch in their order.
function Paths({ layer, overview, places }: { layer: PoseLayer; overview: Overview; places: Vec2[] }) {
  const { id, sequence, stretch } = overview.keyframes;
  const stretchOf = new Map(id.map((k, i) => [k, `${sequence[i]} ${stretch[i]}`]));
  const paths = new Map<string, Vec2[]>();
  layer.keyframes.id.forEach((k, i) => {
    const name = stretchOf.get(k) ?? "";
    if (!paths.has(name)) paths.set(name, []);
    paths.get(name)!.push(places[i]);
  });
  return <>{[...paths].map(([name, path]) => <polyline key={name} class="path" points={pointList(path)} />)}</>;
}

function Keyframes(props: {
  layer: PoseLayer;
  view: Above;
  places: Vec2[];
  narrow: boolean;
  noun: string;
  choose: (id: number) => void;
}) {
  const { id, orientation } = props.layer.keyframes;
  const size = props.narrow || id.length > kMany ? 0.6 : 1;
  return (
    <>
      {id.map((keyframe, i) => {
        const [x, y] = props.places[i];
        const heading = headingSeen(props.view, orientation[i]);
        const tick = kTick * size;
        return (
          <g key={keyframe} class="keyframe" onClick={() => props.choose(keyframe)}>
            <title>{props.noun} {keyframe}</title>
            {heading && <line x1={x} y1={y} x2={x + tick * heading[0]} y2={y - tick * heading[1]} />}
            <circle cx={x} cy={y} r={kDot * size} />
          </g>
        );
      })}
    </>
  );
}

function Panoramas(props: { layer: PoseLayer; view: Above; places: Vec2[]; narrow: boolean }) {
  const { id, orientation } = props.layer.nodes;
  const size = props.narrow || id.length > kMany ? 0.6 : 1;
  const [half, tick] = [kDot * size, kTick * size];
  return (
    <>
      {id.map((node, i) => {
        const [x, y] = props.places[i];
        const heading = headingSeen(props.view, orientation[i]);
        return (
          <g key={node} class="panorama">
            <title>panorama {node}</title>
            {heading && <line x1={x} y1={y} x2={x + tick * heading[0]} y2={y - tick * heading[1]} />}
            <rect x={x - half} y={y - half} width={2 * half} height={2 * half} />
          </g>
        );
      })}
    </>
  );
}

function QueryMark(props: { pose: Pose; view: Above; scale: number; at: Place }) {
  const { pose, view, scale, at } = props;
  const [x, y] = at(seen(view, pose.position));
  const heading = headingSeen(view, pose.orientation);
  const { long, short, angle_rad } = ellipseSeen(view, pose.covariance);
  const angle = heading && Math.atan2(-heading[1], heading[0]);
  return (
    <g class="query">
      <title>query</title>
      <ellipse rx={(scale * long).toFixed(2)} ry={(scale * short).toFixed(2)}
        transform={`translate(${x} ${y}) rotate(${(-angle_rad * 180) / Math.PI})`} />
      {angle !== null && (
        <path transform={`translate(${x} ${y}) rotate(${(angle * 180) / Math.PI})`}
          d={`M 0 0 H ${kArrow} m -9 -5 l 9 5 l -9 5`} />
      )}
      <circle cx={x} cy={y} r="5" />
    </g>
  );
}

function ScaleBar({ scale, y, unit }: { scale: number; y: number; unit: string }) {
  const length = barLength(scale, 120);
  const end = kMargin + scale * length;
  return (
    <g class="scale">
      <path d={`M ${kMargin} ${y - 5} V ${y} H ${end} V ${y - 5}`} />
      <text x={end + 8} y={y}>{Number(length.toPrecision(1))} {unit}</text>
    </g>
  );
}

// The axes of the frame, in the lower right corner.
function Axes({ view, x, y }: { view: Above; x: number; y: number }) {
  const kArm = 18;
  return (
    <g class="scale">
      {axesSeen(view).map(({ name, direction: [dx, dy] }) => (
        <g key={name}>
          <line x1={x} y1={y} x2={x + kArm * dx} y2={y - kArm * dy} />
          <text class="axis" x={x + (kArm + 8) * dx} y={y - (kArm + 8) * dy}>{name}</text>
        </g>
      ))}
    </g>
  );
}

// "12 keyframes", "31 panoramas": what there is of them. `noun` is what the layer's keyframes are called.
function imagesOf({ keyframes, nodes }: PoseLayer, noun: string): string[] {
  const [photos, panoramas] = [keyframes.id.length, nodes.id.length];
  return [
    photos > 0 || panoramas === 0 ? [counted(photos, noun)] : [],
    panoramas > 0 ? [counted(panoramas, "panorama")] : [],
  ].flat();
}

function labelOf(layer: PoseLayer, planes: SeenPlane[], pose: Pose | null, noun: string): string {
  const what = `${imagesOf(layer, noun).join(", ")} and ${counted(planes.length, "plane")} seen from above`;
  return pose ? `${what}, with the query` : what;
}

// What clicks on the map choose for a new name, instead of opening what is there.
export interface Compose {
  corners: Vec2[]; // so far
  addCorner?: (corner: Vec2, px_per_unit: number) => void;
  choosePlane?: (id: number) => void;
  noun: string; // of what is drawn as keyframes
}

export function PoseMap(props: {
  map: string;
  layer: PoseLayer;
  overview: Overview | null; // null: without the paths from keyframe to keyframe
  pose: Pose | null; // of the query
  colours: Map<number, string>; // of recognised planes
  plan: FloorPlan | null;
  areas: Area[];
  compose?: Compose;
}) {
  const { map, layer, pose, plan, compose } = props;
  const narrow = useMedia("(max-width: 700px)");
  const width = narrow ? kNarrowWidth : kWidth;
  const view = viewFromAbove(layer.up);
  const positions = layer.keyframes.position.map((p) => seen(view, p));
  const ofNodes = layer.nodes.position.map((p) => seen(view, p));
  const images = [...positions, ...ofNodes];
  const planes = layer.planes.map((p) => ({ id: p.id, points: planeSeen(view, p) })).filter((p) => p.points.length > 0);
  const must = [...images, ...(pose ? [seen(view, pose.position)] : []), ...(plan ? planCorners(plan) : []),
    ...props.areas.flatMap((a) => a.corners), ...(compose?.corners ?? [])];
  const room = { width, height: kHeight, margin: kMargin, strip: kStrip };
  const { scale, height, at, from } = layOut(boxOf(must, planes.flatMap((p) => p.points)), room);
  const places = positions.map(at);
  const clicked = (event: MouseEvent) => {
    const svg = event.currentTarget as SVGSVGElement;
    const { x, y } = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM()!.inverse());
    compose?.addCorner?.(from([x, y]), scale);
  };
  const nothing = () => {};
  return (
    <svg class={`plot pose-map${compose?.addCorner ? " drawing" : ""}`} viewBox={`0 0 ${width} ${height.toFixed(0)}`}
      role="img" aria-label={labelOf(layer, planes, pose, compose?.noun ?? "keyframe")} onClick={clicked}>
      {plan && <PlanImage plan={plan} at={at} />}
      <Areas areas={props.areas} at={at} />
      <Planes planes={planes} colours={props.colours} at={at}
        choose={compose ? compose.choosePlane ?? nothing : openOn(map, "planes")} />
      {props.overview && <Paths layer={layer} overview={props.overview} places={places} />}
      <Keyframes layer={layer} view={view} places={places} narrow={narrow} noun={compose?.noun ?? "keyframe"}
        choose={compose ? nothing : openOn(map, "keyframes")} />
      <Panoramas layer={layer} view={view} places={ofNodes.map(at)} narrow={narrow} />
      {compose && <Corners corners={compose.corners} at={at} />}
      {pose && <QueryMark pose={pose} view={view} scale={scale} at={at} />}
      <ScaleBar scale={scale} y={height - 12} unit={unitOf(layer.unit)} />
      <Axes view={view} x={width - 40} y={height - 14} />
    </svg>
  );
}

function noiseInWords({ noise, unit }: PoseLayer): string {
  const { position_deviation: position, rotation_deviation_rad: rotation } = noise;
  if (position === null && rotation === null) return "The noise of the given poses was not measured.";
  const parts = [
    position === null ? [] : [`${Number(position.toPrecision(2))} ${unitOf(unit)}`],
    rotation === null ? [] : [degrees(rotation, 2)],
  ].flat();
  return `Noise of the given poses: ${parts.join(" and ")} (1σ).`;
}

function Legend({ layer, pose }: { layer: PoseLayer; pose: Pose | null }) {
  const placed = layer.planes.filter((p) => p.outline.length > 0).length;
  return (
    <figcaption>
      <Swatch colour="var(--text)" shape="circle" />{imagesOf(layer, "keyframe").join(" (dots) and ")}{" "}
      <Swatch colour="var(--accent)" shape="line" />{counted(placed, "plane")}{pose && ", recognised ones in bold"}
      {pose && <>{" "}<Swatch colour="var(--red)" shape="circle" />query, with an arrow and a 2σ ellipse</>}. Seen from above in the frame
      “{layer.frame}”{layer.up === null && ", along its z axis, since the images don’t show which way is up"}.{" "}
      {noiseInWords(layer)}
    </figcaption>
  );
}

// The plan under a map: that of the answer or the first one, until another is chosen.
export function usePlan(plans: FloorPlan[], preferred: string | null = null) {
  const [chosen, choose] = useState<string | null>(null);
  const name = chosen ?? preferred ?? plans[0]?.name;
  return { plan: plans.find((p) => p.name === name) ?? null, choose };
}

export function PlanChooser(props: { plans: FloorPlan[]; plan: FloorPlan | null; choose: (name: string) => void }) {
  if (props.plans.length === 0) return null;
  return (
    <label class="toggle">
      Floor plan <select value={props.plan?.name ?? ""}
        onChange={(e) => props.choose((e.target as HTMLSelectElement).value)}>
        {props.plans.map((p) => <option key={p.name} value={p.name}>{p.name}</option>)}
        <option value="">none</option>
      </select>
    </label>
  );
}

// The map from above with its legend, and with the query of `answer` if that has a pose.
export function PoseFigure({ map, answer }: { map: string; answer: Answer | null }) {
  const overview = useGet<Overview>(`${mapPath(map)}/overview`);
  const layer = useGet<PoseLayer>(`${mapPath(map)}/poses`);
  const plans = useGet<FloorPlans>(`${mapPath(map)}/plan`);
  const names = useGet<NamesFile>(`${mapPath(map)}/names`);
  const { plan, choose } = usePlan(plans.value?.plans ?? [], answer?.place?.plan?.name);
  const error = overview.error ?? layer.error ?? plans.error ?? names.error;
  if (error) return <Failure error={error} />;
  if (!overview.value || !layer.value || !plans.value || !names.value) return <Waiting what="the poses" />;
  if (layer.value.keyframes.id.length + layer.value.nodes.id.length === 0) return null;
  const pose = answer?.pose ?? null;
  const colours = new Map(pose ? answer!.planes.map((p, i) => [p.id, colourOf(i)]) : []);
  return (
    <figure>
      <PoseMap map={map} layer={layer.value} overview={overview.value} pose={pose} colours={colours} plan={plan}
        areas={areasOf(names.value.places)} />
      <PlanChooser plans={plans.value.plans} plan={plan} choose={choose} />
      <Legend layer={layer.value} pose={pose} />
    </figure>
  );
}
