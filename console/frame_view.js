// The annotated frame: interest points and placements drawn on it, and the evidence of a point.
// The service's pixel coordinates have their origin at the centre of the top-left pixel; pictures begin half a pixel earlier.

import {h, replace, svg} from "./dom.js";
import {call} from "./api.js";
import {number} from "./parts.js";
import {showable} from "./portable_map.js";

const TONES = 5; // colours of labels; the rest share one

// Which class colours a label: the best vote's the first.
export function tones(votes) {
  const rank = new Map(votes.slice(0, TONES).map(({label}, place) => [label, `tone-${place + 1}`]));
  return (label) => rank.get(label) ?? "tone-0";
}

// Rounded down, so that nothing looks certain.
export const confidenceText = (confidence) => confidence > 0.999 ? "> 0.999" : (Math.floor(confidence * 1000) / 1000).toFixed(3);

// A picture as a loaded <img>, freed when `signal` is aborted.
export async function loaded(blob, alt, signal) {
  const url = URL.createObjectURL(await showable(blob));
  signal.addEventListener("abort", () => URL.revokeObjectURL(url));
  const image = h("img", {src: url, alt});
  await image.decode();
  return image;
}

// Pictures of a database's exemplars by id, each fetched once; null where it can't be fetched.
export function exemplarPictures(database, signal) {
  const held = new Map();
  const fetched = async (id) => {
    const answer = await call("GET", `v1/databases/${database}/exemplars/${id}/image`, {signal});
    return loaded(await answer.blob(), "", signal);
  };
  return (id) => {
    if (!held.has(id)) held.set(id, fetched(id).catch(() => null));
    return held.get(id);
  };
}

// Votes grouped by interest point, the strongest first. A point votes once for each radius of its window.
function pointsOf(votes) {
  const places = new Map();
  for (const vote of votes) {
    const where = `${vote.x_px} ${vote.y_px}`;
    if (!places.has(where)) places.set(where, {x: vote.x_px, y: vote.y_px, salience: vote.salience, votes: []});
    places.get(where).votes.push(vote);
  }
  const points = [...places.values()];
  for (const point of points) {
    point.votes.sort((a, b) => b.weight - a.weight || a.distance - b.distance);
    [point.best] = point.votes;
  }
  return points.sort((a, b) => b.best.weight - a.best.weight || b.salience - a.salience);
}

// Maps a point of the frame to the exemplar's picture by a placement, in its pixels from the corner; null outside.
function inExemplar({outline_px: [from, right, , down]}, {x, y}, {naturalWidth, naturalHeight}) {
  const along = (to) => {
    const [dx, dy] = [to[0] - from[0], to[1] - from[1]];
    return ((x - from[0]) * dx + (y - from[1]) * dy) / (dx * dx + dy * dy);
  };
  const [u, v] = [along(right), along(down)];
  return u >= 0 && u <= 1 && v >= 0 && v <= 1 ? {x: u * naturalWidth, y: v * naturalHeight} : null;
}

// A window of a picture, enlarged, with its circle; `turn_deg` shows an exemplar's as it lies on the frame.
function enlarged(caption, image, {x, y}, radius, turn_deg = 0) {
  const side = 168;
  const zoom = side / (3.2 * radius);
  const canvas = h("canvas", {width: side, height: side, role: "img", "aria-label": caption});
  const pen = canvas.getContext("2d");
  pen.translate(side / 2, side / 2);
  pen.save();
  pen.rotate(turn_deg * Math.PI / 180);
  pen.scale(zoom, zoom);
  pen.drawImage(image, -x, -y);
  pen.restore();
  pen.beginPath();
  pen.arc(0, 0, radius * zoom, 0, 2 * Math.PI);
  for (const [width, colour] of [[4, "#000a"], [2, "#fff"]]) {
    pen.lineWidth = width;
    pen.strokeStyle = colour;
    pen.stroke();
  }
  return h("figure", {}, canvas, h("figcaption", {}, caption));
}

// The evidence of one point: its window, the exemplar it votes for, D and weight of each of its votes.
export async function evidence(point, {image, answer, radius, exemplar, tone}) {
  const {best} = point;
  const vote = answer.votes.find(({label}) => label === best.label);
  const picture = await exemplar(best.exemplar);
  const placement = best.weight > 0 && vote?.placement?.exemplar === best.exemplar ? vote.placement : null;
  const there = placement && picture && inExemplar(placement, point, picture);
  const figures = [enlarged("In the frame", image, {x: point.x + 0.5, y: point.y + 0.5}, radius)];
  if (there) figures.push(enlarged(`In the exemplar of ${best.label}`, picture, there, radius / placement.scale, placement.rotation_deg));
  if (picture) {
    const {naturalWidth: width, naturalHeight: height} = picture;
    figures.push(h("figure", {class: "whole"},
      h("div", {class: "annotated small"}, h("img", {src: picture.src, alt: `The exemplar of ${best.label}`}),
        there && svg("svg", {viewBox: `0 0 ${width} ${height}`, "aria-hidden": "true"},
          svg("circle", {class: "selected", cx: there.x, cy: there.y, r: Math.max(radius / placement.scale, width / 30)}))),
      h("figcaption", {}, "The exemplar")));
  }
  return [
    h("div", {class: "windows"}, figures),
    h("p", {class: "muted"}, best.weight === 0
      ? "Its weight is 0: no placement agrees with its nearest eigenpoints. The nearest is of this exemplar."
      : there ? "The window of the exemplar is where its placement puts this point, turned and scaled by it."
      : picture ? "The answer doesn't say where in the exemplar it is."
        : "The exemplar's picture can't be had: it was deleted, or your key doesn't reach it."),
    h("div", {class: "scroll", tabindex: "0", role: "region", "aria-label": "Votes of this point"}, h("table", {},
      h("thead", {}, h("tr", {}, h("th", {scope: "col"}, "Votes for"), h("th", {scope: "col", class: "n"}, "D"),
        h("th", {scope: "col", class: "n"}, "Weight"), h("th", {scope: "col", class: "n"}, "Of W"))),
      h("tbody", {}, point.votes.map((each) => {
        const all = answer.votes.find(({label}) => label === each.label)?.weight;
        return h("tr", {}, h("td", {class: "name"}, h("span", {class: `chip ${each.weight > 0 ? tone(each.label) : "tone-0"}`}),
          each.label ?? "(negative)"), h("td", {class: "n"}, number(each.distance, 4)),
          h("td", {class: "n"}, number(each.weight, 4)), h("td", {class: "n"}, all ? `${number(100 * each.weight / all, 1)} %` : "–"));
      })))),
  ];
}

const corners = (outline) => outline.map((corner) => corner.join(",")).join(" ");

// An exemplar's border on the frame, its upper edge thick, and a cross in its middle; the label below that as text, as
// large on every screen.
function outline({label, placement, kind, words}, tone, {width, height}) {
  const {x_px: x, y_px: y, outline_px: [a, b]} = placement;
  const arm = width / 60;
  const percent = (value, of) => `${Math.min(Math.max(100 * value / of, 2), 92)}%`;
  return {
    drawing: svg("g", {class: `outline ${kind} ${tone}`, "data-label": label},
      svg("polygon", {class: "halo", points: corners(placement.outline_px)}), svg("polygon", {points: corners(placement.outline_px)}),
      svg("line", {class: "top", x1: a[0], y1: a[1], x2: b[0], y2: b[1]}),
      svg("path", {d: `M${x - arm} ${y}h${2 * arm}M${x} ${y - arm}v${2 * arm}`})),
    text: h("span", {class: `tag ${kind} ${tone}`, "data-label": label, style: {left: percent(x, width), top: percent(y + arm, height)}},
      words),
  };
}

// The frame, a checkbox for each layer, and a slider through its points; calls `onPoint` with the selected one.
export function annotatedFrame({image, answer, tone, onPoint}) {
  const {naturalWidth: width, naturalHeight: height} = image;
  const points = pointsOf(answer.points ?? []);
  const heaviest = points[0]?.best.weight || 1;
  const unit = width / 170;
  const circle = (point) => {
    const counts = point.best.weight > 0;
    point.node = svg("circle", {class: counts ? tone(point.best.label) : "idle", cx: point.x, cy: point.y,
      r: counts ? unit * (0.5 + 0.6 * Math.sqrt(point.best.weight / heaviest)) : unit * 0.5});
    return point.node;
  };
  const counting = points.filter(({best}) => best.weight > 0);
  const idle = points.filter(({best}) => best.weight === 0);
  const named = (found, kind, words) => found.filter(({placement}) => placement)
    .map((each) => outline({...each, kind, words: words(each)}, tone(each.label), {width, height}));
  const instances = named(answer.instances ?? [], "sure", ({label, confidence}) => `${label} ${confidenceText(confidence)}`);
  const placements = named(answer.votes ?? [], "unsure", ({label}) => label);
  const ring = svg("circle", {class: "selected off", r: 2.2 * unit});
  const layers = [
    {name: "Instances", nodes: instances, on: true},
    {name: "Placements of the votes", nodes: placements, on: !instances.length},
    {name: "Points that count", nodes: [{drawing: svg("g", {class: "points"}, counting.map(circle))}], count: counting.length, on: true},
    {name: "Points that don't", nodes: [{drawing: svg("g", {class: "points"}, idle.map(circle))}], count: idle.length,
      on: !counting.length},
  ].map((layer) => ({...layer, count: layer.count ?? layer.nodes.length})).filter(({count}) => count);
  const drawing = svg("svg", {viewBox: `-0.5 -0.5 ${width} ${height}`, role: "img",
    "aria-label": `The frame: ${counting.length} of ${points.length} interest points count, `
      + `${instances.length} known things are in it for sure`},
    layers.toReversed().map(({nodes}) => nodes.map((node) => node.drawing)), ring);
  const canvas = h("div", {class: "annotated"}, image, drawing, layers.map(({nodes}) => nodes.map((node) => node.text)));

  let isKept = false;
  let current = null;
  const hint = h("span", {class: "muted"});
  const slider = h("input",
    {type: "range", id: "try-point", min: 1, max: points.length, value: 1, "aria-label": "Interest point, the strongest vote first",
      onInput: () => { isKept = true; look(points[slider.value - 1]); }});
  function look(point) {
    if (point === current) return;
    current = point;
    const place = points.indexOf(point) + 1;
    slider.value = place;
    const words = point.best.weight > 0 ? `votes for ${point.best.label}` : "counts for nothing";
    slider.setAttribute("aria-valuetext", `Point ${place} of ${points.length}, ${words}`);
    replace(hint, `Point ${place} of ${points.length}: `, words);
    ring.setAttribute("cx", point.x);
    ring.setAttribute("cy", point.y);
    ring.classList.remove("off");
    onPoint(point);
  }
  // The point near the pointer that is drawn: one listener for all of them.
  function near(event) {
    const box = drawing.getBoundingClientRect();
    const scale = width / box.width;
    const [x, y] = [(event.clientX - box.left) * scale - 0.5, (event.clientY - box.top) * scale - 0.5];
    let [found, least] = [null, (14 * scale) ** 2];
    for (const point of points) {
      const square = (point.x - x) ** 2 + (point.y - y) ** 2;
      if (square < least && !point.node.parentNode.classList.contains("off")) [found, least] = [point, square];
    }
    return found;
  }
  drawing.addEventListener("pointermove", (event) => {
    const point = isKept ? null : near(event);
    if (point) look(point);
  });
  drawing.addEventListener("click", (event) => {
    const point = near(event);
    isKept = Boolean(point) && !(isKept && point === current);
    if (point) look(point);
  });

  const switches = layers.map(({name, count, nodes, on}) => {
    const show = (isOn) => nodes.forEach(({drawing, text}) => {
      drawing.classList.toggle("off", !isOn);
      text?.classList.toggle("off", !isOn);
    });
    show(on);
    return h("label", {}, h("input", {type: "checkbox", checked: on, onChange: (event) => show(event.target.checked)}), ` ${name} `,
      h("span", {class: "muted"}, `(${count})`));
  });
  return {
    element: h("div", {}, canvas, layers.length ? h("fieldset", {class: "layers"}, h("legend", {}, "Shown on it"), switches) : null,
      points.length ? h("div", {class: "through"}, slider, hint,
        h("p", {class: "muted"}, "Point at one, or move the slider with the arrow keys. A click keeps a point, another lets go.")) : null),
    // Shows one label's evidence alone, or all for null.
    only(label) {
      for (const {node, best} of points) node.classList.toggle("dim", label !== null && best.label !== label);
      for (const node of canvas.querySelectorAll("[data-label]")) {
        node.classList.toggle("dim", label !== null && node.dataset.label !== label);
      }
    },
    // Selects the strongest vote for a label, or of all.
    begin(label) {
      const point = points.find(({best}) => best.label === label && best.weight > 0) ?? points[0];
      if (point) look(point);
    },
  };
}
