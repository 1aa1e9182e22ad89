// A person sets up a table with a camera and a robot, and gets the coordinates of each part.

import assert from "node:assert/strict";
import {after, before, test} from "node:test";
import {launch, withTab} from "./browser.mjs";
import {file, sees} from "./person.mjs";
import {Service} from "./service.mjs";
import {NAMES, STRANGE, middle, table, turntable} from "./things.mjs";

const STANDING = [
  {name: "bracket", x: 90, y: 90, turn_deg: 33}, {name: "lever", x: 310, y: 100, turn_deg: 120}, {name: "cam", x: 130, y: 265, turn_deg: 200},
  {name: STRANGE, x: 370, y: 260, turn_deg: 70}];
// Where the robot is at a pixel of the overview: half a millimetre a pixel, Y away from the reader.
const robot = ([x, y]) => [200 + 0.5 * x, 150 - 0.5 * y];
const CLOSE_MM = 1;
const overview = file("table.png", table(STANDING));

let service;
let browser;
before(async () => {
  service = await Service.start();
  browser = await launch();
  await service.database("parts", "objects", Object.fromEntries(NAMES.map((name) => [name, turntable(name)])), {segment: true});
});
after(async () => {
  await browser?.close();
  await service?.stop();
});

test("a person clicks three points the robot has touched, and every part gets its name and place", () => withTab(browser, service.url, {}, async (page, tab) => {
  await tab.go("#/workcells");
  await page.setInputFiles("#new-workcell input[type=file] >> nth=0", overview);
  const picture = page.locator("#new-workcell .overlaid");
  await picture.waitFor();
  await page.fill("#workcell-form [name=name]", "bench");
  await page.selectOption("#workcell-form [name=database]", "parts");
  for (const [at, [u, v]] of [[0.1, 0.1], [0.9, 0.15], [0.5, 0.9]].entries()) {
    await picture.evaluate((node) => node.scrollIntoView({block: "center"}));
    const box = await picture.boundingBox();
    await page.mouse.click(box.x + u * box.width, box.y + v * box.height);
    const value = async (name) => Number(await page.getByLabel(`${name} of point ${at + 1}`).inputValue());
    const [X, Y] = robot([await value("Image x"), await value("Image y")]);
    // The keyboard is where the robot's place is typed.
    await page.keyboard.type(`${X}`);
    await page.keyboard.press("Tab");
    await page.keyboard.type(`${Y}`);
  }
  await page.click("#keep-workcell");
  // Its page inspects the overview that was dropped.
  await page.waitForSelector("#inspected");
  await sees(page, ".facts", /affine, 3 points/);
  await sees(page, "#inspection .answer", /3 named, 1 unknown/);
  const rows = await page.locator("#parts tbody tr").evaluateAll((list) => list.map((row) => [...row.cells].map((cell) => cell.innerText)));
  for (const thing of STANDING) {
    const [X, Y] = robot(middle(thing));
    const row = rows.find(([, , x, y]) => Math.hypot(x - X, y - Y) < CLOSE_MM);
    assert.ok(row, `nothing is told at ${X.toFixed(1)}, ${Y.toFixed(1)} mm: ${JSON.stringify(rows)}`);
    assert.match(row[1], new RegExp(thing.name === STRANGE ? "unknown" : thing.name));
  }
  // A part chosen in the table says why it is named so.
  await page.getByRole("button", {name: /Part \d: cam/}).click();
  await sees(page, "#part-why", /cam[\s\S]*Turned by/);
}));

test("the workcell is listed, inspects another picture, and is deleted", () => withTab(browser, service.url, {}, async (page, tab) => {
  await tab.go("#/workcells");
  await page.locator("#workcells").getByRole("link", {name: "bench"}).click();
  await page.setInputFiles("#inspect-card .drop input[type=file] >> nth=0", file("empty.png", table([])));
  await page.locator("#inspection", {hasText: "Nothing stands out"}).waitFor();
  await page.click("#delete-workcell");
  await page.getByRole("button", {name: "Delete it"}).click();
  await page.getByText("There is no workcell yet").waitFor();
}));
