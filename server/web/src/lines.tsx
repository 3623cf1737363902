// SPDX-License-Identifier: Apache-2.0
// A picture with its straight lines, coloured by the direction of the building that they have (the
// orientation paper's fig. 2).
import type { DirectedLines } from "./api";
import { Frame } from "./figure";
import { Failure, Waiting } from "./parts";
import { useGet } from "./use";
import { counted } from "./words";

const kAxes = ["x", "y", "z"] as const;

export function LineStrokes({ lines }: { lines: DirectedLines }) {
  const drawn = [null, ...kAxes].flatMap((axis) => lines.lines.filter((l) => l.axis === axis));
  return (
    <g class="directed">
      {drawn.map((l, i) => (
        <polyline key={i} class={l.axis ?? "none"} points={l.points.map((p) => p.join(",")).join(" ")} />
      ))}
    </g>
  );
}

// How many lines have which direction, and whose directions they are.
export function LineWords({ lines }: { lines: DirectedLines }) {
  const count = (axis: string | null) => lines.lines.filter((l) => l.axis === axis).length;
  return (
    <figcaption>
      <span class="key x">{count("x")} along x</span> <span class="key y">{count("y")} along y</span>{" "}
      <span class="key z">{count("z")} upright</span>; {counted(count(null), "line")} of no axis.{" "}
      {lines.of === "frame"
        ? "The axes are the building’s."
        : lines.reliable ? "The axes are this picture’s own." : "This picture’s axes aren’t reliable."}
    </figcaption>
  );
}

// A picture and the lines that the server finds in it; `path` gives them.
export function LinedPicture({ image, alt, path }: { image: string; alt: string; path: string }) {
  const lines = useGet<DirectedLines>(path);
  if (lines.error) return <Failure error={lines.error} />;
  if (!lines.value) return <Waiting what="the lines" />;
  const { width, height } = lines.value;
  return (
    <figure>
      <div class="figure" style={{ aspectRatio: `${width} / ${height}` }}>
        <Frame picture={{ src: image, alt, width, height }} />
        <svg viewBox={`0 0 ${width} ${height}`} aria-hidden="true"><LineStrokes lines={lines.value} /></svg>
      </div>
      <LineWords lines={lines.value} />
    </figure>
  );
}
