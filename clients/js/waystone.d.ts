// SPDX-License-Identifier: Apache-2.0
// Made from clients/openapi.yaml by scripts/generate_js_client.py; don't edit.

/** An image's bytes; a form with images in their order; or the JSON of a request with images. */
export type Photo = Blob | ArrayBuffer | ArrayBufferView | FormData |
  (Request & { images: { name?: string; data: string }[] });

export declare class WaystoneError extends Error {
  /** The contract's code, or "unreachable", "timeout" or "bad_answer". */
  code: string;
  /** Of HTTP; 0 where no answer came. */
  status: number;
  constructor(code: string, status: number, detail: string);
}

/** Runs in browsers and in Node 18 and later. Throws WaystoneError alone. */
export declare class Client {
  server: string;
  token: string | null;
  timeout_ms: number;
  retries: number;
  /**
   * `server` is an address without path, or "" in a page that the server gave; the token is printable
   * ASCII. Others are a "bad_request". `timeout_ms` may be Infinity, which waits for weeks.
   */
  constructor(server?: string, options?: { token?: string | null; timeout_ms?: number; retries?: number });
  /** One request, as all methods send it. An answer of another kind than `kind` is an error. */
  ask(verb: string, path: string, options?: object, photo?: Photo, kind?: "json" | "image" | "text" | null): Promise<unknown>;
  rows(list: "listMaps"): AsyncGenerator<Map, void>;
  rows(list: "listJobs"): AsyncGenerator<Job, void>;
  rows(list: "listPlanes", map: string): AsyncGenerator<PlaneSummary, void>;
  rows(list: "listFeatures", map: string, id: number): AsyncGenerator<Feature, void>;
  rows(list: "listViews", map: string, id: number): AsyncGenerator<View, void>;
  rows(list: "listKeyframes", map: string): AsyncGenerator<Keyframe, void>;
  rows(list: "listAppearanceNodes", map: string): AsyncGenerator<AppearanceNode, void>;
  rows(list: "listLoops", map: string): AsyncGenerator<Loop, void>;
  rows(list: "listOrientationFrames", map: string): AsyncGenerator<OrientationFrame, void>;
  rows(list: "listTurns", map: string): AsyncGenerator<Turn, void>;
  rows(list: "listCorridors", map: string): AsyncGenerator<Corridor, void>;
  /** This contract as JSON. */
  contract(): Promise<Record<string, unknown>>;
  /** Liveness check. Does not require a token. */
  healthz(): Promise<string>;
  /** Readiness check: maps are loaded and the server is not shutting down. Does not require a token. */
  readyz(): Promise<Ready>;
  /** Versions of the program and of the map schema. */
  version(): Promise<Version>;
  /** Metrics in Prometheus format. */
  metrics(): Promise<string>;
  /** List of maps. */
  listMaps(options?: { limit?: number; cursor?: string }): Promise<MapList>;
  /** List of jobs in the registry, newest first; at most 1000. */
  listJobs(options?: { limit?: number; cursor?: string }): Promise<JobList>;
  /** A job with its steps, attempts and log. */
  getJob(id: number): Promise<JobDetails>;
  /** Localize images in all maps. */
  localizeAcross(photo: Photo, options?: { name?: string; fx?: number; fy?: number; cx?: number; cy?: number; fov_deg?: number; top_k?: number; debug?: boolean; deadline_ms?: number }): Promise<Answer>;
  /** Localize images in a map. */
  localize(map: string, photo: Photo, options?: { name?: string; fx?: number; fy?: number; cx?: number; cy?: number; fov_deg?: number; camera?: string; prior_keyframe?: number; top_k?: number; debug?: boolean; deadline_ms?: number }): Promise<Answer>;
  /** Summary of a map. */
  getMap(map: string): Promise<Map>;
  /** List of planes. */
  listPlanes(map: string, options?: { limit?: number; cursor?: string }): Promise<PlaneList>;
  /** A plane. */
  getPlane(map: string, id: number): Promise<Plane>;
  /** Features of a plane. */
  listFeatures(map: string, id: number, options?: { limit?: number; cursor?: string }): Promise<FeatureList>;
  /** Keyframes with the plane in view. */
  listViews(map: string, id: number, options?: { limit?: number; cursor?: string }): Promise<ViewList>;
  /** Graph of planes, or poses in other formats. */
  getGraph(map: string, options?: { format?: "json" | "graphml" | "dot" | "g2o" | "geojson" | "ply" | "tum" | "poses" }): Promise<Graph | string>;
  /** List of keyframes. */
  listKeyframes(map: string, options?: { limit?: number; cursor?: string }): Promise<KeyframeList>;
  /** A keyframe. */
  getKeyframe(map: string, id: number): Promise<Keyframe>;
  /** Image of a keyframe. */
  getKeyframeImage(map: string, id: number, options?: { width?: number }): Promise<Blob>;
  /** Thumbnail of a keyframe. */
  getKeyframeThumbnail(map: string, id: number): Promise<Blob>;
  /** Line segments of a keyframe by Manhattan axis. 422 for a sequence without a camera. */
  getKeyframeLines(map: string, id: number): Promise<DirectedLines>;
  /** 3D positions of the planes in view, relative to the camera. 422 for a sequence without a camera. */
  getKeyframeSpace(map: string, id: number): Promise<Space>;
  /** The complete map in columns, for visualization. */
  getOverview(map: string): Promise<Overview>;
  /** The pose layer, for visualization. 404 with the code no_layer for maps without poses. */
  getPoses(map: string): Promise<PoseLayer>;
  /** The named places, in the format that `waystone name MAP --from` reads. Only that command assigns names; the server never does. */
  getNames(map: string): Promise<NamesFile>;
  /** The floor plans, which `waystone plan` adds to the map. */
  getFloorPlans(map: string): Promise<FloorPlans>;
  /** Image of a floor plan, as it was added. */
  getFloorPlanImage(map: string, options?: { name?: string }): Promise<Blob>;
  /** Weak spots of the map. The first request takes seconds and counts as a query; further requests in the meantime get 429. */
  getAudit(map: string): Promise<Audit>;
  /** The appearance layer, for visualization. This route and those below it return 404 with the code no_layer for maps without the layer. */
  getAppearance(map: string): Promise<Appearance>;
  /** List of panoramas with their poses. */
  listAppearanceNodes(map: string, options?: { limit?: number; cursor?: string }): Promise<AppearanceNodeList>;
  /** A panorama with its pose. */
  getAppearanceNode(map: string, id: number): Promise<AppearanceNode>;
  /** Image of a panorama. */
  getAppearanceImage(map: string, id: number, options?: { width?: number }): Promise<Blob>;
  /** Fourier signature of a panorama. */
  getSignature(map: string, id: number): Promise<Signature>;
  /** List of loop closures. */
  listLoops(map: string, options?: { limit?: number; cursor?: string }): Promise<LoopList>;
  /** The orientation layer, for visualization. This route and those below it return 404 with the code no_layer for maps without the layer. */
  getOrientation(map: string): Promise<Orientation>;
  /** List of frames with the camera rotation relative to the Manhattan axes. */
  listOrientationFrames(map: string, options?: { limit?: number; cursor?: string }): Promise<OrientationFrameList>;
  /** A frame. */
  getOrientationFrame(map: string, id: number): Promise<OrientationFrame>;
  /** Image of a node. */
  getOrientationImage(map: string, id: number, options?: { width?: number }): Promise<Blob>;
  /** Line segments of the image of a node by Manhattan axis. */
  getOrientationLines(map: string, id: number): Promise<DirectedLines>;
  /** List of turns, confirmed or not. */
  listTurns(map: string, options?: { limit?: number; cursor?: string }): Promise<TurnList>;
  /** List of corridors. */
  listCorridors(map: string, options?: { limit?: number; cursor?: string }): Promise<CorridorList>;
}

/** Texts are limited to 200 bytes of UTF-8, in which a character may take up to four. The camera is given in at most one way: fx, fy, cx and cy, fov_deg, or camera. */
export interface Request {
  fx?: number;
  fy?: number;
  cx?: number;
  cy?: number;
  fov_deg?: number;
  camera?: string;
  /** Validated, but not used by any layer so far, and therefore always listed in `unused`. */
  prior?: { keyframe: Id };
  /** Narrows down a query of all maps (/v1/localize) on a server with a registry. */
  hints?: { position?: { frame: string; x: number; y: number; z?: number; radius: number }; tags?: string[]; previous_map?: string };
  previous?: { keyframe?: Id; heading_rad?: Angle; map_version?: string; belief?: Belief };
  /** For series of panoramas: the motion of each image since the previous image or answer, in map units (x forward, y left), or null; as many as images. */
  odometry?: (null | { x: number; y: number; heading_rad: Angle })[];
  top_k?: number;
  debug?: boolean;
  deadline_ms?: number;
}

export interface RequestWithImages {
  fx?: number;
  fy?: number;
  cx?: number;
  cy?: number;
  fov_deg?: number;
  camera?: string;
  /** Validated, but not used by any layer so far, and therefore always listed in `unused`. */
  prior?: { keyframe: Id };
  /** Narrows down a query of all maps (/v1/localize) on a server with a registry. */
  hints?: { position?: { frame: string; x: number; y: number; z?: number; radius: number }; tags?: string[]; previous_map?: string };
  previous?: { keyframe?: Id; heading_rad?: Angle; map_version?: string; belief?: Belief };
  /** For series of panoramas: the motion of each image since the previous image or answer, in map units (x forward, y left), or null; as many as images. */
  odometry?: (null | { x: number; y: number; heading_rad: Angle })[];
  top_k?: number;
  debug?: boolean;
  deadline_ms?: number;
  images: { name?: string; data: string }[];
}

/** Belief about the position of the robot, most probable node first. The remaining probability is spread over the map. */
export type Belief = { node: Id; probability: Probability; heading_rad: Angle; deviation_rad: number }[];

export interface Problem {
  type: string;
  title: string;
  status: number;
  detail: string;
  /** Stable. Codes of status 503, which has Retry-After: not_ready, out_of_memory and, on servers with a registry, registry_unavailable, store_unavailable, store_damaged (the stored file differs from the published one) and no_room (the map does not fit within the limits of memory or cache, or on the disk). */
  code: string;
}

export interface Ready {
  ready: true;
  /** Number of maps known by name. */
  maps: number;
  /** Number of maps in memory; the others are opened when they are requested. */
  open: number;
  /** Only on servers with a registry. */
  registry?: { connected: boolean; silent_s: number; memory_bytes: number; cached_files: number; cached_bytes: number; jobs: boolean; coarse: { maps: number; places: number; bytes: number; without: number; waiting: number } };
}

export interface Version {
  program: string;
  schema: number;
}

export type Id = number;

/** Radians. */
export type Angle = number;

/** The surface, such as a wall, that the plane is part of, as the lowest id of its planes. */
export type SurfaceId = number;

/** Id in `sequences` of the map; several sequences may have the same name. */
export type SequenceId = number;

export type Probability = number;

export type Count = number;

/** Cursor of the next page; null at the end. */
export type Next = string | null;

/** Three rows of three. */
export type Matrix = [[number, number, number], [number, number, number], [number, number, number]];

export type Vector = [number, number, number];

/** Points [x, y], px. */
export type Outline = [number, number][];

export type Verdict = "localized" | "ambiguous" | "not_in_map" | "bad_image" | "undecided";

export interface KeyframeRef {
  id: Id;
  sequence: string;
  source: string;
  time_s?: number | null;
}

/** The place of a localized image, regardless of the layer: the nearest keyframe (planes) or panorama (appearance) with its source image, and the position and heading of the query if known. */
export interface AnsweredPlace {
  layer: "planes" | "appearance";
  id: Id;
  name: PlaceName;
  image: string;
  sequence: string;
  time_s: number | null;
  position: null | PlacePosition;
  heading: null | Heading;
  plan: null | PlanPosition;
}

/** Position of the query on a floor plan of the map, in pixels of its image, rightwards and downwards from the upper left corner; null if the query has no position or no plan shows it. */
export interface PlanPosition {
  name: string;
  x: number;
  y: number;
}

/** Name given to the place by `waystone name`, null if there is none. If several named places contain it, the narrowest one. */
export type PlaceName = string | null;

/** In the frame and units of the appearance layer; `deviation` is the standard deviation along the worst direction. `metres_per_unit` is null if the scale is unknown. */
export interface PlacePosition {
  x: number;
  y: number;
  deviation: number;
  metres_per_unit: number | null;
}

/** Counter-clockwise from the x axis of the frame that `of` names, seen from above. */
export interface Heading {
  rad: number;
  deviation_rad: number;
  of: "keyframe" | "building" | "layer";
}

export interface Place {
  keyframe: KeyframeRef;
  probability: Probability;
  inliers: Count;
}

export interface RunnerUp {
  keyframe: { id: Id };
  probability: Probability;
}

export interface Timing {
  decode: number;
  extract: number;
  shortlist: number;
  verify: number;
  pose?: number;
  total: number;
}

export interface QueryCamera {
  source: "stored" | "fov" | "intrinsics" | "exif";
  model: string;
  width: number;
  height: number;
  params: number[];
}

export interface ShortAnswer {
  map?: string;
  image?: string;
  verdict: Verdict;
  probability: Probability;
  place: null | AnsweredPlace;
  keyframe: null | KeyframeRef;
  inliers: Count;
}

export interface ImageRef {
  id: Id;
  source: string | null;
}

export interface RecognisedPlane {
  id: Id;
  inliers: Count;
  reference: ImageRef;
  reference_from_query: Matrix;
  outline: Outline;
  /** Planes that were seen together with this one in the map, but are not recognised in this image: what a moving camera may see next. */
  expect_next: Id[];
}

/** The query's matches with one keyframe, on planes or not, that fit a single epipolar geometry. */
export interface EpipolarMatches {
  keyframe: ImageRef;
  inliers: Count;
  matches: Count;
}

export interface Answer {
  verdict: Verdict;
  probability: Probability;
  image: string;
  map: string;
  map_version: string;
  place: null | AnsweredPlace;
  /** The place if the plane layer answered, otherwise null. */
  keyframe: null | KeyframeRef;
  heading: null | Heading;
  /** Only for maps with poses. Null if the pose is unknown; `pose_reason` says why. */
  pose?: null | Pose;
  pose_reason?: string;
  building?: BuildingView;
  planes: RecognisedPlane[];
  epipolar?: EpipolarMatches;
  panorama?: PanoramaPlace;
  belief?: Belief;
  /** If ambiguous: the keyframes of the matching places, of all maps. Panoramas have none; for several maps, `maps` has the place of each. */
  places?: Place[];
  /** For the plane layer: the second-best place, or the best one if it was refused; null if there is none. For panoramas, it is in `panorama`. */
  runner_up: null | RunnerUp;
  /** The test that decided the verdict. In the plane layer: features, shortlist_votes, homography_inliers, epipolar_inliers, inlier_share, homography_scale, place_probability, ambiguous_places; in the appearance layer: panorama_signature, panorama_features, series, photo, photo_features; in the orientation layer: building_axes; for several maps: ambiguous_maps; before any layer: bad_image, image_too_large, deadline. docs/http-api.md explains each of them. Later versions may add others. */
  decided_by: string;
  message?: string;
  timing_ms: Timing;
  /** For several maps: a summary of the answer of each. */
  maps?: ShortAnswer[];
  /** For several images: a summary of the answer to each. */
  images?: ShortAnswer[];
  candidates?: Place[];
  explanation?: Explanation;
  stage?: "queue" | "decode" | "extract" | "shortlist" | "decide";
  camera?: QueryCamera;
  /** Fields of the request that no layer of this map uses. */
  unused?: ("camera" | "prior" | "previous" | "odometry")[];
  /** If not all maps could be queried: those that the coarse index proposed, most likely first. If all fit into memory but some could not be opened: all of them, by name. */
  searched?: SearchedMap[];
  /** With `searched`: one of these maps was not queried, so a different answer is possible. */
  partial?: boolean;
  /** With `searched`: number of maps that are not in the coarse index and cannot be proposed. */
  unindexed?: number;
}

/** A map that was to be queried in a query of all maps. */
export interface SearchedMap {
  map: string;
  /** `asked`: queried. `late`: not opened or no answer by the deadline. `too_large`: exceeds the memory that the server may use. */
  state: "asked" | "late" | "failed" | "too_large";
  /** How strongly the features of the image support the map; comparable only within one answer. 0 for `previous_map` if the index does not propose it, and if all maps were to be queried. */
  score: number;
  /** Why it was not queried. */
  message?: string;
}

/** Pose of the query camera in the frame of the poses that the map was built with. The camera has x right, y down, z forward; `orientation` is the quaternion x, y, z, w that rotates its axes into those of the frame. `covariance` is that of the position and of a small rotation about the axes of the frame, in the order of ROS: x, y, z, about x, about y, about z. `inliers` is 0 for a panorama that was localized by its appearance alone. `camera` says whose calibration was used; a panorama has its own. */
export interface Pose {
  frame: string;
  unit: "metres" | "unknown";
  position: Vector;
  orientation: [number, number, number, number];
  /** Six rows of six. */
  covariance: [[number, number, number, number, number, number], [number, number, number, number, number, number], [number, number, number, number, number, number], [number, number, number, number, number, number], [number, number, number, number, number, number], [number, number, number, number, number, number]];
  inliers: Count;
  camera: "query" | "map";
}

/** Rotation of the query relative to the Manhattan axes, if the map has an orientation layer and the camera is known or the query is a panorama. disagreement_rad is the angle between the axes estimated from the query's lines and those of the place, null if not reliable. */
export interface BuildingView {
  heading: null | Heading;
  building_from_query: null | Matrix;
  lines: [number, number, number];
  disagreement_rad: number | null;
}

/** Result of the appearance layer: the nearest node and the position (null unless localized), and the candidates. */
export interface PanoramaPlace {
  node: null | NodeRef;
  position: null | PlacePosition;
  candidates: NodeCandidate[];
  /** The most probable node at another place; null if there is none. */
  runner_up: null | NodeCandidate;
}

export interface NodeRef {
  id: Id;
  sequence: string;
  source: string;
  time_s: number | null;
}

export interface NodeCandidate {
  node: NodeRef;
  probability: Probability;
  cost: number;
  inliers: Count;
}

/** With debug: the outcome of every candidate plane. */
export interface Explanation {
  image: { width: Count; height: Count; features: Count };
  gates: Gates;
  candidates: ExplainedCandidate[];
  keyframes: ExplainedKeyframe[];
  places: ExplainedPlace[];
}

export interface Gates {
  min_inliers: Count;
  min_inlier_share: number;
  max_scale: number;
  min_probability: number;
  ambiguous_share: number;
}

export interface ExplainedPlace {
  keyframe: Id;
  planes: Id[];
  inliers: Count;
  best_share: number;
  probability: Probability;
}

export interface ExplainedKeyframe {
  keyframe: Id;
  matches: Count;
  inliers: Count;
  /** Inliers that are independent of each other: a corner gives several features, which are found together or not at all. */
  independent: number;
  expected: Count;
  /** Share of the query image near an inlier. */
  coverage: number;
  place: number | null;
  /** The inliers: [x, y] in the query and [x, y] in the reference image, px. */
  points: [number, number, number, number][];
}

export interface ExplainedCandidate {
  plane: Id;
  reference: Id;
  votes: Count;
  matches: Count;
  inliers: Count;
  stopped_by: null | "settled" | "no_homography" | "min_inliers" | "min_inlier_share" | "max_scale";
  place: number | null;
  /** The inliers: [x, y] in the query and [x, y] in the reference image, px. */
  points: [number, number, number, number][];
}

export interface Overview {
  layers: ("planes" | "appearance" | "orientation" | "poses")[];
  keyframes: { id: number[]; sequence: number[]; stretch: number[]; frame: number[]; planes: number[]; features: number[]; place: PlaceName[] };
  planes: { id: number[]; surface: number[]; reference: number[]; stretch: (number | null)[]; features: number[]; keyframes: number[][] };
  edges: { a: number[]; b: number[]; third_eigenvalue: number[] };
}

/** Named places, defined by their images, so that they can be reused on a map rebuilt from the same images. */
export interface NamesFile {
  format: "waystone-names";
  format_version: "1";
  map: { name: string; version: string; sequences: string[] };
  places: NamesFilePlace[];
}

export interface NamesFilePlace {
  name: string;
  keyframes: ImageRange[];
  nodes: ImageRange[];
  planes: PlaneInImage[];
  polygons: NamedArea[];
}

/** Images of a sequence, from `first` to `last`. `sequence_number` is its number among the sequences of this name; 1 if missing. */
export interface ImageRange {
  sequence: string;
  sequence_number?: number;
  first: ImageInSequence;
  last: ImageInSequence;
}

export interface ImageInSequence {
  image: string;
  frame: number;
}

/** The plane that an image shows at a pixel. */
export interface PlaneInImage {
  sequence: string;
  sequence_number?: number;
  image: string;
  frame: number;
  at_px: [number, number];
}

/** A polygon seen from above. `right` and `top` are the unit vectors, in the frame, of its x and y axes; without them and `unit`, it is in the frame of the appearance layer, called layer. */
export interface NamedArea {
  frame: string;
  unit?: "metres" | "unknown";
  right?: Vector;
  top?: Vector;
  corners: [number, number][];
}

/** Floor plans of the map, ordered by name. `right` and `top` are the unit vectors, in the frame, of the x and y axes; without them and `unit`, the frame is that of the appearance layer, called layer. */
export interface FloorPlans {
  frame: string;
  unit?: "metres" | "unknown";
  right?: Vector;
  top?: Vector;
  plans: FloorPlan[];
}

/** An image on which the map is drawn: px = `plan_from_frame` (x, y, 1), a rotation, a scale of `px_per_unit` and a translation. `residual` is the root mean square error of the anchors, in the unit of the frame. `heights` is the range of heights, along right x top, of the positions that the plan shows; null for all heights. */
export interface FloorPlan {
  name: string;
  /** Width of the image, px. */
  width: number;
  /** Height of the image, px. */
  height: number;
  /** Path of the image. */
  image: string;
  heights: null | { low: number; high: number };
  plan_from_frame: [Vector, Vector];
  px_per_unit: number;
  residual: number;
  anchors: PlanAnchor[];
}

/** A pixel of the image and its position in the frame, along `right` and `top`. */
export interface PlanAnchor {
  px: Pair;
  at: Pair;
}

export type Pair = [number, number];

/** Keyframes, panoramas (nodes of the appearance layer) and planes in the frame of the poses that the map was built with; lengths are in its unit. `up` points upwards: the mean up direction of the images, null if they differ too much. `noise` is the noise of the given poses on each axis, null if it was not measured. */
export interface PoseLayer {
  frame: string;
  unit: "metres" | "unknown";
  noise: { position_deviation: number | null; rotation_deviation_rad: number | null };
  up: null | Vector;
  keyframes: PosedImages;
  nodes: PosedImages;
  planes: PosedPlane[];
}

/** Images with a pose, in columns, ordered by id. `orientation` is the quaternion x, y, z, w that rotates the axes of the camera (x right, y down, z forward) into those of the frame. */
export interface PosedImages {
  id: Id[];
  position: Vector[];
  orientation: [number, number, number, number][];
}

/** The points X with normal . X = distance; the normal points away from the camera of the reference keyframe. `outline` encloses its features, except those that the reference image shows at too flat an angle; it consists of such points, in order around it. */
export interface PosedPlane {
  id: Id;
  reference: Id;
  normal: Vector;
  distance: number;
  outline: Vector[];
}

/** Positions are in map units; headings are counter-clockwise. */
export interface Appearance {
  scale: "metric" | "arbitrary";
  metres_per_unit: number | null;
  dropped: Count;
  nodes: AppearancePoint[];
  edges: AppearanceEdge[];
}

export interface AppearancePoint {
  id: Id;
  keyframe: null | Id;
  x: number;
  y: number;
  heading_rad: number;
}

export interface AppearanceEdge {
  a: Id;
  b: Id;
  kind: "odometry" | "loop";
  distance: number;
}

export interface AppearanceNode {
  id: Id;
  sequence: string;
  sequence_id: SequenceId;
  source: string;
  place: PlaceName;
  time_s: number | null;
  frame: Count;
  keyframe: null | Id;
  x: number;
  y: number;
  heading_rad: number;
  features: Count;
  image: string | null;
}

export interface AppearanceNodeList {
  nodes: AppearanceNode[];
  next: Next;
}

export interface Loop {
  a: Id;
  b: Id;
  distance: number;
  a_from_b: { x: number; y: number; heading_rad: number };
  deviation_rad: number;
}

export interface LoopList {
  loops: Loop[];
  next: Next;
}

/** Fourier transform of each row of the panorama from top to bottom; frequencies from 0. */
export interface Signature {
  node: Id;
  magnitudes: number[][];
  phases: number[][];
}

export interface Orientation {
  step: number;
  frames: OrientationColumns;
  nodes: OrientationNode[];
  edges: OrientationEdge[];
  turns: Turn[];
  corridors: Corridor[];
  /** Sequences of a single camera that does not cover the full circle, in which corridors can't be distinguished from rooms. */
  corridors_unknown: Id[];
}

/** All frames in columns. x and y are the trajectory reconstructed from turns, with one unit step per frame along the Manhattan axes, starting at 0 in each sequence; `lines_x`, `lines_y` and `lines_z` are the numbers of lines along each axis. */
export interface OrientationColumns {
  id: number[];
  sequence: number[];
  frame: number[];
  x: number[];
  y: number[];
  heading_rad: (number | null)[];
  reliable: boolean[];
  lines_x: number[];
  lines_y: number[];
  lines_z: number[];
}

/** Polylines in pixels of an image of the given size, each with the Manhattan axis it is parallel to. If the rotation of the frame is known (`of` is frame), the axes are those of the map; otherwise they are estimated in this image, with z the most vertical one. */
export interface DirectedLines {
  width: number;
  height: number;
  of: "frame" | "picture";
  reliable: boolean;
  lines: DirectedLine[];
}

export interface DirectedLine {
  axis: null | "x" | "y" | "z";
  points: Outline;
}

/** In the frame of the keyframe's camera (x right, y down, z forward). Lengths are multiples of the distance of `unit_plane`. `image_from_camera` is the linear part of the projection in pixels; `corners` are rays through the image corners, clockwise from the top left. */
export interface Space {
  keyframe: Id;
  views: Count;
  unit_plane: null | Id;
  image_from_camera: Matrix;
  corners: [Vector, Vector, Vector, Vector];
  planes: PlaneInSpace[];
}

/** The points X with normal . X = distance; `outline` consists of such points, in order around it. Planes that are not well determined have a `trouble` and null values. */
export interface PlaneInSpace {
  id: Id;
  trouble: null | "no_parallax" | "ambiguous" | "uncertain";
  normal: null | Vector;
  distance: number | null;
  normal_deviation_rad: number | null;
  distance_deviation: number | null;
  outline: Vector[];
}

export interface OrientationNode {
  id: Id;
  keyframe: null | Id;
  kind: "turn" | "frame";
  heading_rad: number | null;
  corridor: null | Id;
  /** Number of lines perpendicular to the direction of travel in the upper, right, lower and left cells of the image. */
  directions: [number, number, number, number];
  image: string | null;
}

export interface OrientationEdge {
  a: Id;
  b: Id;
  kind: "traversable" | "loop";
  matches: Count;
}

export interface OrientationFrame {
  id: Id;
  sequence: string;
  source: string;
  time_s: number | null;
  frame: Count;
  keyframe: null | Id;
  reliable: boolean;
  heading_rad: number | null;
  deviation_rad: number | null;
  building_from_head: null | Matrix;
  lines: [number, number, number];
}

export interface OrientationFrameList {
  frames: OrientationFrame[];
  next: Next;
}

export interface Turn {
  frame: Id;
  direction: "left" | "right";
  /** Change of the heading around the turn, positive to the left. */
  angle_rad: number;
  confirmed: boolean;
  axis_after: "x" | "y";
}

export interface TurnList {
  turns: Turn[];
  next: Next;
}

export interface Corridor {
  id: Id;
  axis: "x" | "y";
  first: Id;
  last: Id;
  nodes: Id[];
}

export interface CorridorList {
  corridors: Corridor[];
  next: Next;
}

export interface Map {
  name: string;
  version: string;
  program: string;
  feature_type: string;
  keyframes: Count;
  planes: Count;
  /** Number of surfaces that the planes are part of. */
  surfaces: number;
  edges: Count;
  features: Count;
  /** Number of named places. */
  names: number;
  /** Number of floor plans. */
  floor_plans: number;
  sequences: Sequence[];
  sessions: Session[];
  /** Connected sequences, one list per part of the map; nothing connects one part to another. */
  parts: Id[][];
}

/** What one build added to the map. A map that was never joined with another has one session. */
export interface Session {
  /** Name of the map that was joined, or of the walk that was added. */
  name: string;
  program: string;
  /** Version of that map's file; null for an added walk. */
  version: string | null;
  sequences: Id[];
  keyframes: Count;
  panoramas: Count;
  orientation_frames: Count;
  /** Time of its first image in the map. */
  from_s: number | null;
  /** Time of its last image in the map. */
  to_s: number | null;
}

export interface Sequence {
  id: Id;
  name: string;
  kind: string;
  frames: Count;
  skipped: Count;
  camera: null | Camera;
}

export interface Camera {
  model: string;
  width: Count;
  height: Count;
  params: number[];
}

export interface MapList {
  maps: Map[];
  next: Next;
}

/** UTC by the clock of the database, such as "2026-01-31T12:00:00.000Z"; null if it has not been reached. */
export type Time = string | null;

export interface JobWorker {
  /** Host and process. */
  worker: string;
  kind: StepKind;
  step: Count;
  /** Null before the first heartbeat. */
  stage: string | null;
}

/** `plan` inspects the sources, `part` builds some of their frames, `join` joins the parts and publishes the map. */
export type StepKind = "plan" | "part" | "join";

export interface Job {
  id: Id;
  /** Name of the map. */
  name: string;
  state: "queued" | "running" | "done" | "failed" | "cancelled";
  /** Why the job failed. */
  reason: string | null;
  /** Version that was published. */
  version: number | null;
  sources: string[];
  /** Options of `waystone build`. */
  options: string[];
  tags: string[];
  /** Frames of all parts; those in two parts count twice. Null until the sources have been inspected. */
  frames: number | null;
  frames_done: Count;
  /** Number of parts; 0 until the sources have been inspected. */
  parts: number;
  parts_done: Count;
  /** Attempts of all steps, including those that did not fail. */
  attempts: number;
  /** Workers that are working on the job. */
  workers: JobWorker[];
  created_at: Time;
  started_at: Time;
  ended_at: Time;
}

export interface JobList {
  jobs: Job[];
  next: Next;
}

export interface JobStep {
  number: Count;
  kind: StepKind;
  /** `waiting` until the parts are done, then `queued`. */
  state: "waiting" | "queued" | "leased" | "done";
  /** Number of frames of a part. */
  frames: number | null;
  frames_done: Count;
  stage: string | null;
  /** Progress of this stage. */
  done: number;
  /** Total of this stage; 0 if unknown. */
  total: number;
  failures: Count;
  worker: string | null;
  heartbeat_at: Time;
  lease_until: Time;
  /** SHA-256 of the map in the store. */
  sha256: string | null;
  bytes: number | null;
}

export interface JobAttempt {
  step: Count;
  worker: string;
  /** Null while the attempt is in progress. */
  outcome: "done" | "failed" | "released" | "expired" | "ended" | null;
  reason: string | null;
  started_at: Time;
  ended_at: Time;
}

export interface JobLogLine {
  at: Time;
  worker: string | null;
  message: string;
}

export interface JobDetails {
  id: Id;
  /** Name of the map. */
  name: string;
  state: "queued" | "running" | "done" | "failed" | "cancelled";
  /** Why the job failed. */
  reason: string | null;
  /** Version that was published. */
  version: number | null;
  sources: string[];
  /** Options of `waystone build`. */
  options: string[];
  tags: string[];
  /** Frames of all parts; those in two parts count twice. Null until the sources have been inspected. */
  frames: number | null;
  frames_done: Count;
  /** Number of parts; 0 until the sources have been inspected. */
  parts: number;
  parts_done: Count;
  /** Attempts of all steps, including those that did not fail. */
  attempts: number;
  /** Workers that are working on the job. */
  workers: JobWorker[];
  created_at: Time;
  started_at: Time;
  ended_at: Time;
  steps: JobStep[];
  history: JobAttempt[];
  log: JobLogLine[];
}

export interface PlaneSummary {
  id: Id;
  surface: SurfaceId;
  reference: ImageRef;
  features: Count;
  views: Count;
  neighbours: Id[];
  outline: Outline;
}

export interface Plane {
  id: Id;
  surface: SurfaceId;
  reference: ImageRef;
  features: Feature[];
  views: View[];
  neighbours: Id[];
  outline: Outline;
}

export interface PlaneList {
  planes: PlaneSummary[];
  next: Next;
}

export interface Feature {
  x_px: number;
  y_px: number;
  scale_px: number;
  angle_rad: number;
  votes: Count;
  visible: Count;
}

export interface FeatureList {
  features: Feature[];
  next: Next;
}

export interface View {
  keyframe: Id;
  inliers: Count;
  reference_from_keyframe: Matrix;
}

export interface ViewList {
  views: View[];
  next: Next;
}

export interface Graph {
  nodes: GraphNode[];
  edges: GraphEdge[];
}

export interface GraphNode {
  id: Id;
  surface: SurfaceId;
  reference: Id;
  features: Count;
}

export interface GraphEdge {
  a: Id;
  b: Id;
  from: Id;
  to: Id;
  homology: Matrix;
  third_eigenvalue: number;
}

export interface Keyframe {
  id: Id;
  sequence: string;
  sequence_id: SequenceId;
  source: string;
  place: PlaceName;
  time_s: number | null;
  stretch: Count;
  frame: Count;
  width: Count;
  height: Count;
  image: string | null;
  planes: SeenPlane[];
  /** Number of features on no plane by which the keyframe can also be recognised. */
  landmarks: number;
}

export interface SeenPlane {
  id: Id;
  surface: SurfaceId;
  inliers: Count;
  reference_from_keyframe: Matrix;
  outline: Outline;
}

export interface KeyframeList {
  keyframes: Keyframe[];
  next: Next;
}

export interface Audit {
  aliases: Alias[];
  ties: Tie[];
  weak: WeakRun[];
}

export interface AuditKeyframe {
  id: Id;
  sequence: string;
  source: string;
}

export interface Alias {
  a: AuditKeyframe;
  b: AuditKeyframe;
  inliers: Count;
  of_view: number;
  shared: number;
  planes: AliasPlanes[];
  remedy: string;
  advice: string;
}

export interface AliasPlanes {
  a: Id;
  b: Id;
  inliers: Count;
  shared: number;
}

export interface Tie {
  plane: Id;
  a: AuditKeyframe;
  b: AuditKeyframe;
  inliers: Count;
  advice: string;
}

export interface WeakRun {
  first: AuditKeyframe;
  last: AuditKeyframe;
  keyframes: Count;
  planes: Count;
  features: Count;
  weakness: string;
  remedy: string;
  advice: string;
}
