// Pictures as the tests draw them, and as PNG. Colours are [red, green, blue] in 0 to 255; x right, y down, and the origin
// is the centre of the top-left pixel.

import {crc32} from "./crc.mjs";
import {deflateSync} from "node:zlib";
import {normal, random} from "./random.mjs";

const SIGNATURE = Buffer.from([137, 80, 78, 71, 13, 10, 26, 10]);

function chunk(kind, data) {
  const body = Buffer.concat([Buffer.from(kind, "latin1"), data]);
  const length = Buffer.alloc(4);
  length.writeUInt32BE(data.length);
  const sum = Buffer.alloc(4);
  sum.writeUInt32BE(crc32(body));
  return Buffer.concat([length, body, sum]);
}

// Three values a pixel, as floats until they are written.
export class Picture {
  constructor(width, height, data = new Float32Array(3 * width * height)) {
    Object.assign(this, {width, height, data});
  }

  // `colour(x, y)` of each pixel, the mean of `fine` × `fine` places within it.
  static drawn(width, height, colour, fine = 2) {
    const picture = new Picture(width, height);
    for (let y = 0, at = 0; y < height; y += 1) {
      for (let x = 0; x < width; x += 1, at += 3) {
        for (let place = 0; place < fine * fine; place += 1) {
          const [dx, dy] = [(place % fine + 0.5) / fine - 0.5, (Math.floor(place / fine) + 0.5) / fine - 0.5];
          const [red, green, blue] = colour(x + dx, y + dy);
          picture.data[at] += red / fine ** 2;
          picture.data[at + 1] += green / fine ** 2;
          picture.data[at + 2] += blue / fine ** 2;
        }
      }
    }
    return picture;
  }

  // The colour between pixels, by the four around; beyond the border it is that of the border.
  at(x, y) {
    const column = Math.min(Math.max(x, 0), this.width - 1.001);
    const row = Math.min(Math.max(y, 0), this.height - 1.001);
    const [left, top] = [Math.floor(column), Math.floor(row)];
    const [u, v] = [column - left, row - top];
    const value = (k) => {
      const first = 3 * (top * this.width + left) + k;
      const below = first + 3 * this.width;
      return (1 - v) * ((1 - u) * this.data[first] + u * this.data[first + 3]) + v * ((1 - u) * this.data[below] + u * this.data[below + 3]);
    };
    return [value(0), value(1), value(2)];
  }

  // With the noise of a camera, in grey levels.
  noisy(deviation, seed) {
    const uniform = random(seed);
    return new Picture(this.width, this.height, this.data.map((value) => value + deviation * normal(uniform)));
  }

  // As PNG, 8 bits a value.
  png() {
    const line = 3 * this.width + 1; // with the filter's number, 0, before it
    const lines = Buffer.alloc(line * this.height);
    for (let y = 0, from = 0; y < this.height; y += 1) {
      for (let at = y * line + 1; at < (y + 1) * line; at += 1, from += 1) lines[at] = Math.round(Math.min(Math.max(this.data[from], 0), 255));
    }
    const header = Buffer.alloc(13);
    header.writeUInt32BE(this.width, 0);
    header.writeUInt32BE(this.height, 4);
    header.set([8, 2, 0, 0, 0], 8);
    return Buffer.concat([SIGNATURE, chunk("IHDR", header), chunk("IDAT", deflateSync(lines, {level: 1})), chunk("IEND", Buffer.alloc(0))]);
  }
}
