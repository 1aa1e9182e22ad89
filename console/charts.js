// Charts of a training's report, as SVG. Coordinates within a picture are its own units, about a CSS pixel each; each
// series has the class series-N, which style.css colours, and a dash pattern of its own.

import {h, picture, svg} from "./dom.js";
import {number} from "./parts.js";

const DASHES = [null, "6 4", "2 3"];
const series = (index) => `series-${index + 1}`;

// The legend of several series; null for a single one.
export function legend(names) {
  if (names.length < 2) return null;
  return h("p", {class: "series-names"}, names.map((name, index) => h("span", {class: series(index)},
    svg("svg", {viewBox: "0 0 24 8", width: 24, height: 8, "aria-hidden": "true"},
      svg("line", {class: "line", x1: 0, x2: 24, y1: 4, y2: 4, "stroke-dasharray": DASHES[index]})),
    " ", name)));
}

// Round numbers from `from` to `to`, about `count` of them: 1, 2 or 5 times a power of ten apart.
export function ticks(from, to, count = 5) {
  const span = (to - from) / count || 1;
  const power = 10 ** Math.floor(Math.log10(span));
  const step = power * ([1, 2, 5].find((factor) => factor * power >= span) ?? 10);
  const found = [];
  for (let value = Math.ceil(from / step) * step; value <= to + step * 1e-6; value += step) found.push(Number(value.toPrecision(12)));
  return found;
}

function powersOfTen(from, to) {
  const [least, most] = [Math.ceil(Math.log10(from)), Math.floor(Math.log10(to))];
  const step = Math.max(1, Math.ceil((most - least) / 5));
  return Array.from({length: Math.max(0, Math.floor((most - least) / step) + 1)}, (_, index) => 10 ** (least + index * step));
}

// The scale of an axis and its ticks. `pixels` is [position of the least value, of the largest].
function axis({from, to, log, whole}, pixels) {
  if (log && !(from > 0)) [from, to] = [0.1, 1];
  if (to <= from) to = from + 1;
  const way = log ? Math.log10 : (value) => value;
  const scale = (pixels[1] - pixels[0]) / (way(to) - way(from));
  return {at: (value) => pixels[0] + (way(value) - way(from)) * scale,
    ticks: log ? powersOfTen(from, to) : ticks(from, to).filter((value) => !whole || Number.isInteger(value))};
}

const extent = (values) => values.length ? [Math.min(...values), Math.max(...values)] : [0, 1];
const short = (value) => Math.abs(value) >= 1e4 || (value !== 0 && Math.abs(value) < 1e-3) ? value.toExponential(0).replace("e+", "e")
  : number(value, 3);

// Lines over common axes. `x` and `y`: {label, from?, to?, log?, whole?}. `lines`: [{name, points: [[x, y, size?]], dots?, mark?}],
// where `mark` is an x to be pointed out, and a dot's area goes with its size. `diagonal` draws x = y.
export function lineChart({title, x, y, lines, diagonal = false}) {
  const [width, height, left, right, top, bottom] = [420, 250, 52, 12, 12, 42];
  const points = lines.flatMap((line) => line.points);
  const [x0, x1] = extent(points.map((point) => point[0]));
  const [y0, y1] = extent(points.map((point) => point[1]));
  const across = axis({from: x0, to: x1, ...x}, [left, width - right]);
  const up = axis({from: y0, to: y1, ...y}, [height - bottom, top]);
  const largest = Math.max(...points.map((point) => point[2] ?? 1));
  return picture(title, width, height,
    up.ticks.map((value) => [
      svg("line", {class: "axis", x1: left, x2: width - right, y1: up.at(value), y2: up.at(value)}),
      svg("text", {x: left - 6, y: up.at(value) + 4, "text-anchor": "end"}, short(value))]),
    across.ticks.map((value) => svg("text", {x: across.at(value), y: height - bottom + 16, "text-anchor": "middle"}, short(value))),
    svg("line", {class: "axis", x1: left, x2: width - right, y1: height - bottom, y2: height - bottom}),
    svg("text", {x: (left + width - right) / 2, y: height - 6, "text-anchor": "middle"}, x.label),
    svg("text", {x: 0, y: 0, "text-anchor": "middle", transform: `translate(11 ${(top + height - bottom) / 2}) rotate(-90)`}, y.label),
    diagonal && svg("line", {class: "axis ideal", x1: across.at(0), y1: up.at(0), x2: across.at(1), y2: up.at(1)}),
    lines.map((line, index) => svg("g", {class: series(index)},
      line.mark !== undefined
        && svg("line", {class: "mark", x1: across.at(line.mark), x2: across.at(line.mark), y1: top, y2: height - bottom}),
      svg("polyline", {class: "line", "stroke-dasharray": DASHES[index],
        points: line.points.map((point) => `${across.at(point[0]).toFixed(1)},${up.at(point[1]).toFixed(1)}`).join(" ")}),
      line.dots && line.points.map((point) => svg("circle",
        {class: "dot", cx: across.at(point[0]), cy: up.at(point[1]), r: 2.5 + 5 * Math.sqrt((point[2] ?? 0) / largest)},
        svg("title", {}, `${short(point[0])}: ${short(point[1])}${point[2] ? `, ${point[2]} answers` : ""}`))))));
}

const LEAST_DEG = 0.1;

// Rows of a bar up to `far`, with a stroke at `middle`: the errors of poses, in degrees. A look-alike seen from behind is
// wrong by 180 and a good one by less than 1, so that the axis is logarithmic. `rows`: [{name, bars: [{middle, far}]}], a bar
// for each series.
export function barChart({title, label, rows}) {
  const [width, left, right, thick] = [420, 92, 14, 9];
  const count = Math.max(...rows.map((row) => row.bars.length));
  const pitch = count * (thick + 2) + 7;
  const height = rows.length * pitch + 40;
  const scale = axis({from: LEAST_DEG, to: 180, log: true}, [left, width - right]);
  const across = {at: (deg) => scale.at(Math.max(deg, LEAST_DEG)), ticks: [0.1, 1, 5, 20, 90, 180]};
  return picture(title, width, height,
    across.ticks.map((value) => [
      svg("line", {class: "axis", x1: across.at(value), x2: across.at(value), y1: 0, y2: height - 38}),
      svg("text", {x: across.at(value), y: height - 24, "text-anchor": "middle"}, short(value))]),
    svg("text", {x: (left + width - right) / 2, y: height - 6, "text-anchor": "middle"}, label),
    rows.map((row, line) => [
      svg("text", {x: left - 6, y: line * pitch + pitch / 2 + 3, "text-anchor": "end"}, clip(row.name, 14), svg("title", {}, row.name)),
      row.bars.map((bar, index) => bar && svg("g", {class: series(index)},
        svg("rect", {class: "bar-far",
          x: left, width: Math.max(1, across.at(bar.far) - left), y: line * pitch + 4 + index * (thick + 2), height: thick}),
        svg("rect", {class: "bar-middle",
          x: across.at(bar.middle) - 1.5, width: 3, y: line * pitch + 3 + index * (thick + 2), height: thick + 2}),
        svg("title", {}, `${row.name}: median ${number(bar.middle)}°, 95 % within ${number(bar.far)}°`)))]));
}

const clip = (text, length) => text.length > length ? `${text.slice(0, length - 1)}…` : text;

// How often what is shown (rows) was named as what (columns). `counts`: shown -> named -> times.
export function matrix({title, rows, columns, counts}) {
  const cell = Math.max(11, Math.min(30, 320 / columns.length));
  const [left, top] = [92, 70];
  const [width, height] = [Math.max(300, left + columns.length * cell + 40), top + rows.length * cell + 4];
  return picture(title, width, height,
    columns.map((named, column) => svg("text", {transform: `translate(${left + (column + 0.5) * cell + 3} ${top - 6}) rotate(-50)`},
      clip(named, 11))),
    rows.map((shown, row) => {
      const times = columns.map((named) => counts.get(shown)?.get(named) ?? 0);
      const sum = times.reduce((a, b) => a + b, 0) || 1;
      return [
        svg("text", {x: left - 6, y: top + (row + 0.5) * cell + 4, "text-anchor": "end"}, clip(shown, 13)),
        times.map((count, column) => [
          svg("rect", {class: columns[column] === shown ? "cell right" : "cell wrong",
            "fill-opacity": count ? 0.15 + 0.85 * count / sum : 0,
            x: left + column * cell, y: top + row * cell, width: cell - 1, height: cell - 1},
            svg("title", {}, `${shown} named ${columns[column]}: ${count}`)),
          count > 0 && cell >= 14 && svg("text", {class: count / sum > 0.5 ? "on" : "off", "text-anchor": "middle",
            x: left + (column + 0.5) * cell, y: top + (row + 0.5) * cell + 4}, count)])];
    }));
}

// The turntable from above, 0° at the top and clockwise on: a tick for each view's pose, an arc for each gap.
export function ring({title, poses, gaps}) {
  const [size, radius] = [150, 52];
  const middle = size / 2;
  const at = (deg, distance) => {
    const angle = (deg - 90) * Math.PI / 180;
    return [middle + distance * Math.cos(angle), middle + distance * Math.sin(angle)];
  };
  const arc = ({from_deg: from, to_deg: to}) => {
    const turn = (to - from + 360) % 360 || 360;
    const [a, b] = [at(from, radius), at(from + Math.min(turn, 359.9), radius)];
    return `M${a.join(" ")} A${radius} ${radius} 0 ${turn > 180 ? 1 : 0} 1 ${b.join(" ")}`;
  };
  return picture(title, size, size,
    svg("circle", {class: "axis", cx: middle, cy: middle, r: radius}),
    gaps.map((gap) => svg("path", {class: "gap", d: arc(gap)})),
    poses.map((pose) => {
      const [[x1, y1], [x2, y2]] = [at(pose, radius - 6), at(pose, radius + 6)];
      return svg("line", {class: "turn", x1, y1, x2, y2});
    }),
    [0, 90, 180, 270].map((deg) => {
      const [x, y] = at(deg, radius - 18);
      return svg("text", {x, y: y + 4, "text-anchor": "middle"}, `${deg}°`);
    }));
}
