// SPDX-License-Identifier: Apache-2.0
// An image with its line segments, coloured by the Manhattan axis they are parallel to (the
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

// The number of lines along each axis, and the frame of the axes.
export function LineWords({ lines }: { lines: DirectedLines }) {
  const count = (axis: string | null) => lines.lines.filter((l) => l.axis === axis).length;
  return (
    <figcaption>
      <span class="key x">{count("x")} along x</span> <span class="key y">{count("y")} along y</span>{" "}
      <span class="key z">{count("z")} vertical</span>; {counted(count(null), "line")} along no axis.{" "}
      {lines.of === "frame"
        ? "The axes are those of the map."
        : lines.reliable ? "The axes were estimated from this image alone." : "The axes of this image are not reliable."}
    </figcaption>
  );
}

// An image and the lines that the server detects in it, at `path`.
export function LinedPicture({ image, alt, path }: { image: string; alt: string; path: string }) {
  const lines = useGet<DirectedLines>(path);
  if (lines.error) return <Failure error={lines.error} />;
  if (!lines.value) return <Waiting what="lines" />;
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
