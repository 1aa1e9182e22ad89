// A person puts exemplars on a map, sees where frames were taken, and follows a track.

import assert from "node:assert/strict";
import {after, before, test} from "node:test";
import {launch, withTab} from "./browser.mjs";
import {ask, file, sees} from "./person.mjs";
import {frame, place, views} from "./places.mjs";
import {Service} from "./service.mjs";

const PLACES = {kitchen: 11, workshop: 12, library: 13};
const CAMERA = {fx: 150, fy: 150, cx: 79.5, cy: 59.5, width_px: 160, height_px: 120};
const HANDLE_PX = 38; // from a chosen mark to the ring that turns it

let service;
let browser;
before(async () => {
  service = await Service.start();
  browser = await launch();
  const taught = Object.fromEntries(Object.entries(PLACES).map(([label, seed]) => [label, views(seed, 2)]));
  await service.database("bare", "landmarks", taught);
  await service.database("hall", "landmarks", Object.fromEntries(Object.entries(PLACES).map(([label, seed]) => [label, views(seed)])));
  await service.place("hall", "ground-floor");
  await service.train("hall");
});
after(async () => {
  await browser?.close();
  await service?.stop();
});
const visit = (use) => withTab(browser, service.url, {}, use);
const exemplars = async (name) => (await service.call("GET", `v1/databases/${name}/exemplars`)).items;
const placed = async (name) => (await exemplars(name)).filter(({pose}) => pose);
const near = (a, b, most, words) => assert.ok(Math.abs(a - b) <= most, `${words}: ${a}, and not ${b}`);

async function drag(page, from, to) {
  await page.mouse.move(...from);
  await page.mouse.down();
  await page.mouse.move((from[0] + to[0]) / 2, (from[1] + to[1]) / 2);
  await page.mouse.move(...to);
  const kept = page.waitForResponse((answer) => answer.request().method() === "PATCH");
  await page.mouse.up();
  await kept;
}
// What the map says is under a place of the window.
async function under(page, [x, y]) {
  await page.mouse.move(x - 1, y);
  await page.mouse.move(x, y);
  const said = await page.textContent("#map-reading");
  const [, x_m, y_m, label] = /^x (-?[\d.]+) m, y (-?[\d.]+) m(?: · (.*))?$/.exec(said) ?? assert.fail(`the map says ${said}`);
  return {x_m: Number(x_m), y_m: Number(y_m), label};
}
async function ground(page) {
  await page.locator(".map-canvas").scrollIntoViewIfNeeded();
  const {x, y, width, height} = await page.locator(".map-canvas").boundingBox();
  return [x + width / 2, y + height / 2];
}

test("a person drags a picture onto the map, moves it, turns it, and takes both back", () => visit(async (page, tab) => {
  tab.expects(/403/);
  await tab.go("#/databases/bare");
  await page.click("#map > summary");
  const waiting = page.locator("#map-tray button[data-id]");
  await waiting.nth(5).waitFor();
  const [x, y] = await ground(page);
  const box = await waiting.first().boundingBox();
  const dropped = [x - 60, y + 40];
  await drag(page, [box.x + 20, box.y + 20], dropped);
  await waiting.nth(5).waitFor({state: "detached"});
  const [first] = await placed("bare");
  let there = await under(page, dropped);
  assert.equal(there.label, first.label);
  near(there.x_m, first.pose.x_m, 0.02, "x");
  near(there.y_m, first.pose.y_m, 0.02, "y");
  assert.equal(first.pose.yaw_deg, 0);

  const moved = [x + 60, y - 20];
  await drag(page, dropped, moved);
  there = await under(page, moved);
  const [second] = await placed("bare");
  assert.equal(second.id, first.id);
  near(there.x_m, second.pose.x_m, 0.02, "x after the drag");
  assert.ok(second.pose.x_m > first.pose.x_m + 0.1 && second.pose.y_m > first.pose.y_m + 0.05, "to the right is x, upwards y");

  await drag(page, [moved[0] + HANDLE_PX, moved[1]], [moved[0], moved[1] - 60]);
  const [turned] = await placed("bare");
  near(turned.pose.yaw_deg, 90, 2, "heading");
  assert.equal(turned.pose.x_m, second.pose.x_m);

  for (const expected of [second, first]) {
    const kept = page.waitForResponse((answer) => answer.request().method() === "PATCH");
    await page.click("#map-undo");
    await kept;
    await page.waitForSelector("#map-undo:enabled");
    assert.deepEqual((await placed("bare"))[0].pose, expected.pose);
  }
  await page.getByText("come into force with the next training").waitFor();

  // What the service refuses goes back to where it was.
  const refusal = {status: 403, title: "The key may not", detail: "this key may only recognise", code: "forbidden"};
  await page.route("**/exemplars/*", (route) => route.request().method() === "PATCH" ? route.fulfill({status: 403, json: refusal}) : route.continue());
  const [u, v] = await ground(page); // the page scrolled
  await drag(page, [u - 60, v + 40], [u + 30, v]);
  await sees(page, "#map .problem", /this key may only recognise/);
  assert.equal((await under(page, [u - 60, v + 40])).label, first.label);
  assert.deepEqual((await placed("bare"))[0].pose, first.pose);
}));

test("one that was chosen is placed where a finger taps, and two fingers zoom", () => visit(async (page, tab) => {
  await tab.go("#/databases/bare");
  await page.getByRole("button", {name: "Place workshop"}).first().click();
  const [x, y] = await ground(page);
  const touch = await page.context().newCDPSession(page);
  const fingers = (type, ...points) => touch.send("Input.dispatchTouchEvent", {type, touchPoints: points.map(([u, v], id) => ({x: u, y: v, id}))});
  const before = (await placed("bare")).length;
  const kept = page.waitForResponse((answer) => answer.request().method() === "PATCH");
  await fingers("touchStart", [x + 100, y + 100]);
  await fingers("touchEnd");
  await kept;
  const after = await placed("bare");
  assert.equal(after.length, before + 1);
  assert.ok(after.some(({label}) => label === "workshop"));

  const width = async () => (await under(page, [x + 100, y])).x_m - (await under(page, [x - 100, y])).x_m;
  const wide = await width();
  await fingers("touchStart", [x - 50, y - 120], [x + 50, y - 120]);
  for (const apart of [70, 90, 100]) await fingers("touchMove", [x - apart, y - 120], [x + apart, y - 120]);
  await fingers("touchEnd");
  await page.waitForTimeout(100);
  near(await width(), wide / 2, 0.05 * wide, "the width of the map under 200 px");
}));

test("without a mouse the numbers place a picture, and a wrong one is explained", () => visit(async (page, tab) => {
  tab.expects(/422/);
  await tab.go("#/databases/bare");
  await page.getByRole("button", {name: "Place library"}).first().focus();
  await page.keyboard.press("Enter");
  await page.fill("#map-detail [name=map]", "cellar");
  await page.fill("#map-detail [name=x_m]", "9000000000");
  await page.fill("#map-detail [name=y_m]", "-2");
  await page.fill("#map-detail [name=yaw_deg]", "45");
  await page.getByRole("button", {name: "Place it"}).click();
  await sees(page, "#map-detail .problem", /not within 1000000 m/);
  assert.equal(await page.getAttribute("#map-detail [name=x_m]", "aria-invalid"), "true");
  await page.fill("#map-detail [name=x_m]", "1.5");
  await page.getByRole("button", {name: "Place it"}).click();
  await page.getByRole("button", {name: "cellar (1)", pressed: true}).waitFor();
  const [{label, pose}] = (await placed("bare")).filter((exemplar) => exemplar.pose.map === "cellar");
  assert.equal(label, "library");
  assert.deepEqual([pose.x_m, pose.y_m, pose.yaw_deg], [1.5, -2, 45]);
  // The keys of the map find it too, and the table has its numbers.
  await page.keyboard.press("Escape");
  await page.focus(".map-canvas");
  await page.keyboard.press("PageDown");
  await sees(page, "#map-detail h3", "library");
  await page.locator(".map-card img").waitFor();
  await sees(page, ".map-card", /library\s*x 1.5, y -2 m, 45°/);
  await page.click("#map-table summary");
  await sees(page, "#map-table tbody tr", /library.*1\.5.*-2/);
}));

test("the map zooms around the pointer and pans, by wheel, drag and keys", () => visit(async (page, tab) => {
  await tab.go("#/databases/hall");
  await page.getByRole("button", {name: "ground-floor (12)"}).waitFor();
  const [x, y] = await ground(page);
  const at = [x + 90, y - 50];
  const width = async () => (await under(page, [x + 190, y])).x_m - (await under(page, [x - 10, y])).x_m; // of 200 px, in metres
  const wide = await width();
  const held = await under(page, at);
  await page.mouse.wheel(0, -400);
  await page.waitForTimeout(100);
  near((await under(page, at)).x_m, held.x_m, 0.02, "x under the pointer");
  assert.ok(await width() < 0.6 * wide, "zoomed in");
  // A free spot is held where the pointer goes.
  const free = [x + 10, y + 150];
  const before = await under(page, free);
  await page.mouse.down();
  await page.mouse.move(free[0] + 70, free[1] - 30, {steps: 3});
  await page.mouse.up();
  const after = await under(page, [free[0] + 70, free[1] - 30]);
  near(after.x_m, before.x_m, 0.03, "x of the dragged ground");
  near(after.y_m, before.y_m, 0.03, "y of the dragged ground");
  await page.focus(".map-canvas");
  await page.keyboard.press("ArrowRight");
  await page.waitForTimeout(50);
  assert.ok((await under(page, [free[0] + 70, free[1] - 30])).x_m > after.x_m + 0.05, "farther to the right");
  await page.keyboard.press("0");
  await page.waitForTimeout(50);
  const fitted = await under(page, at);
  near(fitted.x_m, held.x_m, 0.02, "x after all is shown again");
}));

test("an exemplar's card has its pose, camera and size", () => visit(async (page, tab) => {
  tab.expects(/422/);
  await tab.go("#/databases/bare");
  const card = page.getByRole("region", {name: "Exemplars of workshop"}).locator("figure").first();
  await card.getByRole("button", {name: /Pose, camera and size/}).click();
  const dialog = page.getByRole("dialog");
  await dialog.getByText("Height, camera, size").click();
  await dialog.locator("[name=map]").fill("cellar");
  for (const [name, value] of Object.entries({x_m: 3, y_m: 4, yaw_deg: 180, z_m: 1.2, size_mm: 210})) await dialog.locator(`[name=${name}]`).fill(`${value}`);
  await dialog.locator("[name=camera]").selectOption("+");
  for (const [name, value] of Object.entries({...CAMERA, fx: -5})) await dialog.locator(`[name=${name}]`).fill(`${value}`);
  await dialog.getByRole("button", {name: "Save"}).click();
  await dialog.locator(".problem").waitFor();
  assert.equal(await dialog.locator("[name=fx]").getAttribute("aria-invalid"), "true");
  await dialog.locator("[name=fx]").fill("150");
  await dialog.getByRole("button", {name: "Save"}).click();
  await dialog.waitFor({state: "detached"});
  await sees(page, "#exemplars figcaption", /cellar: 3, 4 m, 180°[\s\S]*210 mm wide[\s\S]*with camera/);
  const [kept] = (await placed("bare")).filter(({size_mm}) => size_mm);
  assert.deepEqual([kept.pose.z_m, kept.camera.fx, kept.label], [1.2, 150, "workshop"]);
}));

test("thousands of exemplars stay a map, and the lists beside it stay short", () => visit(async (page, tab) => {
  const [one] = await exemplars("hall");
  const items = Array.from({length: 2000}, (_, n) => ({...one, id: `${one.id.slice(0, -4)}${String(n).padStart(4, "0")}`, label: `spot-${n}`,
    pose: n < 1900 ? {...one.pose, x_m: n % 50, y_m: Math.floor(n / 50)} : null}));
  await page.route("**/exemplars?limit=500*", (route) => {
    const from = Number(new URL(route.request().url()).searchParams.get("cursor") ?? 0);
    return route.fulfill({json: {items: items.slice(from, from + 500), next_cursor: from + 500 < items.length ? `${from + 500}` : null}});
  });
  await page.route("**/exemplars/*/image", async (route) => route.fulfill({contentType: "image/png", body: place(11).png()}));
  await tab.go("#/databases/hall");
  await page.getByRole("button", {name: "ground-floor (1900)"}).waitFor();
  assert.equal(await page.locator("#map-tray button[data-id]").count(), 24);
  await page.click("#map-table summary");
  assert.equal(await page.locator("#map-table tbody tr").count(), 100);
  const painted = await page.evaluate(() => {
    const canvas = document.querySelector(".map-canvas");
    const {data} = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    return data.filter((value, at) => at % 4 === 3 && value > 200).length / (canvas.width * canvas.height);
  });
  assert.ok(painted > 0.05, `${painted} of the map is painted`);
}));

test("a camera is kept and named, and the answer says on the map where the frame was taken", () => visit(async (page, tab) => {
  await tab.go("#/try/hall");
  await page.selectOption("#camera", "+");
  await page.fill("#new-camera [name=name]", "front");
  for (const [name, value] of Object.entries(CAMERA)) await page.fill(`#new-camera [name=${name}]`, `${value}`);
  await page.click("#keep-camera");
  await page.waitForFunction(() => document.querySelector("#camera").value === "front");
  assert.equal((await service.call("GET", "v1/cameras/front")).fx, CAMERA.fx);
  assert.equal(await ask(page, file("frame.png", frame(PLACES.library))), "library");
  assert.match(await page.textContent("#panel-curl code"), /[?&]camera=front/);
  assert.match(await page.textContent("#panel-python code"), /camera="front"/);
  await sees(page, "#try-where", /ground-floor: x .* m, y .* m, heading .*With 95 % within ±.*\([1-4] exemplars?\)\./s);
  assert.ok(await page.locator("#try-where .map-canvas").isVisible());
  await page.selectOption("#camera", "");
  await page.waitForFunction(() => !document.querySelector("#panel-curl code")?.textContent.includes("camera="));
  const [, x_m] = /x (-?[\d.]+) m/.exec(await page.textContent("#try-where .answer"));
  near(Number(x_m), Object.keys(PLACES).sort().indexOf("library"), 0.25, "the library's x");
}));

// A landmark that is looked at from straight before it: its normal towards the camera, its z axis up.
const FACING = [0.5, 0.5, -0.5, 0.5];
const turnedBy = (deg) => { // about its own z axis
  const [x, y, z, w] = FACING;
  const [sin, cos] = [Math.sin(deg * Math.PI / 360), Math.cos(deg * Math.PI / 360)];
  return [x * cos + y * sin, y * cos - x * sin, z * cos + w * sin, w * cos - z * sin];
};

test("a covariance is an ellipse, and a landmark's pose a distance, a bearing and a tilt", () => visit(async (page, tab) => {
  await tab.go("");
  const {round, aslant, ahead, aside} = await page.evaluate(async ([facing, turned]) => {
    const {beforeCamera, uncertainty} = await import(new URL("console/map_pose.js", location.href));
    return {
      round: uncertainty([0.04, 0, 0, 0, 0.01, 0, 0, 0, 0.01]), aslant: uncertainty([0.025, 0.015, 0, 0.015, 0.025, 0, 0, 0, 100]),
      ahead: beforeCamera({translation_m: [0, 0, 2], quaternion: facing}), aside: beforeCamera({translation_m: [1, -1, 1], quaternion: turned})};
  }, [FACING, turnedBy(30)]);
  // By hand: the square root of 5.991 is 2.4477.
  near(round.axes_m[0], 0.48954, 1e-4, "the long half axis");
  near(round.axes_m[1], 0.24477, 1e-4, "the short one");
  near(round.yaw_deg, 1.96 * 0.1 * 180 / Math.PI, 1e-9, "half the heading's interval");
  near(aslant.turn_rad, Math.PI / 4, 1e-9, "its turn");
  near(aslant.axes_m[0], 0.48954, 1e-4, "its long half axis");
  assert.equal(aslant.yaw_deg, 180);
  near(ahead.distance_m, 2, 1e-12, "distance");
  near(ahead.tilt_deg, 0, 1e-4, "tilt of what is faced");
  near(aside.bearing_deg, 45, 1e-9, "bearing");
  near(aside.elevation_deg, 35.2644, 1e-3, "elevation");
  // The normal, turned to the left or right by 30 degrees, against the line of sight.
  const normal = [Math.sin(Math.PI / 6), 0, -Math.cos(Math.PI / 6)];
  near(Math.cos(aside.tilt_deg * Math.PI / 180), -(normal[0] - 0 * 1 + normal[2]) / Math.sqrt(3), 1e-9, "tilt");
}));

test("a flat landmark's pose is told in words, and that it is ambiguous", () => visit(async (page, tab) => {
  await page.route("**/recognitions?*", async (route) => {
    const answer = await (await route.fetch()).json();
    const pose = {translation_m: [0, 0, 2], quaternion: FACING, covariance: Array(36).fill(0), error_px: 0.4};
    Object.assign(answer.votes[0].placement, {T_camera_landmark: pose, ambiguous: true, alternative: {...pose, quaternion: turnedBy(20)}});
    await route.fulfill({json: answer});
  });
  await tab.go("#/try/hall");
  await ask(page, file("frame.png", frame(PLACES.library)));
  await sees(page, "#try-votes", /2 m before the camera, straight ahead, tilted by 0° from facing it; reprojection error 0\.4 px\. Ambiguous: .* 20°/);
}));

test("frames asked as a track come to its timeline with their pictures, a robot's without", () => visit(async (page, tab) => {
  await tab.go("#/try/hall");
  await page.check("#as-track");
  for (const [name, seed] of Object.entries(PLACES)) await ask(page, file(`${name}.png`, frame(seed)));
  await sees(page, "#try-track", /3 frames/);
  assert.match(await page.textContent("#panel-python code"), /client\.track\("hall"\)\.frame\("library\.png", explain=True\)/);
  assert.match(await page.textContent("#panel-curl code"), /tracks\/[\w-]+\/frames/);
  await page.locator("#try-track").getByRole("link", {name: "Its timeline"}).click();
  await page.locator(".frame-dot").nth(2).waitFor();
  await page.locator("#track-frame img").waitFor();
  await sees(page, "#track-belief table", /somewhere else/);
  await sees(page, "#track-frame", /ground-floor: x .* by all frames of the track/s);
  assert.ok(await page.locator("#track .map-canvas").isVisible());
  await page.locator("#track-slider").focus();
  await page.keyboard.press("Home");
  await page.getByAltText("The frame kitchen.png").waitFor();
  await page.click("#track-table summary");
  await page.locator("#track-table tbody tr").nth(2).waitFor();
  const [{id}] = (await service.call("GET", "v1/databases/hall/tracks")).items;
  await service.call("POST", `v1/databases/hall/tracks/${id}/frames`, {body: place(PLACES.library, {right: 3}).png()});
  await page.locator(".frame-dot").nth(3).waitFor();
  await page.getByRole("button", {name: "Follow the newest"}).click();
  await page.getByAltText("The frame kitchen.png").waitFor({state: "detached"});
  assert.equal(await page.locator("#track-frame img").count(), 0);
  await page.getByRole("button", {name: /End track/}).click();
  await sees(page, "#track-list tr", /gone/);
  assert.equal(await page.locator(".frame-dot").count(), 4);
}));
