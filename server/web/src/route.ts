// SPDX-License-Identifier: Apache-2.0
// Where the page is: #/MAP/VIEW/ID, so that every view has an address.
import { useEffect, useState } from "preact/hooks";

export const kViews = [
  "ask", "why", "planes", "keyframes", "layers", "orientation", "coverage", "names", "jobs",
] as const;
export type View = (typeof kViews)[number];

export interface Route {
  map: string | null;
  view: View;
  id: number | null;
  unknown: string | null; // what follows the map, if it names no view
}

export function parseRoute(hash: string): Route {
  const [map, view = "", id = ""] = hash
    .replace(/^#\/?/, "")
    .split("/")
    .map((part) => {
      try {
        return decodeURIComponent(part);
      } catch {
        return "";
      }
    });
  const found = kViews.find((known) => known === view);
  const named = (found !== undefined || view === "") && /^\d*$/.test(id);
  return {
    map: map || null,
    view: found ?? "ask",
    id: named && id ? Number(id) : null,
    unknown: named ? null : [view, id].filter(Boolean).join("/"),
  };
}

export function href(map: string, view: View, id?: number | null): string {
  const base = `#/${encodeURIComponent(map)}/${view}`;
  return id == null ? base : `${base}/${id}`;
}

export function useRoute(): Route {
  const [route, setRoute] = useState(() => parseRoute(location.hash));
  useEffect(() => {
    const update = () => setRoute(parseRoute(location.hash));
    addEventListener("hashchange", update);
    update(); // it may have changed since the first rendering
    return () => removeEventListener("hashchange", update);
  }, []);
  return route;
}
