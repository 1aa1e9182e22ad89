// Numbers that look random and are the same in every run.

// Uniform in [0, 1), by mulberry32.
export function random(seed) {
  let state = seed >>> 0;
  return () => {
    state = (state + 0x6d2b79f5) >>> 0;
    let mixed = Math.imul(state ^ (state >>> 15), state | 1);
    mixed ^= mixed + Math.imul(mixed ^ (mixed >>> 7), mixed | 61);
    return ((mixed ^ (mixed >>> 14)) >>> 0) / 2 ** 32;
  };
}

// About normal, mean 0 and deviation 1: from a sum of four uniform ones.
export const normal = (uniform) => Math.sqrt(3) * (uniform() + uniform() + uniform() + uniform() - 2);
