// SPDX-License-Identifier: Apache-2.0
// A photo or two with what was found drawn over them, in the pixels of the originals.
import type { ComponentChildren } from "preact";
import type { Candidate, Point } from "./api";
import { turnedStyle } from "./exif";
import { useMedia, usePicture } from "./use";

export interface Picture {
  src: string | null; // null: the map was built without images
  alt: string;
  width: number; // of the upright image
  height: number;
  orientation?: number; // as EXIF has it; else it is stored upright
}

export interface Shape {
  points: Point[];
  colour: string;
  label?: string;
  faint?: boolean;
}

const pointList = (points: Point[]) => points.map((p) => p.join(",")).join(" ");

const kLabelWidth = 30; // px, of a label and the air around it
const kLabelHeight = 18;

const centre = (points: Point[]): Point => [
  points.reduce((sum, p) => sum + p[0], 0) / points.length,
  points.reduce((sum, p) => sum + p[1], 0) / points.length,
];

// Where labels go: at the centres, one below the other where they would cover each other.
function labelPlaces(shapes: Shape[], unit: number): Point[] {
  const places: Point[] = [];
  for (const shape of shapes) {
    const [x, y] = centre(shape.points);
    let place: Point = [x, y];
    const taken = ([u, v]: Point) =>
      Math.abs(u - place[0]) < kLabelWidth * unit && Math.abs(v - place[1]) < kLabelHeight * unit;
    while (places.some(taken)) place = [x, place[1] + kLabelHeight * unit];
    places.push(place);
  }
  return places;
}

// Outlines, each with its label at its centre. `unit` is what is about a pixel on the screen.
export function Outlines({ shapes, unit }: { shapes: Shape[]; unit: number }) {
  const drawn = shapes.filter((s) => s.points.length > 2);
  const places = labelPlaces(drawn, unit);
  return (
    <>
      {drawn.map((s, i) => (
        <g key={s.label ?? "only"} class={s.faint ? "outline faint" : "outline"}>
          <polygon points={pointList(s.points)} stroke={s.colour} fill={s.colour} />
          {s.label && (
            <text x={places[i][0]} y={places[i][1]} font-size={15 * unit}>
              {s.label}
            </text>
          )}
        </g>
      ))}
    </>
  );
}

export function Frame({ picture, children }: { picture: Picture; children?: ComponentChildren }) {
  const src = usePicture(picture.src);
  const { alt, width, height, orientation = 1 } = picture;
  return picture.src
    ? <img src={src ?? undefined} alt={alt} width={width} height={height} style={turnedStyle(orientation, width, height)} />
    : <div class="no-image" role="img" aria-label={alt}>{children ?? "no image stored"}</div>;
}

// One picture with outlines and points.
export function Overlay(props: {
  picture: Picture;
  shapes: Shape[];
  dots?: Point[];
  children?: ComponentChildren; // drawn below the outlines
}) {
  const { picture, shapes, dots = [], children } = props;
  return (
    <div class="figure" style={{ aspectRatio: `${picture.width} / ${picture.height}` }}>
      <Frame picture={picture} />
      <svg viewBox={`0 0 ${picture.width} ${picture.height}`} aria-hidden="true">
        {children}
        <Outlines shapes={shapes} unit={picture.width / 640} />
        <g class="dots">
          {dots.map(([x, y], i) => <circle key={i} cx={x} cy={y} r={picture.width / 320} />)}
        </g>
      </svg>
    </div>
  );
}

const kFewLines = 30; // so few are drawn clearly, more so that they don't hide the pictures
const kGap = 12; // between the two, in pixels of the left one scaled to a width of 640

// Two pictures and the lines between what matches in them: beside each other, or one above the
// other where the page is narrow.
export function Pair(props: {
  left: Picture;
  right: Picture;
  leftShapes: Shape[];
  rightShapes: Shape[];
  points: Candidate["points"];
  colour: string;
  stacked?: boolean;
}) {
  const { left, right } = props;
  const narrow = useMedia("(max-width: 700px)");
  const stacked = props.stacked || narrow;
  const unit = 640;
  const leftScale = unit / left.width;
  const rightScale = unit / right.width;
  const leftHeight = left.height * leftScale;
  const rightHeight = right.height * rightScale;
  const width = stacked ? unit : 2 * unit + kGap;
  const height = stacked ? leftHeight + kGap + rightHeight : Math.max(leftHeight, rightHeight);
  const dx = stacked ? 0 : unit + kGap;
  const dy = stacked ? leftHeight + kGap : 0;
  const place = (x: number, y: number, w: number, h: number) => ({
    left: `${(100 * x) / width}%`,
    top: `${(100 * y) / height}%`,
    width: `${(100 * w) / width}%`,
    height: `${(100 * h) / height}%`,
  });
  return (
    <div class="figure" style={{ aspectRatio: `${width} / ${height}` }}>
      <div class="part" style={place(0, 0, unit, leftHeight)}>
        <Frame picture={left} />
      </div>
      <div class="part" style={place(dx, dy, unit, rightHeight)}>
        <Frame picture={right} />
      </div>
      <svg viewBox={`0 0 ${width} ${height}`} aria-hidden="true">
        <g transform={`scale(${leftScale})`}>
          <Outlines shapes={props.leftShapes} unit={1 / leftScale} />
        </g>
        <g transform={`translate(${dx} ${dy}) scale(${rightScale})`}>
          <Outlines shapes={props.rightShapes} unit={1 / rightScale} />
        </g>
        <g class={props.points.length < kFewLines ? "matches few" : "matches"} stroke={props.colour} fill={props.colour}>
          {props.points.map(([x, y, u, v], i) => (
            <g key={i}>
              <line
                x1={x * leftScale}
                y1={y * leftScale}
                x2={dx + u * rightScale}
                y2={dy + v * rightScale}
              />
              <circle cx={x * leftScale} cy={y * leftScale} r="2" />
              <circle cx={dx + u * rightScale} cy={dy + v * rightScale} r="2" />
            </g>
          ))}
        </g>
      </svg>
    </div>
  );
}
