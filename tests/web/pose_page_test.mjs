// SPDX-License-Identifier: Apache-2.0
// node pose_page_test.mjs URL HALL NAMES_FILE [SCREENSHOT_FOLDER]: the page of a map with poses, a floor
// plan and a named area, served at URL as hall, whose images, poses and queries `waystone demo --write
// HALL` wrote, in Debian's Chromium. The names that are composed there are saved as NAMES_FILE.
// Exit status: 0 on success, 1 after a message about what failed or is missing.
import assert from "node:assert/strict";
import { copyFileSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { ask, checkAccess, go, json, startBrowser } from "./browser.mjs";

const [url, hall, namesFile, screenshots] = process.argv.slice(2);
const { open, shoot, shootWhole, run } = await startBrowser(url, screenshots);

const rowsOf = (file) => readFileSync(join(hall, file), "utf8").trim().split("\n").slice(1).map((l) => l.split(","));
const truths = rowsOf("queries.csv");
const kInside = truths.filter((row) => row[2] !== "").at(4);
const kOutside = truths.find((row) => row[2] === "");
const photoOf = ([image]) => join(hall, image);
const [kX, kY, kZ] = kInside.slice(2).map(Number);

// Where the camera of the frame before the photo looked, counter-clockwise from x: the map's z is up.
function trueHeading() {
  const row = rowsOf("poses.csv").find((r) => r[0] === kInside[1]);
  const [x, y, z, w] = row.slice(5).map(Number);
  return Math.atan2(2 * (y * z - x * w), 2 * (x * z + y * w));
}

const wrapped = (rad) => Math.atan2(Math.sin(rad), Math.cos(rad));

// How the drawing has the frame: cx = left + scale x, cy = bottom - scale y. All keyframes agree.
async function measureDrawing(page) {
  const { keyframes } = await (await fetch(`${url}/v1/maps/hall/poses`)).json();
  const dots = await page.locator(".pose-map .keyframe circle").evaluateAll((all) =>
    all.map((c) => [Number(c.getAttribute("cx")), Number(c.getAttribute("cy"))]));
  assert.equal(dots.length, keyframes.id.length, "every keyframe is drawn");
  const xs = keyframes.position.map((p) => p[0]);
  const [a, b] = [xs.indexOf(Math.min(...xs)), xs.indexOf(Math.max(...xs))];
  const scale = (dots[b][0] - dots[a][0]) / (xs[b] - xs[a]);
  const left = dots[a][0] - scale * xs[a];
  const bottom = dots[a][1] + scale * keyframes.position[a][1];
  keyframes.position.forEach(([x, y], i) => {
    const off = Math.hypot(left + scale * x - dots[i][0], bottom - scale * y - dots[i][1]);
    assert.ok(off < 0.1, `keyframe ${keyframes.id[i]} is ${off} px from its place`);
  });
  return { scale, left, bottom };
}

// The query is drawn where it was taken, and looks where it looked.
async function checkQuery(page, where) {
  const { scale, left, bottom } = await measureDrawing(page);
  const mark = await page.locator(".pose-map .query").evaluate((g) => {
    const [dot, arrow] = [g.querySelector("circle"), g.querySelector("path")];
    return {
      cx: Number(dot.getAttribute("cx")),
      cy: Number(dot.getAttribute("cy")),
      turn: Number(/rotate\((.*)\)/.exec(arrow.getAttribute("transform"))[1]),
      radius: Number(g.querySelector("ellipse").getAttribute("rx")),
    };
  });
  const off = Math.hypot((mark.cx - left) / scale - kX, (bottom - mark.cy) / scale - kY);
  assert.ok(off < 0.05, `${where}: the query is drawn ${off} m from its true place`);
  const turn = Math.abs(wrapped(-mark.turn * (Math.PI / 180) - trueHeading()));
  assert.ok(turn < 0.3, `${where}: its arrow is turned by ${turn} rad`);
  assert.ok(mark.radius > 0 && mark.radius < scale, `${where}: an ellipse of ${mark.radius} px`);
}

async function testMap(page) {
  await go(page, "hall", "layers", "Trajectory");
  await page.getByRole("img", { name: /keyframes and \d+ planes seen from above$/ }).waitFor();
  await measureDrawing(page);
  assert.ok(await page.locator(".pose-map .wall").count() > 5, "walls are lines");
  assert.equal(await page.locator(".pose-map .query").count(), 0, "nothing was asked");
  assert.match(await page.locator(".pose-map .scale text").first().textContent(), /^[125]0* m$/);
  assert.deepEqual(await page.locator(".pose-map .scale g text").allTextContents(), ["x", "y"]);
  await checkAccess(page, "poses");
}

async function testQuery(page) {
  await go(page, "hall", "ask", "Where was this photo taken?");
  assert.match(await ask(page, photoOf(kInside)), /Localized near keyframe \d+/);
  await page.locator(".pose-map .query").waitFor();
  const said = await page.locator(".facts").innerText();
  const position = /Position\s*(\S+) ± \S+, (\S+) ± \S+, (\S+) ± \S+ m/.exec(said);
  assert.ok(position, said);
  const off = Math.hypot(position[1] - kX, position[2] - kY, position[3] - kZ);
  assert.ok(off < 0.05, `${off} m from the truth: ${said}`);
  assert.match(said, /Orientation\s*.* ± \d\.\d\d°/);
  assert.match(said, /in the frame “/);
  assert.match(said, /On the plan\s*\d+, \d+ px of “Floor plan”/);
  await checkQuery(page, "answer");
  assert.ok(await page.locator(".pose-map .recognized").count() > 0, "recognised planes stand out");
  await shootWhole(page, "pose_answer");
  await checkAccess(page, "an answer with a pose");
  await go(page, "hall", "layers", "Trajectory");
  await page.locator(".pose-map .query").waitFor();
  await checkQuery(page, "trajectory");
  await shoot(page, "poses");
}

// The floor plan lies where its anchors are, below all else, and can be put away.
async function testPlan(page) {
  const { plans } = await (await fetch(`${url}/v1/maps/hall/plan`)).json();
  await go(page, "hall", "layers", "Trajectory");
  await page.locator(".pose-map .plan").waitFor();
  const { scale, left, bottom } = await measureDrawing(page);
  const [a, b, c, d, e, f] = await page.locator(".pose-map .plan").evaluate((image) =>
    /matrix\((.*)\)/.exec(image.getAttribute("transform"))[1].split(" ").map(Number));
  for (const { px: [u, v], at: [x, y] } of plans[0].anchors) {
    const off = Math.hypot(a * u + c * v + e - (left + scale * x), b * u + d * v + f - (bottom - scale * y));
    assert.ok(off < 0.2, `an anchor of the plan is ${off} px from its place`);
  }
  assert.equal(await page.locator(".pose-map > :first-child").getAttribute("class"), "plan");
  assert.equal(await page.locator(".pose-map .area text").textContent(), "Room <&>");
  await page.getByLabel("Floor plan").selectOption("none");
  assert.equal(await page.locator(".pose-map .plan").count(), 0);
  await measureDrawing(page);
  await page.getByLabel("Floor plan").selectOption("Floor plan");
  await page.locator(".pose-map .plan").waitFor();
}

const kCorners = [[1, 8], [4, 8], [4, 11], [1.5, 11]];

// Clicks on points of the frame, as measureDrawing found them.
async function clickAt(page, { scale, left, bottom }, [x, y]) {
  const svg = page.locator(".pose-map");
  await svg.scrollIntoViewIfNeeded();
  const spot = await svg.evaluate((element, p) => {
    const { x, y } = new DOMPoint(...p).matrixTransform(element.getScreenCTM());
    return [x, y];
  }, [left + scale * x, bottom - scale * y]);
  await page.mouse.click(...spot);
}

// An area by clicks, with its last corner undone and typed; planes by clicks and ids; the file.
async function testCompose(page) {
  await go(page, "hall", "names", "Named places");
  const of = (kind) => page.locator(".composer select").selectOption(kind);
  const add = async (name) => {
    await page.getByLabel("Name", { exact: true }).fill(name);
    await page.getByRole("button", { name: "Add" }).click();
  };
  await of("areas");
  await page.locator(".pose-map.drawing").waitFor();
  const drawing = await measureDrawing(page);
  for (const corner of kCorners) await clickAt(page, drawing, corner);
  const field = page.getByRole("textbox", { name: "Corners" });
  const read = async () => (await field.inputValue()).split(" ").map((pair) => pair.split(",").map(Number));
  const clicked = await read();
  assert.equal(clicked.length, kCorners.length);
  clicked.forEach(([x, y], i) => {
    const off = Math.hypot(x - kCorners[i][0], y - kCorners[i][1]);
    assert.ok(off < 2 / drawing.scale, `corner ${i} is ${off} m from where the click was`);
  });
  assert.equal(await page.locator(".corners circle").count(), 4);
  assert.match(await page.locator("figcaption").innerText(), /The area contains \d+ keyframes/);
  await shootWhole(page, "names_area");
  await checkAccess(page, "an area that is drawn");
  await page.getByRole("button", { name: "Undo last corner" }).click();
  assert.deepEqual(await read(), clicked.slice(0, 3));
  await field.fill("1,8 2,8");
  await add("Area");
  assert.match(await page.locator(".failure").innerText(), /at least three corners/);
  await field.fill("1,8 2,8 3,8");
  await page.getByRole("button", { name: "Add" }).click();
  assert.match(await page.locator(".failure").innerText(), /on one line/);
  await field.fill("1,8 x 2,8");
  await page.getByRole("button", { name: "Add" }).click();
  assert.match(await page.locator(".failure").innerText(), /Enter corners/);
  await field.fill(kCorners.map((c) => c.join(",")).join(" "));
  await page.getByRole("button", { name: "Add" }).click();
  await page.locator(".names tbody tr").nth(1).waitFor();
  assert.equal(await page.locator(".failure").count(), 0);
  assert.equal(await page.locator(".pose-map .area").count(), 2);
  await composePlanes(page, of, add);
  await saveNames(page);
}

async function composePlanes(page, of, add) {
  await of("planes");
  const wall = page.locator(".pose-map .wall").first();
  const id = /\d+/.exec(await wall.locator("title").textContent())[0];
  await wall.dispatchEvent("click");
  const field = page.getByRole("textbox", { name: "Planes" });
  assert.equal(await field.inputValue(), id);
  await page.locator(".pose-map .recognized").waitFor({ state: "attached" });
  await page.locator('ul[aria-label="Chosen planes"] .outline polygon').waitFor();
  await checkAccess(page, "a plane that is chosen");
  await field.fill(`${id}, 1000000`);
  await add("Walls");
  assert.match(await page.locator(".failure").innerText(), /no plane 1000000/);
  await field.fill(id);
  await page.getByRole("button", { name: "Add" }).click();
  await page.locator(".names tbody tr").nth(2).waitFor();
  // From the view of another plane one comes back to what was composed.
  await go(page, "hall", `planes/${id}`, "Plane graph");
  await page.getByRole("link", { name: "Name this plane" }).click();
  await page.getByRole("heading", { level: 1, name: "Named places" }).waitFor();
  assert.equal(await field.inputValue(), id);
  assert.equal(await page.locator(".names tbody tr").count(), 3);
}

async function saveNames(page) {
  const waiting = page.waitForEvent("download");
  await page.getByRole("link", { name: "Download hall-names.json" }).click();
  copyFileSync(await (await waiting).path(), namesFile);
  const { places } = JSON.parse(readFileSync(namesFile, "utf8"));
  assert.deepEqual(places.map((p) => p.name), ["Area", "Room <&>", "Walls"]);
  assert.deepEqual(places[0].polygons[0].corners, kCorners);
  assert.deepEqual(Object.keys(places[0].polygons[0]).sort(), ["corners", "frame", "right", "top", "unit"]);
  assert.equal(places[2].planes.length, 1);
}

async function testLinks(page) {
  await go(page, "hall", "layers", "Trajectory");
  const named = async (what) => {
    const id = /\d+/.exec(await page.locator(what).first().locator("title").textContent())[0];
    await page.locator(what).first().dispatchEvent("click");
    return id;
  };
  const keyframe = await named(".pose-map .keyframe");
  await page.getByRole("heading", { level: 1, name: `Keyframe ${keyframe}` }).waitFor();
  await go(page, "hall", "layers", "Trajectory");
  const plane = await named(".pose-map .wall");
  await page.getByRole("heading", { level: 2, name: `Plane ${plane}` }).waitFor();
  await go(page, "hall", "layers", "Trajectory");
  await page.getByLabel("Plane", { exact: true }).fill(plane);
  await page.keyboard.press("Enter");
  await page.getByRole("heading", { level: 2, name: `Plane ${plane}` }).waitFor();
}

// Without a pose there is a reason, and no drawing.
async function testNoPose(page) {
  await go(page, "hall", "ask", "Where was this photo taken?");
  await ask(page, photoOf(kOutside));
  await page.locator(".verdict.not_in_map").waitFor();
  assert.match(await page.locator(".facts").innerText(), /Pose\s*none: not localized/);
  assert.equal(await page.locator(".pose-map").count(), 0);
}

// The same map with a floor, of unknown unit and not knowing what is up, and an uncertain answer.
async function testUncertain() {
  const { page, complaints, close } = await open({ viewport: { width: 1280, height: 900 }, colorScheme: "dark" });
  await page.route("**/maps/hall/poses", async (route) => {
    const layer = await (await route.fetch()).json();
    const outline = [[1, 9, 0], [4, 9, 0], [4, 11, 0], [1, 11, 0]];
    layer.planes.push({ id: 900, reference: 1, normal: [0, 0, -1], distance: 0, outline });
    await route.fulfill(json({ ...layer, unit: "unknown", up: null }));
  });
  await page.route("**/localize?*", async (route) => {
    const answer = await (await route.fetch()).json();
    answer.pose.covariance[0] = [0.25, 0, 0, 0, 0, 0];
    await route.fulfill(json({ ...answer, pose: { ...answer.pose, unit: "unknown" } }));
  });
  await page.goto(`${url}/`);
  await ask(page, photoOf(kInside));
  await page.locator(".pose-map .surface").filter({ hasText: "plane 900" }).waitFor();
  const { scale } = await measureDrawing(page);
  const drawn = Number(await page.locator(".pose-map .query ellipse").getAttribute("rx"));
  assert.ok(Math.abs(drawn - 2 * 0.5 * scale) < 0.1, `an ellipse of ${drawn} px for 1 unit of ${scale} px`);
  assert.match(await page.locator(".facts").innerText(), / ± 0\.50, .* map units/);
  await page.getByText("the images don’t show which way is up").waitFor();
  await shootWhole(page, "pose_uncertain");
  await checkAccess(page, "an uncertain pose");
  assert.deepEqual(complaints, []);
  await close();
}

async function testPhone() {
  const { page, complaints, close } = await open({
    viewport: { width: 360, height: 740 }, isMobile: true, hasTouch: true, colorScheme: "dark",
  });
  await page.goto(`${url}/`);
  await ask(page, photoOf(kInside));
  await go(page, "hall", "names", "Named places");
  await page.locator(".composer select").selectOption("areas");
  await page.locator(".pose-map.drawing").waitFor();
  const drawing = await measureDrawing(page);
  for (const corner of kCorners.slice(0, 3)) await clickAt(page, drawing, corner);
  assert.equal(await page.locator(".corners circle").count(), 3, "taps are corners");
  const wide = await page.evaluate(() => document.documentElement.scrollWidth);
  assert.ok(wide <= 360, `names are ${wide} px wide on a phone`);
  await shootWhole(page, "phone_names_area");
  await checkAccess(page, "an area on a phone, dark");
  for (const [view, heading] of [["ask", /Where/], ["layers", /Trajectory/]]) {
    await go(page, "hall", view, heading);
    await page.locator(".pose-map .query").waitFor();
    const width = await page.evaluate(() => document.documentElement.scrollWidth);
    assert.ok(width <= 360, `${view} is ${width} px wide on a phone`);
    await checkQuery(page, `${view} on a phone`);
    await shootWhole(page, `phone_pose_${view}`);
    await checkAccess(page, `${view} with a pose, dark`);
  }
  assert.deepEqual(complaints, []);
  await close();
}

await run(async () => {
  const { page, complaints, close } = await open({ viewport: { width: 1280, height: 800 } });
  await page.goto(`${url}/`);
  for (const test of [testMap, testQuery, testPlan, testCompose, testLinks, testNoPose]) {
    await test(page);
    assert.deepEqual(complaints, [], test.name);
  }
  await close();
  await testUncertain();
  await testPhone();
});
