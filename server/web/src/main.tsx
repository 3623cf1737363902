// SPDX-License-Identifier: Apache-2.0
// The page: which map, which view.
import type { ComponentType } from "preact";
import { render } from "preact";
import { useEffect, useState } from "preact/hooks";
import { type Answer, keepToken, listMaps, type MapSummary, wantsToken } from "./api";
import { AskView } from "./ask";
import { Failure, Waiting } from "./parts";
import { href, type Route, useRoute, type View } from "./route";
import { counted } from "./words";

// The last photo that was asked about; several views show parts of its answer.
export interface Query {
  map: string;
  photo: string; // object URL
  name: string;
  answer: Answer;
}

export interface ViewProps {
  map: MapSummary;
  route: Route;
  query: Query | null;
  setQuery: (query: Query | null) => void;
}

const kTitles: Record<View, string> = {
  ask: "Ask",
  why: "Why",
  planes: "Planes",
  keyframes: "Keyframes",
  layers: "Layers",
  orientation: "Orientation",
  coverage: "Coverage",
};

// What the first view doesn't need is loaded when it is asked for.
const kLater: Record<Exclude<View, "ask">, () => Promise<ComponentType<ViewProps>>> = {
  why: async () => (await import("./why")).WhyView,
  planes: async () => (await import("./planes")).PlanesView,
  keyframes: async () => (await import("./keyframes")).KeyframesView,
  layers: async () => (await import("./layers")).LayersView,
  orientation: async () => (await import("./orientation")).OrientationView,
  coverage: async () => (await import("./coverage")).CoverageView,
};

function useView(view: View): ComponentType<ViewProps> | null {
  const [loaded, setLoaded] = useState<{ view: View; show: ComponentType<ViewProps> }>({
    view: "ask",
    show: AskView,
  });
  useEffect(() => {
    if (view === "ask") setLoaded({ view, show: AskView });
    else kLater[view]().then((show) => setLoaded({ view, show }));
  }, [view]);
  if (view === "ask") return AskView;
  return loaded.view === view ? loaded.show : null;
}

function Header({ maps, map, view }: { maps: MapSummary[]; map: MapSummary; view: View }) {
  const choose = (event: Event) => {
    location.hash = href((event.target as HTMLSelectElement).value, view);
  };
  return (
    <header>
      <a class="name" href={href(map.name, "ask")}>Waystone</a>
      <label class="map">
        <span>Map</span>
        <select value={map.name} onChange={choose}>
          {maps.map((m) => <option key={m.name}>{m.name}</option>)}
        </select>
      </label>
      <nav aria-label="Views">
        {(Object.keys(kTitles) as View[]).map((v) => (
          <a key={v} href={href(map.name, v)} aria-current={v === view ? "page" : undefined}>
            {kTitles[v]}
          </a>
        ))}
      </nav>
    </header>
  );
}

function Footer({ map }: { map: MapSummary }) {
  return (
    <footer>
      <p>
        {map.name}: {counted(map.keyframes, "keyframe")}, {counted(map.planes, "plane")},{" "}
        {counted(map.features, "feature")} ({map.feature_type}), {counted(map.edges, "edge")}.
        Built by {map.program}. Version <code title={map.version}>{map.version.slice(0, 15)}</code>.
      </p>
      <p>
        <a href={`/v1/maps/${encodeURIComponent(map.name)}`}>JSON</a> ·{" "}
        <a href="/plain">without scripts</a> · <a href="/page/licences.txt">licences</a>
      </p>
    </footer>
  );
}

// The server's operator gives out tokens; the page keeps one as long as its tab is open.
function TokenForm({ refused, use }: { refused: boolean; use: (token: string) => void }) {
  const submit = (event: Event) => {
    event.preventDefault();
    const field = (event.target as HTMLFormElement).elements.namedItem("token") as HTMLInputElement;
    if (field.value.trim()) use(field.value.trim());
  };
  return (
    <main>
      <h1>This server wants a token</h1>
      <form class="token" onSubmit={submit}>
        <label>
          Token <input name="token" type="password" autocomplete="off" required />
        </label>
        <button>Go on</button>
      </form>
      {refused && <p class="failure" role="alert">The server doesn’t know this token.</p>}
      <p class="quiet">Whoever runs the server has its tokens. This one is kept until the tab is closed.</p>
    </main>
  );
}

function App() {
  const route = useRoute();
  const [maps, setMaps] = useState<MapSummary[] | null>(null);
  const [error, setError] = useState<string | null>(null);
  const [query, setQuery] = useState<Query | null>(null);
  const show = useView(route.view);
  const [asked, setAsked] = useState<"no" | "yes" | "again">("no"); // for a token
  const load = () =>
    listMaps().then(setMaps, (e: Error) => {
      if (wantsToken(e)) setAsked((before) => (before === "no" ? "yes" : "again"));
      else setError(e.message);
    });
  useEffect(() => {
    load();
  }, []);
  const useToken = (token: string) => {
    keepToken(token);
    load();
  };
  const map = maps?.find((m) => m.name === route.map) ?? maps?.[0];
  useEffect(() => {
    document.title = `${kTitles[route.view]} · ${map?.name ?? ""} · Waystone`;
  }, [route.view, map]);
  if (error) return <main><Failure error={error} /></main>;
  if (!maps && asked !== "no") return <TokenForm refused={asked === "again"} use={useToken} />;
  if (!maps) return <main><Waiting what="the maps" /></main>;
  if (!map) return <main><p>This server has no map.</p></main>;
  const Show = show;
  const own = query?.map === map.name ? query : null;
  return (
    <>
      <a class="skip" href="#main" onClick={skip}>Skip to the content</a>
      <Header maps={maps} map={map} view={route.view} />
      <main id="main" tabIndex={-1} key={map.name}>
        {Show
          ? <Show map={map} route={route} query={own} setQuery={setQuery} />
          : <Waiting what="the view" />}
      </main>
      <Footer map={map} />
    </>
  );
}

// The address has the view in its hash, so the link can't change it.
function skip(event: Event) {
  event.preventDefault();
  document.getElementById("main")?.focus();
}

render(<App />, document.getElementById("app")!);
