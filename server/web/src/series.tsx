// SPDX-License-Identifier: Apache-2.0
// Numbers along the map's order, as curves.
import uPlot from "uplot";
import { useEffect, useRef } from "preact/hooks";
import { cssColour } from "./colours";
import { useMedia } from "./use";

const kHeight = 200; // px

// Steps between ticks: numbers of keyframes are whole.
const kSteps = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000, 20000, 50000];

export interface Curve {
  values: (number | null)[]; // as many as `at`
  colour: string; // a variable of the style sheet
  dash?: number[]; // px, of the line
  dots?: "full" | "hollow"; // a dot a value and no line between them
}

// A vertical line.
export interface Mark {
  at: number;
  colour: string;
  dash?: number[];
}

export interface SeriesProps {
  at: number[]; // numbers of what the values are of, ascending
  along: string; // what is numbered
  curves: Curve[];
  unit: string;
  range?: [number, number]; // of the values; 0 to the largest otherwise
  ticks?: number[]; // of the values
  marked: [number, number][]; // runs that are shaded, first and last as in `at`
  marks?: Mark[];
  chosen?: number | null; // as in `at`
  what: string;
  choose?: (index: number) => void;
}

// Shades the marked runs behind the curves.
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

function drawMarks(plot: uPlot, marks: Mark[], width: number) {
  const { ctx, bbox } = plot;
  ctx.save();
  ctx.lineWidth = width * devicePixelRatio;
  for (const { at, colour, dash = [] } of marks) {
    const x = plot.valToPos(at, "x", true);
    ctx.strokeStyle = cssColour(colour);
    ctx.setLineDash(dash.map((px) => px * devicePixelRatio));
    ctx.beginPath();
    ctx.moveTo(x, bbox.top);
    ctx.lineTo(x, bbox.top + bbox.height);
    ctx.stroke();
  }
  ctx.restore();
}

function seriesOf({ colour, dash, dots }: Curve): uPlot.Series {
  const stroke = cssColour(colour);
  if (!dots) return { stroke, width: 1.5, dash, points: { show: false } };
  const points = dots === "full" ? { size: 4, fill: stroke, width: 0 } : { size: 5, fill: cssColour("--ground"), width: 1 };
  return { stroke, paths: () => null, points: { show: true, ...points } };
}

function optionsFor(width: number, props: SeriesProps, chosen: () => Mark[]): uPlot.Options {
  const axis = { stroke: cssColour("--quiet"), grid: { stroke: cssColour("--line"), width: 1 } };
  const { range, ticks } = props;
  return {
    width,
    height: kHeight,
    legend: { show: false },
    cursor: { drag: { x: true, y: false } },
    scales: {
      x: { time: false },
      y: {
        range: (_, low, high) =>
          range ?? [Math.min(0, low), high > low ? high * 1.05 : low + 1],
      },
    },
    axes: [
      { ...axis, label: props.along, labelSize: 20, size: 30, incrs: kSteps },
      { ...axis, label: props.unit, labelSize: 20, size: 50, ...(ticks && { splits: () => ticks }) },
    ],
    series: [{}, ...props.curves.map(seriesOf)],
    hooks: {
      drawClear: [(plot) => shade(plot, props.marked)],
      draw: [
        (plot) => drawMarks(plot, props.marks ?? [], 2),
        (plot) => drawMarks(plot, chosen(), 1),
      ],
    },
  };
}

export function Series(props: SeriesProps) {
  const { at, curves, unit, marked, marks, chosen, what, choose } = props;
  const box = useRef<HTMLDivElement>(null);
  const drawn = useRef<uPlot | null>(null);
  const picked = useRef<Mark[]>([]);
  const dark = useMedia("(prefers-color-scheme: dark)");
  useEffect(() => {
    const place = box.current!;
    const data = [at, ...curves.map((c) => c.values)] as uPlot.AlignedData;
    const plot = new uPlot(optionsFor(place.clientWidth, props, () => picked.current), data, place);
    drawn.current = plot;
    const resized = new ResizeObserver(() =>
      plot.setSize({ width: place.clientWidth, height: kHeight }));
    resized.observe(place);
    const click = () => plot.cursor.idx != null && choose?.(plot.cursor.idx);
    plot.over.addEventListener("click", click);
    return () => {
      resized.disconnect();
      plot.destroy();
    };
  }, [at, curves, unit, marked, marks, dark]);
  // Another choice draws the same plot again.
  useEffect(() => {
    picked.current = chosen == null ? [] : [{ at: chosen, colour: "--text" }];
    drawn.current?.redraw(false);
  }, [chosen]);
  return <div class="series" ref={box} role="img" aria-label={what} />;
}
