// #/tracks/{database}[/{track}]: the live tracks of a database, and one of them on the map and on a timeline of its frames.

import {h, replace, drawOnChange, svg} from "./dom.js";
import {all, follow, get, remove} from "./api.js";
import {act, count, number, poll, problem, state, time, whileVisible} from "./parts.js";
import {confidenceText, exemplarPictures} from "./frame_view.js";
import {mapView} from "./map_view.js";
import {marksOf} from "./database_map.js";
import {placeLines, surveyed} from "./where.js";
import {beliefTable, pictureOf} from "./tracking.js";
import {showable} from "./portable_map.js";
import {ticks} from "./charts.js";

const KEPT = 1000; // frames of a track
const IN_TABLE = 100;
const GAP_S = 2; // and so many times the usual time between two frames
const GAP_FACTOR = 4;
const TONES = 5;

const shortId = (id) => id.slice(-8);

export async function show(main, [name, wanted], signal) {
  if (!name) return location.replace("#/");
  const path = `v1/databases/${encodeURIComponent(name)}`;
  await get(path, {signal});
  let chosen = wanted ?? null;
  let pinned = null; // an entry that was chosen; none follows the newest
  const entries = new Map(); // track -> its frames in their order
  const list = h("div", {id: "track-list"});
  const belief = h("div", {id: "track-belief"});
  const line = h("div", {id: "timeline"});
  const detail = h("div", {id: "track-frame", "aria-live": "polite"});
  const fault = h("div", {});
  const rows = h("div", {class: "scroll"});
  const table = h("details", {id: "track-table"}, h("summary", {}, "Its frames as a table"), rows);
  const slider = h("input", {type: "range", min: 0, value: 0, step: 1, id: "track-slider", "aria-label": "Frame of the track",
    onInput() { pin(framesOf()[Number(slider.value)]); }});
  const newest = h("button", {type: "button", class: "quiet small", onClick: () => pin(null)}, "Follow the newest");
  const view = mapView({exemplar: exemplarPictures(encodeURIComponent(name), signal), signal});
  const ground = h("div", {hidden: true}, view.node);
  const one = h("section", {class: "card", id: "track", hidden: true}, h("h2", {}, "The track"),
    h("div", {class: "map-split"}, h("div", {}, ground, detail), belief), line,
    h("div", {class: "through"}, slider), h("p", {class: "row"}, newest), table);
  let exemplars = [];
  let [onMap, fitted] = [null, false];
  const framesOf = () => entries.get(chosen) ?? [];

  replace(main, h("div", {class: "tracks try"}, h("h1", {}, `Tracks of ${name}`),
    h("p", {class: "muted"}, "A track adds up the evidence of a robot's frames. ",
      h("a", {href: `#/try/${encodeURIComponent(name)}`}, "Try it"),
      " posts frames of one; ", h("a", {href: `#/databases/${encodeURIComponent(name)}`}, "the database"), " has the map."),
    fault, h("section", {class: "card"}, h("h2", {}, "Live tracks"), list), one));

  function choose(id) {
    [chosen, pinned, fitted] = [id, null, false];
    history.replaceState(null, "", `#/tracks/${encodeURIComponent(name)}/${id}`);
    draw();
    refresh().catch((error) => replace(fault, problem(error)));
  }
  function pin(entry) {
    pinned = entry;
    draw();
  }
  const drawList = drawOnChange(list, ({live, past, chosen: current}) => live.length || past.length ? h("div", {class: "scroll"},
    h("table", {},
    h("thead", {}, h("tr", {}, ["Track", "Began", "Frames", "Version", "Ends", ""].map((words) => h("th", {scope: "col"}, words)))),
    h("tbody", {}, [...live, ...past].map((track) => h("tr", {},
      h("td", {}, h("button", {type: "button", class: "quiet small", "aria-pressed": String(track.id === current),
        "aria-label": `Show track ${shortId(track.id)}`, onClick: () => choose(track.id)}, shortId(track.id))),
      h("td", {}, time(track.created_at)), h("td", {}, track.frames), h("td", {}, track.version ?? "–"),
      h("td", {}, track.expires_at ? time(track.expires_at) : state("gone")),
      h("td", {}, track.expires_at ? act("End", async () => { await remove(`${path}/tracks/${track.id}`); await refresh(); },
        {kind: "quiet small", "aria-label": `End track ${shortId(track.id)}`}) : null))))))
    : h("p", {class: "muted"}, "None: a robot begins one, or Try it does with “As frames of a track”."));
  const drawBelief = drawOnChange(belief, ({track}) => track ? [
    h("p", {}, track.decision ? [h("strong", {}, track.decision.label), ` with probability ${confidenceText(track.decision.confidence)}`]
      : h("strong", {}, "Nowhere for sure"), h("span", {class: "muted"}, `, by ${count(track.frames, "frame")}, motion ${track.motion}`)),
    track.pose ? placeLines(track.pose) : null, beliefTable(track)] : h("p", {class: "muted"}, "It ended: only its frames are left here."));

  async function refresh() {
    const live = await all(`${path}/tracks`, {signal});
    chosen ??= live.at(-1)?.id ?? [...entries.keys()].at(-1) ?? null;
    const past = [...entries].filter(([id]) => live.every((track) => track.id !== id)).map(([id, frames]) =>
      ({id, created_at: frames[0].at, frames: frames.length}));
    const detailed = live.some(({id}) => id === chosen) ? await get(`${path}/tracks/${chosen}`, {signal}) : null;
    if (signal.aborted) return;
    one.hidden = !chosen;
    drawList({live, past, chosen});
    const {decision, belief: labels, elsewhere, pose, frames, motion} = detailed ?? {};
    drawBelief({track: detailed && {decision, belief: labels, elsewhere, pose, frames, motion}});
    draw();
  }

  let drawn = 0;
  const draw = () => { drawn ||= requestAnimationFrame(() => { drawn = 0; if (!signal.aborted) paint(); }); };
  function paint() {
    const frames = framesOf();
    one.hidden = !chosen;
    const entry = pinned && frames.includes(pinned) ? pinned : frames.at(-1) ?? null;
    newest.hidden = !pinned;
    slider.parentNode.hidden = frames.length < 2;
    slider.max = Math.max(frames.length - 1, 0);
    slider.value = entry ? frames.indexOf(entry) : 0;
    slider.setAttribute("aria-valuetext", entry ? words(entry) : "none");
    replace(line, frames.length ? timeline(frames, entry, pin)
      : h("p", {class: "muted"}, "No frame of it was seen yet: they appear here as they come."));
    drawFrame(entry);
    drawTable(frames);
    const pose = entry?.pose ?? null;
    ground.hidden = !frames.some((each) => each.pose);
    if (!pose) return view.show({marks: marksOf(exemplars, onMap)});
    if (onMap !== pose.map) [onMap, fitted] = [pose.map, false];
    view.show({marks: marksOf(exemplars, onMap), support: pose.support, found: [pose],
      path: frames.filter((each) => each.pose?.map === onMap).map((each) => each.pose)});
    if (!fitted) { fitted = true; view.fit(); }
  }
  const drawFrame = drawOnChange(detail, (entry) => entry ? h("div", {class: "row top"}, thumbnail(entry, signal), h("div", {},
    h("p", {}, time(entry.at), entry.frame_id ? [" · ", h("code", {class: "long"}, entry.frame_id)] : null),
    h("p", {}, words(entry)), entry.pose ? placeLines(entry.pose) : h("p", {class: "muted"}, "No pose."))) : null);
  function drawTable(frames) {
    if (!table.open) return;
    replace(rows, h("table", {}, h("thead", {}, h("tr", {}, ["Frame", "Decision"].map((head) => h("th", {scope: "col"}, head)),
      ["Confidence", "x, m", "y, m", "Heading, °"].map((head) => h("th", {scope: "col", class: "n"}, head)),
      h("th", {scope: "col"}, "State"))),
    h("tbody", {}, frames.slice(-IN_TABLE).reverse().map((entry) => h("tr", {},
      h("td", {}, h("button", {type: "button", class: "quiet small", "aria-pressed": String(entry === pinned), onClick: () => pin(entry)},
        new Date(entry.at).toLocaleTimeString())),
      h("td", {}, entry.decision?.label ?? "unknown"), h("td", {class: "n"}, entry.decision ? number(entry.decision.confidence, 3) : "–"),
      ["x_m", "y_m", "yaw_deg"].map((member) => h("td", {class: "n"}, number(entry.pose?.[member]))),
      h("td", {}, entry.pose?.lost ? state("lost") : null))))));
  }
  table.addEventListener("toggle", draw);

  // What came before the page was opened is told too, as far as the service keeps it.
  const since = {id: "0-0"};
  const query = new URLSearchParams({database: name, kind: "decision"});
  whileVisible((visible) => follow(`v1/events?${query}`, ({at, header, track, decision, pose}) => {
    if (!track) return;
    const frames = entries.get(track) ?? [];
    entries.set(track, frames);
    // Another process of a fleet may tell again what it told before.
    if (frames.some((each) => each.at === at)) return;
    const place = frames.findLastIndex((each) => new Date(each.at) <= new Date(at)) + 1;
    frames.splice(place, 0, {at, frame_id: header.frame_id, decision, pose: pose ?? null});
    if (frames.length > KEPT) frames.shift();
    if (track === chosen || !chosen) draw();
  }, visible, since), signal).catch((error) => {
    if (error.name !== "AbortError" && !signal.aborted) replace(fault, problem(error));
  });
  await refresh();
  surveyed(path, signal).then((found) => { exemplars = found; fitted = false; draw(); }).catch(() => {});
  poll(refresh, signal, (error) => replace(fault, error && problem(error)), 3);
}

const words = ({decision, pose}) => (decision ? `${decision.label}, confidence ${confidenceText(decision.confidence)}` : "unknown")
  + (pose?.lost ? ", lost" : "");

// The picture of a frame that this tab posted; the service keeps none.
function thumbnail({frame_id: id}, signal) {
  const file = id && pictureOf(id);
  if (!file) return null;
  const image = h("img", {class: "cut", alt: `The frame ${file.name}`});
  showable(file).then((blob) => {
    const url = URL.createObjectURL(blob);
    const done = () => URL.revokeObjectURL(url);
    for (const end of ["load", "error"]) image.addEventListener(end, done);
    signal.addEventListener("abort", done);
    image.src = url;
  }).catch(() => image.remove());
  return image;
}

// Confidence over time: a dot a frame, coloured by its label; times without a frame hatched, lost stretches marked.
function timeline(frames, chosen, onChosen) {
  const [width, height, left, right, top, bottom] = [900, 190, 40, 14, 14, 58];
  const times = frames.map(({at}) => new Date(at).getTime() / 1000);
  const [from, to] = [times[0], Math.max(times.at(-1), times[0] + 1)];
  const x = (second) => left + (second - from) / (to - from) * (width - left - right);
  const y = (confidence) => height - bottom - confidence * (height - top - bottom);
  const steps = times.slice(1).map((second, place) => second - times[place]).sort((a, b) => a - b);
  const usual = steps[steps.length >> 1] ?? 0;
  const isGap = (step) => step > Math.max(GAP_S, GAP_FACTOR * usual);
  const labels = [...new Set(frames.map(({decision}) => decision?.label).filter(Boolean))];
  const tone = (label) => label ? `tone-${labels.indexOf(label) < TONES ? labels.indexOf(label) + 1 : 0}` : "tone-0";
  const band = (kind, place, title) => svg("rect", {class: kind, x: x(times[place]), y: top,
    width: Math.max(x(times[place + 1] ?? to) - x(times[place]), 3), height: height - top - bottom}, svg("title", {}, title));
  const runs = [];
  frames.forEach(({decision}, place) => {
    const label = decision?.label ?? null;
    const last = runs.at(-1);
    if (last && last.label === label && !isGap(times[place] - times[last.to])) last.to = place;
    else runs.push({label, from: place, to: place});
  });
  const gaps = frames.filter((_, place) => place && isGap(times[place] - times[place - 1])).length;
  const lost = frames.filter(({pose}) => pose?.lost).length;
  const title = `${count(frames.length, "frame")} over ${number(to - from, 0)} s, ${count(gaps, "gap")}, ${count(lost, "frame")} lost`;
  const drawing = svg("svg", {viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": title, class: "chart timeline"},
    [0, 0.5, 1].map((value) => [svg("line", {class: "axis", x1: left, x2: width - right, y1: y(value), y2: y(value)}),
      svg("text", {x: left - 6, y: y(value) + 4, "text-anchor": "end"}, value)]),
    ticks(0, to - from, 6).map((second) => svg("text", {x: x(from + second), y: height - 4, "text-anchor": "middle"},
      `${number(second, 1)} s`)),
    frames.map(({pose}, place) => [
      pose?.lost && band("lost-band", place, "lost"),
      place + 1 < frames.length && isGap(times[place + 1] - times[place])
        && band("gap-band", place, `${number(times[place + 1] - times[place], 1)} s without a frame`)]),
    runs.map(({label, from: first, to: last}) => [
      svg("rect", {class: `run ${tone(label)}`, x: x(times[first]) - 3, width: Math.max(x(times[last]) - x(times[first]), 0) + 6,
        y: height - bottom + 12, height: 8}, svg("title", {}, label ?? "unknown")),
      x(times[last]) - x(times[first]) > 7 * (label ?? "unknown").length
        && svg("text", {x: (x(times[first]) + x(times[last])) / 2, y: height - bottom + 33, "text-anchor": "middle"}, label ?? "unknown")]),
    frames.map(({decision}, place) => svg("circle", {class: `frame-dot ${tone(decision?.label)}${decision ? "" : " none"}`,
      cx: x(times[place]), cy: y(decision?.confidence ?? 0), r: 4})),
    chosen && svg("circle", {class: "chosen", cx: x(times[frames.indexOf(chosen)]), cy: y(chosen.decision?.confidence ?? 0), r: 8}));
  drawing.addEventListener("click", (event) => {
    const box = drawing.getBoundingClientRect();
    const at = (event.clientX - box.left) / box.width * width;
    let nearest = 0;
    times.forEach((second, place) => { if (Math.abs(x(second) - at) < Math.abs(x(times[nearest]) - at)) nearest = place; });
    onChosen(frames[nearest]);
  });
  return [h("h3", {}, "Confidence over time"), h("div", {class: "scroll", tabindex: 0, role: "region", "aria-label": "Timeline"}, drawing),
    h("p", {class: "muted"}, `${title}. Click near a frame, or move the slider with the arrow keys.`)];
}
