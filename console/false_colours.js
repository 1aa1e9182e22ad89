// Colour maps: Turbo, reversed as in the service's own previews, so that near is red and far is blue; and a sequential map
// from dark to light.

const NEAR_TO_FAR = [[160, 19, 3], [196, 40, 9], [228, 71, 18], [255, 130, 29], [254, 184, 38], [211, 228, 54], [146, 250, 81],
  [87, 250, 121], [46, 228, 175], [37, 188, 224], [56, 134, 248], [74, 77, 205], [64, 58, 160]];
const LITTLE_TO_MUCH = [[12, 42, 66], [20, 92, 110], [66, 148, 130], [160, 200, 130], [253, 245, 190]];

// A colour map as a function from 0 to 1 to [r, g, b], linear between the stops.
const ramp = (stops) => (part) => {
  const at = Math.min(Math.max(part, 0), 1) * (stops.length - 1);
  const low = Math.min(Math.floor(at), stops.length - 2);
  return stops[low].map((value, k) => Math.round(value + (stops[low + 1][k] - value) * (at - low)));
};

export const nearToFar = ramp(NEAR_TO_FAR);
export const littleToMuch = ramp(LITTLE_TO_MUCH);
export const css = ([r, g, b]) => `rgb(${r} ${g} ${b})`;
// As a pixel of a picture's bytes seen as 32-bit numbers, opaque; 0 is clear.
export const packed = ([r, g, b]) => (0xff000000 | b << 16 | g << 8 | r) >>> 0;

// The same for pixels: from a value between `from` and `to`, by a table of 256.
export function pixelRamp(ramp, [from, to]) {
  const table = Uint32Array.from({length: 256}, (_, k) => packed(ramp(k / 255)));
  const steps = to > from ? 255 / (to - from) : 0;
  return (value) => table[steps ? Math.min(Math.max(Math.round((value - from) * steps), 0), 255) : 127];
}

const MOST_SORTED = 200000;

// The quantiles of an array's finite values; of a large array, those of every n-th value.
export function quantiles(values, parts) {
  const stride = Math.ceil(values.length / MOST_SORTED);
  const known = values.filter((value, at) => at % stride === 0 && Number.isFinite(value)).sort();
  return known.length ? parts.map((part) => known[Math.round(part * (known.length - 1))]) : null;
}
