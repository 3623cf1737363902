// SPDX-License-Identifier: Apache-2.0
// View: what became of each plane that looked like the photo, and which gate stopped it.
import { useState } from "preact/hooks";
import type { Candidate, Explanation } from "./api";
import { colourOf } from "./colours";
import { MatchFigure } from "./match_figure";
import type { Query, ViewProps } from "./main";
import { Facts, KeyframeLink, PlaneLink, PlaneLinks } from "./parts";
import { href } from "./route";
import { counted, decisionInWords, outcomeOf, percent, sure, verdictInWords } from "./words";

// How many got through each stage, widest first.
function Stages({ why }: { why: Explanation }) {
  const tried = why.candidates.filter((c) => c.stopped_by !== "settled");
  const fitted = tried.filter((c) => c.stopped_by !== "no_homography");
  const passed = why.candidates.filter((c) => c.stopped_by === null);
  const stages: [string, string][] = [
    [counted(why.image.features, "feature"), "found in the photo"],
    [counted(why.candidates.length, "plane"), "of the map look alike"],
    [counted(tried.length, "plane"), "tried"],
    [counted(fitted.length, "plane"), "with a homography"],
    [counted(passed.length, "plane"), "through the gates"],
    [counted(why.places.length, "place"), "they agree on"],
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
          Places: planes that agree with each other. The best one needs{" "}
          {percent(why.gates.min_probability)}.
        </caption>
        <thead>
          <tr>
            <th class="number">Place</th><th>Keyframe</th><th>Planes</th>
            <th class="number">Inliers</th><th class="number wide">Best plane’s share</th>
            <th class="number">Sure</th>
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
              <td class="number">{sure(place.probability)}</td>
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
          Planes that look alike, most votes first: each feature of the photo votes for the planes
          with the most similar features. Inliers close to each other count once. Choose a plane to
          see its inliers.
        </caption>
        <thead>
          <tr>
            <th>Show</th><th>Plane</th><th class="number wide">Votes</th>
            <th class="number wide">Matches</th>
            <th class="number">Distinct inliers</th><th>What became of it</th>
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
  const [selected, setSelected] = useState<number | null>(shown?.plane ?? null);
  const candidate = why.candidates.find((c) => c.plane === selected);
  return (
    <>
      <Stages why={why} />
      <div class="split">
        <div>
          <Candidates map={map} why={why} selected={selected} select={setSelected} />
          <Places map={map} why={why} />
        </div>
        {candidate && (
          <MatchFigure
            map={map}
            query={query}
            candidate={candidate}
            shapes={[]}
            colour={colourOf(candidate.stopped_by === null ? 0 : 1)}
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
          Ask about a photo first: <a href={href(map.name, "ask")}>choose one</a>. Then this view
          shows every plane that looked like it, and which gate stopped it.
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
        <p>{decisionInWords(answer)}{answer.message && ` The server says: ${answer.message}.`}</p>
      </div>
      {why && <Explained map={map.name} query={query} why={why} />}
      {answer.verdict !== "localized" && <Advice answer={answer} />}
    </>
  );
}

function Advice({ answer }: { answer: Query["answer"] }) {
  const general: [string, string][] = [
    ["The place is in the map", "Show more flat things with texture, sharp and from a distance like the map’s; or add a sequence through this place to the map."],
    ["It isn’t", "Then this is the right answer."],
  ];
  return (
    <section>
      <h2>What would help</h2>
      {answer.verdict === "ambiguous"
        ? <p>Take a photo from a few steps aside, with something in it that only one of the places has.</p>
        : <Facts rows={general} />}
    </section>
  );
}
