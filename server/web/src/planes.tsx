// SPDX-License-Identifier: Apache-2.0
// View: the graph of surfaces, and one plane with its views, features and neighbours.
import { useEffect, useMemo, useState } from "preact/hooks";
import { type Keyframe, mapPath, type Overview, type Plane } from "./api";
import { colourOf } from "./colours";
import { Overlay } from "./figure";
import type { GraphProps } from "./graph";
import type { ViewProps } from "./types";
import { Facts, Failure, hasWebGl, KeyframeLink, NotLoaded, PlaneLink, PlaneLinks, Swatch, Waiting } from "./parts";
import { href } from "./route";
import { surfaceGraph } from "./surfaces";
import { useGet } from "./use";
import { counted } from "./words";

const kRows = 50; // of the table, at first

function Legend({ planes, surfaces }: { planes: number; surfaces: number }) {
  return (
    <p class="legend">
      {counted(planes, "plane")} on {counted(surfaces, "surface")}. Each node is a surface, such as a wall, named after
      the first of its planes. Size: number of features. Edges: surfaces seen together. A surface has the same colour in
      all keyframes.
    </p>
  );
}

function Table({ map, overview, selected }: { map: string; overview: Overview; selected: number | null }) {
  const [rows, setRows] = useState(kRows);
  const { planes, edges } = overview;
  const degree = new Map<number, number>();
  for (const end of [...edges.a, ...edges.b]) degree.set(end, (degree.get(end) ?? 0) + 1);
  const order = planes.id.map((_, i) => i).sort((a, b) => planes.features[b] - planes.features[a]);
  return (
    <div class="scroll tall" tabIndex={0} role="region" aria-label="Table of planes">
      <table>
        <caption>Planes, most features first</caption>
        <thead>
          <tr>
            <th>Plane</th><th class="number">Surface</th><th class="number">Features</th><th class="number">Views</th>
            <th class="number">Neighbours</th><th>Reference</th>
          </tr>
        </thead>
        <tbody>
          {order.slice(0, rows).map((i) => (
            <tr key={planes.id[i]} class={planes.id[i] === selected ? "selected" : ""}>
              <td>
                <Swatch colour={colourOf(planes.surface[i])} />
                <PlaneLink map={map} id={planes.id[i]} />
              </td>
              <td class="number">{planes.surface[i]}</td>
              <td class="number">{planes.features[i]}</td>
              <td class="number">{planes.keyframes[i].length}</td>
              <td class="number">{degree.get(planes.id[i]) ?? 0}</td>
              <td><KeyframeLink map={map} id={planes.reference[i]} /></td>
            </tr>
          ))}
        </tbody>
      </table>
      {rows < order.length && <button onClick={() => setRows(rows + 500)}>Show more</button>}
    </div>
  );
}

function Picture({ map, plane }: { map: string; plane: Plane }) {
  const keyframe = useGet<Keyframe>(`${mapPath(map)}/keyframes/${plane.reference.id}`);
  if (keyframe.error) return <Failure error={keyframe.error} />;
  if (!keyframe.value) return <Waiting what="the reference keyframe" />;
  const { width, height, image } = keyframe.value;
  const dots = plane.features.filter(
    (f) => f.x_px >= 0 && f.y_px >= 0 && f.x_px < width && f.y_px < height,
  );
  return (
    <figure>
      <Overlay
        picture={{ src: image, alt: `reference image of plane ${plane.id}`, width, height }}
        shapes={[{ points: plane.outline, colour: colourOf(plane.surface) }]}
        dots={dots.map((f) => [f.x_px, f.y_px])}
      />
      <figcaption>
        Reference image, keyframe <KeyframeLink map={map} id={plane.reference.id} />. Each dot is a
        feature.
      </figcaption>
    </figure>
  );
}

function Views({ map, plane }: { map: string; plane: Plane }) {
  return (
    <div class="scroll" tabIndex={0} role="region" aria-label="Views">
      <table>
        <caption>Keyframes with this plane in view</caption>
        <thead><tr><th>Keyframe</th><th class="number">Inliers</th></tr></thead>
        <tbody>
          {plane.views.map((view) => (
            <tr key={view.keyframe}>
              <td><KeyframeLink map={map} id={view.keyframe} /></td>
              <td class="number">{view.inliers}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

function PlanePanel({ map, id, siblings }: { map: string; id: number; siblings: number[] }) {
  const plane = useGet<Plane>(`${mapPath(map)}/planes/${id}`);
  if (plane.error) return <Failure error={plane.error} />;
  if (!plane.value) return <Waiting what={`plane ${id}`} />;
  const { features, views, neighbours, surface } = plane.value;
  const votes = features.reduce((sum, f) => sum + f.votes, 0) / Math.max(1, features.length);
  return (
    <section class="panel" aria-label={`Plane ${id}`}>
      <h2>Plane {id} <a class="close" href={href(map, "planes")}>Close</a></h2>
      <Picture map={map} plane={plane.value} />
      <p><a href={href(map, "names", id)}>Name this plane</a></p>
      <Facts
        rows={[
          ["Features", `${features.length}, each matched ${votes.toFixed(1)} times on average`],
          ["Views", views.length],
          ["Surface", siblings.length > 0
            ? <>{surface}, with <PlaneLinks map={map} ids={siblings} /></>
            : `${surface}, this plane only`],
          ["Neighbours", <PlaneLinks map={map} ids={neighbours} />],
        ]}
      />
      <Views map={map} plane={plane.value} />
    </section>
  );
}

// The graph, whose code needs WebGL to be loaded.
function Graph(props: GraphProps) {
  const [graph, setGraph] = useState<typeof import("./graph") | "failed" | null>(null);
  useEffect(() => {
    import("./graph").then(setGraph, () => setGraph("failed"));
  }, []);
  if (graph === "failed") return <NotLoaded what="The graph" />;
  return graph ? <graph.PlaneGraph {...props} /> : <Waiting what="the graph" />;
}

export function PlanesView({ map, route }: ViewProps) {
  const overview = useGet<Overview>(`${mapPath(map.name)}/overview`);
  const surfaces = useMemo(() => overview.value && surfaceGraph(overview.value), [overview.value]);
  if (overview.error) return <Failure error={overview.error} />;
  if (!overview.value || !surfaces) return <Waiting what="the graph" />;
  if (map.planes === 0) {
    return (
      <>
        <h1>Plane graph</h1>
        <p class="missing">This map has no planes.</p>
      </>
    );
  }
  const surface = route.id === null ? undefined : surfaces.ofPlane.get(route.id);
  const siblings = surfaces.surfaces.find(({ id }) => id === surface)?.planes ?? [];
  const select = (plane: number) => {
    location.hash = href(map.name, "planes", plane);
  };
  return (
    <>
      <h1>Plane graph</h1>
      <Legend planes={map.planes} surfaces={surfaces.surfaces.length} />
      <div class="split">
        {hasWebGl()
          ? <Graph map={map.name} surfaces={surfaces} selected={route.id} select={select} />
          : (
            <p class="missing">
              The graph can’t be drawn: this browser has no WebGL. The{" "}
              <a href={href(map.name, "planes")}>table of planes</a> has the same information.
            </p>
          )}
        {route.id === null
          ? <Table map={map.name} overview={overview.value} selected={route.id} />
          : <PlanePanel map={map.name} id={route.id} siblings={siblings.filter((id) => id !== route.id)} />}
      </div>
    </>
  );
}
