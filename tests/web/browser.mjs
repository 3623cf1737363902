// SPDX-License-Identifier: Apache-2.0
// What the tests of the page in Debian's Chromium share.
import assert from "node:assert/strict";
import { existsSync, readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";

const kChromium = process.env.CHROMIUM ?? "/usr/bin/chromium";
const kModules = new URL("../../server/web/", import.meta.url);
const kPatience = 20_000; // ms
const require = createRequire(kModules);

function missing(what) {
  console.log(what);
  process.exit(1);
}

if (Number(process.versions.node.split(".")[0]) < 18) missing("Node is older than 18");
if (!existsSync(new URL("node_modules/playwright-core", kModules))) {
  missing("server/web/node_modules is missing; 'make browser' installs it");
}
if (!existsSync(kChromium)) missing(`there is no ${kChromium}; apt-get install chromium`);

const { chromium } = require("playwright-core");
const axeSource = readFileSync(require.resolve("axe-core/axe.min.js"), "utf8");

// A browser for the page at `url`, with functions that open it, save screenshots to a folder (if one is
// given), and run a test: its exit status is 1, after a message, if it fails.
export async function startBrowser(url, screenshots) {
  const browser = await chromium.launch({
    executablePath: kChromium,
    args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-quic",
      "--disable-background-networking", "--disable-component-update", "--disable-sync"],
  });
  const save = async (page, name, options) => {
    if (screenshots) await page.screenshot({ path: join(screenshots, `${name}.png`), ...options });
  };
  const run = async (test) => {
    try {
      await test();
      await browser.close();
    } catch (error) {
      console.log(String(error.stack ?? error).replace(/\n\s*\n/g, "\n"));
      await browser.close();
      process.exit(1);
    }
  };
  return {
    open: (options) => open(browser, url, options),
    shoot: (page, name) => save(page, name, {}),
    shootWhole: (page, name) => save(page, name, { fullPage: true }),
    run,
  };
}

// A page, with what it complains about or asks of others: a test wants none of it.
async function open(browser, url, options) {
  const context = await browser.newContext(options);
  const page = await context.newPage();
  page.setDefaultTimeout(kPatience);
  const complaints = [];
  page.on("console", (m) => {
    // Software WebGL says that reading pixels is slow. It is asked to by the test alone.
    const own = !/GPU stall due to ReadPixels/.test(m.text());
    if (["error", "warning"].includes(m.type()) && own) complaints.push(m.text());
  });
  page.on("pageerror", (e) => complaints.push(e.message));
  page.on("request", (request) => {
    const target = request.url();
    const ours = target.startsWith(url) || /^(blob|data):/.test(target);
    if (!ours) complaints.push(`a request for ${target}`);
  });
  const close = async () => {
    await page.unrouteAll({ behavior: "wait" }); // what is still asked for would fail
    await context.close();
  };
  return { page, complaints, close };
}

// Serious or not: the page has no violation at all.
export async function checkAccess(page, where) {
  await page.evaluate(axeSource);
  const result = await page.evaluate(() => window.axe.run(document));
  const found = result.violations.map((v) =>
    `${v.id}: ${v.help} (${v.nodes.map((n) => n.target.join(" ")).slice(0, 3).join("; ")})`);
  assert.deepEqual(found, [], `axe in ${where}`);
}

export async function go(page, map, view, heading) {
  await page.evaluate((hash) => { location.hash = hash; }, `#/${map}/${view}`);
  await page.getByRole("heading", { level: 1, name: heading }).waitFor();
}

// Chooses a photo and returns the verdict in words.
export async function ask(page, photo) {
  await page.setInputFiles(".chooser input >> nth=0", photo);
  await page.locator(".verdict").waitFor();
  return page.locator(".verdict h2").innerText();
}

export const json = (value) => ({ contentType: "application/json", body: JSON.stringify(value) });
