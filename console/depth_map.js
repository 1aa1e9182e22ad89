// The view of a depth map: layers in false colours, the reading of any pixel, and the profile along a line.

import {h, picture, replace, svg} from "./dom.js";
import {number} from "./parts.js";
import {ticks} from "./charts.js";
import {css, littleToMuch, nearToFar, packed, pixelRamp, quantiles} from "./false_colours.js";

// Why a pixel has no depth: a bit each, in the order that decides the colour of a pixel with several.
const FLAGS = [
  {bit: 16, word: "border", colour: [120, 120, 120], why: "the filters don't fit into the picture here"},
  {bit: 2, word: "saturated", colour: [250, 250, 250], why: "full scale within 8 px in either picture: expose less"},
  {bit: 1, word: "low_texture", colour: [90, 120, 230], why: "too little detail: more light, or a projected pattern"},
  {bit: 4, word: "out_of_range", colour: [240, 200, 40], why: "nearer or farther than the working range"},
  {bit: 8, word: "inconsistent", colour: [230, 70, 50],
    why: "no one depth explains it: an edge, motion, glint, or pictures out of register"},
  {bit: 32, word: "ambiguous", colour: [200, 80, 200], why: "a second depth explains it nearly as well: a fine regular pattern"},
];
const flagsOf = (bits) => FLAGS.filter(({bit}) => bits & bit);

// Warnings about a whole map.
export const DEPTH_WARNINGS = {
  shifted: "The far-focused picture was displaced by more than 0.25 px and was moved back. "
    + "A fixed rig should show less: register it in a calibration.",
  shift_unknown: "The shift between the pictures is unknown: the texture is too regular or too little to fix one. "
    + "Distances are right only if the pictures are in register.",
  scaled: "The pictures' scales differ by more than 0.25 px in the corners: the lens breathes as it focuses. They were matched; "
    + "a calibration registers them better.",
  rotated: "The camera turned by more than 0.25 px in the corners between the pictures, and was turned back: fix it.",
  moved: "A part of the picture moved between the two pictures: what moved has no distance. Take both at once, or of a still scene.",
  misregistered: "No shift, scale and turn brings the pictures' parts together: the camera tilted, or much of the scene moved.",
  contrast_off: "The pictures' contrasts differ by another factor than their brightness, and were matched: one has a dark level or "
    + "a tone curve that the other has not. Take linear pictures, or calibrate with dark ones.",
  scale_estimated: "The aperture was measured from these pictures: all distances share its error. State it once it is known.",
  sweep_failed: "The calibration's newest sweep failed: what was measured before it answers.",
  gain_off: "The pictures' brightness differs by more than 3 %, and was matched: use one exposure for both, "
    + "or calibrate with dark and flat pictures.",
  many_inconsistent: "More than a fifth of the pixels with texture fit no depth: the scene moved between the pictures, "
    + "they are out of register, or the optics aren't these.",
  low_coverage: "Fewer than 5 % of the pixels have a distance: the layer Flags says why.",
  near_far_swapped: "The pictures are exchanged, as the scales of near and far say, or the detail of two apertures: swap them and "
    + "measure again.",
};

const LAYERS = [["depth", "Depth"], ["sigma", "Uncertainty"], ["flags", "Flags"], ["coverage", "Coverage"]];
const SPAN = [0.02, 0.98]; // as the service's previews: single wrong pixels don't take all colours

// The legend of a colour map: a bar with ticks.
function scaleBar(title, colour, [from, to]) {
  const [left, right] = [8, 392];
  const x = (value) => left + (right - left) * (to > from ? (value - from) / (to - from) : 0.5);
  return picture(`${title}: colours run from ${number(from, 2)} to ${number(to, 2)} mm`, 400, 38,
    Array.from({length: 64}, (_, k) => svg("rect", {x: left + k * 6, y: 2, width: 6.5, height: 14, fill: css(colour((k + 0.5) / 64))})),
    ticks(from, to, 5).map((value) => [svg("line", {x1: x(value), x2: x(value), y1: 16, y2: 21, class: "tick"}),
      svg("text", {x: x(value), y: 34, "text-anchor": x(value) < 40 ? "start" : x(value) > 370 ? "end" : "middle"},
        `${number(value, 3)} mm`)]));
}

function swatches(rows) {
  return h("ul", {class: "swatches"}, rows.map(([colour, words, why]) => h("li", {},
    h("span", {class: "swatch", style: {background: css(colour)}}),
    h("span", {}, words, why ? h("span", {class: "muted"}, ` – ${why}`) : null))));
}

// The profile of depth along a line: the curve with its band of ± sigma, broken where nothing is known.
function profile(map, [x0, y0, x1, y1], focus) {
  const length = Math.max(Math.hypot(x1 - x0, y1 - y0), 1);
  const steps = Math.round(length);
  const samples = Array.from({length: steps + 1}, (_, k) => {
    const at = Math.round(y0 + (y1 - y0) * k / steps) * map.width + Math.round(x0 + (x1 - x0) * k / steps);
    return {along: length * k / steps, depth: map.depth[at], sigma: map.sigma[at] || 0};
  });
  const known = samples.filter(({depth}) => Number.isFinite(depth));
  if (!known.length) return h("p", {class: "note"}, "No pixel on this line has a distance.");
  let [least, most] = [Math.min(...known.map(({depth, sigma}) => depth - sigma)),
    Math.max(...known.map(({depth, sigma}) => depth + sigma))];
  const margin = Math.max((most - least) * 0.06, 0.1);
  [least, most] = [least - margin, most + margin];
  const [left, right, top, bottom] = [48, 414, 12, 196];
  const x = (along) => left + (right - left) * along / length;
  const y = (depth) => bottom - (bottom - top) * (depth - least) / (most - least);
  const runs = [];
  for (const sample of samples) {
    if (!Number.isFinite(sample.depth)) runs.push([]);
    else (runs.at(-1) ?? runs[runs.push([]) - 1]).push(sample);
  }
  const points = (list, value) => list.map((sample) => `${x(sample.along).toFixed(1)},${y(value(sample)).toFixed(1)}`);
  const [first, last] = [known[0], known.at(-1)];
  const missing = 1 - known.length / samples.length;
  const depths = known.map(({depth}) => depth);
  const words = [`Along the line of ${number(length, 0)} px: from ${number(first.depth, 1)} to ${number(last.depth, 1)} mm`,
    `, least ${number(Math.min(...depths), 1)}, most ${number(Math.max(...depths), 1)} mm`,
    missing ? `; ${number(100 * missing, 1)} % of it has no distance.` : "."].join("");
  return [picture(words, 420, 234,
    ticks(least, most, 4).map((depth) => [svg("line", {x1: left, x2: right, y1: y(depth), y2: y(depth), class: "axis"}),
      svg("text", {x: left - 5, y: y(depth) + 4, "text-anchor": "end"}, number(depth, 2))]),
    ticks(0, length, 5).map((along) => svg("text", {x: x(along), y: bottom + 16, "text-anchor": "middle"}, number(along, 0))),
    svg("text", {x: right, y: bottom + 34, "text-anchor": "end"}, "px along the line"),
    svg("text", {x: 2, y: bottom + 34}, "mm; band: ± sigma"),
    focus.filter((depth) => depth > least && depth < most)
      .map((depth) => svg("line", {x1: left, x2: right, y1: y(depth), y2: y(depth), class: "dashed"})),
    runs.filter((run) => run.length).map((run) => [
      svg("polygon", {points: [...points(run, ({depth, sigma}) => depth + sigma),
        ...points(run, ({depth, sigma}) => depth - sigma).reverse()].join(" "), class: "band"}),
      svg("polyline", {points: points(run, ({depth}) => depth).join(" "), class: "curve near"})])), h("p", {class: "muted"}, words)];
}

// `map` is {width, height, depth, sigma, flags, counts, near}; `near` is the near-focused picture where the browser can
// show it. `focus` are the two focus distances.
export function depthMapView(map, focus) {
  const {width, height} = map;
  const canvas = h("canvas", {width, height, tabindex: 0, role: "application",
    "aria-label": "Depth map: arrow keys move the cursor, with Shift by ten; Enter begins and ends a line",
    "aria-describedby": "depth-reading", id: "depth-canvas"});
  const marks = svg("svg", {viewBox: `0 0 ${width} ${height}`, preserveAspectRatio: "none", "aria-hidden": "true"});
  const reading = h("output", {id: "depth-reading", "aria-live": "polite"});
  const legend = h("div", {id: "depth-legend"});
  const chart = h("div", {id: "depth-profile"});
  const cursor = {x: width >> 1, y: height >> 1};
  let ends = [Math.round(width * 0.1), height >> 1, Math.round(width * 0.9), height >> 1];
  let begun = null;

  const gray = new Uint8Array(width * height).fill(70);
  if (map.near) {
    const scratch = new OffscreenCanvas(width, height).getContext("2d");
    scratch.drawImage(map.near, 0, 0, width, height);
    const {data} = scratch.getImageData(0, 0, width, height);
    for (let at = 0; at < gray.length; at += 1) gray[at] = 0.3 * data[4 * at] + 0.59 * data[4 * at + 1] + 0.11 * data[4 * at + 2];
  }
  const depthSpan = quantiles(map.depth, SPAN) ?? focus;
  const sigmaSpan = [0, quantiles(map.sigma.filter((_, at) => !map.flags[at]), [SPAN[1]])?.[0] || 1];
  const [depthColour, sigmaColour] = [pixelRamp(nearToFar, depthSpan), pixelRamp(littleToMuch, sigmaSpan)];
  const flagColours = Uint32Array.from({length: 64}, (_, bits) => bits ? packed(flagsOf(bits)[0].colour) : 0);
  // The pixel of each layer. What is unknown is left clear: the canvas stands on a pattern.
  const colours = {
    depth: (at) => Number.isFinite(map.depth[at]) ? depthColour(map.depth[at]) : 0,
    sigma: (at) => !map.flags[at] && Number.isFinite(map.sigma[at]) ? sigmaColour(map.sigma[at]) : 0,
    flags: (at) => flagColours[map.flags[at] & 63] || packed([gray[at] >> 1, gray[at] >> 1, gray[at] >> 1]),
    coverage: (at) => map.flags[at] ? 0 : packed([gray[at] >> 1, 60 + gray[at] * 0.7, 50 + (gray[at] >> 1)]),
  };
  const share = (count) => `${number(100 * count / (width * height), 1)} %`;
  const legends = {
    depth: () => [scaleBar("Depth", nearToFar, depthSpan), h("p", {class: "muted"}, "Checked: no distance there.")],
    sigma: () => quantiles(map.sigma, [0.5]) ? [scaleBar("Uncertainty", littleToMuch, sigmaSpan),
      h("p", {class: "muted"}, "The standard deviation that the method expects of each distance: texture, noise and window decide it.")]
      : h("p", {class: "note"}, "This method has no model of its error: it gives no uncertainty."),
    flags: () => swatches(FLAGS.map(({word, bit, colour, why}) => [colour,
      [h("strong", {}, word), ` (bit ${bit}): ${number(map.counts[word] ?? 0, 0)} px, ${share(map.counts[word] ?? 0)}`], why])),
    coverage: () => swatches([[[60, 190, 120], `has a distance: ${share(map.flags.reduce((sum, bits) => sum + (bits === 0), 0))}`],
      [[128, 128, 128], "checked: has none; the layer Flags says why"]]),
  };

  function paint(layer) {
    const context = canvas.getContext("2d");
    const image = context.createImageData(width, height);
    const pixels = new Uint32Array(image.data.buffer);
    for (let at = 0; at < pixels.length; at += 1) pixels[at] = colours[layer](at);
    context.putImageData(image, 0, 0);
    replace(legend, legends[layer]());
  }
  function mark() {
    const both = (props) => ["under", "over"].map((kind) => svg("line", {...props, class: kind}));
    const [x, y] = [cursor.x + 0.5, cursor.y + 0.5];
    const reach = Math.max(width, height) / 40;
    replace(marks, both({x1: ends[0], y1: ends[1], x2: ends[2], y2: ends[3]}), both({x1: x - reach, x2: x + reach, y1: y, y2: y}),
      both({x1: x, x2: x, y1: y - reach, y2: y + reach}));
  }
  function read() {
    const at = cursor.y * width + cursor.x;
    const [depth, sigma, bits] = [map.depth[at], map.sigma[at], map.flags[at]];
    replace(reading, h("span", {class: "muted"}, `x ${cursor.x}, y ${cursor.y}: `),
      h("strong", {}, Number.isFinite(depth) ? `${number(depth, 2)} mm` : "no distance"),
      !Number.isFinite(sigma) ? "" : bits ? ` (it would be ± ${number(sigma, 2)} mm)` : ` ± ${number(sigma, 2)} mm`,
      bits ? ` · ${flagsOf(bits).map(({word, why}) => `${word}: ${why}`).join("; ")}` : "");
  }
  const fields = ["from x", "from y", "to x", "to y"].map((label, k) => h("label", {}, label, " ",
    h("input", {type: "number", min: 0, max: (k % 2 ? height : width) - 1, step: 1,
      onInput: () => setLine(fields.map((each, j) => each.lastChild.value === "" ? ends[j] : Number(each.lastChild.value)), true)})));
  function setLine(line, typed) {
    ends = line.map((value, k) => Math.min(Math.max(Math.round(value), 0), (k % 2 ? height : width) - 1));
    if (!typed) fields.forEach((each, k) => { each.lastChild.value = ends[k]; });
    mark();
    replace(chart, profile(map, ends, focus));
  }
  function moveTo(x, y) {
    cursor.x = Math.min(Math.max(Math.round(x), 0), width - 1);
    cursor.y = Math.min(Math.max(Math.round(y), 0), height - 1);
    if (begun) setLine([...begun, cursor.x, cursor.y]);
    else mark();
    read();
  }
  const pixel = (event) => [event.offsetX / canvas.clientWidth * width - 0.5, event.offsetY / canvas.clientHeight * height - 0.5];
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    moveTo(...pixel(event));
    canvas.dataset.from = `${cursor.x} ${cursor.y}`;
  });
  canvas.addEventListener("pointermove", (event) => {
    const [x, y] = pixel(event);
    if (canvas.dataset.from && !begun && Math.hypot(x - cursor.x, y - cursor.y) > 2) begun = canvas.dataset.from.split(" ").map(Number);
    if (!canvas.dataset.from || begun) moveTo(x, y);
  });
  for (const end of ["pointerup", "pointercancel"]) {
    canvas.addEventListener(end, () => {
      if (canvas.dataset.from) begun = null;
      delete canvas.dataset.from;
    });
  }
  canvas.addEventListener("keydown", (event) => {
    const step = event.shiftKey ? 10 : 1;
    const moves = {ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, -step], ArrowDown: [0, step]};
    if (moves[event.key]) moveTo(cursor.x + moves[event.key][0], cursor.y + moves[event.key][1]);
    else if (event.key === "Enter") begun = begun ? null : [cursor.x, cursor.y];
    else if (event.key === "Escape" && begun) begun = null;
    else return;
    event.preventDefault();
  });

  const layers = h("fieldset", {class: "choices"}, h("legend", {}, "Layer"), LAYERS.map(([layer, words]) =>
    h("label", {}, h("input", {type: "radio", name: "layer", value: layer, checked: layer === "depth", onChange: () => paint(layer)}),
      ` ${words}`)));
  paint("depth");
  setLine(ends);
  read();
  return {
    map: h("div", {}, layers, h("div", {class: "depth-canvas"}, canvas, marks), h("p", {class: "reading"}, reading), legend),
    profile: h("div", {class: "depth-profile"},
      h("p", {class: "muted"},
        "Draw a line on the map with the mouse, or give its ends; on the map Enter begins a line at the cursor and ends it."),
      h("div", {class: "ends"}, fields), chart),
  };
}
