// SPDX-License-Identifier: Apache-2.0
// node measure_page.mjs URL: how soon the page served at URL can be used, and at how many frames
// per second the graph of its first map is drawn while it is dragged. Prints one line of JSON.
import { createRequire } from "node:module";

const require = createRequire(new URL("../../server/web/", import.meta.url));
const { chromium } = require("playwright-core");
const [url] = process.argv.slice(2);
const kLoads = 5; // each in a browser context of its own, so that nothing is cached
const kDrag_ms = 3000;

const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--disable-quic", "--disable-background-networking", "--disable-component-update",
    "--disable-sync"],
});

const median = (values) => [...values].sort((a, b) => a - b)[Math.floor(values.length / 2)];

// From the navigation's start, on the page's own clock: `selector` is there and was drawn.
function drawnAfter(page, selector) {
  return page.evaluate((wanted) => new Promise((resolve) => {
    const look = () => document.querySelector(wanted)
      ? requestAnimationFrame(() => resolve(performance.now()))
      : requestAnimationFrame(look);
    look();
  }), selector);
}

async function firstView() {
  const times = [];
  const bytes = [];
  for (let i = 0; i < kLoads; ++i) {
    const context = await browser.newContext();
    const page = await context.newPage();
    await page.goto(`${url}/`, { waitUntil: "commit" });
    times.push(await drawnAfter(page, ".chooser"));
    await page.waitForLoadState("networkidle"); // only what has been loaded has known sizes
    bytes.push(await page.evaluate(() => performance.getEntries()
      .reduce((sum, e) => sum + (e.encodedBodySize ?? 0), 0)));
    await context.close();
  }
  return { first_view_ms: Math.round(median(times)), first_view_bytes: median(bytes) };
}

// Frames per second while the graph is dragged about.
async function dragged(page) {
  const box = await page.locator(".graph .canvas").boundingBox();
  await page.getByRole("button", { name: "Fit" }).click(); // the last drag threw it off
  await page.waitForTimeout(500);
  const at = (angle) => [
    box.x + box.width * (0.5 + 0.15 * Math.cos(angle)),
    box.y + box.height * (0.5 + 0.15 * Math.sin(angle)),
  ];
  await page.evaluate(() => {
    if (window.frames_ !== undefined) return;
    window.frames_ = 0;
    const count = () => { window.frames_ += 1; requestAnimationFrame(count); };
    requestAnimationFrame(count);
  });
  await page.mouse.move(...at(0));
  await page.mouse.down();
  const start = await page.evaluate(() => [performance.now(), window.frames_]);
  // Back and forth, so that the whole graph stays in view.
  const until = Date.now() + kDrag_ms;
  for (let i = 1; Date.now() < until; ++i) await page.mouse.move(...at(Math.sin(i / 20)));
  const end = await page.evaluate(() => [performance.now(), window.frames_]);
  if (process.env.SCREENSHOT) await page.screenshot({ path: process.env.SCREENSHOT });
  await page.mouse.up();
  return (1000 * (end[1] - start[1])) / (end[0] - start[0]);
}

async function graph(name) {
  const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
  await page.goto(`${url}/#/${encodeURIComponent(name)}/planes`, { waitUntil: "commit" });
  const shown = await drawnAfter(page, ".graph canvas");
  const whileLaidOut = await dragged(page);
  await page.locator(".graph[data-state=settled]").waitFor({ timeout: 300_000 });
  const settled = await page.evaluate(() => performance.now());
  const afterwards = await dragged(page);
  await page.close();
  return {
    graph_ms: Math.round(shown),
    settled_ms: Math.round(settled),
    frames_per_s_laying_out: Math.round(whileLaidOut),
    frames_per_s: Math.round(afterwards),
  };
}

const [map] = (await (await fetch(`${url}/v1/maps`)).json()).maps;
const result = { planes: map.planes, ...(await firstView()), ...(await graph(map.name)) };
await browser.close();
console.log(JSON.stringify(result));
