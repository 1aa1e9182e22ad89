// A person measures distances from a focal pair whose truth is known.

import assert from "node:assert/strict";
import {readFile} from "node:fs/promises";
import {after, before, test} from "node:test";
import {launch, withTab} from "./browser.mjs";
import {OPTICS, focalPair, truth_mm} from "./focal_pair.mjs";
import {file, sees} from "./person.mjs";
import {Service} from "./service.mjs";

// Of a working range of 83 mm.
const CLOSE_MM = 2;
const pair = focalPair();

let service;
let browser;
before(async () => {
  service = await Service.start();
  browser = await launch();
});
after(async () => {
  await browser?.close();
  await service?.stop();
});

async function measure(page, optics) {
  await page.setInputFiles("#pair-near input[type=file]", file("near.png", pair.near));
  assert.match(await page.innerText("#measure-hint"), /Still missing: the far-focused/);
  await page.setInputFiles("#pair-far input[type=file]", file("far.png", pair.far));
  const {f_number, near_focus_mm, ...rest} = optics;
  await page.selectOption("[name=aperture_kind]", "f_number");
  await page.selectOption("[name=sensor_kind]", "near_focus_mm");
  for (const [name, value] of Object.entries({...rest, aperture_value: f_number, sensor_value: near_focus_mm})) await page.fill(`#optics-form [name=${name}]`, `${value}`);
  await page.check("#optics-form [name=telecentric]");
  await page.click("#measure");
}

test("a slanted plane is measured, and the reading under the cursor is its distance", () => withTab(browser, service.url, {}, async (page, tab) => {
  await tab.go("#/depth");
  await measure(page, OPTICS);
  await page.waitForSelector("#depth-canvas");
  await sees(page, "#depth-result .answer", /of the pixels have a distance/);
  const canvas = page.locator("#depth-canvas");
  await canvas.scrollIntoViewIfNeeded();
  const box = await canvas.boundingBox();
  for (const [x, y] of [[40, 40], [80, 100], [120, 60], [165, 110]]) {
    await page.mouse.move(box.x + (x + 0.5) / pair.width * box.width, box.y + (y + 0.5) / pair.height * box.height);
    const said = await page.innerText("#depth-reading");
    const [, atX, told] = /x (\d+), y \d+: ([\d.,]+) mm/.exec(said) ?? assert.fail(`the reading says “${said}”`);
    assert.ok(Math.abs(Number(told) - truth_mm(Number(atX))) < CLOSE_MM, `${said}, in truth ${truth_mm(Number(atX)).toFixed(1)} mm`);
  }
  // A line drawn with the mouse.
  await page.mouse.move(box.x + 0.2 * box.width, box.y + 0.5 * box.height);
  await page.mouse.down();
  await page.mouse.move(box.x + 0.5 * box.width, box.y + 0.5 * box.height);
  await page.mouse.move(box.x + 0.8 * box.width, box.y + 0.5 * box.height);
  await page.mouse.up();
  const profile = await page.innerText("#depth-profile p");
  const [, from, to] = /from ([\d.]+) to ([\d.]+) mm/.exec(profile);
  assert.ok(Math.abs(from - truth_mm(0.2 * pair.width)) < CLOSE_MM && Math.abs(to - truth_mm(0.8 * pair.width)) < CLOSE_MM, profile);
  for (const layer of ["sigma", "flags", "coverage", "depth"]) {
    await page.check(`input[name=layer][value=${layer}]`);
    assert.ok((await page.innerText("#depth-legend")).length > 5, `the layer ${layer} has a legend`);
  }
  assert.ok(await page.isVisible("#point-cloud"));
  const [download] = await Promise.all([page.waitForEvent("download"), page.getByRole("button", {name: "NPY"}).click()]);
  assert.equal(download.suggestedFilename(), "near-depth.npy");
  const bytes = await readFile(await download.path());
  assert.match(bytes.subarray(0, 128).toString("latin1"), new RegExp(`NUMPY.*'shape': \\(3, ${pair.height}, ${pair.width},?\\)`, "s"));
}));

test("optics that can't be are told at their field, and those that can are kept as a calibration", () => withTab(browser, service.url, {}, async (page, tab) => {
  tab.expects(/422.*\/v1\/depth-maps/);
  await tab.go("#/depth");
  await measure(page, {...OPTICS, focal_length_mm: 600});
  await page.waitForSelector(".problem");
  assert.ok(await page.locator("#optics-form [aria-invalid=true]").count() > 0, "a field is marked");
  await page.fill("[name=focal_length_mm]", "35");
  await page.getByText("Keep these optics as a calibration").click();
  await page.fill("[name=name]", "bench");
  await page.getByRole("button", {name: "Keep them"}).click();
  await page.getByText("Kept as the calibration bench.").waitFor();
  await page.reload();
  await page.selectOption("[name=calibration]", "bench");
  await page.getByText("Not swept").waitFor();
}));
