// SPDX-License-Identifier: Apache-2.0
// View: the named places, and a file of names to download. The server never writes: `waystone name`
// takes the file.
import { useEffect, useState } from "preact/hooks";
import {
  type AppearanceNode, get, type ImageRange, type Keyframe, mapPath, type NamesFile, type NamesFilePlace,
  type Overview,
} from "./api";
import type { ViewProps } from "./types";
import { Failure, Waiting } from "./parts";
import { useGet } from "./use";
import { counted } from "./words";

type Kind = "keyframes" | "nodes";
type Taken = Keyframe | AppearanceNode;

const kMaxBytes = 200; // of a name
const kNouns: Record<Kind, string> = { keyframes: "keyframe", nodes: "panorama" };

const load = (map: string, kind: Kind, id: number) =>
  get<Taken>(`${mapPath(map)}/${kind === "nodes" ? "appearance/nodes" : "keyframes"}/${id}`);

const imageOf = ({ source, frame }: Taken) => ({ image: source, frame });

// The range from one keyframe or panorama to another as names files have it. Throws for two of
// different sequences.
export function rangeOf(first: Taken, last: Taken): ImageRange {
  if (first.sequence !== last.sequence) {
    throw new Error(`${first.source} and ${last.source} are of different sequences; name them one after the other`);
  }
  const [a, b] = first.frame <= last.frame ? [first, last] : [last, first];
  return { sequence: a.sequence, first: imageOf(a), last: imageOf(b) };
}

// The places with `range` added to the one of this name, in the order of their names.
export function withRange(places: NamesFilePlace[], name: string, kind: Kind, range: ImageRange): NamesFilePlace[] {
  const empty: NamesFilePlace = { name, keyframes: [], nodes: [], planes: [], polygons: [] };
  const old = places.find((p) => p.name === name) ?? empty;
  const added = { ...old, [kind]: [...old[kind], range] };
  const all = [...places.filter((p) => p.name !== name), added];
  return all.sort((a, b) => (a.name < b.name ? -1 : 1));
}

export function problemOf(name: string): string | null {
  if (name === "") return "Enter a name.";
  if (new TextEncoder().encode(name).length > kMaxBytes) return `A name has at most ${kMaxBytes} bytes.`;
  if (/[\p{Cc}\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069]/u.test(name)) return "A name has no control characters.";
  return null;
}

const rangeInWords = ({ sequence, first, last }: ImageRange) =>
  first.image === last.image ? `${first.image} of ${sequence}` : `${first.image} to ${last.image} of ${sequence}`;

function heldInWords(place: NamesFilePlace): string {
  const parts = [...place.keyframes, ...place.nodes].map(rangeInWords);
  if (place.planes.length > 0) parts.push(counted(place.planes.length, "plane"));
  if (place.polygons.length > 0) parts.push(counted(place.polygons.length, "area"));
  return parts.join(", ");
}

function Places({ places, remove }: { places: NamesFilePlace[]; remove: (name: string) => void }) {
  if (places.length === 0) return <p class="missing">No place has a name yet.</p>;
  return (
    <div class="scroll" tabIndex={0} role="region" aria-label="Named places">
      <table class="names">
        <thead><tr><th>Name</th><th>Images</th><th>Remove</th></tr></thead>
        <tbody>
          {places.map((place) => (
            <tr key={place.name}>
              <td>{place.name}</td>
              <td>{heldInWords(place)}</td>
              <td><button onClick={() => remove(place.name)} aria-label={`Remove ${place.name}`}>Remove</button></td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

function Composer(props: { map: string; kinds: Kind[]; add: (name: string, kind: Kind, range: ImageRange) => void }) {
  const { map, kinds, add } = props;
  const [kind, setKind] = useState<Kind>(kinds[0]);
  const [error, setError] = useState<string | null>(null);
  const submit = async (event: Event) => {
    event.preventDefault();
    const form = event.target as HTMLFormElement;
    const field = (name: string) => (form.elements.namedItem(name) as HTMLInputElement).value.trim();
    const name = field("name");
    const problem = problemOf(name);
    setError(problem);
    if (problem) return;
    try {
      const [first, last] = await Promise.all(
        [field("first"), field("last") || field("first")].map((id) => load(map, kind, Number(id))));
      add(name, kind, rangeOf(first, last));
      form.reset();
    } catch (failure) {
      setError((failure as Error).message);
    }
  };
  return (
    <form class="composer" onSubmit={submit}>
      {kinds.length > 1 && (
        <label>
          Of <select value={kind} onChange={(e) => setKind((e.target as HTMLSelectElement).value as Kind)}>
            {kinds.map((k) => <option key={k} value={k}>{kNouns[k]}s</option>)}
          </select>
        </label>
      )}
      <label>First {kNouns[kind]} <input name="first" type="number" min="1" step="1" required /></label>
      <label>Last {kNouns[kind]} <input name="last" type="number" min="1" step="1" /></label>
      <label>Name <input name="name" type="text" autocomplete="off" required /></label>
      <button>Add</button>
      {error && <Failure error={error} />}
    </form>
  );
}

function Download({ map, file }: { map: string; file: NamesFile }) {
  const [address, setAddress] = useState<string | null>(null);
  useEffect(() => {
    const made = URL.createObjectURL(new Blob([`${JSON.stringify(file, null, 2)}\n`], { type: "application/json" }));
    setAddress(made);
    return () => URL.revokeObjectURL(made);
  }, [file]);
  return (
    <>
      <p><a class="button" href={address ?? "#"} download={`${map}-names.json`}>Download {map}-names.json</a></p>
      <p class="quiet">
        Then, where the map is: <code>waystone name {map}.db --from {map}-names.json</code>. Places that the file doesn’t
        have stay; <code>--remove NAME</code> removes one.
      </p>
    </>
  );
}

export function NamesView({ map }: ViewProps) {
  const overview = useGet<Overview>(`${mapPath(map.name)}/overview`);
  const stored = useGet<NamesFile>(`${mapPath(map.name)}/names`);
  const [edited, setEdited] = useState<NamesFilePlace[] | null>(null);
  const error = overview.error ?? stored.error;
  if (error) return <Failure error={error} />;
  if (!overview.value || !stored.value) return <Waiting what="the names" />;
  const places = edited ?? stored.value.places;
  const all: Kind[] = ["keyframes", "nodes"];
  const has = { keyframes: map.keyframes > 0, nodes: overview.value.layers.includes("appearance") };
  return (
    <>
      <h1>Named places</h1>
      <p class="quiet">Answers carry the name of the place where a photo was taken.</p>
      <Places places={places} remove={(name) => setEdited(places.filter((p) => p.name !== name))} />
      <h2>Name another</h2>
      <Composer map={map.name} kinds={all.filter((k) => has[k])}
        add={(name, kind, range) => setEdited(withRange(places, name, kind, range))} />
      {edited && <Download map={map.name} file={{ ...stored.value, places }} />}
    </>
  );
}
