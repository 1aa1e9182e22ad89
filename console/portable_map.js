// Portable graymaps and pixmaps (PGM, PPM): cameras on robots send them, browsers don't show them.

import {h} from "./dom.js";

// Converts one to PNG; other pictures stay as they are.
export async function showable(blob) {
  const kind = /^P[2356]$/.exec(await blob.slice(0, 2).text())?.[0];
  if (!kind) return blob;
  const bytes = new Uint8Array(await blob.arrayBuffer());
  let at = 2;
  function next() {
    for (;; at += 1) {
      if (bytes[at] === 35) while (at < bytes.length && bytes[at] !== 10) at += 1; // a comment, to the end of its line
      else if (!(bytes[at] <= 32)) break;
    }
    let value = 0;
    for (; bytes[at] >= 48 && bytes[at] <= 57; at += 1) value = 10 * value + bytes[at] - 48;
    return value;
  }
  const [width, height, most] = [next(), next(), next()];
  at += 1;
  const sample = kind < "P4" ? next : most > 255 ? () => 256 * bytes[at++] + bytes[at++] : () => bytes[at++];
  const pixels = new ImageData(width, height);
  for (let i = 0; i < pixels.data.length; i += 4) {
    for (let channel = 0; channel < 3; channel += 1) {
      pixels.data[i + channel] = channel && kind !== "P3" && kind !== "P6" ? pixels.data[i] : 255 * sample() / most;
    }
    pixels.data[i + 3] = 255;
  }
  const canvas = h("canvas", {width, height});
  canvas.getContext("2d").putImageData(pixels, 0, 0);
  return new Promise((resolve) => canvas.toBlob(resolve));
}
