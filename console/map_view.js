// A map seen from above, on a canvas: x right, y up, in metres; headings in degrees, counter-clockwise from x. On it stand
// exemplars where they were taken, flat landmarks, and places that were found, with their 95 % ellipses.

import {h, replace} from "./dom.js";
import {number} from "./parts.js";
import {ticks} from "./charts.js";
import {poseNumbers, uncertainty} from "./map_pose.js";

const REACH_PX = 14; // so near to a mark the pointer is on it
const WEDGE_PX = 20;
const WEDGE_HALF = 22 * Math.PI / 180;
const HANDLE_PX = 38; // where the selected mark's heading is held
const CROWD = 300;
const MOST_LABELS = 60;
const STILL_PX = 4; // a pointer that moved less was clicked
const SCALES = [0.01, 20000]; // px per metre
const COLOURS = {text: "--text", muted: "--muted", line: "--line", card: "--card", exemplar: "--series-1", support: "--series-2",
  found: "--series-3", lost: "--bad"};

const rad = (deg) => deg * Math.PI / 180;
const wrapped = (deg) => { const turn = ((deg % 360) + 360) % 360; return turn > 180 ? turn - 360 : turn; };

const PAUSE_MS = 150; // before the picture under the pointer is fetched

// Marks are {id, label, pose: {x_m, y_m, yaw_deg}, size_mm}. `onMoved(mark, pose)` is called at the end of a drag, where marks may
// be moved; `onSelected(id | null)`; `onPlaced(x_m, y_m)` for a click on the ground, and is true if it took it.
// `exemplar(id)` resolves to an exemplar's picture, or null.
export function mapView({exemplar: pictureOf, onSelected, onMoved, onPlaced, signal}) {
  const canvas = h("canvas", {tabindex: 0, role: "application", class: "map-canvas", "aria-describedby": "map-reading",
    "aria-label": "Map: arrow keys move it, plus and minus zoom, 0 shows all, Page Down and Page Up go from exemplar to exemplar"});
  const reading = h("output", {id: "map-reading", class: "muted"}, "\u00a0");
  const said = h("span", {class: "visually-hidden", role: "status"});
  const probe = h("span", {hidden: true});
  const tool = (label, words, work) => h("button",
    {type: "button", class: "quiet small", "aria-label": words, title: words, onClick: work}, label);
  const tools = h("div", {class: "map-tools"}, tool("+", "Zoom in", () => zoom(1.5)), tool("−", "Zoom out", () => zoom(1 / 1.5)),
    tool("All", "Show all of the map", () => fit()));
  const card = h("figure", {class: "map-card", hidden: true});
  const node = h("div", {class: "map-view"}, h("div", {class: "map-ground"}, canvas, tools, card), h("p", {class: "reading"}, reading),
    said, probe);
  const pen = canvas.getContext("2d");
  let size = {width: 0, height: 0};
  const view = {x: 0, y: 0, scale: 0}; // scale 0: not fitted yet
  let shown = {marks: [], support: new Set(), found: [], path: []};
  let [selected, hovered] = [null, null];
  let colours = {};
  let asked = 0;
  let isFitted = true; // until the person moves it

  const toScreen = ({x_m, y_m}) => [size.width / 2 + (x_m - view.x) * view.scale, size.height / 2 - (y_m - view.y) * view.scale];
  const toMap = ([x, y]) => [view.x + (x - size.width / 2) / view.scale, view.y - (y - size.height / 2) / view.scale];
  const at = (event) => [event.offsetX, event.offsetY];
  const mark = (id) => shown.marks.find((each) => each.id === id);
  const handle = ({pose}) => {
    const [x, y] = toScreen(pose);
    return [x + HANDLE_PX * Math.cos(rad(pose.yaw_deg)), y - HANDLE_PX * Math.sin(rad(pose.yaw_deg))];
  };
  const isNear = ([x, y], [u, v]) => Math.hypot(x - u, y - v) <= REACH_PX;
  function hit(point) {
    let [found, least] = [null, REACH_PX];
    for (const each of shown.marks) {
      const [x, y] = toScreen(each.pose);
      const distance = Math.hypot(x - point[0], y - point[1]);
      if (distance <= least) [found, least] = [each, distance];
    }
    return found;
  }

  function fit() {
    isFitted = true;
    if (!size.width) return;
    const around = ({x_m, y_m, covariance}) => [-1, 1].map((way) => {
      const [reach] = uncertainty(covariance).axes_m;
      return {x_m: x_m + way * reach, y_m: y_m + way * reach};
    });
    const points = [...shown.marks.map(({pose}) => pose), ...shown.found.flatMap(around), ...shown.path];
    const [xs, ys] = [points.map(({x_m}) => x_m), points.map(({y_m}) => y_m)];
    const ends = (values) => values.length ? [values.reduce((a, b) => Math.min(a, b)), values.reduce((a, b) => Math.max(a, b))] : [-2, 2];
    const [[left, right], [low, high]] = [ends(xs), ends(ys)];
    const span = ([from, to], px) => (px - 110) / Math.max(to - from, 2);
    Object.assign(view, {x: (left + right) / 2, y: (low + high) / 2,
      scale: clamp(Math.min(span([left, right], size.width), span([low, high], size.height)))});
    draw();
  }
  const clamp = (scale) => Math.min(Math.max(scale, SCALES[0]), SCALES[1]);
  function zoom(factor, around = [size.width / 2, size.height / 2]) {
    isFitted = false;
    const [x, y] = toMap(around);
    view.scale = clamp(view.scale * factor);
    const [u, v] = toMap(around);
    view.x += x - u;
    view.y += y - v;
    draw();
  }
  function pan(dx, dy) {
    isFitted = false;
    view.x -= dx / view.scale;
    view.y += dy / view.scale;
    draw();
  }

  const draw = () => { asked ||= requestAnimationFrame(() => { asked = 0; paint(); }); };
  // Colours are those of the style sheet, resolved for the scheme that is shown.
  function resolve() {
    for (const [name, variable] of Object.entries(COLOURS)) {
      probe.style.color = `var(${variable})`;
      colours[name] = getComputedStyle(probe).color;
    }
  }
  function line(from, to) {
    pen.beginPath();
    pen.moveTo(...from);
    pen.lineTo(...to);
    pen.stroke();
  }
  function ground() {
    const [left, top] = toMap([0, 0]);
    const [right, low] = toMap([size.width, size.height]);
    const lines = ticks(0, (right - left), size.width / 90);
    const step = lines[1] ?? 1;
    pen.strokeStyle = colours.line;
    pen.lineWidth = 1;
    for (let x = Math.ceil(left / step) * step; x <= right; x += step) {
      const [u] = toScreen({x_m: x, y_m: 0});
      line([u, 0], [u, size.height]);
    }
    for (let y = Math.ceil(low / step) * step; y <= top; y += step) {
      const [, v] = toScreen({x_m: 0, y_m: y});
      line([0, v], [size.width, v]);
    }
    pen.strokeStyle = pen.fillStyle = colours.text;
    pen.lineWidth = 2;
    const [from, y] = [12, size.height - 12];
    const length = step * view.scale;
    pen.beginPath();
    pen.moveTo(from, y - 5);
    pen.lineTo(from, y);
    pen.lineTo(from + length, y);
    pen.lineTo(from + length, y - 5);
    pen.stroke();
    pen.fillText(step < 1 ? `${number(100 * step, 3)} cm` : `${number(step, 0)} m`, from + 4, y - 6);
  }
  const wedge = ([x, y], yaw_deg, length) => {
    pen.moveTo(x, y);
    pen.arc(x, y, length, -rad(yaw_deg) - WEDGE_HALF, -rad(yaw_deg) + WEDGE_HALF);
    pen.closePath();
  };
  function plate([x, y], {pose, size_mm}) {
    const [cos, sin] = [Math.cos(rad(pose.yaw_deg)), Math.sin(rad(pose.yaw_deg))];
    const half = Math.max(size_mm / 2000 * view.scale, 7);
    pen.lineWidth += 2;
    line([x - half * sin, y - half * cos], [x + half * sin, y + half * cos]);
    pen.lineWidth -= 2;
    line([x, y], [x + 14 * cos, y - 14 * sin]);
  }
  // Marks that look the same, in few strokes: thousands stay quick.
  function exemplars(list, {colour, edge = colour, width, length}) {
    pen.strokeStyle = edge;
    pen.fillStyle = colour;
    pen.lineWidth = width;
    for (const each of list) if (each.size_mm) plate(toScreen(each.pose), each);
    pen.beginPath();
    for (const each of list) if (!each.size_mm) wedge(toScreen(each.pose), each.pose.yaw_deg, length);
    pen.globalAlpha = 0.3;
    pen.fill();
    pen.globalAlpha = 1;
    pen.stroke();
    pen.beginPath();
    for (const {pose} of list) {
      const [x, y] = toScreen(pose);
      pen.moveTo(x, y);
      pen.arc(x, y, Math.min(3.5, length / 4), 0, 2 * Math.PI);
    }
    pen.fill();
  }
  function ring(each) {
    const held = handle(each);
    pen.lineWidth = 1.5;
    pen.setLineDash([3, 3]);
    line(toScreen(each.pose), held);
    pen.setLineDash([]);
    pen.fillStyle = colours.card;
    pen.beginPath();
    pen.arc(...held, 7, 0, 2 * Math.PI);
    pen.fill();
    pen.stroke();
  }
  const isSeen = ({pose}) => {
    const [x, y] = toScreen(pose);
    return x > -60 && y > -60 && x < size.width + 60 && y < size.height + 60;
  };
  function marks() {
    const seen = shown.marks.filter(isSeen);
    // Where they stand close together they are drawn smaller.
    const length = Math.min(Math.max(0.7 * Math.sqrt(size.width * size.height / (seen.length || 1)), 8), WEDGE_PX);
    const isPlain = ({id}) => id !== selected && id !== hovered && !shown.support.has(id);
    exemplars(seen.filter(isPlain), {colour: colours.exemplar, width: 1.5, length});
    exemplars(seen.filter(({id}) => shown.support.has(id)), {colour: colours.support, width: 3, length: WEDGE_PX});
    for (const id of new Set([hovered, selected])) {
      const each = mark(id);
      if (!each) continue;
      const colour = shown.support.has(id) ? colours.support : colours.exemplar;
      exemplars([each], {colour, edge: colours.text, width: id === selected ? 3 : 1.5, length: WEDGE_PX});
      if (id === selected && onMoved) ring(each);
    }
    return seen;
  }
  function place(pose) {
    const [x, y] = toScreen(pose);
    const {axes_m: [major, minor], turn_rad: turn, yaw_deg: either} = uncertainty(pose.covariance);
    pen.strokeStyle = pen.fillStyle = pose.lost ? colours.lost : colours.found;
    pen.lineWidth = 2;
    pen.setLineDash(pose.lost ? [5, 4] : []);
    pen.beginPath();
    pen.ellipse(x, y, Math.max(major * view.scale, 3), Math.max(minor * view.scale, 3), -turn, 0, 2 * Math.PI);
    pen.globalAlpha = 0.15;
    pen.fill();
    pen.globalAlpha = 1;
    pen.stroke();
    pen.setLineDash([]);
    const spread = Math.min(rad(either), Math.PI);
    pen.globalAlpha = 0.3;
    pen.beginPath();
    pen.moveTo(x, y);
    pen.arc(x, y, 34, -rad(pose.yaw_deg) - spread, -rad(pose.yaw_deg) + spread);
    pen.closePath();
    pen.fill();
    pen.globalAlpha = 1;
    pen.lineWidth = 3;
    line([x, y], [x + 34 * Math.cos(rad(pose.yaw_deg)), y - 34 * Math.sin(rad(pose.yaw_deg))]);
    pen.beginPath();
    pen.arc(x, y, 5, 0, 2 * Math.PI);
    pen.fill();
  }
  // The labels that don't lie on one another, the selected and the supporting ones first; in a crowd these alone.
  const widths = new Map();
  const widthOf = (text) => {
    if (!widths.has(text)) widths.set(text, pen.measureText(text).width);
    return widths.get(text);
  };
  function labels(seen) {
    const taken = [];
    const rank = ({id}) => id === selected || id === hovered ? 0 : shown.support.has(id) ? 1 : 2;
    pen.lineWidth = 3;
    pen.strokeStyle = colours.card;
    pen.fillStyle = colours.text;
    const told = seen.length > CROWD ? seen.filter((each) => rank(each) < 2) : seen;
    for (const each of told.toSorted((a, b) => rank(a) - rank(b))) {
      if (taken.length >= MOST_LABELS) return;
      const [x, y] = toScreen(each.pose);
      const [from, width] = [x + 7, widthOf(each.label)];
      const base = y + (Math.sin(rad(each.pose.yaw_deg)) >= 0 ? 14 : -8);
      if (taken.some((box) => from < box.to && from + width > box.from && Math.abs(base - box.base) < 14)) continue;
      taken.push({from, to: from + width, base});
      pen.strokeText(each.label, from, base);
      pen.fillText(each.label, from, base);
    }
  }
  function paint() {
    if (signal.aborted || !size.width) return;
    if (!view.scale) return fit();
    resolve();
    const ratio = window.devicePixelRatio || 1;
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, size.width, size.height);
    pen.font = "12px system-ui, sans-serif";
    ground();
    const seen = marks();
    if (shown.path.length > 1) {
      pen.strokeStyle = colours.found;
      pen.lineWidth = 1.5;
      pen.globalAlpha = 0.6;
      pen.beginPath();
      shown.path.forEach((each) => pen.lineTo(...toScreen(each)));
      pen.stroke();
      pen.globalAlpha = 1;
    }
    for (const each of shown.path) {
      pen.fillStyle = each.lost ? colours.lost : colours.found;
      pen.beginPath();
      pen.arc(...toScreen(each), 3, 0, 2 * Math.PI);
      pen.fill();
    }
    shown.found.forEach(place);
    labels(seen);
  }

  function select(id, tell = true) {
    selected = id;
    const each = mark(id);
    if (each) said.textContent = `${each.label}: ${poseNumbers(each.pose)}`;
    describe();
    draw();
    if (tell) onSelected?.(id);
  }
  // The picture and the numbers of the mark under the pointer, else of the selected one.
  let described = null;
  let waiting = 0;
  function describe() {
    const each = mark(hovered) ?? mark(selected);
    card.hidden = !each;
    if (!each || described === each) return;
    described = each;
    const place = h("div", {});
    replace(card, place, h("figcaption", {}, h("strong", {}, each.label), h("br"), poseNumbers(each.pose),
      each.size_mm ? [h("br"), `${number(each.size_mm, 0)} mm wide`] : null));
    clearTimeout(waiting);
    waiting = setTimeout(async () => {
      const image = await pictureOf(each.id);
      if (image && described === each) replace(place, image);
    }, PAUSE_MS);
  }
  // Shows the place of the selected mark.
  function reveal() {
    const each = mark(selected);
    const [x, y] = each && view.scale ? toScreen(each.pose) : [0, 0];
    if (x < 0 || y < 0 || x > size.width || y > size.height) Object.assign(view, {x: each.pose.x_m, y: each.pose.y_m});
    draw();
  }
  function hover(id) {
    if (hovered === id) return;
    hovered = id;
    describe();
    draw();
  }
  function point(event) {
    const [x, y] = toMap(at(event));
    const each = hit(at(event));
    reading.textContent = `x ${number(x)} m, y ${number(y)} m${each ? ` · ${each.label}` : ""}`;
    hover(each?.id ?? null);
    const isHeld = onMoved && mark(selected) && isNear(handle(mark(selected)), at(event));
    canvas.style.cursor = isHeld ? "grab" : each ? (onMoved ? "move" : "pointer") : "";
  }

  const fingers = new Map();
  let held = null; // what is under way: {kind: "pan" | "move" | "turn", mark, from, before}
  canvas.addEventListener("pointerdown", (event) => {
    if (event.button) return;
    isFitted = false;
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, at(event));
    if (fingers.size > 1) {
      if (held?.before) held.mark.pose = held.before;
      held = null;
      return;
    }
    const chosen = mark(selected);
    const turned = onMoved && chosen && isNear(handle(chosen), at(event)) ? chosen : null;
    const each = turned ?? hit(at(event));
    held = {kind: turned ? "turn" : each && onMoved ? "move" : "pan", mark: each, from: at(event), before: each?.pose, moved: false};
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = fingers.get(event.pointerId);
    if (!before) return point(event);
    const now = at(event);
    if (fingers.size === 2) {
      const other = [...fingers].find(([id]) => id !== event.pointerId)[1];
      const apart = ([x, y]) => Math.hypot(x - other[0], y - other[1]) || 1;
      pan((now[0] - before[0]) / 2, (now[1] - before[1]) / 2);
      zoom(apart(now) / apart(before), [(now[0] + other[0]) / 2, (now[1] + other[1]) / 2]);
    } else if (held) {
      held.moved ||= Math.hypot(now[0] - held.from[0], now[1] - held.from[1]) > STILL_PX;
      if (held.moved && held.kind === "pan") pan(now[0] - before[0], now[1] - before[1]);
      else if (held.moved) {
        const [x_m, y_m] = toMap(now).map((metres) => Math.round(metres * 1000) / 1000);
        const middle = toScreen(held.before);
        held.mark.pose = {...held.mark.pose, ...held.kind === "move" ? {x_m, y_m}
          : {yaw_deg: Math.round(10 * wrapped(Math.atan2(middle[1] - now[1], now[0] - middle[0]) * 180 / Math.PI)) / 10}};
        reading.textContent = held.kind === "move" ? `x ${number(x_m)} m, y ${number(y_m)} m`
          : `heading ${number(held.mark.pose.yaw_deg, 1)}°`;
        draw();
      }
    }
    fingers.set(event.pointerId, now);
  });
  canvas.addEventListener("pointerup", (event) => {
    if (!fingers.delete(event.pointerId) || !held) return;
    const {kind, mark: each, moved, before} = held;
    held = null;
    if (moved && kind !== "pan") {
      select(each.id, false);
      onMoved(each, each.pose, before);
    } else if (!moved && !(onPlaced && !each && onPlaced(...toMap(at(event))))) select(each?.id ?? null);
  });
  canvas.addEventListener("pointercancel", (event) => {
    fingers.delete(event.pointerId);
    if (held?.before) held.mark.pose = held.before;
    held = null;
    draw();
  });
  canvas.addEventListener("pointerleave", () => hover(null));
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoom(Math.exp(-event.deltaY / (event.deltaMode ? 15 : 400)), at(event));
  }, {passive: false});
  canvas.addEventListener("keydown", (event) => {
    const step = 48;
    const moves = {ArrowLeft: [step, 0], ArrowRight: [-step, 0], ArrowUp: [0, step], ArrowDown: [0, -step]};
    const to = {PageDown: 1, PageUp: -1}[event.key];
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (moves[event.key]) pan(...moves[event.key]);
    else if (event.key === "+" || event.key === "=") zoom(1.5);
    else if (event.key === "-") zoom(1 / 1.5);
    else if (event.key === "0") fit();
    else if (event.key === "Escape" && selected !== null) select(null);
    else if (to && shown.marks.length) {
      const place = shown.marks.findIndex(({id}) => id === selected);
      const next = shown.marks[place < 0 ? (to > 0 ? 0 : shown.marks.length - 1) : (place + to + shown.marks.length) % shown.marks.length];
      select(next.id);
      reveal();
    } else return;
    event.preventDefault();
  });

  const sized = new ResizeObserver(() => {
    const {clientWidth: width, clientHeight: height} = canvas;
    if (!width || !height) return;
    size = {width, height};
    const ratio = window.devicePixelRatio || 1;
    Object.assign(canvas, {width: Math.round(width * ratio), height: Math.round(height * ratio)});
    isFitted ? fit() : paint();
  });
  sized.observe(canvas);
  signal.addEventListener("abort", () => sized.disconnect());
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw, {signal});
  return {
    node, fit,
    select(id) { select(id, false); reveal(); },
    // `found` are poses with their covariance, `path` poses in their order, `support` ids of marks.
    show({marks = [], support = [], found = [], path = []}) {
      shown = {marks, support: new Set(support), found, path};
      if (selected !== null && !mark(selected)) selected = null;
      describe();
      draw();
    },
    // The place in the map that a point of the window is over; null beside it.
    under({clientX, clientY}) {
      const box = canvas.getBoundingClientRect();
      const [x, y] = [clientX - box.left, clientY - box.top];
      if (x < 0 || y < 0 || x > box.width || y > box.height) return null;
      isFitted = false;
      return toMap([x, y]);
    },
    middle: () => [view.x, view.y],
  };
}
