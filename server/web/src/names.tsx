// SPDX-License-Identifier: Apache-2.0
// View: the named places, and a file of names to download. The server never writes: `waystone name`
// takes the file.
import { useEffect, useState } from "preact/hooks";
import {
  type Appearance, type FloorPlans, type ImageRange, mapPath, type NamesFile, type NamesFilePlace, type Overview,
  type PoseLayer,
} from "./api";
import { colourOf } from "./colours";
import { Composer, type Draft, type Kind, kNouns, PlanePreviews } from "./name_composer";
import type { ViewProps } from "./types";
import { Failure, Waiting } from "./parts";
import { areasOf, type Compose, PlanChooser, PoseMap, usePlan } from "./pose_map";
import { asPoseLayer, holds, seen, type Vec2, viewFromAbove } from "./pose_view";
import { useGet } from "./use";
import { cornersIn, cornerText, counted, idsIn, shellWord } from "./words";

function rangeInWords({ sequence, sequence_number: number, first, last }: ImageRange): string {
  const images = first.image === last.image ? first.image : `${first.image} to ${last.image}`;
  return `${images} of ${sequence}${number ? ` number ${number}` : ""}`;
}

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
        <thead><tr><th>Name</th><th>Consists of</th><th>Remove</th></tr></thead>
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

function Download({ map, file }: { map: string; file: NamesFile }) {
  const [address, setAddress] = useState<string | null>(null);
  useEffect(() => {
    const made = URL.createObjectURL(new Blob([`${JSON.stringify(file, null, 2)}\n`], { type: "application/json" }));
    setAddress(made);
    return () => URL.revokeObjectURL(made);
  }, [file]);
  const name = `${map}-names.json`;
  return (
    <>
      <p><a class="button" href={address ?? "#"} download={name}>Download {name}</a></p>
      <p class="quiet">
        Then, on the machine with the map: <code>waystone name {shellWord(`${map}.db`)} --from {shellWord(name)}</code>. Places
        that aren’t in the file are kept; <code>--remove NAME</code> removes one.
      </p>
    </>
  );
}

const kHelp: Partial<Record<Kind, string>> = {
  planes: "Click on planes to choose them, or enter their ids.",
  polygons: "Click on the corners of the area in order, or enter them.",
};

// The map from above, where planes and corners are chosen.
function AboveFigure(props: {
  map: string;
  layer: PoseLayer;
  posed: boolean; // else panoramas are drawn
  overview: Overview;
  plans: FloorPlans;
  places: NamesFilePlace[];
  draft: Draft;
  setDraft: (draft: Draft) => void;
}) {
  const { layer, posed, plans, draft, setDraft } = props;
  const { plan, choose } = usePlan(plans.plans);
  const corners = (draft.kind === "polygons" && cornersIn(draft.corners)) || [];
  const chosen = (draft.kind === "planes" && idsIn(draft.planes)) || [];
  const noun = posed ? "keyframe" : "panorama";
  const addCorner = (corner: Vec2, px_per_unit: number) =>
    setDraft({ ...draft, corners: `${draft.corners} ${cornerText(corner, px_per_unit)}`.trim() });
  const choosePlane = (id: number) => {
    const ids = chosen.includes(id) ? chosen.filter((c) => c !== id) : [...chosen, id];
    setDraft({ ...draft, planes: ids.join(", ") });
  };
  const compose: Compose = {
    corners,
    noun,
    addCorner: draft.kind === "polygons" ? addCorner : undefined,
    choosePlane: draft.kind === "planes" ? choosePlane : undefined,
  };
  const opens = posed && (draft.kind === "keyframes" || draft.kind === "nodes");
  const view = viewFromAbove(layer.up);
  const held = layer.keyframes.position.filter((p) => holds(corners, seen(view, p))).length;
  return (
    <figure>
      <PoseMap map={props.map} layer={layer} overview={posed ? props.overview : null} pose={null}
        colours={new Map(chosen.map((id, i) => [id, colourOf(i)]))} plan={plan} areas={areasOf(props.places)}
        compose={opens ? undefined : compose} />
      <PlanChooser plans={plans.plans} plan={plan} choose={choose} />
      <figcaption>
        {kHelp[draft.kind]} {corners.length > 2 && `The area contains ${counted(held, noun)}.`}
      </figcaption>
    </figure>
  );
}

// What was composed for a map stays while other views are shown.
const drafted = new Map<string, NamesFilePlace[]>();

function useLayer(map: string, layers: string[]) {
  const posed = layers.includes("poses");
  const poses = useGet<PoseLayer>(posed ? `${mapPath(map)}/poses` : null);
  const walked = !posed && layers.includes("appearance");
  const appearance = useGet<Appearance>(walked ? `${mapPath(map)}/appearance` : null);
  const layer = poses.value ?? (appearance.value && asPoseLayer(appearance.value));
  return { posed, layer, wanted: posed || walked, error: poses.error ?? appearance.error };
}

export function NamesView({ map, route }: ViewProps) {
  const overview = useGet<Overview>(`${mapPath(map.name)}/overview`);
  const stored = useGet<NamesFile>(`${mapPath(map.name)}/names`);
  const plans = useGet<FloorPlans>(`${mapPath(map.name)}/plan`);
  const { posed, layer, wanted, error: missing } = useLayer(map.name, overview.value?.layers ?? []);
  const [edited, setEdited] = useState<NamesFilePlace[] | null>(drafted.get(map.name) ?? null);
  const [draft, setDraft] = useState<Draft>(
    { kind: map.keyframes > 0 ? "keyframes" : "nodes", planes: "", corners: "" });
  useEffect(() => {
    if (route.id !== null) setDraft({ kind: "planes", planes: `${route.id}`, corners: "" });
  }, [route.id]);
  const error = overview.error ?? stored.error ?? plans.error ?? missing;
  if (error) return <Failure error={error} />;
  if (!overview.value || !stored.value || !plans.value || (wanted && !layer)) return <Waiting what="the names" />;
  const edit = (places: NamesFilePlace[]) => {
    drafted.set(map.name, places);
    setEdited(places);
  };
  const places = edited ?? stored.value.places;
  const has: Record<Kind, boolean> = {
    keyframes: map.keyframes > 0,
    nodes: overview.value.layers.includes("appearance"),
    planes: map.planes > 0,
    polygons: wanted,
  };
  const known = overview.value.planes.id;
  return (
    <>
      <h1>Named places</h1>
      <p class="quiet">Answers include the name of the place where a photo was taken.</p>
      <Places places={places} remove={(name) => edit(places.filter((p) => p.name !== name))} />
      <h2>Name another place</h2>
      <Composer map={map} kinds={(Object.keys(kNouns) as Kind[]).filter((k) => has[k])} planes={known}
        plans={plans.value} places={places} draft={draft} setDraft={setDraft} setPlaces={edit} />
      {draft.kind === "planes" &&
        <PlanePreviews map={map.name} ids={(idsIn(draft.planes) ?? []).filter((id) => known.includes(id))} />}
      {layer && layer.keyframes.id.length > 0 && (
        <AboveFigure map={map.name} layer={layer} posed={posed} overview={overview.value} plans={plans.value}
          places={places} draft={draft} setDraft={setDraft} />
      )}
      {edited && <Download map={map.name} file={{ ...stored.value, places }} />}
    </>
  );
}
