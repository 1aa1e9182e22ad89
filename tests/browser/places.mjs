// Places: walls full of things, seen from here and there.

import {Picture} from "./pictures.mjs";
import {random} from "./random.mjs";

const WALL = [460, 380]; // px
const VIEW = [160, 120];
const THINGS = 240;

// A wall of a place: rectangles and discs, some striped, painted over one another. A place is its seed.
function wall(seed) {
  const uniform = random(seed);
  const colour = () => [0, 0, 0].map(() => 30 + 200 * uniform());
  const ground = colour();
  const picture = new Picture(...WALL);
  picture.data.forEach((_, at) => { picture.data[at] = ground[at % 3]; });
  for (let n = 0; n < THINGS; n += 1) {
    const [x, y, wide, tall] = [WALL[0] * uniform(), WALL[1] * uniform(), 5 + 26 * uniform(), 5 + 26 * uniform()];
    const [isRound, stripe, turn, colours] = [uniform() < 0.4, uniform() < 0.4 ? 3 + 6 * uniform() : 0, Math.PI * uniform(), [colour(), colour()]];
    const [cos, sin, reach] = [Math.cos(turn), Math.sin(turn), Math.ceil(Math.hypot(wide, tall) / 2)];
    for (let py = Math.max(Math.ceil(y - reach), 0); py <= Math.min(y + reach, WALL[1] - 1); py += 1) {
      for (let px = Math.max(Math.ceil(x - reach), 0); px <= Math.min(x + reach, WALL[0] - 1); px += 1) {
        const [u, v] = [(px - x) * cos + (py - y) * sin, (py - y) * cos - (px - x) * sin];
        if (isRound ? u * u + v * v > wide * tall / 4 : Math.abs(u) > wide / 2 || Math.abs(v) > tall / 2) continue;
        picture.data.set(colours[stripe && Math.floor(u / stripe) % 2 ? 1 : 0], 3 * (py * WALL[0] + px));
      }
    }
  }
  return picture;
}

const walls = new Map();

// A view of a place: the camera displaced, turned and nearer, and its noise.
export function place(seed, {right = 0, down = 0, turn_deg = 0, scale = 1, noise = 2} = {}) {
  if (!walls.has(seed)) walls.set(seed, wall(seed));
  const [cos, sin] = [Math.cos(turn_deg * Math.PI / 180) / scale, Math.sin(turn_deg * Math.PI / 180) / scale];
  return Picture.drawn(...VIEW, (x, y) => {
    const [dx, dy] = [x - VIEW[0] / 2, y - VIEW[1] / 2];
    return walls.get(seed).at(WALL[0] / 2 + right + dx * cos + dy * sin, WALL[1] / 2 + down - dx * sin + dy * cos);
  }, 1).noisy(noise, seed + Math.round(1000 * (right + 10 * down + turn_deg)));
}

// Views of a place to learn it from, as [name of the file, bytes].
const VIEWS = [{}, {right: 16, turn_deg: 4}, {right: -14, down: 8, turn_deg: -5}, {down: -13, scale: 1.06}, {right: 9, down: 12, turn_deg: 8}, {right: -8, down: -9, scale: 0.95}];
export const views = (seed, many = 4) => VIEWS.slice(0, many).map((view, at) => [`${at}.png`, place(seed, view).png()]);

// A frame of a place that was never learnt so.
export const frame = (seed) => place(seed, {right: 6, down: -5, turn_deg: 3, noise: 3});

// A wall without anything on it.
export const blank = () => Picture.drawn(...VIEW, () => [128, 128, 128], 1);
