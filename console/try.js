// #/try[/{name}]: recognises one frame, and shows the evidence for the answer.

import {h, picture, replace, svg} from "./dom.js";
import {all, call, get, key} from "./api.js";
import {download} from "./fields.js";
import {act, number, pictures, problem, toast} from "./parts.js";
import {evidence, exemplarPictures, loaded, annotatedFrame, confidenceText, tones} from "./frame_view.js";
import {candidates, eigenimages, pose, reconstruction} from "./appearance.js";
import {OBJECT_WARNINGS} from "./warnings.js";
import {cameraChoice} from "./cameras.js";
import {landmarkWords} from "./map_pose.js";
import {beliefCard, tracking} from "./tracking.js";
import {requests} from "./code.js";

const OFFERED = 12; // exemplars at a time
const FEW_POINTS = 8;

// The last frame: recognised again when another database or version is chosen, and kept while other pages are shown.
let frame = null;
let chosen = null; // the database that recognised it
let camera = ""; // the name of what took it

// The texts of warnings about places.
const WARNINGS = {
  no_interest_points: () => "No interest points were found: the frame is flat, dark or out of focus.",
  too_few_points: ({points_used}) => `Only ${points_used} interest points voted; fewer than ${FEW_POINTS} make an unsure vote.`,
  votes_on_background: () => "Most points speak for nothing known: they lie on the background, or on something the database wasn't taught.",
  close_second: () => "Another label has nearly the same evidence: compare the votes.",
  gray_frame: () => "The frame is gray, but the version was trained in colour: signatures differ.",
};
const inWords = (code, answer) => answer.kind === "objects" ? OBJECT_WARNINGS[code] : WARNINGS[code]?.(answer);

const TYPES = {png: "image/png", pgm: "image/x-portable-graymap", ppm: "image/x-portable-pixmap"};
const ENDINGS = {"image/png": "png", "image/jpeg": "jpg", "image/x-portable-graymap": "pgm"};
const mediaType = (file) => file.type || TYPES[file.name.split(".").pop().toLowerCase()] || "image/jpeg";

export async function show(main, [wanted], signal) {
  const databases = await all("v1/databases", {signal});
  if (signal.aborted) return;
  if (!databases.length && !wanted) {
    return replace(main, h("h1", {}, "Try it"), h("p", {}, "There is no database yet. ", h("a", {href: "#/"}, "Make one on the overview"),
      ", give it pictures and train it; then ask it about a frame here."));
  }
  const ready = await get("readyz", {signal}).catch(() => null);
  if (signal.aborted) return;
  const trained = new Set(ready?.databases.filter(({version}) => version).map(({database}) => database));
  const first = wanted
    ?? (databases.find(({name}) => name === chosen) ?? databases.find(({name}) => trained.has(name)) ?? databases[0]).name;
  const names = databases.some(({name}) => name === first) ? databases.map(({name}) => name) : [first, ...databases.map(({name}) => name)];

  const asking = h("div", {id: "try-asking"});
  const answer = h("div", {id: "try-answer"});
  const status = h("p", {id: "try-status", class: "visually-hidden", role: "status"});
  const select = h("select", {id: "try-database", onChange: () => choose(select.value)},
    names.map((name) => h("option", {value: name, selected: name === first}, name)));
  replace(main, h("div", {class: "try"}, h("h1", {}, "Try it"), status,
    h("section", {class: "card", "aria-label": "What to ask"},
      h("div", {class: "fields"}, h("div", {}, h("label", {for: "try-database"}, "Database"), select), h("div", {id: "try-version-field"}),
        h("div", {id: "try-camera-field"})),
      asking),
    answer));

  let leaving = new AbortController();
  async function choose(name) {
    leaving.abort();
    leaving = new AbortController();
    chosen = name;
    const left = AbortSignal.any([signal, leaving.signal]);
    history.replaceState(null, "", `#/try/${encodeURIComponent(name)}`);
    replace(answer);
    try {
      await askOf(name, left);
    } catch (error) {
      if (!left.aborted) replace(asking, problem(error));
    }
  }

  async function askOf(name, left) {
    const path = `v1/databases/${encodeURIComponent(name)}`;
    const [database, versions] = await Promise.all([get(path, {signal: left}), all(`${path}/versions`, {signal: left})]);
    if (left.aborted) return;
    const field = main.querySelector("#try-version-field");
    const cameraField = main.querySelector("#try-camera-field");
    replace(cameraField);
    if (!versions.length) {
      replace(field);
      replace(asking, h("p", {class: "note"}, "This database isn't trained yet: ",
        h("a", {href: `#/databases/${encodeURIComponent(name)}`}, "give it pictures and train it"), ", then ask it here."));
      return;
    }
    const again = () => frame && ask(frame);
    const isOfPlaces = database.kind === "landmarks";
    const track = isOfPlaces ? tracking({name, path, onChanged: again, signal: left}) : null;
    const cameras = isOfPlaces ? cameraChoice({chosen: camera, signal: left, onChosen(name) { camera = name; again(); }}) : null;
    await cameras?.ready.catch((error) => { if (left.aborted) throw error; });
    if (left.aborted) return;
    replace(cameraField, cameras?.field);
    const asked = {database, path, versions, exemplar: exemplarPictures(encodeURIComponent(name), left), left, track, cameras};
    const version = h("select", {id: "try-version", onChange: again},
      database.aliases.toSorted((a, b) => (b.alias === "current") - (a.alias === "current"))
        .map(({alias, version}) => h("option", {value: `alias ${alias}`}, `${alias} (version ${version})`)),
      versions.toReversed().map(({version}) => h("option", {value: `version ${version}`}, `version ${version}`)));
    replace(field, h("label", {for: "try-version"}, "Version"), version);
    const ask = (file) => askAbout(file, asked, version.value.split(" "));
    replace(asking, cameras?.details, track?.node,
      pictures({label: "Drop a frame here, or paste one", onPictures: ([{file}]) => ask(file)}),
      exemplarChoice(asked, ask));
    document.addEventListener("paste", (event) => {
      const file = [...event.clipboardData.files].find(({type}) => type.startsWith("image/"));
      if (file) ask(file);
    }, {signal: left});
    if (frame) ask(frame);
  }

  let earlier = new AbortController();
  async function askAbout(file, asked, [way, which]) {
    earlier.abort();
    earlier = new AbortController();
    const now = AbortSignal.any([asked.left, earlier.signal]);
    frame = file;
    const evidence = {explain: true, ...asked.cameras?.value() ? {camera: asked.cameras.value()} : {}};
    const query = {...(way === "alias" && which === "current" ? {} : {[way]: way === "version" ? Number(which) : which}), ...evidence};
    answer.setAttribute("aria-busy", "true");
    status.textContent = "Asking…";
    if (!answer.hasChildNodes()) replace(answer, h("p", {class: "muted"}, "Asking…"));
    try {
      const began = performance.now();
      if (asked.track?.isOn() && way === "version") throw new Error("A track is answered by an alias: choose one instead of a version.");
      const {reply, ...sent} = asked.track?.isOn() ? await asked.track.send(file, mediaType(file), which, evidence, now)
        : {target: "recognitions", query, reply: await call("POST", `${asked.path}/recognitions?${new URLSearchParams(query)}`,
          {body: file, type: mediaType(file), signal: now})};
      const body = await reply.json();
      const roundTrip = performance.now() - began;
      const image = await loaded(file, `The frame ${file.name}`, now).catch(() => null);
      if (now.aborted) return;
      const where = body.kind === "landmarks" && "pose" in body && await import("./where.js");
      if (now.aborted) return;
      draw(body, {...asked, image, file, query, sent, roundTrip, signal: now}, where);
    } catch (error) {
      if (now.aborted) return;
      replace(answer, problem(error));
      status.textContent = error.message;
    } finally {
      answer.removeAttribute("aria-busy");
    }
  }

  // `where` shows the answer's pose, if it has one.
  function draw(body, context, where) {
    const version = context.versions.find(({version}) => version === body.version);
    const parts = (body.kind === "landmarks" ? landmarks : objects)(body, {...context, version});
    replace(answer,
      h("div", {class: "answered"},
        h("section", {class: "card verdict"}, verdict(body, version)),
        h("section", {class: "card frame", "aria-label": "The frame"},
          parts.frame ?? h("p", {}, `The browser can't show ${context.file.name}; the service has read it.`)),
        h("div", {class: "beside"}, body.track ? beliefCard(body) : null, parts.beside)),
      where && where.whereCard(body, context),
      parts.below,
      provenance(body, context),
      h("section", {class: "card"}, h("h2", {}, "The same request"),
        requests({database: body.database, ...context.sent, file: context.file.name, type: mediaType(context.file),
          hasKey: Boolean(key())})));
    parts.ready?.();
    status.textContent = body.decision ? `Recognised: ${body.decision.label}` : "Unknown: nothing is decided";
    if (answer.getBoundingClientRect().top > window.innerHeight * 0.6) answer.scrollIntoView();
  }

  await choose(first);
}

// Some of the database's own exemplars as frames to recognise, of as many labels as there are.
function exemplarChoice({database, path, exemplar, left}, ask) {
  const place = h("div", {class: "thumbs offered"});
  let items = null;
  let shown = 0;
  const more = act("Show more", () => offer(), {kind: "quiet", hidden: true});
  place.append(more);
  async function offer() {
    items ??= interleaved((await get(`${path}/exemplars?limit=200`, {signal: left})).items);
    const some = items.slice(shown, shown + OFFERED);
    shown += some.length;
    more.hidden = shown >= items.length;
    if (!items.length) replace(place, h("p", {class: "muted"}, "The database has no exemplars any more."));
    for (const {id, label, pose_deg, media_type} of some) {
      const words = pose_deg === null ? label : `${label} ${number(pose_deg, 1)}°`;
      const button = act(h("span", {}, words), async () => {
        const blob = await (await call("GET", `${path}/exemplars/${id}/image`, {signal: left})).blob();
        await ask(new File([blob], `${label}.${ENDINGS[media_type] ?? "ppm"}`, {type: media_type}));
      }, {kind: "quiet offer", "aria-label": `Ask about the exemplar ${words}`});
      more.before(button);
      exemplar(id).then((image) => image && button.prepend(h("img", {src: image.src, alt: ""})));
    }
  }
  const details = h("details", {id: "try-exemplars"}, h("summary", {}, `Or ask about one of its own ${database.exemplars} exemplars`),
    h("p", {class: "muted"}, "It was trained with them, so it should know them: a check that all works, not of how good it is."), place);
  details.addEventListener("toggle", () => {
    if (!details.open || items) return;
    offer().catch((error) => {
      if (left.aborted) return;
      replace(place, error.status === 403
        ? h("p", {class: "muted"}, "Your key may recognise, but not read exemplars.") : problem(error));
    });
  });
  details.open = !frame;
  return details;
}

// Round robin over the labels: the first of each, then the second of each.
function interleaved(items) {
  const counts = new Map();
  const round = items.map(({label}) => {
    counts.set(label, (counts.get(label) ?? 0) + 1);
    return counts.get(label);
  });
  return items.map((item, place) => [round[place], item]).sort((a, b) => a[0] - b[0] || (a[1].label < b[1].label ? -1 : 1))
    .map(([, item]) => item);
}

// The decision with its confidence; or "unknown", with the reasons there are.
function verdict(answer, version) {
  const {decision, warnings} = answer;
  const threshold = version?.report.reliability?.threshold ?? null;
  const doubts = warnings.map((code) => h("li", {}, inWords(code, answer) ?? code, " ", h("code", {class: "muted"}, code)));
  if (!decision) {
    const [best] = answer.votes ?? [];
    doubts.unshift(...(answer.reasons ?? []).map(({code, detail, remedy}) =>
      h("li", {}, `${detail}: ${remedy}. `, h("code", {class: "muted"}, code))));
    return [
      h("h2", {class: "decided unknown", id: "try-decision"}, "Unknown"),
      h("p", {}, "Nothing known is in the frame for sure enough. That is an answer, not an error: don't act on the evidence below."),
      doubts.length ? [h("h3", {}, "Why"), h("ul", {class: "reasons"}, doubts)] : null,
      best ? h("p", {}, `The largest share is that of ${best.label}: ${number(100 * best.share, 0)} % of the votes’ weight, `
        + `${best.points} votes${best.placement ? `, ${best.placement.inliers} windows agree on its placement` : ""}. `,
        threshold === null ? null
          : `Its confidence is below ${number(threshold)}, this version's threshold.`) : null,
    ];
  }
  const {label, confidence} = decision;
  return [
    h("h2", {class: "decided", id: "try-decision"}, label),
    confidence === null
      ? h("p", {}, "No confidence: this version isn't calibrated, so nothing says how far to trust it.")
      : [h("p", {}, "Confidence ", h("strong", {}, confidenceText(confidence)),
        threshold === null ? null : h("span", {class: "muted"}, ` · threshold ${number(threshold)}`)),
        meter(confidence, threshold)],
    answer.also?.length ? h("p", {}, `It may also be ${answer.also.map((other) => other.label).join(", ")}: chance explains none of them.`)
      : null,
    doubts.length ? [h("h3", {}, "Doubts"), h("ul", {class: "reasons"}, doubts)] : h("p", {class: "muted"}, "No warnings."),
  ];
}

const meter = (confidence, threshold) => svg("svg", {viewBox: "0 0 100 10", preserveAspectRatio: "none", class: "hbar meter", role: "img",
  "aria-label": `Confidence ${confidenceText(confidence)} of 1${threshold === null ? "" : `, threshold ${number(threshold)}`}`},
  svg("rect", {class: "track", width: 100, height: 10}), svg("rect", {width: 100 * confidence, height: 10}),
  threshold !== null && svg("line", {x1: 100 * threshold, x2: 100 * threshold, y1: 0, y2: 10}));

const placementText = ({x_px, y_px, rotation_deg, scale, inliers, agreement}) =>
  `at (${number(x_px, 0)}, ${number(y_px, 0)}), turned ${number(rotation_deg, 1)}°, scale ${number(scale)}; `
  + `${inliers} windows agree, agreement ${number(agreement)}`;

function landmarks(answer, {image, version, exemplar, signal}) {
  const tone = tones(answer.votes);
  const why = h("div", {id: "try-evidence"});
  const radius = [version?.options.subwindow_radius_px ?? 10].flat()[0];
  let selected = null;
  async function select(point) {
    selected = point;
    const drawn = await evidence(point, {image, answer, radius, exemplar, tone});
    if (selected === point && !signal.aborted) replace(why, h("h3", {}, "The votes of this point"), drawn);
  }
  const view = image && annotatedFrame({image, answer, tone, onPoint: select});

  let only = null;
  const buttons = new Map(answer.votes.map(({label}) =>
    [label, h("button", {type: "button", class: "quiet small", "aria-pressed": "false", disabled: !view, onClick() {
      only = only === label ? null : label;
      buttons.forEach((button, each) => button.setAttribute("aria-pressed", each === only));
      view.only(only);
    }}, label)]));
  const vote = ({label, weight, share, points, placement}) => [
    h("tr", {class: placement ? "with-note" : ""},
      h("td", {}, buttons.get(label)),
      h("td", {class: "bar-cell"},
        svg("svg", {viewBox: "0 0 100 10", preserveAspectRatio: "none", class: `hbar ${tone(label)}`, "aria-hidden": "true"},
          svg("rect", {class: "track", width: 100, height: 10}), svg("rect", {width: 100 * share, height: 10}))),
      h("td", {class: "n"}, `${number(100 * share, 1)} %`), h("td", {class: "n"}, points), h("td", {class: "n"}, number(weight, 3))),
    placement && h("tr", {class: "note-row"}, h("td", {colspan: "5", class: "muted"}, `Placed ${placementText(placement)}`,
      placement.T_camera_landmark ? h("p", {}, landmarkWords(placement)) : null)),
  ];
  const votes = h("section", {class: "card"}, h("h2", {}, "Votes"),
    answer.votes.length
      ? [h("div", {class: "scroll"}, h("table", {id: "try-votes"},
        h("thead", {}, h("tr", {}, h("th", {scope: "col"}, "Label"), h("th", {scope: "col"}, h("span", {class: "visually-hidden"}, "Bar")),
          ["Share", "Votes", "W"].map((head) => h("th", {scope: "col", class: "n"}, head)))),
        h("tbody", {}, answer.votes.map(vote)))),
        h("p", {class: "muted"}, "A label shows its points and placements alone.")]
      : h("p", {}, "No point votes for a label."),
    h("p", {class: "muted"}, `${answer.points_used} of ${answer.points_found} interest points voted.`));
  const instances = h("section", {class: "card"}, h("h2", {}, "Instances"),
    answer.instances.length
      ? h("ul", {class: "reasons", id: "try-instances"},
        answer.instances.map(({label, confidence, placement}) => h("li", {}, h("span", {class: `chip ${tone(label)}`}),
          h("strong", {}, label), ` ${confidenceText(confidence)}, `, h("span", {class: "muted"}, placementText(placement),
            placement.T_camera_landmark ? ` – ${landmarkWords(placement)}` : ""))))
      : h("p", {class: "muted"},
        answer.decision ? "This version gives no placements." : "Nothing known is in the frame for sure enough."));
  return {
    frame: view && [view.element, why],
    beside: [votes, instances],
    ready: () => view?.begin(answer.decision?.label ?? answer.votes[0]?.label),
  };
}

function objects(answer, {database, file, query, image, version, exemplar, signal}) {
  const place = {database: encodeURIComponent(database.name), exemplar, signal};
  const turned = pose(answer, place);
  return {
    frame: image && h("div", {class: "annotated undrawn"}, image),
    beside: turned && h("section", {class: "card"}, h("h2", {}, "Pose"), turned),
    below: h("section", {class: "card"}, h("h2", {}, "Candidates"), candidates(answer),
      answer.candidates.length ? [h("h3", {}, "Rebuilt from eigenimages"),
        reconstruction(place.database, {file, type: mediaType(file), query, signal})] : null,
      version && eigenimages(place.database, version, signal)),
  };
}

// The timings, the version that answered, and the answer as JSON.
function provenance(answer, {file, path, query, roundTrip, signal}) {
  const {queue, decode, recognise, ...stages} = answer.timings_ms;
  const spans = Object.entries({queue, decode, ...stages});
  const all = spans.reduce((sum, [, took]) => sum + took, 0) || 1;
  const [longest] = spans.reduce((most, span) => span[1] > most[1] ? span : most);
  let from = 0;
  const bars = spans.map(([name, took], place) => {
    const x = from;
    from += 600 * took / all;
    return svg("rect", {class: `span-${place}`, x, width: 600 * took / all, height: 22}, svg("title", {}, `${name} ${number(took)} ms`));
  });
  const raw = h("details", {}, h("summary", {}, "The answer as JSON"));
  raw.addEventListener("toggle", () => {
    if (!raw.open || raw.childElementCount > 1) return;
    raw.append(h("pre", {class: "raw", tabindex: "0", "aria-label": "The answer as JSON"}, JSON.stringify(answer, null, 2)));
  });
  return h("section", {class: "card"}, h("h2", {}, "What answered, and how long it took"),
    h("p", {}, h("a", {href: `#/versions/${encodeURIComponent(answer.database)}/${answer.version}`},
      `${answer.database}, version ${answer.version}`), h("span", {class: "muted"}, " · digest "),
      h("code", {class: "long"}, answer.digest)),
    picture(`${number(decode + queue + recognise, 1)} ms in the service, most of it ${longest}`, 600, 22, bars),
    h("ul", {class: "spans", id: "try-timings"},
      spans.map(([name, took], place) => h("li", {}, h("span", {class: `chip span-${place}`}), `${name} ${number(took)} ms`))),
    h("p", {class: "muted"},
      `${number(all, 1)} ms in the service, ${number(roundTrip, 0)} ms from this browser and back with ${number(file.size / 1024, 0)} kB.`),
    h("div", {class: "row"},
      act("Save the answer", async () => download(new Blob([JSON.stringify(answer, null, 2)], {type: "application/json"}),
        `${file.name}.json`), {kind: "quiet small"}),
      act("Save the drawn frame", async () => {
        const drawn = await call("POST", `${path}/recognitions?${new URLSearchParams(query)}`,
          {body: file, type: mediaType(file), accept: "image/png", signal});
        download(await drawn.blob(), `${file.name}-annotated.png`);
        toast("Saved as the service draws it");
      }, {kind: "quiet small"})),
    raw);
}
