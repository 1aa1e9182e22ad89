// Cameras: the fields of their intrinsics, and the choice of a kept one.

import {h, replace} from "./dom.js";
import {all, put} from "./api.js";
import {act, toast} from "./parts.js";
import {markFaults, NAME, numberField, numberIn, textField} from "./fields.js";

const MUST = [["fx", "fx, px"], ["fy", "fy, px"], ["cx", "cx, px"], ["cy", "cy, px"],
  ["width_px", "Width, px"], ["height_px", "Height, px"]];
const MAY = ["k1", "k2", "p1", "p2", "k3"];

// Fields of intrinsics, by the names of the wire.
export const cameraFields = (camera = {}) => h("div", {class: "fields"},
  MUST.map(([name, label]) => numberField(label, name, camera[name])),
  MAY.map((name) => numberField(`${name}, distortion`, name, camera[name], {placeholder: "0"})));

// Intrinsics as they are in a form with these fields.
export const cameraIn = (form) => Object.fromEntries([...MUST.map(([name]) => name), ...MAY]
  .map((name) => [name, numberIn(form, name)]).filter(([, value]) => value !== undefined));

// The names of the cameras that are kept.
export const cameraNames = async (signal) => (await all("v1/cameras", {signal})).map(({name}) => name);

// What took the frame: none, a kept camera, or a new one that is kept first. `onChosen` is called when another is chosen.
export function cameraChoice({chosen = "", onChosen, signal}) {
  const select = h("select", {id: "camera", onChange() {
    details.hidden = select.value !== "+";
    if (!details.hidden) form.elements.name.focus();
    else onChosen(select.value);
  }});
  const fault = h("div", {});
  const form = h("form", {onSubmit: (event) => event.preventDefault()},
    textField("Name of the camera", "name", "", {pattern: NAME, required: true}),
    cameraFields(), h("div", {class: "row"}, act("Keep this camera", async () => {
      if (!form.reportValidity()) return;
      const name = form.elements.name.value;
      try {
        await put(`v1/cameras/${encodeURIComponent(name)}`, cameraIn(form));
        markFaults(form, null);
      } catch (error) {
        markFaults(form, error);
        throw error;
      }
      toast(`The camera ${name} is kept.`);
      await draw(name);
      details.hidden = true;
      onChosen(name);
    }, {place: fault, type: "submit", kind: "quiet", id: "keep-camera"})), fault);
  const details = h("div", {class: "card", hidden: true, id: "new-camera"},
    h("p", {class: "muted"}, "Intrinsics as OpenCV and ROS write them, of pictures of that size."), form);
  async function draw(value) {
    const names = await cameraNames(signal);
    if (signal.aborted) return;
    replace(select, h("option", {value: ""}, "not known"), names.map((name) => h("option", {value: name}, name)),
      h("option", {value: "+"}, "another: give its intrinsics…"));
    select.value = names.includes(value) ? value : "";
  }
  return {field: h("div", {}, h("label", {for: "camera"}, "Camera"), select), details,
    value: () => select.value === "+" ? "" : select.value, ready: draw(chosen)};
}
