// Frames that this tab posts to a track: the fields for that, the track that is under way, and the pictures, which the service
// doesn't keep.

import {h, replace} from "./dom.js";
import {call, post} from "./api.js";
import {act, count, number} from "./parts.js";
import {numberField, numberIn} from "./fields.js";
import {confidenceText} from "./frame_view.js";

const KEPT = 200; // pictures
const pictures = new Map(); // X-Frame-Id -> file
const ids = new WeakMap();
let isOn = false;
let track = null; // {id, database, alias}

// The picture that was posted under an X-Frame-Id, if this tab did.
export const pictureOf = (frameId) => pictures.get(frameId) ?? null;

// The id of a picture: the same one asked again isn't counted twice.
function idOf(file) {
  if (!ids.has(file)) ids.set(file, `console-${crypto.getRandomValues(new Uint32Array(2)).join("-")}`);
  const id = ids.get(file);
  pictures.delete(id);
  pictures.set(id, file);
  if (pictures.size > KEPT) pictures.delete(pictures.keys().next().value);
  return id;
}

// The fields, for the database at `path`; `onChanged` is called when frames become those of a track, or no more.
export function tracking({name, path, onChanged, signal}) {
  const said = h("span", {class: "muted", id: "track-said"});
  const form = h("form", {class: "fields", id: "odometry", hidden: !isOn, onSubmit: (event) => event.preventDefault()},
    numberField("Moved forward, m", "dx_m", undefined, {hint: "Since the frame before; empty: not known."}),
    numberField("To its left, m", "dy_m"), numberField("Turned left, °", "dyaw_deg"),
    h("div", {class: "bottom"}, act("Begin a new track", () => { track = null; tell(); }, {kind: "quiet small"})));
  const box = h("input", {type: "checkbox", id: "as-track", checked: isOn, onChange() {
    isOn = box.checked;
    form.hidden = !isOn;
    tell();
    onChanged();
  }});
  const tell = () => replace(said, isOn && track?.database === name ? h("a", {href: address()}, "Its timeline") : "");
  const address = () => `#/tracks/${encodeURIComponent(name)}/${track.id}`;
  tell();
  return {
    node: h("div", {}, h("p", {class: "row"}, box, h("label", {for: "as-track"}, "As frames of a track: evidence adds up"), said), form),
    isOn: () => isOn,
    // Posts a frame to the track of that alias, and begins one where there is none: {reply, target, query, alias}.
    async send(file, type, alias, asked, now) {
      const moved = ["dx_m", "dy_m", "dyaw_deg"].map((member) => [member, numberIn(form, member)])
        .filter(([, value]) => value !== undefined);
      const query = {...asked, ...Object.fromEntries(moved)};
      for (let attempt = 0; ; attempt += 1) {
        if (track?.database !== name || track.alias !== alias) {
          const {id} = await post(`${path}/tracks`, {json: alias === "current" ? {} : {alias}, signal: now});
          track = {id, database: name, alias};
        }
        try {
          const target = `tracks/${track.id}/frames`;
          const reply = await call("POST", `${path}/${target}?${new URLSearchParams(query)}`,
            {body: file, type, headers: {"X-Frame-Id": idOf(file)}, signal: now});
          form.reset();
          if (!signal.aborted) tell();
          return {reply, target, query, alias: alias === "current" ? undefined : alias};
        } catch (error) {
          if (error.status !== 404 || attempt) throw error; // it ended meanwhile: another begins
          track = null;
        }
      }
    },
  };
}

// What is believed of a track.
export function beliefCard({track: id, database, frame, belief, elsewhere}) {
  const {decision} = frame;
  return h("section", {class: "card", id: "try-track"}, h("h2", {}, "The track"),
    h("p", {}, `${count(frame.number, "frame")}${frame.counted ? "" : "; this one was counted before"}. This frame alone: `,
      decision ? decision.label : "unknown",
      decision && decision.confidence !== null ? `, confidence ${confidenceText(decision.confidence)}` : "", ". ",
      h("a", {href: `#/tracks/${encodeURIComponent(database)}/${id}`}, "Its timeline")),
    beliefTable({belief, elsewhere}));
}

export const beliefTable = ({belief, elsewhere}) => h("table", {},
  h("thead", {}, h("tr", {}, h("th", {scope: "col"}, "Believed at"), h("th", {scope: "col", class: "n"}, "Probability"))),
  h("tbody", {}, belief.map(({label, probability}) => h("tr", {}, h("td", {}, label), h("td", {class: "n"}, number(probability, 3)))),
    h("tr", {}, h("td", {class: "muted"}, "somewhere else"), h("td", {class: "n"}, number(elsewhere, 3)))));
