// #/databases/{name}: its exemplars, its training, and its versions with the names that point to them.

import {h, replace, drawOnChange} from "./dom.js";
import {all, get, post, put, remove} from "./api.js";
import {act, confirm, count, poll, liveJobs, outcome, problem, state, time, toast} from "./parts.js";
import {NAME} from "./fields.js";
import {exemplarList} from "./exemplars.js";
import {upload} from "./upload.js";
import {training} from "./training.js";
import {versionLink} from "./overview.js";
import {headline} from "./version.js";

export async function show(main, [name], signal) {
  if (!name) return location.replace("#/");
  const path = `v1/databases/${encodeURIComponent(name)}`;
  const {kind} = await get(path, {signal});
  const page = {name, path, kind, signal, refresh, surveyed};
  // Places are on a map; the page of a turntable does without its files.
  const map = kind === "landmarks" ? (await import("./database_map.js")).databaseMap(page) : null;

  const fault = h("div");
  const summary = h("div", {id: "summary"});
  const live = h("div", {id: "live-jobs"});
  const last = h("div", {id: "last-training"});
  const versions = h("div", {id: "versions"});
  const exemplars = exemplarList(page);
  const alias = aliasForm(page);
  const drawSummary = drawOnChange(summary, (detail) => summaryOf(detail));
  const drawLive = liveJobs(live, signal, () => refresh().catch(() => {}));
  const drawLast = drawOnChange(last, lastTraining);
  const drawVersions = drawOnChange(versions, (data) => versionTable(page, data));

  let known = {};
  async function refresh() {
    const [detail, {items: jobs}] = await Promise.all([
      get(path, {signal}), get(`v1/jobs?database=${encodeURIComponent(name)}&limit=20`, {signal})]);
    const ended = jobs.find((job) => job.finished_at);
    // The long lists are fetched when their counts changed, and after every job.
    if (known.ended !== ended?.id || known.versions !== detail.versions) {
      known.list = (await all(`${path}/versions`, {signal})).reverse();
      alias.draw(known.list);
    }
    if (known.exemplars !== detail.exemplars || known.labels !== detail.labels) await drawExemplars(detail.exemplars);
    Object.assign(known, {ended: ended?.id, versions: detail.versions, exemplars: detail.exemplars, labels: detail.labels});
    if (signal.aborted) return;
    drawSummary({...detail, busy: jobs.some((job) => !job.finished_at)});
    drawLive(jobs);
    drawLast(ended ?? {state: jobs.length ? "under way" : "none"});
    drawVersions({versions: known.list, detail});
  }

  // A key that may only recognise sees the rest of the page.
  async function drawExemplars(counted) {
    try {
      known.items = await all(`${path}/exemplars`, {signal});
      exemplars.draw(known.items, counted);
      map?.draw(known.items, counted);
    } catch (error) {
      if (error.status !== 403) throw error;
      exemplars.refuse(error);
      map?.refuse(error);
    }
  }

  // Shows an exemplar whose survey changed.
  function surveyed(exemplar) {
    known.items = known.items.map((each) => each.id === exemplar.id ? exemplar : each);
    exemplars.draw(known.items, known.exemplars);
    map.draw(known.items, known.exemplars);
  }

  replace(main,
    h("h1", {}, name), summary, jumps(), fault, map?.node,
    h("div", {class: "split"},
      h("section", {class: "card", id: "exemplars"}, h("h2", {}, "Exemplars"), upload(page), exemplars.node),
      h("div", {},
        h("section", {class: "card", id: "training", tabindex: "-1", "aria-label": "Training"}, h("h2", {}, "Training"),
          training(page, () => refresh()), live, last),
        h("section", {class: "card", id: "versions-card", tabindex: "-1", "aria-label": "Versions"}, h("h2", {}, "Versions"), versions,
          alias.node, takeIn(page)),
        h("section", {class: "card"}, h("h2", {}, "Delete"),
          h("p", {class: "muted"}, "With its exemplars, versions and aliases, at once and for good."),
          act("Delete this database", async () => {
            if (!await confirm(`Delete ${name}?`,
              "Its exemplars, versions and aliases go with it, and robots that ask it are answered 404.", "Delete it", name)) return;
            await remove(path);
            if (!signal.aborted) location.hash = "#/";
          }, {kind: "danger", id: "delete-database"})))));
  await refresh();
  poll(refresh, signal, (error) => replace(fault, error && problem(error)));
}

// On a phone the exemplars come first: buttons that scroll to what is below them.
function jumps() {
  const to = (id, text) => h("button", {type: "button", class: "quiet small", onClick() {
    const section = document.getElementById(id);
    section.scrollIntoView();
    section.focus();
  }}, text);
  return h("p", {class: "row narrow"}, to("training", "To training"), to("versions-card", "To versions"));
}

// Kind, counts, current version, and the next step when there is one.
function summaryOf({name, kind, exemplars, labels, current_version: current, busy}) {
  const next = !exemplars ? "It has no exemplars yet: add pictures below, one folder for each label."
    : !current && !busy ? "No version answers yet: train, or make a version current." : null;
  return [
    h("p", {class: "row"}, h("span", {}, h("strong", {}, kind), ` · ${count(exemplars, "exemplar")} of ${count(labels, "label")} · `,
      current ? [versionLink(name, current), " answers"] : "no version answers"),
    current ? h("a", {class: "button", href: `#/try/${encodeURIComponent(name)}`}, "Try it") : null),
    next && h("p", {class: "note"}, next)];
}

function lastTraining(job) {
  if (!job.finished_at) return job.state === "none" && h("p", {class: "muted"}, "Never trained yet.");
  const seconds = job.started_at && (new Date(job.finished_at) - new Date(job.started_at)) / 1000;
  return h("p", {class: job.state === "failed" ? "problem" : "muted"}, "Last: ", state(job.state), " ", time(job.finished_at),
    seconds ? ` after ${seconds.toFixed(1)} s` : "", ". ", outcome(job));
}

function versionTable(page, {versions, detail}) {
  const current = detail.current_version;
  if (!versions.length) return h("p", {class: "muted"}, "None yet: train, or take in a file of one.");
  return h("ul", {class: "plain versions"},
    versions.map((version) => versionItem(page, version, current, detail.aliases.filter((alias) => alias.version === version.version))));
}

function versionItem(page, {version, created_at: at, counts, report}, current, aliases) {
  const answers = version === current;
  const point = async () => {
    await put(`${page.path}/aliases/current`, {version});
    toast(`Version ${version} answers now.`);
    await page.refresh();
  };
  return h("li", {},
    h("div", {class: "row"}, h("strong", {}, versionLink(page.name, version)),
      aliases.map((alias) => h("span", {class: "alias"}, state(alias.alias),
        alias.alias === "current" ? null : act("×", async () => {
          if (!await confirm(`Remove the alias ${alias.alias}?`,
            "Robots that ask for it are answered 404 until it points to a version again.", "Remove it")) return;
          await remove(`${page.path}/aliases/${encodeURIComponent(alias.alias)}`);
          await page.refresh();
        }, {kind: "quiet small", "aria-label": `Remove alias ${alias.alias}`})))),
    h("p", {class: "muted"}, time(at), ` · ${count(counts.exemplars, "exemplar")} of ${count(counts.labels, "label")}`),
    h("p", {}, headline(report)),
    h("div", {class: "row"},
      answers ? null : act(current && version < current ? `Roll back to version ${version}` : `Make version ${version} current`, point,
        {kind: "small"}),
      answers || !current ? null : h("a",
        {href: `#/versions/${encodeURIComponent(page.name)}/${current}/${version}`,
          "aria-label": `Compare with ${current}: version ${version}`}, `Compare with ${current}`),
      aliases.length ? null : act("Delete", async () => {
        if (!await confirm(`Delete version ${version}?`,
          "Its artifact goes with it; a training with the same exemplars and options makes it again.", "Delete it")) return;
        await remove(`${page.path}/versions/${version}`);
        await page.refresh();
      }, {kind: "quiet small", "aria-label": `Delete version ${version}`})));
}

// Not part of the list that is drawn again, so that typed text stays.
function aliasForm(page) {
  const place = h("div");
  const alias = h("input", {id: "alias-name", name: "alias", required: true, maxlength: "64", pattern: NAME, placeholder: "stable",
    autocomplete: "off", spellcheck: "false"});
  const version = h("select", {id: "alias-version", name: "version"});
  const form = h("form", {hidden: true, onSubmit: (event) => event.preventDefault()},
    h("h3", {}, "Point an alias"),
    h("p", {class: "muted"}, "A robot may ask for an alias; without one, ", h("code", {}, "current"), " answers."),
    h("div", {class: "fields"},
      h("div", {}, h("label", {for: "alias-name"}, "Alias"), alias), h("div", {}, h("label", {for: "alias-version"}, "Version"), version),
      h("div", {class: "bottom"}, act("Point", async () => {
        if (!form.reportValidity()) return;
        await put(`${page.path}/aliases/${encodeURIComponent(alias.value)}`, {version: Number(version.value)});
        toast(`${alias.value} points to version ${version.value}.`);
        await page.refresh();
      }, {place, kind: "quiet", type: "submit"}))), place);
  function draw(versions) {
    const chosen = version.value;
    form.hidden = !versions.length;
    replace(version, versions.map((each) => h("option", {value: each.version}, each.version)));
    if (versions.some((each) => `${each.version}` === chosen)) version.value = chosen;
  }
  return {node: form, draw};
}

// A version from a file: a backup, or another site's.
function takeIn(page) {
  const place = h("div", {role: "status"});
  const file = h("input", {type: "file", id: "artifact", accept: ".safetensors", async onChange() {
    if (!file.files.length) return;
    try {
      replace(place, h("p", {class: "muted"}, "It is being checked…"));
      const {version} = await post(`${page.path}/versions`, {body: file.files[0], type: "application/octet-stream"});
      replace(place, h("p", {}, `It is version ${version}; it doesn't answer before it is made current.`));
      await page.refresh();
    } catch (error) {
      replace(place, problem(error));
    }
    file.value = "";
  }});
  return h("details", {}, h("summary", {}, "Take in a version's file"),
    h("p", {}, h("label", {for: "artifact"}, "Artifact (.safetensors)"), file), place);
}
