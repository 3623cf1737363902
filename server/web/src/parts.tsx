// SPDX-License-Identifier: Apache-2.0
// Small things that several views show.
import type { ComponentChildren } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import { type MapSummary, thumbnailPath } from "./api";
import { href } from "./route";
import { usePicture } from "./use";

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
      <img src={usePicture(thumbnailPath(map.name, id)) ?? undefined} alt={`keyframe ${id}`} loading="lazy" />
    </a>
  );
}

const kViewerWidth = 300; // px; a smaller picture is too blurred to look around in

// A panorama to look around in, or flat where the map has a small copy of it only.
export function Panorama({ path }: { path: string }) {
  const src = usePicture(path);
  const [large, setLarge] = useState<string | null>(null);
  const sized = (event: Event) => {
    if ((event.target as HTMLImageElement).naturalWidth >= kViewerWidth) setLarge(src);
  };
  if (!src) return null;
  if (large === src) return <PanoramaViewer src={src} />;
  return <div class="panoramas"><img class="small" src={src} alt="the panorama" onLoad={sized} /></div>;
}

function PanoramaViewer({ src }: { src: string }) {
  const box = useRef<HTMLDivElement>(null);
  useEffect(() => {
    let viewer: { destroy(): void } | null = null;
    let gone = false;
    import("./panorama").then(({ showPanorama }) => {
      if (!gone) viewer = showPanorama(box.current!, src);
    });
    return () => {
      gone = true;
      viewer?.destroy();
    };
  }, [src]);
  return <div class="panorama" ref={box} />;
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
