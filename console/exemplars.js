// The exemplars of a database by label, with their pictures; one can be deleted, or a label.

import {h, replace} from "./dom.js";
import {remove} from "./api.js";
import {act, confirm, count, number, remotePicture} from "./parts.js";

const SHOWN_PER_LABEL = window.matchMedia("(max-width: 48rem)").matches ? 3 : 10;

// The title of the exemplars without a label; no label has a space.
const NEGATIVE = "Negative: nothing known";

// The exemplars by label. Elements that are there stay when the list is drawn again, so that pictures are fetched once.
export function exemplarList(page) {
  const groups = new Map();
  const note = h("p", {class: "muted"});
  const node = h("div", {}, note);
  function draw(list, counted) {
    const byLabel = grouped(list, (exemplar) => exemplar.label ?? NEGATIVE);
    const labels = [...byLabel.keys()].sort((a, b) => a.localeCompare(b, "en", {numeric: true}));
    replace(note, list.length < counted ? `The first ${count(list.length, "exemplar")} of ${counted.toLocaleString("en")} are shown.`
      : !list.length && "None yet.");
    for (const [label, group] of groups) {
      if (byLabel.has(label)) continue;
      group.node.remove();
      groups.delete(label);
    }
    labels.forEach((label, index) => {
      if (!groups.has(label)) groups.set(label, labelGroup(page, label));
      const group = groups.get(label);
      const place = node.children[index + 1];
      if (place !== group.node) node.insertBefore(group.node, place ?? null);
      group.draw(byLabel.get(label).sort((a, b) => (a.pose_deg ?? -1) - (b.pose_deg ?? -1) || a.created_at.localeCompare(b.created_at)));
    });
  }
  return {node, draw, refuse: (error) => replace(note, error.message)};
}

function grouped(list, keyOf) {
  const groups = new Map();
  for (const item of list) groups.has(keyOf(item)) ? groups.get(keyOf(item)).push(item) : groups.set(keyOf(item), [item]);
  return groups;
}

function labelGroup(page, label) {
  const figures = new Map();
  const thumbs = h("div", {class: "thumbs"});
  const title = h("h3", {});
  const more = act("Show more", () => { most += 4 * SHOWN_PER_LABEL; draw(list); },
    {kind: "quiet small", "aria-label": `Show more of ${label}`});
  let most = SHOWN_PER_LABEL;
  let list = [];
  function draw(given) {
    list = given;
    replace(title, label, h("span", {class: "muted"}, ` ${list.length}`));
    const shown = list.slice(0, most);
    for (const [id, {node: figure}] of figures) {
      if (shown.some((exemplar) => exemplar.id === id)) continue;
      figure.remove();
      figures.delete(id);
    }
    shown.forEach((exemplar, index) => {
      if (!figures.has(exemplar.id)) figures.set(exemplar.id, exemplarFigure(page, exemplar));
      const {node: figure, survey} = figures.get(exemplar.id);
      survey(exemplar);
      if (thumbs.children[index] !== figure) thumbs.insertBefore(figure, thumbs.children[index] ?? null);
    });
    more.hidden = list.length <= most;
    replace(more, `Show more (${list.length - shown.length})`);
  }
  const node = h("section", {class: "label-group", "aria-label": `Exemplars of ${label}`},
    h("div", {class: "row spread"}, title, act("Delete label", async () => {
      if (!await confirm(`Delete all ${list.length} exemplars of ${label}?`,
        "Versions that were trained with them stay as they are; the next training does without.", "Delete them")) return;
      await remove(`${page.path}/exemplars?${label === NEGATIVE ? "negative=true" : `label=${encodeURIComponent(label)}`}`);
      await page.refresh();
    }, {kind: "quiet small", "aria-label": `Delete label ${label}`})), thumbs, more);
  return {node, draw};
}

function exemplarFigure(page, exemplar) {
  const {id, label, negative, pose_deg: pose, width_px: width, height_px: height, created_at: at, media_type: type, header} = exemplar;
  const name = `${label}${pose === null ? "" : ` at ${pose}°`}`;
  const sender = header.robot_id ? `, from ${header.robot_id}` : "";
  const details = `${name}, ${width} × ${height} px ${type}, ${new Date(at).toLocaleString()}${sender}`;
  const place = h("figcaption", {});
  let now = exemplar;
  const edit = page.kind === "landmarks" && !negative ? act("Pose", async () => {
    const {surveyDialog} = await import("./survey_form.js");
    surveyDialog(page, now, `Where ${name} was taken`);
  }, {kind: "quiet small", "aria-label": `Pose, camera and size of this exemplar of ${name}`}) : null;
  const node = h("figure", {class: "exemplar"},
    remotePicture(`${page.path}/exemplars/${id}/image`, name, page.signal, {title: details}),
    pose === null ? null : h("figcaption", {}, `${pose}°`), place, edit,
    act("×", async () => {
      if (!await confirm("Delete this exemplar?", `${details}. Versions that were trained with it stay as they are.`, "Delete it")) return;
      await remove(`${page.path}/exemplars/${id}`);
      await page.refresh();
    }, {kind: "danger small remove", "aria-label": `Delete this exemplar of ${name}`}));
  // Its map pose, camera and size, which can change.
  function survey(given) {
    now = given;
    const {pose: there, camera, size_mm: size} = now;
    replace(place, [there && `${there.map}: ${number(there.x_m)}, ${number(there.y_m)} m, ${number(there.yaw_deg, 0)}°`,
      size && `${number(size, 0)} mm wide`, camera && "with camera"].filter(Boolean).map((words) => h("div", {}, words)));
  }
  return {node, survey};
}
