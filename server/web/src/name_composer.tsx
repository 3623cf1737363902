// SPDX-License-Identifier: Apache-2.0
// What a named place is made of, chosen by people: ranges of images, planes, and areas.
import { useState } from "preact/hooks";
import {
  type AppearanceNode, type FloorPlans, get, type ImageRange, imagePath, type Keyframe, mapPath, type MapSummary,
  type NamedArea, type NamesFilePlace, type Plane, type PlaneInImage,
} from "./api";
import { colourOf } from "./colours";
import { Overlay } from "./figure";
import { Failure, Waiting } from "./parts";
import { areaOf, pointInside } from "./pose_view";
import { useGet } from "./use";
import { cornersIn, idsIn, withoutLast } from "./words";

// As the lists of a place in names files are called.
export type Kind = "keyframes" | "nodes" | "planes" | "polygons";
type Taken = Keyframe | AppearanceNode;
type Part = ImageRange | PlaneInImage | NamedArea;

export const kNouns: Record<Kind, string> = {
  keyframes: "keyframe", nodes: "panorama", planes: "plane", polygons: "area",
};

const kMaxBytes = 200; // of a name
const kPreviews = 6; // planes that are shown

const imageOf = ({ source, frame }: Taken) => ({ image: source, frame });

// The sequence of an image as names files have it: by its name, and which of that name it is unless the first.
function sequenceRef({ sequences }: MapSummary, { sequence, sequence_id }: Taken) {
  const number = 1 + sequences.filter((s) => s.name === sequence).findIndex((s) => s.id === sequence_id);
  return { sequence, ...(number > 1 && { sequence_number: number }) };
}

// The range from one keyframe or panorama to another as names files have it. Throws for two of
// different sequences.
function rangeOf(map: MapSummary, first: Taken, last: Taken): ImageRange {
  if (first.sequence_id !== last.sequence_id) {
    throw new Error(`${first.source} and ${last.source} belong to different sequences; add them one after the other`);
  }
  const [a, b] = first.frame <= last.frame ? [first, last] : [last, first];
  return { ...sequenceRef(map, a), first: imageOf(a), last: imageOf(b) };
}

// A plane by a pixel of its reference image that shows it.
function planeInImage(map: MapSummary, { id, outline }: Plane, keyframe: Keyframe): PlaneInImage {
  if (outline.length === 0) throw new Error(`Plane ${id} has no outline; name keyframes that show it.`);
  const rounded = (value: number) => Math.round(100 * value) / 100;
  const [x, y] = pointInside(outline);
  return { ...sequenceRef(map, keyframe), ...imageOf(keyframe), at_px: [rounded(x), rounded(y)] };
}

// The places with a part added to the one of this name, in the order of their names.
function withPart(places: NamesFilePlace[], name: string, kind: Kind, part: Part): NamesFilePlace[] {
  const empty: NamesFilePlace = { name, keyframes: [], nodes: [], planes: [], polygons: [] };
  const old = places.find((p) => p.name === name) ?? empty;
  const added = { ...old, [kind]: [...old[kind], part] };
  const all = [...places.filter((p) => p.name !== name), added];
  return all.sort((a, b) => (a.name < b.name ? -1 : 1));
}

function problemOf(name: string): string | null {
  if (name === "") return "Enter a name.";
  if (new TextEncoder().encode(name).length > kMaxBytes) return `A name may have at most ${kMaxBytes} bytes.`;
  if (/[\p{Cc}\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069]/u.test(name)) return "A name must not contain control characters.";
  return null;
}

const load = (map: MapSummary, kind: Kind, id: number) =>
  get<Taken>(`${mapPath(map.name)}/${kind === "nodes" ? "appearance/nodes" : "keyframes"}/${id}`);

async function loadPlane(map: MapSummary, id: number): Promise<PlaneInImage> {
  const plane = await get<Plane>(`${mapPath(map.name)}/planes/${id}`);
  return planeInImage(map, plane, (await load(map, "keyframes", plane.reference.id)) as Keyframe);
}

function planeParts(map: MapSummary, text: string, known: number[]): Promise<PlaneInImage[]> {
  const ids = idsIn(text);
  if (!ids?.length) throw new Error("Enter plane ids, such as 3, 5.");
  const unknown = ids.find((id) => !known.includes(id));
  if (unknown !== undefined) throw new Error(`The map has no plane ${unknown}.`);
  return Promise.all(ids.map((id) => loadPlane(map, id)));
}

function areaPart(text: string, { plans: _, ...frame }: FloorPlans): NamedArea {
  const corners = cornersIn(text);
  if (!corners) throw new Error("Enter corners as x,y, separated by spaces, such as 0,0 4.5,0 4.5,3.");
  if (corners.length < 3) throw new Error("An area needs at least three corners.");
  if (!(areaOf(corners) > 0)) throw new Error("The corners lie on one line.");
  return { ...frame, corners };
}

function PlanePreview({ map, id, colour }: { map: string; id: number; colour: string }) {
  const plane = useGet<Plane>(`${mapPath(map)}/planes/${id}`);
  const reference = plane.value?.reference.id;
  const keyframe = useGet<Keyframe>(reference ? `${mapPath(map)}/keyframes/${reference}` : null);
  const error = plane.error ?? keyframe.error;
  if (error) return <Failure error={error} />;
  if (!plane.value || !keyframe.value) return <Waiting what={`plane ${id}`} />;
  const { width, height, image } = keyframe.value;
  const src = image && imagePath(map, keyframe.value.id);
  return (
    <Overlay picture={{ src, alt: `plane ${id} in keyframe ${reference}`, width, height }}
      shapes={[{ points: plane.value.outline, colour, label: `${id}` }]} />
  );
}

// The chosen planes in their reference images.
export function PlanePreviews({ map, ids }: { map: string; ids: number[] }) {
  if (ids.length === 0) return null;
  return (
    <ul class="grid" aria-label="Chosen planes">
      {ids.slice(0, kPreviews).map((id, i) => <li key={id}><PlanePreview map={map} id={id} colour={colourOf(i)} /></li>)}
      {ids.length > kPreviews && <li class="quiet">and {ids.length - kPreviews} more</li>}
    </ul>
  );
}

// What is being composed, beside the name.
export interface Draft {
  kind: Kind;
  planes: string; // ids
  corners: string;
}

export function Composer(props: {
  map: MapSummary;
  kinds: Kind[];
  planes: number[]; // that the map has
  plans: FloorPlans; // for their frame
  places: NamesFilePlace[];
  draft: Draft;
  setDraft: (draft: Draft) => void;
  setPlaces: (places: NamesFilePlace[]) => void;
}) {
  const { map, kinds, draft, setDraft } = props;
  const { kind } = draft;
  const [error, setError] = useState<string | null>(null);
  const put = (part: Partial<Draft>) => setDraft({ ...draft, ...part });
  const partsOf = async (field: (name: string) => string): Promise<Part[]> => {
    if (kind === "planes") return planeParts(map, draft.planes, props.planes);
    if (kind === "polygons") return [areaPart(draft.corners, props.plans)];
    const [first, last] = await Promise.all(
      [field("first"), field("last") || field("first")].map((id) => load(map, kind, Number(id))));
    return [rangeOf(map, first, last)];
  };
  const submit = async (event: Event) => {
    event.preventDefault();
    const form = event.target as HTMLFormElement;
    const field = (name: string) => (form.elements.namedItem(name) as HTMLInputElement).value.trim();
    const name = field("name");
    const problem = problemOf(name);
    setError(problem);
    if (problem) return;
    try {
      const parts = await partsOf(field);
      props.setPlaces(parts.reduce((places, part) => withPart(places, name, kind, part), props.places));
      form.reset();
      put({ planes: "", corners: "" });
    } catch (failure) {
      setError((failure as Error).message);
    }
  };
  return (
    <form class="composer" onSubmit={submit}>
      {kinds.length > 1 && (
        <label>
          Of <select value={kind} onChange={(e) => put({ kind: (e.target as HTMLSelectElement).value as Kind })}>
            {kinds.map((k) => <option key={k} value={k}>{kNouns[k]}s</option>)}
          </select>
        </label>
      )}
      {kind === "planes" && (
        <label>Planes <input name="planes" type="text" autocomplete="off" required placeholder="3, 5" value={draft.planes}
          onInput={(e) => put({ planes: (e.target as HTMLInputElement).value })} /></label>
      )}
      {kind === "polygons" && (
        <>
          <label class="long">Corners <input name="corners" type="text" autocomplete="off" required
            placeholder="0,0 4.5,0 4.5,3" value={draft.corners}
            onInput={(e) => put({ corners: (e.target as HTMLInputElement).value })} /></label>
          <button type="button" disabled={draft.corners.trim() === ""}
            onClick={() => put({ corners: withoutLast(draft.corners) })}>Undo last corner</button>
          <button type="button" disabled={draft.corners === ""} onClick={() => put({ corners: "" })}>Clear</button>
        </>
      )}
      {(kind === "keyframes" || kind === "nodes") && (
        <>
          <label>First {kNouns[kind]} <input name="first" type="number" min="1" step="1" required /></label>
          <label>Last {kNouns[kind]} <input name="last" type="number" min="1" step="1" /></label>
        </>
      )}
      <label>Name <input name="name" type="text" autocomplete="off" required /></label>
      <button>Add</button>
      {error && <Failure error={error} />}
    </form>
  );
}
