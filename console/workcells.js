// #/workcells and #/workcells/{name}: tables with a camera above and a robot beside; what lies on one, and where to reach.

import {h, replace} from "./dom.js";
import {all, get, post, remove} from "./api.js";
import {act, confirm, number, pictures, problem, time, toast} from "./parts.js";
import {choiceField, numberField, numberIn, textField} from "./fields.js";
import {inspectionView} from "./inspection.js";
import {loaded} from "./frame_view.js";
import {workcellForm} from "./workcell_form.js";

// Pictures by workcell and role, kept while other pages are shown.
const kept = new Map();
const filesOf = (name) => kept.get(name) ?? kept.set(name, {}).get(name);

const address = (name) => `v1/workcells/${encodeURIComponent(name)}`;

const choices = async (signal) => {
  const [databases, calibrations] = await Promise.all([all("v1/databases", {signal}), all("v1/calibrations", {signal})]);
  return {databases: databases.filter(({kind}) => kind === "objects").map(({name}) => name),
    calibrations: calibrations.map(({name}) => name)};
};

async function list(main, signal) {
  const [workcells, {databases, calibrations}] = await Promise.all([all("v1/workcells", {signal}), choices(signal)]);
  if (signal.aborted) return;
  const files = filesOf("");
  const form = databases.length ? workcellForm({kept: null, databases, calibrations, picture: () => files.overview, signal, onKept({name}) {
    kept.set(name, {...files});
    if (!signal.aborted) location.hash = `#/workcells/${encodeURIComponent(name)}`;
  }}) : null;
  const showPicture = async (file) => { files.overview = file; form.show(await loaded(file, "The overview", signal)); };
  if (form && files.overview) showPicture(files.overview).catch(() => {});
  replace(main,
    h("h1", {}, "Workcells"),
    h("p", {}, "A workcell is a table with an overview camera, and a robot that reaches onto it: "
      + "the service says what lies there, how it is turned, and where in the robot's millimetres."),
    workcells.length ? h("section", {class: "card scroll"}, h("table", {id: "workcells"},
      h("thead", {}, h("tr", {}, ["Name", "Database", "Calibration", "Mapping"].map((words) => h("th", {}, words)),
        h("th", {class: "n"}, "Points"), h("th", {class: "n"}, "Residual, mm"), h("th", {}, "Changed"))),
      h("tbody", {}, workcells.map((cell) => h("tr", {},
        h("td", {}, h("a", {href: `#/workcells/${encodeURIComponent(cell.name)}`}, cell.name)),
        h("td", {}, cell.database), h("td", {}, cell.calibration ?? "–"), h("td", {}, cell.mapping.kind),
        h("td", {class: "n"}, cell.correspondences.length), h("td", {class: "n"}, number(cell.mapping.residual_mm)),
        h("td", {}, time(cell.updated_at)))))))
      : h("p", {class: "note"}, "There is no workcell yet. Make one below."),
    form
      ? h("details", {class: "card", open: workcells.length === 0, id: "new-workcell"}, h("summary", {}, "New workcell"),
        pictures({label: "Drop a picture of the overview camera, to click points on",
          onPictures: ([{file}]) => showPicture(file).catch((error) => toast(error.message))}), form.node)
      : h("p", {class: "note"}, "A workcell names its parts by a database of kind objects, and there is none: make one on the ",
        h("a", {href: "#/"}, "overview"), "."));
}

// The inspection of an overview; calls `onOverview` with the picture as a loaded <img>.
function inspecting(workcell, files, onOverview, signal) {
  const result = h("div", {});
  const fault = h("div", {});
  const names = h("p", {class: "muted"});
  const form = h("form", {onSubmit: (event) => event.preventDefault()}, h("div", {class: "fields"},
    textField("Alias", "alias", "", {hint: "Empty: current."}),
    numberField("or version", "version", undefined, {min: 1, step: 1}),
    choiceField("The pair shows", "pair_view", [["local", "one part, from near"], ["overview", "the whole table, as the overview"]],
      "local"),
    numberField("that of region", "region", undefined, {min: 1, step: 1, hint: "Empty: the one nearest the middle."})));
  const showNames = () => replace(names,
    ["overview", "near", "far"].filter((role) => files[role]).map((role) => `${role}: ${files[role].name}`).join(" · "));

  let earlier = new AbortController();
  async function run() {
    earlier.abort();
    earlier = new AbortController();
    const now = AbortSignal.any([signal, earlier.signal]);
    const body = new FormData();
    const asked = [];
    const file = files.overview;
    const {near, far} = files;
    body.append("overview", file, file.name);
    for (const [role, given] of [["near", near], ["far", far]]) if (given) body.append(role, given, given.name);
    for (const name of ["alias", "version"]) asked.push([name, form.elements[name].value.trim()]);
    if (near || far) {
      asked.push(["pair_view", form.elements.pair_view.value]);
      if (numberIn(form, "region") !== undefined) asked.push(["region", numberIn(form, "region")]);
    }
    replace(result);
    const query = new URLSearchParams(asked.filter(([, value]) => value !== ""));
    const [answer, image] = await Promise.all([post(`${address(workcell.name)}/inspections?${query}`, {body, signal: now}),
      loaded(file, "The overview camera's picture", now)]).catch((error) => { if (!now.aborted) throw error; return []; });
    if (now.aborted) return;
    replace(result, inspectionView(answer, image, workcell.mapping));
  }
  const again = act("Inspect", run, {place: fault, id: "inspect"});
  function given(role, file) {
    files[role] = file;
    showNames();
    again.disabled = !files.overview;
    if (role !== "overview") return;
    loaded(file, "The overview", signal).then(onOverview).catch(() => {});
    again.click();
  }
  const drop = (role, label) => pictures({label, onPictures: ([{file}]) => given(role, file)});
  const pair = workcell.calibration
    ? h("div", {class: "split even"}, drop("near", "Near-focused picture"), drop("far", "Far-focused picture"))
    : h("p", {class: "note"}, "Distances need a calibration: name one in the set-up below.");
  const node = h("section", {class: "card", id: "inspect-card"}, h("h2", {}, "Inspect the table"),
    drop("overview", "Drop the overview camera's picture"),
    names,
    h("details", {}, h("summary", {}, "Which version answers, and a focal pair for distances"), form, pair,
      h("p", {}, act("Without the pair", async () => { delete files.near; delete files.far; showNames(); }, {kind: "quiet small"}))),
    h("p", {}, again), fault, result);
  showNames();
  again.disabled = !files.overview;
  if (files.overview) queueMicrotask(() => given("overview", files.overview));
  return node;
}

// What a warning of a workcell says, and about which points.
function doubt(word, suspects) {
  const points = suspects.map((at) => at + 1).join(" and ");
  return {
    mirrored: "With the other direction of Y the points would fit far better, or two of them are exchanged.",
    exchanged: `With the robot's coordinates of points ${points} exchanged the mapping would fit far better.`,
    outlying: `Without point ${points} the mapping would fit far better: look for what is mistyped.`,
  }[word] ?? "";
}

const foretold = ({leave_one_out_mm: left}) => Object.entries(left ?? {}).filter(([, mm]) => mm !== null)
  .map(([kind, mm]) => `${kind} ${number(mm)} mm`).join(", ");

async function one(main, name, signal, isSetUp = false) {
  const [workcell, {databases, calibrations}] = await Promise.all([get(address(name), {signal}), choices(signal)]);
  if (signal.aborted) return;
  const files = filesOf(name);
  const {mapping} = workcell;
  const form = workcellForm({kept: workcell, databases, calibrations, picture: () => files.overview, signal, onKept(now) {
    toast(`Kept: ${now.mapping.kind} mapping, residual ${number(now.mapping.residual_mm)} mm.`);
    if (!signal.aborted) one(main, name, signal, true).catch((error) => { if (!signal.aborted) replace(main, problem(error)); });
  }});
  const fact = (term, ...value) => h("div", {}, h("dt", {}, term), h("dd", {}, value));
  const gone = act("Delete", async () => {
    if (!await confirm(`Delete the workcell ${name}?`, "Its mapping and settings are gone then; its database and calibration stay.",
      "Delete it")) return;
    await remove(address(name));
    kept.delete(name);
    if (!signal.aborted) location.hash = "#/workcells";
  }, {kind: "danger", id: "delete-workcell"});
  replace(main,
    h("div", {class: "row spread"}, h("h1", {}, `Workcell ${name}`), gone),
    h("dl", {class: "facts"},
      fact("Database", h("a", {href: `#/databases/${encodeURIComponent(workcell.database)}`}, workcell.database)),
      fact("Calibration", workcell.calibration ?? "none"),
      fact("Mapping", `${mapping.kind}, ${workcell.correspondences.length} points`), fact("Residual", `${number(mapping.residual_mm)} mm`),
      foretold(mapping) ? fact("Points left out are off by", foretold(mapping)) : null,
      fact("Changed", time(workcell.updated_at))),
    workcell.warnings.map((word) => h("p", {class: "note"}, h("code", {}, word), " ", doubt(word, mapping.suspects ?? []))),
    inspecting(workcell, files, form.show, signal),
    h("details", {class: "card", id: "set-up", open: isSetUp}, h("summary", {}, "Set-up: mapping, points, segmentation"), form.node,
      h("details", {}, h("summary", {}, "The mapping's matrix"),
        h("pre", {tabindex: "0", "aria-label": "Matrix"},
          mapping.matrix.map((row) => row.map((value) => value.toPrecision(8).padStart(14)).join(" ")).join("\n")),
        h("p", {class: "muted"}, "(X·w, Y·w, w) = matrix · (x, y, 1)."))));
  if (isSetUp) document.getElementById("set-up").scrollIntoView();
}

export const show = (main, [name], signal) => name ? one(main, name, signal) : list(main, signal);
