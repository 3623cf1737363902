// SPDX-License-Identifier: Apache-2.0
// View: where the map is weak, and how to improve it.
import { useMemo } from "preact/hooks";
import { type Audit, mapPath, type MapSummary, type Overview } from "./api";
import type { ViewProps } from "./types";
import { Failure, GoTo, KeyframeLink, PlaneLink, Thumbnail, Waiting } from "./parts";
import { href } from "./route";
import { Series } from "./series";
import { useGet } from "./use";
import { counted, percent } from "./words";

type Weak = Audit["weak"][number];

function causeOf(run: Weak): string {
  switch (run.weakness) {
    case "no_plane":
      return "no plane in view";
    case "few_features":
      return `only ${counted(run.features, "feature")} in view`;
    default:
      return `isolated stretch with only ${counted(run.planes, "plane")}`;
  }
}

function WeakRuns({ map, audit }: { map: MapSummary; audit: Audit }) {
  return (
    <section>
      <h2>Weak keyframes ({audit.weak.length})</h2>
      {audit.weak.length === 0 && <p>Every keyframe has enough features for localization.</p>}
      <ul class="findings">
        {audit.weak.map((run) => (
          <li key={run.first.id}>
            <Thumbnail map={map} id={run.first.id} />
            <div>
              <strong>
                Keyframe <KeyframeLink map={map.name} id={run.first.id} />
                {run.keyframes > 1 && <> to <KeyframeLink map={map.name} id={run.last.id} /></>}
              </strong>
              : {causeOf(run)}, {counted(run.keyframes, "keyframe")}
              <p>{sentence(run.advice)}</p>
            </div>
          </li>
        ))}
      </ul>
    </section>
  );
}

const sentence = (text: string) => `${text[0].toUpperCase()}${text.slice(1)}.`;

function Aliases({ map, audit }: { map: MapSummary; audit: Audit }) {
  return (
    <section>
      <h2>Perceptual aliases ({audit.aliases.length})</h2>
      {audit.aliases.length === 0 && <p>No two places are likely to be confused.</p>}
      <ul class="findings">
        {audit.aliases.map((pair) => (
          <li key={`${pair.a.id} ${pair.b.id}`}>
            <Thumbnail map={map} id={pair.a.id} />
            <Thumbnail map={map} id={pair.b.id} />
            <div>
              <strong>
                Keyframes <KeyframeLink map={map.name} id={pair.a.id} /> and{" "}
                <KeyframeLink map={map.name} id={pair.b.id} />
              </strong>
              : {counted(pair.inliers, "feature")} in common, {percent(pair.of_view)} of those in view
              <p>{sentence(pair.advice)}</p>
            </div>
          </li>
        ))}
      </ul>
    </section>
  );
}

function Ties({ map, audit }: { map: MapSummary; audit: Audit }) {
  return (
    <section>
      <h2>Connected by a single plane ({audit.ties.length})</h2>
      {audit.ties.length === 0 && <p>No two passes depend on a single plane.</p>}
      <ul class="findings">
        {audit.ties.map((tie) => (
          <li key={tie.plane}>
            <Thumbnail map={map} id={tie.a.id} />
            <Thumbnail map={map} id={tie.b.id} />
            <div>
              <strong>Plane <PlaneLink map={map.name} id={tie.plane} /></strong>: in view of keyframes{" "}
              <KeyframeLink map={map.name} id={tie.a.id} /> and{" "}
              <KeyframeLink map={map.name} id={tie.b.id} />, {counted(tie.inliers, "feature")}
              <p>{sentence(tie.advice)}</p>
            </div>
          </li>
        ))}
      </ul>
    </section>
  );
}

function Profile({ map, overview, audit }: { map: string; overview: Overview; audit: Audit | null }) {
  const { id, features } = overview.keyframes;
  const weak = useMemo(
    () => (audit?.weak ?? []).map((run): [number, number] =>
      [run.first.id, run.last.id]),
    [audit],
  );
  const curves = useMemo(() => [{ values: features, colour: "--accent" }], [features]);
  const none = features.filter((f) => f === 0).length;
  const sorted = [...features].sort((a, b) => a - b);
  const median = sorted[Math.floor(sorted.length / 2)] ?? 0;
  const open = (i: number) => {
    location.hash = href(map, "keyframes", id[i]);
  };
  return (
    <section>
      <h2>Features in view by keyframe</h2>
      <p class="legend">
        Median {median}; {counted(none, "keyframe")} with none. Shaded: weak keyframes. Click to open a
        keyframe, or enter its number.
      </p>
      <Series
        at={id}
        along="keyframe"
        curves={curves}
        unit="features"
        marked={weak}
        what={`Features in view of ${id.length} keyframes, median ${median}`}
        choose={open}
      />
      <GoTo what="Keyframe" numbers={id} choose={open} />
    </section>
  );
}

export function CoverageView({ map }: ViewProps) {
  const overview = useGet<Overview>(`${mapPath(map.name)}/overview`);
  const audit = useGet<Audit>(map.planes > 0 ? `${mapPath(map.name)}/audit` : null);
  if (overview.error) return <Failure error={overview.error} />;
  if (!overview.value) return <Waiting what="the map" />;
  if (map.planes === 0) {
    return (
      <>
        <h1>Coverage</h1>
        <p class="missing">This map has no planes, and coverage is a measure of the plane layer.</p>
      </>
    );
  }
  return (
    <>
      <h1>Coverage</h1>
      <Profile map={map.name} overview={overview.value} audit={audit.value} />
      {audit.error && <Failure error={audit.error} />}
      {!audit.value && !audit.error && <Waiting what="the audit (every plane is matched like a query)" />}
      {audit.value && (
        <>
          <WeakRuns map={map} audit={audit.value} />
          <Aliases map={map} audit={audit.value} />
          <Ties map={map} audit={audit.value} />
        </>
      )}
    </>
  );
}
