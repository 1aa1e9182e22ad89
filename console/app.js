// The router: which address shows which page, the dialog for the key (once a tab), and the page of an error.
// A page is a module with `show(main, parts, signal)`: `parts` are the words of the address after its own, `signal` is
// aborted when the page is left.

import {h, replace} from "./dom.js";
import {key, onKeyAsked, setKey} from "./api.js";
import {problem} from "./parts.js";
import * as overview from "./overview.js";
import * as database from "./database.js";
import * as version from "./version.js";
import * as attempt from "./try.js";
import * as depth from "./depth.js";
import * as workcells from "./workcells.js";

const PAGES = {
  "": overview,
  databases: database, // #/databases/{name}
  versions: version, // #/versions/{name}/{n}[/{other}]
  try: attempt, // #/try[/{name}]
  depth,
  workcells, // #/workcells[/{name}]
  tracks: {show: async (...page) => (await import("./tracks.js")).show(...page)}, // #/tracks/{name}[/{id}]
};

const main = document.getElementById("main");
let leaving = new AbortController();

// Marks the current page in the navigation.
function markHere(word) {
  for (const link of document.querySelectorAll(".bar nav a")) {
    const here = link.getAttribute("href") === `#/${word}`
      || (link.getAttribute("href") === "#/" && ["databases", "versions", "tracks"].includes(word));
    if (here) link.setAttribute("aria-current", "page");
    else link.removeAttribute("aria-current");
  }
}

async function route() {
  leaving.abort();
  leaving = new AbortController();
  const {signal} = leaving;
  replace(main, h("p", {class: "muted"}, "Loading…"));
  try {
    const [word = "", ...parts] = location.hash.replace(/^#\/?/, "").split("/").map(decodeURIComponent);
    markHere(word);
    const page = PAGES[word];
    if (!page) throw new Error(`There is no page “${word}” here.`);
    await page.show(main, parts, signal);
    if (!signal.aborted) document.title = `${main.querySelector("h1")?.textContent ?? "landmarkd"} – landmarkd`;
  } catch (error) {
    if (error.name !== "AbortError" && !signal.aborted) replace(main, h("h1", {}, "That didn't work"), problem(error));
  }
}

const keyButton = document.getElementById("key");
function keyDialog(refused) {
  return new Promise((resolve) => {
    const input = h("input", {type: "password", id: "key-input", autocomplete: "off", required: true, spellcheck: "false"});
    const dialog = h("dialog", {"aria-labelledby": "key-title"},
      h("form", {method: "dialog", onSubmit: () => { dialog.returnValue = "given"; }},
        h("h2", {id: "key-title"}, "This service asks for a key"),
        h("p", {}, refused?.detail ?? "Give another key for this tab."),
        h("label", {for: "key-input"}, "Key (lmk_…)"), input,
        h("p", {class: "muted"}, "It is kept until this tab is closed, and sent nowhere else."),
        h("div", {class: "row end"},
          h("button", {type: "button", class: "quiet", onClick: () => dialog.close("")}, "Cancel"),
          h("button", {type: "submit"}, "Use the key"))));
    dialog.addEventListener("close", () => {
      const given = dialog.returnValue === "given" ? input.value.trim() : null;
      dialog.remove();
      keyButton.hidden = !(given || key());
      resolve(given);
    });
    document.body.append(dialog);
    dialog.showModal();
  });
}
onKeyAsked(keyDialog);
keyButton.hidden = !key();
keyButton.addEventListener("click", async () => {
  const given = await keyDialog();
  if (given) { setKey(given); route(); }
});

document.querySelector(".skip").addEventListener("click", (event) => { event.preventDefault(); main.focus(); });
window.addEventListener("hashchange", () => { route(); main.focus(); });
window.addEventListener("unhandledrejection", (event) => {
  if (event.reason?.name === "AbortError") event.preventDefault();
});
route();
