// #/: the health of the service, its databases, jobs and processes.

import {h, replace, drawOnChange} from "./dom.js";
import {all, call, get} from "./api.js";
import {act, poll, liveJobs, outcome, problem, state, time} from "./parts.js";
import {NAME} from "./fields.js";

const ENDED_JOBS = 8;
const KINDS = {
  landmarks: "landmarks: places, and objects on any background",
  objects: "objects: which object, and how it is turned",
};

const databaseLink = (name) => h("a", {href: `#/databases/${encodeURIComponent(name)}`}, name);
export const versionLink = (name, version, text = `version ${version}`) =>
  h("a", {href: `#/versions/${encodeURIComponent(name)}/${version}`}, text);

// The readiness of the service; needs no key, answers 503 while it starts.
async function readiness(signal) {
  const answer = await fetch("readyz", {signal, cache: "no-store"}).catch((error) => { if (error.name === "AbortError") throw error; });
  const body = await answer?.json().catch(() => null);
  return body?.status ? body : {status: "away", databases: [], catalogue: "unknown", blobs: "unknown"};
}

export async function show(main, parts, signal) {
  const fault = h("div");
  const health = h("section", {class: "card", id: "health", "aria-label": "Health"});
  const databases = h("div", {id: "databases"});
  const live = h("div", {id: "live-jobs"});
  const ended = h("div", {id: "ended-jobs"});
  const processes = h("div", {id: "processes"});
  const drawHealth = drawOnChange(health, healthOf);
  const drawDatabases = drawOnChange(databases, databaseTable);
  const drawEnded = drawOnChange(ended, endedJobs);
  const drawProcesses = drawOnChange(processes, processTable);

  let details = [];
  const older = new Map(); // the last training of a database that isn't among the jobs asked for
  let known = "";
  let round = 0;
  async function refresh() {
    const [info, ready, jobs, list] = await Promise.all([
      get("v1/info", {signal}), readiness(signal), get("v1/jobs?limit=100", {signal}), all("v1/databases", {signal})]);
    // Details of databases are fetched when something changed, and in every sixth round.
    const now = JSON.stringify([ready, list.map((database) => database.name), jobs.items.map((job) => [job.id, job.state])]);
    if (now !== known || round % 6 === 0) {
      details = (await Promise.all(list.map(({name}) => get(`v1/databases/${encodeURIComponent(name)}`, {signal}).catch(unlessGone))))
        .filter(Boolean);
      const recent = lastTrainings(jobs.items);
      const without = details.map(({name}) => name).filter((name) => !recent[name] && !older.has(name));
      await Promise.all(without.map(async (name) => older.set(name,
        lastTrainings((await get(`v1/jobs?database=${encodeURIComponent(name)}&limit=1`, {signal})).items)[name])));
      known = now;
    }
    round += 1;
    if (signal.aborted) return;
    drawHealth({info, ready});
    drawDatabases({details, ready, trainings: {...Object.fromEntries(older), ...lastTrainings(jobs.items)}});
    drawLive(jobs.items);
    drawEnded({jobs: jobs.items.filter((job) => job.finished_at).slice(0, ENDED_JOBS), busy: jobs.items.some((job) => !job.finished_at)});
    drawProcesses(info.processes);
  }
  const drawLive = liveJobs(live, signal, () => refresh().catch(() => {}));

  replace(main, h("h1", {}, "Overview"), fault, health,
    h("section", {class: "card"}, h("h2", {}, "Databases"), databases, newDatabase(signal)),
    h("div", {class: "split"},
      h("section", {class: "card"}, h("h2", {}, "Jobs"), live, ended),
      h("section", {class: "card"}, h("h2", {}, "Processes"), processes)));
  await refresh();
  poll(refresh, signal, (error) => replace(fault, error && problem(error)));
}

// A database that was deleted meanwhile is no error.
function unlessGone(error) {
  if (error.status === 404) return null;
  throw error;
}

// By database, the newest training; jobs come newest first.
function lastTrainings(jobs) {
  const found = {};
  for (const job of jobs) if (job.kind === "training") found[job.database] ??= {state: job.state, at: job.finished_at ?? job.created_at};
  return found;
}

const STATUS_TEXTS = {
  ready: "All is well.",
  degraded: "The service answers, but something below needs you.",
  starting: "The service is starting or shutting down; it answers when it is ready.",
  away: "The service doesn't answer.",
};

function healthOf({info, ready}) {
  const broken = ready.databases.filter((database) => database.reason);
  return [
    h("p", {class: "row"}, state(ready.status), h("strong", {}, STATUS_TEXTS[ready.status] ?? ready.status),
      ready.databases.length ? null : h("span", {}, "It holds no version yet.")),
    broken.length > 0 && h("ul", {}, broken.map(({database, reason}) => h("li", {}, databaseLink(database), `: ${reason}`))),
    h("p", {class: "muted"}, `${info.name} ${info.version}, algorithm revision ${info.revision}, ${info.limits.threads} threads, since `,
      time(info.started_at), " · catalogue ", state(ready.catalogue), " · blobs ", state(ready.blobs)),
    h("details", {}, h("summary", {}, "What it takes"),
      h("p", {}, `Pictures: ${info.formats.join(", ")}.`),
      h("div", {class: "scroll"}, h("table", {}, h("caption", {class: "visually-hidden"}, "Limits"),
        Object.entries(info.limits)
          .map(([name, value]) => h("tr", {}, h("th", {scope: "row"}, h("code", {}, name)),
            h("td", {class: "n"}, value.toLocaleString("en")))))))];
}

function databaseTable({details, ready, trainings}) {
  if (!details.length) {
    return h("div", {class: "note", id: "first-steps"}, h("strong", {}, "Nothing is known yet. Four steps to the first answer:"),
      h("ol", {}, h("li", {}, "Create a database below: ", h("em", {}, "landmarks"), " to tell places, ", h("em", {}, "objects"),
        " to tell things and their pose."),
        h("li", {}, "On its page, drop a folder of pictures for each label: these are its exemplars."),
        h("li", {}, "Train: a job makes a version of them."),
        h("li", {}, "Show it a picture under ", h("a", {href: "#/try"}, "Try it"), ".")),
      h("p", {}, "Or run ", h("code", {}, "landmarkd demo"), " to see all of it with pictures it draws itself."));
  }
  const served = new Map(ready.databases.map((database) => [database.database, database]));
  return h("div", {class: "scroll", tabindex: "0", role: "region", "aria-label": "Databases"}, h("table", {},
    h("thead", {}, h("tr", {}, ["Name", "Health", "Answers with", "Kind"].map((text) => h("th", {scope: "col"}, text)),
      h("th", {scope: "col", class: "n"}, "Exemplars"), h("th", {scope: "col", class: "n"}, "Labels"),
      ["Last training", ""].map((text) => h("th", {scope: "col"}, text || h("span", {class: "visually-hidden"}, "Actions"))))),
    h("tbody", {}, details.map(({name, kind, current_version: current, exemplars, labels}) => {
      const training = trainings[name];
      return h("tr", {}, h("th", {scope: "row"}, databaseLink(name)),
        h("td", {}, healthOfDatabase(current, served.get(name))),
        h("td", {class: "whole"}, current ? versionLink(name, current) : h("span", {class: "muted"}, "no version yet")),
        h("td", {}, kind),
        h("td", {class: "n"}, exemplars), h("td", {class: "n"}, labels),
        h("td", {class: "whole"}, training ? [state(training.state), " ", time(training.at)] : h("span", {class: "muted"}, "–")),
        h("td", {class: "whole"}, current ? h("a", {href: `#/try/${encodeURIComponent(name)}`, "aria-label": `Try it: ${name}`},
          "Try it") : null));
    }))));
}

function healthOfDatabase(current, served) {
  if (served) return [state(served.state), served.reason ? ` ${served.reason}` : ""];
  return h("span", {class: "muted"}, current ? "not held by this process" : "to be trained");
}

function newDatabase(signal) {
  const place = h("div");
  const name = h("input", {id: "new-name", required: true, maxlength: "64", pattern: NAME, autocomplete: "off", spellcheck: "false",
    "aria-describedby": "new-name-hint"});
  const kind = h("select", {id: "new-kind"}, Object.entries(KINDS).map(([value, text]) => h("option", {value}, text)));
  const form = h("form", {id: "new-database", onSubmit: (event) => event.preventDefault()},
    h("h3", {}, "Create a database"),
    h("div", {class: "row bottoms"},
      h("div", {}, h("label", {for: "new-name"}, "Name"), name),
      h("div", {}, h("label", {for: "new-kind"}, "Kind"), kind),
      act("Create", async () => {
        if (!form.reportValidity()) return;
        const path = encodeURIComponent(name.value);
        await call("PUT", `v1/databases/${path}`, {json: {kind: kind.value}});
        if (!signal.aborted) location.hash = `#/databases/${path}`;
      }, {place, type: "submit"})),
    h("p", {class: "muted", id: "new-name-hint"},
      "Letters, digits, “_”, “.” and “-”; a letter or digit first. The kind can't be changed later."), place);
  return form;
}

function endedJobs({jobs, busy}) {
  if (!jobs.length) return busy ? null : h("p", {class: "muted"}, "No job yet: trainings and sweeps are shown here while they run.");
  return h("div", {class: "scroll", tabindex: "0", role: "region", "aria-label": "Jobs that ended"}, h("table", {},
    h("thead", {}, h("tr", {}, ["Ended", "Job", "State", "Outcome"].map((text) => h("th", {scope: "col"}, text)))),
    h("tbody", {}, jobs.map((job) => h("tr", {}, h("td", {}, time(job.finished_at)),
      h("td", {}, job.kind, " of ", job.database ? databaseLink(job.database) : job.calibration),
      h("td", {}, state(job.state)), h("td", {}, outcome(job)))))));
}

function processTable(processes) {
  return processes.map(({worker, role, started_at: since, databases}, index) => h("div", {class: "process"},
    h("p", {}, h("strong", {}, role === "all" ? "serves and trains" : role === "serve" ? "serves" : "trains"),
      index === 0 ? " (this one)" : "", ", since ", time(since)),
    h("p", {class: "muted"}, h("code", {}, worker)),
    databases.length
      ? h("ul", {class: "plain"},
        databases.map(({database, version, state: word, reason}) => h("li", {}, databaseLink(database),
          version ? ` version ${version} ` : " ", state(word), reason ? ` ${reason}` : "")))
      : h("p", {class: "muted"}, "It holds no database.")));
}
