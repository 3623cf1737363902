// SPDX-License-Identifier: Apache-2.0
// Small components shared by several views.
import { Component, type ComponentChildren } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import { type MapSummary, thumbnailPath } from "./api";
import { href } from "./route";
import { usePicture } from "./use";

export function Failure({ error }: { error: string }) {
  return <p class="failure" role="alert">Error: {error}</p>;
}

export function Waiting({ what }: { what: string }) {
  return <p class="quiet" role="status">Loading {what} …</p>;
}

// In place of a part of the page that didn't load: the server has another one by now, or can't be reached.
export function NotLoaded({ what }: { what: string }) {
  return (
    <p class="failure" role="alert">
      {what} can’t be loaded. <button onClick={() => location.reload()}>Reload the page</button>
    </p>
  );
}

// In place of what can't be drawn, which would leave the page empty.
export class Boundary extends Component<{ children: ComponentChildren }, { error: Error | null }> {
  state = { error: null as Error | null };

  static getDerivedStateFromError(error: Error) {
    return { error };
  }

  render() {
    const { error } = this.state;
    return error ? <Failure error={`this view can’t be shown (${error.message})`} /> : this.props.children;
  }
}

let webGl: boolean | null = null;

// Whether the browser draws with WebGL. It is asked once: browsers have few contexts to give.
export function hasWebGl(): boolean {
  webGl ??= document.createElement("canvas").getContext("webgl2") !== null;
  return webGl;
}

export function KeyframeLink(props: { map: string; id: number; children?: ComponentChildren }) {
  return <a href={href(props.map, "keyframes", props.id)}>{props.children ?? props.id}</a>;
}

export function PlaneLink({ map, id }: { map: string; id: number }) {
  return <a href={href(map, "planes", id)}>{id}</a>;
}

// Plane ids separated by commas.
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

const kViewerWidth = 300; // px; smaller panoramas are too blurred for the viewer

// A panorama in a 360-degree viewer, or flat where the map stores only a small copy.
export function Panorama({ path }: { path: string }) {
  const src = usePicture(path);
  const [large, setLarge] = useState<string | null>(null);
  const sized = (event: Event) => {
    if ((event.target as HTMLImageElement).naturalWidth >= kViewerWidth) setLarge(src);
  };
  if (!src) return null;
  if (large === src) return <PanoramaViewer src={src} />;
  return <div class="panoramas"><img class="small" src={src} alt="panorama" onLoad={sized} /></div>;
}

function PanoramaViewer({ src }: { src: string }) {
  const box = useRef<HTMLDivElement>(null);
  const [failed, setFailed] = useState(false);
  useEffect(() => {
    let viewer: { destroy(): void } | null = null;
    let gone = false;
    import("./panorama").then(({ showPanorama }) => {
      if (!gone) viewer = showPanorama(box.current!, src);
    }).catch(() => setFailed(true));
    return () => {
      gone = true;
      viewer?.destroy();
    };
  }, [src]);
  return failed ? <NotLoaded what="The panorama viewer" /> : <div class="panorama" ref={box} />;
}

export function Swatch({ colour, shape = "" }: { colour: string; shape?: Shape }) {
  return <span class={`swatch ${shape}`} style={{ color: colour }} />;
}

// As a drawing has it; a square otherwise.
type Shape = "circle" | "ring" | "diamond" | "line" | "dashed" | "dotted" | "";

// What a sign of a drawing means.
export function Sign(props: { colour: string; shape?: Shape; children: ComponentChildren }) {
  return <span class="sign"><Swatch colour={props.colour} shape={props.shape} />{props.children} </span>;
}

// Chooses by its number what a drawing offers to the mouse: the nearest one of `numbers`.
export function GoTo(props: { what: string; numbers: number[]; choose: (index: number) => void }) {
  const { what, numbers } = props;
  const submit = (event: Event) => {
    event.preventDefault();
    const field = (event.target as HTMLFormElement).elements.namedItem("number") as HTMLInputElement;
    const away = (i: number) => Math.abs(numbers[i] - Number(field.value));
    props.choose(numbers.reduce((best, _, i) => (away(i) < away(best) ? i : best), 0));
  };
  if (numbers.length === 0) return null;
  return (
    <form class="go-to" onSubmit={submit}>
      <label>
        {what} <input name="number" type="number" step="1" required min={numbers[0]} max={numbers[numbers.length - 1]} />
      </label>{" "}
      <button>Show</button>
    </form>
  );
}

// A list of names and values.
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
