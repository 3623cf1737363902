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
const kLongestMs = 2 ** 31 - 1; // that a timer waits; with more it fires at once

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

const wrong = (detail) => new WaystoneError("bad_request", 0, detail);

// Without what would be sent elsewhere or refused by fetch, as if nobody were there. "" is the page's server.
function addressOf(server) {
  if (server === "" && globalThis.location) return "";
  let url = null;
  try {
    url = new URL(server);
  } catch {
    // Told below.
  }
  const http = url !== null && ["http:", "https:"].includes(url.protocol);
  if (!http || url.port === "0" || url.username || url.password) {
    throw wrong(`the address '${server}' is no server; it looks like http://127.0.0.1:8080`);
  }
  return url.origin + url.pathname.replace(/\/+$/, "");
}

// A value in a path. Half a character, which can't be sent, becomes U+FFFD, as in a query.
const segment = (value) => encodeURIComponent(String(value).replace(/\p{Surrogate}/gu, "\ufffd"));

// Whether a path has a value "." or "..", which fetch would resolve: for a map, to all maps.
const hasDots = (path) => /\/(\.|%2e){1,2}(\/|$)/i.test(path.split(/[?#]/)[0]);

function queryOf(options) {
  const given = Object.entries(options).filter(([, value]) => value !== undefined && value !== null);
  return given.length ? "?" + new URLSearchParams(given.map(([name, value]) => [name, String(value)])) : "";
}

// What a Content-Type is: "json", "image", "text", or "page", which no method asks for.
function kindOf(type) {
  const media = type.split(";")[0].trim().toLowerCase();
  if (media === "application/json") return "json";
  if (media.startsWith("image/")) return "image";
  return media === "text/html" || media === "application/xhtml+xml" ? "page" : "text";
}

const notOurs = (response, instead) =>
  new WaystoneError("bad_answer", response.status, `the server responded with ${instead}; check its address`);

async function problemOf(response) {
  let problem = null;
  try {
    problem = await response.json();
  } catch (error) {
    if (error.name === "TimeoutError") throw error;
    // Told below: not every server that answers is ours.
  }
  if (typeof problem?.code === "string") {
    return new WaystoneError(problem.code, response.status, String(problem.detail ?? problem.title));
  }
  // A browser doesn't tell the status of a redirect.
  const status = response.type === "opaqueredirect" ? "a redirect" : response.status;
  return notOurs(response, `${status}, without JSON of Waystone`);
}

// Runs in browsers and in Node 18 and later, on fetch alone.
export class Client {
  #token = null;

  constructor(server = "", { token = null, timeout_ms = 30000, retries = 2 } = {}) {
    this.server = addressOf(String(server));
    this.token = token;
    this.timeout_ms = timeout_ms;
    this.retries = retries;
  }

  get token() {
    return this.#token;
  }

  set token(token) {
    if (token && !/^[ -~]*[!-~][ -~]*$/.test(token)) {
      throw wrong("the token has characters that can't be sent; it must be printable ASCII");
    }
    this.#token = token;
  }

  // One request: JSON parsed, an image as a Blob, else text; another kind than `kind` ("json",
  // "image" or "text") is an error. A server that is busy is asked again after its Retry-After,
  // `retries` times at most and not beyond the timeout.
  async ask(verb, path, options = {}, photo = undefined, kind = null) {
    if (hasDots(path)) throw new WaystoneError("not_found", 404, `no resource at ${path}`);
    const end = Date.now() + this.patience();
    for (let left = this.retries; ; --left) {
      const response = await this.send(verb, path + queryOf(options), photo, end - Date.now());
      if (response.ok) return this.read(response, kind);
      const after = Number(response.headers.get("Retry-After") ?? kDefaultRetryS);
      const wait = 1000 * (after >= 0 ? after : kDefaultRetryS);
      if (response.status !== 429 || left <= 0 || Date.now() + wait >= end) throw await this.problem(response);
      await sleep(wait);
    }
  }

  // One query with a photo. Every answer has a verdict.
  async query(path, options, photo) {
    const answer = await this.ask("POST", path, options, photo, "json");
    if (typeof answer.verdict !== "string") throw new WaystoneError("bad_answer", 200, "the response has no verdict");
    return answer;
  }

  // The timeout as timers take it: Infinity waits for weeks.
  patience() {
    if (typeof this.timeout_ms !== "number" || Number.isNaN(this.timeout_ms)) {
      throw wrong(`timeout_ms is ${this.timeout_ms}; expected a number of milliseconds`);
    }
    return Math.min(this.timeout_ms, kLongestMs);
  }

  // Redirects aren't followed: what they lead to, as a proxy's page for logging in, is no answer.
  async send(verb, target, photo, patience_ms) {
    const headers = {};
    if (this.token) headers.Authorization = `Bearer ${this.token}`;
    const signal = AbortSignal.timeout(Math.max(1, patience_ms));
    const init = { method: verb, headers, signal, redirect: "manual" };
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

  async read(response, wanted) {
    const type = response.headers.get("Content-Type") ?? "";
    const kind = kindOf(type);
    if (kind === "page" || (wanted && kind !== wanted)) {
      throw notOurs(response, `${type || "something"} instead of ${wanted ?? "an answer"}`);
    }
    try {
      if (kind === "image") return await response.blob();
      if (kind === "text") return await response.text();
      const value = await response.json();
      // Every JSON of the contract is an object.
      if (typeof value === "object" && value !== null && !Array.isArray(value)) return value;
    } catch (error) {
      if (!(error instanceof SyntaxError)) throw this.lost(error);
    }
    throw notOurs(response, "JSON that isn't Waystone's");
  }

  async problem(response) {
    try {
      return await problemOf(response);
    } catch (error) {
      return this.lost(error);
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
      const rows = page[kLists[list]];
      if (!Array.isArray(rows)) throw new WaystoneError("bad_answer", 200, `the response has no ${kLists[list]}`);
      yield* rows;
      cursor = page.next;
    } while (cursor);
  }

  contract() {
    return this.ask("GET", `/openapi.json`, {}, undefined, "json");
  }

  healthz() {
    return this.ask("GET", `/healthz`, {}, undefined, "text");
  }

  readyz() {
    return this.ask("GET", `/readyz`, {}, undefined, "json");
  }

  version() {
    return this.ask("GET", `/version`, {}, undefined, "json");
  }

  metrics() {
    return this.ask("GET", `/metrics`, {}, undefined, "text");
  }

  listMaps(options = {}) {
    return this.ask("GET", `/v1/maps`, options, undefined, "json");
  }

  listJobs(options = {}) {
    return this.ask("GET", `/v1/jobs`, options, undefined, "json");
  }

  getJob(id) {
    return this.ask("GET", `/v1/jobs/${segment(id)}`, {}, undefined, "json");
  }

  localizeAcross(photo, options = {}) {
    return this.query(`/v1/localize`, options, photo);
  }

  localize(map, photo, options = {}) {
    return this.query(`/v1/maps/${segment(map)}/localize`, options, photo);
  }

  getMap(map) {
    return this.ask("GET", `/v1/maps/${segment(map)}`, {}, undefined, "json");
  }

  listPlanes(map, options = {}) {
    return this.ask("GET", `/v1/maps/${segment(map)}/planes`, options, undefined, "json");
  }

  getPlane(map, id) {
    return this.ask("GET", `/v1/maps/${segment(map)}/planes/${segment(id)}`, {}, undefined, "json");
  }

  listFeatures(map, id, options = {}) {
    return this.ask("GET", `/v1/maps/${segment(map)}/planes/${segment(id)}/features`, options, undefined, "json");
  }

  listViews(map, id, options = {}) {
    return this.ask("GET", `/v1/maps/${segment(map)}/planes/${segment(id)}/views`, options, undefined, "json");
  }

  getGraph(map, options = {}) {
    return this.ask("GET", `/v1/maps/${segment(map)}/graph`, options);
  }

  listKeyframes(map, options = {}) {
    return this.ask("GET", `/v1/maps/${segment(map)}/keyframes`, options, undefined, "json");
  }

  getKeyframe(map, id) {
    return this.ask("GET", `/v1/maps/${segment(map)}/keyframes/${segment(id)}`, {}, undefined, "json");
  }

  getKeyframeImage(map, id, options = {}) {
    return this.ask("GET", `/v1/maps/${segment(map)}/keyframes/${segment(id)}/image`, options, undefined, "image");
  }

  getKeyframeThumbnail(map, id) {
    return this.ask("GET", `/v1/maps/${segment(map)}/keyframes/${segment(id)}/thumbnail`, {}, undefined, "image");
  }

  getKeyframeLines(map, id) {
    return this.ask("GET", `/v1/maps/${segment(map)}/keyframes/${segment(id)}/lines`, {}, undefined, "json");
  }

  getKeyframeSpace(map, id) {
    return this.ask("GET", `/v1/maps/${segment(map)}/keyframes/${segment(id)}/space`, {}, undefined, "json");
  }

  getOverview(map) {
    return this.ask("GET", `/v1/maps/${segment(map)}/overview`, {}, undefined, "json");
  }

  getPoses(map) {
    return this.ask("GET", `/v1/maps/${segment(map)}/poses`, {}, undefined, "json");
  }

  getNames(map) {
    return this.ask("GET", `/v1/maps/${segment(map)}/names`, {}, undefined, "json");
  }

  getFloorPlans(map) {
    return this.ask("GET", `/v1/maps/${segment(map)}/plan`, {}, undefined, "json");
  }

  getFloorPlanImage(map, options = {}) {
    return this.ask("GET", `/v1/maps/${segment(map)}/plan/image`, options, undefined, "image");
  }

  getAudit(map) {
    return this.ask("GET", `/v1/maps/${segment(map)}/audit`, {}, undefined, "json");
  }

  getAppearance(map) {
    return this.ask("GET", `/v1/maps/${segment(map)}/appearance`, {}, undefined, "json");
  }

  listAppearanceNodes(map, options = {}) {
    return this.ask("GET", `/v1/maps/${segment(map)}/appearance/nodes`, options, undefined, "json");
  }

  getAppearanceNode(map, id) {
    return this.ask("GET", `/v1/maps/${segment(map)}/appearance/nodes/${segment(id)}`, {}, undefined, "json");
  }

  getAppearanceImage(map, id, options = {}) {
    return this.ask("GET", `/v1/maps/${segment(map)}/appearance/nodes/${segment(id)}/image`, options, undefined, "image");
  }

  getSignature(map, id) {
    return this.ask("GET", `/v1/maps/${segment(map)}/appearance/nodes/${segment(id)}/signature`, {}, undefined, "json");
  }

  listLoops(map, options = {}) {
    return this.ask("GET", `/v1/maps/${segment(map)}/appearance/loops`, options, undefined, "json");
  }

  getOrientation(map) {
    return this.ask("GET", `/v1/maps/${segment(map)}/orientation`, {}, undefined, "json");
  }

  listOrientationFrames(map, options = {}) {
    return this.ask("GET", `/v1/maps/${segment(map)}/orientation/frames`, options, undefined, "json");
  }

  getOrientationFrame(map, id) {
    return this.ask("GET", `/v1/maps/${segment(map)}/orientation/frames/${segment(id)}`, {}, undefined, "json");
  }

  getOrientationImage(map, id, options = {}) {
    return this.ask("GET", `/v1/maps/${segment(map)}/orientation/nodes/${segment(id)}/image`, options, undefined, "image");
  }

  getOrientationLines(map, id) {
    return this.ask("GET", `/v1/maps/${segment(map)}/orientation/nodes/${segment(id)}/lines`, {}, undefined, "json");
  }

  listTurns(map, options = {}) {
    return this.ask("GET", `/v1/maps/${segment(map)}/orientation/turns`, options, undefined, "json");
  }

  listCorridors(map, options = {}) {
    return this.ask("GET", `/v1/maps/${segment(map)}/orientation/corridors`, options, undefined, "json");
  }
}
