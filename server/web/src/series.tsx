// SPDX-License-Identifier: Apache-2.0
// A series of numbers along the map's order.
import uPlot from "uplot";
import { useEffect, useRef } from "preact/hooks";
import { cssColour } from "./colours";
import { useMedia } from "./use";

const kHeight = 200; // px

// Steps between ticks: numbers of keyframes are whole.
const kSteps = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000, 20000, 50000];

// Shades the marked runs (first and last, as in `at`) behind the line.
function shade(plot: uPlot, marked: [number, number][]) {
  const { ctx, bbox } = plot;
  ctx.save();
  ctx.fillStyle = cssColour("--weak");
  for (const [first, last] of marked) {
    const left = plot.valToPos(first - 0.5, "x", true);
    const right = plot.valToPos(last + 0.5, "x", true);
    ctx.fillRect(left, bbox.top, Math.max(1, right - left), bbox.height);
  }
  ctx.restore();
}

function optionsFor(
  width: number,
  along: string,
  unit: string,
  marked: [number, number][],
): uPlot.Options {
  const axis = { stroke: cssColour("--quiet"), grid: { stroke: cssColour("--line"), width: 1 } };
  return {
    width,
    height: kHeight,
    legend: { show: false },
    cursor: { drag: { x: true, y: false } },
    scales: {
      x: { time: false },
      y: { range: (_, low, high) => [Math.min(0, low), high > low ? high * 1.05 : low + 1] },
    },
    axes: [
      { ...axis, label: along, labelSize: 20, size: 30, incrs: kSteps },
      { ...axis, label: unit, labelSize: 20, size: 50 },
    ],
    series: [{}, { stroke: cssColour("--accent"), width: 1.5, points: { show: false } }],
    hooks: { drawClear: [(plot) => shade(plot, marked)] },
  };
}

export function Series(props: {
  at: number[]; // numbers of what the values are of, ascending
  along: string; // what is numbered
  values: number[];
  unit: string;
  marked: [number, number][];
  what: string;
  choose?: (index: number) => void;
}) {
  const { at, along, values, unit, marked, what, choose } = props;
  const box = useRef<HTMLDivElement>(null);
  const dark = useMedia("(prefers-color-scheme: dark)");
  useEffect(() => {
    const place = box.current!;
    const data: uPlot.AlignedData = [at, values];
    const plot = new uPlot(optionsFor(place.clientWidth, along, unit, marked), data, place);
    const resized = new ResizeObserver(() =>
      plot.setSize({ width: place.clientWidth, height: kHeight }));
    resized.observe(place);
    const click = () => plot.cursor.idx != null && choose?.(plot.cursor.idx);
    plot.over.addEventListener("click", click);
    return () => {
      resized.disconnect();
      plot.destroy();
    };
  }, [at, values, unit, marked, dark]);
  return <div class="series" ref={box} role="img" aria-label={what} />;
}
