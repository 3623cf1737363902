// SPDX-License-Identifier: Apache-2.0
// View: the orientation layer. The trajectory by its turns (the paper's fig. 10), heading and lines
// by frame (figs. 3, 4 and 11), and one frame with its free directions (fig. 13).
import { useMemo } from "preact/hooks";
import { mapPath, type Orientation, type OrientationFrame, type Overview } from "./api";
import { LinedPicture } from "./lines";
import type { Stretch, ViewProps } from "./types";
import { Facts, Failure, GoTo, KeyframeLink, Sign, Waiting } from "./parts";
import { href } from "./route";
import { type Mark, Series } from "./series";
import { useGet } from "./use";
import { TrajectoryMap } from "./trajectory_map";
import { counted, degrees } from "./words";

const kDegrees = 180 / Math.PI;
const kDashed = [6, 4]; // px
const kDotted = [2, 3];
const kQuarters = [-180, -90, 0, 90, 180];

type Node = Orientation["nodes"][number];

function stretches({ frames }: Orientation): Stretch[] {
  const found: Stretch[] = [];
  frames.sequence.forEach((sequence, i) => {
    const current = found[found.length - 1];
    if (current?.sequence === sequence) current.last = i;
    else found.push({ sequence, first: i, last: i });
  });
  return found;
}

// The values of both plots for the frames of a stretch.
function plotted(layer: Orientation, { first, last }: Stretch) {
  const { frames } = layer;
  const rows = Array.from({ length: last - first + 1 }, (_, i) => first + i);
  const row = new Map(rows.map((i) => [frames.id[i], i]));
  const heading = (reliable: boolean) =>
    rows.map((i) => {
      const rad = frames.heading_rad[i];
      return rad === null || frames.reliable[i] !== reliable ? null : rad * kDegrees;
    });
  const marks: Mark[] = layer.turns.filter((t) => row.has(t.frame)).map((t) => ({
    at: frames.frame[row.get(t.frame)!],
    ...(t.confirmed ? { colour: "--red" } : { colour: "--blue", dash: kDashed }),
  }));
  const marked = layer.corridors.filter((c) => row.has(c.first)).map((c): [number, number] =>
    [frames.frame[row.get(c.first)!], frames.frame[row.get(c.last)!]]);
  return {
    at: rows.map((i) => frames.frame[i]),
    headings: [
      { values: heading(false), colour: "--quiet", dots: "hollow" as const },
      { values: heading(true), colour: "--accent", dots: "full" as const },
    ],
    lines: [
      { values: rows.map((i) => frames.lines_x[i]), colour: "--red" },
      { values: rows.map((i) => frames.lines_y[i]), colour: "--green", dash: kDashed },
      { values: rows.map((i) => frames.lines_z[i]), colour: "--blue", dash: kDotted },
    ],
    marks,
    marked,
  };
}

function Plots(props: { layer: Orientation; stretch: Stretch; row: number; choose: (row: number) => void }) {
  const { layer, stretch, row } = props;
  const plot = useMemo(() => plotted(layer, stretch), [layer, stretch]);
  const chosen = layer.frames.frame[row];
  const choose = (i: number) => props.choose(stretch.first + i);
  const { at, marks, marked } = plot;
  const turns = counted(marks.length, "marked turn");
  return (
    <section>
      <h2>Heading and lines</h2>
      <p class="legend">
        <Sign colour="var(--accent)" shape="circle">heading: 0° along the map’s x axis, 90° along its y axis</Sign>
        <Sign colour="var(--quiet)" shape="ring">not reliable</Sign>
        <Sign colour="var(--weak)">corridor</Sign>
        <Sign colour="var(--red)" shape="line">turn</Sign>
        <Sign colour="var(--blue)" shape="dashed">camera-only turn</Sign>
      </p>
      <Series at={at} along="frame" curves={plot.headings} unit="heading (degrees)"
        range={[-185, 185]} ticks={kQuarters} marked={marked} marks={marks} chosen={chosen}
        what={`Heading of ${at.length} frames; ${turns}`} choose={choose} />
      <p class="legend">
        Lines along the axes of the map: <Sign colour="var(--red)" shape="line">x</Sign>
        <Sign colour="var(--green)" shape="dashed">y</Sign>
        <Sign colour="var(--blue)" shape="dotted">z (vertical)</Sign>
      </p>
      <Series at={at} along="frame" curves={plot.lines} unit="lines" marked={marked} marks={marks}
        chosen={chosen} what={`Lines along each axis in ${at.length} frames; ${turns}`} choose={choose} />
    </section>
  );
}

const kCells = [
  { name: "up", points: "0,0 100,0 50,50", x: 50, y: 20 },
  { name: "right", points: "100,0 100,100 50,50", x: 81, y: 52 },
  { name: "down", points: "0,100 100,100 50,50", x: 50, y: 85 },
  { name: "left", points: "0,0 0,100 50,50", x: 19, y: 52 },
];

// Lines across the direction of travel in the four cells around it (fig. 13).
function Cells({ node }: { node: Node }) {
  const most = Math.max(1, ...node.directions);
  const said = kCells.map((c, i) => `${node.directions[i]} ${c.name}`).join(", ");
  return (
    <figure class="cells">
      <svg viewBox="-1 -1 102 102" role="img" aria-label={`Lines across the direction of travel: ${said}`}>
        {kCells.map((cell, i) => (
          <g key={cell.name}>
            <polygon points={cell.points} fill-opacity={(0.75 * node.directions[i]) / most} />
            <text x={cell.x} y={cell.y}>{node.directions[i]}</text>
            <text class="name" x={cell.x} y={cell.y + 8}>{cell.name}</text>
          </g>
        ))}
      </svg>
      <figcaption>Lines perpendicular to the direction of travel in each cell of the image. Many lines mean that the direction is open.</figcaption>
    </figure>
  );
}

function headingInWords(frame: OrientationFrame): string {
  if (frame.heading_rad === null) return "axes not found";
  const heading = degrees(frame.heading_rad, 1);
  const sure = frame.deviation_rad === null ? "" : ` ± ${degrees(frame.deviation_rad, 2)}`;
  return `${heading}${sure}${frame.reliable ? "" : ", not reliable"}`;
}

// The nodes of a stretch, by their frames.
function nodesOf({ frames, nodes }: Orientation, { first, last }: Stretch): Node[] {
  return nodes.filter((n) => frames.id[first] <= n.id && n.id <= frames.id[last]);
}

function Frame({ map, layer, stretch, id }: { map: string; layer: Orientation; stretch: Stretch; id: number }) {
  const frame = useGet<OrientationFrame>(`${mapPath(map)}/orientation/frames/${id}`);
  if (frame.error) return <Failure error={frame.error} />;
  if (!frame.value) return <Waiting what={`frame ${id}`} />;
  const { source, sequence, time_s, keyframe, lines } = frame.value;
  const node = nodesOf(layer, stretch).findLast((n) => n.id <= id);
  const there = node?.id === id;
  const corridor = layer.corridors.find((c) => c.first <= id && id <= c.last);
  const turn = layer.turns.find((t) => t.frame === id);
  return (
    <>
      <Facts
        rows={[
          ["Frame", <>{frame.value.frame}{time_s !== null && ` at ${time_s.toFixed(2)} s`}
            {keyframe !== null && <>, keyframe <KeyframeLink map={map} id={keyframe} /></>}</>],
          ["Source", `${source} of sequence ${sequence}`],
          ["Heading", headingInWords(frame.value)],
          ["Lines", `${lines[0]} along x, ${lines[1]} along y, ${lines[2]} vertical`],
          ["Corridor", corridor ? `${corridor.id}, along ${corridor.axis}` : "–"],
          ["Turn", turn ? `${turn.direction}${turn.confirmed ? "" : " (camera only)"}` : "–"],
        ]}
      />
      {node && (
        <>
          <h2>
            {there ? "Node" : <>Previous node, frame <FrameLink map={map} id={node.id} layer={layer} /></>}
            {node.kind === "turn" ? ": turn" : ": view break"}
          </h2>
          <div class="node">
            {layer.frames.reliable[layer.frames.id.indexOf(node.id)]
              ? <Cells node={node} />
              : <p class="quiet">Free directions are unknown: the rotation is not reliable.</p>}
            {node.image && (
              <LinedPicture image={node.image} alt={`forward view at node ${node.id}`}
                path={`${mapPath(map)}/orientation/nodes/${node.id}/lines`} />
            )}
          </div>
        </>
      )}
    </>
  );
}

function FrameLink({ map, layer, id }: { map: string; layer: Orientation; id: number }) {
  const frame = layer.frames.frame[layer.frames.id.indexOf(id)];
  return <a href={href(map, "orientation", id)}>{frame}</a>;
}

function Table(props: { name: string; heads: string[]; rows: preact.ComponentChildren[][]; none: string }) {
  const { name, heads, rows, none } = props;
  if (rows.length === 0) return <p class="quiet">{none}</p>;
  return (
    <div class="scroll" tabIndex={0} role="region" aria-label={name}>
      <table>
        <caption>{name}</caption>
        <thead><tr>{heads.map((head) => <th key={head}>{head}</th>)}</tr></thead>
        <tbody>
          {rows.map((row, i) => <tr key={i}>{row.map((cell, j) => <td key={j}>{cell}</td>)}</tr>)}
        </tbody>
      </table>
    </div>
  );
}

function Lists({ map, layer }: { map: string; layer: Orientation }) {
  const link = (id: number) => <FrameLink map={map} layer={layer} id={id} />;
  const loops = layer.edges.filter((e) => e.kind === "loop");
  return (
    <div class="lists">
      <Table
        name="Turns"
        heads={["Frame", "Direction", "Angle", "New axis"]}
        rows={layer.turns.map((t) => [
          link(t.frame), t.confirmed ? t.direction : `${t.direction} (camera only)`,
          degrees(t.angle_rad), t.axis_after,
        ])}
        none="No turns."
      />
      <Table
        name="Corridors"
        heads={["Corridor", "Axis", "Frames"]}
        rows={layer.corridors.map((c) => [c.id, c.axis, <>{link(c.first)} to {link(c.last)}</>])}
        none={layer.corridors_unknown.length > 0
          ? "Unknown: corridors can be distinguished from rooms only with rigs and panoramas, which cover the full circle."
          : "No corridors."}
      />
      <Table
        name="Loop closures"
        heads={["Frames", "Verified matches"]}
        rows={loops.map((e) => [<>{link(e.a)} and {link(e.b)}</>, e.matches])}
        none="No loop closures: the trajectory has no loop, or its loops were not detected."
      />
    </div>
  );
}

function Steps({ map, nodes, id }: { map: string; nodes: Node[]; id: number }) {
  const before = nodes.findLast((n) => n.id < id);
  const after = nodes.find((n) => n.id > id);
  const link = (node: Node | undefined, text: string) =>
    node ? <a href={href(map, "orientation", node.id)}>{text}</a> : <span class="quiet">{text}</span>;
  return <p class="steps">{link(before, "← Previous node")} {link(after, "Next node →")}</p>;
}

function Layer({ map, id }: { map: string; id: number | null }) {
  const layer = useGet<Orientation>(`${mapPath(map)}/orientation`);
  const sequences = useMemo(() => (layer.value ? stretches(layer.value) : []), [layer.value]);
  if (layer.error) return <Failure error={layer.error} />;
  if (!layer.value) return <Waiting what="the orientation layer" />;
  const { frames, nodes } = layer.value;
  if (frames.id.length === 0) return <p>The layer has no frames.</p>;
  const first = nodes[0]?.id ?? frames.id[0];
  const row = frames.id.indexOf(id ?? first);
  if (row < 0) {
    return (
      <>
        <Failure error={`no frame ${id ?? first} in this map`} />
        <p><a href={href(map, "orientation", frames.id[0])}>First frame</a></p>
      </>
    );
  }
  const stretch = sequences.find((s) => s.first <= row && row <= s.last)!;
  const choose = (to: number) => {
    location.hash = href(map, "orientation", frames.id[to]);
  };
  return (
    <>
      {sequences.length > 1 && (
        <p>
          Sequence{" "}
          {sequences.map((s, i) => (
            <a key={s.sequence} class="other-sequence" href={href(map, "orientation", frames.id[s.first])}
              aria-current={s === stretch ? "true" : undefined}>{i + 1}</a>
          ))}
        </p>
      )}
      <div class="split">
        <TrajectoryMap layer={layer.value} stretch={stretch} row={row} choose={choose} />
        <section aria-label="Selected frame">
          <Steps map={map} nodes={nodesOf(layer.value, stretch)} id={frames.id[row]} />
          <GoTo what="Frame" numbers={frames.frame.slice(stretch.first, stretch.last + 1)}
            choose={(i) => choose(stretch.first + i)} />
          <Frame map={map} layer={layer.value} stretch={stretch} id={frames.id[row]} />
        </section>
      </div>
      <Plots layer={layer.value} stretch={stretch} row={row} choose={choose} />
      <Lists map={map} layer={layer.value} />
    </>
  );
}

export function OrientationView({ map, route }: ViewProps) {
  const overview = useGet<Overview>(`${mapPath(map.name)}/overview`);
  if (overview.error) return <Failure error={overview.error} />;
  if (!overview.value) return <Waiting what="the layers" />;
  return (
    <>
      <h1>Turns and corridors</h1>
      {overview.value.layers.includes("orientation") ? <Layer map={map.name} id={route.id} /> : (
        <p class="missing">
          This map has no orientation layer. Build a map with a calibrated camera in a building with
          walls at right angles to get one.
        </p>
      )}
    </>
  );
}
