//! Polar sub-windows about interest points (A§4.3): rows are rings r, columns are sectors θ.
//!
//! Ring k lies at radius (k + ½)·radius/rings, sector s at the angle 2π·s/sectors, from x towards y. So
//! turning the image about the point shifts the columns cyclically, and nothing else. Samples are
//! bilinear; outside the image its border is continued.

use pulp::{Arch, Simd, WithSimd};

use crate::imaging::Image;

/// Samples whose places are computed together.
const LANES: usize = 32;

/// Where the samples of a sub-window lie, relative to its point.
#[derive(Clone, Debug)]
pub struct PolarGrid {
    rings: usize,
    sectors: usize,
    /// Of every sample, ring by ring, and then zeros up to a multiple of [`LANES`].
    dx_px: Vec<f32>,
    dy_px: Vec<f32>,
}

/// One sub-window in polar form.
#[derive(Clone, Debug, PartialEq)]
pub struct PolarSubwindow {
    /// Rows.
    pub rings: usize,
    /// Columns.
    pub sectors: usize,
    /// Gray levels, ring by ring.
    pub samples: Vec<f32>,
}

impl PolarGrid {
    /// A grid of `rings` × `sectors` samples within `radius_px`.
    pub fn new(radius_px: f64, rings: usize, sectors: usize) -> PolarGrid {
        let padded = (rings * sectors).next_multiple_of(LANES);
        let [mut dx_px, mut dy_px] = [(); 2].map(|()| vec![0.0; padded]);
        for sample in 0..rings * sectors {
            let (ring, sector) = (sample / sectors, sample % sectors);
            let radius = (ring as f64 + 0.5) * radius_px / rings as f64;
            let (sin, cos) = (std::f64::consts::TAU * sector as f64 / sectors as f64).sin_cos();
            dx_px[sample] = (radius * cos) as f32;
            dy_px[sample] = (radius * sin) as f32;
        }
        PolarGrid { rings, sectors, dx_px, dy_px }
    }

    /// Rows of the sub-windows.
    pub fn rings(&self) -> usize {
        self.rings
    }

    /// Columns of the sub-windows.
    pub fn sectors(&self) -> usize {
        self.sectors
    }

    /// The sub-window about a point.
    pub fn subwindow(&self, image: &Image, x_px: f32, y_px: f32) -> PolarSubwindow {
        let mut samples = vec![0.0; self.rings * self.sectors];
        self.sample(image, x_px, y_px, &mut samples);
        PolarSubwindow { rings: self.rings, sectors: self.sectors, samples }
    }

    /// Writes the samples of the sub-window about a point, ring by ring.
    ///
    /// # Panics
    /// If `samples` does not hold rings × sectors values, or the image is empty.
    pub fn sample(&self, image: &Image, x_px: f32, y_px: f32, samples: &mut [f32]) {
        assert_eq!(samples.len(), self.rings * self.sectors, "one value a sample");
        assert!(!image.pixels().is_empty(), "there is a pixel to sample");
        Arch::new().dispatch(Sample { grid: self, image, x_px, y_px, samples });
    }
}

struct Sample<'a> {
    grid: &'a PolarGrid,
    image: &'a Image,
    x_px: f32,
    y_px: f32,
    samples: &'a mut [f32],
}

/// The position clamped to 0..=`last`, NaN to 0: unlike `clamp`, which keeps NaN.
#[inline(always)]
fn within(position: f32, last: f32) -> f32 {
    let position = if position > 0.0 { position } else { 0.0 };
    if position < last { position } else { last }
}

/// The whole number at or before a position ≥ 0; of a whole position, this or the one before.
///
/// By adding so much that f32 has no place for a fraction: unlike a cast this is a vector instruction.
#[inline(always)]
fn below(position: f32) -> i32 {
    const NO_FRACTION: f32 = (3 << 22) as f32;
    (position - 0.5 + NO_FRACTION).to_bits() as i32 - NO_FRACTION.to_bits() as i32
}

impl WithSimd for Sample<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let (width, height) = (self.image.width(), self.image.height());
        let (last_x, last_y) = (width - 1, height - 1);
        // the pixel left of a sample is the last but one at most, so that there is one on its right
        let (last_left, last_upper) = (last_x.saturating_sub(1) as i32, last_y.saturating_sub(1) as i32);
        let (right, lower) = (last_x.min(1), last_y.min(1) * width);
        // the four neighbours stand at the same place of these
        let pixels = self.image.pixels();
        let lower_right = &pixels[lower + right..];
        let lower_left = &pixels[lower..][..lower_right.len()];
        let upper_right = &pixels[right..][..lower_right.len()];
        let upper_left = &pixels[..lower_right.len()];

        let (dx_px, dy_px) = (self.grid.dx_px.as_chunks::<LANES>().0, self.grid.dy_px.as_chunks::<LANES>().0);
        for (chunk, samples) in self.samples.chunks_mut(LANES).enumerate() {
            let (dx_px, dy_px) = (&dx_px[chunk], &dy_px[chunk]);
            let mut places = [0; LANES];
            let [mut right_parts, mut lower_parts] = [[0.0; LANES]; 2];
            for lane in 0..LANES {
                let x = within(self.x_px + dx_px[lane], last_x as f32);
                let y = within(self.y_px + dy_px[lane], last_y as f32);
                let (left, upper) = (below(x).min(last_left), below(y).min(last_upper));
                places[lane] = upper * width as i32 + left;
                right_parts[lane] = x - left as f32;
                lower_parts[lane] = y - upper as f32;
            }
            for (lane, sample) in samples.iter_mut().enumerate() {
                let place = places[lane] as usize;
                let above = upper_left[place] + right_parts[lane] * (upper_right[place] - upper_left[place]);
                let below = lower_left[place] + right_parts[lane] * (lower_right[place] - lower_left[place]);
                *sample = above + lower_parts[lane] * (below - above);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// One bilinear sample, straight from the definition.
    fn bilinear(image: &Image, x: f64, y: f64) -> f64 {
        let x = x.clamp(0.0, (image.width() - 1) as f64);
        let y = y.clamp(0.0, (image.height() - 1) as f64);
        let rows = (0..image.height()).flat_map(|row| (0..image.width()).map(move |column| (column, row)));
        rows.map(|(column, row)| {
            let part = |from: f64, to: usize| (1.0 - (from - to as f64).abs()).max(0.0);
            part(x, column) * part(y, row) * f64::from(image.at(column, row))
        })
        .sum()
    }

    proptest! {
        #[test]
        fn samples_are_bilinear_wherever_the_point_lies(
            (width, height, levels) in (1usize..9, 1usize..9).prop_flat_map(|(width, height)| {
                (Just(width), Just(height), prop::collection::vec(0u8..=255, width * height))
            }),
            (x_px, y_px) in prop_oneof![
                (-5.0f32..12.0, -5.0f32..12.0),
                (-5i8..12, -5i8..12).prop_map(|(x, y)| (f32::from(x), f32::from(y))),
            ],
            radius_px in 0.5f64..6.0,
        ) {
            let image = Image::new(width, height, levels.into_iter().map(f32::from).collect());
            let grid = PolarGrid::new(radius_px, 3, 13);
            let window = grid.subwindow(&image, x_px, y_px);
            for (sample, (dx, dy)) in window.samples.iter().zip(grid.dx_px.iter().zip(&grid.dy_px)) {
                let expected = bilinear(&image, f64::from(x_px + dx), f64::from(y_px + dy));
                prop_assert!((f64::from(*sample) - expected).abs() < 1e-3, "{sample} is not {expected}");
            }
        }
    }

    #[test]
    fn samples_lie_where_the_text_says() {
        let slope = Image::from_fn(41, 41, |x, y| x as f32 + 100.0 * y as f32);
        let window = PolarGrid::new(8.0, 4, 8).subwindow(&slope, 20.0, 10.0);
        for ring in 0..4 {
            let radius = 1.0 + 2.0 * ring as f32;
            for sector in 0..8 {
                let (sin, cos) = (sector as f32 * std::f32::consts::FRAC_PI_4).sin_cos();
                let expected = 20.0 + radius * cos + 100.0 * (10.0 + radius * sin);
                let sample = window.samples[ring * 8 + sector];
                assert!((sample - expected).abs() < 0.01, "ring {ring}, sector {sector}: {sample}");
            }
        }
    }

    #[test]
    fn outside_the_border_is_continued() {
        let image = Image::from_fn(4, 4, |x, _| if x == 0 { 7.0 } else { 50.0 });
        let window = PolarGrid::new(60.0, 1, 4).subwindow(&image, 0.0, 0.0);
        assert_eq!(window.samples, [50.0, 7.0, 7.0, 7.0]);
        let dot = PolarGrid::new(5.0, 3, 4).subwindow(&Image::new(1, 1, vec![9.0]), 0.0, 0.0);
        assert!(dot.samples.iter().all(|&v| v == 9.0));
    }
}
