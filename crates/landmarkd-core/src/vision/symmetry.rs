//! The attention operator: isotropic generalised symmetry (A§4.2; Reisfeld, Wolfson, Yeshurun 1995).
//!
//! Two pixels i and j on either side of p, with gradient directions θᵢ, θⱼ, log magnitudes
//! r = ln(1 + ‖∇‖), and the direction α of the line through them, give p
//!
//! > exp(−‖i − j‖ / 2σ) · (1 − cos(θᵢ + θⱼ − 2α)) · (1 − cos(θᵢ − θⱼ)) · rᵢ · rⱼ
//!
//! summed over half a disc of offsets; σ is half of the disc's radius. Outside the image r = 0.
//!
//! The product of the two brackets is a square. By halved angles it is 4 sin²((θᵢ + θⱼ)/2 − α) · sin²((θᵢ − θⱼ)/2),
//! and that product of sines is half of a difference of cosines:
//!
//! > (cos(θᵢ − α) − cos(θⱼ − α))² = (d·(uᵢ − uⱼ))², u = (cos θ, sin θ), d = (cos α, sin α)
//!
//! so a pair costs a handful of operations and no trigonometry, three planes hold all that is known of a
//! pixel, and no part of the sum is negative.

use pulp::{Arch, Simd, WithSimd};

use super::gradient::GradientRows;
use crate::imaging::Image;

/// Pixels of a row whose sums are held in registers while all pairs pass over them: a quarter of AVX2's.
const TILE_PX: usize = 64;

/// Magnitudes below this have no direction.
const LEAST_MAGNITUDE: f32 = 1e-6;

/// How strongly edges face each other about each pixel, in a disc of `radius_px`; of the image's size.
///
/// The image should be smoothed (σ = 1 px) before. Values are ≥ 0 and grow with the logarithm of
/// contrast.
pub fn symmetry_map(image: &Image, radius_px: usize) -> Image {
    let (width, height) = (image.width(), image.height());
    if width == 0 || height == 0 {
        return image.clone();
    }
    let pairs = pairs(radius_px);
    let mut places = vec![(0, 0); pairs.len()];
    let mut edges = EdgeRows::new(width, radius_px);
    let mut map = vec![0.0; width * height];
    for row in 0..radius_px {
        edges.advance(image, row);
    }
    for (y, out) in map.chunks_exact_mut(width).enumerate() {
        edges.advance(image, y + radius_px);
        for (place, pair) in places.iter_mut().zip(&pairs) {
            *place = (edges.place(y, -pair.dx, -pair.dy), edges.place(y, pair.dx, pair.dy));
        }
        Arch::new().dispatch(AllPairs { edges: &edges, pairs: &pairs, places: &places, out });
    }
    Image::new(width, height, map)
}

/// The whole sum for the pixels of a row.
struct AllPairs<'a> {
    edges: &'a EdgeRows,
    pairs: &'a [Pair],
    /// For each pair, the indices of the two partners of the row's first pixel.
    places: &'a [(usize, usize)],
    out: &'a mut [f32],
}

impl WithSimd for AllPairs<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let strength = &self.edges.strength[..];
        let (x, y) = (&self.edges.x[..strength.len()], &self.edges.y[..strength.len()]);
        for (tile, out) in self.out.chunks_mut(TILE_PX).enumerate() {
            let start = tile * TILE_PX;
            let mut sums = [0.0; TILE_PX];
            for p in 0..self.pairs.len() {
                let (pair, (i, j)) = (&self.pairs[p], self.places[p]);
                let from = [tile_at(strength, start + i), tile_at(x, start + i), tile_at(y, start + i)];
                let to = [tile_at(strength, start + j), tile_at(x, start + j), tile_at(y, start + j)];
                pair.add(from, to, &mut sums);
            }
            out.copy_from_slice(&sums[..out.len()]);
        }
    }
}

/// The tile's pixels from one on; after a row's end they are of no meaning.
#[inline(always)]
fn tile_at(plane: &[f32], start: usize) -> &[f32; TILE_PX] {
    plane[start..].first_chunk().expect("planes have room for a whole tile after the last pixel")
}

/// Two pixels p − d and p + d, and what of their part does not depend on the image.
struct Pair {
    dx: isize,
    dy: isize,
    /// (cos α, sin α)·√w of the weight w = exp(−‖d‖/σ).
    along_x: f32,
    along_y: f32,
}

/// One pair for each offset of half a disc, row by row.
fn pairs(radius_px: usize) -> Vec<Pair> {
    let radius = radius_px as isize;
    let sigma = radius_px as f64 / 2.0;
    let half_disc = (0..=radius).flat_map(|dy| (-radius..=radius).map(move |dx| (dx, dy)));
    half_disc
        .filter(|&(dx, dy)| dy > 0 || dx > 0)
        .filter(|&(dx, dy)| dx * dx + dy * dy <= radius * radius)
        .map(|(dx, dy)| {
            let (x, y) = (dx as f64, dy as f64);
            let distance = x.hypot(y);
            let root = (-0.5 * distance / sigma).exp();
            Pair { dx, dy, along_x: (root * x / distance) as f32, along_y: (root * y / distance) as f32 }
        })
        .collect()
}

impl Pair {
    /// Adds this pair's part to every pixel of a tile, given the three planes along both lines of partners.
    #[inline(always)]
    fn add(
        &self,
        [ri, xi, yi]: [&[f32; TILE_PX]; 3],
        [rj, xj, yj]: [&[f32; TILE_PX]; 3],
        sums: &mut [f32; TILE_PX],
    ) {
        for p in 0..TILE_PX {
            let facing = self.along_x * (xi[p] - xj[p]) + self.along_y * (yi[p] - yj[p]);
            sums[p] += (facing * facing) * (ri[p] * rj[p]); // A§4.2
        }
    }
}

/// r and (cos θ, sin θ) of the rows that a disc reaches, with zeros outside the image.
struct EdgeRows {
    radius_px: usize,
    stride: usize,
    /// A ring of 2·radius + 1 rows: row y is at y modulo that.
    strength: Vec<f32>,
    x: Vec<f32>,
    y: Vec<f32>,
    gradient: GradientRows,
    gradient_x: Vec<f32>,
    gradient_y: Vec<f32>,
}

impl EdgeRows {
    fn new(width: usize, radius_px: usize) -> EdgeRows {
        let stride = width + 2 * radius_px;
        let ring = || vec![0.0; stride * (2 * radius_px + 1) + TILE_PX];
        EdgeRows {
            radius_px,
            stride,
            strength: ring(),
            x: ring(),
            y: ring(),
            gradient: GradientRows::new(width),
            gradient_x: vec![0.0; width],
            gradient_y: vec![0.0; width],
        }
    }

    /// Replaces the oldest row of the ring by `row`; below the image, by zeros.
    fn advance(&mut self, image: &Image, row: usize) {
        let width = image.width();
        let start = row % (2 * self.radius_px + 1) * self.stride + self.radius_px;
        let strength = &mut self.strength[start..start + width];
        let (x, y) = (&mut self.x[start..start + width], &mut self.y[start..start + width]);
        if row < image.height() {
            self.gradient.write(image, row, &mut self.gradient_x, &mut self.gradient_y);
            let (from_x, from_y) = (&self.gradient_x[..], &self.gradient_y[..]);
            Arch::new().dispatch(Root { from_x, from_y, strength, x, y });
        } else {
            strength.fill(0.0);
            x.fill(0.0);
            y.fill(0.0);
        }
    }

    /// Index of the pixel (dx, y + dy) in the ring's planes.
    fn place(&self, y: usize, dx: isize, dy: isize) -> usize {
        let kept = 2 * self.radius_px + 1;
        let row = (y + kept).wrapping_add_signed(dy) % kept;
        (row * self.stride + self.radius_px).wrapping_add_signed(dx)
    }
}

/// One row from gradients to edges.
struct Root<'a> {
    from_x: &'a [f32],
    from_y: &'a [f32],
    strength: &'a mut [f32],
    x: &'a mut [f32],
    y: &'a mut [f32],
}

impl WithSimd for Root<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let width = self.from_x.len();
        let (from_x, from_y) = (self.from_x, &self.from_y[..width]);
        let (strength, x, y) = (&mut self.strength[..width], &mut self.x[..width], &mut self.y[..width]);
        for p in 0..width {
            let (gx, gy) = (from_x[p], from_y[p]);
            let magnitude = (gx * gx + gy * gy).sqrt();
            let floor = if magnitude > LEAST_MAGNITUDE { magnitude } else { LEAST_MAGNITUDE };
            let scale = 1.0 / floor;
            strength[p] = ln_1p(magnitude); // A§4.2: r = log(1 + ‖∇‖)
            x[p] = scale * gx;
            y[p] = scale * gy;
        }
    }
}

/// ln(1 + m) for m ≥ 0, to an error of 2·10⁻⁷ absolute or relative, whichever is larger: the usual
/// series of ln((1 + s)/(1 − s)) on a mantissa in [√½, √2), without a branch so that it vectorises.
#[inline(always)]
fn ln_1p(m: f32) -> f32 {
    const ROOT_HALF_BITS: u32 = 0x3f35_04f3;
    const ONE_BITS: u32 = 0x3f80_0000;
    let bits = (1.0 + m).to_bits() + (ONE_BITS - ROOT_HALF_BITS);
    let exponent = (bits >> 23) as i32 - 127;
    let mantissa = f32::from_bits((bits & 0x007f_ffff) + ROOT_HALF_BITS);
    let f = mantissa - 1.0;
    let s = f / (2.0 + f);
    let z = s * s;
    let series = z * (0.666_666_6 + z * (0.400_009_7 + z * (0.284_987_87 + z * 0.242_790_79)));
    let half = 0.5 * f * f;
    let exponent = exponent as f32;
    exponent * std::f32::consts::LN_2 + (s * (half + series) - half + f)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::gradient::gradient;
    use super::*;

    /// Straight from the formula above, pixel by pixel and pair by pair, in f64 with angles.
    fn direct(image: &Image, radius_px: usize) -> Image {
        let (width, height) = (image.width(), image.height());
        let gradient = gradient(image);
        let edge = |x: isize, y: isize| {
            let inside = x >= 0 && y >= 0 && (x as usize) < width && (y as usize) < height;
            if !inside {
                return (0.0, 0.0);
            }
            let (gx, gy) = (
                f64::from(gradient.x.at(x as usize, y as usize)),
                f64::from(gradient.y.at(x as usize, y as usize)),
            );
            (gx.hypot(gy).ln_1p(), gy.atan2(gx))
        };
        let (radius, sigma) = (radius_px as isize, radius_px as f64 / 2.0);
        Image::from_fn(width, height, |x, y| {
            let (x, y) = (x as isize, y as isize);
            let mut sum = 0.0;
            for dy in -radius..=radius {
                for dx in -radius..=radius {
                    let distance = (dx as f64).hypot(dy as f64);
                    if distance == 0.0 || distance > radius as f64 {
                        continue;
                    }
                    let alpha = (dy as f64).atan2(dx as f64);
                    let ((ri, ti), (rj, tj)) = (edge(x - dx, y - dy), edge(x + dx, y + dy));
                    let facing = (1.0 - (ti + tj - 2.0 * alpha).cos()) * (1.0 - (ti - tj).cos());
                    sum += 0.5 * (-distance / sigma).exp() * facing * ri * rj; // every pair is met twice
                }
            }
            sum as f32
        })
    }

    fn pictures() -> impl Strategy<Value = Image> {
        (1usize..40, 1usize..14).prop_flat_map(|(width, height)| {
            prop::collection::vec(0u8..=255, width * height).prop_map(move |levels| {
                Image::new(width, height, levels.into_iter().map(f32::from).collect())
            })
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]
        #[test]
        fn products_equal_the_formula(image in pictures(), radius_px in 2usize..8) {
            let (fast, slow) = (symmetry_map(&image, radius_px), direct(&image, radius_px));
            let highest = slow.pixels().iter().fold(1.0f32, |m, &v| m.max(v));
            for (i, (a, b)) in fast.pixels().iter().zip(slow.pixels()).enumerate() {
                prop_assert!((a - b).abs() < 1e-4 * highest, "pixel {i}: {a} is not {b}");
            }
        }

        #[test]
        fn a_quarter_turn_turns_the_map(image in pictures(), radius_px in 2usize..8) {
            let (width, height) = (image.width(), image.height());
            let turned = Image::from_fn(height, width, |x, y| image.at(y, height - 1 - x));
            let (map, of_turned) = (symmetry_map(&image, radius_px), symmetry_map(&turned, radius_px));
            let highest = map.pixels().iter().fold(1.0f32, |m, &v| m.max(v));
            for (x, y) in (0..width).flat_map(|x| (0..height).map(move |y| (x, y))) {
                let difference = (map.at(x, y) - of_turned.at(height - 1 - y, x)).abs();
                prop_assert!(difference < 1e-4 * highest);
            }
        }
    }

    #[test]
    fn the_middle_of_a_spot_stands_out() {
        let spot = Image::from_fn(31, 31, |x, y| {
            let (dx, dy) = (x as f32 - 15.0, y as f32 - 15.0);
            if dx * dx + dy * dy <= 16.0 { 220.0 } else { 30.0 }
        });
        let map = symmetry_map(&super::super::smoothed(&spot, 1.0), 6);
        let best = (0..31 * 31).max_by(|&a, &b| map.pixels()[a].total_cmp(&map.pixels()[b])).unwrap();
        assert_eq!((best % 31, best / 31), (15, 15));
    }

    #[test]
    fn flat_and_tiny_pictures_are_calm_at_every_radius() {
        for (width, height) in [(0, 0), (0, 5), (5, 0), (1, 1), (2, 1), (1, 9), (300, 1), (1, 300), (20, 20)]
        {
            let flat = Image::from_fn(width, height, |_, _| 128.0);
            for radius_px in 2..=16 {
                let map = symmetry_map(&flat, radius_px);
                assert_eq!((map.width(), map.height()), (width, height));
                assert!(map.pixels().iter().all(|&v| v == 0.0), "{width}×{height}, radius {radius_px}");
            }
        }
    }

    #[test]
    fn the_logarithm_is_near_enough() {
        let mut m = 0.0_f64;
        while m < 400.0 {
            let error = (f64::from(ln_1p(m as f32)) - (m as f32 as f64).ln_1p()).abs();
            assert!(error < 2e-7 * (m as f32 as f64).ln_1p().max(1.0), "ln(1 + {m}) is off by {error:e}");
            m = m * 1.01 + 1e-4;
        }
    }

    #[test]
    fn vector_instructions_change_no_bit() {
        let picture = Image::from_fn(161, 23, |x, y| ((x * x * 7 + y * 31 + x * y) % 251) as f32);
        let gradient = gradient(&picture);
        let mut plain = [[0.0; 161]; 3];
        let mut wide = [[0.0; 161]; 3];
        for row in 0..23 {
            let (from_x, from_y) = (gradient.x.row(row), gradient.y.row(row));
            let [strength, x, y] = &mut plain;
            Arch::Scalar.dispatch(Root { from_x, from_y, strength, x, y });
            let [strength, x, y] = &mut wide;
            Arch::new().dispatch(Root { from_x, from_y, strength, x, y });
            assert_eq!(plain, wide);
        }
        let (mut edges, pairs) = (EdgeRows::new(161, 6), pairs(6));
        (0..16).for_each(|row| edges.advance(&picture, row));
        let place = |p: &Pair| (edges.place(9, -p.dx, -p.dy), edges.place(9, p.dx, p.dy));
        let places: Vec<(usize, usize)> = pairs.iter().map(place).collect();
        let (mut a, mut b) = (vec![0.0; 161], vec![0.0; 161]);
        Arch::Scalar.dispatch(AllPairs { edges: &edges, pairs: &pairs, places: &places, out: &mut a });
        Arch::new().dispatch(AllPairs { edges: &edges, pairs: &pairs, places: &places, out: &mut b });
        assert!(a.iter().any(|&v| v > 1.0));
        assert_eq!(a, b);
    }
}
