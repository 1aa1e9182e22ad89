// Jobs: they can be cancelled, and the memory of the page is bounded however many events they send.

import assert from "node:assert/strict";
import {after, before, test} from "node:test";
import {launch, withTab} from "./browser.mjs";
import {sees} from "./person.mjs";
import {views} from "./places.mjs";
import {Service} from "./service.mjs";

const EVENTS = 1000;
const MOST_GROWTH_BYTES = 400_000;

let service;
let browser;
before(async () => {
  service = await Service.start();
  browser = await launch();
  // Enough that a training lasts for seconds.
  await service.database("slow", "landmarks", Object.fromEntries([21, 22, 23, 24].map((seed) => [`place-${seed}`, views(seed, 6)])));
});
after(async () => {
  await browser?.close();
  await service?.stop();
});

test("a training that runs is cancelled on the page of its database", () => withTab(browser, service.url, {}, async (page, tab) => {
  await tab.go("#/databases/slow");
  await page.waitForSelector("#option-method");
  await page.click("#train");
  await page.locator("#live-jobs .state.running").waitFor();
  await page.getByRole("button", {name: "Cancel the training of slow"}).click();
  await page.locator("#last-training .state.cancelled").waitFor();
  await sees(page, "#versions", /None yet/);
}));

test("jobs that wait are cancelled on the overview", () => withTab(browser, service.url, {}, async (page, tab) => {
  // More than end meanwhile.
  for (let query_points = 100; query_points < 110; query_points += 1) await service.call("POST", "v1/databases/slow/trainings", {json: {options: {query_points}}});
  await tab.go("");
  const cancel = page.locator("#live-jobs").getByRole("button", {name: "Cancel"});
  const cancelled = page.locator("#ended-jobs .state.cancelled");
  await cancel.nth(2).waitFor();
  const before = await cancelled.count();
  // The last first: it waits longest.
  for (let more = 0; more < 3; more += 1) {
    await cancel.last().click();
    await cancelled.nth(before + more).waitFor();
  }
  for (const {id} of (await service.call("GET", "v1/jobs?limit=20")).items) await service.call("DELETE", `v1/jobs/${id}`).catch(() => {});
}));

test(`after ${EVENTS} events of a job the page's memory is as it was`, () => withTab(browser, service.url, {}, async (page, tab) => {
  const job = {id: "0", kind: "training", database: "slow", state: "running", progress: {stage: "rehearsal", done: 0, total: EVENTS}, attempts: 1, created_at: new Date(0).toISOString()};
  await page.route("**/v1/jobs?*", (route) => route.fulfill({json: {items: [job], next_cursor: null}}));
  // A stream of events in the service's format, sent by this test.
  await page.addInitScript((first) => {
    const {fetch} = window;
    window.fetch = async (path, options) => {
      if (!`${path}`.endsWith("/events")) return fetch(path, options);
      const body = new ReadableStream({start(controller) {
        const encoder = new TextEncoder();
        let id = 0;
        window.say = (done) => controller.enqueue(encoder.encode(`id: ${id += 1}\ndata: ${JSON.stringify({...first, progress: {...first.progress, done}})}\n\n`));
      }});
      return new Response(body, {headers: {"Content-Type": "text/event-stream"}});
    };
  }, job);
  await tab.go("");
  await page.waitForFunction(() => "say" in window);
  const session = await tab.context.newCDPSession(page);
  await session.send("Performance.enable");
  const heap = async () => {
    await session.send("HeapProfiler.collectGarbage");
    const {metrics} = await session.send("Performance.getMetrics");
    const of = (name) => metrics.find((metric) => metric.name === name).value;
    return {bytes: of("JSHeapUsedSize"), nodes: of("Nodes")};
  };
  const say = (from, to) => page.evaluate(async ([from, to]) => {
    for (let done = from; done <= to; done += 1) {
      window.say(done);
      await new Promise((wake) => setTimeout(wake, 1));
    }
  }, [from, to]);
  const shown = (done) => page.getByText(`rehearsal ${done} of ${EVENTS}`).waitFor();
  // What is made once is made, the looking included.
  await say(0, 20);
  await shown(20);
  const before = await heap();
  await say(21, EVENTS);
  await shown(EVENTS);
  const after = await heap();
  console.log(`memory: ${(before.bytes / 1e6).toFixed(2)} MB and ${before.nodes} nodes before, ${(after.bytes / 1e6).toFixed(2)} MB and ${after.nodes} nodes after ${EVENTS} events`);
  assert.ok(after.bytes - before.bytes < MOST_GROWTH_BYTES, "the heap grew");
  assert.ok(after.nodes - before.nodes < 200, "the document grew");
}));
