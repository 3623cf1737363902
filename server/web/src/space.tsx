// SPDX-License-Identifier: Apache-2.0
// The planes of a keyframe in 3D, as reconstructed from their homographies.
import { useEffect, useRef, useState } from "preact/hooks";
import { type Keyframe, mapPath, type MapSummary, type Space } from "./api";
import { colourOf } from "./colours";
import { Failure, hasWebGl, NotLoaded, PlaneLink, Swatch, Waiting } from "./parts";
import type { Side, SpaceView } from "./space_view";
import { useGet, useMedia, usePicture } from "./use";
import { counted } from "./words";

const kDegrees = 180 / Math.PI;

const kReasons: Record<string, string> = {
  no_parallax: "too little parallax between its views",
  ambiguous: "two decompositions fit its views",
  uncertain: "too uncertain",
};

const kSides: [Side, string][] = [
  ["camera", "Behind the camera"],
  ["side", "Side"],
  ["above", "Top"],
];

function Scene({ space, keyframe, colours }: {
  space: Space;
  keyframe: Keyframe;
  colours: Map<number, string>;
}) {
  const box = useRef<HTMLDivElement>(null);
  const view = useRef<SpaceView | null>(null);
  const [failed, setFailed] = useState(false);
  const picture = usePicture(keyframe.image);
  const dark = useMedia("(prefers-color-scheme: dark)");
  useEffect(() => {
    let gone = false;
    import("./space_view").then(({ showSpace }) => {
      if (gone) return;
      const size: [number, number] = [keyframe.width, keyframe.height];
      view.current = showSpace(box.current!, { space, colours, picture, size });
    }).catch(() => setFailed(true));
    return () => {
      gone = true;
      view.current?.destroy();
      view.current = null;
    };
  }, [space, picture, dark]);
  if (failed) return <NotLoaded what="The drawing" />;
  return (
    <>
      <div class="space" ref={box} role="img"
        aria-label={`Planes of keyframe ${keyframe.id} in 3D, with its camera`} />
      <p class="steps">
        {kSides.map(([side, text]) => (
          <button key={side} onClick={() => view.current?.look(side)}>{text}</button>
        ))}
      </p>
    </>
  );
}

function Table({ map, space, colours }: { map: string; space: Space; colours: Map<number, string> }) {
  return (
    <div class="scroll" tabIndex={0} role="region" aria-label="Planes in 3D">
      <table>
        <caption>Distances, in units of the distance to plane {space.unit_plane}</caption>
        <thead><tr><th>Plane</th><th>Distance</th><th>Normal (1σ)</th></tr></thead>
        <tbody>
          {space.planes.map((p) => (
            <tr key={p.id}>
              <td><Swatch colour={colours.get(p.id)!} /><PlaneLink map={map} id={p.id} /></td>
              {p.trouble !== null
                ? <td colSpan={2} class="quiet">unknown: {kReasons[p.trouble]}</td>
                : (
                  <>
                    <td>{p.distance!.toFixed(2)} ± {p.distance_deviation!.toFixed(2)}</td>
                    <td>{(p.normal_deviation_rad! * kDegrees).toFixed(1)}°</td>
                  </>
                )}
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

function Found({ map, keyframe }: { map: MapSummary; keyframe: Keyframe }) {
  const space = useGet<Space>(`${mapPath(map.name)}/keyframes/${keyframe.id}/space`);
  if (space.error) return <Failure error={space.error} />;
  if (!space.value) return <Waiting what="planes in 3D" />;
  const colours = new Map(keyframe.planes.map((p) => [p.id, colourOf(p.surface)]));
  const placed = space.value.planes.filter((p) => p.trouble === null).length;
  return (
    <>
      <p class="quiet">
        {placed} of {counted(space.value.planes.length, "plane")} reconstructed from the homographies to{" "}
        {counted(space.value.views, "other keyframe")}. The scale is unknown, so distances are relative.
        Drag to rotate, scroll to zoom.
      </p>
      {placed > 0 && (hasWebGl()
        ? <Scene space={space.value} keyframe={keyframe} colours={colours} />
        : <p class="missing">Planes can’t be drawn in 3D: this browser has no WebGL.</p>)}
      {space.value.unit_plane !== null && <Table map={map.name} space={space.value} colours={colours} />}
    </>
  );
}

// Planes in 3D, computed on request.
export function InSpace({ map, keyframe }: { map: MapSummary; keyframe: Keyframe }) {
  const [asked, setAsked] = useState(false);
  return (
    <section>
      <h2>Planes in 3D</h2>
      {asked
        ? <Found map={map} keyframe={keyframe} />
        : <button onClick={() => setAsked(true)}>Show planes in 3D</button>}
    </section>
  );
}
