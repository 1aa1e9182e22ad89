// What axe-core finds on a page.

import {readFileSync} from "node:fs";

const SOURCE = readFileSync(new URL(import.meta.resolve("axe-core/axe.min.js")), "utf8");
const RULES = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa"];

// Findings in words, serious and critical ones alone.
export async function findings(page) {
  if (!await page.evaluate(() => "axe" in window)) await page.evaluate(SOURCE);
  const {violations} = await page.evaluate((rules) => window.axe.run(document, {runOnly: rules, resultTypes: ["violations"]}), RULES);
  return violations.filter(({impact}) => ["serious", "critical"].includes(impact))
    .map(({id, impact, nodes}) => `${impact} ${id}: ${nodes.slice(0, 3).map(({html, any}) => `${html.slice(0, 120)} ${any[0]?.message ?? ""}`).join(" | ")}`);
}
