//! What a sensor sees through a lens of many points: one ray from each of them to each pixel.
//!
//! The light of a point of the scene that is seen at place q of the near-focused picture falls, through the lens' point
//! l of the unit disc, on q + r·l: r is half the signed diameter of its blur circle, B(2). So a pixel at p sees through l
//! the nearest surface with q + r(q)·l = p. What hides what differs from one lens point to the next: behind the edge of
//! a near surface a part of the lens still sees the far one.

use crate::imaging::Image;

/// Points of the lens.
const LENS_POINTS: usize = 96;
/// Longest step along a ray over a map of depths, in pixels.
const STEP_PX: f64 = 0.5;
/// Blur radii of neighbouring pixels that differ by more belong to two surfaces, in pixels.
const SAME_SURFACE_PX: f64 = 0.25;

/// Points evenly over the unit disc: Vogel's spiral.
fn lens_points() -> impl Iterator<Item = [f64; 2]> {
    (0..LENS_POINTS).map(|k| {
        let (sin, cos) = (k as f64 * 2.399_963_229_728_653).sin_cos();
        let radius = ((k as f64 + 0.5) / LENS_POINTS as f64).sqrt();
        [radius * cos, radius * sin]
    })
}

/// The light on each pixel of a sensor, row-major: the mean over the lens of what `seen` says of the pixel's middle and a
/// point of the lens.
pub(super) fn gathered(
    [width, height]: [usize; 2],
    mut seen: impl FnMut([f64; 2], [f64; 2]) -> f32,
) -> Vec<f32> {
    let points: Vec<[f64; 2]> = lens_points().collect();
    let pixel = |at: usize| {
        let place = [(at % width) as f64, (at / width) as f64];
        points.iter().map(|&lens| seen(place, lens)).sum::<f32>() / LENS_POINTS as f32
    };
    (0..width * height).map(pixel).collect()
}

/// The blur radius of what each pixel of the near-focused picture shows, on one sensor.
pub(super) struct RadiusMap {
    radius_px: Image,
    least_px: f64,
    most_px: f64,
}

impl RadiusMap {
    pub(super) fn new(radius_px: Image) -> RadiusMap {
        let span = radius_px.pixels().iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], &r| {
            [least.min(f64::from(r)), most.max(f64::from(r))]
        });
        // A little before the nearest surface and beyond the farthest: rays come to both from outside.
        RadiusMap { radius_px, least_px: span[0] - 0.01, most_px: span[1] + 0.01 }
    }

    /// The radius at a place: between pixels of one surface, else that of the nearest pixel.
    fn at(&self, [x, y]: [f64; 2]) -> f64 {
        let (right, bottom) = (self.radius_px.width() - 1, self.radius_px.height() - 1);
        let (x, y) = (x.clamp(0.0, right as f64), y.clamp(0.0, bottom as f64));
        let (left, top) = (x as usize, y as usize);
        let (u, v) = (x - left as f64, y - top as f64);
        let [a, b, c, d] = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(across, down)| {
            f64::from(self.radius_px.at((left + across).min(right), (top + down).min(bottom)))
        });
        if a.max(b).max(c).max(d) - a.min(b).min(c).min(d) < SAME_SURFACE_PX {
            return (a * (1.0 - u) + b * u) * (1.0 - v) + (c * (1.0 - u) + d * u) * v;
        }
        match (u < 0.5, v < 0.5) {
            (true, true) => a,
            (false, true) => b,
            (true, false) => c,
            (false, false) => d,
        }
    }

    /// The place that a ray sees. Nearer surfaces have lesser radii: the ray is followed from the nearest on to where
    /// it meets a surface. Where it passes behind one, nobody knows what is there: then it sees the farthest that it
    /// passed.
    pub(super) fn met(&self, place: [f64; 2], lens: [f64; 2]) -> [f64; 2] {
        let at = |radius: f64| [place[0] - radius * lens[0], place[1] - radius * lens[1]];
        let span = self.most_px - self.least_px;
        let steps = (span * lens[0].hypot(lens[1]) / STEP_PX).ceil().max(1.0);
        let (mut before, mut beyond) = (self.least_px, self.at(at(self.least_px)) - self.least_px);
        let mut farthest = (beyond + self.least_px, at(self.least_px));
        for step in 1..=steps as usize {
            let radius = self.least_px + span * step as f64 / steps;
            let there = self.at(at(radius));
            if there >= farthest.0 {
                farthest = (there, at(radius));
            }
            let rest = there - radius;
            if beyond >= 0.0 && rest <= 0.0 {
                let met = before + (radius - before) * beyond / (beyond - rest).max(1e-9);
                if (self.at(at(met)) - met).abs() < SAME_SURFACE_PX {
                    return at(met);
                }
            }
            (before, beyond) = (radius, rest);
        }
        farthest.1
    }
}
