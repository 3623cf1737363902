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
}

export function parseRoute(hash: string): Route {
  const [map, view, id] = hash
    .replace(/^#\/?/, "")
    .split("/")
    .map((part) => {
      try {
        return decodeURIComponent(part);
      } catch {
        return "";
      }
    });
  return {
    map: map || null,
    view: kViews.find((known) => known === view) ?? "ask",
    id: id && /^\d+$/.test(id) ? Number(id) : null,
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
