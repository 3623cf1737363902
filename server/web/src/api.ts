// SPDX-License-Identifier: Apache-2.0
// What the server answers, and how it is asked.

export type Point = [number, number];
export type Matrix = [number[], number[], number[]];

export interface Sequence {
  id: number;
  name: string;
  kind: string;
  frames: number;
  skipped: number;
  camera: { model: string; width: number; height: number } | null;
}

export interface MapSummary {
  name: string;
  version: string;
  program: string;
  feature_type: string;
  keyframes: number;
  planes: number;
  edges: number;
  features: number;
  sequences: Sequence[];
}

// By columns: row i of each list is the same thing.
export interface Overview {
  layers: string[];
  keyframes: {
    id: number[];
    sequence: number[];
    stretch: number[];
    frame: number[];
    planes: number[];
    features: number[];
  };
  planes: {
    id: number[];
    reference: number[];
    stretch: (number | null)[];
    features: number[];
    keyframes: number[][];
  };
  edges: { a: number[]; b: number[]; third_eigenvalue: number[] };
}

export interface Plane {
  id: number;
  reference: { id: number; source: string | null };
  features: { x_px: number; y_px: number; votes: number; visible: number }[];
  views: { keyframe: number; inliers: number; reference_from_keyframe: Matrix }[];
  neighbours: number[];
  outline: Point[];
}

export interface Keyframe {
  id: number;
  sequence: string;
  source: string;
  time_s: number | null;
  stretch: number;
  frame: number;
  width: number;
  height: number;
  image: string | null;
  planes: { id: number; inliers: number; outline: Point[] }[];
}

export interface KeyframeRef {
  id: number;
  sequence: string;
  source: string;
  time_s: number | null;
}

export interface Candidate {
  plane: number;
  reference: number;
  votes: number;
  matches: number;
  inliers: number;
  stopped_by: string | null;
  place: number | null;
  points: [number, number, number, number][];
}

export interface Explanation {
  image: { width: number; height: number; features: number };
  gates: {
    min_inliers: number;
    min_inlier_share: number;
    max_scale: number;
    min_probability: number;
    ambiguous_share: number;
  };
  candidates: Candidate[];
  places: {
    keyframe: number;
    planes: number[];
    inliers: number;
    best_share: number;
    probability: number;
  }[];
}

export interface Answer {
  verdict: "localized" | "ambiguous" | "not_in_map" | "bad_image" | "undecided";
  probability: number;
  image: string;
  map: string;
  keyframe: KeyframeRef | null;
  planes: {
    id: number;
    inliers: number;
    reference: { id: number; source: string };
    outline: Point[];
    expect_next: number[];
  }[];
  places?: { keyframe: KeyframeRef; probability: number; inliers: number }[];
  runner_up: { keyframe: { id: number }; probability: number } | null;
  decided_by: string;
  message?: string;
  timing_ms: Record<"decode" | "extract" | "shortlist" | "verify" | "total", number>;
  explanation?: Explanation;
}

interface AuditKeyframe {
  id: number;
  sequence: string;
  source: string;
}

export interface Audit {
  aliases: {
    a: AuditKeyframe;
    b: AuditKeyframe;
    inliers: number;
    of_view: number;
    planes: { a: number; b: number }[];
    advice: string;
  }[];
  ties: { plane: number; a: AuditKeyframe; b: AuditKeyframe; inliers: number; advice: string }[];
  weak: {
    first: AuditKeyframe;
    last: AuditKeyframe;
    keyframes: number;
    planes: number;
    features: number;
    weakness: string;
    advice: string;
  }[];
}

export const mapPath = (map: string) => `/v1/maps/${encodeURIComponent(map)}`;
export const imagePath = (map: string, keyframe: number) =>
  `${mapPath(map)}/keyframes/${keyframe}/image`;

export const thumbnailPath = (map: string, keyframe: number) =>
  `${mapPath(map)}/keyframes/${keyframe}/thumbnail`;

// What the server says went wrong, or that it can't be reached.
async function problemOf(response: Response): Promise<Error> {
  try {
    const problem = await response.json();
    return new Error(problem.detail ?? problem.title);
  } catch {
    return new Error(`the server answered ${response.status}`);
  }
}

async function ask<T>(path: string, init?: RequestInit): Promise<T> {
  let response: Response;
  try {
    response = await fetch(path, init);
  } catch {
    throw new Error("the server can't be reached; is it still running?");
  }
  if (!response.ok) throw await problemOf(response);
  return response.json();
}

// Maps don't change while the server runs, so what was asked once is kept.
const kept = new Map<string, Promise<unknown>>();

export function get<T>(path: string): Promise<T> {
  let answer = kept.get(path) as Promise<T> | undefined;
  if (!answer) {
    answer = ask<T>(path);
    answer.catch(() => kept.delete(path));
    kept.set(path, answer);
  }
  return answer;
}

export async function listMaps(): Promise<MapSummary[]> {
  const maps: MapSummary[] = [];
  let next: string | null = null;
  do {
    const cursor: string = next ? `&cursor=${encodeURIComponent(next)}` : "";
    const page: { maps: MapSummary[]; next: string | null } = await get(
      `/v1/maps?limit=1000${cursor}`,
    );
    maps.push(...page.maps);
    next = page.next;
  } while (next);
  return maps;
}

export function localize(map: string, photo: File): Promise<Answer> {
  const name = encodeURIComponent(photo.name.slice(-100));
  return ask(`${mapPath(map)}/localize?debug=true&name=${name}`, {
    method: "POST",
    headers: { "Content-Type": photo.type.startsWith("image/") ? photo.type : "image/jpeg" },
    body: photo,
  });
}
