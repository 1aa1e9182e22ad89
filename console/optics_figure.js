// The figure of the optics: of a focal pair the two focus planes and the rays from a point to the sensors; and the blur against
// distance.

import {h, picture, replace, svg} from "./dom.js";
import {number} from "./parts.js";
import {lensOf} from "./optics.js";
import {ticks} from "./charts.js";

const line = (x1, y1, x2, y2, kind) => svg("line", {x1, y1, x2, y2, class: kind});
const text = (x, y, words, anchor = "middle", kind) => svg("text", {x, y, "text-anchor": anchor, class: kind}, words);
const path = (points, kind) => svg("polyline", {points: points.map(([x, y]) => `${x.toFixed(1)},${y.toFixed(1)}`).join(" "), class: kind});

// The scene to scale left of the lens; behind it the sensors, drawn far apart.
function scene(lens, u, most) {
  const [axis, at, high, farSensor, nearSensor, end] = [118, 272, 60, 356, 436, 464];
  const x = (distance) => at - 262 * distance / most;
  const behind = (v) => Math.min(Math.max(farSensor + (v - lens.farPlane) / lens.separation * (nearSensor - farSensor), at + 15), 600);
  const sharp = behind(lens.imageDistance(u));
  const height = (xs) => high * (sharp - xs) / (sharp - at);
  const sensor = (xs, kind) => [line(xs, axis - 50, xs, axis + 50, "axis"),
    line(xs, axis - Math.abs(height(xs)) - 1.5, xs, axis + Math.abs(height(xs)) + 1.5, `thick ${kind}`)];
  const plane = (distance, words, labelAt, kind) => [line(x(distance), 36, x(distance), 200, `dashed ${kind}`),
    text(Math.max(x(distance), 4), labelAt, `${words} ${number(distance, 1)} mm`,
      x(distance) < 75 ? "start" : x(distance) > at - 80 ? "end" : "middle")];
  const [nearBlur, farBlur] = lens.blur(u);
  const stop = lens.telecentric ? [x(lens.focalLength), high * Math.max(0.12, 1 - lens.focalLength / u)] : null;
  return picture(
    `The lens with its focus planes at ${number(lens.nearFocus, 1)} and ${number(lens.farFocus, 1)} mm. `
      + `A point at ${number(u, 1)} mm makes a blur of ${number(nearBlur, 1)} px on the near-focused sensor `
      + `and ${number(farBlur, 1)} px on the far-focused one.`,
    480, 240,
    line(4, axis, 476, axis, "axis"),
    svg("rect", {x: x(lens.farFocus), y: 36, width: x(lens.nearFocus) - x(lens.farFocus), height: 164, class: "working"}),
    plane(lens.farFocus, "far focus", 28, "far"), plane(lens.nearFocus, "near focus", 217, "near"),
    path([[x(u), axis], [at, axis - high], [end, axis - height(end)]], "ray"),
    path([[x(u), axis], [at, axis + high], [end, axis + height(end)]], "ray"),
    svg("ellipse", {cx: at, cy: axis, rx: 8, ry: 74, class: "glass"}), text(at, 28, "lens"),
    stop && [line(stop[0], 50, stop[0], axis - stop[1], "thick stop"), line(stop[0], 186, stop[0], axis + stop[1], "thick stop"),
      text(stop[0] - 4, 200, "stop", "end")],
    sensor(farSensor, "far"), text(farSensor, 58, "far sensor"), text(farSensor, 186, `${number(farBlur, 1)} px`),
    sensor(nearSensor, "near"), text(nearSensor, 42, "near sensor"), text(nearSensor, 202, `${number(nearBlur, 1)} px`),
    svg("circle", {cx: x(u), cy: axis, r: 5, class: "point"}), text(476, 234, "behind the lens not to scale", "end"));
}

function chart(lens, u, [from, to]) {
  const [left, right, top, bottom] = [34, 468, 20, 172];
  const steps = Array.from({length: 161}, (_, k) => from + (to - from) * k / 160);
  const most = Math.min(Math.max(...steps.flatMap(lens.blur)), 2.4 * lens.largestBlur) || 1;
  const x = (distance) => left + (right - left) * (distance - from) / (to - from);
  const y = (blur) => bottom - (bottom - top) * Math.min(blur, most * 1.02) / most;
  const curve = (sensor, kind) => path(steps.map((distance) => [x(distance), y(lens.blur(distance)[sensor])]), `curve ${kind}`);
  const [near, far] = lens.blur(u);
  return picture(
    `Blur against distance, ${lens.names.join(" and ")}: ${lens.blur(lens.nearFocus).map((px) => number(px, 1)).join(" and ")} px at `
      + `${number(lens.nearFocus, 1)} mm, ${lens.blur(lens.farFocus).map((px) => number(px, 1)).join(" and ")} px at `
      + `${number(lens.farFocus, 1)} mm.`,
    480, 226,
    svg("rect", {x: x(lens.nearFocus), y: top, width: x(lens.farFocus) - x(lens.nearFocus), height: bottom - top, class: "working"}),
    ticks(0, most, 4).map((blur) => [line(left, y(blur), right, y(blur), "axis"), text(left - 5, y(blur) + 4, number(blur, 1), "end")]),
    ticks(from, to, 5).map((distance) => [line(x(distance), bottom, x(distance), bottom + 4, "axis"),
      text(x(distance), bottom + 17, number(distance, 1))]),
    text(right, bottom + 45, "distance, mm", "end"), text(2, 12, "blur, px", "start"),
    curve(0, "near"), curve(1, "far"),
    line(x(u), top, x(u), bottom, "dashed"),
    svg("circle", {cx: x(u), cy: y(near), r: 4, class: "dot near"}), svg("circle", {cx: x(u), cy: y(far), r: 4, class: "dot far"}),
    [[lens.names[0], "near", 34], [lens.names[1], "far", 164]].map(([words, kind, at]) =>
      [line(at, bottom + 41, at + 20, bottom + 41, `curve ${kind}`),
        text(at + 25, bottom + 45, words, "start")]));
}

// Whether the largest blur suits the measurement.
const verdict = (blur) => blur < 0.5 ? "too little to measure by: a wider aperture or a larger separation is needed"
  : blur < 3.5 ? "less than the best, 4 to 7 px: distances will be less exact"
  : blur <= 7.5 ? "good: 4 to 7 px are best"
  : blur <= 120 ? "more than the best, 4 to 7 px: pictures are shrunk first"
  : "more than the 120 px that can be measured";

// The figure with a slider that moves the point; `update(optics)` draws it again.
export function opticsFigure() {
  const place = h("div", {});
  const slider = h("input", {type: "range", id: "optics-point", min: 0, max: 1, step: "any", value: 0.5, onInput: () => draw()});
  const reading = h("output", {for: "optics-point"});
  const control = h("div", {class: "field"}, h("label", {for: "optics-point"}, "A point at ", reading), slider);
  const facts = h("p", {});
  const rows = h("tbody", {});
  const [firstName, secondName] = [0, 1].map(() => h("th", {class: "n"}));
  const table = h("details", {}, h("summary", {}, "The same in figures"),
    h("table", {}, h("thead", {},
      h("tr", {}, h("th", {}, "Distance"), firstName, secondName)), rows));
  let lens = null;
  function draw() {
    const from = Math.max(lens.focalLength * 1.02 + 1e-6, lens.nearFocus - 0.4 * lens.range);
    const to = lens.farFocus + 0.4 * lens.range;
    const u = from + (to - from) * Number(slider.value);
    replace(reading, `${number(u, 1)} mm`);
    slider.setAttribute("aria-valuetext", `${number(u, 1)} mm`);
    replace(place, lens.separation > 0 ? scene(lens, u, to) : null, chart(lens, u, [from, to]));
    [firstName, secondName].forEach((cell, k) => replace(cell, lens.names[k]));
    replace(facts, `Measures from ${number(lens.nearFocus, 2)} to ${number(lens.farFocus, 2)} mm. `
      + `Largest blur ${number(lens.largestBlur, 2)} px: ${verdict(lens.largestBlur)}.`);
    replace(rows, [0, 0.25, 0.5, 0.75, 1].map((part) => {
      const distance = lens.nearFocus + part * lens.range;
      const [near, far] = lens.blur(distance);
      return h("tr", {}, h("td", {}, `${number(distance, 1)} mm`), h("td", {class: "n"}, `${number(near)} px`),
        h("td", {class: "n"}, `${number(far)} px`));
    }));
  }
  const node = h("div", {class: "optics-figure"});
  return {
    node,
    update(optics) {
      try {
        lens = lensOf(optics);
        if (!(lens.range > 0 && Number.isFinite(lens.farFocus))) {
          throw new Error(lens.separation > 0 ? "Both sensors are focused at one distance: take a larger separation."
            : "The range must end at another distance than the focus: on which side says which is measured.");
        }
        if (!place.isConnected) replace(node, facts, place, control, table);
        draw();
      } catch (error) {
        lens = null;
        replace(node, h("p", {class: "note"}, error.message));
      }
      return lens;
    },
  };
}
