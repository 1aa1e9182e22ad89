// #/versions/{name}/{n}: the training report of a version; #/versions/{name}/{n}/{other} compares two.
// Every function takes a list of one or two versions: a comparison is the same page with one more series.

import {h, replace, svg} from "./dom.js";
import {all, call, get, put} from "./api.js";
import {act, number, problem, remotePicture, time, toast, verdict} from "./parts.js";
import {download} from "./fields.js";
import {barChart, legend, lineChart, matrix, ring} from "./charts.js";

const EIGENIMAGES = 8;
const MATRIX_LABELS = 24;

const percent = (part) => part === null || part === undefined ? "–" : `${number(100 * part, 1)} %`;
const part = (some, whole) => whole ? some / whole : null;
const isObjects = (report) => "objects" in report;

// The quality of a version in a sentence.
export function headline(report) {
  if (isObjects(report)) {
    const held = report.held_out;
    if (!held) return "No object has two views: nothing could be held out to tell how good it is.";
    return `${held.known_right} of ${held.known} held-out views named right; `
      + `${held.unknown_refused} of ${held.unknown} unknown ones refused.`;
  }
  if (report.verdict) return [report.verdict.summary, report.verdict.remedy].filter(Boolean).join(". To do: ") + ".";
  const reliability = report.reliability;
  if (!reliability) return "Not calibrated: its answers have no confidence.";
  return `${percent(reliability.known_named)} of known frames named, ${percent(reliability.known_misnamed)} misnamed; `
    + `${percent(reliability.unknown_refused)} of unknown ones refused.`;
}

export async function show(main, [name, ...numbers], signal) {
  if (!numbers.length) return location.replace(`#/databases/${encodeURIComponent(name ?? "")}`);
  const path = `v1/databases/${encodeURIComponent(name)}`;
  const [detail, list, {items: jobs}, ...versions] = await Promise.all([
    get(path, {signal}), all(`${path}/versions`, {signal}), get(`v1/jobs?database=${encodeURIComponent(name)}&limit=500`, {signal}),
    ...numbers.slice(0, 2).map((number) => get(`${path}/versions/${encodeURIComponent(number)}`, {signal}))]);
  if (signal.aborted) return;
  const page = {name, path, signal, current: detail.current_version, badges: [], names: versions.map(({version}) => `version ${version}`)};
  const objects = detail.kind === "objects";
  replace(main,
    h("h1", {}, h("a", {href: `#/databases/${encodeURIComponent(name)}`}, name), ` ${page.names.join(" and ")}`),
    h("div", {class: "grid summaries"}, versions.map((version) => summary(page, version, jobs))),
    compareWith(page, list, versions),
    h("section", {class: "card"}, h("h2", {}, "Figures"), figureTable(page, versions)),
    h("div", {class: "grid charts"}, (objects ? objectCharts : landmarkCharts)(page, versions), spectrum(page, versions)),
    objects ? [rings(page, versions[0]), versions.map((version) => eigenimages(page, version))] : null,
    remarks(page, versions),
    h("section", {class: "card"}, h("h2", {}, "Options"), optionTable(page, versions)));
}

function summary(page, {version, created_at: at, digest, revision, counts, artifact_bytes: bytes, report}, jobs) {
  const place = h("div");
  const gates = jobs.filter((job) => job.version === version && job.comparison);
  const current = h("span", {});
  const draw = () => replace(current, page.current === version ? h("span", {class: "state current"}, "current")
    : act(page.current > version ? `Roll back to version ${version}` : `Make version ${version} current`, async () => {
      await put(`${page.path}/aliases/current`, {version});
      page.current = version;
      toast(`Version ${version} answers now.`);
      for (const badge of page.badges) badge();
    }, {place}));
  page.badges.push(draw);
  draw();
  return h("section", {class: "card", "aria-label": `Version ${version}`},
    h("p", {class: "row"}, h("strong", {}, `Version ${version}`), current),
    h("p", {class: "lead"}, headline(report)),
    (report.warnings ?? []).map((warning) => h("p", {class: "note"}, WARNINGS[warning] ?? warning)),
    gates.map(({comparison}) => h("p", {}, "Gate: ", verdict(comparison), gate(comparison))),
    h("p", {class: "muted"}, "Trained ", time(at), ` of ${counts.exemplars} exemplars of ${counts.labels} labels`,
      counts.interest_points ? `, ${counts.interest_points.toLocaleString("en")} interest points` : "",
      `, algorithm revision ${revision}.`),
    h("p", {class: "muted"}, "Digest ", h("code", {class: "digest"}, digest)),
    h("div", {class: "row"},
      act(`Download the artifact (${number(bytes / 1e6, 1)} MB)`, () => save(page, version), {kind: "quiet", place}),
      h("a", {href: `#/try/${encodeURIComponent(page.name)}`}, "Try it")), place);
}

const WARNINGS = {
  not_checked: "Not checked yet: the version serves, and is still to be asked about its own pictures.",
  not_calibrated: "Not calibrated: no exemplar was recognised in its synthetic views, so answers have no confidence. "
    + "More exemplars a label, or larger pictures, help most.",
};

// Which version was right on the frames on which they differ: the input of the sign test.
function gate({against_version: against, candidate_only: candidate, current_only: current}) {
  if (against === null || !(candidate + current)) return null;
  const share = 200 * candidate / (candidate + current);
  return h("span", {class: "gate"},
    svg("svg", {viewBox: "0 0 200 14", width: 200, height: 14, role: "img",
      "aria-label": `Of the frames on which they differ, this version alone was right on ${candidate}, `
        + `version ${against} alone on ${current}`},
      svg("rect", {class: "series-1 block", width: share, height: 14}),
      svg("rect", {class: "series-2 block", x: share, width: 200 - share, height: 14})),
    h("span", {class: "muted"}, ` it alone right: ${candidate} · version ${against} alone right: ${current}`));
}

// A link can't fetch it, because it sends no key.
async function save(page, version) {
  const artifact = await call("GET", `${page.path}/versions/${version}/artifact`, {signal: page.signal});
  download(await artifact.blob(), `${page.name}-${version}.safetensors`);
}

function compareWith(page, list, versions) {
  const others = list.map(({version}) => version).filter((version) => version !== versions[0].version).reverse();
  if (!others.length) return null;
  const address = (other) => `#/versions/${encodeURIComponent(page.name)}/${versions[0].version}${other ? `/${other}` : ""}`;
  return h("div", {class: "card row"}, h("label", {for: "other"}, `Compare version ${versions[0].version} with`),
    h("select", {id: "other", onChange: (event) => { location.hash = address(event.target.value); }},
      h("option", {value: ""}, "none"),
      others.map((other) => h("option", {value: other, selected: versions[1]?.version === other},
        `version ${other}${other === page.current ? " (current)" : ""}`))));
}

// Figures ---------------------------------------------------------------------------------------------------------

// The figures of a report: [name, value of a report, format].
const FIGURES = {
  landmarks: [
    ["Known frames named right", (report) => report.reliability?.known_named, percent],
    ["Known frames misnamed", (report) => report.reliability?.known_misnamed, percent],
    ["Unknown frames refused", (report) => report.reliability?.unknown_refused, percent],
    ["Synthetic views recognised", (report) => report.reliability && report.reliability.known + report.reliability.unknown, number],
    ["Confidence below which nothing is decided", (report) => report.reliability?.threshold, number],
    ["Exemplars without interest points", (report) => report.exemplars_without_points.length, number],
    ["Components of a signature", (report) => report.signature_length, number],
  ],
  objects: [
    ["Held-out views named right", ({held_out: held}) => held && part(held.known_right, held.known), percent],
    ["Held-out views refused", ({held_out: held}) => held && part(held.known - held.known_accepted, held.known), percent],
    ["Held-out views misnamed", ({held_out: held}) => held && part(held.known_accepted - held.known_right, held.known), percent],
    ["Unknown views refused", ({held_out: held}) => held && part(held.unknown_refused, held.unknown), percent],
    ["Views held out", ({held_out: held}) => held?.known, number],
    ["Poses within 5°", ({objects}) => poses(objects, (pose) => pose.within_5_deg), percent],
    ["Mean pose error (°)", ({objects}) => poses(objects, (pose) => pose.mean_deg * pose.trials), number],
    ["Width of a picture (px)", (report) => report.width_px, number],
    ["Height of a picture (px)", (report) => report.height_px, number],
  ],
  both: [
    ["Dimensions kept", (report) => report.dimension, number],
    ["Variance kept", (report) => report.energy_kept, percent],
  ],
  time: [
    ["Describing the exemplars (ms)", (report) => report.timings_ms?.describe, (value) => number(value, 0)],
    ["Eigenspace and artifact (ms)", (report) => report.timings_ms?.eigenspace, (value) => number(value, 0)],
    ["Recognising synthetic views (ms)", (report) => report.timings_ms?.rehearsal, (value) => number(value, 0)],
  ],
};

// Over all objects, the mean of what `of` gives for all trials of one.
function poses(objects, of) {
  const withPose = objects.filter((object) => object.pose);
  return part(withPose.reduce((sum, {pose}) => sum + of(pose), 0), withPose.reduce((sum, {pose}) => sum + pose.trials, 0));
}

function figureTable(page, versions) {
  const kind = isObjects(versions[0].report) ? "objects" : "landmarks";
  const rows = [...FIGURES[kind], ...FIGURES.both, ...FIGURES.time];
  const isNews = (values, row) => differ(values) && !FIGURES.time.includes(row);
  return h("div", {class: "scroll", tabindex: "0", role: "region", "aria-label": "Figures"}, h("table", {class: "figures"},
    h("thead", {}, h("tr", {}, h("th", {scope: "col"}, "Figure"), page.names.map((name) => h("th", {scope: "col", class: "n"}, name)))),
    h("tbody", {}, rows.map((row) => {
      const [what, of, write] = row;
      const values = versions.map(({report}) => of(report) ?? null);
      if (values.every((value) => value === null)) return null;
      return h("tr", {class: isNews(values, row) ? "differs" : null}, h("th", {scope: "row"}, what),
        values.map((value) => h("td", {class: "n"}, write(value))));
    }))));
}

const differ = (values) => values.length > 1 && JSON.stringify(values[0]) !== JSON.stringify(values[1]);

function optionTable(page, versions) {
  const names = [...new Set(versions.flatMap(({options}) => Object.keys(options)))];
  const values = (name) => versions.map(({options}) => options[name]);
  const unlike = names.filter((name) => differ(values(name)));
  const table = (some) => h("div", {class: "scroll", tabindex: "0", role: "region", "aria-label": "Options"}, h("table", {},
    h("thead", {}, h("tr", {}, h("th", {scope: "col"}, "Option"), page.names.map((name) => h("th", {scope: "col"}, name)))),
    h("tbody", {}, some.map((name) => h("tr", {}, h("th", {scope: "row"}, h("code", {}, name)),
      values(name).map((value) => h("td", {}, h("code", {}, JSON.stringify(value) ?? "–"))))))));
  if (versions.length < 2) return table(names);
  return [unlike.length ? table(unlike) : h("p", {}, "Both were trained with the same options: the exemplars differ, or the algorithm."),
    h("details", {}, h("summary", {}, "The options they share"), table(names.filter((name) => !unlike.includes(name))))];
}

// Charts ----------------------------------------------------------------------------------------------------------

function chart(page, title, text, drawn, figures) {
  return h("section", {class: "card"}, h("h2", {}, title), legend(page.names), drawn, h("p", {class: "muted"}, text),
    figures && h("details", {}, h("summary", {}, "As figures"), figures));
}

// Figures of a chart, a table for each version.
const tables = (page, heads, rows) => rows.map((lines, index) => {
  const cell = (value) => h("td", {class: "n"}, typeof value === "number" ? number(value, 4) : value);
  const label = `${heads.join(", ")}: ${page.names[index]}`;
  return h("div", {class: "scroll tall", tabindex: "0", role: "region", "aria-label": label}, h("table", {},
    h("thead", {}, h("tr", {}, heads.map((head) => h("th", {scope: "col", class: "n"}, head)))),
    h("tbody", {}, lines.map((line) => h("tr", {}, line.map(cell))))));
});

function spectrum(page, versions) {
  const lines = versions.map(({report}, index) => ({
    name: page.names[index], mark: report.dimension, dots: report.spectrum.length < 20,
    points: report.spectrum.map((variance, direction) => [direction + 1, variance])
      .filter(([, variance]) => variance > report.spectrum[0] * 1e-6),
  }));
  const found = versions.map(({report}, index) =>
    `${page.names[index]} keeps ${report.dimension} dimensions with ${percent(report.energy_kept)} of the variance`).join("; ");
  return chart(page, "Spectrum", `${found[0].toUpperCase()}${found.slice(1)} (dotted line).`,
    lineChart({title: `Spectrum: ${found}`, x: {label: "direction", from: 1, whole: true}, y: {label: "variance", log: true}, lines}),
    tables(page, ["Direction", "Variance"],
      versions.map(({report}) => report.spectrum.slice(0, 50)
        .map((variance, index) => [index + 1, variance < 1e-3 ? variance.toExponential(2) : variance]))));
}

function landmarkCharts(page, versions) {
  const reliabilities = versions.map(({report}) => report.reliability);
  if (reliabilities.every((each) => !each)) {
    return h("section", {class: "card"}, h("h2", {}, "Reliability"), h("p", {},
      versions.some(({report}) => report.verdict) ? "The number of false alarms decides: the verdict above is of its own pictures."
        : "Unknown: the version isn't calibrated."));
  }
  const lines = reliabilities.map((each, index) => ({name: page.names[index], dots: true, mark: each?.threshold,
    points: (each?.curve ?? []).map((bin) => [bin.confidence, bin.right, bin.answers])}));
  const thresholds = reliabilities.map((each) => each ? number(each.threshold) : "–").join(", ");
  return [
    chart(page, "Reliability",
      "Each dot is answers of about one confidence, its area their number. On the diagonal, confidence is the part that was right; "
      + `above it, confidence is too low. Below the dotted line (${thresholds}) the decision is null.`,
      lineChart({title: reliabilityFinding(page, reliabilities), diagonal: true, lines,
        x: {label: "confidence", from: 0, to: 1}, y: {label: "part that was right", from: 0, to: 1}}),
      tables(page, ["Confidence", "Answers", "Right"],
        reliabilities.map((each) => (each?.curve ?? []).map((bin) => [bin.confidence, bin.answers, percent(bin.right)])))),
    h("section", {class: "card"}, h("h2", {}, "Decisions on the synthetic views"), shares(page, reliabilities),
      h("p", {class: "muted"},
        "Exemplars turned, moved, on another background and partly hidden; and again with their label left out, "
        + "when the right answer is null."))];
}

function reliabilityFinding(page, reliabilities) {
  return `Reliability: ${reliabilities.map((each, index) => {
    if (!each) return `${page.names[index]} isn't calibrated`;
    const answers = each.curve.reduce((sum, bin) => sum + bin.answers, 0);
    const off = each.curve.reduce((sum, bin) => sum + bin.answers * Math.abs(bin.right - bin.confidence), 0) / answers;
    return `${page.names[index]}'s confidence is off by ${number(off)} on average`;
  }).join("; ")}`;
}

// Of the known and the unknown views, how many were named right, wrongly, and not at all.
function shares(page, reliabilities) {
  const rows = reliabilities.flatMap((each, index) => each ? [
    [`${page.names[index]}, ${each.known} known`,
      [["right", each.known_named], ["wrong", each.known_misnamed], ["null", 1 - each.known_named - each.known_misnamed]]],
    [`${page.names[index]}, ${each.unknown} unknown`, [["right", each.unknown_refused], ["wrong", 1 - each.unknown_refused]]]] : []);
  const says = {right: "right", wrong: "wrong", null: "no decision"};
  return h("div", {}, rows.map(([name, parts]) => {
    let from = 0;
    const text = parts.map(([word, share]) => `${percent(share)} ${says[word]}`).join(", ");
    return h("div", {class: "share"}, h("p", {}, h("strong", {}, name), `: ${text}`),
      svg("svg", {viewBox: "0 0 100 4", preserveAspectRatio: "none", role: "img", "aria-label": `${name}: ${text}`},
        parts.map(([word, share]) => {
          const x = from;
          from += 100 * share;
          return svg("rect", {class: `share-${word}`, x, width: Math.max(0, 100 * share), height: 4});
        })));
  }));
}

function objectCharts(page, versions) {
  const reports = versions.map(({report}) => report);
  return [rateChart(page, reports), poseChart(page, reports), versions.map((version, index) => confusion(page, version, index))];
}

function rateChart(page, reports) {
  if (reports.every((report) => !report.rate_by_dimension.length)) return null;
  const lines = reports.map((report, index) =>
    ({name: page.names[index], mark: report.dimension, dots: true,
      points: report.rate_by_dimension.map(({dimension, right, trials}) => [dimension, part(right, trials) ?? 0])}));
  const best = reports.map((report, index) => {
    const at = report.rate_by_dimension.filter(({dimension}) => dimension <= report.dimension).at(-1);
    return at ? `${page.names[index]}: ${at.right} of ${at.trials} at ${report.dimension} dimensions` : `${page.names[index]}: unknown`;
  }).join("; ");
  return chart(page, "Rate against dimension", `Held-out views whose nearest eigenpoint is of their own object. ${best}.`,
    lineChart({title: `Rate against dimension: ${best}`, x: {label: "dimension", from: 0, whole: true},
      y: {label: "part recognised", from: 0, to: 1}, lines}),
    tables(page, ["Dimension", "Right", "Of"],
      reports.map((report) => report.rate_by_dimension.map(({dimension, right, trials}) => [dimension, right, trials]))));
}

function poseChart(page, reports) {
  const labels = [...new Set(reports.flatMap((report) => report.objects.filter((object) => object.pose).map((object) => object.label)))];
  if (!labels.length) {
    return h("section", {class: "card"}, h("h2", {}, "Pose error"), h("p", {}, "Unknown: no object has enough views with a pose."));
  }
  const bar = (report, label) => {
    const pose = report.objects.find((object) => object.label === label)?.pose;
    return pose && {middle: pose.median_deg, far: pose.p95_deg};
  };
  const rows = labels.map((label) => ({name: label, bars: reports.map((report) => bar(report, label))}));
  const worst = rows.reduce((a, b) => (b.bars[0]?.far ?? 0) > (a.bars[0]?.far ?? 0) ? b : a);
  return chart(page, "Pose error",
    "A bar holds 95 % of an object's held-out views, the stroke is their median. "
    + "The gap around a held-out view is twice that around a picture to recognise.",
    barChart({title: `Pose error by object: the worst is ${worst.name}, 95 % within ${number(worst.bars[0]?.far)}°`,
      label: "error in degrees", rows}),
    tables(page, ["Object", "Views", "Mean °", "Median °", "95 % °", "Within 5°"],
      reports.map((report) => report.objects.map(({label, pose}) => pose
        ? [label, pose.trials, pose.mean_deg, pose.median_deg, pose.p95_deg, pose.within_5_deg] : [label, "–", "–", "–", "–", "–"]))));
}

const NONE = "none";

// The report lists what went wrong; what is left of an object's views went right.
function confusion(page, {report}, index) {
  if (!report.held_out) return h("section", {class: "card"}, h("h2", {}, "Confusion"),
    h("p", {}, "Unknown: no object has two views, so that none could be held out. Add more views of each."));
  const counts = new Map();
  const add = (shown, named, times) => { if (!counts.has(shown)) counts.set(shown, new Map()); counts.get(shown).set(named, times); };
  for (const {label, views} of report.objects) if (views >= 2) add(label, label, views);
  for (const {shown, named, times} of report.confusion) {
    add(shown, named ?? NONE, times);
    add(shown, shown, Math.max(0, (counts.get(shown).get(shown) ?? 0) - times));
  }
  const wrong = report.confusion.reduce((sum, {times}) => sum + times, 0);
  let labels = [...counts.keys()];
  const many = labels.length > MATRIX_LABELS;
  if (many) {
    const confused = (label) => report.confusion.some(({shown, named}) => shown === label || named === label);
    labels = labels.filter(confused).slice(0, MATRIX_LABELS);
  }
  const found = wrong
    ? `${wrong} held-out views were not named right, most often ${report.confusion.reduce((a, b) => b.times > a.times ? b : a).shown}`
    : "every held-out view was named right";
  const title = page.names.length > 1 ? `Confusion, ${page.names[index]}` : "Confusion";
  return h("section", {class: "card"}, h("h2", {}, title),
    labels.length > 0 && matrix({title: `${title}: ${found}`, rows: labels, columns: [...labels, NONE], counts}),
    h("p", {class: "muted"}, `Rows are shown, columns named; ${found}.${many ? " Only objects that were confused are drawn." : ""}`),
    wrong > 0 && h("details", {}, h("summary", {}, "As figures"), h("div", {class: "scroll"}, h("table", {},
      h("thead", {}, h("tr", {}, h("th", {scope: "col"}, "Shown"), h("th", {scope: "col"}, "Named"),
        h("th", {scope: "col", class: "n"}, "Times"))),
      h("tbody", {}, report.confusion.map(({shown, named, times}) => h("tr", {}, h("td", {}, shown), h("td", {}, named ?? NONE),
        h("td", {class: "n"}, times))))))));
}

// The known poses of each object: gaps by the report, ticks by the exemplars as they are now.
function rings(page, {version, report}) {
  const turned = report.objects.filter((object) => object.views_with_pose);
  const place = h("div", {class: "rings"});
  // A key that may only recognise sees the gaps all the same.
  all(`${page.path}/exemplars`, {signal: page.signal}).catch((error) => { if (error.status === 403) return []; throw error; })
    .then((exemplars) => {
      replace(place, turned.map(({label, gaps, views_with_pose: views}) => {
        const poses = exemplars.filter((exemplar) => exemplar.label === label && exemplar.pose_deg !== null)
          .map((exemplar) => exemplar.pose_deg);
        const found = gaps.length ? `gaps ${gaps.map(({from_deg: from, to_deg: to}) => `${number(from)}° to ${number(to)}°`).join(", ")}`
          : "no gaps";
        return h("figure", {}, ring({title: `${label}: ${views} views with a pose, ${found}`, poses, gaps}),
          h("figcaption", {}, h("strong", {}, label), ` ${views} views`, h("br", {}), found));
      }));
    }).catch((error) => { if (error.name !== "AbortError") replace(place, problem(error)); });
  return h("section", {class: "card"}, h("h2", {}, `Poses known, version ${version}`),
    turned.length ? [h("p", {class: "muted"},
      "The turntable from above. In a gap the pose isn't reliable: add views there. Ticks are the exemplars as they are now."), place]
      : h("p", {}, "No exemplar has a pose: the version names objects without one. "
        + "Send pose_deg with the exemplars, or names that end in __<degrees>."));
}

function eigenimages(page, {version, report}) {
  const of = (word, text) => h("figure", {}, remotePicture(`${page.path}/versions/${version}/eigenimages/${word}`, text, page.signal),
    h("figcaption", {}, text));
  return h("section", {class: "card"}, h("h2", {}, `Eigenimages, version ${version}`),
    h("p", {class: "muted"},
      "The mean of all views, and the directions in which they differ most, with the part of the variance each holds."),
    h("div", {class: "thumbs eigenimages"}, of("mean", "mean"),
      Array.from({length: Math.min(EIGENIMAGES, report.dimension)},
        (_, index) => of(index, `${index}: ${percent(shareOf(report, index))}`))));
}

// `energy_kept` is what the kept directions hold together.
function shareOf({spectrum, dimension, energy_kept: kept}, index) {
  const sum = spectrum.slice(0, dimension).reduce((a, b) => a + b, 0);
  return kept * spectrum[index] / sum;
}

// Remarks ---------------------------------------------------------------------------------------------------------

const REMARKS = {
  exemplars_without_points: "no interest points: they can't be recognised",
  near_duplicates: "all but the same picture: one of a pair is enough",
  repeated_poses: "one pose of one object twice: their mean is taken",
  over_exposed: "too many pixels as bright as can be",
  under_exposed: "hardly a bright pixel",
  blank: "black, or nothing stands out: left out",
  resized: "of another size, and scaled",
  touches_border: "the object reaches the border, which may cut it",
  several_regions: "another thing is nearly as large: the largest was taken",
};

// Remarks of the report on single exemplars, with their pictures.
function remarks(page, versions) {
  const found = versions.flatMap(({version, report}) => Object.entries(REMARKS).filter(([key]) => report[key]?.length)
    .map(([key, text]) => ({version, key, text, ids: report[key]})));
  if (!found.length) return null;
  return h("section", {class: "card"}, h("h2", {}, "Remarks on exemplars"), found.map(({version, key, text, ids}) => h("details", {},
    h("summary", {}, versions.length > 1 ? `Version ${version}, ` : "", `${key.replaceAll("_", " ")}, ${ids.length}: ${text}`),
    h("div", {class: "thumbs"},
      ids.slice(0, 24).map((id) => h("span", {class: "row"},
        [id].flat().map((one) => remotePicture(`${page.path}/exemplars/${one}/image`, `Exemplar ${one}`, page.signal))))),
    ids.length > 24 && h("p", {class: "muted"}, `and ${ids.length - 24} more`))));
}
