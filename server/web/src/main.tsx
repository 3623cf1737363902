// SPDX-License-Identifier: Apache-2.0
// The page: the header, the chosen map and the chosen view.
import type { ComponentType } from "preact";
import { render } from "preact";
import { useEffect, useState } from "preact/hooks";
import {
  hasJobs, keepToken, keepVersions, listMaps, mapPath, type MapSummary, type Overview, versionOf, wantsToken,
} from "./api";
import { AskView } from "./ask";
import { Boundary, Failure, NotLoaded, Waiting } from "./parts";
import { href, useRoute, type View } from "./route";
import type { Query, ViewProps } from "./types";
import { useGet } from "./use";
import { counted } from "./words";

const kTitles: Record<View, string> = {
  ask: "Localize",
  why: "Why",
  planes: "Planes",
  keyframes: "Keyframes",
  layers: "Trajectory",
  orientation: "Orientation",
  coverage: "Coverage",
  names: "Names",
  jobs: "Jobs",
};

// Every view but the first is loaded on demand.
const kLater: Record<Exclude<View, "ask">, () => Promise<ComponentType<ViewProps>>> = {
  why: async () => (await import("./why")).WhyView,
  planes: async () => (await import("./planes")).PlanesView,
  keyframes: async () => (await import("./keyframes")).KeyframesView,
  layers: async () => (await import("./layers")).LayersView,
  orientation: async () => (await import("./orientation")).OrientationView,
  coverage: async () => (await import("./coverage")).CoverageView,
  names: async () => (await import("./names")).NamesView,
  jobs: async () => (await import("./jobs")).JobsView,
};

function NoView({ route }: ViewProps) {
  return (
    <>
      <h1>{kTitles[route.view]}</h1>
      <NotLoaded what="The view" />
    </>
  );
}

// In place of a view that the address names and the page hasn't got.
function UnknownView({ name }: { name: string }) {
  return (
    <>
      <h1>No such view</h1>
      <Failure error={`no view “${name}”`} />
    </>
  );
}

function useView(view: View): ComponentType<ViewProps> | null {
  const [loaded, setLoaded] = useState<{ view: View; show: ComponentType<ViewProps> }>({
    view: "ask",
    show: AskView,
  });
  useEffect(() => {
    if (view === "ask") setLoaded({ view, show: AskView });
    else kLater[view]().then((show) => setLoaded({ view, show }), () => setLoaded({ view, show: NoView }));
  }, [view]);
  if (view === "ask") return AskView;
  return loaded.view === view ? loaded.show : null;
}

// The views that a map has data for. Those that need a layer appear once the overview is loaded.
function viewsOf(map: MapSummary, layers: string[], jobs: boolean): View[] {
  const needs: Record<View, boolean> = {
    ask: true,
    why: map.keyframes > 0,
    planes: map.planes > 0,
    keyframes: map.keyframes > 0,
    layers: map.planes > 0 || layers.includes("appearance") || layers.includes("poses"),
    orientation: layers.includes("orientation"),
    coverage: map.planes > 0,
    names: map.keyframes > 0 || layers.includes("appearance"),
    jobs,
  };
  return (Object.keys(kTitles) as View[]).filter((view) => needs[view]);
}

function Header(props: { maps: MapSummary[]; map: MapSummary; view: View | null; refresh: () => void }) {
  const { maps, map, view } = props;
  const overview = useGet<Overview>(`${mapPath(map.name)}/overview`);
  const [jobs, setJobs] = useState(false);
  useEffect(() => {
    hasJobs().then(setJobs, () => {}); // a server that ends has none
  }, []);
  const choose = (event: Event) => {
    location.hash = href((event.target as HTMLSelectElement).value, view ?? "ask");
  };
  return (
    <header>
      <a class="name" href={href(map.name, "ask")}>Waystone</a>
      <div class="map">
        <label>
          <span>Map</span>
          <select value={map.name} title={map.name} onChange={choose}>
            {maps.map((m) => <option key={m.name}>{m.name}</option>)}
          </select>
        </label>
        <button aria-label="Refresh the list of maps" title="Refresh the list of maps" onClick={props.refresh}>↻</button>
      </div>
      <nav aria-label="Views">
        {viewsOf(map, overview.value?.layers ?? [], jobs).map((v) => (
          <a key={v} href={href(map.name, v)} aria-current={v === view ? "page" : undefined}>
            {kTitles[v]}
          </a>
        ))}
      </nav>
    </header>
  );
}

function Footer({ map }: { map: MapSummary }) {
  const counts = [counted(map.keyframes, "keyframe"), counted(map.planes, "plane"),
    `${counted(map.features, "feature")} (${map.feature_type})`, counted(map.edges, "edge")];
  return (
    <footer>
      <p>
        {map.name}{map.keyframes > 0 && `: ${counts.join(", ")}`}. Built with {map.program}. Version <code title={map.version}>{map.version.slice(0, 15)}</code>.
      </p>
      <p>
        <a href={`/v1/maps/${encodeURIComponent(map.name)}`}>JSON</a> ·{" "}
        <a href="/plain">version without JavaScript</a> · <a href="/page/licences.txt">Licences</a>
      </p>
    </footer>
  );
}

// The page keeps the token in the session storage of its tab.
function TokenForm({ refused, use }: { refused: boolean; use: (token: string) => void }) {
  const submit = (event: Event) => {
    event.preventDefault();
    const field = (event.target as HTMLFormElement).elements.namedItem("token") as HTMLInputElement;
    if (field.value.trim()) use(field.value.trim());
  };
  return (
    <main>
      <h1>Authentication required</h1>
      <form class="token" onSubmit={submit}>
        <label>
          Token <input name="token" type="password" autocomplete="off" required />
        </label>
        <button>Sign in</button>
      </form>
      {refused && <p class="failure" role="alert">Invalid token.</p>}
      <p class="quiet">Ask the server’s administrator for a token. It is kept until this tab is closed.</p>
    </main>
  );
}

// In place of a map that the address names and the server hasn't got.
function NoMap({ name, maps }: { name: string | null; maps: MapSummary[] }) {
  if (maps.length === 0) return <main><p>This server has no maps.</p></main>;
  return (
    <main>
      <h1>No such map</h1>
      <p>This server has no map “{name}”. It has:</p>
      <ul class="columns">
        {maps.map((m) => <li key={m.name}><a href={href(m.name, "ask")}>{m.name}</a></li>)}
      </ul>
    </main>
  );
}

function App() {
  const route = useRoute();
  const [maps, setMaps] = useState<MapSummary[] | null>(null);
  const [error, setError] = useState<string | null>(null);
  const [query, setQuery] = useState<Query | null>(null);
  const show = useView(route.view);
  const [asked, setAsked] = useState<"no" | "yes" | "again">("no"); // whether a token is needed
  const take = (found: MapSummary[]) => {
    const gone = keepVersions(found);
    setMaps(found);
    setQuery((last) => (last && gone.includes(last.answer.map_version) ? null : last));
  };
  const load = () =>
    listMaps().then(take, (e: Error) => {
      if (wantsToken(e)) setAsked((before) => (before === "no" ? "yes" : "again"));
      else setError(e.message);
    });
  // Maps may change while the server runs.
  useEffect(() => {
    load();
    const seen = () => document.visibilityState === "visible" && load();
    document.addEventListener("visibilitychange", seen);
    return () => document.removeEventListener("visibilitychange", seen);
  }, []);
  const useToken = (token: string) => {
    try {
      keepToken(token);
      load();
    } catch {
      setAsked("again");
    }
  };
  const map = maps?.find((m) => route.map === null || m.name === route.map);
  const check = (version: string) => {
    if (version !== map?.version) load();
  };
  useEffect(() => {
    if (map) versionOf(map.name).then(check, load);
    else if (maps) load(); // it may be new
  }, [route.map, map?.name, route.view]);
  useEffect(() => () => {
    if (query) URL.revokeObjectURL(query.photo);
  }, [query]);
  useEffect(() => {
    document.title = `${route.unknown === null ? kTitles[route.view] : "No such view"} · ${map?.name ?? ""} · Waystone`;
  }, [route.view, route.unknown, map]);
  if (!maps && error) return <main><Failure error={error} /></main>;
  if (!maps && asked !== "no") return <TokenForm refused={asked === "again"} use={useToken} />;
  if (!maps) return <main><Waiting what="the maps" /></main>;
  if (!map) return <NoMap name={route.map} maps={maps} />;
  const Show = show;
  const own = query?.map === map.name ? query : null;
  const keep = (answered: Query | null) => {
    setQuery(answered);
    if (answered) check(answered.answer.map_version);
  };
  const mapAndVersion = `${map.name} ${map.version}`;
  return (
    <>
      <a class="skip" href="#main" onClick={skip}>Skip to content</a>
      <Header key={mapAndVersion} maps={maps} map={map}
        view={route.unknown === null ? route.view : null} refresh={load} />
      <main id="main" tabIndex={-1} key={mapAndVersion}>
        <Boundary key={route.view}>
          {route.unknown !== null && <UnknownView name={route.unknown} />}
          {route.unknown === null && (Show
            ? <Show map={map} route={route} query={own} setQuery={keep} />
            : <Waiting what="the view" />)}
        </Boundary>
      </main>
      <Footer map={map} />
    </>
  );
}

// The hash of the address names the view, so a link to #main can't be followed.
function skip(event: Event) {
  event.preventDefault();
  document.getElementById("main")?.focus();
}

render(<App />, document.getElementById("app")!);
