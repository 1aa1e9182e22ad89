// Arrays of NumPy as the service writes them: float32, little-endian, in C order. The header is a Python dictionary
// behind a magic number, a version and its own length (numpy.lib.format).

const MAGIC = "\x93NUMPY";

// {shape, data} of the bytes; `data` is a Float32Array that shares them where it can.
export function readNpy(buffer) {
  const view = new DataView(buffer);
  const magic = String.fromCharCode(...new Uint8Array(buffer, 0, MAGIC.length));
  if (magic !== MAGIC) throw new Error("The service sent no array.");
  const [length, start] = view.getUint8(6) === 1 ? [view.getUint16(8, true), 10] : [view.getUint32(8, true), 12];
  const header = new TextDecoder("latin1").decode(new Uint8Array(buffer, start, length));
  const shape = header.match(/'shape': \(([^)]*)\)/)?.[1].split(",").map((side) => side.trim()).filter(Boolean).map(Number);
  if (!shape || !header.includes("'<f4'") || !header.includes("'fortran_order': False")) {
    throw new Error(`The array isn't float32 in C order: ${header.trim()}`);
  }
  const count = shape.reduce((product, side) => product * side, 1);
  const at = start + length;
  return {shape, data: new Float32Array(at % 4 ? buffer.slice(at) : buffer, at % 4 ? 0 : at, count)};
}
