// SPDX-License-Identifier: Apache-2.0
// Made from clients/openapi.yaml by scripts/generate_js_client.py; don't edit.

// What the server or the way to it refused. `code` is the contract's, or "unreachable", "timeout" or
// "bad_answer"; `status` is 0 where no answer came.
export class WaystoneError extends Error {
  constructor(code, status, detail) {
    super(detail);
    this.name = "WaystoneError";
    this.code = code;
    this.status = status;
  }
}

const kLists = { listMaps: "maps", listJobs: "jobs", listPlanes: "planes", listFeatures: "features", listViews: "views", listKeyframes: "keyframes", listAppearanceNodes: "nodes", listLoops: "loops", listOrientationFrames: "frames", listTurns: "turns", listCorridors: "corridors" };
const kDefaultRetryS = 1;

const sleep = (ms) => new Promise((wake) => setTimeout(wake, ms));

// A photo as a request's body and its type. An object goes as JSON; a FormData brings its own type.
function bodyOf(photo) {
  if (photo instanceof FormData) return [photo, null];
  if (photo instanceof Blob) {
    return [photo, photo.type.startsWith("image/") ? photo.type : "application/octet-stream"];
  }
  if (photo instanceof ArrayBuffer || ArrayBuffer.isView(photo)) return [photo, "application/octet-stream"];
  return [JSON.stringify(photo), "application/json"];
}

function queryOf(options) {
  const given = Object.entries(options).filter(([, value]) => value !== undefined && value !== null);
  return given.length ? "?" + new URLSearchParams(given.map(([name, value]) => [name, String(value)])) : "";
}

async function problemOf(response) {
  let problem = null;
  try {
    problem = await response.json();
  } catch {
    // Told below: not every server that answers is ours.
  }
  if (typeof problem?.code === "string") {
    return new WaystoneError(problem.code, response.status, String(problem.detail ?? problem.title));
  }
  return new WaystoneError("bad_answer", response.status, `the server responded with ${response.status}, without JSON of Waystone`);
}

// Runs in browsers and in Node 18 and later, on fetch alone.
export class Client {
  constructor(server = "", { token = null, timeout_ms = 30000, retries = 2 } = {}) {
    this.server = server.replace(/\/+$/, "");
    this.token = token;
    this.timeout_ms = timeout_ms;
    this.retries = retries;
  }

  // One request: JSON parsed, an image as a Blob, else text. A server that is busy is asked again
  // after its Retry-After, `retries` times at most and not beyond the timeout.
  async ask(verb, path, options = {}, photo = undefined) {
    const end = Date.now() + this.timeout_ms;
    for (let left = this.retries; ; --left) {
      const response = await this.send(verb, path + queryOf(options), photo, end - Date.now());
      if (response.ok) return this.read(response);
      const after = Number(response.headers.get("Retry-After") ?? kDefaultRetryS);
      const wait = 1000 * (after >= 0 ? after : kDefaultRetryS);
      if (response.status !== 429 || left <= 0 || Date.now() + wait >= end) throw await problemOf(response);
      await sleep(wait);
    }
  }

  async send(verb, target, photo, patience_ms) {
    const headers = {};
    if (this.token) headers.Authorization = `Bearer ${this.token}`;
    const init = { method: verb, headers, signal: AbortSignal.timeout(Math.max(1, patience_ms)) };
    if (photo !== undefined) {
      const [body, type] = bodyOf(photo);
      init.body = body;
      if (type) headers["Content-Type"] = type;
    }
    try {
      return await fetch(this.server + target, init);
    } catch (error) {
      throw this.lost(error);
    }
  }

  async read(response) {
    const type = response.headers.get("Content-Type") ?? "";
    try {
      if (type.startsWith("application/json")) return await response.json();
      return type.startsWith("image/") ? await response.blob() : await response.text();
    } catch (error) {
      if (error instanceof SyntaxError) throw new WaystoneError("bad_answer", response.status, "the response is not JSON");
      throw this.lost(error);
    }
  }

  lost(error) {
    if (error.name === "TimeoutError") {
      return new WaystoneError("timeout", 0, `no answer within ${this.timeout_ms / 1000} s; increase timeout_ms`);
    }
    return new WaystoneError("unreachable", 0, "the server can't be reached; is it running?");
  }

  // Every row of a list, page by page: for await (const plane of client.rows("listPlanes", "lab")).
  async *rows(list, ...captures) {
    let cursor;
    do {
      const page = await this[list](...captures, { limit: 1000, cursor });
      yield* page[kLists[list]];
      cursor = page.next;
    } while (cursor);
  }

  contract() {
    return this.ask("GET", `/openapi.json`, {});
  }

  healthz() {
    return this.ask("GET", `/healthz`, {});
  }

  readyz() {
    return this.ask("GET", `/readyz`, {});
  }

  version() {
    return this.ask("GET", `/version`, {});
  }

  metrics() {
    return this.ask("GET", `/metrics`, {});
  }

  listMaps(options = {}) {
    return this.ask("GET", `/v1/maps`, options);
  }

  listJobs(options = {}) {
    return this.ask("GET", `/v1/jobs`, options);
  }

  getJob(id) {
    return this.ask("GET", `/v1/jobs/${encodeURIComponent(id)}`, {});
  }

  localizeAcross(photo, options = {}) {
    return this.ask("POST", `/v1/localize`, options, photo);
  }

  localize(map, photo, options = {}) {
    return this.ask("POST", `/v1/maps/${encodeURIComponent(map)}/localize`, options, photo);
  }

  getMap(map) {
    return this.ask("GET", `/v1/maps/${encodeURIComponent(map)}`, {});
  }

  listPlanes(map, options = {}) {
    return this.ask("GET", `/v1/maps/${encodeURIComponent(map)}/planes`, options);
  }

  getPlane(map, id) {
    return this.ask("GET", `/v1/maps/${encodeURIComponent(map)}/planes/${encodeURIComponent(id)}`, {});
  }

  listFeatures(map, id, options = {}) {
    return this.ask("GET", `/v1/maps/${encodeURIComponent(map)}/planes/${encodeURIComponent(id)}/features`, options);
  }

  listViews(map, id, options = {}) {
    return this.ask("GET", `/v1/maps/${encodeURIComponent(map)}/planes/${encodeURIComponent(id)}/views`, options);
  }

  getGraph(map, options = {}) {
    return this.ask("GET", `/v1/maps/${encodeURIComponent(map)}/graph`, options);
  }

  listKeyframes(map, options = {}) {
    return this.ask("GET", `/v1/maps/${encodeURIComponent(map)}/keyframes`, options);
  }

  getKeyframe(map, id) {
    return this.ask("GET", `/v1/maps/${encodeURIComponent(map)}/keyframes/${encodeURIComponent(id)}`, {});
  }

  getKeyframeImage(map, id, options = {}) {
    return this.ask("GET", `/v1/maps/${encodeURIComponent(map)}/keyframes/${encodeURIComponent(id)}/image`, options);
  }

  getKeyframeThumbnail(map, id) {
    return this.ask("GET", `/v1/maps/${encodeURIComponent(map)}/keyframes/${encodeURIComponent(id)}/thumbnail`, {});
  }

  getKeyframeLines(map, id) {
    return this.ask("GET", `/v1/maps/${encodeURIComponent(map)}/keyframes/${encodeURIComponent(id)}/lines`, {});
  }

  getKeyframeSpace(map, id) {
    return this.ask("GET", `/v1/maps/${encodeURIComponent(map)}/keyframes/${encodeURIComponent(id)}/space`, {});
  }

  getOverview(map) {
    return this.ask("GET", `/v1/maps/${encodeURIComponent(map)}/overview`, {});
  }

  getPoses(map) {
    return this.ask("GET", `/v1/maps/${encodeURIComponent(map)}/poses`, {});
  }

  getNames(map) {
    return this.ask("GET", `/v1/maps/${encodeURIComponent(map)}/names`, {});
  }

  getFloorPlans(map) {
    return this.ask("GET", `/v1/maps/${encodeURIComponent(map)}/plan`, {});
  }

  getFloorPlanImage(map, options = {}) {
    return this.ask("GET", `/v1/maps/${encodeURIComponent(map)}/plan/image`, options);
  }

  getAudit(map) {
    return this.ask("GET", `/v1/maps/${encodeURIComponent(map)}/audit`, {});
  }

  getAppearance(map) {
    return this.ask("GET", `/v1/maps/${encodeURIComponent(map)}/appearance`, {});
  }

  listAppearanceNodes(map, options = {}) {
    return this.ask("GET", `/v1/maps/${encodeURIComponent(map)}/appearance/nodes`, options);
  }

  getAppearanceNode(map, id) {
    return this.ask("GET", `/v1/maps/${encodeURIComponent(map)}/appearance/nodes/${encodeURIComponent(id)}`, {});
  }

  getAppearanceImage(map, id, options = {}) {
    return this.ask("GET", `/v1/maps/${encodeURIComponent(map)}/appearance/nodes/${encodeURIComponent(id)}/image`, options);
  }

  getSignature(map, id) {
    return this.ask("GET", `/v1/maps/${encodeURIComponent(map)}/appearance/nodes/${encodeURIComponent(id)}/signature`, {});
  }

  listLoops(map, options = {}) {
    return this.ask("GET", `/v1/maps/${encodeURIComponent(map)}/appearance/loops`, options);
  }

  getOrientation(map) {
    return this.ask("GET", `/v1/maps/${encodeURIComponent(map)}/orientation`, {});
  }

  listOrientationFrames(map, options = {}) {
    return this.ask("GET", `/v1/maps/${encodeURIComponent(map)}/orientation/frames`, options);
  }

  getOrientationFrame(map, id) {
    return this.ask("GET", `/v1/maps/${encodeURIComponent(map)}/orientation/frames/${encodeURIComponent(id)}`, {});
  }

  getOrientationImage(map, id, options = {}) {
    return this.ask("GET", `/v1/maps/${encodeURIComponent(map)}/orientation/nodes/${encodeURIComponent(id)}/image`, options);
  }

  getOrientationLines(map, id) {
    return this.ask("GET", `/v1/maps/${encodeURIComponent(map)}/orientation/nodes/${encodeURIComponent(id)}/lines`, {});
  }

  listTurns(map, options = {}) {
    return this.ask("GET", `/v1/maps/${encodeURIComponent(map)}/orientation/turns`, options);
  }

  listCorridors(map, options = {}) {
    return this.ask("GET", `/v1/maps/${encodeURIComponent(map)}/orientation/corridors`, options);
  }
}
