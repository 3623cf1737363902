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
import { Kept } from "./kept";
import { endWithin } from "./words";

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
  client.token = token; // throws if it can't be one
  sessionStorage.setItem(kToken, token);
}

const kMaxAnswers = 200;
const kMaxPictures = 300; // that are fetched and not shown

const answers = new Kept<unknown>(kMaxAnswers, (path) => client.ask("GET", path));
const pictures = new Kept<string>(
  kMaxPictures,
  async (path) => URL.createObjectURL((await client.ask("GET", path)) as Blob),
  (address) => URL.revokeObjectURL(address),
);

export const get = <T>(path: string) => answers.get(path) as Promise<T>;

// An <img> can't show a token, so with one pictures are fetched.
export const picturesAreFetched = () => client.token !== null;

// The address of a fetched picture, until it is released.
export const holdPicture = (path: string) => pictures.hold(path);

const versions = new Map<string, string>(); // of the maps that were listed, by their names

const mapOf = (path: string) => decodeURIComponent(path.split("/")[3]);

// The address of a picture for an <img>: one for each version of the map, since browsers show what they have of
// an address again without asking.
export const pictureAddress = (path: string) =>
  `${path}${path.includes("?") ? "&" : "?"}version=${encodeURIComponent(versions.get(mapOf(path)) ?? "")}`;

export async function listMaps(): Promise<MapSummary[]> {
  const maps: MapSummary[] = [];
  for await (const map of client.rows("listMaps")) maps.push(map);
  return maps;
}

export const versionOf = async (map: string) => (await client.getMap(map)).version;

// Forgets what was asked of maps that have changed. Returns the versions that they had.
export function keepVersions(maps: MapSummary[]): string[] {
  const listed = new Map(maps.map((map) => [map.name, map.version]));
  const changed = [...versions].filter(([name, version]) => listed.get(name) !== version);
  const names = new Set(changed.map(([name]) => name));
  for (const kept of [answers, pictures]) kept.forget((path) => names.has(mapOf(path)));
  versions.clear();
  listed.forEach((version, name) => versions.set(name, version));
  return changed.map(([, version]) => version);
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

const kMaxNameBytes = 200; // of an image, that the server takes

export function localize(map: string, photo: File): Promise<Answer> {
  return client.localize(map, photo, { debug: true, name: endWithin(photo.name, kMaxNameBytes) });
}

