// A service with keys: the console asks for one once a tab, keeps it no longer, and says when it is wrong.

import assert from "node:assert/strict";
import {after, before, test} from "node:test";
import {findings} from "./axe.mjs";
import {launch, withTab} from "./browser.mjs";
import {Service} from "./service.mjs";

let service;
let browser;
before(async () => {
  service = await Service.start({key: true});
  browser = await launch();
});
after(async () => {
  await browser?.close();
  await service?.stop();
});

test("the key is asked for once a tab, and all works with it", () => withTab(browser, service.url, {}, async (page, tab) => {
  tab.expects(/401/);
  await page.goto(service.url);
  await page.waitForSelector("#key-input");
  assert.deepEqual(await findings(page), []);
  await page.fill("#key-input", service.key);
  await page.keyboard.press("Enter");
  await page.waitForSelector("#health .state");
  await page.fill("#new-name", "rooms");
  await page.getByRole("button", {name: "Create", exact: true}).click();
  await page.waitForSelector("#exemplars");
  // The tab keeps it when it is loaded anew; another tab doesn't have it.
  await page.reload();
  await page.waitForSelector("#training #option-method");
  assert.equal(await page.locator("#key-input").count(), 0);
  assert.ok(await page.isVisible("#key"), "another key can be given");
  await withTab(browser, service.url, {context: tab.context}, async (other, second) => {
    second.expects(/401/);
    await other.goto(service.url);
    await other.waitForSelector("#key-input");
  });
}));

test("a wrong key is told, and the right one may be given then", () => withTab(browser, service.url, {}, async (page, tab) => {
  tab.expects(/401/);
  await page.goto(service.url);
  await page.fill("#key-input", "lmk_wrong");
  await page.keyboard.press("Enter");
  await page.waitForFunction(() => document.getElementById("key-input")?.value === "");
  const told = await page.innerText("dialog");
  assert.match(told, /key/i);
  assert.match(told, /not|wrong|unknown|no key|force/i, "the dialog says that the key isn't one");
  await page.fill("#key-input", service.key);
  await page.keyboard.press("Enter");
  await page.waitForSelector("#health .state");
}));

test("without a key nothing is shown, and the page says why", () => withTab(browser, service.url, {}, async (page, tab) => {
  tab.expects(/401/);
  await page.goto(service.url);
  await page.waitForSelector("#key-input");
  await page.keyboard.press("Escape");
  await page.locator("main .problem", {hasText: "key_required"}).waitFor();
  assert.equal(await page.locator("dialog").count(), 0);
}));
