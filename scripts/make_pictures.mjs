// SPDX-License-Identifier: Apache-2.0
// node make_pictures.mjs WAYSTONE FOLDER: takes the pictures of docs/web.md from the page that the
// program WAYSTONE serves. The rendered buildings and their maps are kept in FOLDER; what is there
// already is used again. Needs Chromium and `make browser`; pngquant, if installed, makes the files small.
import { execFileSync, spawn, spawnSync } from "node:child_process";
import { existsSync, mkdirSync } from "node:fs";
import { createRequire } from "node:module";
import { join, resolve } from "node:path";
import { createInterface } from "node:readline";
import { fileURLToPath } from "node:url";

const kRoot = fileURLToPath(new URL("..", import.meta.url));
const kPictures = join(kRoot, "docs/web");
const { chromium } = createRequire(join(kRoot, "server/web/"))("playwright-core");
const [program, folder] = process.argv.slice(2).map((path) => resolve(path));
if (!folder) throw new Error("usage: node make_pictures.mjs WAYSTONE FOLDER");
const photo = (name) => join(folder, "walk/queries", `${name}.jpg`);

// The maps room (photos), both (the same, with revisits), hall (the same, with poses, a floor plan and
// names) and office (panoramas) of rendered buildings.
function makeMaps() {
  mkdirSync(folder, { recursive: true });
  const run = (...args) => execFileSync(program, args, { cwd: folder, stdio: "inherit" });
  if (!existsSync(join(folder, "walk/plan.png"))) run("demo", "--write", "walk");
  if (!existsSync(join(folder, "office"))) run("demo", "--write", "office", "--setting", "office");
  if (!existsSync(join(folder, "room.db"))) run("build", "walk", "-o", "room.db");
  if (!existsSync(join(folder, "both.db"))) run("build", "walk", "walk", "-o", "both.db", "--every", "2");
  const poses = ["--camera", "walk/camera.yaml", "--poses", "walk/poses.csv", "--unit", "metres", "--frame", "hall"];
  if (!existsSync(join(folder, "hall.db"))) run("build", "walk/images", "-o", "hall.db", ...poses);
  const anchors = ["0,500=0,0", "540,500=13.5,0", "540,0=13.5,12.5"].flatMap((anchor) => ["--anchor", anchor]);
  run("plan", "hall.db", "walk/plan.png", ...anchors);
  run("name", "hall.db", "--polygon", "0.5,9 4,9 4,12 0.5,12", "Meeting room");
  run("name", "hall.db", "--polygon", "5,9 8.5,9 8.5,12 5,12", "Workshop");
  if (!existsSync(join(folder, "office.db"))) run("build", "office/panorama", "-o", "office.db");
}

async function serve() {
  const server = spawn(program, ["serve", "room.db", "both.db", "hall.db", "office.db", "--port", "0"], { cwd: folder });
  for await (const line of createInterface({ input: server.stdout })) {
    const url = /http:\/\/\S+/.exec(line);
    if (url) return { server, url: url[0] };
  }
  throw new Error("the server did not start");
}

async function show(page, url, view) {
  await page.goto(`${url}/#/${view}`);
  await page.getByRole("heading", { level: 1 }).waitFor();
}

async function localize(page, url, name, map = "room") {
  await show(page, url, `${map}/ask`);
  await page.setInputFiles(".chooser input >> nth=0", photo(name));
  await page.locator(".verdict").waitFor();
}

async function shoot(page, name, options = {}) {
  await page.waitForLoadState("networkidle");
  await page.waitForTimeout(1500);  // for the images in the nodes, and the layout of the graph
  await page.screenshot({ path: join(kPictures, `${name}.png`), ...options });
  const small = ["--force", "--skip-if-larger", "--strip", "--speed", "1", "--ext", ".png", "256"];
  spawnSync("pngquant", [...small, join(kPictures, `${name}.png`)], { stdio: "inherit" });
}

async function shootRoom(page, url) {
  await localize(page, url, "124");
  await page.locator("figure svg line").first().waitFor();
  await shoot(page, "ask");
  await localize(page, url, "other-148");
  await page.getByRole("link", { name: "Why", exact: true }).click();
  await page.locator(".stages").waitFor();
  await shoot(page, "why");
  await show(page, url, "room/planes");
  await shoot(page, "planes");
  await show(page, url, "room/keyframes/22");
  await page.locator(".outline polygon").first().waitFor();
  await shoot(page, "keyframe");
  await show(page, url, "room/keyframes/46");
  await page.getByLabel("Show lines coloured by Manhattan axis").check();
  await page.getByRole("button", { name: "Show planes in 3D" }).click();
  await page.locator(".space canvas").waitFor();
  await shoot(page, "space", { fullPage: true });
  await show(page, url, "both/layers");
  await shoot(page, "layers");
  await show(page, url, "room/coverage");
  await page.locator(".series canvas").waitFor();
  await shoot(page, "coverage");
}

async function shootHall(page, url) {
  await localize(page, url, "124", "hall");
  await show(page, url, "hall/layers");
  await page.locator(".pose-map .query").waitFor();
  await shoot(page, "poses");
  await show(page, url, "hall/names");
  await page.locator(".composer select").selectOption("areas");
  await page.getByRole("textbox", { name: "Corners" }).fill("0.5,7 13,7 13,8.5 0.5,8.5");
  await page.getByLabel("Name", { exact: true }).fill("Corridor, north");
  await page.locator(".pose-map .plan").waitFor();
  await shoot(page, "names", { fullPage: true });
}

async function shootOffice(page, url) {
  await page.setViewportSize({ width: 1280, height: 900 });
  await show(page, url, "office/layers");
  await page.getByRole("button", { name: "Next" }).click();
  await shoot(page, "trajectory");
  await page.setViewportSize({ width: 1280, height: 800 });
  await show(page, url, "office/orientation");
  await page.locator(".trajectory-map .turn path").nth(1).click();
  await page.locator(".directed polyline").first().waitFor({ state: "attached" });
  await shoot(page, "orientation", { fullPage: true });
}

async function shootPhone(page, url) {
  await localize(page, url, "100");
  await shoot(page, "phone_ask");
  await show(page, url, "room/planes");
  await shoot(page, "phone_planes");
  await show(page, url, "office/orientation");
  await shoot(page, "phone_orientation");
}

makeMaps();
const { server, url } = await serve();
const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
});
try {
  const desktop = await browser.newPage({ viewport: { width: 1280, height: 800 } });
  await shootRoom(desktop, url);
  await shootHall(desktop, url);
  await shootOffice(desktop, url);
  const phone = { viewport: { width: 360, height: 740 }, isMobile: true, hasTouch: true, colorScheme: "dark" };
  await shootPhone(await browser.newPage(phone), url);
} finally {
  await browser.close();
  server.kill();
}
