// The form of an exemplar's survey: where it was taken, with which camera, and how large what it shows is.

import {h} from "./dom.js";
import {call} from "./api.js";
import {act} from "./parts.js";
import {choiceField, markFaults, NAME, numberField, numberIn, textField} from "./fields.js";
import {cameraFields, cameraIn, cameraNames} from "./cameras.js";

const LENGTHS = [["x_m", "x, m"], ["y_m", "y, m"], ["yaw_deg", "Heading, °"]];
const MORE = [["z_m", "Height, m", 0], ["pitch_deg", "Pitch, ° down", 0], ["roll_deg", "Roll, ° left side up", 0],
  ["sigma_m", "± m (1 σ)", 0.05]];

// Changes an exemplar's survey; gives the exemplar as it is then.
export const patchSurvey = async (page, id, change) => (await call("PATCH", `${page.path}/exemplars/${id}`, {json: change})).json();

// `exemplar` as the service has it; `suggested` are members of a pose that it may get. `keep(change)` sends it.
export function surveyForm({exemplar, suggested = {}, signal, keep, words = "Save"}) {
  const pose = exemplar.pose ?? suggested;
  const fault = h("div", {});
  const choice = choiceField("Camera", "camera", [["", "not known"], ...exemplar.camera ? [["=", "as it is kept with it"]] : [],
    ["+", "these intrinsics"]], exemplar.camera ? "=" : "");
  const select = choice.querySelector("select");
  const intrinsics = h("div", {hidden: true},
    cameraFields(exemplar.camera ?? {width_px: exemplar.width_px, height_px: exemplar.height_px}));
  select.addEventListener("change", () => { intrinsics.hidden = select.value !== "+"; });
  cameraNames(signal).then((names) => select.append(...names.map((name) => h("option", {value: `=${name}`}, name)))).catch(() => {});
  const form = h("form", {class: "survey-form", onSubmit: (event) => event.preventDefault()},
    h("div", {class: "fields"}, textField("Map", "map", pose.map, {pattern: NAME}),
      LENGTHS.map(([name, label]) => numberField(label, name, pose[name]))),
    h("details", {}, h("summary", {}, "Height, camera, size"), h("div", {class: "fields"},
      MORE.map(([name, label, usual]) => numberField(label, name, exemplar.pose?.[name], {placeholder: usual})),
      numberField("Width of a flat picture, mm", "size_mm", exemplar.size_mm,
        {min: 0, hint: "Of a poster or a plate: then the pose is the picture's own, x along its normal."}), choice), intrinsics),
    h("div", {class: "row"}, act(words, save, {place: fault, type: "submit", kind: "small"}),
      exemplar.pose ? act("Take off the map", () => keep({pose: null}), {place: fault, kind: "quiet small"}) : null), fault);
  async function save() {
    if (!form.reportValidity()) return;
    const given = [...LENGTHS, ...MORE].map(([name]) => [name, numberIn(form, name)]).filter(([, value]) => value !== undefined);
    const map = form.elements.map.value;
    const camera = select.value;
    try {
      await keep({pose: given.length ? {map, ...Object.fromEntries(given)} : null, size_mm: numberIn(form, "size_mm") ?? null,
        ...camera === "=" ? {} : {camera: camera === "+" ? cameraIn(form) : camera.slice(1) || null}});
      markFaults(form, null);
    } catch (error) {
      markFaults(form, error);
      const wrong = form.querySelector("[aria-invalid]");
      if (wrong?.closest("details")) wrong.closest("details").open = true;
      throw error;
    }
  }
  return form;
}

// The form in a dialog, for one exemplar.
export function surveyDialog(page, exemplar, title) {
  const dialog = h("dialog", {class: "wide", "aria-labelledby": "survey-title"}, h("h2", {id: "survey-title"}, title),
    surveyForm({exemplar, signal: page.signal, async keep(change) {
      page.surveyed(await patchSurvey(page, exemplar.id, change));
      dialog.close();
    }}),
    h("div", {class: "row end"}, h("button", {type: "button", class: "quiet", onClick: () => dialog.close()}, "Close")));
  dialog.addEventListener("close", () => dialog.remove());
  document.body.append(dialog);
  dialog.showModal();
}
