// SPDX-License-Identifier: Apache-2.0
// node page_test.mjs URL INSIDE.jpg ELSEWHERE.jpg [SCREENSHOT_FOLDER]: every view of the page, served
// at URL with the maps room, walls (of a calibrated camera) and turns (of a rig), in Debian's Chromium.
// Exit status: 0 on success, 1 after a message about what failed or is missing.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { ask, checkAccess, go as goTo, json, startBrowser } from "./browser.mjs";

const [url, inside, elsewhere, screenshots] = process.argv.slice(2);
const { open, shoot, shootWhole, run } = await startBrowser(url, screenshots);

const go = (page, view, heading, map = "room") => goTo(page, map, view, heading);

async function overview() {
  return (await fetch(`${url}/v1/maps/room/overview`)).json();
}

// Dropped as a person would, not chosen.
async function drop(page, photo) {
  const bytes = [...readFileSync(photo)];
  await page.evaluate((data) => {
    const transfer = new DataTransfer();
    transfer.items.add(new File([new Uint8Array(data)], "dropped.jpg", { type: "image/jpeg" }));
    document.querySelector(".chooser").dispatchEvent(
      new DragEvent("drop", { dataTransfer: transfer, bubbles: true, cancelable: true }));
  }, bytes);
  await page.locator(".verdict").waitFor();
  return page.locator(".verdict h2").innerText();
}

async function testAsk(page) {
  await go(page, "ask", "Where was this photo taken?");
  assert.match(await drop(page, inside), /Localized near keyframe \d+/);
  await page.locator("figure svg line").first().waitFor();
  assert.ok(await page.locator("figure svg line").count() >= 8, "lines of matches");
  assert.ok(await page.locator("figure .outline polygon").count() >= 2, "outlines on both pictures");
  const numbers = await page.locator(".facts").innerText();
  assert.match(numbers, /Probability\s*(over )?\d+%/);
  assert.match(numbers, /\d ms/);
  assert.ok((await page.locator(".curl pre").innerText()).includes(`${url}/v1/maps/room/localize`));
  await shoot(page, "ask");
  await checkAccess(page, "ask");
}

async function testWhy(page) {
  await page.getByRole("link", { name: "Why", exact: true }).click();
  await page.getByRole("heading", { level: 1, name: "Why this answer?" }).waitFor();
  assert.match(await page.locator("table").first().innerText(), /Accepted: best place/);
  await checkAccess(page, "why, localized");
  await go(page, "ask", "Where was this photo taken?");
  await ask(page, elsewhere);
  await page.locator(".verdict.not_in_map").waitFor();
  await go(page, "why", "Why this answer?");
  const stages = await page.locator(".stages").innerText();
  assert.match(stages, /0 planes\s+accepted/);
  await shoot(page, "why");
  await checkAccess(page, "why, not in the map");
}

async function testPlanes(page) {
  const { planes } = await overview();
  await go(page, "planes", "Plane graph");
  await page.locator(".graph canvas").first().waitFor();
  assert.equal(await page.locator("tbody tr").count(), Math.min(50, planes.id.length));
  const surfaces = new Set(planes.surface);
  assert.ok(surfaces.size < planes.id.length, "some planes are parts of one surface");
  await page.getByText(`${planes.id.length} planes on ${surfaces.size} surfaces`).waitFor();
  await screenshotOfColours(page, ".graph .canvas", 50);  // the graph shows its planes
  await shoot(page, "planes");
  await checkAccess(page, "planes");
  await go(page, `planes/${planes.id[0]}`, "Plane graph");
  await page.locator(".panel .dots circle").first().waitFor();
  const shared = planes.id.filter((_, i) => planes.surface.filter((s) => s === planes.surface[i]).length > 1);
  await go(page, `planes/${shared[1]}`, "Plane graph");
  await page.locator(".panel").getByText("with").getByRole("link", { name: `${shared[0]}`, exact: true }).waitFor();
  await checkAccess(page, "a plane");
}

const getJson = async (path) => (await fetch(url + path)).json();

// The orientation layer of a rig that went around a corner: its map, its plots, and a node.
async function testOrientation(page) {
  const layer = await getJson("/v1/maps/turns/orientation");
  const turn = layer.turns.find((t) => t.confirmed);
  assert.ok(turn, "the walk around the corner has a turn");
  await go(page, "orientation", "Turns and corridors", "turns");
  await page.locator(".trajectory-map .turn path").first().waitFor();
  assert.equal(await page.locator(".trajectory-map g .mark").count(), layer.nodes.length);
  assert.equal(await page.locator(".trajectory-map .corridor").count(), layer.corridors.length);
  await page.locator(".series canvas").nth(1).waitFor();
  assert.equal(await page.locator(".series canvas").count(), 2, "heading and lines");
  await page.locator(".trajectory-map .turn path").first().click();
  await page.waitForURL(new RegExp(`orientation/${turn.frame}$`));
  await page.locator(".facts", { hasText: `Turn${turn.direction}` }).waitFor();
  const cells = layer.nodes.find((n) => n.id === turn.frame).directions;
  assert.deepEqual((await page.locator(".cells text:not(.name)").allTextContents()).map(Number), cells);
  const { lines } = await getJson(`/v1/maps/turns/orientation/nodes/${turn.frame}/lines`);
  await page.waitForFunction((n) => document.querySelectorAll(".directed polyline").length === n, lines.length);
  assert.ok(lines.length > 5, "its picture has lines");
  for (const axis of ["x", "y", "z"]) {
    const along = lines.filter((l) => l.axis === axis).length;
    assert.equal(await page.locator(`.directed polyline.${axis}`).count(), along, `lines along ${axis}`);
  }
  const plot = await page.locator(".series canvas").first().screenshot();
  assert.ok(await distinctColours(page, plot) > 5, "the heading is drawn");
  await shootWhole(page, "orientation");
  await checkAccess(page, "orientation");
  await page.getByRole("link", { name: "Next node" }).or(page.getByRole("link", { name: "Previous node" })).first().click();
  await page.waitForURL((to) => !to.hash.endsWith(`/${turn.frame}`));
  await page.getByLabel("Frame", { exact: true }).fill(`${layer.frames.frame[7]}`);
  await page.keyboard.press("Enter");
  await page.waitForURL(new RegExp(`orientation/${layer.frames.id[7]}$`));
}

// The same layer with a corridor, a turn of the camera alone and a loop, which its short walk hasn't.
async function testCorridors() {
  const { page, complaints, close } = await open({});
  const layer = await getJson("/v1/maps/turns/orientation");
  const at = layer.turns[0].frame;
  layer.corridors = [{ id: 1, axis: "x", first: 3, last: at - 3, nodes: [] }];
  layer.turns.push({ frame: at + 5, direction: "left", angle_rad: 1.5, confirmed: false, axis_after: "y" });
  layer.edges.push({ a: layer.nodes[0].id, b: layer.nodes.at(-1).id, kind: "loop", matches: 60 });
  await page.route("**/turns/orientation", (route) => route.fulfill(json(layer)));
  await page.goto(`${url}/#/turns/orientation/${at}`);
  await page.locator(".trajectory-map .false-turn").click();
  await page.waitForURL(new RegExp(`orientation/${at + 5}$`));
  await page.locator(".facts", { hasText: "left (camera only)" }).waitFor();
  assert.equal(await page.locator(".trajectory-map .corridor").count(), 1);
  assert.equal(await page.locator(".trajectory-map .loop").count(), 1);
  assert.match(await page.getByRole("region", { name: "Corridors" }).innerText(), /1\s+x/);
  assert.match(await page.getByRole("region", { name: "Loop closures" }).innerText(), /60/);
  await shootWhole(page, "corridors");
  await checkAccess(page, "corridors");
  assert.deepEqual(complaints, []);
  await close();
}

// A walk of more frames than a call has arguments, in two sequences: a node of the first one is none of the second.
async function testLongWalk() {
  const { page, complaints, close } = await open({});
  const layer = await getJson("/v1/maps/turns/orientation");
  const kFrames = 150_000;
  const rows = Array.from({ length: kFrames }, (_, i) => i);
  const column = (value) => rows.map(() => value);
  layer.frames = {
    id: rows.map((i) => i + 1), sequence: rows.map((i) => (i < kFrames - 100 ? 1 : 2)), frame: rows,
    x: rows, y: rows.map((i) => i % 50), heading_rad: column(null), reliable: column(false),
    lines_x: column(1), lines_y: column(2), lines_z: column(3),
  };
  layer.nodes = [{ ...layer.nodes[0], id: 5 }];
  [layer.edges, layer.turns, layer.corridors] = [[], [], []];
  await page.route("**/turns/orientation", (route) => route.fulfill(json(layer)));
  await page.route("**/turns/orientation/frames/*", (route) => route.fulfill(json({
    id: 1, sequence: "walk", source: "1.jpg", time_s: null, frame: 1, keyframe: null, reliable: false,
    heading_rad: null, deviation_rad: null, building_from_head: null, lines: [1, 2, 3],
  })));
  await page.goto(`${url}/#/turns/orientation/9`);
  await page.getByRole("img", { name: `1 nodes in ${kFrames - 100} frames` }).waitFor();
  await page.getByRole("heading", { name: /Previous node, frame 4/ }).waitFor();
  assert.equal(await page.getByRole("link", { name: "Previous node" }).count(), 1);
  await go(page, `orientation/${kFrames}`, "Turns and corridors", "turns");
  await page.getByRole("img", { name: "0 nodes in 100 frames" }).waitFor();
  await page.locator(".facts").waitFor();
  assert.equal(await page.getByText("Previous node, frame").count(), 0);
  assert.equal(await page.getByRole("link", { name: "Previous node" }).count(), 0);
  assert.deepEqual(complaints, []);
  await close();
}

// A keyframe that has planes with a place: lines by direction, and planes in space.
async function testSpace(page) {
  const { keyframes } = await getJson("/v1/maps/walls/keyframes");
  const spaces = await Promise.all(keyframes.map((k) => getJson(`/v1/maps/walls/keyframes/${k.id}/space`)));
  const placed = (space) => space.planes.filter((p) => p.trouble === null).length;
  const best = spaces.reduce((a, b) => (placed(b) > placed(a) ? b : a));
  assert.ok(placed(best) >= 2, "a keyframe sees both walls in space");
  await go(page, `keyframes/${best.keyframe}`, `Keyframe ${best.keyframe}`, "walls");
  await page.getByLabel("Show lines coloured by Manhattan axis").check();
  await page.locator(".directed polyline").first().waitFor({ state: "attached" });
  await page.getByRole("button", { name: "Show planes in 3D" }).click();
  await page.locator(".space canvas").waitFor();
  const seen = await screenshotOfColours(page, ".space", 40);  // the planes have their pictures
  await page.getByRole("button", { name: "Top" }).click();
  assert.notDeepEqual(await page.locator(".space").screenshot(), seen, "it turns");
  await page.getByRole("button", { name: "Behind the camera" }).click();
  await shootWhole(page, "space");
  await checkAccess(page, "planes in space");
}

// Of what is drawn late: as soon as it has more than so many colours.
async function screenshotOfColours(page, selector, colours) {
  for (let tries = 0; tries < 100; tries++) {
    const picture = await page.locator(selector).screenshot();
    if (await distinctColours(page, picture) > colours) return picture;
    await page.waitForTimeout(100);
  }
  assert.fail(`${selector} never has ${colours} colours`);
}

// How many colours a picture has, to 4 bits a channel.
function distinctColours(page, png) {
  return page.evaluate(async (base64) => {
    const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
    const bitmap = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
    const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
    const context = canvas.getContext("2d");
    context.drawImage(bitmap, 0, 0);
    const { data } = context.getImageData(0, 0, bitmap.width, bitmap.height);
    const colours = new Set();
    for (let i = 0; i < data.length; i += 4) {
      colours.add(((data[i] >> 4) << 8) | ((data[i + 1] >> 4) << 4) | (data[i + 2] >> 4));
    }
    return colours.size;
  }, png.toString("base64"));
}

async function testKeyframes(page) {
  const { keyframes } = await overview();
  const seeing = keyframes.id[keyframes.planes.findIndex((n) => n > 0)];
  await go(page, "keyframes", "Keyframes");
  assert.equal(await page.locator(".grid li").count(), Math.min(60, keyframes.id.length));
  await checkAccess(page, "keyframes");
  await go(page, `keyframes/${seeing}`, `Keyframe ${seeing}`);
  await page.locator(".outline polygon").first().waitFor();
  const drawn = await page.locator(".outline polygon").count();
  const { planes } = await getJson(`/v1/maps/room/keyframes/${seeing}`);
  const colours = await page.locator("tbody .swatch").evaluateAll((all) => all.map((s) => s.style.color));
  planes.forEach(({ surface }, i) => {
    const first = planes.findIndex((p) => p.surface === surface);
    assert.equal(colours[i], colours[first], "planes of one surface have one colour");
  });
  await page.getByRole("checkbox", { name: "draw plane" }).first().uncheck();
  assert.equal(await page.locator(".outline polygon").count(), drawn - 1, "one outline less");
  await shoot(page, "keyframe");
  await checkAccess(page, "a keyframe");
}

async function testCoverage(page) {
  await go(page, "coverage", "Coverage");
  await page.getByRole("heading", { name: /Weak keyframes/ }).waitFor();
  await page.locator(".series canvas").waitFor();
  await shoot(page, "coverage");
  await checkAccess(page, "coverage");
  await page.getByLabel("Keyframe", { exact: true }).fill("3");
  await page.keyboard.press("Enter");
  await page.getByRole("heading", { level: 1, name: "Keyframe 3" }).waitFor();
}

// The walk's map has one named place, its first three keyframes; another is composed and downloaded.
async function testNames(page, complaints) {
  const { keyframes } = await overview();
  const [first, second, third, fourth] = keyframes.id;
  assert.deepEqual(keyframes.place.slice(0, 4), ["Door <&>", "Door <&>", "Door <&>", null]);
  await go(page, "keyframes", "Keyframes");
  assert.match(await page.locator(".grid li").first().innerText(), /Door <&>/);
  await go(page, "names", "Named places");
  assert.equal(await page.locator(".names tbody tr").count(), 1);
  const fill = (label, text) => page.getByLabel(label, { exact: true }).fill(String(text));
  await fill("First keyframe", fourth);
  await fill("Name", "x".repeat(201));
  await page.getByRole("button", { name: "Add" }).click();
  assert.match(await page.locator(".failure").innerText(), /at most 200 bytes/);
  await fill("Name", "Window");
  await fill("First keyframe", 1_000_000);
  await page.getByRole("button", { name: "Add" }).click();
  assert.match(await page.locator(".failure").innerText(), /no keyframe 1000000/);
  assert.match(complaints.pop() ?? "", /404/, "the browser logs the answer");
  await fill("First keyframe", fourth);
  await fill("Last keyframe", second);  // backwards, as people may give them
  await page.getByRole("button", { name: "Add" }).click();
  await page.locator(".names tbody tr").nth(1).waitFor();
  assert.equal(await page.locator(".failure").count(), 0);
  await shoot(page, "names");
  await checkAccess(page, "names");
  const waiting = page.waitForEvent("download");
  await page.getByRole("link", { name: "Download room-names.json" }).click();
  const file = JSON.parse(readFileSync(await (await waiting).path(), "utf8"));
  const stored = await getJson("/v1/maps/room/names");
  assert.deepEqual(file.places[0], stored.places[0]);
  const [a, b] = await Promise.all([second, fourth].map((id) => getJson(`/v1/maps/room/keyframes/${id}`)));
  assert.deepEqual(file.places[1], {
    name: "Window",
    keyframes: [{ sequence: a.sequence, first: { image: a.source, frame: a.frame }, last: { image: b.source, frame: b.frame } }],
    nodes: [], planes: [], polygons: [],
  });
  assert.equal(a.place, "Door <&>");
  await page.getByRole("button", { name: "Remove Door" }).click();
  assert.equal(await page.locator(".names tbody tr").count(), 1);
  assert.ok(first < second && second < third);
}

// Two sequences of one name, the first of which took panoramas: a keyframe has the camera of its own one, and
// is named in it.
async function testNamesakes() {
  const { page, complaints, close } = await open({});
  const summary = await getJson("/v1/maps/room");
  const [own] = summary.sequences;
  const other = { ...own, id: 1000, camera: { model: "EQUIRECTANGULAR", width: 640, height: 480, params: [] } };
  summary.sequences = [other, own];
  await page.route("**/v1/maps?*", (route) => route.fulfill(json({ maps: [summary], next: null })));
  await page.route("**/keyframes/3", async (route) => {
    const keyframe = await (await route.fetch()).json();
    await route.fulfill(json({ ...keyframe, sequence_id: other.id }));
  });
  await page.goto(`${url}/#/room/keyframes/1`);
  await page.locator(".facts").waitFor();
  assert.equal(await page.locator(".panorama").count(), 0);
  await go(page, "keyframes/3", "Keyframe 3");
  await page.locator(".panorama").waitFor();
  await go(page, "names", "Named places");
  const name = async (first, last, text) => {
    await page.getByLabel("First keyframe").fill(first);
    await page.getByLabel("Last keyframe").fill(last);
    await page.getByLabel("Name", { exact: true }).fill(text);
    await page.getByRole("button", { name: "Add" }).click();
  };
  await name("1", "3", "Both");
  await page.locator(".failure", { hasText: "belong to different sequences" }).waitFor();
  await name("1", "2", "Second");
  await page.locator(".names tbody tr").nth(1).waitFor();
  await name("3", "3", "First");
  await page.locator(".names tbody tr").nth(2).waitFor();
  const said = await page.locator(".names tbody tr").allInnerTexts();
  assert.match(said.find((row) => row.startsWith("Second")), / of images number 2/);
  const waiting = page.waitForEvent("download");
  await page.getByRole("link", { name: "Download room-names.json" }).click();
  const { places } = JSON.parse(readFileSync(await (await waiting).path(), "utf8"));
  const numberOf = (place) => places.find((p) => p.name === place).keyframes[0].sequence_number;
  assert.deepEqual([numberOf("First"), numberOf("Second")], [undefined, 2]);
  assert.deepEqual(complaints, []);
  await close();
}

// A map that changes while the page is open, as the server answers: what was asked of the old one is asked
// anew, and its answer goes.
async function testNewVersion() {
  const { page, complaints, close } = await open({});
  let [version, said] = ["sha256:one", "old"];
  const summary = await getJson("/v1/maps/room");
  await page.route("**/v1/maps?*", (route) => route.fulfill(json({ maps: [{ ...summary, version }], next: null })));
  await page.route("**/v1/maps/room", (route) => route.fulfill(json({ ...summary, version })));
  await page.route("**/overview", async (route) => {
    const known = await (await route.fetch()).json();
    known.keyframes.place.fill(said);
    await route.fulfill(json(known));
  });
  await page.route("**/localize?*", async (route) => {
    const answer = await (await route.fetch()).json();
    await route.fulfill(json({ ...answer, map_version: version }));
  });
  const places = page.locator(".grid li", { hasText: said });
  const pictures = () => page.locator(".thumbnail img").evaluateAll((all) => all.map((img) => img.src));
  await page.goto(`${url}/#/room/keyframes`);
  await places.first().waitFor();
  const before = await pictures();
  await go(page, "ask", "Where was this photo taken?");
  await ask(page, inside);
  [version, said] = ["sha256:two", "new"];
  await go(page, "keyframes", "Keyframes");
  await page.locator(".grid li", { hasText: "new" }).first().waitFor();
  assert.ok((await pictures()).every((src) => !before.includes(src)), "pictures have other addresses");
  await go(page, "ask", "Where was this photo taken?");
  assert.equal(await page.locator(".verdict").count(), 0, "the answer was of the old version");
  [version, said] = ["sha256:three", "newest"];
  await ask(page, inside);
  await page.locator("footer code", { hasText: "three" }).waitFor();
  assert.equal(await page.locator(".verdict").count(), 1, "the answer is of the new version");
  await go(page, "keyframes", "Keyframes");
  await page.locator(".grid li", { hasText: "newest" }).first().waitFor();
  version = "sha256:four";
  await page.getByRole("button", { name: "Refresh the list of maps" }).click();
  await page.locator("footer code", { hasText: "four" }).waitFor();
  assert.deepEqual(complaints, []);
  await close();
}

// An address of a map that the server hasn't got.
async function testNoMap() {
  const { page, complaints, close } = await open({});
  await page.goto(`${url}/#/warehouse/keyframes/2`);
  await page.getByText("This server has no map “warehouse”.").waitFor();
  assert.deepEqual(await page.locator("main a").allTextContents(), ["room", "turns", "walls"]);
  await checkAccess(page, "no such map");
  await page.getByRole("link", { name: "room" }).click();
  await page.getByRole("heading", { name: "Where was this photo taken?" }).waitFor();
  assert.deepEqual(complaints, []);
  await close();
}

// Addresses of what the map or the page hasn't got: nothing else is shown in its place.
async function testNothingThere() {
  const { page, complaints, close } = await open({});
  for (const [address, name] of [["nosuch", "nosuch"], ["keyframes/x", "keyframes/x"]]) {
    await page.goto(`${url}/#/room/${address}`);
    await page.getByRole("heading", { level: 1, name: "No such view" }).waitFor();
    await page.getByRole("alert").getByText(`no view “${name}”`).waitFor();
    assert.equal(await page.locator("nav a[aria-current]").count(), 0);
  }
  await checkAccess(page, "no such view");
  await page.getByRole("navigation").getByRole("link", { name: "Localize" }).click();
  await page.getByRole("heading", { name: "Where was this photo taken?" }).waitFor();
  await go(page, "orientation/999999", "Turns and corridors", "turns");
  await page.getByRole("alert").getByText("no frame 999999").waitFor();
  assert.equal(await page.locator(".facts").count(), 0);
  await checkAccess(page, "no such frame");
  await page.getByRole("link", { name: "First frame" }).click();
  await page.locator(".facts").waitFor();
  const known = await overview();
  await page.route("**/room/overview", (route) => route.fulfill(json({ ...known, layers: ["appearance"] })));
  await page.route("**/room/appearance", (route) => route.fulfill(json({
    scale: "metric", nodes: [{ id: 1, keyframe: null, x: 0, y: 0, heading_rad: 0 }], edges: [],
  })));
  await page.route("**/room/appearance/nodes/99", (route) => route.fulfill({ ...json({
    code: "not_found", detail: "no node 99 in this map" }), status: 404 }));
  await page.goto(`${url}/`);
  await go(page, "layers/99", "Trajectory");
  await page.getByRole("alert").getByText("no node 99").waitFor();
  assert.equal(await page.locator(".trajectory circle.chosen").count(), 0);
  assert.deepEqual(complaints.filter((said) => !/404/.test(said)), []);
  await close();
}

// A photo that is refused: the answer of the one before goes.
async function testRefusedPhoto() {
  const { page, complaints, close } = await open({});
  await page.goto(`${url}/`);
  await ask(page, inside);
  await page.route("**/localize?*", (route) => route.fulfill({ ...json({
    code: "payload_too_large", detail: "the body is too large" }), status: 413 }));
  await page.setInputFiles(".chooser input >> nth=0", elsewhere);
  await page.getByRole("alert").getByText("the body is too large").waitFor();
  assert.equal(await page.locator(".answer").count(), 0);
  assert.deepEqual(complaints.filter((said) => !/413/.test(said)), []);
  await close();
}

// A name without a space to break it at makes no view wider than its window.
async function testLongName() {
  const name = "x".repeat(240);
  const { page, complaints, close } = await open({});
  await page.route(/\/v1\/maps/, async (route) => {
    const answer = await route.fetch({ url: route.request().url().replace(name, "room") });
    if (!/json/.test(answer.headers()["content-type"])) return route.fulfill({ response: answer });
    const value = await answer.json();
    if (value.name) value.name = name;
    if (value.maps) value.maps = [{ ...value.maps[0], name }];
    return route.fulfill(json(value));
  });
  const views = [["ask", /Where/], ["why", /Why/], ["planes", /Plane graph/], ["keyframes", /Keyframes/],
    ["keyframes/1", /Keyframe 1/], ["layers", /Trajectory/], ["coverage", /Coverage/], ["names", /Named/], ["nosuch", /No such/]];
  for (const width of [320, 1200]) {
    await page.setViewportSize({ width, height: 740 });
    await page.goto(`${url}/`);
    await page.locator(`select[title="${name}"]`).waitFor();
    for (const [view, heading] of views) {
      await go(page, view, heading, name);
      const wide = await page.evaluate(() => document.documentElement.scrollWidth);
      assert.ok(wide <= width, `${view} is ${wide} px wide in ${width}`);
    }
  }
  await page.setViewportSize({ width: 320, height: 740 });
  await page.goto(`${url}/#/${"y".repeat(240)}/ask`);
  await page.getByRole("heading", { name: "No such map" }).waitFor();
  assert.ok(await page.evaluate(() => document.documentElement.scrollWidth) <= 320, "no such map");
  assert.deepEqual(complaints.filter((said) => !/404/.test(said)), []);
  await close();
}

// A view that can't be loaded says so, as does one that can't be drawn; the others can be chosen.
async function testFailures() {
  const { page, complaints, close } = await open({});
  await page.route(/\/page\/coverage-.*\.js$/, (route) => route.abort());
  await page.route("**/maps/walls/overview", (route) => route.fulfill(json({ layers: [] })));
  await page.goto(`${url}/#/room/coverage`);
  await page.getByRole("alert").getByText("The view can’t be loaded").waitFor();
  await page.getByRole("button", { name: "Reload the page" }).waitFor();
  await checkAccess(page, "a view that isn't loaded");
  await page.goto(`${url}/#/walls/keyframes`);
  await page.getByRole("alert").getByText("this view can’t be shown").waitFor();
  await page.getByRole("link", { name: "Localize" }).click();
  await page.getByRole("heading", { name: "Where was this photo taken?" }).waitFor();
  assert.deepEqual(complaints.filter((said) => !/ERR_FAILED/.test(said)), []);
  await close();
}

// A browser without WebGL says what it can't draw.
async function testNoWebGl() {
  const { page, complaints, close } = await open({});
  await page.addInitScript(() => {
    const get = HTMLCanvasElement.prototype.getContext;
    HTMLCanvasElement.prototype.getContext = function (kind, ...options) {
      return /webgl/.test(kind) ? null : get.call(this, kind, ...options);
    };
  });
  await page.goto(`${url}/#/room/planes`);
  await page.getByText("The graph can’t be drawn: this browser has no WebGL").waitFor();
  assert.ok(await page.locator("tbody tr").count() > 0, "the table is there");
  await page.goto(`${url}/#/walls/keyframes/2`);
  await page.getByRole("button", { name: "Show planes in 3D" }).click();
  await page.getByText("Planes can’t be drawn in 3D: this browser has no WebGL").waitFor();
  await checkAccess(page, "a browser without WebGL");
  assert.deepEqual(complaints, []);
  await close();
}

// A keyframe without planes: whether a query from there can be localized.
async function testLandmarks() {
  const { page, complaints, close } = await open({});
  let landmarks = 12;
  await page.route("**/keyframes/*", async (route) => {
    const keyframe = await (await route.fetch()).json();
    await route.fulfill(json({ ...keyframe, planes: [], landmarks }));
  });
  await page.goto(`${url}/#/room/keyframes/1`);
  await page.getByText("the keyframe is recognised by its 12 landmarks").waitFor();
  landmarks = 0;
  await go(page, "keyframes/2", "Keyframe 2");
  await page.getByText("a query from here can’t be localized").waitFor();
  assert.deepEqual(complaints, []);
  await close();
}

async function testLayers(page) {
  await go(page, "layers", "Trajectory");
  await page.getByText("has no appearance layer").waitFor();
  await page.getByText("has no orientation layer").waitFor();
  assert.equal(await page.getByRole("heading", { name: "Sessions" }).count(), 0, "one session, no table");
  assert.equal(await page.locator(".pose-map").count(), 0, "no poses, no drawing of them");
  await shoot(page, "layers");
  await checkAccess(page, "layers");
}

// A map that was joined of two, as the endpoints answer.
async function testSessions() {
  const { page, complaints, close } = await open({});
  const session = { program: "waystone 0.1.0", sequences: [1], keyframes: 12, panoramas: 0, orientation_frames: 0 };
  await page.route(/\/v1\/maps(\?.*)?$/, async (route) => {
    const answer = await route.fetch();
    const list = await answer.json();
    list.maps = list.maps.map((map) => ({
      ...map,
      sessions: [{ ...session, name: "morning", version: `sha256:${"ab".repeat(32)}`, from_s: 0, to_s: 61.26 },
        { ...session, name: "evening <&>", version: null, keyframes: 0, panoramas: 34,
          from_s: null, to_s: null }],
      parts: [[1], [1]],
    }));
    await route.fulfill(json(list));
  });
  await page.goto(`${url}/#/room/layers`);
  await page.getByRole("heading", { name: "Sessions" }).waitFor();
  await page.getByText("2 parts that have no views in common").waitFor();
  const rows = page.locator("section", { hasText: "Built with" }).locator("tbody tr");
  assert.match(await rows.nth(0).innerText(), /^morning\s.*\(1\)\s12\s0\s0 to 61\.3\swaystone 0\.1\.0\ssha256:abababab$/);
  assert.match(await rows.nth(1).innerText(), /^evening <&>\s.*\s0\s34\s.*added walk$/);
  await shoot(page, "sessions");
  await checkAccess(page, "sessions");
  assert.deepEqual(complaints, []);
  await close();
}

// Jobs of a registry in each state; this server has none.
async function testJobs() {
  const { page, complaints, close } = await open({});
  const job = { version: null, reason: null, options: [], tags: [], attempts: 1, workers: [], started_at: null,
    ended_at: null, created_at: "2026-01-31T12:00:00.000Z", sources: ["/data/lab <walk>"] };
  await page.route("**/readyz", async (route) => {
    const ready = await (await route.fetch()).json();
    await route.fulfill(json({ ...ready, registry: { jobs: true } }));
  });
  await page.route(/\/v1\/jobs(\?.*)?$/, (route) => route.fulfill(json({ next: null, jobs: [
    { ...job, id: 3, name: "hall", state: "queued", frames: null, frames_done: 0, parts: 0, parts_done: 0 },
    { ...job, id: 2, name: "lab", state: "running", frames: 4000, frames_done: 1000, parts: 2, parts_done: 1,
      workers: [{ worker: "host:7", kind: "part", step: 2, stage: "frames" }] },
    { ...job, id: 1, name: "attic", state: "failed", frames: 10, frames_done: 0, parts: 1, parts_done: 0,
      reason: "no plane or landmark found" },
  ] })));
  await page.goto(`${url}/#/room/ask`);
  await page.getByRole("link", { name: "Jobs", exact: true }).click();
  await page.getByRole("heading", { level: 1, name: "Jobs" }).waitFor();
  const rows = page.locator("tbody tr");
  await rows.nth(2).waitFor();
  assert.match(await rows.nth(0).innerText(), /^3\s+hall\s+queued\s+not started\s+\/data\/lab <walk>/);
  assert.match(await rows.nth(1).innerText(), /running\s+host:7: part 2, frames\s+1,000 of 4,000 frames, 1 of 2 parts/);
  assert.equal(await rows.nth(1).locator("progress").evaluate((bar) => bar.position), 0.25);
  assert.match(await rows.nth(2).innerText(), /failed\s+no plane or landmark found/);
  await shoot(page, "jobs");
  await checkAccess(page, "jobs");
  assert.deepEqual(complaints, []);
  await close();
}

// A walk of two stretches that came back to one plane.
async function testRevisit() {
  const { page, complaints, close } = await open({});
  const known = await overview();
  const id = Array.from({ length: 24 }, (_, i) => i + 1);
  const keyframes = { ...known.keyframes, id, sequence: id.map(() => 1), stretch: id.map((k) => (k > 9 ? 1 : 0)) };
  const planes = { ...known.planes, keyframes: known.planes.keyframes.map((_, i) => (i === 0 ? [1, 2, 23] : [1])) };
  await page.route("**/overview", (route) => route.fulfill(json({ ...known, keyframes, planes })));
  await page.goto(`${url}/#/room/layers`);
  await page.locator(".arc").waitFor({ state: "attached" });
  assert.equal(await page.locator(".plot circle").count(), 24);
  assert.equal(await page.locator(".plot .break").count(), 1);
  await shoot(page, "revisit");
  await checkAccess(page, "a revisit");
  assert.deepEqual(complaints, []);
  await close();
}

// A trajectory with a loop, as the endpoints answer.
async function testOtherLayers() {
  const { page, complaints, close } = await open({});
  const known = await overview();
  const ring = Array.from({ length: 24 }, (_, i) => (2 * Math.PI * i) / 24);
  await page.route("**/overview", (route) =>
    route.fulfill(json({ ...known, layers: ["planes", "appearance"] })));
  await page.route("**/appearance", (route) => route.fulfill(json({
    scale: "arbitrary",
    nodes: ring.map((a, i) => ({ id: i, keyframe: 1, x: Math.cos(a), y: Math.sin(a), heading_rad: a })),
    edges: [...ring.keys()].map((i) => ({ a: i, b: (i + 1) % 24, kind: i === 23 ? "loop" : "odometry", distance: 0.1 })),
  })));
  await page.route("**/appearance/nodes/*", (route) => route.fulfill(json({
    id: 0, sequence: "walk", source: "0.jpg", time_s: null, frame: 0, keyframe: 1, x: 1, y: 0,
    heading_rad: 0, features: 0, image: null,
  })));
  await page.goto(`${url}/#/room/layers`);
  await page.locator(".trajectory line.loop").waitFor({ state: "attached" });
  assert.equal(await page.locator(".trajectory circle").count(), 24);
  assert.equal(await page.locator(".trajectory line.loop").count(), 1);
  await page.getByText("0.jpg of sequence walk").waitFor();
  await page.getByRole("button", { name: "Next" }).click();
  await page.locator(".trajectory circle.chosen").waitFor({ state: "attached" });
  await page.getByLabel("Node", { exact: true }).fill("12");
  await page.keyboard.press("Enter");
  await page.locator(".trajectory circle:nth-of-type(13).chosen").waitFor({ state: "attached" });
  assert.equal(await page.evaluate(() => location.hash), "#/room/layers/12");
  await shoot(page, "other_layers");
  await checkAccess(page, "the other layers");
  assert.deepEqual(complaints, []);
  await close();
}

// A photo that is chosen before the last one was answered: its answer stays, whichever arrives last.
async function testTwoPhotos() {
  const { page, complaints, close } = await open({});
  await page.addInitScript(() => {
    window.photos = { made: [], gone: [] };
    const [make, revoke] = [URL.createObjectURL, URL.revokeObjectURL];
    URL.createObjectURL = (blob) => {
      const address = make(blob);
      window.photos.made.push(address);
      return address;
    };
    URL.revokeObjectURL = (address) => {
      window.photos.gone.push(address);
      revoke(address);
    };
  });
  let pending = [];
  await page.route("**/localize?*", (route) => pending.push(route));
  await page.goto(`${url}/`);
  const choose = async (name) => {
    const asked = pending.length + 1;
    await page.setInputFiles(".chooser input >> nth=0", { name, mimeType: "image/jpeg", buffer: readFileSync(inside) });
    while (pending.length < asked) await page.waitForTimeout(20);
  };
  const busy = page.locator(".chooser", { hasText: "Localizing" });
  const answer = async (route) => {
    const arrived = page.waitForResponse("**/localize?*");
    await route.continue();
    await (await arrived).finished();
    await page.waitForTimeout(200);
  };
  await choose("first.jpg");
  await choose("second.jpg");
  await answer(pending[0]);
  assert.equal(await busy.count(), 1, "the second one isn't answered yet");
  assert.equal(await page.locator(".verdict").count(), 0);
  await answer(pending[1]);
  await page.getByLabel("Answer for second.jpg").waitFor();
  assert.equal(await busy.count(), 0);
  pending = [];
  await choose("third.jpg");
  await choose("fourth.jpg");
  await answer(pending[1]);
  await answer(pending[0]);
  await page.getByLabel("Answer for fourth.jpg").waitFor();
  const { made, gone } = await page.evaluate(() => window.photos);
  assert.deepEqual(gone, made.slice(0, -1), "all but the photo that is shown");
  assert.deepEqual(complaints, []);
  await close();
}

// A panorama that could be of two places: they are listed.
async function testAmbiguousPanorama() {
  const { page, complaints, close } = await open({});
  const node = (id) => ({ id, sequence: "walk", source: `${id - 1}.jpg`, time_s: null });
  await page.route("**/localize?*", (route) => route.fulfill(json({
    verdict: "ambiguous", probability: 0.57, image: "p.jpg", map: "room", map_version: "sha256:0",
    keyframe: null, heading: null, planes: [], places: [], message: "two places match",
    panorama: {
      node: null, position: null, runner_up: null,
      candidates: [{ node: node(51), probability: 0.57, cost: 1 }, { node: node(7), probability: 0.29, cost: 2 }],
    },
    runner_up: null, decided_by: "ambiguous_places", timing_ms: { decode: 1, extract: 2, shortlist: 3, verify: 4, total: 10 },
  })));
  await page.goto(`${url}/`);
  assert.equal(await ask(page, inside), "Ambiguous: several places match");
  assert.deepEqual(await page.locator(".verdict li").allInnerTexts(), [
    "panorama 51, 50.jpg of sequence walk, probability 57%", "panorama 7, 6.jpg of sequence walk, probability 29%",
  ]);
  await checkAccess(page, "an ambiguous panorama");
  assert.deepEqual(complaints, []);
  await close();
}

// A panorama asked of a map of panoramas: words, place and heading, and no keyframe made up.
async function testPanoramaAnswer() {
  const { page, complaints, close } = await open({});
  await page.route("**/localize?*", (route) => route.fulfill(json({
    verdict: "localized", probability: 0.97, image: "p.jpg", map: "room", map_version: "sha256:0",
    keyframe: null, heading: { rad: 1.5708, deviation_rad: 0.01, of: "layer" }, planes: [],
    panorama: {
      node: { id: 51, sequence: "walk", source: "50.jpg", time_s: null },
      position: { x: 74.4, y: -29.2, deviation: 1.9, metres_per_unit: null }, candidates: [], runner_up: null,
    },
    runner_up: null, decided_by: "appearance", timing_ms: { decode: 1, extract: 2, shortlist: 3, verify: 4, total: 10 },
  })));
  await page.route("**/appearance/nodes/51/image?*", (route) => route.fulfill({
    contentType: "image/jpeg", body: readFileSync(inside),
  }));
  await page.goto(`${url}/`);
  assert.equal(await ask(page, inside), "Localized near panorama 51");
  assert.match(await page.locator(".verdict").innerText(), /50\.jpg of sequence walk, probability 97%/);
  assert.match(await page.locator(".facts").innerText(), /74\.4, -29\.2 ± 1\.9 map units\s+Heading\s+90°/);
  assert.equal(await page.locator(".panoramas img").count(), 2);
  await checkAccess(page, "a panorama's answer");
  assert.deepEqual(complaints, []);
  await close();
}

// A keyframe that is a panorama can be looked around in.
async function testPanorama() {
  const { page, complaints, close } = await open({});
  const summary = await (await fetch(`${url}/v1/maps/room`)).json();
  for (const sequence of summary.sequences) {
    sequence.camera = { model: "EQUIRECTANGULAR", width: 640, height: 480, params: [] };
  }
  await page.route("**/v1/maps?*", (route) => route.fulfill({
    contentType: "application/json", body: JSON.stringify({ maps: [summary], next: null }),
  }));
  await page.goto(`${url}/#/room/keyframes/1`);
  await page.locator(".panorama canvas").waitFor();
  await page.locator(".panorama .pnlm-load-box").waitFor({ state: "hidden" });
  await shoot(page, "panorama");
  assert.deepEqual(complaints, []);
  await close();
}

// A map of panoramas alone: no views of planes, and no findings about keyframes that it hasn't got.
async function testPanoramaMap() {
  const { page, complaints, close } = await open({});
  const summary = { ...(await getJson("/v1/maps/room")), planes: 0, surfaces: 0, keyframes: 0, edges: 0, features: 0 };
  const none = { id: [], sequence: [], stretch: [], planes: [], features: [] };
  await page.route("**/v1/maps?*", (route) => route.fulfill(json({ maps: [summary], next: null })));
  await page.route("**/overview", (route) => route.fulfill(json({
    ...known(none), layers: ["appearance"],
  })));
  await page.route("**/appearance", (route) => route.fulfill(json({
    scale: "metric", nodes: [{ id: 1, keyframe: null, x: 0, y: 0, heading_rad: 0 }], edges: [],
  })));
  await page.goto(`${url}/`);
  await page.getByRole("navigation").getByRole("link", { name: "Trajectory" }).waitFor();
  const tabs = await page.getByRole("navigation").getByRole("link").allTextContents();
  assert.deepEqual(tabs, ["Localize", "Trajectory", "Names"]);
  await go(page, "coverage", "Coverage");
  await page.getByText("This map has no planes").waitFor();
  assert.equal(await page.getByText("Every keyframe").count(), 0);
  await go(page, "planes", "Plane graph");
  assert.equal(await page.locator(".graph").count(), 0, "no empty graph");
  await checkAccess(page, "a map of panoramas");
  assert.deepEqual(complaints, []);
  await close();
}

const known = (keyframes) => ({
  keyframes,
  planes: { id: [], surface: [], stretch: [], features: [], reference: [], keyframes: [] },
  edges: { a: [], b: [] },
});

// EXIF data of an orientation alone: 6 is that of an image stored lying on its side, to be turned 90 degrees
// clockwise.
const exifOf = (orientation) =>
  Buffer.from(`49492a0008000000010012010300010000000${orientation}00000000000000`, "hex");

function turnedJpeg(jpeg, orientation) {
  const segment = Buffer.concat([Buffer.from("ffe10022457869660000", "hex"), exifOf(orientation)]);
  return Buffer.concat([jpeg.subarray(0, 2), segment, jpeg.subarray(2)]);
}

function crcOf(bytes) {
  let crc = ~0;
  for (const byte of bytes) {
    crc ^= byte;
    for (let k = 0; k < 8; ++k) crc = (crc >>> 1) ^ (crc & 1 ? 0xedb88320 : 0);
  }
  return ~crc >>> 0;
}

function turnedPng(png, orientation) {
  const exif = exifOf(orientation);
  const chunk = Buffer.concat([Buffer.alloc(4), Buffer.from("eXIf"), exif, Buffer.alloc(4)]);
  chunk.writeUInt32BE(exif.length);
  chunk.writeUInt32BE(crcOf(chunk.subarray(4, -4)), chunk.length - 4);
  return Buffer.concat([png.subarray(0, 33), chunk, png.subarray(33)]); // behind IHDR
}

// A WebP in the extended form, to which the chunk with its orientation is added.
function turnedWebp(webp, orientation) {
  assert.equal(webp.toString("latin1", 12, 16), "VP8X");
  const exif = exifOf(orientation);
  const turned = Buffer.concat([webp, Buffer.from("EXIF"), Buffer.from([exif.length, 0, 0, 0]), exif]);
  turned.writeUInt32LE(turned.length - 8, 4);
  turned[20] |= 8;
  return turned;
}

// A photo in another format.
async function converted(page, jpeg, type) {
  const base64 = await page.evaluate(async ([data, type]) => {
    const bytes = Uint8Array.from(atob(data), (c) => c.charCodeAt(0));
    const bitmap = await createImageBitmap(new Blob([bytes], { type: "image/jpeg" }));
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [bitmap.width, bitmap.height];
    canvas.getContext("2d").drawImage(bitmap, 0, 0);
    return canvas.toDataURL(type, 0.9).split(",")[1];
  }, [jpeg.toString("base64"), type]);
  return Buffer.from(base64, "base64");
}

// As which EXIF orientation a screenshot shows a stored photo.
function shownOrientation(page, shot, jpeg) {
  return page.evaluate(async ([shot, jpeg]) => {
    const bitmapOf = (data, type) =>
      createImageBitmap(new Blob([Uint8Array.from(atob(data), (c) => c.charCodeAt(0))], { type }));
    const kSide = 48;
    const greys = (bitmap, turn) => {
      const context = new OffscreenCanvas(kSide, kSide).getContext("2d");
      context.setTransform(...turn.map((v, i) => (i < 4 ? v : v * kSide)));
      context.drawImage(bitmap, 0, 0, kSide, kSide);
      return context.getImageData(0, 0, kSide, kSide).data.filter((_, i) => i % 4 === 1);
    };
    const kTurns = [[1, 0, 0, 1, 0, 0], [-1, 0, 0, 1, 1, 0], [-1, 0, 0, -1, 1, 1], [1, 0, 0, -1, 0, 1],
      [0, 1, 1, 0, 0, 0], [0, 1, -1, 0, 1, 0], [0, -1, -1, 0, 1, 1], [0, -1, 1, 0, 0, 1]];
    const seen = greys(await bitmapOf(shot, "image/png"), kTurns[0]);
    const stored = await bitmapOf(jpeg, "image/jpeg");
    const off = kTurns.map((turn) => greys(stored, turn).reduce((sum, grey, i) => sum + Math.abs(grey - seen[i]), 0));
    return 1 + off.indexOf(Math.min(...off));
  }, [shot.toString("base64"), jpeg.toString("base64")]);
}

// Such a photo is shown upright; what the server answers in stored pixels follows it.
async function testTurnedPhoto() {
  const { page, complaints, close } = await open({ viewport: { width: 1280, height: 900 } });
  await page.goto(`${url}/`);
  const jpeg = readFileSync(inside);
  const file = { name: "turned.jpg", mimeType: "image/jpeg", buffer: turnedJpeg(jpeg, 6) };
  let answer = null;
  page.on("response", async (r) => { if (r.url().includes("/localize")) answer = await r.json(); });
  assert.match(await ask(page, file), /Localized near keyframe \d+/);
  await page.locator("figure svg line").first().waitFor();
  const { width, height } = answer.explanation.image;
  const box = await page.locator("figure .part").first().boundingBox();
  assert.ok(Math.abs(box.height / box.width - width / height) < 0.02, "its frame is as high as the upright photo");
  const [x, y] = answer.planes[0].outline[0];
  const points = await page.locator("figure .outline polygon").evaluateAll((all) => all.map((p) => p.getAttribute("points")));
  assert.ok(points.some((list) => list.split(" ")[0] === `${height - y},${x}`), `outlines are turned: ${points[0]}`);
  await shoot(page, "turned_photo");
  assert.deepEqual(complaints, []);
  await close();
  await testTurnedFormats(jpeg, answer);
}

async function testTurnedFormats(jpeg, answer) {
  const { page, complaints, close } = await open({ viewport: { width: 1280, height: 900 } });
  await page.route("**/localize?*", (route) => route.fulfill(json(answer)));
  await page.goto(`${url}/`);
  const [png, webp] = [await converted(page, jpeg, "image/png"), await converted(page, jpeg, "image/webp")];
  const files = [["image/png", turnedPng(png, 6), 6], ["image/webp", turnedWebp(webp, 8), 8],
    ...[1, 2, 3, 4, 5, 6, 7, 8].map((orientation) => ["image/jpeg", turnedJpeg(jpeg, orientation), orientation])];
  for (const [mimeType, buffer, orientation] of files) {
    const name = `${mimeType.slice(6)} ${orientation}`;
    await page.setInputFiles(".chooser input >> nth=0", { name, mimeType, buffer });
    await page.getByLabel(`Answer for ${name}`).waitFor();
    const part = page.locator("figure .part").first();
    await part.locator("img").evaluate((img) => img.decode());
    await page.locator("figure svg").evaluate((drawn) => { drawn.style.visibility = "hidden"; });
    assert.equal(await shownOrientation(page, await part.screenshot(), jpeg), orientation, name);
  }
  assert.deepEqual(complaints, []);
  await close();
}

// A server with tokens: the page asks for one, says when it is wrong, and keeps it with the tab. What
// the server refuses without one is played here.
async function testTokens() {
  const { page, complaints, close } = await open({});
  const token = "a-token-of-this-test";
  await page.route("**/v1/**", (route) => {
    if (route.request().headers().authorization === `Bearer ${token}`) return route.continue();
    return route.fulfill({ status: 401, contentType: "application/problem+json", body: JSON.stringify({
      type: "urn:waystone:problem:unauthorized", title: "Authentication required", status: 401,
      detail: "Send one of this server's tokens as a bearer token", code: "unauthorized" }) });
  });
  await page.goto(`${url}/`);
  await page.getByRole("heading", { name: "Authentication required" }).waitFor();
  await checkAccess(page, "the token");
  const enter = async (text) => {
    await page.getByLabel("Token").fill(text);
    await page.getByRole("button", { name: "Sign in" }).click();
  };
  await enter("日本"); // can't be sent
  await page.getByText("Invalid token").waitFor();
  await enter("another");
  await page.getByText("Invalid token").waitFor();
  await enter(token);
  await page.getByRole("heading", { name: "Where was this photo taken?" }).waitFor();
  assert.match(await drop(page, inside), /Localized near keyframe \d+/);
  await page.reload();
  await page.getByRole("heading", { name: "Where was this photo taken?" }).waitFor();
  await go(page, "keyframes", "Keyframes");
  await page.locator('.thumbnail img[src^="blob:"]').first().waitFor();
  // The browser itself notes each refusal.
  assert.deepEqual(complaints.filter((said) => !/401/.test(said)), []);
  await close();
}

// From the address to an answer without a mouse.
async function testKeyboard(page) {
  await page.goto(`${url}/`);
  await page.getByRole("heading", { level: 1 }).waitFor();
  const reached = [];
  for (let i = 0; i < 14; ++i) {
    await page.keyboard.press("Tab");
    reached.push(await page.evaluate(() => {
      const e = document.activeElement;
      return e.getAttribute("type") === "file" ? "file" : e.textContent.trim().slice(0, 24);
    }));
  }
  for (const wanted of ["Skip to content", "Planes", "Coverage", "file"]) {
    assert.ok(reached.includes(wanted), `Tab reaches ${wanted}: ${reached}`);
  }
}

// Nothing is wider than a phone, and the dark colours are as good.
async function testPhone() {
  const { page, complaints, close } = await open({
    viewport: { width: 360, height: 740 }, isMobile: true, hasTouch: true, colorScheme: "dark",
  });
  await page.goto(`${url}/`);
  await ask(page, inside);
  const views = [["ask", /Where/], ["why", /Why/], ["planes", /Plane graph/], ["keyframes", /Keyframes/],
    ["layers", /Trajectory/], ["orientation", /Turns/], ["coverage", /Coverage/], ["names", /Named places/], ["layers", /Trajectory/, "turns"],
    ["orientation", /Turns/, "turns"], ["keyframes/2", /Keyframe 2/, "walls"]];
  for (const [view, heading, map] of views) {
    await go(page, view, heading, map);
    if (map === "walls") await page.getByRole("button", { name: "planes in 3D" }).click();
    if (map) await page.waitForTimeout(800);  // for its pictures
    const width = await page.evaluate(() => document.documentElement.scrollWidth);
    assert.ok(width <= 360, `${view} is ${width} px wide on a phone`);
    await shoot(page, `phone_${map ? `${map}_` : ""}${view.split("/")[0]}`);
    await checkAccess(page, `${view}${map ? ` of ${map}` : ""}, dark`);
  }
  assert.deepEqual(complaints, []);
  await close();
}

await run(async () => {
  const { page, complaints, close } = await open({ viewport: { width: 1280, height: 800 } });
  await page.goto(`${url}/`);
  for (const test of [testAsk, testWhy, testPlanes, testKeyframes, testNames, testLayers, testOrientation,
    testSpace, testCoverage, testKeyboard]) {
    await test(page, complaints);
    assert.deepEqual(complaints, [], test.name);
  }
  await close();
  await testNamesakes();
  await testLandmarks();
  await testNewVersion();
  await testNoMap();
  await testNothingThere();
  await testRefusedPhoto();
  await testLongName();
  await testFailures();
  await testNoWebGl();
  await testSessions();
  await testJobs();
  await testRevisit();
  await testOtherLayers();
  await testCorridors();
  await testLongWalk();
  await testPanorama();
  await testTwoPhotos();
  await testAmbiguousPanorama();
  await testPanoramaAnswer();
  await testPanoramaMap();
  await testTurnedPhoto();
  await testTokens();
  await testPhone();
});
