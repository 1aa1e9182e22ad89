// The result of an inspection: the parts on the picture and in a table, linked to each other, and the evidence for each.

import {h, replace, svg} from "./dom.js";
import {measure, measureText} from "./appearance.js";
import {number} from "./parts.js";
import {DEPTH_WARNINGS} from "./depth_map.js";
import {OBJECT_WARNINGS} from "./warnings.js";
import {mapped, overlaid, pixelOf} from "./workcell_form.js";

const WARNINGS = {
  no_region: "Nothing stands out from the background: check the threshold and whether objects are lighter or darker.",
  more_regions: "More stands out than “most objects” lets through: the largest are reported.",
  touching: "A region may be several parts that touch: move them apart, or take its pieces.",
  large_region: "The largest region may be the table itself: crop the picture to the table, or say whether objects are lighter or darker.",
  little_ground: "Hardly any background is to be seen, so its level is a guess: show more of it, or give a gray level as threshold.",
  textured_ground: "The ground's texture is nearly as strong as the parts: plainer ground, or more even light, shows fainter ones.",
  line_left_out: "A line across the picture was taken for a mark on the ground.",
  shadows_left_out: "Dark places beside the parts were taken for their shadows.",
  perhaps_shadow: "A part's dark side may be its shadow: light from several sides, or a coloured ground, tells them apart.",
  small_left_out: "Something nearly as large as the least area was left out: if it is a part, lower “least area”.",
  not_segmented: "The version was trained without segment, so its exemplars were normalised differently from the parts. "
    + "Train it with segment.",
  no_region_in_pair: "Nothing stands out in the near-focused picture, so that no part got its distance.",
};

const tenths = (value) => value === null || value === undefined ? "–" : value.toFixed(1);
const angle = (deg) => deg === null || deg === undefined ? "–" : `${tenths(deg)}°`;
// Rounded down: what isn't certain isn't called 100 %.
const percent = (part) => `${number(Math.floor(1000 * part) / 10, 1)} %`;
const named = (part) => part.decision?.label ?? "unknown";

// Box, axis, centroid and pose of a part. A pose turns counter-clockwise from the picture's right.
function drawing({region, decision, pose}, scale) {
  const [x, y] = region.centroid_px;
  const [left, top, width, height] = region.bbox_px;
  const reach = 0.62 * Math.max(width, height);
  const shapes = [["rect", {x: left - 0.5, y: top - 0.5, width, height}], ["circle", {cx: x, cy: y, r: 3 * scale}]];
  if (region.orientation_deg !== null) {
    const turn = region.orientation_deg * Math.PI / 180;
    const half = Math.sqrt(region.area_px * region.elongation / Math.PI); // of an ellipse: the longer half axis
    const [dx, dy] = [half * Math.cos(turn), half * Math.sin(turn)];
    shapes.push(["line", {x1: x - dx, y1: y - dy, x2: x + dx, y2: y + dy, class: "principal"}]);
  }
  if (pose) {
    const turn = -pose.turn_deg * Math.PI / 180;
    const at = (length, by) => `${x + length * Math.cos(turn + by)} ${y + length * Math.sin(turn + by)}`;
    shapes.push(["path", {d: `M${x} ${y}L${at(reach, 0)}M${at(reach * 0.8, -0.16)}L${at(reach, 0)}L${at(reach * 0.8, 0.16)}`,
      class: pose.reliable ? "pose" : "pose unsure"}]);
  }
  return svg("g", {class: `part ${decision ? "named" : "unnamed"}`},
    ["halo", ""].map((kind) => svg("g", {class: kind}, shapes.map(([tag, props]) => svg(tag, props)))),
    svg("rect", {x: left, y: top, width, height, class: "hit"}));
}

// The robot's axes from the middle of the picture, 100 mm long.
function axes(matrix, {naturalWidth: width, naturalHeight: height}) {
  const middle = [width / 2, height / 2];
  const robot = mapped(matrix, middle);
  const [[a, b, c], [d, e, f], [g, k, l]] = matrix;
  const inverse = [[e * l - f * k, c * k - b * l, b * f - c * e], [f * g - d * l, a * l - c * g, c * d - a * f],
    [d * k - e * g, b * g - a * k, a * e - b * d]];
  if (!robot) return null;
  return svg("g", {class: "axes"}, [["X", [robot[0] + 100, robot[1]]], ["Y", [robot[0], robot[1] + 100]]].map(([name, mm]) => {
    const [x, y] = mapped(inverse, mm);
    return [svg("line", {x1: middle[0], y1: middle[1], x2: x, y2: y}),
      svg("text", {x: x + (x - middle[0]) * 0.08, y: y + (y - middle[1]) * 0.08, "font-size": width / 32}, name)];
  }));
}

// The answer about a part, in sentences.
function sentences({decision, pose, distance_mm: distance, distance_sigma_mm: sigma, distance_coverage: coverage}) {
  const found = [];
  if (!decision) found.push("Unknown: don't treat it as a known part.");
  else found.push(decision.confidence === null ? "Named, without a confidence."
    : `Right with a chance of ${percent(decision.confidence)}.`);
  if (pose) {
    found.push(`Turned by ${angle(pose.turn_deg)} ± ${tenths(pose.sigma_deg)}°${pose.reliable ? "." : ": not reliable."}`);
    if (pose.alternative_deg !== undefined) found.push(`${angle(pose.alternative_deg)} would look the same.`);
  }
  if (distance !== null) {
    const plusMinus = sigma === null ? "" : ` ± ${tenths(sigma)} mm`;
    found.push(`${tenths(distance)} mm away${plusMinus}, by ${number(100 * coverage, 0)} % of its pixels.`);
  }
  return found;
}

// The evidence for a part: its crop, its candidates, and the warnings.
function reasons(part, image) {
  const [left, top, width, height] = part.region.bbox_px;
  const isAligned = (part.candidates[0]?.explained ?? null) !== null;
  const cut = h("canvas", {width, height, class: "cut", role: "img", "aria-label": `Part ${part.region.id}, cropped from the overview`});
  cut.getContext("2d").drawImage(image, left, top, width, height, 0, 0, width, height);
  return [
    h("h3", {}, `Part ${part.region.id}: `, named(part)),
    h("div", {class: "row top"}, cut, h("div", {},
      sentences(part).map((sentence) => h("p", {}, sentence)),
      h("p", {class: "muted"}, `${number(part.region.area_px, 0)} px, ${number(part.region.elongation, 2)} times as long as broad, `
        + `${part.region.darker ? "darker" : "lighter"} than the ground.`),
      part.region.touching ? h("p", {class: "note"}, `It may be ${part.region.pieces.length} parts that touch, at `
        + `${part.region.pieces.map(({centroid_px: [x, y]}) => `${number(x, 0)}, ${number(y, 0)}`).join(" and ")} px.`) : null)),
    part.warnings.map((word) => h("p", {class: "note"}, h("code", {}, word), " ", OBJECT_WARNINGS[word] ?? "")),
    part.candidates.length ? h("table", {}, h("caption", {class: "visually-hidden"}, "What it was compared with"),
      h("thead", {}, h("tr", {}, h("th", {}, "Like"),
        isAligned ? [h("th", {class: "n"}, "explained"), h("th", {class: "n"}, "accepted from")]
          : [h("th", {class: "n"}, "distance"), h("th", {class: "n"}, "accepted to")])),
      h("tbody", {}, part.candidates.map((candidate) => {
        const {value, limit} = measure(candidate);
        return h("tr", {}, h("td", {}, candidate.label),
          h("td", {class: "n"}, measureText(value, isAligned)), h("td", {class: "n"}, measureText(limit, isAligned)));
      }))) : null,
  ];
}

// What differs from the ground and is no part, in a sentence.
function leftOut({left_out: {small, small_areas_px: areas, least_area_px: least, lines, shadows}, ground}) {
  const found = [];
  if (small) found.push(`${small} below ${least} px, the largest of ${areas[0]}`);
  if (lines) found.push(`${lines} ${lines === 1 ? "line" : "lines"}`);
  if (shadows) found.push(`${shadows} ${shadows === 1 ? "shadow" : "shadows"}`);
  const contrast = ground ? `Parts differ from the ground by ${number(ground.offset, 1)} gray levels or more. ` : "";
  return contrast + (found.length ? `Left out: ${found.join("; ")}.` : "Nothing was left out.");
}

// `image` is the overview as a loaded <img>, `mapping` that of the workcell.
export function inspectionView(answer, image, mapping) {
  const {objects, width_px: width, height_px: height} = answer;
  const scale = width / 640;
  const why = h("div", {id: "part-why"});
  const pointed = h("output", {class: "muted"}, "Point at the picture to read the robot's millimetres.");
  const rows = new Map();
  const shapes = new Map();
  const tags = new Map();
  const each = (id) => [rows, shapes, tags].map((map) => map.get(id));
  const hover = (id, on) => each(id).forEach((node) => node.classList.toggle("hovered", on));
  let chosen = null;
  function choose(part) {
    if (chosen) each(chosen).forEach((node) => node.classList.remove("chosen"));
    chosen = part.region.id;
    each(chosen).forEach((node) => node.classList.add("chosen"));
    for (const [id, row] of rows) row.querySelector("button").setAttribute("aria-pressed", String(id === chosen));
    replace(why, reasons(part, image));
  }
  for (const part of objects) {
    const {id, bbox_px: [left, top]} = part.region;
    const both = {onMouseenter: () => hover(id, true), onMouseleave: () => hover(id, false), onClick: () => choose(part)};
    const shape = drawing(part, scale);
    for (const [event, doIt] of Object.entries(both)) shape.addEventListener(event.slice(2).toLowerCase(), doIt);
    shapes.set(id, shape);
    tags.set(id, h("span", {class: `tag ${part.decision ? "named" : "unnamed"}`,
      style: {left: `${Math.min(100 * left / width, 85)}%`, top: `${100 * top / height}%`}}, `${id} ${named(part)}`));
    const mm = part.robot_mm;
    rows.set(id, h("tr", both,
      h("td", {}, h("button", {type: "button", class: "quiet small", "aria-pressed": "false", "aria-label": `Part ${id}: ${named(part)}`,
        onFocus: () => hover(id, true), onBlur: () => hover(id, false)}, String(id))),
      h("td", {}, part.decision ? [h("strong", {}, part.decision.label),
        part.decision.confidence === null ? "" : ` ${percent(part.decision.confidence)}`]
          : h("span", {class: "state degraded"}, "unknown")),
      h("td", {class: "n"}, tenths(mm?.[0])), h("td", {class: "n"}, tenths(mm?.[1])), h("td", {class: "n"}, angle(part.robot_deg)),
      h("td", {class: "n"},
        part.pose ? [angle(part.pose.turn_deg), part.pose.reliable ? ` ± ${tenths(part.pose.sigma_deg)}°` : " unsure"] : "–"),
      h("td", {class: "n"}, part.distance_mm === null ? "–" : [tenths(part.distance_mm),
        part.distance_sigma_mm === null ? "" : ` ± ${tenths(part.distance_sigma_mm)}`])));
  }
  const picture = overlaid(image, axes(mapping.matrix, image), [...shapes.values()]);
  picture.id = "inspected";
  picture.append(...tags.values());
  picture.addEventListener("pointermove", (event) => {
    const [x, y] = pixelOf(event, picture, image);
    const mm = mapped(mapping.matrix, [x, y]);
    replace(pointed, `x ${number(x, 0)}, y ${number(y, 0)} px${mm ? ` is X ${number(mm[0], 1)}, Y ${number(mm[1], 1)} mm` : ""}`);
  });
  const known = objects.filter(({decision}) => decision).length;
  const strange = objects.length - known;
  if (objects.length) choose(objects.find(({decision}) => !decision) ?? objects[0]);
  return h("div", {id: "inspection"},
    h("p", {class: "answer", role: "status"}, h("strong", {}, objects.length ? `${known} named, ${strange} unknown` : "Nothing stands out"),
      `: ${answer.regions_found} regions in ${number(answer.timings_ms.total, 0)} ms, by ${answer.database} version ${answer.version}`,
      answer.calibration ? `, distances by ${answer.calibration}.` : "."),
    h("p", {class: "muted", id: "left-out"}, leftOut(answer)),
    answer.warnings.map((word) => h("p", {class: "note"}, h("code", {}, word), " ",
      WARNINGS[word] ?? DEPTH_WARNINGS[word.replace("depth_", "")] ?? "")),
    h("div", {class: "split"},
      h("div", {}, picture, h("p", {}, pointed),
        h("p", {class: "muted"},
          "Box and thin line: region and its principal axis. Arrow: pose, counter-clockwise from the picture's right; "
          + "dashed where it isn't reliable. X and Y: the robot's axes, 100 mm.")),
      h("div", {class: "scroll"}, why)),
    h("div", {class: "scroll"}, h("table", {id: "parts"},
      h("thead", {}, h("tr", {}, h("th", {}, "Part"), h("th", {}, "What"),
        ["X, mm", "Y, mm", "axis", "turned by", "distance, mm"].map((words) => h("th", {class: "n"}, words)))),
      h("tbody", {}, [...rows.values()]))));
}
