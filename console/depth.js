// #/depth: how far everything is, from a picture focused near and one focused far, or from one wide open and one stopped down.

import {h, replace} from "./dom.js";
import {all, call, post, Problem, put} from "./api.js";
import {act, confirm, number, pictures, problem, toast} from "./parts.js";
import {checkField, choiceField, download, markFaults, numberField, numberIn, textField} from "./fields.js";
import {DEPTH_WARNINGS, depthMapView} from "./depth_map.js";
import {nearToFar, quantiles} from "./false_colours.js";
import {isAperturePair, isStack, lensOf} from "./optics.js";
import {opticsFigure} from "./optics_figure.js";
import {predictionCard} from "./prediction.js";
import {pointCloud} from "./point_cloud.js";
import {readNpy} from "./npy.js";
import {loaded} from "./frame_view.js";

const LAST = "landmarkd-optics";
// A 35 mm lens at f/8: a working range of 500 to 583 mm with a largest blur of 5 px.
const EXAMPLE = {focal_length_mm: 35, f_number: 8, near_focus_mm: 500, plane_separation_mm: 0.4, pixel_pitch_um: 10, telecentric: true};
const MOST_POINTS = 120000;
// The pictures of either kind of pair: the names of their parts, and what they are.
const FOCAL = [
  ["near", "Near-focused", "Drop the picture that is focused near"],
  ["far", "Far-focused", "Drop the picture that is focused far"],
];
const APERTURE = [["wide", "Wide open", "Drop the picture of the wider aperture"],
  ["narrow", "Stopped down", "Drop the picture of the narrower aperture"]];
// The first and the second picture, kept while other pages are shown.
const pair = {near: null, far: null};
// The pictures of a stack, from near to far.
const stack = {files: []};

function lastOptics() {
  try {
    return {...JSON.parse(localStorage.getItem(LAST) ?? "null") ?? EXAMPLE};
  } catch {
    return {...EXAMPLE};
  }
}

function remember(optics) {
  try {
    localStorage.setItem(LAST, JSON.stringify(optics));
  } catch { /* this browser stores nothing */ }
}

// One picture of the pair: a preview, and where to drop another. `name(title, hint)` says which it is.
function pictureChoice(role, onChange, signal) {
  const preview = h("div", {class: "pair-preview"});
  const heading = h("h2", {});
  const choice = h("div", {});
  let title = "";
  async function show() {
    const file = pair[role];
    if (!file) return void replace(preview);
    const shown = await loaded(file, `${title} picture`, signal).catch(() => null);
    if (file === pair[role]) replace(preview, shown,
      h("p", {class: "muted"}, shown ? file.name : `${file.name}: this browser can't show it; the service may.`));
  }
  show();
  function name(words, hint) {
    if (words === title) return;
    title = words;
    replace(heading, title);
    replace(choice, pictures({label: hint, onPictures([{file}]) { pair[role] = file; show(); onChange(); }}));
  }
  return {node: h("section", {class: "card", id: `pair-${role}`}, heading, preview, choice), show, name};
}

// The pictures of a stack: their names in order, and where to drop others.
function stackChoice(onChange) {
  const list = h("ol", {});
  const show = () => replace(list, stack.files.map((file) => h("li", {}, file.name)));
  show();
  return h("section", {class: "card", id: "stack-pictures"}, h("h2", {}, "Pictures of the stack"), list,
    pictures({label: "Drop the pictures together, named in the order of their focus from near to far", multiple: true,
      onPictures(dropped) {
        stack.files = dropped.map(({file}) => file).toSorted((a, b) => a.name.localeCompare(b.name, undefined, {numeric: true}));
        show();
        onChange();
      }}));
}

// The form of the optics: by hand, or those of a stored calibration.
function opticsForm(calibrations, onChange) {
  const last = lastOptics();
  const kinds = {
    aperture: [["f_number", "f-number"], ["aperture_mm", "aperture, mm"], ["aperture", "unknown aperture"]],
    sensor: [["near_focus_mm", "near focus, mm"], ["near_plane_mm", "near sensor at, mm"]],
  };
  const either = (kind, value, hint) => h("div", {class: "field either"},
    choiceField("", `${kind}_kind`, kinds[kind], kinds[kind].map(([name]) => name).find((name) => last[name] !== undefined),
      {"aria-label": `The ${kind} is given as`}),
    h("input", {type: "number", step: "any", min: 0, inputmode: "decimal", name: `${kind}_value`, value,
      "aria-label": `${kind === "sensor" ? "Near focus or near sensor" : "f-number or aperture"}`}), h("span", {class: "hint"}, hint));
  const ofFocal = h("div", {class: "fields"},
    either("sensor", last.near_focus_mm ?? last.near_plane_mm ?? EXAMPLE.near_focus_mm,
      "What the near-focused picture is sharp at, or its sensor's distance from the lens."),
    numberField("Sensors apart, mm", "plane_separation_mm", last.plane_separation_mm ?? EXAMPLE.plane_separation_mm,
      {min: 0, hint: "How much nearer to the lens the far-focused picture's sensor stands."}));
  const ofApertures = h("div", {class: "fields"},
    numberField("f-number, wide open", "f_number_wide", last.f_numbers?.[0] ?? 2.8, {min: 0}),
    numberField("f-number, stopped down", "f_number_narrow", last.f_numbers?.[1] ?? 8, {min: 0}),
    numberField("Focus, mm", "focus_mm", last.focus_mm ?? 500, {min: 0, hint: "What both pictures are sharp at."}),
    numberField("Range ends at, mm", "range_end_mm", last.range_end_mm ?? 540,
      {min: 0, hint: "Beyond the focus or before it: what stands on its other side is measured as if it stood on this one."}));
  const ofStack = h("div", {class: "fields"},
    textField("Focus distances, mm", "focuses_mm", (last.focuses_mm ?? [500, 583, 701]).join(", "),
      {hint: "Three and more, from near to far, with commas between."}));
  const aperture = either("aperture", last.f_number ?? last.aperture_mm ?? EXAMPLE.f_number,
    "How wide the lens is. Unknown, it is measured from two textured pictures.");
  const byHand = h("div", {class: "fields"},
    choiceField("The pictures differ in", "pair_kind",
      [["focus", "focus, two settings"], ["aperture", "aperture"], ["stack", "focus, three settings and more"]],
      isAperturePair(last) ? "aperture" : isStack(last) ? "stack" : "focus"),
    numberField("Focal length, mm", "focal_length_mm", last.focal_length_mm, {min: 0}),
    aperture, ofFocal, ofApertures, ofStack,
    numberField("Pixel pitch, µm", "pixel_pitch_um", last.pixel_pitch_um, {min: 0}),
    numberField("Optical axis at x, px", "axis_x", last.principal_point_px?.[0], {hint: "Empty: the picture's middle."}),
    numberField("Optical axis at y, px", "axis_y", last.principal_point_px?.[1]),
    checkField("Telecentric stop", "telecentric", last.telecentric, "Keeps both pictures at one scale."));
  const stored = h("div", {});
  const source = calibrations.length
    ? choiceField("Optics from", "calibration", [["", "this form"], ...calibrations.map(({name}) => [name, `calibration ${name}`])], "")
      : null;
  const form = h("form", {id: "optics-form", onSubmit: (event) => event.preventDefault()}, source, byHand, stored);
  const chosen = () => calibrations.find(({name}) => name === form.elements.calibration?.value);
  const differIn = (kind) => form.elements.pair_kind.value === kind;
  function read() {
    const [x, y] = [numberIn(form, "axis_x"), numberIn(form, "axis_y")];
    const wide = form.elements.aperture_kind.value;
    const oneAperture = {[wide]: wide === "aperture" ? "unknown" : numberIn(form, "aperture_value")};
    const differ = {
      focus: () => ({...oneAperture, [form.elements.sensor_kind.value]: numberIn(form, "sensor_value"),
        plane_separation_mm: numberIn(form, "plane_separation_mm")}),
      aperture: () => ({f_numbers: [numberIn(form, "f_number_wide") ?? null, numberIn(form, "f_number_narrow") ?? null],
        focus_mm: numberIn(form, "focus_mm"), range_end_mm: numberIn(form, "range_end_mm")}),
      stack: () => ({...oneAperture, focuses_mm: form.elements.focuses_mm.value.split(",").map((mm) => Number(mm))}),
    }[form.elements.pair_kind.value];
    return {
      focal_length_mm: numberIn(form, "focal_length_mm"),
      ...differ(),
      pixel_pitch_um: numberIn(form, "pixel_pitch_um"),
      telecentric: form.elements.telecentric.checked,
      ...x !== undefined || y !== undefined ? {principal_point_px: [x ?? null, y ?? null]} : {},
    };
  }
  let before = read();
  const showKind = () => {
    [ofFocal.hidden, ofApertures.hidden, ofStack.hidden] = ["focus", "aperture", "stack"].map((kind) => !differIn(kind));
    aperture.hidden = differIn("aperture");
    form.elements.aperture_value.disabled = form.elements.aperture_kind.value === "aperture";
  };
  showKind();
  form.addEventListener("input", (event) => {
    // Another unit for the same lens: the value is converted.
    if (/^(aperture|sensor)_kind$/.test(event.target.name)) {
      try {
        const lens = lensOf(before);
        const same = {f_number: lens.focalLength / lens.aperture, aperture_mm: lens.aperture, near_focus_mm: lens.nearFocus,
          near_plane_mm: lens.nearPlane}[event.target.value];
        if (same !== undefined) form.elements[event.target.name.replace("kind", "value")].value = Number(same.toPrecision(10));
      } catch { /* impossible optics are not converted */ }
    }
    showKind();
    before = read();
    byHand.hidden = !!chosen();
    replace(stored, chosen() ? storedFacts(chosen()) : null);
    if (!chosen()) remember(before);
    onChange();
  });
  return {
    node: form,
    // The optics that the page draws with, and the part of the form that is sent.
    optics: () => chosen()?.optics ?? read(),
    part: () => chosen() ? ["calibration", chosen().name] : ["optics", JSON.stringify(read())],
    mark: (error) => markFaults(form, {errors: (error?.errors ?? []).map(({pointer}) => ({
      pointer: pointer.replace(/\bf_number\b|\baperture(_mm)?\b/, "aperture_value").replace(/near_focus_mm|near_plane_mm/, "sensor_value")
        .replace(/principal_point_px/, "axis_x/axis_y").replace(/f_numbers|apertures_mm/, "f_number_wide/f_number_narrow")}))}),
  };
}

function storedFacts({registration, table, residual, advice, image}) {
  return [
    h("ul", {},
      image && h("li", {}, `Pictures of ${image.width} × ${image.height} px, ${image.bits} bit.`),
      h("li", {}, registration ? `Registered, ${number(registration.rms_px, 3)} px left.`
        : "Not registered: the scale follows from the optics."),
      h("li", {}, table
        ? `Swept: ${table.depth_mm.length} planes, ${number(table.depth_mm[0], 1)} to ${number(table.depth_mm.at(-1), 1)} mm`
        : "Not swept: depths follow from the optics alone",
        residual ? `, ${number(residual.rms_mm)} mm left.` : ".")),
    advice.length ? h("div", {class: "note"}, h("ul", {}, advice.map((each) => h("li", {}, each)))) : null];
}

function optionsForm() {
  const form = h("form", {onSubmit: (event) => event.preventDefault()}, h("div", {class: "fields"},
    choiceField("Method", "method", [["gram", "gram: explains both pictures best"], ["stm", "stm: closed form, the cheapest"],
      ["laplacian", "laplacian: the paper's, needs its own sweep"]], "gram"),
    textField("Window, px", "window", "auto", {hint: "auto, or 1 to 32: larger is steadier and coarser."}),
    choiceField("Shift", "align", [["auto", "look for it"], ["none", "leave it"]], "auto"),
    choiceField("Brightness", "photometric", [["auto", "match it"], ["none", "leave it"]], "auto"),
    choiceField("Median over depths", "median", [["0", "none"], ["3", "3 × 3"], ["5", "5 × 5"]], "0")));
  return {
    node: h("details", {class: "card", id: "depth-options"}, h("summary", {}, "Options of the method"), form),
    read() {
      const {method, window: size, align, photometric, median} = form.elements;
      const px = size.value.trim();
      return {method: method.value, window: px === "" || Number.isNaN(Number(px)) ? px || "auto" : Number(px), align: align.value,
        photometric: photometric.value, median: Number(median.value)};
    },
    mark: (error) => markFaults(form, error),
  };
}

function cloudOf(map, optics) {
  const lens = lensOf(optics);
  const [axisX, axisY] = optics.principal_point_px ?? [(map.width - 1) / 2, (map.height - 1) / 2];
  const [from, to] = quantiles(map.depth, [0.005, 0.995]);
  const stride = Math.max(1, Math.ceil(Math.sqrt(map.width * map.height / MOST_POINTS)));
  const [points, colours] = [[], []];
  for (let y = 0; y < map.height; y += stride) {
    for (let x = 0; x < map.width; x += stride) {
      const depth = map.depth[y * map.width + x];
      if (!(depth >= from && depth <= to)) continue;
      points.push(...lens.point(x - axisX, y - axisY, depth));
      colours.push(...nearToFar(to > from ? (depth - from) / (to - from) : 0.5));
    }
  }
  return points.length ? pointCloud(Float32Array.from(points), colours) : h("p", {class: "muted"}, "No points.");
}

// The result: the summary first, then the map with its profile and its point cloud.
function results(summary, map, optics, files) {
  const {coverage, depth_mm: span, warnings, blur_scale: scale} = summary;
  const typical = quantiles(map.sigma.filter((_, at) => !map.flags[at]), [0.5])?.[0];
  const view = depthMapView(map, [summary.near_focus_mm, summary.far_focus_mm]);
  const fact = (name, value) => h("div", {}, h("dt", {}, name), h("dd", {}, value));
  return [
    h("section", {class: "card"}, h("h2", {id: "depth-heading", tabindex: "-1"}, "Distances"),
      h("p", {class: "answer"}, span
        ? [h("strong", {}, `${number(span.min, 1)} to ${number(span.max, 1)} mm`), `, median ${number(span.median, 1)} mm`,
          typical ? `, typically ± ${number(typical)} mm` : "", `; ${number(100 * coverage, 1)} % of the pixels have a distance.`]
        : [h("strong", {}, "No pixel has a distance."), " The layer Flags says why."]),
      warnings.map((word) => h("div", {class: "note"}, h("code", {}, word), " ", DEPTH_WARNINGS[word] ?? "")),
      h("dl", {class: "facts"},
        fact("Working range", `${number(summary.near_focus_mm, 1)} to ${number(summary.far_focus_mm, 1)} mm`),
        fact("Largest blur", `${number(summary.largest_blur_px, 1)} px`),
        scale && fact(
          "Aperture, measured",
          `${number(scale.aperture_mm)} mm: ${number(scale.largest_blur_px)} ± ${number(scale.sigma_px)} px`,
        ),
        fact("Noise", summary.noise_sigma === null ? "unknown" : `${number(summary.noise_sigma)} of 255`),
        fact("Shift taken out", `${summary.shift_px.map((px) => number(px)).join(", ")} px`),
        fact("Gain of far", number(summary.gain, 3)),
        fact("Method", `${summary.method}, window ${summary.window}${summary.calibration ? `, calibration ${summary.calibration}` : ""}`),
        fact("Time", `${number(summary.timings_ms.total, 1)} ms`)),
      h("div", {class: "row"}, files)),
    h("div", {class: "split"},
      h("section", {class: "card"}, h("h2", {}, "Map"), view.map),
      h("div", {}, h("section", {class: "card"}, h("h2", {}, "Profile"), view.profile),
        h("section", {class: "card"}, h("h2", {}, "Points in space"), span ? cloudOf(map, optics) : h("p", {class: "muted"}, "None.")))),
  ];
}

export async function show(main, parts, signal) {
  const calibrations = await all("v1/calibrations", {signal});
  if (signal.aborted) return;
  const result = h("div", {id: "depth-result"});
  const fault = h("div", {});
  const figure = opticsFigure();
  const keepFault = h("div", {});
  const keepName = textField("Name of the calibration", "name", "", {hint: "Letters, digits, - _ ."});
  const keeping = h("details", {}, h("summary", {}, "Keep these optics as a calibration"),
    h("p", {class: "muted"},
      "Workcells measure distances by a calibration. One of that name with other optics is replaced, "
      + "and its registration and sweep are deleted."),
    keepName, act("Keep them", async () => {
      const name = keepName.querySelector("input").value.trim();
      if ((await all("v1/calibrations", {signal})).some((each) => each.name === name)
        && !await confirm(`Replace the calibration ${name}?`,
          "There is one of that name. With other optics, its registration and its sweep are deleted.", "Replace it")) return;
      await put(`v1/calibrations/${encodeURIComponent(name)}`, optics.optics());
      toast(`Kept as the calibration ${name}.`);
    }, {place: keepFault, kind: "quiet"}), keepFault);
  const optics = opticsForm(calibrations, () => { figure.update(optics.optics()); name(); ready(); });
  const kind = () => isAperturePair(optics.optics()) ? APERTURE : FOCAL;
  const options = optionsForm();
  const hint = h("p", {class: "muted", id: "measure-hint"});
  const ready = () => {
    const settings = optics.optics().focuses_mm?.length;
    stacked.hidden = settings === undefined;
    twoPictures.hidden = swap.hidden = settings !== undefined;
    if (settings !== undefined) {
      measure.disabled = stack.files.length !== settings;
      return void replace(hint, measure.disabled ? `${settings} focus distances, and ${stack.files.length} pictures.` : "");
    }
    const missing = ["near", "far"].flatMap((role, k) => pair[role] ? [] : [kind()[k][1].toLowerCase()]);
    measure.disabled = missing.length > 0;
    replace(hint, missing.length ? `Still missing: the ${missing.join(" and the ")} picture.` : "");
  };
  const near = pictureChoice("near", () => ready(), signal);
  const far = pictureChoice("far", () => ready(), signal);
  const name = () => [near, far].forEach((choice, k) => choice.name(...kind()[k].slice(1)));
  name();
  const twoPictures = h("div", {class: "split even"}, near.node, far.node);
  const stacked = stackChoice(() => ready());

  let earlier = new AbortController();
  async function run() {
    earlier.abort();
    earlier = new AbortController();
    const now = AbortSignal.any([signal, earlier.signal]);
    const lens = optics.optics();
    const pairParts = kind().map(([part], k) => [part, [pair.near, pair.far][k]]);
    const parts = isStack(lens) ? stack.files.map((file) => ["stack", file]) : pairParts;
    const sent = {parts, near: parts[0][1], optics: lens, part: optics.part(), options: options.read()};
    const form = () => {
      const body = new FormData();
      for (const [part, file] of sent.parts) body.append(part, file, file.name);
      body.append(...sent.part);
      body.append("options", JSON.stringify(sent.options));
      return body;
    };
    const asked = (accept, query = "") => call("POST", `v1/depth-maps${query}`, {body: form(), accept, signal: now});
    try {
      replace(result, h("p", {class: "muted", role: "status"}, "Measuring…"));
      const [summary, bytes, picture] = await Promise.all([
        post("v1/depth-maps", {body: form(), signal: now}),
        asked("application/x-npy", "?planes=depth,sigma,flags").then((answer) => answer.arrayBuffer()),
        loaded(sent.near, "", now).catch(() => null)]);
      if (now.aborted) return;
      const {shape: [, height, width], data} = readNpy(bytes);
      const plane = (k) => data.subarray(k * width * height, (k + 1) * width * height);
      const map = {width, height, depth: plane(0), sigma: plane(1), flags: Uint8Array.from(plane(2)), counts: summary.flags, near: picture};
      const stem = sent.near.name.replace(/\.[^.]*$/, "");
      const files = [
        act("PNG, 16 bit", async () => {
          const answer = await asked("image/png");
          download(await answer.blob(), `${stem}-depth.png`);
          toast(`Distance = gray level × ${answer.headers.get("X-Depth-Scale-Mm")} mm; 0 is unknown.`);
        }, {kind: "quiet"}),
        act("NPY: depth, sigma, flags", async () => download(new Blob([bytes]), `${stem}-depth.npy`), {kind: "quiet"}),
        act("PLY: points, metres", async () => download(await (await asked("model/ply")).blob(), `${stem}.ply`), {kind: "quiet"})];
      optics.mark(null);
      options.mark(null);
      replace(result, results(summary, map, sent.optics, files));
      const heading = document.getElementById("depth-heading");
      heading.focus({preventScroll: true});
      heading.scrollIntoView({block: "start"});
    } catch (error) {
      if (now.aborted) return;
      replace(result);
      if (error instanceof Problem) { optics.mark(error); options.mark(error); }
      throw error;
    }
  }
  const measure = act("Measure", run, {place: fault, id: "measure", "aria-describedby": "measure-hint"});
  const swap = act("Swap the pictures", async () => { [pair.near, pair.far] = [pair.far, pair.near]; near.show(); far.show(); },
    {kind: "quiet"});
  replace(main,
    h("h1", {}, "Depth"),
    h("p", {}, "Two pictures of one scene, one focused near and one far, or one wide open and one stopped down: how blurred each "
      + "point is in both says how far it is."),
    twoPictures, stacked,
    h("section", {class: "card"}, h("h2", {}, "Optics"), h("div", {class: "split even"}, h("div", {}, optics.node, keeping), figure.node)),
    predictionCard(() => optics.optics(), signal),
    options.node,
    h("div", {class: "row", id: "measure-row"}, measure, swap, hint), fault, result);
  figure.update(optics.optics());
  ready();
}
