// SPDX-License-Identifier: Apache-2.0
// The query's photo beside the keyframe that a plane was found on, with the lines of the matches.
import { type Candidate, imagePath, type Keyframe, mapPath } from "./api";
import { Pair, type Shape } from "./figure";
import type { Query } from "./main";
import { Failure, KeyframeLink, Waiting } from "./parts";
import { useGet } from "./use";

export function MatchFigure(props: {
  map: string;
  query: Query;
  candidate: Candidate;
  shapes: Shape[];
  colour: string;
  stacked?: boolean; // the keyframe below the photo, where there is little room beside it
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
        left={{ src: query.photo, alt: "the photo", ...why.image }}
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
        The photo, and keyframe <KeyframeLink map={map} id={candidate.reference} /> with plane{" "}
        {candidate.plane}. Each line joins a point of the photo with the same point of the plane.
      </figcaption>
    </figure>
  );
}
