// The map of a database: its exemplars where they were taken, and a tray of those without a pose, to be dragged onto it.

import {h, replace, drawOnChange} from "./dom.js";
import {act, number, problem, remotePicture} from "./parts.js";
import {NAME} from "./fields.js";
import {exemplarPictures} from "./frame_view.js";
import {mapView} from "./map_view.js";
import {poseNumbers} from "./map_pose.js";
import {patchSurvey, surveyForm} from "./survey_form.js";

const IN_TRAY = 24; // pictures at a time
const IN_TABLE = 100;
const FIRST_MAP = "map";

const named = ({label}) => label ?? "negative";
// What follows the pointer while a picture is dragged.
function ghostOf(image) {
  const canvas = h("canvas", {class: "map-ghost", width: 128, height: Math.round(128 * image.naturalHeight / image.naturalWidth) || 96});
  if (image.naturalWidth) canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height);
  return canvas;
}
const shortly = (exemplar) => `${named(exemplar)}, ${poseNumbers(exemplar.pose)}`;

// Marks of those exemplars that stand on that map.
export const marksOf = (list, map) => list.filter(({pose}) => pose?.map === map)
  .map((exemplar) => ({id: exemplar.id, label: named(exemplar), pose: exemplar.pose, size_mm: exemplar.size_mm, exemplar}));

// `draw(list, counted)` shows the database's exemplars, of which there are `counted`.
export function databaseMap(page) {
  let list = [];
  let total = 0;
  let map = null;
  let fitted = null;
  let inTray = IN_TRAY;
  let inTable = IN_TABLE;
  let selected = null; // the id of an exemplar: on the map, or of the tray
  const added = new Set();
  const changes = []; // {id, before}: the survey that undoing puts back
  let sent = Promise.resolve(); // changes are sent one by one
  const tabs = h("div", {class: "row", role: "group", "aria-label": "Maps"});
  const tray = h("div", {class: "tray", id: "map-tray"});
  const detail = h("div", {id: "map-detail", tabindex: "-1", role: "group", "aria-label": "The chosen exemplar"});
  const fault = h("div", {});
  const hint = h("div", {});
  const note = h("p", {class: "note", hidden: true});
  const undo = act("Undo", async () => {
    const last = changes.pop();
    try {
      await send(last.id, last.before);
    } catch (error) {
      if (error.status !== 404) changes.push(last); // else it was deleted meanwhile
      throw error;
    } finally {
      bar();
    }
  }, {kind: "quiet small", place: fault, id: "map-undo", hidden: true});
  const table = h("details", {id: "map-table"}, h("summary", {}, "The same as a table"));
  const rows = h("div", {class: "scroll"});
  table.append(rows);
  table.addEventListener("toggle", () => drawTable());
  const view = mapView({signal: page.signal, exemplar: exemplarPictures(encodeURIComponent(page.name), page.signal),
    onSelected: (id) => choose(id, false),
    onMoved: (mark, pose) => keep(mark.id, {pose}).catch(refused), onPlaced(x_m, y_m) {
      const exemplar = exemplarOf(selected);
      if (!exemplar || exemplar.pose) return false;
      place(exemplar, x_m, y_m);
      return true;
    }});
  const exemplarOf = (id) => list.find((exemplar) => exemplar.id === id);
  const mapsOf = () => [...new Set([...list.map(({pose}) => pose?.map).filter(Boolean), ...added])].sort();

  function send(id, change) {
    const next = sent.then(async () => {
      page.surveyed(await patchSurvey(page, id, change));
      replace(fault);
    });
    sent = next.catch(() => {});
    return next;
  }
  async function keep(id, change) {
    const {pose, camera, size_mm} = exemplarOf(id);
    await send(id, change);
    changes.push({id, before: {pose, camera, size_mm}});
    bar();
  }
  // Shows why the service refused what was dropped, and the exemplar where it was.
  function refused(error) {
    if (error.name === "AbortError") return;
    replace(fault, problem(error));
    draw(list, total);
  }
  const place = (exemplar, x_m, y_m) => keep(exemplar.id, {pose: {map, x_m: round(x_m), y_m: round(y_m), yaw_deg: 0}})
    .then(() => choose(exemplar.id), refused);
  const round = (metres) => Math.round(metres * 1000) / 1000;

  function bar() {
    undo.hidden = !changes.length;
    const last = changes.at(-1);
    const changed = last && exemplarOf(last.id);
    if (last) replace(undo, `Undo: ${last.before.pose ? "changing" : "placing"} ${changed ? named(changed) : ""}`);
    replace(hint, changes.length ? h("div", {class: "note row spread"},
      h("span", {}, "A version keeps the poses that it was trained with: these come into force with the next training."),
      h("button", {type: "button", class: "small", onClick: () => document.getElementById("train").click()}, "Train now")) : null);
  }

  function choose(id, onMap = true) {
    selected = id;
    if (onMap) view.select(id);
    for (const each of tray.querySelectorAll("button[data-id]")) each.setAttribute("aria-pressed", String(each.dataset.id === id));
    drawDetail();
  }
  function drawDetail() {
    const exemplar = exemplarOf(selected);
    if (!exemplar) return replace(detail, h("p", {class: "muted"}, "Choose an exemplar on the map, in the tray or in the table."));
    const [x_m, y_m] = view.middle().map((metres) => Math.round(metres * 100) / 100);
    replace(detail, h("h3", {}, exemplar.pose ? named(exemplar) : `Place ${named(exemplar)}`),
      h("div", {class: "row top"},
        remotePicture(`${page.path}/exemplars/${exemplar.id}/image`, named(exemplar), page.signal, {class: "cut"}),
        h("p", {class: "muted"}, exemplar.pose
          ? [poseNumbers(exemplar.pose), exemplar.size_mm ? `, ${number(exemplar.size_mm, 0)} mm wide` : "",
          exemplar.camera ? ", with its camera" : ""] : "Click on the map where it was taken, drag it there, or give the numbers:")),
      surveyForm({exemplar, signal: page.signal, words: exemplar.pose ? "Save" : "Place it",
        suggested: {map, x_m, y_m, yaw_deg: 0},
        async keep(change) {
          await keep(exemplar.id, change);
          if (change.pose && change.pose.map !== map) show(change.pose.map);
          choose(exemplar.id);
          detail.focus({preventScroll: true});
        }}));
  }

  const drawTabs = drawOnChange(tabs, ({maps, current}) => maps.map(([name, many]) => h("button", {type: "button", class: "quiet small",
    "aria-pressed": String(name === current), onClick: () => show(name)}, `${name} (${many})`)));
  const another = h("input", {"aria-label": "Name of another map", placeholder: "another map", pattern: NAME, required: true, size: 12,
    spellcheck: "false", autocomplete: "off"});
  const addMap = h("form", {class: "row", onSubmit(event) {
    event.preventDefault();
    added.add(another.value);
    show(another.value);
    another.value = "";
  }}, another, h("button", {type: "submit", class: "quiet small"}, "Add"));
  function show(name) {
    map = name;
    draw(list, total);
  }

  function drawTray() {
    const waiting = list.filter(({pose, negative}) => !pose && !negative);
    const shown = new Map([...tray.querySelectorAll("button[data-id]")].map((node) => [node.dataset.id, node]));
    replace(tray, h("h3", {}, "Not on a map ", h("span", {class: "muted"}, waiting.length)),
      waiting.length ? h("p", {class: "muted hint"}, "Drag one onto the map; or choose it, and click where it was taken.")
        : h("p", {class: "muted"}, "All exemplars have a pose."),
      h("div", {class: "thumbs"}, waiting.slice(0, inTray).map((exemplar) => shown.get(exemplar.id) ?? trayItem(exemplar))),
      waiting.length > inTray ? h("button", {type: "button", class: "quiet small", onClick() { inTray += IN_TRAY; drawTray(); }},
        `Show more (${waiting.length - inTray})`) : null);
  }
  function trayItem(exemplar) {
    const button = h("button", {type: "button", class: "quiet offer", "data-id": exemplar.id,
      "aria-pressed": String(exemplar.id === selected), "aria-label": `Place ${named(exemplar)}`},
    remotePicture(`${page.path}/exemplars/${exemplar.id}/image`, "", page.signal, {title: named(exemplar), draggable: "false"}),
    named(exemplar));
    let ghost = null;
    let from = null;
    const end = () => { ghost?.remove(); ghost = from = null; };
    button.addEventListener("pointerdown", (event) => {
      if (event.button) return;
      from = [event.clientX, event.clientY];
      button.setPointerCapture(event.pointerId);
    });
    button.addEventListener("pointermove", (event) => {
      if (!from || (!ghost && Math.hypot(event.clientX - from[0], event.clientY - from[1]) < 6)) return;
      if (!ghost) document.body.append(ghost = ghostOf(button.querySelector("img")));
      Object.assign(ghost.style, {left: `${event.clientX}px`, top: `${event.clientY}px`});
    });
    button.addEventListener("pointerup", (event) => {
      const dropped = ghost && view.under(event);
      const wasDragged = Boolean(ghost);
      end();
      if (dropped) place(exemplar, ...dropped);
      if (wasDragged) button.addEventListener("click", (click) => click.stopImmediatePropagation(), {once: true, capture: true});
    });
    button.addEventListener("pointercancel", end);
    button.addEventListener("click", () => choose(exemplar.id));
    return button;
  }

  function drawTable() {
    if (!table.open) return;
    const placed = list.filter(({pose}) => pose?.map === map);
    replace(rows, placed.length ? h("table", {},
      h("thead", {}, h("tr", {}, h("th", {scope: "col"}, "Exemplar"), ["x, m", "y, m", "z, m", "Heading, °", "± m", "Width, mm"]
        .map((words) => h("th", {scope: "col", class: "n"}, words)))),
      h("tbody", {}, placed.slice(0, inTable).map((exemplar) => h("tr", {},
        h("td", {}, h("button", {type: "button", class: "quiet small", "aria-label": `Choose ${shortly(exemplar)}`,
          onClick: () => choose(exemplar.id)}, named(exemplar))),
        ["x_m", "y_m", "z_m", "yaw_deg", "sigma_m"].map((name) => h("td", {class: "n"}, number(exemplar.pose[name]))),
        h("td", {class: "n"}, number(exemplar.size_mm, 0)))))) : h("p", {class: "muted"}, "Nothing stands on this map yet."),
      placed.length > inTable ? h("button", {type: "button", class: "quiet small", onClick() { inTable += IN_TABLE; drawTable(); }},
        `Show more (${placed.length - inTable})`) : null);
  }

  function draw(given, counted) {
    total = counted;
    note.hidden = given.length >= counted;
    replace(note, `The first ${given.length.toLocaleString("en")} exemplars of ${counted.toLocaleString("en")} are here.`);
    // It opens by itself where there is something on it.
    if (!list.some(({pose}) => pose) && given.some(({pose}) => pose)) node.open = true;
    list = given;
    map ??= mapsOf()[0] ?? FIRST_MAP;
    if (!mapsOf().includes(map)) added.add(map);
    const marks = marksOf(list, map);
    // A drag changes a mark, and not the exemplar, before the service has kept it.
    view.show({marks});
    // Later what was dropped stays where it was dropped.
    if (fitted !== map) { fitted = map; view.fit(); }
    drawTabs({current: map, maps: mapsOf().map((name) => [name, list.filter(({pose}) => pose?.map === name).length])});
    drawTray();
    drawTable();
    if (selected === null || !detail.hasChildNodes()) drawDetail();
  }
  const body = h("div", {}, h("p", {class: "muted"}, "Exemplars where they were taken, looking along their wedges; flat landmarks as ",
    "a line with its normal. Drag one to move it, and the ring before it to turn it. ",
    h("a", {href: `#/tracks/${encodeURIComponent(page.name)}`}, "Tracks on it")),
  note, h("div", {class: "row"}, tabs, addMap),
  h("div", {class: "map-split"}, h("div", {}, view.node, h("div", {class: "row"}, undo), fault, hint), h("div", {}, tray, detail)), table);
  const node = h("details", {class: "card", id: "map"}, h("summary", {}, h("h2", {}, "Map")), body);
  return {node, draw, refuse: (error) => replace(body, h("p", {class: "muted"}, error.message))};
}
