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
   * `server` is an address without path, or "" in a page that the server gave. `timeout_ms` may be
   * Infinity, which waits for weeks.
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
  /** Jobs of the registry, the newest first, at most 1000. */
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
  /** The named places, as the file that `waystone name MAP --from` reads. Names are given by that command, never by the server. */
  getNames(map: string): Promise<NamesFile>;
  /** The floor plans, which `waystone plan` puts into the map. */
  getFloorPlans(map: string): Promise<FloorPlans>;
  /** Image of a floor plan, as it was given. */
  getFloorPlanImage(map: string, options?: { name?: string }): Promise<Blob>;
  /** Weak spots of the map. The first request takes seconds and counts as a query; others meanwhile get 429. */
  getAudit(map: string): Promise<Audit>;
  /** The appearance layer, for visualization. 404 with the code no_layer for maps without one, as the following. */
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
  /** The orientation layer, for visualization. 404 with the code no_layer for maps without one, as the following. */
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

export interface Request {
  fx?: number;
  fy?: number;
  cx?: number;
  cy?: number;
  fov_deg?: number;
  camera?: string;
  /** Checked, but used by no layer so far, and so always listed in unused. */
  prior?: { keyframe: number };
  /** Narrows a query of all maps (/v1/localize) of a server of a registry. */
  hints?: { position?: { frame: string; x: number; y: number; z?: number; radius: number }; tags?: string[]; previous_map?: string };
  previous?: { keyframe?: number; heading_rad?: number; map_version?: string; belief?: Belief };
  /** For series of panoramas: the motion of each image since the previous image or answer, in map units (x forward, y left), or null. */
  odometry?: (null | { x: number; y: number; heading_rad: number })[];
  top_k?: number;
  debug?: boolean;
  deadline_ms?: number;
}

/** Belief about the position of the robot, most probable node first. The remaining probability is spread over the map. */
export type Belief = { node: Id; probability: Probability; heading_rad: number; deviation_rad: number }[];

export interface Problem {
  type: string;
  title: string;
  status: number;
  detail: string;
  /** Stable. Of status 503, which has Retry-After: not_ready, out_of_memory, and of servers of a registry registry_unavailable, store_unavailable, store_damaged (its file has other bytes than were published) and no_room (the bounds of memory or cache, or the disk, have no room for the map). */
  code: string;
}

export interface Ready {
  ready: true;
  /** Known by name. */
  maps: number;
  /** In memory; the others are opened when they are asked for. */
  open: number;
  /** Only of servers of a registry. */
  registry?: { connected: boolean; silent_s: number; memory_bytes: number; cached_files: number; cached_bytes: number; jobs: boolean; coarse: { maps: number; places: number; bytes: number; without: number; waiting: number } };
}

export interface Version {
  program: string;
  schema: number;
}

export type Id = number;

/** The surface, such as a wall, that the plane is a part of: the lowest id of its planes. */
export type SurfaceId = number;

/** The id in `sequences` of the map; two sequences may have one name. */
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

/** The place of a localized image, whatever the layer: the nearest keyframe (planes) or panorama (appearance) with its source image, and position and heading of the query where known. */
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

/** Position of the query on a floor plan of the map, in pixels of its image from the upper left corner to the right and downwards; null without a position of the query, or where no plan shows it. */
export interface PlanPosition {
  name: string;
  x: number;
  y: number;
}

/** What people called the place (`waystone name`), null where they did not: the narrowest of the named places that hold it. */
export type PlaceName = string | null;

/** In the frame and units of the appearance layer; `deviation` along the worst direction. `metres_per_unit` is null where the scale is unknown. */
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
  /** Planes that were seen together with this one in the map, and are not recognised in this image: what a camera that moves on may show next. */
  expect_next: Id[];
}

/** The query's matches with one keyframe, on planes and beside them, that fit one epipolar geometry. */
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
  /** The place where the plane layer answered, else null. */
  keyframe: null | KeyframeRef;
  heading: null | Heading;
  /** Only of maps with poses. Null where none is known; pose_reason says why. */
  pose?: null | Pose;
  pose_reason?: string;
  building?: BuildingView;
  planes: RecognisedPlane[];
  epipolar?: EpipolarMatches;
  panorama?: PanoramaPlace;
  belief?: Belief;
  /** If ambiguous: the keyframes of the places that match, of all maps. Panoramas have none; for several maps, `maps` has the place of each. */
  places?: Place[];
  /** Of the plane layer: the place that comes second, or the best one if it was refused. Null without one. That of panoramas is in `panorama`. */
  runner_up: null | RunnerUp;
  /** The test that decided the verdict. Of the plane layer: features, shortlist_votes, homography_inliers, epipolar_inliers, inlier_share, homography_scale, place_probability, ambiguous_places; of the appearance layer: panorama_signature, panorama_features, series, photo, photo_features; of the orientation layer: building_axes; of several maps: ambiguous_maps; before any layer: bad_image, image_too_large, deadline. docs/http-api.md says what each means. Later versions may have others. */
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
  /** If not all maps could be asked: those that the coarse index proposed, the likeliest first. Where all fit into memory but some could not be opened: all of them by name. */
  searched?: SearchedMap[];
  /** With `searched`: one of these maps was not asked, so that another answer is possible. */
  partial?: boolean;
  /** With `searched`: how many maps are not in the coarse index and can not be proposed. */
  unindexed?: number;
}

/** A map that was to be asked in a query of all maps. */
export interface SearchedMap {
  map: string;
  /** `late`: not opened or not answered by the deadline. `too_large`: beyond the memory that the server may use. */
  state: "asked" | "late" | "failed" | "too_large";
  /** By how much features of the image speak for the map; comparable within one answer only. 0 for `previous_map` where the index does not propose it, and where all maps were to be asked. */
  score: number;
  /** Why it was not asked. */
  message?: string;
}

/** The camera of the query in the frame of the poses that the map was built with. The camera has x right, y down, z forward; orientation is the quaternion x, y, z, w that turns its axes into those of the frame. The covariance is that of the position and of a small rotation about the axes of the frame, in the order of ROS: x, y, z, about x, about y, about z. `inliers` is 0 for a panorama that was localized by its appearance alone. `camera` says whose calibration was used; a panorama has its own. */
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

/** Result of the appearance layer: the nearest node and the position if localized, else null, and the candidates. */
export interface PanoramaPlace {
  node: null | NodeRef;
  position: null | PlacePosition;
  candidates: NodeCandidate[];
  /** The most probable node elsewhere, null without one. */
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

/** Named places by the images that they were made of, so that they can be used on a map built again of the same images. */
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

/** Images of a sequence from the first to the last. `sequence_number` is that among the sequences of this name, 1 where it is missing. */
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

/** A polygon seen from above. `right` and `top` are the unit vectors of the frame that its x and y are along; without them and `unit` it is in the frame of the appearance layer, called layer. */
export interface NamedArea {
  frame: string;
  unit?: "metres" | "unknown";
  right?: Vector;
  top?: Vector;
  corners: [number, number][];
}

/** Floor plans of the map, ordered by name. `right` and `top` are the unit vectors of the frame that x and y are along; without them and `unit` it is the frame of the appearance layer, called layer. */
export interface FloorPlans {
  frame: string;
  unit?: "metres" | "unknown";
  right?: Vector;
  top?: Vector;
  plans: FloorPlan[];
}

/** An image that the map is drawn on: px = `plan_from_frame` (x, y, 1), a rotation, a scale of `px_per_unit` and a translation. `residual` is the root mean square over the anchors, in the unit of the frame. `heights` are those of the positions that the plan shows, along right x top; null for all. */
export interface FloorPlan {
  name: string;
  /** Of the image, px. */
  width: number;
  /** Of the image, px. */
  height: number;
  /** Path of the image. */
  image: string;
  heights: null | { low: number; high: number };
  plan_from_frame: [Vector, Vector];
  px_per_unit: number;
  residual: number;
  anchors: PlanAnchor[];
}

/** A pixel of the image and its position in the frame, to the right and to the top. */
export interface PlanAnchor {
  px: Pair;
  at: Pair;
}

export type Pair = [number, number];

/** Keyframes, panoramas (nodes of the appearance layer) and planes in the frame of the poses that the map was built with; lengths in its unit. `up` points upwards: the mean direction of the tops of the images, null where they differ too much. `noise` is that of the given poses on each axis, null where none was measured. */
export interface PoseLayer {
  frame: string;
  unit: "metres" | "unknown";
  noise: { position_deviation: number | null; rotation_deviation_rad: number | null };
  up: null | Vector;
  keyframes: PosedImages;
  nodes: PosedImages;
  planes: PosedPlane[];
}

/** Those with a pose in columns, by id. orientation is the quaternion x, y, z, w that turns the axes of the camera (x right, y down, z forward) into those of the frame. */
export interface PosedImages {
  id: Id[];
  position: Vector[];
  orientation: [number, number, number, number][];
}

/** Points X with normal . X = distance; the normal points away from the camera of the reference keyframe. `outline` is that of its features, such points in order around, but for those that the reference image shows too flatly. */
export interface PosedPlane {
  id: Id;
  reference: Id;
  normal: Vector;
  distance: number;
  outline: Vector[];
}

/** Positions in map units; headings counter-clockwise. */
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
  /** Sequences taken by one camera that does not see all around, in which corridors can't be told from rooms. */
  corridors_unknown: Id[];
}

/** All frames in columns. x and y are the trajectory reconstructed from turns, with unit steps per frame along the Manhattan axes, starting at 0 in each sequence; lines are counts along the x, y and z axes. */
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

/** Points X with normal . X = distance; `outline` are such points, in order around. Planes that are not well determined have a trouble and null values. */
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
  /** Lines perpendicular to the direction of travel in the upper, right, lower and left cell of the image. */
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
  /** Surfaces that the planes are parts of. */
  surfaces: number;
  edges: Count;
  features: Count;
  /** Named places. */
  names: number;
  /** Floor plans. */
  floor_plans: number;
  sequences: Sequence[];
  sessions: Session[];
  /** Sequences that hang together, a list for each part of the map: from one part to another nothing leads. */
  parts: Id[][];
}

/** What one build put into the map. A map that was never joined with another is one session. */
export interface Session {
  /** Of the map that was joined */
  name: string;
  program: string;
  /** Of that map's file; null for an added walk. */
  version: string | null;
  sequences: Id[];
  keyframes: Count;
  panoramas: Count;
  orientation_frames: Count;
  /** Time of the first image that the map holds of it. */
  from_s: number | null;
  /** Time of the last one. */
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

/** UTC by the clock of the database, "2026-01-31T12:00:00.000Z"; null where it has not come. */
export type Time = string | null;

export interface JobWorker {
  /** Host and process. */
  worker: string;
  kind: StepKind;
  step: Count;
  /** Null before the first heartbeat. */
  stage: string | null;
}

/** plan looks at the sources, part builds some of their frames, join joins the parts and publishes the map. */
export type StepKind = "plan" | "part" | "join";

export interface Job {
  id: Id;
  /** Of the map. */
  name: string;
  state: "queued" | "running" | "done" | "failed" | "cancelled";
  /** Why it failed. */
  reason: string | null;
  /** That was published. */
  version: number | null;
  sources: string[];
  /** Of waystone build. */
  options: string[];
  tags: string[];
  /** Of all parts; frames of two parts count twice. Null before the sources were looked at. */
  frames: number | null;
  frames_done: Count;
  /** 0 before the sources were looked at. */
  parts: number;
  parts_done: Count;
  /** Of all steps, also those that did not fail. */
  attempts: number;
  /** That work on it. */
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
  /** waiting for the parts before it is queued. */
  state: "waiting" | "queued" | "leased" | "done";
  /** Of a part. */
  frames: number | null;
  frames_done: Count;
  stage: string | null;
  /** Of this stage. */
  done: number;
  /** 0 where it is not known. */
  total: number;
  failures: Count;
  worker: string | null;
  heartbeat_at: Time;
  lease_until: Time;
  /** Of the map in the store. */
  sha256: string | null;
  bytes: number | null;
}

export interface JobAttempt {
  step: Count;
  worker: string;
  /** Null while it is under way. */
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
  /** Of the map. */
  name: string;
  state: "queued" | "running" | "done" | "failed" | "cancelled";
  /** Why it failed. */
  reason: string | null;
  /** That was published. */
  version: number | null;
  sources: string[];
  /** Of waystone build. */
  options: string[];
  tags: string[];
  /** Of all parts; frames of two parts count twice. Null before the sources were looked at. */
  frames: number | null;
  frames_done: Count;
  /** 0 before the sources were looked at. */
  parts: number;
  parts_done: Count;
  /** Of all steps, also those that did not fail. */
  attempts: number;
  /** That work on it. */
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
  /** Features on no plane by which the keyframe can be recognized as well. */
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
