// SPDX-License-Identifier: Apache-2.0
// A map with poses, seen from above: keyframes, panoramas, planes, and a query where its pose is known.
import { type Answer, mapPath, type Overview, type Pose, type PoseLayer } from "./api";
import { colourOf } from "./colours";
import { Failure, Swatch, Waiting } from "./parts";
import {
  type Above, axesSeen, barLength, boxOf, ellipseSeen, headingSeen, layOut, planeSeen, seen, type Vec2, viewFromAbove,
} from "./pose_view";
import { href } from "./route";
import { useGet, useMedia } from "./use";
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

function openOn(map: string, view: "keyframes" | "planes", id: number) {
  return () => {
    location.hash = href(map, view, id);
  };
}

interface SeenPlane {
  id: number;
  points: Vec2[]; // two are a line
}

function Planes(props: { map: string; planes: SeenPlane[]; colours: Map<number, string>; at: Place }) {
  const { map, planes, colours, at } = props;
  const drawn = [...planes.filter((p) => !colours.has(p.id)), ...planes.filter((p) => colours.has(p.id))];
  return (
    <>
      {drawn.map(({ id, points }) => {
        const colour = colours.get(id);
        const style = colour && { stroke: colour, fill: colour };
        const shape = points.length > 2 ? "surface" : "wall";
        return (
          <polygon key={id} class={colour ? `${shape} recognized` : shape} style={style}
            points={pointList(points.map(at))} onClick={openOn(map, "planes", id)}>
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

function Keyframes(props: { map: string; layer: PoseLayer; view: Above; places: Vec2[]; narrow: boolean }) {
  const { id, orientation } = props.layer.keyframes;
  const size = props.narrow || id.length > kMany ? 0.6 : 1;
  return (
    <>
      {id.map((keyframe, i) => {
        const [x, y] = props.places[i];
        const heading = headingSeen(props.view, orientation[i]);
        const tick = kTick * size;
        return (
          <g key={keyframe} class="keyframe" onClick={openOn(props.map, "keyframes", keyframe)}>
            <title>keyframe {keyframe}</title>
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

// "12 keyframes", "31 panoramas": what there is of them.
function imagesOf({ keyframes, nodes }: PoseLayer): string[] {
  const [photos, panoramas] = [keyframes.id.length, nodes.id.length];
  return [
    photos > 0 || panoramas === 0 ? [counted(photos, "keyframe")] : [],
    panoramas > 0 ? [counted(panoramas, "panorama")] : [],
  ].flat();
}

function labelOf(layer: PoseLayer, planes: SeenPlane[], pose: Pose | null): string {
  const what = `${imagesOf(layer).join(", ")} and ${counted(planes.length, "plane")} seen from above`;
  return pose ? `${what}, with the query` : what;
}

export function PoseMap(props: {
  map: string;
  layer: PoseLayer;
  overview: Overview;
  pose: Pose | null; // of the query
  colours: Map<number, string>; // of recognized planes
}) {
  const { map, layer, pose } = props;
  const narrow = useMedia("(max-width: 700px)");
  const width = narrow ? kNarrowWidth : kWidth;
  const view = viewFromAbove(layer.up);
  const positions = layer.keyframes.position.map((p) => seen(view, p));
  const ofNodes = layer.nodes.position.map((p) => seen(view, p));
  const images = [...positions, ...ofNodes];
  const planes = layer.planes.map((p) => ({ id: p.id, points: planeSeen(view, p) })).filter((p) => p.points.length > 0);
  const must = pose ? [...images, seen(view, pose.position)] : images;
  const room = { width, height: kHeight, margin: kMargin, strip: kStrip };
  const { scale, height, at } = layOut(boxOf(must, planes.flatMap((p) => p.points)), room);
  const places = positions.map(at);
  return (
    <svg class="plot pose-map" viewBox={`0 0 ${width} ${height.toFixed(0)}`} role="img"
      aria-label={labelOf(layer, planes, pose)}>
      <Planes map={map} planes={planes} colours={props.colours} at={at} />
      <Paths layer={layer} overview={props.overview} places={places} />
      <Keyframes map={map} layer={layer} view={view} places={places} narrow={narrow} />
      <Panoramas layer={layer} view={view} places={ofNodes.map(at)} narrow={narrow} />
      {pose && <QueryMark pose={pose} view={view} scale={scale} at={at} />}
      <ScaleBar scale={scale} y={height - 12} unit={unitOf(layer.unit)} />
      <Axes view={view} x={width - 40} y={height - 14} />
    </svg>
  );
}

function noiseInWords({ noise, unit }: PoseLayer): string {
  const { position_deviation: position, rotation_deviation_rad: rotation } = noise;
  if (position === null && rotation === null) return "No noise of the given poses was measured.";
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
      <Swatch colour="var(--text)" />{imagesOf(layer).join(" (dots) and ")}{" "}
      <Swatch colour="var(--accent)" />{counted(placed, "plane")}{pose && ", the recognized ones bold"}
      {pose && <>{" "}<Swatch colour="var(--red)" />query with its 2σ ellipse</>}. Seen from above in the frame
      “{layer.frame}”{layer.up === null && ", along its z axis since the images don’t tell what is up"}.{" "}
      {noiseInWords(layer)}
    </figcaption>
  );
}

// The map from above with its legend, and with the query of `answer` if that has a pose.
export function PoseFigure({ map, answer }: { map: string; answer: Answer | null }) {
  const overview = useGet<Overview>(`${mapPath(map)}/overview`);
  const layer = useGet<PoseLayer>(`${mapPath(map)}/poses`);
  const error = overview.error ?? layer.error;
  if (error) return <Failure error={error} />;
  if (!overview.value || !layer.value) return <Waiting what="the poses" />;
  if (layer.value.keyframes.id.length + layer.value.nodes.id.length === 0) return null;
  const pose = answer?.pose ?? null;
  const colours = new Map(pose ? answer!.planes.map((p, i) => [p.id, colourOf(i)]) : []);
  return (
    <figure>
      <PoseMap map={map} layer={layer.value} overview={overview.value} pose={pose} colours={colours} />
      <Legend layer={layer.value} pose={pose} />
    </figure>
  );
}
