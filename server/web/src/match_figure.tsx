// SPDX-License-Identifier: Apache-2.0
// The query image beside a keyframe, with lines between the inliers: those of a plane and its
// reference keyframe, or all of a keyframe.
import { imagePath, type Keyframe, mapPath } from "./api";
import { Pair, type Shape } from "./figure";
import type { Query } from "./types";
import { Failure, KeyframeLink, Waiting } from "./parts";
import { useGet } from "./use";

export interface Matched {
  plane?: number; // the inliers are all on it
  reference: number;
  points: [number, number, number, number][];
}

export function MatchFigure(props: {
  map: string;
  query: Query;
  candidate: Matched;
  shapes: Shape[];
  colour: string;
  stacked?: boolean; // the keyframe below the query image
}) {
  const { map, query, candidate, colour } = props;
  const keyframe = useGet<Keyframe>(`${mapPath(map)}/keyframes/${candidate.reference}`);
  const why = query.answer.explanation;
  if (keyframe.error) return <Failure error={keyframe.error} />;
  if (!keyframe.value || !why) return <Waiting what="the keyframe" />;
  const { width, height, image, planes } = keyframe.value;
  const outline = planes.find((p) => p.id === candidate.plane)?.outline ?? [];
  return (
    <figure>
      <Pair
        left={{ src: query.photo, alt: "query image", orientation: query.orientation, ...why.image }}
        right={{
          src: image && imagePath(map, candidate.reference),
          alt: `keyframe ${candidate.reference}`,
          width,
          height,
        }}
        leftShapes={props.shapes}
        rightShapes={outline.length > 0 ? [{ points: outline, colour, label: `${candidate.plane}` }] : []}
        points={candidate.points}
        colour={colour}
        stacked={props.stacked}
      />
      <figcaption>
        Query image and keyframe <KeyframeLink map={map} id={candidate.reference} />
        {candidate.plane !== undefined && <>, the reference of plane {candidate.plane}</>}. Each line
        connects an inlier in the two images.
      </figcaption>
    </figure>
  );
}
