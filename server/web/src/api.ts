// SPDX-License-Identifier: Apache-2.0
// What the server answers, and how it is asked.

import {
  type Answer,
  Client,
  type ExplainedCandidate,
  type Job,
  type Map as MapSummary,
  WaystoneError,
} from "../../../clients/js/waystone.js";

export type {
  Appearance, AppearanceNode, Audit, DirectedLines, ExplainedKeyframe, Explanation, FloorPlan, FloorPlans, ImageRange, Keyframe, NamesFile,
  NamedArea, NamesFilePlace, Orientation, OrientationFrame, Overview, Plane, PlaneInImage, Pose, PoseLayer, Space,
} from "../../../clients/js/waystone.js";
export type { Answer, Job, MapSummary };
export type Candidate = ExplainedCandidate;
export type Point = [number, number];

export const mapPath = (map: string) => `/v1/maps/${encodeURIComponent(map)}`;
export const imagePath = (map: string, keyframe: number) =>
  `${mapPath(map)}/keyframes/${keyframe}/image`;

export const thumbnailPath = (map: string, keyframe: number) =>
  `${mapPath(map)}/keyframes/${keyframe}/thumbnail`;

const kToken = "waystone-token"; // in the session's storage: gone with the tab

// An audit of a large map takes a while.
const client = new Client("", { token: sessionStorage.getItem(kToken), timeout_ms: 120_000 });

// Whether the server wants a token that it hasn't got.
export const wantsToken = (error: unknown) =>
  error instanceof WaystoneError && error.code === "unauthorized";

export function keepToken(token: string) {
  sessionStorage.setItem(kToken, token);
  client.token = token;
}

// Maps don't change while the server runs, so what was asked once is kept.
const kept = new Map<string, Promise<unknown>>();

export function get<T>(path: string): Promise<T> {
  let answer = kept.get(path) as Promise<T> | undefined;
  if (!answer) {
    answer = client.ask("GET", path) as Promise<T>;
    answer.catch(() => kept.delete(path));
    kept.set(path, answer);
  }
  return answer;
}

// An <img> can't show a token, so with one pictures are fetched.
export const picturesAreFetched = () => client.token !== null;

const addresses = new Map<string, Promise<string>>();

// The address of a fetched picture; the same for the same path.
export function fetchedPicture(path: string): Promise<string> {
  let address = addresses.get(path);
  if (!address) {
    address = (client.ask("GET", path) as Promise<Blob>).then((blob) => URL.createObjectURL(blob));
    address.catch(() => addresses.delete(path));
    addresses.set(path, address);
  }
  return address;
}

export async function listMaps(): Promise<MapSummary[]> {
  const maps: MapSummary[] = [];
  for await (const map of client.rows("listMaps")) maps.push(map);
  return maps;
}

// Whether the server knows of jobs.
export async function hasJobs(): Promise<boolean> {
  const ready = await client.readyz();
  return ready.registry?.jobs ?? false;
}

// As they are now, the newest first.
export async function listJobs(): Promise<Job[]> {
  const { jobs } = await client.listJobs({ limit: 100 });
  return jobs;
}

export function localize(map: string, photo: File): Promise<Answer> {
  return client.localize(map, photo, { debug: true, name: photo.name.slice(-100) });
}

