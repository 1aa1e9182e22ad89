// A person teaches places: from nothing to an answer, to a second version, and back.

import assert from "node:assert/strict";
import {execFile} from "node:child_process";
import {mkdtemp, rm, writeFile} from "node:fs/promises";
import {tmpdir} from "node:os";
import {join} from "node:path";
import {after, before, test} from "node:test";
import {promisify} from "node:util";
import {launch, withTab} from "./browser.mjs";
import {ask, createDatabase, file, folderOf, sees, train, uploadFolder} from "./person.mjs";
import {blank, frame, place, views} from "./places.mjs";
import {Service} from "./service.mjs";

const PLACES = {kitchen: 11, workshop: 12, library: 13};

let service;
let browser;
let folder;
before(async () => {
  folder = await folderOf(Object.fromEntries(Object.entries(PLACES).map(([label, seed]) => [label, views(seed)])));
  service = await Service.start();
  browser = await launch();
});
after(async () => {
  await browser?.close();
  await service?.stop();
  await rm(folder, {recursive: true});
});
const visit = (use) => withTab(browser, service.url, {}, use);

test("a person without any database is told the four steps", () => visit(async (page, tab) => {
  await tab.go("");
  assert.equal(await page.locator("#first-steps li").count(), 4);
  await page.click("text=Try it");
  await page.getByText("There is no database yet").waitFor();
}));

test("a person creates a database, uploads a folder of places, trains it, and watches how far it is", () => visit(async (page, tab) => {
  await tab.go("");
  await createDatabase(page, "rooms", "landmarks");
  await sees(page, "#summary", /no exemplars yet/);
  assert.match(await uploadFolder(page, folder), /12 of 12 sent: 12 kept, 0 were there, 0 refused/);
  await page.getByRole("heading", {name: "workshop 4"}).waitFor();
  const said = await train(page, 1);
  assert.ok(said.some((words) => /training of rooms/.test(words)), `the progress said ${JSON.stringify(said)}`);
  await sees(page, "#last-training", /succeeded.*version 1/);
  await sees(page, "#summary", /12 exemplars of 3 labels · version 1 answers/);
}));

test("the same folder again adds nothing", () => visit(async (page, tab) => {
  await tab.go("#/databases/rooms");
  assert.match(await uploadFolder(page, folder), /0 kept, 12 were there, 0 refused/);
}));

test("a frame of a known place is recognised, and shows the votes and the points that say so", () => visit(async (page, tab) => {
  await tab.go("#/try/rooms");
  assert.equal(await ask(page, file("frame.png", frame(PLACES.library))), "library");
  assert.equal(await page.textContent("#try-status"), "Recognised: library");
  await sees(page, "#try-votes tbody tr", /library/);
  const points = page.locator(".annotated svg .points:not(.off) circle");
  assert.ok(await points.count() > 20, "points are drawn");
  // Another point under the pointer is another evidence.
  const evidence = () => page.innerText("#try-evidence");
  await page.waitForSelector("#try-evidence table");
  const first = await page.getAttribute("#try-point", "aria-valuetext");
  await page.locator(".frame .annotated").first().scrollIntoViewIfNeeded();
  for (let at = 1; at < 12 && await page.getAttribute("#try-point", "aria-valuetext") === first; at += 1) await points.nth(3 * at).hover({force: true});
  assert.notEqual(await page.getAttribute("#try-point", "aria-valuetext"), first);
  assert.match(await evidence(), /The votes of this point[\s\S]*Votes for/);
  // And from the keyboard.
  const hovered = await page.getAttribute("#try-point", "aria-valuetext");
  await page.focus("#try-point");
  await page.keyboard.press("End");
  assert.notEqual(await page.getAttribute("#try-point", "aria-valuetext"), hovered);
  await sees(page, "#try-timings", /decode .* ms/);
}));

test("an exemplar of its own is asked about with one click", () => visit(async (page, tab) => {
  await tab.go("#/try/rooms");
  await page.getByRole("button", {name: "Ask about the exemplar kitchen"}).first().click();
  await page.waitForSelector("#try-decision");
  assert.equal(await page.textContent("#try-status"), "Recognised: kitchen");
}));

test("a strange place is answered Unknown, with reasons", () => visit(async (page, tab) => {
  await tab.go("#/try/rooms");
  assert.equal(await ask(page, file("strange.png", place(77))), "Unknown");
  assert.match(await page.textContent("#try-status"), /^Unknown/);
  assert.ok(await page.locator(".verdict .reasons li").count() > 0, "a reason is given");
  assert.equal(await ask(page, file("blank.png", blank())), "Unknown");
  await sees(page, ".verdict .reasons", /no_interest_points/);
}));

test("the request that is shown for curl works as it stands", () => visit(async (page, tab) => {
  await tab.go("#/try/rooms");
  const picture = frame(PLACES.library);
  await ask(page, file("a frame.png", picture));
  const shown = await page.textContent("#panel-curl code");
  const own = await mkdtemp(join(tmpdir(), "landmarkd-curl-"));
  await writeFile(join(own, "a frame.png"), picture.png());
  const {stdout} = await promisify(execFile)("sh", ["-c", shown], {cwd: own});
  await rm(own, {recursive: true});
  assert.equal(JSON.parse(stdout).decision.label, "library");
}));

test("a picture of the device's camera is asked about", () => visit(async (page, tab) => {
  await tab.go("#/try/rooms");
  await page.getByRole("button", {name: "Use the camera"}).click();
  await page.waitForFunction(() => document.querySelector("dialog video")?.videoWidth > 0);
  await page.getByRole("button", {name: "Take a picture"}).click();
  await page.waitForSelector("#try-answer:not([aria-busy]) #try-decision");
  assert.equal(await page.locator("dialog").count(), 0);
}));

test("who leaves Try it while it loads stays where they went", () => visit(async (page, tab) => {
  let pass;
  const held = new Promise((resolve) => { pass = resolve; });
  await tab.go("#/depth");
  await page.route("**/v1/databases?*", async (route) => { await held; await route.continue().catch(() => {}); });
  await page.evaluate(() => { location.hash = "#/try/rooms"; });
  await page.waitForRequest("**/v1/databases?*");
  await page.evaluate(() => { location.hash = "#/depth"; });
  await page.waitForSelector("#measure");
  pass();
  await page.waitForTimeout(500);
  assert.equal(await page.textContent("main h1"), "Depth");
  assert.equal(new URL(page.url()).hash, "#/depth");
}));

test("a person trains again with other options, compares both versions, and rolls back to version 1", () => visit(async (page, tab) => {
  await tab.go("#/databases/rooms");
  await page.selectOption("#option-viewpoint", "upright");
  await train(page, 2);
  await sees(page, "#summary", /version 2 answers/);
  await page.getByRole("link", {name: "Compare with 2: version 1"}).click();
  await page.locator("h1", {hasText: "version 2 and version 1"}).waitFor();
  assert.ok(await page.locator("svg.chart").count() > 0);
  await tab.go("#/databases/rooms");
  await page.getByRole("button", {name: "Roll back to version 1"}).click();
  await page.locator("#summary", {hasText: "version 1 answers"}).waitFor();
  await tab.go("#/try/rooms");
  await ask(page, file("frame.png", frame(PLACES.kitchen)));
  await page.getByRole("link", {name: "rooms, version 1"}).waitFor();
  await page.selectOption("#try-version", "version 2");
  await page.getByRole("link", {name: "rooms, version 2"}).waitFor();
}));

test("an alias points where a person wants it, and goes again", () => visit(async (page, tab) => {
  await tab.go("#/databases/rooms");
  await page.fill("#alias-name", "stable");
  await page.selectOption("#alias-version", "1");
  await page.getByRole("button", {name: "Point"}).click();
  await page.getByRole("button", {name: "Remove alias stable"}).click();
  await page.getByRole("button", {name: "Remove it"}).click();
  await page.getByRole("button", {name: "Remove alias stable"}).waitFor({state: "detached"});
}));

test("a database goes only after its name was typed", () => visit(async (page, tab) => {
  await service.call("PUT", "v1/databases/passing", {json: {kind: "landmarks"}});
  await tab.go("#/databases/passing");
  await page.click("#delete-database");
  const sure = page.getByRole("button", {name: "Delete it"});
  assert.ok(await sure.isDisabled());
  await page.fill("#confirm-word", "passing");
  await sure.click();
  await page.waitForSelector("#databases table");
  assert.equal(await page.locator("#databases", {hasText: "passing"}).count(), 0);
}));
