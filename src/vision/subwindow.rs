//! Polar sub-windows about interest points (A§4.3): rows are rings r, columns are sectors θ.
//!
//! Ring k lies at radius (k + ½)·radius/rings, sector s at the angle 2π·s/sectors, from x towards y. So
//! turning the image about the point shifts the columns cyclically, and nothing else. Samples are
//! bilinear; outside the image its border is continued.

use crate::imaging::Image;

/// Where the samples of a sub-window lie, relative to its point.
#[derive(Clone, Debug)]
pub struct PolarGrid {
    rings: usize,
    sectors: usize,
    /// (dx, dy) of every sample, ring by ring.
    offsets_px: Vec<(f32, f32)>,
}

/// One sub-window in polar form.
#[derive(Clone, Debug, PartialEq)]
pub struct PolarSubwindow {
    /// Rows.
    pub rings: usize,
    /// Columns.
    pub sectors: usize,
    /// Grey levels, ring by ring.
    pub samples: Vec<f32>,
}

impl PolarGrid {
    /// A grid of `rings` × `sectors` samples within `radius_px`.
    pub fn new(radius_px: f64, rings: usize, sectors: usize) -> PolarGrid {
        let offset = |ring: usize, sector: usize| {
            let radius = (ring as f64 + 0.5) * radius_px / rings as f64;
            let (sin, cos) = (std::f64::consts::TAU * sector as f64 / sectors as f64).sin_cos();
            ((radius * cos) as f32, (radius * sin) as f32)
        };
        let offsets_px =
            (0..rings).flat_map(|ring| (0..sectors).map(move |sector| offset(ring, sector))).collect();
        PolarGrid { rings, sectors, offsets_px }
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
        let mut samples = vec![0.0; self.offsets_px.len()];
        self.sample(image, x_px, y_px, &mut samples);
        PolarSubwindow { rings: self.rings, sectors: self.sectors, samples }
    }

    /// Write the samples of the sub-window about a point, ring by ring.
    ///
    /// # Panics
    /// If `samples` does not hold rings × sectors values, or the image is empty.
    pub fn sample(&self, image: &Image, x_px: f32, y_px: f32, samples: &mut [f32]) {
        assert_eq!(samples.len(), self.offsets_px.len(), "one value a sample");
        let (last_x, last_y) = (image.width() - 1, image.height() - 1);
        for (sample, &(dx, dy)) in samples.iter_mut().zip(&self.offsets_px) {
            let x = (x_px + dx).clamp(0.0, last_x as f32);
            let y = (y_px + dy).clamp(0.0, last_y as f32);
            let (left, top) = (x as usize, y as usize);
            let (right_part, lower_part) = (x - left as f32, y - top as f32);
            let right = (left + 1).min(last_x);
            let (upper, lower) = (image.row(top), image.row((top + 1).min(last_y)));
            let above = upper[left] + right_part * (upper[right] - upper[left]);
            let below = lower[left] + right_part * (lower[right] - lower[left]);
            *sample = above + lower_part * (below - above);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
