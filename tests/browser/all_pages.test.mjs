// Every page, light and dark, on a desk and on a phone: accessible, without horizontal scrolling; and its size in bytes.

import assert from "node:assert/strict";
import {join} from "node:path";
import {after, before, test} from "node:test";
import {findings} from "./axe.mjs";
import {launch, withTab} from "./browser.mjs";
import {focalPair} from "./focal_pair.mjs";
import {ask, file} from "./person.mjs";
import {frame, place, views} from "./places.mjs";
import {Service} from "./service.mjs";
import {NAMES, STRANGE, onTurntable, table, turntable} from "./things.mjs";

const SCREENSHOTS = process.env.LANDMARKD_SCREENSHOTS;
const LOOKS = [["desktop", 1280, 900], ["phone", 390, 844]].flatMap(([device, width, height]) => ["light", "dark"].map((scheme) => ({device, width, height, scheme})));
const MOST_BYTES = 300_000;
const PLACES = {kitchen: 11, workshop: 12, library: 13};

let service;
let browser;
before(async () => {
  service = await Service.start();
  browser = await launch();
  await service.call("PUT", "v1/databases/untrained", {json: {kind: "landmarks"}});
  await service.database("rooms", "landmarks", Object.fromEntries(Object.entries(PLACES).map(([label, seed]) => [label, views(seed, 3)])), {viewpoint: "upright"});
  await service.place("rooms", "ground-floor");
  await service.train("rooms", {viewpoint: "upright", query_points: 120});
  const {id} = await service.call("POST", "v1/databases/rooms/tracks", {json: {}});
  for (const seed of Object.values(PLACES)) await service.call("POST", `v1/databases/rooms/tracks/${id}/frames`, {body: frame(seed).png()});
  await service.database("things", "objects", Object.fromEntries(NAMES.map((name) => [name, turntable(name)])), {segment: true});
  await service.call("PUT", "v1/workcells/bench", {json: {database: "things", correspondences: [[40, 40], [440, 60], [240, 320]].map(([x, y]) => ({image_px: [x, y], robot_mm: [200 + x / 2, 150 - y / 2]}))}});
});
after(async () => {
  await browser?.close();
  await service?.stop();
});

const asked = (picture) => (page) => ask(page, file("frame.png", picture));
const openAll = (page) => page.evaluate(() => { for (const details of document.querySelectorAll("main details")) details.open = true; });

// Name, address, and what is done there before the checks.
const PAGES = [
  ["overview", ""],
  ["database-places", "#/databases/rooms", openAll],
  ["database-things", "#/databases/things"],
  ["database-untrained", "#/databases/untrained"],
  ["version-places", "#/versions/rooms/2", openAll],
  ["version-things", "#/versions/things/1"],
  ["versions-compared", "#/versions/rooms/2/1"],
  ["try", "#/try/rooms", async (page) => { await page.check("#as-track"); await page.selectOption("#camera", "+"); }],
  ["tracks", "#/tracks/rooms", async (page) => { await page.locator(".frame-dot").nth(2).waitFor(); await openAll(page); }],
  ["try-recognised", "#/try/rooms", asked(frame(PLACES.kitchen))],
  ["try-unknown", "#/try/rooms", asked(place(77))],
  ["try-pose", "#/try/things", async (page) => { await asked(onTurntable("bracket", 47, 2))(page); await page.locator("#try-dial .views circle").first().waitFor({state: "attached"}); await openAll(page); }],
  ["try-strange-thing", "#/try/things", asked(onTurntable(STRANGE, 47, 2))],
  ["depth", "#/depth", openAll],
  ["depth-measured", "#/depth", async (page) => {
    const {near, far} = focalPair();
    await page.setInputFiles("#pair-near input[type=file]", file("near.png", near));
    await page.setInputFiles("#pair-far input[type=file]", file("far.png", far));
    await page.click("#measure");
    await page.waitForSelector("#depth-canvas");
    await page.check("input[name=layer][value=flags]");
  }],
  ["workcells", "#/workcells", openAll],
  ["workcell-inspected", "#/workcells/bench", async (page) => {
    const standing = [...NAMES, STRANGE].map((name, at) => ({name, x: 90 + 100 * at, y: 90 + 60 * at, turn_deg: 70 * at}));
    await page.setInputFiles("#inspect-card .drop input[type=file] >> nth=0", file("table.png", table(standing)));
    await page.waitForSelector("#inspected");
    await openAll(page);
  }],
  ["unknown-page", "#/nowhere"],
];

for (const [name, address, prepare] of PAGES) {
  test(`the page ${name} keeps nobody out and fits every screen`, () => withTab(browser, service.url, {}, async (page, tab) => {
    await tab.go(address);
    await prepare?.(page);
    if (name !== "tracks") await page.waitForLoadState("networkidle"); // that one follows events
    for (const {device, width, height, scheme} of LOOKS) {
      await page.setViewportSize({width, height});
      await page.emulateMedia({colorScheme: scheme});
      await page.evaluate(() => Promise.all([new Promise((drawn) => requestAnimationFrame(() => requestAnimationFrame(drawn))), ...document.getAnimations().map(({finished}) => finished.catch(() => {}))]));
      if (SCREENSHOTS) await page.screenshot({path: join(SCREENSHOTS, `${name}-${device}-${scheme}.png`), fullPage: true});
      const wide = await page.evaluate(() => document.documentElement.scrollWidth);
      assert.ok(wide <= width, `${name} is ${wide} px wide on a screen of ${width} px: ${await page.evaluate(tooWide, width)}`);
      assert.deepEqual(await findings(page), [], `${name}, ${device}, ${scheme}`);
    }
  }));
}

// What reaches beyond the screen, for the message.
function tooWide(width) {
  return [...document.querySelectorAll("body *")].filter((node) => node.getBoundingClientRect().right > width + 1 && !node.closest(".scroll")).slice(0, 5)
    .map((node) => `${node.tagName.toLowerCase()}#${node.id}.${node.getAttribute("class") ?? ""}`).join(", ");
}

test("a problem's type opens a page that says what to do", () => withTab(browser, service.url, {}, async (page, tab) => {
  tab.expects(/409/);
  await tab.go("");
  const {type} = await page.evaluate(async () => (await fetch("v1/databases/untrained/recognitions", {method: "POST", body: new Uint8Array([80, 53, 10, 49, 32, 49, 10, 50, 53, 53, 10, 0])})).json());
  assert.equal(type, "/problems/not_trained");
  await page.goto(new URL(type, service.url).href);
  assert.match(await page.innerText("main"), /not_trained[\s\S]*What to do/);
  for (const {width, height, scheme} of LOOKS) {
    await page.setViewportSize({width, height});
    await page.emulateMedia({colorScheme: scheme});
    assert.ok(await page.evaluate(() => document.documentElement.scrollWidth) <= width);
    assert.deepEqual(await findings(page), []);
  }
  if (SCREENSHOTS) await page.screenshot({path: join(SCREENSHOTS, "problem-phone-dark.png")});
}));

test("the console paints and weighs little", async () => {
  const paints = [];
  let bytes;
  for (let run = 0; run < 5; run += 1) {
    await withTab(browser, service.url, {}, async (page, tab) => {
      await tab.go("");
      const told = await page.evaluate(() => ({
        first: performance.getEntriesByName("first-contentful-paint")[0].startTime,
        bytes: [...performance.getEntriesByType("navigation"), ...performance.getEntriesByType("resource").filter(({name}) => name.includes("/console/"))].reduce((sum, {decodedBodySize}) => sum + decodedBodySize, 0),
      }));
      paints.push(told.first);
      ({bytes} = told);
    });
  }
  const median = paints.toSorted((a, b) => a - b)[2];
  console.log(`first paint: ${median.toFixed(0)} ms (median of 5); the console's files: ${(bytes / 1000).toFixed(1)} kB`);
  assert.ok(median > 0, "each load painted");
  assert.ok(bytes > 100_000, "the files were counted");
  assert.ok(bytes <= MOST_BYTES, `${bytes} bytes`);
});
