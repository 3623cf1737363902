// SPDX-License-Identifier: Apache-2.0
// Small things that several views show.
import type { ComponentChildren } from "preact";
import { type MapSummary, thumbnailPath } from "./api";
import { href } from "./route";

export function Failure({ error }: { error: string }) {
  return <p class="failure" role="alert">This didn’t work: {error}</p>;
}

export function Waiting({ what }: { what: string }) {
  return <p class="quiet" role="status">Loading {what} …</p>;
}

export function KeyframeLink(props: { map: string; id: number; children?: ComponentChildren }) {
  return <a href={href(props.map, "keyframes", props.id)}>{props.children ?? props.id}</a>;
}

export function PlaneLink({ map, id }: { map: string; id: number }) {
  return <a href={href(map, "planes", id)}>{id}</a>;
}

// A row of planes' ids.
export function PlaneLinks({ map, ids }: { map: string; ids: number[] }) {
  if (ids.length === 0) return <>–</>;
  return (
    <>
      {ids.map((id, i) => (
        <span key={id}>{i > 0 && ", "}<PlaneLink map={map} id={id} /></span>
      ))}
    </>
  );
}

export function Thumbnail({ map, id }: { map: MapSummary; id: number }) {
  return (
    <a class="thumbnail" href={href(map.name, "keyframes", id)}>
      <img src={thumbnailPath(map.name, id)} alt={`keyframe ${id}`} loading="lazy" />
    </a>
  );
}

export function Swatch({ colour }: { colour: string }) {
  return <span class="swatch" style={{ backgroundColor: colour }} />;
}

// Pairs of a name and a value.
export function Facts({ rows }: { rows: [string, ComponentChildren][] }) {
  return (
    <dl class="facts">
      {rows.map(([name, value]) => (
        <div key={name}>
          <dt>{name}</dt>
          <dd>{value}</dd>
        </div>
      ))}
    </dl>
  );
}
