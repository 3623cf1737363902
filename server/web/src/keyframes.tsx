// SPDX-License-Identifier: Apache-2.0
// View: the keyframes, and one keyframe with the outlines of its planes.
import { useState } from "preact/hooks";
import { type DirectedLines, imagePath, type Keyframe, type MapSummary, mapPath, type Overview } from "./api";
import { colourOf } from "./colours";
import { Overlay } from "./figure";
import { LineStrokes, LineWords } from "./lines";
import type { ViewProps } from "./types";
import { Facts, Failure, Panorama, PlaneLink, Swatch, Thumbnail, Waiting } from "./parts";
import { href } from "./route";
import { InSpace } from "./space";
import { useGet } from "./use";
import { counted } from "./words";

const kPage = 60; // thumbnails

function Neighbours({ map, id, ids }: { map: string; id: number; ids: number[] }) {
  const at = ids.indexOf(id);
  const link = (to: number | undefined, text: string) =>
    to === undefined ? <span class="quiet">{text}</span> : <a href={href(map, "keyframes", to)}>{text}</a>;
  return (
    <p class="steps">
      {link(ids[at - 1], "← Previous")} {link(ids[at + 1], "Next →")}{" "}
      <a href={href(map, "keyframes")}>All</a>
    </p>
  );
}

function PlaneTable({ map, keyframe, shown, toggle }: {
  map: string;
  keyframe: Keyframe;
  shown: (id: number) => boolean;
  toggle: (id: number) => void;
}) {
  return (
    <div class="scroll" tabIndex={0} role="region" aria-label="Planes in view">
      <table>
        <caption>Planes in view</caption>
        <thead><tr><th>Draw</th><th>Plane</th><th class="number">Surface</th><th class="number">Inliers</th><th>Names</th></tr></thead>
        <tbody>
          {keyframe.planes.map((plane) => (
            <tr key={plane.id}>
              <td>
                <input
                  type="checkbox"
                  aria-label={`draw plane ${plane.id}`}
                  checked={shown(plane.id)}
                  onChange={() => toggle(plane.id)}
                />
              </td>
              <td><Swatch colour={colourOf(plane.surface)} /><PlaneLink map={map} id={plane.id} /></td>
              <td class="number">{plane.surface}</td>
              <td class="number">{plane.inliers}</td>
              <td><a href={href(map, "names", plane.id)} aria-label={`Name plane ${plane.id}`}>name</a></td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

const cameraOf = (map: MapSummary, keyframe: Keyframe) =>
  map.sequences.find((s) => s.id === keyframe.sequence_id)?.camera ?? null;

const withoutPlanes = (landmarks: number) => landmarks > 0
  ? `No mapped plane is in view: the keyframe is recognised by its ${counted(landmarks, "landmark")}.`
  : "No mapped plane is in view, and the keyframe has no landmarks: a query from here can’t be localized.";

function Show({ map, id }: { map: MapSummary; id: number }) {
  const keyframe = useGet<Keyframe>(`${mapPath(map.name)}/keyframes/${id}`);
  const [hidden, setHidden] = useState<number[]>([]);
  const [withLines, setWithLines] = useState(false);
  const lines = useGet<DirectedLines>(withLines ? `${mapPath(map.name)}/keyframes/${id}/lines` : null);
  if (keyframe.error) return <Failure error={keyframe.error} />;
  if (!keyframe.value) return <Waiting what={`keyframe ${id}`} />;
  const { width, height, image, planes, landmarks, place, source, sequence, frame, stretch, time_s } = keyframe.value;
  const camera = cameraOf(map, keyframe.value);
  const panorama = camera?.model === "EQUIRECTANGULAR";
  const shown = (plane: number) => !hidden.includes(plane);
  const toggle = (plane: number) =>
    setHidden(shown(plane) ? [...hidden, plane] : hidden.filter((h) => h !== plane));
  const shapes = planes.map((p) => ({ points: p.outline, colour: colourOf(p.surface), label: `${p.id}` }))
    .filter((_, i) => shown(planes[i].id));
  return (
    <>
      <div class="split">
        <div>
          <Overlay picture={{ src: image, alt: `keyframe ${id}: ${source}`, width, height }} shapes={shapes}>
            {lines.value && <LineStrokes lines={lines.value} />}
          </Overlay>
          {image && camera && !panorama && (
            <label class="toggle">
              <input type="checkbox" checked={withLines} onChange={() => setWithLines(!withLines)} />
              Show lines coloured by Manhattan axis
            </label>
          )}
          {lines.error && <Failure error={lines.error} />}
          {lines.value && <LineWords lines={lines.value} />}
          {image && panorama && <Panorama path={imagePath(map.name, id)} />}
        </div>
        <div>
          <Facts
            rows={[
              ...(place ? [["Place", place] as [string, string]] : []),
              ["Source", `${source} of sequence ${sequence}`],
              ["Frame", time_s === null ? frame : `${frame} at ${time_s.toFixed(2)} s`],
              ["Stretch", stretch + 1],
              ["Size", `${width} × ${height} px`],
            ]}
          />
          {planes.length > 0
            ? <PlaneTable map={map.name} keyframe={keyframe.value} shown={shown} toggle={toggle} />
            : <p>{withoutPlanes(landmarks)}</p>}
        </div>
      </div>
      {planes.length > 0 && camera && !panorama && <InSpace map={map} keyframe={keyframe.value} />}
    </>
  );
}

function Grid({ map, overview }: { map: MapSummary; overview: Overview }) {
  const [count, setCount] = useState(kPage);
  const { id, place, planes, features } = overview.keyframes;
  return (
    <>
      <ul class="grid">
        {id.slice(0, count).map((keyframe, i) => (
          <li key={keyframe}>
            <Thumbnail map={map} id={keyframe} />
            <span><strong>{keyframe}</strong> {place[i] && <>{place[i]}, </>}{counted(planes[i], "plane")}, {counted(features[i], "inlier")}</span>
          </li>
        ))}
      </ul>
      {count < id.length && (
        <button onClick={() => setCount(count + kPage)}>
          Show more ({(id.length - count).toLocaleString("en")} left)
        </button>
      )}
    </>
  );
}

export function KeyframesView({ map, route }: ViewProps) {
  const overview = useGet<Overview>(`${mapPath(map.name)}/overview`);
  if (overview.error) return <Failure error={overview.error} />;
  if (!overview.value) return <Waiting what="keyframes" />;
  if (route.id === null) {
    return (
      <>
        <h1>Keyframes</h1>
        {map.keyframes > 0 ? (
          <>
            <p class="quiet">Each keyframe with the number of planes in view and their inliers.</p>
            <Grid map={map} overview={overview.value} />
          </>
        ) : <p class="missing">This map has no keyframes.</p>}
      </>
    );
  }
  return (
    <>
      <h1>Keyframe {route.id}</h1>
      <Neighbours map={map.name} id={route.id} ids={overview.value.keyframes.id} />
      <Show key={route.id} map={map} id={route.id} />
    </>
  );
}
