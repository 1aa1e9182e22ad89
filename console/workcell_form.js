// The form of a workcell: its database and calibration, and the correspondences between the overview's pixels and the
// robot's coordinates, from which the mapping is estimated.

import {h, replace, svg} from "./dom.js";
import {all, call, put} from "./api.js";
import {act, confirm, number, toast} from "./parts.js";
import {checkField, choiceField, markFaults, NAME, numberField, numberIn, textField} from "./fields.js";

const NEAR_PX = 14; // of the screen: a point that near to the pointer is moved

// Applies a homography to a point; null beyond the horizon.
export function mapped(matrix, [x, y]) {
  const [X, Y, w] = matrix.map((row) => row[0] * x + row[1] * y + row[2]);
  return Math.abs(w) > 1e-12 ? [X / w, Y / w] : null;
}

// A picture with drawings over it in its pixels: the origin is the centre of the top-left one.
export function overlaid(image, ...drawings) {
  const {naturalWidth: width, naturalHeight: height} = image;
  return h("div", {class: "overlaid"}, image, svg("svg", {viewBox: `-0.5 -0.5 ${width} ${height}`, "aria-hidden": "true"}, drawings));
}

// The pixel of the picture that an event is at.
export function pixelOf(event, node, {naturalWidth: width, naturalHeight: height}) {
  const box = node.getBoundingClientRect();
  return [(event.clientX - box.left) / box.width * width - 0.5, (event.clientY - box.top) / box.height * height - 0.5];
}

// The table of correspondences and the points on the overview; both edit the same list.
function correspondences(known, mapping) {
  const rows = h("tbody", {});
  const place = h("div", {});
  const points = svg("g", {});
  let image = null;
  const short = (value) => value === undefined ? "" : Number(value.toPrecision(10));
  const value = (row, k) => { const text = row.inputs[k].value.trim(); return text === "" ? NaN : Number(text); };
  let list = [];

  function update() {
    for (const [at, row] of list.entries()) {
      const [x, y, X, Y] = [0, 1, 2, 3].map((k) => value(row, k));
      replace(row.id, String(at + 1));
      row.inputs.forEach((input, k) => input.setAttribute("aria-label",
        `${["Image x", "Image y", "Robot X", "Robot Y"][k]} of point ${at + 1}`));
      const predicted = mapping ? mapped(mapping.matrix, [x, y]) : null;
      const off = predicted ? Math.hypot(predicted[0] - X, predicted[1] - Y) : NaN;
      replace(row.off, Number.isFinite(off) ? number(off, 2) : "–");
    }
    const size = image ? image.naturalWidth / 70 : 0;
    points.replaceChildren(...list.flatMap((row, at) => {
      const [x, y] = [value(row, 0), value(row, 1)];
      if (!Number.isFinite(x + y)) return [];
      const active = row.node.contains(document.activeElement) ? " active" : "";
      const cross = `M${x - size} ${y}H${x + size}M${x} ${y - size}V${y + size}`;
      return [svg("path", {d: cross, class: "halo"}), svg("path", {d: cross, class: `known${active}`}),
        svg("text", {x: x + size, y: y - size, "font-size": 2.2 * size}, String(at + 1))];
    }));
  }
  function add([x, y, X, Y] = []) {
    const inputs = [x, y, X, Y].map((each) => h("input",
      {type: "number", step: "any", required: true, value: short(each), onInput: update, onFocus: update, onBlur: update}));
    const row = {inputs, id: h("th", {scope: "row"}), off: h("td", {class: "n"})};
    row.node = h("tr", {}, row.id, inputs.map((input) => h("td", {}, input)), row.off,
      h("td", {}, h("button", {type: "button", class: "quiet small", onClick() {
        list = list.filter((each) => each !== row);
        row.node.remove();
        update();
      }}, "Remove")));
    list.push(row);
    rows.append(row.node);
    update();
    return row;
  }
  for (const {image_px: pixel, robot_mm: mm} of known) add([...pixel, ...mm]);

  function onPicture(node) {
    let moved = null;
    node.addEventListener("pointerdown", (event) => {
      const [x, y] = pixelOf(event, node, image);
      const scale = node.getBoundingClientRect().width / image.naturalWidth;
      const distance = (row) => scale * Math.hypot(value(row, 0) - x, value(row, 1) - y) || 0;
      moved = list.filter((row) => Number.isFinite(value(row, 0) + value(row, 1)) && distance(row) < NEAR_PX)
        .sort((a, b) => distance(a) - distance(b))[0];
      if (moved) node.setPointerCapture(event.pointerId);
      else add([Math.round(x * 10) / 10, Math.round(y * 10) / 10]).inputs[2].focus({preventScroll: true});
      event.preventDefault();
    });
    node.addEventListener("pointermove", (event) => {
      if (!moved) return;
      pixelOf(event, node, image).forEach((at, k) => { moved.inputs[k].value = Math.round(at * 10) / 10; });
      update();
    });
    for (const end of ["pointerup", "pointercancel"]) node.addEventListener(end, () => { moved = null; });
  }
  return {
    node: h("div", {class: "split even"},
      h("div", {class: "scroll"}, h("table", {id: "correspondences", class: "touched"},
        h("thead", {}, h("tr", {}, ["", "x, px", "y, px", "X, mm", "Y, mm"].map((words) => h("th", {}, words)),
          h("th", {class: "n", title: "From where the mapping as it is kept puts the pixel"}, "off, mm"),
          h("th", {}, h("span", {class: "visually-hidden"}, "Remove")))), rows),
        h("p", {}, h("button", {type: "button", class: "quiet small", onClick: () => add().inputs[0].focus()}, "Add a point"))),
      place),
    // Shows the overview to click points on.
    show(picture) {
      image = picture;
      if (!image) return;
      const node = overlaid(image, points);
      onPicture(node);
      replace(place, node,
        h("p", {class: "muted"}, "Click a mark whose robot coordinates you know to add a point; drag a point to move it."));
      update();
    },
    read: () => list.map((row) => ({image_px: [value(row, 0), value(row, 1)], robot_mm: [value(row, 2), value(row, 3)]})),
  };
}

function segmentationFields({threshold = "adaptive", polarity, window_px: size, offset, min_area_px: least, max_objects: most} = {}) {
  const level = typeof threshold === "number";
  return h("div", {class: "fields"},
    choiceField("Threshold", "threshold",
      [["adaptive", "adaptive: local background"], ["otsu", "otsu: one for the picture"], ["level", "a gray level"]],
      level ? "level" : threshold),
    numberField("Gray level", "level", level ? threshold : undefined, {min: 0, max: 255, hint: "With “a gray level”."}),
    choiceField("Objects are", "polarity",
      [["either", "lighter, darker or of another colour"], ["light_on_dark", "lighter than the background"],
        ["dark_on_light", "darker than the background"]], polarity ?? "either"),
    numberField("Background window, px", "window_px", size, {min: 3, step: 1, hint: "Empty: chosen from the picture."}),
    numberField("Contrast, gray levels", "offset", offset, {min: 0, max: 255, hint: "Empty: chosen from the picture."}),
    numberField("Least area, px", "min_area_px", least, {min: 1, step: 1, hint: "Empty: chosen from the picture."}),
    numberField("Most objects", "max_objects", most ?? 100, {min: 1, max: 1000, step: 1}));
}

const given = (members) => Object.fromEntries(Object.entries(members).filter(([, value]) => value !== undefined && value !== ""));

// The form of a workcell, `kept` as the service has it or null for a new one. `picture()` gives the overview's file.
export function workcellForm({kept, databases, calibrations, picture, onKept, signal}) {
  const fault = h("div", {});
  const preview = h("div", {});
  const points = correspondences(kept?.correspondences ?? [], kept?.mapping);
  const names = (list, first) => [...first, ...list.map((name) => [name, name])];
  const form = h("form", {id: "workcell-form", onSubmit: (event) => { event.preventDefault(); keep.click(); }},
    h("div", {class: "fields"},
      kept ? null : textField("Name", "name", "", {required: true, pattern: NAME, hint: "Letters, digits, - _ ."}),
      choiceField("Database of the parts", "database", names(databases, []), kept?.database ?? databases[0]),
      choiceField("Calibration for distances", "calibration", names(calibrations, [["", "none"]]), kept?.calibration ?? ""),
      choiceField("Mapping", "mapping",
        [["", "what foretells the points best"], ["similarity", "similarity: from 2 points"], ["affine", "affine: from 3 points"],
          ["homography", "homography: from 4, aslant"]], kept?.mapping.kind ?? ""),
      checkField("Robot's Y grows upwards in the picture", "flip_y", kept?.flip_y ?? true),
      numberField("Centred within, px", "tolerance_px", kept?.tolerance_px ?? 1, {min: 0}),
      numberField("Gripper's camera, mm a pixel", "mm_per_px", kept?.local?.mm_per_px, {min: 0, hint: "Empty: centrings in pixels alone."}),
      numberField("Gripper's camera, turned by °", "rotation_deg", kept?.local?.rotation_deg,
        {hint: "Its x axis, from the robot's X towards Y."})),
    h("h3", {}, "Points: image ↔ robot"), points.node,
    h("details", {}, h("summary", {}, "Segmentation"), segmentationFields(kept?.segmentation),
      act("Try it on the overview", async () => {
        const file = picture();
        if (!file) return toast("Drop an overview first.");
        const body = new FormData();
        body.append("image", file, file.name);
        body.append("options", JSON.stringify(segmentation()));
        const address = URL.createObjectURL(await (await call("POST", "v1/segmentations",
          {body, accept: "image/png; preview=regions", signal})).blob());
        replace(preview, h("img",
          {src: address, alt: "The overview with the regions outlined", onLoad: () => URL.revokeObjectURL(address)}));
      }, {kind: "quiet", place: fault}), preview));
  const field = (name) => form.elements[name].value;
  const segmentation = () => given({
    threshold: field("threshold") === "level" ? numberIn(form, "level") : field("threshold"), polarity: field("polarity"),
    window_px: numberIn(form, "window_px"), offset: numberIn(form, "offset"), min_area_px: numberIn(form, "min_area_px"),
    max_objects: numberIn(form, "max_objects")});
  const keep = act(kept ? "Keep the changes" : "Create the workcell", async () => {
    if (!form.reportValidity()) return;
    const name = kept?.name ?? field("name");
    const scale = numberIn(form, "mm_per_px");
    const body = given({
      database: field("database"), calibration: field("calibration"), mapping: field("mapping"), flip_y: form.elements.flip_y.checked,
      tolerance_px: numberIn(form, "tolerance_px"),
      local: scale === undefined ? undefined : given({mm_per_px: scale, rotation_deg: numberIn(form, "rotation_deg")}),
      correspondences: points.read(), segmentation: segmentation()});
    try {
      if (!kept && (await all("v1/workcells", {signal})).some((each) => each.name === name)
        && !await confirm(`Replace the workcell ${name}?`, "There is one of that name: its mapping and settings are replaced by these.",
          "Replace it")) return;
      onKept(await put(`v1/workcells/${encodeURIComponent(name)}`, body));
    } catch (error) {
      markFaults(form, error);
      throw error;
    }
  }, {place: fault, id: "keep-workcell"});
  return {node: h("div", {}, form, h("div", {class: "row"}, keep), fault), show: points.show};
}
