// A slanted plane of known distances, photographed twice: focused near and far, through a lens with a telecentric stop.
//
// By the lens law 1/f = 1/u + 1/v a point at u is sharp at v behind the lens; a sensor at s sees it as a disc of the
// diameter D |s − v| / f. The sensor of the near-focused picture stands farther from the lens than the other.

import {Picture} from "./pictures.mjs";
import {normal, random} from "./random.mjs";

export const OPTICS = {focal_length_mm: 35, f_number: 8, near_focus_mm: 500, plane_separation_mm: 0.4, pixel_pitch_um: 10};
const [WIDTH, HEIGHT] = [200, 150];
const FINE = 3; // places of light a pixel
const MARGIN = 6; // px beyond the picture that send light into it

const {focal_length_mm: f, f_number, near_focus_mm, plane_separation_mm, pixel_pitch_um} = OPTICS;
const aperture = f / f_number;
const nearSensor = f * near_focus_mm / (near_focus_mm - f);
const farSensor = nearSensor - plane_separation_mm;

// Where the plane's points are sharp behind the lens: the near side of the range at the left, the far one at the right.
const sharpAt = (x) => farSensor + plane_separation_mm * (0.9 - 0.8 * (x / (WIDTH - 1)));

// The distance of what a pixel shows, in mm.
export const truth_mm = (x) => { const v = sharpAt(x); return f * v / (v - f); };

// Light with detail of several sizes, already gathered over a pixel's square.
function light(seed) {
  const uniform = random(seed);
  const [width, height] = [FINE * (WIDTH + 2 * MARGIN), FINE * (HEIGHT + 2 * MARGIN)];
  const grains = new Float32Array(width * height);
  for (const [size, strength] of [[4, 34], [9, 26], [27, 16]]) {
    const columns = Math.ceil(width / size) + 2;
    const nodes = Float32Array.from({length: columns * (Math.ceil(height / size) + 2)}, () => strength * normal(uniform));
    for (let at = 0; at < grains.length; at += 1) {
      const [x, y] = [at % width / size, Math.floor(at / width) / size];
      const [u, v] = [x % 1, y % 1];
      const first = Math.floor(y) * columns + Math.floor(x);
      grains[at] += (1 - v) * ((1 - u) * nodes[first] + u * nodes[first + 1]) + v * ((1 - u) * nodes[first + columns] + u * nodes[first + columns + 1]);
    }
  }
  const gathered = new Float32Array(grains.length);
  for (let y = 1; y < height - 1; y += 1) {
    for (let x = 1; x < width - 1; x += 1) {
      let sum = 0;
      for (let dy = -1; dy <= 1; dy += 1) for (let dx = -1; dx <= 1; dx += 1) sum += grains[(y + dy) * width + x + dx];
      gathered[y * width + x] = 120 + sum / 9;
    }
  }
  return {width, gathered};
}

function photograph({width, gathered}, sensor, seed) {
  // All of a column is as far: one disc for it. Its rim counts by the part that is inside.
  const discs = Array.from({length: WIDTH}, (_, x) => {
    const radius = FINE * aperture * Math.abs(sensor - sharpAt(x)) / f / (pixel_pitch_um / 1000) / 2;
    const reach = Math.ceil(radius + 1);
    const weights = [];
    for (let dy = -reach; dy <= reach; dy += 1) {
      for (let dx = -reach; dx <= reach; dx += 1) {
        const part = Math.min(Math.max(radius + 0.5 - Math.hypot(dx, dy), 0), 1);
        if (part > 0) weights.push([dy * width + dx, part]);
      }
    }
    const whole = weights.reduce((sum, [, part]) => sum + part, 0);
    return weights.map(([offset, part]) => [offset, part / whole]);
  });
  return Picture.drawn(WIDTH, HEIGHT, (x, y) => {
    const middle = (FINE * (y + MARGIN) + 1) * width + FINE * (x + MARGIN) + 1;
    let sum = 0;
    for (const [offset, part] of discs[x]) sum += part * gathered[middle + offset];
    return [sum, sum, sum];
  }, 1).noisy(0.7, seed);
}

export function focalPair(seed = 5) {
  const scene = light(seed);
  return {near: photograph(scene, nearSensor, seed + 1), far: photograph(scene, farSensor, seed + 2), width: WIDTH, height: HEIGHT};
}
