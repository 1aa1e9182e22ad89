// A real browser. A test fails on errors and warnings of the page, uncaught exceptions, and requests to other origins.

import assert from "node:assert/strict";
import {chromium} from "playwright-core";

const ARGS = ["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync",
  // A camera of the browser's own, that nobody is asked about.
  "--use-fake-device-for-media-stream", "--use-fake-ui-for-media-stream"];
const WAIT_MS = 15_000;

export const launch = () => chromium.launch({executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: ARGS});

// A tab that records messages. A test names those that it causes with `expects`.
export class Tab {
  static async open(browser, url, {width = 1280, height = 900, scheme = "light", context} = {}) {
    const tab = new Tab();
    tab.own = !context;
    tab.context = context ?? await browser.newContext({viewport: {width, height}, colorScheme: scheme, acceptDownloads: true});
    tab.page = await tab.context.newPage();
    tab.page.setDefaultTimeout(WAIT_MS);
    tab.url = url;
    tab.messages = [];
    tab.expected = [];
    tab.page.on("console", (message) => ["error", "warning"].includes(message.type()) && tab.messages.push(`${message.text()} (${message.location().url})`));
    tab.page.on("pageerror", (error) => tab.messages.push(`not caught: ${error.stack ?? error}`));
    tab.page.on("request", (request) => !request.url().startsWith(url) && !/^(blob|data):/.test(request.url()) && tab.messages.push(`asks another origin: ${request.url()}`));
    tab.page.on("crash", () => tab.messages.push("the tab crashed"));
    return tab;
  }

  // Names the messages that this test causes; each has to come.
  expects(...patterns) { this.expected.push(...patterns); }

  async go(address) {
    await this.page.goto(this.url + address);
    // The same page but for its hash isn't loaded anew: the route is.
    await this.page.waitForFunction(() => document.querySelector("main h1, main h2"));
  }

  async close() {
    await (this.own ? this.context : this.page).close();
    const others = this.messages.filter((text) => !this.expected.some((pattern) => pattern.test(text)));
    assert.deepEqual(others, [], "the browser reported errors or warnings");
    for (const pattern of this.expected) assert.ok(this.messages.some((text) => pattern.test(text)), `${pattern} was expected and didn't come`);
  }
}

// Opens a tab for `use(page, tab)` and closes it. An error of `use` is reported before the messages of the tab.
export async function withTab(browser, url, options, use) {
  const tab = await Tab.open(browser, url, options);
  try {
    await use(tab.page, tab);
  } catch (error) {
    if (tab.messages.length) error.message += `\nmessages meanwhile: ${tab.messages.join("\n")}`;
    await tab.close().catch(() => {});
    throw error;
  }
  await tab.close();
}
