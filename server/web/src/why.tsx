// SPDX-License-Identifier: Apache-2.0
// View: the outcome of each candidate plane, and the gate that rejected it.
import { useState } from "preact/hooks";
import type { Candidate, Explanation } from "./api";
import { colourOf } from "./colours";
import { MatchFigure } from "./match_figure";
import type { Query, ViewProps } from "./types";
import { Facts, KeyframeLink, PlaneLink, PlaneLinks } from "./parts";
import { href } from "./route";
import { counted, decisionInWords, outcomeOf, percent, probabilityText, verdictInWords } from "./words";

// How many passed each stage, most first.
function Stages({ why }: { why: Explanation }) {
  const tried = why.candidates.filter((c) => c.stopped_by !== "settled");
  const fitted = tried.filter((c) => c.stopped_by !== "no_homography");
  const passed = why.candidates.filter((c) => c.stopped_by === null);
  const stages: [string, string][] = [
    [counted(why.image.features, "feature"), "in the query image"],
    [counted(why.candidates.length, "plane"), "shortlisted"],
    [counted(tried.length, "plane"), "verified"],
    [counted(fitted.length, "plane"), "with a homography"],
    [counted(passed.length, "plane"), "accepted"],
    [counted(why.places.length, "place"), "found"],
  ];
  return (
    <ol class="stages">
      {stages.map(([count, what]) => (
        <li key={what}><strong>{count}</strong> <span>{what}</span></li>
      ))}
    </ol>
  );
}

function Places({ map, why }: { map: string; why: Explanation }) {
  if (why.places.length === 0) return null;
  return (
    <div class="scroll" tabIndex={0} role="region" aria-label="Places">
      <table>
        <caption>
          Places: groups of planes that agree on one position. The best place must have a
          probability of at least {percent(why.gates.min_probability)}.
        </caption>
        <thead>
          <tr>
            <th class="number">Place</th><th>Keyframe</th><th>Planes</th>
            <th class="number">Inliers</th><th class="number wide">Best inlier ratio</th>
            <th class="number">Probability</th>
          </tr>
        </thead>
        <tbody>
          {why.places.map((place, i) => (
            <tr key={i}>
              <td class="number">{i + 1}</td>
              <td><KeyframeLink map={map} id={place.keyframe} /></td>
              <td><PlaneLinks map={map} ids={place.planes} /></td>
              <td class="number">{place.inliers}</td>
              <td class="number wide">{percent(place.best_share)}</td>
              <td class="number">{probabilityText(place.probability)}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

// Keyframes verified by all their features, on planes and beside them.
function Keyframes(props: {
  map: string;
  why: Explanation;
  selected: number | null;
  select: (keyframe: number) => void;
}) {
  if (props.why.keyframes.length === 0) return null;
  return (
    <div class="scroll" tabIndex={0} role="region" aria-label="Keyframes">
      <table>
        <caption>
          Keyframes, verified by all matches under one epipolar geometry. Expected is the number of
          features of the keyframe that, according to the inliers, lie inside the query image: if
          few of them are found, the place merely looks similar. A corner gives several features,
          which count as one independent inlier; a few independent inliers may fit by chance.
          Coverage is the share of the query image near an inlier.
        </caption>
        <thead>
          <tr>
            <th>Show</th><th>Keyframe</th><th class="number wide">Matches</th>
            <th class="number">Distinct inliers</th><th class="number">Independent</th>
            <th class="number">Expected</th>
            <th class="number wide">Coverage</th><th class="number">Place</th>
          </tr>
        </thead>
        <tbody>
          {props.why.keyframes.map((k) => (
            <tr key={k.keyframe} class={k.keyframe === props.selected ? "selected" : ""}>
              <td>
                <input
                  type="radio"
                  name="candidate"
                  aria-label={`show keyframe ${k.keyframe}`}
                  checked={k.keyframe === props.selected}
                  onChange={() => props.select(k.keyframe)}
                />
              </td>
              <td><KeyframeLink map={props.map} id={k.keyframe} /></td>
              <td class="number wide">{k.matches}</td>
              <td class="number">{k.inliers}</td>
              <td class="number">{k.independent}</td>
              <td class="number">{k.expected}</td>
              <td class="number wide">{percent(k.coverage)}</td>
              <td class="number">{k.place === null ? "–" : k.place + 1}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

function Row(props: {
  map: string;
  candidate: Candidate;
  why: Explanation;
  selected: boolean;
  select: () => void;
}) {
  const { candidate: c, why } = props;
  const { outcome, help } = outcomeOf(c, why);
  return (
    <tr class={props.selected ? "selected" : ""}>
      <td>
        {c.points.length > 0 && (
          <input
            type="radio"
            name="candidate"
            aria-label={`show plane ${c.plane}`}
            checked={props.selected}
            onChange={props.select}
          />
        )}
      </td>
      <td><PlaneLink map={props.map} id={c.plane} /></td>
      <td class="number wide">{c.votes}</td>
      <td class="number wide">{c.matches || "–"}</td>
      <td class="number">{c.matches ? c.inliers : "–"}</td>
      <td class={c.stopped_by === null ? "outcome good" : "outcome"}>
        {outcome}{help && <small>{help}</small>}
      </td>
    </tr>
  );
}

function Candidates(props: {
  map: string;
  why: Explanation;
  selected: number | null;
  select: (plane: number) => void;
}) {
  return (
    <div class="scroll" tabIndex={0} role="region" aria-label="Candidates">
      <table>
        <caption>
          Candidate planes, most votes first. Each feature of the query image votes for the planes
          with the most similar features. Inliers close to each other count once. Select a plane to
          see its inliers.
        </caption>
        <thead>
          <tr>
            <th>Show</th><th>Plane</th><th class="number wide">Votes</th>
            <th class="number wide">Matches</th>
            <th class="number">Distinct inliers</th><th>Outcome</th>
          </tr>
        </thead>
        <tbody>
          {props.why.candidates.map((c) => (
            <Row
              key={c.plane}
              map={props.map}
              candidate={c}
              why={props.why}
              selected={c.plane === props.selected}
              select={() => props.select(c.plane)}
            />
          ))}
        </tbody>
      </table>
    </div>
  );
}

function Explained({ map, query, why }: { map: string; query: Query; why: Explanation }) {
  const shown = why.candidates.reduce<Candidate | null>(
    (best, c) => (c.points.length > (best?.points.length ?? 0) ? c : best),
    null,
  );
  const [plane, setPlane] = useState<number | null>(shown?.plane ?? null);
  const [keyframe, setKeyframe] = useState<number | null>(
    shown ? null : why.keyframes[0]?.keyframe ?? null,
  );
  const candidate = why.candidates.find((c) => c.plane === plane);
  const whole = why.keyframes.find((k) => k.keyframe === keyframe);
  const matched = whole ? { reference: whole.keyframe, points: whole.points } : candidate;
  const good = whole ? whole.place !== null : candidate?.stopped_by === null;
  const selectPlane = (id: number) => {
    setPlane(id);
    setKeyframe(null);
  };
  const selectKeyframe = (id: number) => {
    setPlane(null);
    setKeyframe(id);
  };
  return (
    <>
      <Stages why={why} />
      <div class="split">
        <div>
          <Candidates map={map} why={why} selected={plane} select={selectPlane} />
          <Keyframes map={map} why={why} selected={keyframe} select={selectKeyframe} />
          <Places map={map} why={why} />
        </div>
        {matched && (
          <MatchFigure
            map={map}
            query={query}
            candidate={matched}
            shapes={[]}
            colour={colourOf(good ? 0 : 1)}
            stacked
          />
        )}
      </div>
    </>
  );
}

export function WhyView({ map, query }: ViewProps) {
  const why = query?.answer.explanation;
  if (!query) {
    return (
      <>
        <h1>Why this answer?</h1>
        <p>
          <a href={href(map.name, "ask")}>Localize a photo</a> first. This view then shows every
          candidate plane and the gate that rejected it.
        </p>
      </>
    );
  }
  const { answer } = query;
  return (
    <>
      <h1>Why this answer?</h1>
      <div class={`verdict ${answer.verdict}`}>
        <h2>{query.name}: {verdictInWords(answer)}</h2>
        <p>{decisionInWords(answer)}{answer.message && ` Message: ${answer.message}.`}</p>
      </div>
      {why && <Explained map={map.name} query={query} why={why} />}
      {answer.verdict !== "localized" && <Advice answer={answer} />}
    </>
  );
}

function Advice({ answer }: { answer: Query["answer"] }) {
  const general: [string, string][] = [
    ["If the place is mapped", "Take a sharp photo of more textured flat surfaces, from a distance similar to the map’s, or add a sequence through this place to the map."],
    ["If it isn’t", "The answer is correct."],
  ];
  return (
    <section>
      <h2>How to improve it</h2>
      {answer.verdict === "ambiguous"
        ? <p>Take a photo from a few steps to the side that includes something unique to one of the places.</p>
        : <Facts rows={general} />}
    </section>
  );
}
