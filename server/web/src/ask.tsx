// SPDX-License-Identifier: Apache-2.0
// View: localize a photo.
import { useEffect, useState } from "preact/hooks";
import { type Answer, type ExplainedKeyframe, localize, mapPath } from "./api";
import { colourOf } from "./colours";
import { readOrientation, uprightAnswer } from "./exif";
import { Overlay, type Shape } from "./figure";
import { MatchFigure } from "./match_figure";
import type { Query, ViewProps } from "./types";
import { Facts, Failure, KeyframeLink, PlaneLink, PlaneLinks, Swatch } from "./parts";
import { planRows, poseRows } from "./pose_answer";
import { PoseFigure } from "./pose_map";
import { href } from "./route";
import { usePicture } from "./use";
import { counted, degrees, probabilityText, shellWord, verdictInWords } from "./words";

function curlLine(map: string): string {
  const address = shellWord(`${location.origin}${mapPath(map)}/localize`);
  return `curl --data-binary @photo.jpg -H 'Content-Type: image/jpeg' ${address}`;
}

function Curl({ map }: { map: string }) {
  const [copied, setCopied] = useState(false);
  const line = curlLine(map);
  const copy = () =>
    navigator.clipboard?.writeText(line).then(() => setCopied(true), () => setCopied(false));
  return (
    <section class="curl">
      <h2>From the command line</h2>
      <pre tabIndex={0} aria-label="curl command">{line}</pre>
      {navigator.clipboard && <button onClick={copy}>{copied ? "Copied" : "Copy"}</button>}
    </section>
  );
}

function Chooser({ choose, busy }: { choose: (photo: File) => void; busy: boolean }) {
  const [over, setOver] = useState(false);
  const take = (event: Event) => {
    const input = event.target as HTMLInputElement;
    if (input.files?.[0]) choose(input.files[0]);
    input.value = "";
  };
  const drop = (event: DragEvent) => {
    event.preventDefault();
    setOver(false);
    const file = event.dataTransfer?.files[0];
    if (file) choose(file);
  };
  const drag = (event: DragEvent) => {
    event.preventDefault();
    setOver(true);
  };
  return (
    <div
      class={over ? "chooser over" : "chooser"}
      onDragOver={drag}
      onDragLeave={() => setOver(false)}
      onDrop={drop}
    >
      <p>{busy ? "Localizing …" : "Drop a photo here or"}</p>
      <label class="button">
        <input type="file" accept="image/*" onChange={take} />
        Choose a photo
      </label>
      <label class="button camera">
        <input type="file" accept="image/*" capture="environment" onChange={take} />
        Take a photo
      </label>
    </div>
  );
}

const kMostPlaces = 5; // panoramas that are listed

const kStages = ["decode", "extract", "shortlist", "verify"] as const;

function Timing({ answer }: { answer: Answer }) {
  const parts = kStages.map((stage) => `${stage} ${answer.timing_ms[stage].toFixed(1)}`);
  return <>{answer.timing_ms.total.toFixed(1)} ms <small>({parts.join(", ")})</small></>;
}

// The pose of a query panorama in the frame of the appearance layer.
function PanoramaNumbers({ map, answer }: { map: string; answer: Answer }) {
  const { node, position } = answer.panorama!;
  const unit = position?.metres_per_unit === null ? " map units" : "";
  const heading = answer.heading as { rad: number } | null;
  return (
    <Facts
      rows={[
        ["Probability", probabilityText(answer.probability)],
        ["Nearest panorama", node
          ? <><a href={href(map, "layers", node.id)}>{node.id}</a> <small>{node.source}</small></>
          : "–"],
        ["Position", position
          ? `${position.x.toFixed(1)}, ${position.y.toFixed(1)} ± ${position.deviation.toFixed(1)}${unit}`
          : "–"],
        ["Heading", heading ? degrees(heading.rad) : "–"],
        ...planRows(answer),
        ["Time", <Timing answer={answer} />],
      ]}
    />
  );
}

// The query panorama above the nearest one of the map.
function PanoramaFound({ map, query }: { map: string; query: Query }) {
  const node = query.answer.panorama?.node;
  const nearest = usePicture(node ? `${mapPath(map)}/appearance/nodes/${node.id}/image` : null);
  return (
    <div class="panoramas">
      <img src={query.photo} alt="query image" />
      {nearest && <img class="small" src={nearest} alt={`mapped panorama ${node!.id}`} />}
    </div>
  );
}

function Numbers({ map, answer }: { map: string; answer: Answer }) {
  const runnerUp = answer.runner_up;
  if (answer.panorama) return <PanoramaNumbers map={map} answer={answer} />;
  return (
    <Facts
      rows={[
        ["Probability", answer.verdict === "bad_image" ? "–" : probabilityText(answer.probability)],
        ["Nearest keyframe", answer.keyframe
          ? <><KeyframeLink map={map} id={answer.keyframe.id} /> <small>{answer.keyframe.source}</small></>
          : "–"],
        ["Runner-up", runnerUp
          ? <>keyframe <KeyframeLink map={map} id={runnerUp.keyframe.id} />, {probabilityText(runnerUp.probability)}</>
          : "none"],
        ...poseRows(answer),
        ...planRows(answer),
        ["Time", <Timing answer={answer} />],
      ]}
    />
  );
}

// The places that an ambiguous answer can't decide between.
function Candidates({ map, answer }: { map: string; answer: Answer }) {
  const places = answer.places ?? [];
  if (answer.panorama && places.length === 0) {
    return (
      <ul>
        {answer.panorama.candidates.slice(0, kMostPlaces).map(({ node, probability }) => (
          <li key={node.id}>
            panorama {node.id}, {node.source} of sequence {node.sequence}, probability {probabilityText(probability)}
          </li>
        ))}
      </ul>
    );
  }
  return (
    <ul>
      {places.map((place) => (
        <li key={place.keyframe.id}>
          keyframe <KeyframeLink map={map} id={place.keyframe.id} />, {place.inliers} inliers
        </li>
      ))}
    </ul>
  );
}

function Verdict({ map, query }: { map: string; query: Query }) {
  const { answer } = query;
  const near = answer.keyframe ?? answer.panorama?.node;
  return (
    <div class={`verdict ${answer.verdict}`} role="status">
      <h2>{verdictInWords(answer)}</h2>
      <p>
        {answer.verdict === "localized"
          ? <>{answer.place?.name && <><strong>{answer.place.name}</strong>: </>}{near?.source} of sequence {near?.sequence}, probability {probabilityText(answer.probability)}.</>
          : answer.message}{" "}
        {answer.explanation && answer.verdict !== "bad_image" && <a href={href(map, "why")}>Why?</a>}
      </p>
      {answer.verdict === "ambiguous" && <Candidates map={map} answer={answer} />}
    </div>
  );
}

function Planes(props: {
  map: string;
  answer: Answer;
  selected: number;
  select: (id: number) => void;
}) {
  return (
    <div class="scroll" tabIndex={0} role="region" aria-label="Recognised planes">
      <table>
        <caption>Recognised planes; select one to see its inliers</caption>
        <thead>
          <tr>
            <th>Show</th><th>Plane</th><th class="number">Inliers</th><th>Reference keyframe</th><th>Neighbours</th>
          </tr>
        </thead>
        <tbody>
          {props.answer.planes.map((plane, i) => (
            <tr key={plane.id} class={plane.id === props.selected ? "selected" : ""}>
              <td>
                <input
                  type="radio"
                  name="plane"
                  aria-label={`show plane ${plane.id}`}
                  checked={plane.id === props.selected}
                  onChange={() => props.select(plane.id)}
                />
              </td>
              <td><Swatch colour={colourOf(i)} /><PlaneLink map={props.map} id={plane.id} /></td>
              <td class="number">{plane.inliers}</td>
              <td><KeyframeLink map={props.map} id={plane.reference.id} /></td>
              <td><PlaneLinks map={props.map} ids={plane.expect_next.slice(0, 6)} /></td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

function Found({ map, query }: { map: string; query: Query }) {
  const { answer } = query;
  if (answer.panorama) return <PanoramaFound map={map} query={query} />;
  return <PlanesFound map={map} query={query} />;
}

function PlanesFound({ map, query }: { map: string; query: Query }) {
  const { answer } = query;
  const [selected, setSelected] = useState(answer.planes[0]?.id ?? 0);
  useEffect(() => setSelected(answer.planes[0]?.id ?? 0), [answer]);
  const why = answer.explanation;
  if (!why) return null;
  const shapes: Shape[] = answer.planes.map((plane, i) => ({
    points: plane.outline,
    colour: colourOf(i),
    label: `${plane.id}`,
    faint: plane.id !== selected,
  }));
  const candidate = why.candidates.find((c) => c.plane === selected);
  const matched = why.keyframes.find((k) => k.keyframe === answer.epipolar?.keyframe.id);
  if (!candidate && matched) return <LandmarksFound map={map} query={query} matched={matched} />;
  if (!candidate) {
    const picture = { src: query.photo, alt: "query image", orientation: query.orientation, ...why.image };
    return <Overlay picture={picture} shapes={[]} />;
  }
  const index = answer.planes.findIndex((p) => p.id === selected);
  return (
    <>
      <MatchFigure
        map={map}
        query={query}
        candidate={candidate}
        shapes={shapes}
        colour={colourOf(index)}
      />
      <Planes map={map} answer={answer} selected={selected} select={setSelected} />
    </>
  );
}

// Of a place that no plane shows: all matches with its keyframe.
function LandmarksFound(props: { map: string; query: Query; matched: ExplainedKeyframe }) {
  const { map, query, matched } = props;
  return (
    <>
      <MatchFigure
        map={map}
        query={query}
        candidate={{ reference: matched.keyframe, points: matched.points }}
        shapes={[]}
        colour={colourOf(0)}
      />
      <p>
        No plane was recognised: the place was found by {counted(matched.inliers, "inlier")} of a single
        epipolar geometry, out of {matched.expected} features that the query image should show.
      </p>
    </>
  );
}

let chosen = 0; // photos so far: the answer to the last one is shown, whichever arrives last

export function AskView({ map, query, setQuery }: ViewProps) {
  const [busy, setBusy] = useState(false);
  const [error, setError] = useState<string | null>(null);
  const choose = async (photo: File) => {
    const number = ++chosen;
    const settle = (show: () => void) => {
      if (number !== chosen) return;
      show();
      setBusy(false);
    };
    setBusy(true);
    setError(null);
    setQuery(null); // the answer of another photo would look like this one's
    try {
      const orientation = await readOrientation(photo);
      const answer = uprightAnswer(await localize(map.name, photo), orientation);
      settle(() => setQuery({ map: map.name, photo: URL.createObjectURL(photo), orientation, name: photo.name, answer }));
    } catch (e) {
      settle(() => setError((e as Error).message));
    }
  };
  return (
    <>
      <h1>Where was this photo taken?</h1>
      <Chooser choose={choose} busy={busy} />
      {error && <Failure error={error} />}
      {query && (
        <section class="answer" aria-label={`Answer for ${query.name}`}>
          <Verdict map={map.name} query={query} />
          <Found map={map.name} query={query} />
          <Numbers map={map.name} answer={query.answer} />
          {query.answer.pose && <PoseFigure map={map.name} answer={query.answer} />}
        </section>
      )}
      {!query && (
        <p class="quiet">
          {map.keyframes > 0
            ? `The photo is matched against ${map.planes.toLocaleString("en")} mapped planes (flat surfaces such
              as walls and posters) and the features of ${map.keyframes.toLocaleString("en")} keyframes.`
            : "This map contains panoramas: choose an equirectangular image, twice as wide as it is high."}{" "}
          It is sent to this server only, which doesn’t store it unless its query log is enabled.
        </p>
      )}
      <Curl map={map.name} />
    </>
  );
}
