// SPDX-License-Identifier: Apache-2.0
// The query image beside the reference keyframe of a plane, with lines between their inliers.
import { type Candidate, imagePath, type Keyframe, mapPath } from "./api";
import { Pair, type Shape } from "./figure";
import type { Query } from "./types";
import { Failure, KeyframeLink, Waiting } from "./parts";
import { useGet } from "./use";

export function MatchFigure(props: {
  map: string;
  query: Query;
  candidate: Candidate;
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
        left={{ src: query.photo, alt: "query image", ...why.image }}
        right={{
          src: image && imagePath(map, candidate.reference),
          alt: `keyframe ${candidate.reference}`,
          width,
          height,
        }}
        leftShapes={props.shapes}
        rightShapes={[{ points: outline, colour, label: `${candidate.plane}` }]}
        points={candidate.points}
        colour={colour}
        stacked={props.stacked}
      />
      <figcaption>
        Query image and keyframe <KeyframeLink map={map} id={candidate.reference} />, the reference of
        plane {candidate.plane}. Each line joins an inlier in both.
      </figcaption>
    </figure>
  );
}
