//! The attention operator: isotropic generalised symmetry (A§4.2; Reisfeld, Wolfson, Yeshurun 1995).
//!
//! Two pixels i and j on either side of p, with gradient directions θᵢ, θⱼ, log magnitudes
//! r = ln(1 + ‖∇‖), and the direction α of the line through them, give p
//!
//! > exp(−‖i − j‖ / 2σ) · (1 − cos(θᵢ + θⱼ − 2α)) · (1 − cos(θᵢ − θⱼ)) · rᵢ · rⱼ
//!
//! summed over half a disc of offsets; σ is half of the disc's radius. Outside the image r = 0.
//!
//! With q = √r and the vector h = √r·(cos θ, sin θ), both cosines become products:
//!
//! > (qᵢqⱼ − (P cos 2α + Q sin 2α)) · (qᵢqⱼ − A),
//! > P = hxᵢhxⱼ − hyᵢhyⱼ, Q = hxᵢhyⱼ + hyᵢhxⱼ, A = hxᵢhxⱼ + hyᵢhyⱼ
//!
//! so a pair costs no division and no trigonometry, and three planes hold all that is known of a pixel.

use super::gradient::{Gradient, gradient};
use crate::imaging::Image;

/// Magnitudes below this have no direction.
const LEAST_MAGNITUDE: f32 = 1e-6;

/// How strongly edges face each other about each pixel, in a disc of `radius_px`; of the image's size.
///
/// The image should be smoothed (σ = 1 px) before. Values are ≥ 0 up to rounding and grow with the
/// logarithm of contrast.
pub fn symmetry_map(image: &Image, radius_px: usize) -> Image {
    let (width, height) = (image.width(), image.height());
    if width == 0 || height == 0 {
        return image.clone();
    }
    let edges = Edges::of(&gradient(image), radius_px);
    let pairs = pairs(radius_px);
    let mut map = vec![0.0; width * height];
    for (y, out) in map.chunks_exact_mut(width).enumerate() {
        let centre = (y + radius_px) * edges.stride + radius_px;
        pulp::Arch::new().dispatch(|| {
            for pair in &pairs {
                let offset = pair.dy * edges.stride as isize + pair.dx;
                let i = edges.along(centre.wrapping_add_signed(-offset), width);
                let j = edges.along(centre.wrapping_add_signed(offset), width);
                pair.add(i, j, out);
            }
        });
    }
    Image::new(width, height, map)
}

/// Two pixels p − d and p + d, and what of their weight does not depend on the image.
struct Pair {
    dx: isize,
    dy: isize,
    /// exp(−‖d‖/σ).
    weight: f32,
    /// cos 2α.
    cos: f32,
    /// sin 2α.
    sin: f32,
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
            let square = x * x + y * y;
            Pair {
                dx,
                dy,
                weight: (-square.sqrt() / sigma).exp() as f32,
                cos: ((x * x - y * y) / square) as f32,
                sin: (2.0 * x * y / square) as f32,
            }
        })
        .collect()
}

impl Pair {
    /// Add this pair's part to every pixel of a row, given the three planes along both lines of partners.
    #[inline(always)]
    fn add(&self, [qi, xi, yi]: [&[f32]; 3], [qj, xj, yj]: [&[f32]; 3], out: &mut [f32]) {
        let length = out.len();
        let (qi, xi, yi) = (&qi[..length], &xi[..length], &yi[..length]);
        let (qj, xj, yj) = (&qj[..length], &xj[..length], &yj[..length]);
        for p in 0..length {
            let strength = qi[p] * qj[p];
            let (xx, yy) = (xi[p] * xj[p], yi[p] * yj[p]);
            let crossed = xi[p] * yj[p] + yi[p] * xj[p]; // Q
            let mirrored = self.cos * (xx - yy) + self.sin * crossed; // A§4.2: cos(θi + θj − 2α)
            let parallel = xx + yy; // A§4.2: cos(θi − θj)
            out[p] += self.weight * ((strength - mirrored) * (strength - parallel));
        }
    }
}

/// √r and √r·(cos θ, sin θ) of every pixel, with a border of zeros as wide as the disc's radius.
struct Edges {
    stride: usize,
    strength: Vec<f32>,
    x: Vec<f32>,
    y: Vec<f32>,
}

impl Edges {
    fn of(gradient: &Gradient, border_px: usize) -> Edges {
        let (width, height) = (gradient.x.width(), gradient.x.height());
        let stride = width + 2 * border_px;
        let plane = || vec![0.0; stride * (height + 2 * border_px)];
        let mut edges = Edges { stride, strength: plane(), x: plane(), y: plane() };
        for row in 0..height {
            let start = (row + border_px) * stride + border_px;
            let strength = &mut edges.strength[start..start + width];
            let (x, y) = (&mut edges.x[start..start + width], &mut edges.y[start..start + width]);
            let (from_x, from_y) = (gradient.x.row(row), gradient.y.row(row));
            pulp::Arch::new().dispatch(|| rooted(from_x, from_y, strength, x, y));
        }
        edges
    }

    /// The three planes of `width` pixels from a position on.
    #[inline(always)]
    fn along(&self, start: usize, width: usize) -> [&[f32]; 3] {
        [&self.strength[start..][..width], &self.x[start..][..width], &self.y[start..][..width]]
    }
}

#[inline(always)]
fn rooted(from_x: &[f32], from_y: &[f32], strength: &mut [f32], x: &mut [f32], y: &mut [f32]) {
    let width = from_x.len();
    let (from_y, strength) = (&from_y[..width], &mut strength[..width]);
    let (x, y) = (&mut x[..width], &mut y[..width]);
    for p in 0..width {
        let (gx, gy) = (from_x[p], from_y[p]);
        let magnitude = (gx * gx + gy * gy).sqrt();
        let root = ln_1p(magnitude).sqrt(); // A§4.2: r = log(1 + ‖∇‖)
        let floor = if magnitude > LEAST_MAGNITUDE { magnitude } else { LEAST_MAGNITUDE };
        let scale = root / floor;
        strength[p] = root;
        x[p] = scale * gx;
        y[p] = scale * gy;
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
