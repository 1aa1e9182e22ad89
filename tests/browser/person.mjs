// What a person does at the console.

import {mkdir, mkdtemp, writeFile} from "node:fs/promises";
import {tmpdir} from "node:os";
import {join} from "node:path";

// A folder on the person's disk with a folder a label: {label: [[name, bytes]]}.
export async function folderOf(labels) {
  const folder = await mkdtemp(join(tmpdir(), "landmarkd-pictures-"));
  for (const [label, files] of Object.entries(labels)) {
    await mkdir(join(folder, label));
    for (const [name, bytes] of files) await writeFile(join(folder, label, name), bytes);
  }
  return folder;
}

export const file = (name, picture) => ({name, mimeType: "image/png", buffer: picture.png()});

export async function createDatabase(page, name, kind) {
  await page.fill("#new-name", name);
  await page.selectOption("#new-kind", kind);
  await page.getByRole("button", {name: "Create", exact: true}).click();
  await page.waitForSelector("#exemplars");
}

// Chooses a folder and sends what is in it; the report in words.
export async function uploadFolder(page, folder) {
  await page.setInputFiles("#exemplars input[webkitdirectory]", folder);
  await page.click("#upload");
  await page.waitForSelector("#upload-report:not(:has(progress)) span");
  return page.innerText("#upload-report");
}

// Trains and waits for version `expected`; the texts of the progress meanwhile, each once.
export async function train(page, expected) {
  await page.evaluate(() => {
    window.progressTexts = [];
    new MutationObserver(() => {
      const said = document.querySelector("#training #live-jobs")?.innerText;
      if (said && said !== window.progressTexts.at(-1)) window.progressTexts.push(said);
    }).observe(document.getElementById("training"), {subtree: true, childList: true, characterData: true});
  });
  await page.click("#train");
  await page.locator("#versions li", {hasText: `version ${expected}`}).waitFor();
  await page.waitForFunction(() => !document.querySelector("#live-jobs .job"));
  return page.evaluate(() => window.progressTexts);
}

// Waits until a part of the page says it.
export const sees = (page, part, words) => page.locator(part).filter({hasText: words}).first().waitFor();

// Drops a frame on the Try page, and waits for its answer; the decision's words.
export async function ask(page, frame) {
  const before = await page.$("#try-answer > *");
  await page.setInputFiles("#try-asking input[type=file]", frame);
  if (before) await before.waitForElementState("hidden").catch(() => {});
  await page.waitForSelector("#try-answer:not([aria-busy]) #try-decision");
  return page.innerText("#try-decision");
}
