// Things on a dark cloth, seen from above: alone on a turntable, or on a table. One unit is a millimetre; things turn
// counter-clockwise as the picture is seen.

import {Picture} from "./pictures.mjs";
import {random} from "./random.mjs";

const CLOTH = [9, 10, 11];

// The parts of a thing: bars [from x, from y, to x, to y, half width] and discs [x, y, radius], y away from the reader.
const THINGS = {
  bracket: [{bar: [-22, -14, 22, -14, 6], colour: [210, 200, 180]}, {bar: [-18, -14, -18, 20, 6], colour: [190, 120, 90]}, {disc: [16, -14, 3.5], colour: [70, 60, 60]}],
  lever: [{disc: [-16, 0, 9], colour: [120, 170, 220]}, {bar: [-10, 0, 26, 0, 4.5], colour: [200, 210, 215]}, {disc: [26, 3, 6], colour: [230, 190, 90]}],
  cam: [{disc: [0, 0, 15], colour: [130, 190, 130]}, {disc: [13, 6, 9], colour: [215, 215, 120]}, {disc: [-4, -4, 4], colour: [80, 50, 50]}],
  spanner: [{bar: [-24, 0, 18, 0, 4], colour: [170, 160, 200]}, {bar: [14, -11, 14, 11, 4], colour: [225, 225, 235]}, {bar: [14, 9, 26, 9, 3.5], colour: [190, 90, 110]}],
};
export const NAMES = ["bracket", "lever", "cam"];
// One without exemplars.
export const STRANGE = "spanner";

function isOn({bar, disc}, x, y) {
  if (disc) return Math.hypot(x - disc[0], y - disc[1]) < disc[2];
  const [x0, y0, x1, y1, half] = bar;
  const [dx, dy] = [x1 - x0, y1 - y0];
  const along = Math.min(Math.max(((x - x0) * dx + (y - y0) * dy) / (dx * dx + dy * dy), 0), 1);
  return Math.hypot(x - x0 - along * dx, y - y0 - along * dy) < half;
}

// The colour of a thing at a place of its own, the last part on top; null beside it.
const colourOf = (name, x, y) => THINGS[name].findLast((part) => isOn(part, x, y))?.colour ?? null;

function turned({name, x = 0, y = 0, turn_deg}) {
  const [cos, sin] = [Math.cos(turn_deg * Math.PI / 180), Math.sin(turn_deg * Math.PI / 180)];
  return (px, py) => {
    const [right, away] = [px - x, y - py];
    return Math.hypot(right, away) > 45 ? null : colourOf(name, right * cos + away * sin, away * cos - right * sin);
  };
}

// A thing alone, 1 px a millimetre.
export const onTurntable = (name, turn_deg, noise = 1) => {
  const thing = turned({name, turn_deg});
  return Picture.drawn(96, 96, (x, y) => thing(x - 47.5, y - 47.5) ?? CLOTH, 3).noisy(noise, Math.round(turn_deg) + name.length);
};

// Views all round, as [name of the file, bytes].
export const turntable = (name, step_deg = 12) =>
  Array.from({length: 360 / step_deg}, (_, k) => [`${name}__${k * step_deg}.png`, onTurntable(name, k * step_deg).png()]);

// A table of 480 × 360 px with things at pixels.
export function table(standing, noise = 1) {
  const things = standing.map(turned);
  const uniform = random(7);
  const grain = Array.from({length: 64}, () => 3 * uniform());
  return Picture.drawn(480, 360, (x, y) => {
    for (const thing of things) {
      const colour = thing(x, y);
      if (colour) return colour;
    }
    return CLOTH.map((value) => value + grain[Math.abs(Math.floor(x / 9) * 7 + Math.floor(y / 9)) % 64]);
  }, 2).noisy(noise, 99);
}

// The centroid of the visible pixels of a thing, in pixels of the table.
export function middle({name, x, y, turn_deg}) {
  const thing = turned({name, x, y, turn_deg});
  let [sumX, sumY, count] = [0, 0, 0];
  for (let py = y - 45; py <= y + 45; py += 0.5) {
    for (let px = x - 45; px <= x + 45; px += 0.5) if (thing(px, py)) [sumX, sumY, count] = [sumX + px, sumY + py, count + 1];
  }
  return [sumX / count, sumY / count];
}
