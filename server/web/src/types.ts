// SPDX-License-Identifier: Apache-2.0
// The types that the page and its views share. It imports types only, so that no view needs main.
import type { Answer, MapSummary } from "./api";
import type { Route } from "./route";

// The last query image and its answer; several views show parts of it.
export interface Query {
  map: string;
  photo: string; // object URL, as long as this is the last query
  orientation: number; // of the photo, as EXIF has it
  name: string;
  answer: Answer; // in pixels of the upright photo
}

export interface ViewProps {
  map: MapSummary;
  route: Route;
  query: Query | null;
  setQuery: (query: Query | null) => void;
}

// The frames of one sequence: rows first to last of the orientation layer's columns.
export interface Stretch {
  sequence: number;
  first: number;
  last: number;
}
