// A person teaches things on a turntable, and gets the name and pose of the one in a picture.

import assert from "node:assert/strict";
import {rm} from "node:fs/promises";
import {after, before, test} from "node:test";
import {launch, withTab} from "./browser.mjs";
import {ask, createDatabase, file, folderOf, sees, train, uploadFolder} from "./person.mjs";
import {Service} from "./service.mjs";
import {NAMES, STRANGE, onTurntable, turntable} from "./things.mjs";

let service;
let browser;
let folder;
before(async () => {
  folder = await folderOf(Object.fromEntries(NAMES.map((name) => [name, turntable(name)])));
  service = await Service.start();
  browser = await launch();
});
after(async () => {
  await browser?.close();
  await service?.stop();
  await rm(folder, {recursive: true});
});
const visit = (use) => withTab(browser, service.url, {}, use);
const apart = (a, b) => Math.abs((a - b + 540) % 360 - 180);

test("the names of turntable views say their poses, and training them makes a version", () => visit(async (page, tab) => {
  await tab.go("");
  await createDatabase(page, "things", "objects");
  assert.match(await uploadFolder(page, folder), /90 kept, 0 were there, 0 refused/);
  await page.getByText("348°").or(page.getByText("12°")).first().waitFor();
  await train(page, 1);
  await sees(page, "#summary", /objects · 90 exemplars of 3 labels · version 1 answers/);
}));

test("a view between the taught ones is named, and the dial shows its turn", () => visit(async (page, tab) => {
  await tab.go("#/try/things");
  for (const [name, turn_deg] of [["bracket", 47], ["lever", 200], ["cam", 311]]) {
    assert.equal(await ask(page, file(`${name}.png`, onTurntable(name, turn_deg, 2))), name);
    const shown = Number(/turned by ([\d.]+)°/.exec(await page.getAttribute("#try-dial", "aria-label"))[1]);
    assert.ok(apart(shown, turn_deg) < 3, `${name} at ${turn_deg}° is shown at ${shown}°`);
    // The dots of the taught views come on the rim.
    await page.locator("#try-dial .views circle").nth(29).waitFor({state: "attached"});
    await sees(page, "#try-candidates tbody tr", new RegExp(`${name}[\\s\\S]*enough`));
  }
}));

test("what the eigenspace makes of the frame is shown beside it, with what is left over", () => visit(async (page, tab) => {
  await tab.go("#/try/things");
  await ask(page, file("lever.png", onTurntable("lever", 90, 2)));
  await page.waitForFunction(() => document.querySelector("#try-reconstruction img")?.naturalWidth > 0);
  const caption = await page.innerText("#try-reconstruction figcaption");
  const left = Number(/([\d.]+) % of the picture's energy/.exec(caption)?.[1]);
  assert.ok(left > 0 && left < 20, caption);
  await page.click("#try-eigenimages summary");
  await page.waitForFunction(() => { const images = [...document.querySelectorAll("#try-eigenimages img")]; return images.length > 2 && images.every(({naturalWidth}) => naturalWidth > 0); });
}));

test("a thing that was never taught is Unknown, and the candidates say how far it is", () => visit(async (page, tab) => {
  await tab.go("#/try/things");
  assert.equal(await ask(page, file("strange.png", onTurntable(STRANGE, 30))), "Unknown");
  await sees(page, ".verdict .reasons", /beyond_threshold/);
  await sees(page, "#try-candidates tbody tr", /too little/);
}));
