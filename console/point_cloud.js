// A point cloud, rotated with the mouse or the arrow keys. Drawn in software: each point is two by two pixels, with a
// z-buffer.

import {h} from "./dom.js";
import {packed} from "./false_colours.js";

const [WIDTH, HEIGHT] = [640, 460];
const START = {yaw: 0.55, pitch: 0.35, zoom: 1};
const MOST_STRETCH = 1.5; // a cloud deeper than this times its breadth is drawn compressed, with a note

// `points` has x right, y down, z away of each point in mm; `colours` its [r, g, b] in bytes.
export function pointCloud(points, colours) {
  const count = points.length / 3;
  const [least, most] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
  for (let at = 0; at < points.length; at += 1) {
    least[at % 3] = Math.min(least[at % 3], points[at]);
    most[at % 3] = Math.max(most[at % 3], points[at]);
  }
  const size = most.map((value, axis) => value - least[axis] || 1);
  const breadth = Math.max(size[0], size[1]);
  const squeeze = size[2] > MOST_STRETCH * breadth ? MOST_STRETCH * breadth / size[2] : 1;
  const middle = most.map((value, axis) => (value + least[axis]) / 2);
  const reach = 0.5 * Math.hypot(size[0], size[1], size[2] * squeeze);

  const canvas = h("canvas", {width: WIDTH, height: HEIGHT, tabindex: 0, class: "cloud", id: "point-cloud", role: "application",
    "aria-label": `Point cloud of ${count} points: arrow keys turn it, plus and minus enlarge and shrink, Home turns it back`});
  const context = canvas.getContext("2d");
  const image = context.createImageData(WIDTH, HEIGHT);
  const pixels = new Uint32Array(image.data.buffer);
  const depths = new Float32Array(WIDTH * HEIGHT);
  const inks = Uint32Array.from({length: count}, (_, k) => packed(colours.slice(3 * k, 3 * k + 3)));
  let view = {...START};
  let asked = 0;

  function draw() {
    asked = 0;
    pixels.fill(0);
    depths.fill(Infinity);
    const scale = 0.62 * HEIGHT / reach * view.zoom;
    const [cy, sy, cp, sp] = [Math.cos(view.yaw), Math.sin(view.yaw), Math.cos(view.pitch), Math.sin(view.pitch)];
    for (let k = 0; k < count; k += 1) {
      const [x, y, z] = [points[3 * k] - middle[0], points[3 * k + 1] - middle[1], (points[3 * k + 2] - middle[2]) * squeeze];
      const across = cy * x + sy * z;
      const away = cy * z - sy * x;
      const [down, behind] = [cp * y - sp * away, cp * away + sp * y];
      const near = 3 * reach / (3 * reach + behind); // a little perspective
      const [column, row] = [Math.round(WIDTH / 2 + scale * near * across), Math.round(HEIGHT / 2 + scale * near * down)];
      if (column < 0 || row < 0 || column >= WIDTH - 1 || row >= HEIGHT - 1) continue;
      for (const at of [row * WIDTH + column, row * WIDTH + column + 1, (row + 1) * WIDTH + column, (row + 1) * WIDTH + column + 1]) {
        if (behind < depths[at]) {
          depths[at] = behind;
          pixels[at] = inks[k];
        }
      }
    }
    context.putImageData(image, 0, 0);
  }
  const change = (yaw, pitch, zoom = 1) => {
    view = {yaw: view.yaw + yaw, pitch: Math.min(Math.max(view.pitch + pitch, -1.55), 1.55),
      zoom: Math.min(Math.max(view.zoom * zoom, 0.5), 8)};
    asked ||= requestAnimationFrame(draw);
  };
  const reset = () => { view = {...START}; change(0, 0); };
  canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
  canvas.addEventListener("pointermove", (event) => { if (event.buttons) change(-event.movementX / 150, event.movementY / 150); });
  canvas.addEventListener("keydown", (event) => {
    const keys = {ArrowLeft: [0.1, 0], ArrowRight: [-0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1], "+": [0, 0, 1.2],
      "-": [0, 0, 1 / 1.2]};
    if (keys[event.key]) change(...keys[event.key]);
    else if (event.key === "Home") reset();
    else return;
    event.preventDefault();
  });
  draw();
  return h("div", {}, canvas,
    h("div", {class: "row"},
      h("button", {type: "button", class: "quiet small", onClick: () => change(0, 0, 1.25)}, "Enlarge"),
      h("button", {type: "button", class: "quiet small", onClick: () => change(0, 0, 0.8)}, "Shrink"),
      h("button", {type: "button", class: "quiet small", onClick: reset}, "Turn back")),
    h("p", {class: "muted"},
      `${count.toLocaleString("en")} points, ${size.map((mm) => mm.toFixed(0)).join(" × ")} mm. Drag, or use the arrow keys.`,
      squeeze < 1 ? ` Depth is drawn at ${squeeze.toPrecision(2)} of its scale.` : ""));
}
