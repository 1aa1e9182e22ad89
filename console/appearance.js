// The evidence of an answer of kind `objects`: candidates by distance, the pose, the eigenimages, the reconstruction.

import {h, picture, replace, svg} from "./dom.js";
import {all, blobUrl, call} from "./api.js";
import {number, problem} from "./parts.js";

const SHOWN_EIGENIMAGES = 8;
const total = (candidate) => Math.hypot(candidate.distance_in_space, candidate.distance_from_space);

// What a candidate is judged by: the part of the object that is explained, or its total distance.
export function measure(candidate) {
  const {explained, least_explained: least, threshold} = candidate;
  if (explained === null || explained === undefined) {
    return {value: total(candidate), limit: threshold, is: threshold === null ? null : total(candidate) <= threshold};
  }
  return {value: explained, limit: least, is: least === null ? null : explained >= least};
}

// A measure as text: a part in percent, or a distance.
export const measureText = (value, isPart) =>
  isPart ? value === null ? "–" : `${number(100 * value, 0)} %` : number(value, 3);

// Each candidate's measure as a bar, with a mark where it would no longer be accepted.
export function candidates(answer) {
  if (!answer.candidates.length) return h("p", {}, "No object was compared: there is nothing in the frame to compare.");
  const [first] = answer.candidates;
  const isAligned = (first.explained ?? null) !== null;
  const measures = answer.candidates.map(measure);
  const longest = isAligned ? 1 : 1.06 * Math.max(...measures.flatMap(({value, limit}) => [value, limit ?? 0]), 1e-6);
  const hasMahalanobis = answer.candidates.some(({mahalanobis}) => mahalanobis !== undefined);
  const words = isAligned ? ["enough", "too little"] : ["near enough", "too far"];
  const shown = (value) => measureText(value, isAligned);
  const row = (candidate, place) => {
    const {value, limit, is} = measures[place];
    return h("tr", {},
      h("th", {scope: "row"}, candidate.label),
      h("td", {class: "bar-cell"},
        svg("svg", {viewBox: "0 0 100 10", preserveAspectRatio: "none", class: `hbar tone-${place + 1}`, "aria-hidden": "true"},
          svg("rect", {class: "track", width: 100, height: 10}), svg("rect", {width: 100 * value / longest, height: 10}),
          limit !== null && svg("line", {x1: 100 * limit / longest, x2: 100 * limit / longest, y1: 0, y2: 10}))),
      h("td", {class: "n"}, shown(value)),
      h("td", {class: "n"}, shown(limit)),
      h("td", {class: "name"}, is === null ? "–" : words[is ? 0 : 1]),
      h("td", {class: "n"}, number(candidate.distance_in_space, 3)),
      h("td", {class: "n"}, number(candidate.distance_from_space, 3)),
      hasMahalanobis && h("td", {class: "n"}, number(candidate.mahalanobis, 3)));
  };
  const judged = isAligned ? ["Explained", "Accepted from"] : ["Distance", "Accepted to"];
  const heads = ["Object", "", ...judged, "", "In space", "From space", ...(hasMahalanobis ? ["Mahalanobis"] : [])];
  const residual = first.distance_from_space;
  return [
    h("div", {class: "scroll", tabindex: "0", role: "region", "aria-label": "Candidates"}, h("table", {id: "try-candidates"},
      h("thead", {}, h("tr", {},
        heads.map((head, place) => h("th", {scope: "col", class: place > 1 && place !== 4 ? "n" : ""},
          head || h("span", {class: "visually-hidden"}, place === 1 ? "Bar" : "Verdict"))))),
      h("tbody", {}, answer.candidates.map(row)))),
    isAligned && h("p", {class: "muted"},
      "The bar is the part of the object that the frame shows once it is aligned; the mark on it is the least that is accepted. "
      + "The distances are between appearances, 0 for equal ones, √2 for nothing in common."),
    isAligned && alignment(answer),
    !isAligned && h("p", {class: "muted"},
      "The bar is the total distance √(in² + from²), 0 for equal pictures, √2 for nothing in common; "
      + "the mark on it is the farthest that is accepted. "
      + `What the eigenspace can't express of this frame as ${first.label}: ${number(residual, 3)}, `
      + `which is ${number(100 * residual ** 2)} % of the picture's energy.`),
  ];
}

// Where the object stands in the frame, in a sentence.
function alignment({alignment: found}) {
  if (!found) return null;
  const {shift_x_px: right, shift_y_px: down, scale, turn_deg: turn} = found;
  return h("p", {id: "try-alignment"},
    `Against its exemplars it stands ${number(Math.abs(right), 1)} px to the ${right < 0 ? "left" : "right"} and `
    + `${number(Math.abs(down), 1)} px ${down < 0 ? "up" : "down"}, ${number(scale, 2)} times as large, `
    + `turned by ${number(turn, 1)}° in the picture.`);
}

const CENTRE = 110;
const RADIUS = 82;
// 0° is at the top, and a turn goes clockwise as the dial is seen.
const at = (degrees, radius) => {
  const turn = degrees * Math.PI / 180;
  return [CENTRE + radius * Math.sin(turn), CENTRE - radius * Math.cos(turn)];
};

function hand(degrees, kind) {
  const [x, y] = at(degrees, RADIUS - 6);
  return svg("line", {class: `hand ${kind}`, x1: CENTRE, y1: CENTRE, x2: x, y2: y});
}

function sector(from, to) {
  const [a, b] = [at(from, RADIUS), at(to, RADIUS)];
  return svg("path", {class: "sigma",
    d: `M${CENTRE} ${CENTRE}L${a.join(" ")}A${RADIUS} ${RADIUS} 0 ${to - from > 180 ? 1 : 0} 1 ${b.join(" ")}Z`});
}

const apart = (a, b) => Math.abs((a - b + 540) % 360 - 180);

// The pose on a dial with a dot for each exemplar's pose, and the exemplar nearest to it.
export function pose(answer, {database, exemplar, signal}) {
  const {decision, pose: found} = answer;
  if (!decision) return null;
  if (!found) {
    return h("p", {}, `No pose: ${decision.label} has fewer than three views that differ in pose, looks the same from all sides, `
      + "or the version isn't calibrated.");
  }
  const {turn_deg, sigma_deg, reliable, alternative_deg} = found;
  const views = svg("g", {class: "views"});
  const other = alternative_deg === undefined ? "" : `, or by ${number(alternative_deg, 1)}°, which looks the same`;
  const title = `${decision.label} is turned by ${number(turn_deg, 1)}°, give or take ${number(sigma_deg, 1)}°${other}; `
    + (reliable ? "reliable" : "not reliable");
  const half = Math.min(sigma_deg, 179.9);
  const dial = picture(title, 2 * CENTRE, 2 * CENTRE,
    svg("circle", {class: "axis", cx: CENTRE, cy: CENTRE, r: RADIUS}), sector(turn_deg - half, turn_deg + half), views,
    [0, 90, 180, 270].map((degrees) => {
      const [x, y] = at(degrees, RADIUS + 16);
      return svg("text", {x, y: y + 4, "text-anchor": "middle"}, `${degrees}°`);
    }),
    alternative_deg === undefined ? null : hand(alternative_deg, "alternative"), hand(turn_deg, reliable ? "" : "unsure"));
  dial.id = "try-dial";
  const nearest = h("div", {});
  async function compare() {
    const exemplars = (await all(`v1/databases/${database}/exemplars?label=${encodeURIComponent(decision.label)}`, {most: 1000, signal}))
      .filter(({pose_deg}) => pose_deg !== null);
    if (signal.aborted || !exemplars.length) return;
    views.append(...exemplars.map(({pose_deg}) => { const [x, y] = at(pose_deg, RADIUS); return svg("circle", {cx: x, cy: y, r: 2.5}); }));
    const closest = exemplars.reduce((best, view) => apart(view.pose_deg, turn_deg) < apart(best.pose_deg, turn_deg) ? view : best);
    const shown = await exemplar(closest.id);
    replace(nearest, h("p", {class: "muted"}, "Dots are the poses of the exemplars."),
      shown && h("figure", {class: "whole"},
        h("div", {class: "annotated small"},
          h("img", {src: shown.src, alt: `The view of ${decision.label} at ${number(closest.pose_deg, 1)}°`})),
        h("figcaption", {}, `Nearest exemplar: ${number(closest.pose_deg, 1)}°`)));
  }
  compare().catch(() => {}); // the dial stands without them
  return h("div", {class: "turned"}, dial, h("div", {},
    h("p", {}, h("strong", {}, `${number(turn_deg, 1)}° ± ${number(sigma_deg, 1)}°`)),
    h("p", {}, reliable ? "Reliable: it may be acted on." : "Not reliable: don't act on it."),
    alternative_deg === undefined ? null : h("p", {}, `Or ${number(alternative_deg, 1)}°, which would look the same (dashed).`),
    nearest));
}

// The mean appearance and the first eigenimages, each with its share of the variance.
export function eigenimages(database, {version, report}, signal) {
  const place = h("div", {class: "thumbs eigen"});
  const kept = report.spectrum.slice(0, report.dimension).reduce((sum, variance) => sum + variance, 0);
  const whole = kept / report.energy_kept;
  async function load() {
    const which = ["mean", ...Array(Math.min(report.dimension, SHOWN_EIGENIMAGES)).keys()];
    const urls = await Promise.all(which.map((i) => blobUrl(`v1/databases/${database}/versions/${version}/eigenimages/${i}`, {signal})));
    signal.addEventListener("abort", () => urls.forEach(URL.revokeObjectURL));
    replace(place, urls.map((src, i) => h("figure", {},
      h("img", {src, alt: i ? `Eigenimage ${which[i]}` : "The mean appearance"}),
      h("figcaption", {}, i ? `${which[i]}: ${number(100 * report.spectrum[which[i]] / whole, 1)} %` : "Mean"))));
  }
  const details = h("details", {id: "try-eigenimages"}, h("summary", {}, "Eigenimages"),
    h("p", {class: "muted"},
      `The mean of all views, and the first of ${report.dimension} eigenimages (mid-gray is zero) with the part of the variance `
      + `each holds; together they hold ${number(100 * report.energy_kept, 1)} %.`), place);
  details.addEventListener("toggle", () => {
    if (details.open && !place.hasChildNodes()) load().catch((error) => error.name !== "AbortError" && replace(place, problem(error)));
  });
  return details;
}

// The service's drawing of the normalised picture, its reconstruction from eigenimages, and the residual.
export function reconstruction(database, {file, type, query, signal}) {
  const place = h("div", {id: "try-reconstruction"});
  async function load() {
    const drawn = await call("POST", `v1/databases/${database}/recognitions?${new URLSearchParams(query)}`,
      {body: file, type, accept: "image/png; view=reconstruction", signal});
    const residual = Number(drawn.headers.get("X-Distance-From-Space"));
    const src = URL.createObjectURL(await drawn.blob());
    signal.addEventListener("abort", () => URL.revokeObjectURL(src));
    replace(place, h("figure", {},
      h("img", {src, alt: "The normalised picture, its reconstruction from eigenimages, and the residual"}),
      h("figcaption", {}, "The normalised picture, its reconstruction from eigenimages, and the residual (mid-gray is zero). "
        + `Its length is ${number(residual, 3)}: ${number(100 * residual ** 2, 1)} % of the picture's energy `
        + "is not in the universal eigenspace.")));
  }
  load().catch((error) => error.name !== "AbortError" && replace(place, problem(error)));
  return place;
}
