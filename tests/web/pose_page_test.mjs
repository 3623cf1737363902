// SPDX-License-Identifier: Apache-2.0
// node pose_page_test.mjs URL HALL [SCREENSHOT_FOLDER]: the page of a map with poses, served at URL as
// hall, whose images, poses and queries `waystone demo --write HALL` wrote, in Debian's Chromium.
// Exit status: 0 on success, 1 after a message about what failed or is missing.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { ask, checkAccess, go, json, startBrowser } from "./browser.mjs";

const [url, hall, screenshots] = process.argv.slice(2);
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
  await checkQuery(page, "answer");
  assert.ok(await page.locator(".pose-map .recognized").count() > 0, "recognized planes stand out");
  await shootWhole(page, "pose_answer");
  await checkAccess(page, "an answer with a pose");
  await go(page, "hall", "layers", "Trajectory");
  await page.locator(".pose-map .query").waitFor();
  await checkQuery(page, "trajectory");
  await shoot(page, "poses");
}

async function testLinks(page) {
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
  await page.locator(".pose-map .surface").waitFor();
  const { scale } = await measureDrawing(page);
  const drawn = Number(await page.locator(".pose-map .query ellipse").getAttribute("rx"));
  assert.ok(Math.abs(drawn - 2 * 0.5 * scale) < 0.1, `an ellipse of ${drawn} px for 1 unit of ${scale} px`);
  assert.match(await page.locator(".facts").innerText(), / ± 0\.50, .* map units/);
  await page.getByText("the images don’t tell what is up").waitFor();
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
  for (const test of [testMap, testQuery, testLinks, testNoPose]) {
    await test(page);
    assert.deepEqual(complaints, [], test.name);
  }
  await close();
  await testUncertain();
  await testPhone();
});
