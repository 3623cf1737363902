// SPDX-License-Identifier: Apache-2.0
// node units_test.mjs: parts of the page without a browser: maps seen from above, numbers, colours, and what is
// kept of what was loaded. Exit status: 0 on success, 1 after a message about what failed.
import assert from "node:assert/strict";
import { createRequire } from "node:module";
import { fileURLToPath } from "node:url";

const kWeb = new URL("../../server/web/", import.meta.url);

async function load() {
  const esbuild = createRequire(kWeb)("esbuild");
  const built = esbuild.buildSync({
    stdin: {
      contents: 'export * from "./colours"; export * from "./kept"; export * from "./pose_view"; export * from "./triangles"; export * from "./words";',
      resolveDir: fileURLToPath(new URL("src", kWeb)),
    },
    bundle: true,
    format: "esm",
    write: false,
  });
  return import(`data:text/javascript;base64,${Buffer.from(built.outputFiles[0].contents).toString("base64")}`);
}

function near(actual, expected, tolerance = 1e-9) {
  const [a, b] = [[actual].flat(Infinity), [expected].flat(Infinity)];
  assert.equal(a.length, b.length, `${JSON.stringify(actual)} is not ${JSON.stringify(expected)}`);
  const all = a.every((v, i) => Math.abs(v - b[i]) <= tolerance);
  assert.ok(all, `${JSON.stringify(actual)} is not ${JSON.stringify(expected)}`);
}

const kHalf = Math.SQRT1_2;

// A server takes names by their bytes; no character is cut.
function testEndWithin({ endWithin }) {
  assert.equal(endWithin("photo.jpg", 200), "photo.jpg");
  assert.equal(endWithin("photo.jpg", 4), ".jpg");
  const long = "写".repeat(100) + ".jpg";
  assert.equal(endWithin(long, 200), "写".repeat(65) + ".jpg"); // 199 bytes
}

function testTurned({ turned }) {
  near(turned([0, 0, kHalf, kHalf], [1, 0, 0]), [0, 1, 0]); // a quarter about z
  near(turned([kHalf, 0, 0, kHalf], [0, 1, 0]), [0, 0, 1]);
  near(turned([-0.5, 0.5, -0.5, 0.5], [0, 0, 1]), [1, 0, 0]); // a camera upright, looking along x
}

function testViews({ axesSeen, seen, viewFromAbove }) {
  const p = [1, 2, 3];
  near(seen(viewFromAbove([0, 0, 1]), p), [1, 2]);
  near(seen(viewFromAbove(null), p), [1, 2]);
  near(seen(viewFromAbove([0.1, 0.25, 0.95]), p), [1, 2]); // the camera was pitched
  near(seen(viewFromAbove([0, -1, 0]), p), [1, 3]); // as the first camera of a sequence: y down
  near(seen(viewFromAbove([0, 0, -1]), p), [1, -2]);
  near(seen(viewFromAbove([1, 0, 0]), p), [2, 3]); // x is up, so y is to the right
  const kAslant = [1, 1, 1].map((v) => v / Math.sqrt(3));
  const { right, top, up } = viewFromAbove(kAslant);
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  near([dot(right, top), dot(top, up), dot(up, right)], [0, 0, 0]);
  near(up, kAslant);
  const axes = (known) => axesSeen(viewFromAbove(known)).map((a) => a.name).join("");
  assert.equal(axes([0, 0, 1]), "xy");
  assert.equal(axes([0, -1, 0]), "xz");
  assert.equal(axes(kAslant), "", "none lies in the picture");
}

// A plan that is turned by a quarter, 10 px a unit: its corners, and its pixels in a drawing.
function testPlans({ planCorners, planTransform }) {
  const plan = { width: 40, height: 20, plan_from_frame: [[0, -10, 30], [-10, 0, 15]] };
  near(planCorners(plan), [[1.5, 3], [1.5, -1], [-0.5, -1], [-0.5, 3]]);
  const at = ([x, y]) => [100 + 7 * x, 50 - 7 * y];
  const [a, b, c, d, e, f] = /matrix\((.*)\)/.exec(planTransform(plan, at))[1].split(" ").map(Number);
  const [x, y] = [0.4, 1.3];
  const [u, v] = [30 - 10 * y, 15 - 10 * x];
  near([a * u + c * v + e, b * u + d * v + f], at([x, y]));
}

function testPanoramas({ asPoseLayer, headingSeen, viewFromAbove }) {
  for (const heading_rad of [0, 0.7, -2.5, 3.1]) {
    const layer = asPoseLayer({ nodes: [{ id: 4, x: 1, y: 2, heading_rad }], metres_per_unit: null });
    near(layer.keyframes.position, [[1, 2, 0]]);
    const seen = headingSeen(viewFromAbove(layer.up), layer.keyframes.orientation[0]);
    near(seen, [Math.cos(heading_rad), Math.sin(heading_rad)]);
  }
}

function testPointInside({ holds, pointInside }) {
  near(pointInside([[0, 0], [4, 0], [4, 2], [0, 2]]), [2, 1]);
  const thin = [[0, 0], [10, 0], [10, 10], [9, 10], [9, 1], [5, 1], [0, 1]]; // its corners' mean is outside
  assert.ok(holds(thin, pointInside(thin)));
  near(pointInside(thin), [10 / 3, 1 / 3]);
}

function testAreas({ areaOf, holds, idsIn, cornersIn, cornerText, withoutLast }) {
  const hook = [[0, 0], [3, 0], [3, 3], [2, 3], [2, 1], [0, 1]];
  near(areaOf(hook), 5);
  assert.deepEqual([[2.5, 2], [1, 2], [1, 0.5], [4, 1]].map((p) => holds(hook, p)), [true, false, true, false]);
  assert.equal(areaOf([]), 0);
  assert.deepEqual(idsIn(" 3, 5 5"), [3, 5]);
  assert.deepEqual([idsIn(""), idsIn("3 x"), idsIn("-1")], [[], null, null]);
  assert.deepEqual(cornersIn(" 0,0  4.5,-1e1 "), [[0, 0], [4.5, -10]]);
  assert.deepEqual(["1", "1,", "a,b", "1,2,3", "1,Infinity"].map(cornersIn), [null, null, null, null, null]);
  assert.equal(cornerText([1.23456, -0.001], 40), "1.23,0");
  assert.equal(withoutLast("1,2 3,4 "), "1,2");
}

function testHeadings({ headingSeen, viewFromAbove }) {
  const above = viewFromAbove([0, 0, 1]);
  near(headingSeen(above, [-0.5, 0.5, -0.5, 0.5]), [1, 0]);
  assert.equal(headingSeen(above, [1, 0, 0, 0]), null, "straight down");
}

function testEllipses({ ellipseSeen, viewFromAbove }) {
  const above = viewFromAbove([0, 0, 1]);
  const covariance = (xx, xy, yy) => [[xx, xy, 0, 9, 9, 9], [xy, yy, 0, 9, 9, 9], [0, 0, 100, 9, 9, 9]];
  const along = ellipseSeen(above, covariance(0.04, 0, 0.01));
  near([along.long, along.short, along.angle_rad], [0.4, 0.2, 0]);
  const across = ellipseSeen(above, covariance(0.01, 0, 0.04));
  near([across.long, across.short, Math.abs(across.angle_rad)], [0.4, 0.2, Math.PI / 2]);
  const aslant = ellipseSeen(above, covariance(1, 0.5, 1));
  near([aslant.long, aslant.short, aslant.angle_rad], [2 * Math.sqrt(1.5), 2 * Math.sqrt(0.5), Math.PI / 4]);
  near(ellipseSeen(viewFromAbove([0, -1, 0]), covariance(0.04, 0, 0.01)).long, 20); // z is seen
}

function testPlanes({ planeSeen, viewFromAbove }) {
  const above = viewFromAbove([0, 0, 1]);
  const wall = { normal: [1, 0, 0], outline: [[5, 1, 0], [5, 4, 1], [5, 2, 2]] };
  near(planeSeen(above, wall).sort((a, b) => a[1] - b[1]), [[5, 1], [5, 4]]);
  const aslant = { normal: [kHalf, kHalf, 0], outline: [[4, 0, 0], [0, 4, 0], [2, 2, 3]] };
  near(planeSeen(above, aslant).sort((a, b) => a[1] - b[1]), [[4, 0], [0, 4]]);
  const floor = { normal: [0, 0, -1], outline: [[0, 0, 0], [1, 0, 0], [1, 1, 0]] };
  near(planeSeen(above, floor), [[0, 0], [1, 0], [1, 1]]);
  assert.deepEqual(planeSeen(above, { ...floor, outline: floor.outline.slice(0, 2) }), []);
  assert.deepEqual(planeSeen(above, { ...wall, outline: [] }), []);
}

function testLayout({ barLength, boxOf, layOut }) {
  const far = Array.from({ length: 99 }, (_, i) => [i / 10, 0]).concat([[500, 900]]);
  const box = boxOf([[-1, 0], [2, 3]], far);
  near([box.low, box.high], [[-1, 0], [9.7, 3]]);
  near(boxOf([[1, 2]], []).high, [1, 2]);
  const room = { width: 300, height: 200, margin: 10, strip: 30 };
  const wide = layOut({ low: [0, 0], high: [28, 7] }, room);
  near(wide.from(wide.at([3, 4])), [3, 4]);
  near([wide.scale, wide.height, wide.at([0, 7]), wide.at([28, 0])], [10, 120, 10, 10, 290, 80]);
  const high = layOut({ low: [0, 0], high: [1, 15] }, room);
  near([high.scale, high.height, high.at([0, 15])], [10, 200, 145, 10]);
  const point = layOut({ low: [3, 3], high: [3, 3] }, room);
  near([point.scale, point.height, point.at([3, 3])], [150, 200, 150, 85]); // one position
  near([barLength(40, 120), barLength(12, 120), barLength(7, 120), barLength(0.01, 120)], [2, 10, 10, 10000]);
  near([barLength(1000, 120), barLength(24, 120)], [0.1, 5]);
}

function testNumbers({ percent, unitOf, withDeviation }) {
  assert.equal(withDeviation(1.23456, 0.0123), "1.235 ± 0.012");
  assert.equal(withDeviation(123.456, 12.3), "123 ± 12");
  assert.equal(withDeviation(-4.2, 0.3), "-4.20 ± 0.30");
  assert.equal(withDeviation(1, 0), "1.000 ± 0.000");
  assert.deepEqual([unitOf("metres"), unitOf("unknown")], ["m", "map units"]);
  assert.deepEqual([0.29, 0.57, 0.899, 1].map(percent), ["29%", "57%", "89%", "100%"]);
}

function testShellWords({ shellWord }) {
  assert.equal(shellWord("http://127.0.0.1:8080/v1/maps/a%20b/localize"), "http://127.0.0.1:8080/v1/maps/a%20b/localize");
  assert.equal(shellWord("office (2).db"), "'office (2).db'");
  assert.equal(shellWord("Tom's.db"), "'Tom'\\''s.db'");
}

// The triangles of a concave outline are all inside it, and fill it.
function testTriangles({ areaOf, holds, trianglesOf }) {
  const hook = [[0, 0], [3, 0], [3, 3], [2, 3], [2, 1], [0, 1]];
  const inSpace = [
    [hook.map(([x, y]) => [5, x, y]), [1, 0, 0]],
    [hook.map(([x, y]) => [x, 5, y]), [0, -1, 0]],
    [hook.map(([x, y]) => [x, y, x / 2]), [-0.447, 0, 0.894]],
  ];
  for (const [outline, normal] of inSpace) {
    const indices = trianglesOf(outline, normal);
    const triangles = Array.from({ length: indices.length / 3 }, (_, i) => indices.slice(3 * i, 3 * i + 3).map((k) => hook[k]));
    const middle = (corners) => [0, 1].map((axis) => corners.reduce((sum, p) => sum + p[axis], 0) / 3);
    assert.ok(triangles.every((corners) => holds(hook, middle(corners))), "each is inside");
    near(triangles.reduce((sum, corners) => sum + areaOf(corners), 0), areaOf(hook));
  }
}

// The latest two that nobody holds are kept; what is held is never dropped.
async function testKept({ Kept }) {
  let loads = 0;
  const dropped = [];
  const load = async (path) => {
    if (path === "bad") throw new Error("bad");
    return `${path}${++loads}`;
  };
  const kept = new Kept(2, load, (value) => dropped.push(value));
  const a = kept.hold("a");
  assert.equal(await a.value, "a1");
  for (const path of ["b", "c", "b", "d"]) await kept.get(path);
  assert.deepEqual(dropped, ["c3"], "b was used after c, and a is held");
  assert.equal(await kept.get("b"), "b2");
  kept.forget((path) => path === "a");
  await null;
  assert.deepEqual(dropped, ["c3"], "a is forgotten, and still shown");
  assert.equal(await kept.get("a"), "a5");
  a.release();
  await null;
  assert.deepEqual(dropped, ["c3", "d4", "a1"]);
  await assert.rejects(kept.get("bad"));
  await assert.rejects(kept.get("bad"), "a failure isn't kept");
}

// As the report has them, and the ids of a few surfaces, which are those of their first planes, told apart.
function testColours({ colourOf }) {
  assert.equal(colourOf(0), "#ff6161");
  const channels = (id) => [1, 3, 5].map((at) => parseInt(colourOf(id).slice(at, at + 2), 16));
  const ids = [1, 8, 15, 17, 26, 33, 41, 43];
  for (const a of ids) {
    for (const b of ids) {
      if (a === b) continue;
      const apart = Math.hypot(...channels(a).map((value, c) => value - channels(b)[c]));
      assert.ok(apart > 15, `${a} and ${b} look alike: ${colourOf(a)}, ${colourOf(b)}`);
    }
  }
}

try {
  const module = await load();
  const tests = [testTurned, testEndWithin, testViews, testPlans, testPanoramas, testPointInside, testAreas, testHeadings, testEllipses, testPlanes, testLayout,
    testNumbers, testShellWords, testTriangles, testKept, testColours];
  for (const test of tests) await test(module);
} catch (error) {
  console.log(String(error.stack ?? error).replace(/\n\s*\n/g, "\n"));
  process.exit(1);
}
