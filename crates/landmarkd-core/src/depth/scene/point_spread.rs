//! How the light of one sample of a scene spreads over the pixels of a sensor.
//!
//! A scene is a cubic B-spline over samples [`FINE`] times as fine as the pixels; a point of it becomes a disc of
//! uniform light (B(4)); a pixel gathers the light of its square. So a sample's light in a pixel is the spline's kernel
//! folded with the disc and with the square: ∫∫ disc(u, v) ψ(x − u) ψ(y − v), ψ the quartic B-spline twice. A row of the
//! disc is integrated in closed form, the rows by Gauss–Chebyshev quadrature. Kernels are kept for diameters 1/8 px
//! apart and shared linearly between two.

/// Samples a pixel and axis.
pub(super) const FINE: usize = 2;
/// Kernels a pixel of diameter.
const LEVELS_PER_PX: f64 = 8.0;
/// ψ reaches this far.
const REACH_PX: f64 = 1.5;

/// Light on the pixels of a sensor, and on an edge around them.
#[derive(Clone, Debug)]
pub(super) struct LightBuffer {
    width: usize,
    height: usize,
    edge: usize,
    values: Vec<f32>,
}

impl LightBuffer {
    /// A buffer without light.
    pub fn new(width: usize, height: usize, edge: usize) -> LightBuffer {
        LightBuffer { width, height, edge, values: vec![0.0; (width + 2 * edge) * (height + 2 * edge)] }
    }

    /// The picture without its edge, row-major.
    pub fn picture(&self) -> impl Iterator<Item = f32> {
        let stride = self.width + 2 * self.edge;
        let rows = self.values.chunks_exact(stride).skip(self.edge).take(self.height);
        rows.flat_map(|row| row[self.edge..self.edge + self.width].iter().copied())
    }
}

/// The kernels of two neighbouring diameters for samples at one of the places within a pixel.
#[derive(Clone, Debug)]
struct Kernel {
    radius: usize,
    /// Phase by phase (upper left, upper right, lower left, lower right), row-major.
    low: Vec<f32>,
    high: Vec<f32>,
}

/// Kernels by diameter, computed on first use.
#[derive(Clone, Debug, Default)]
pub(super) struct PointSpreads {
    quadrants: Vec<Option<Quadrant>>,
    kernels: Vec<Option<Kernel>>,
}

impl PointSpreads {
    /// Computes the kernels for a diameter, unless it has them.
    pub fn prepare(&mut self, diameter_px: f32) {
        let level = (f64::from(diameter_px) * LEVELS_PER_PX) as usize;
        if self.kernels.get(level).is_some_and(Option::is_some) {
            return;
        }
        if self.kernels.len() <= level {
            self.kernels.resize(level + 1, None);
            self.quadrants.resize(level + 2, None);
        }
        let radius = radius_px((level + 1) as f64 / LEVELS_PER_PX);
        let [low, high] = [level, level + 1].map(|level| {
            let quadrant =
                self.quadrants[level].get_or_insert_with(|| Quadrant::new(level as f64 / LEVELS_PER_PX));
            quadrant.phases(radius)
        });
        self.kernels[level] = Some(Kernel { radius, low, high });
    }

    /// How far a prepared kernel reaches at most, in pixels.
    pub fn reach_px(&self) -> usize {
        self.kernels.iter().flatten().map(|kernel| kernel.radius).max().unwrap_or(0)
    }

    /// Adds the light of the sample at `column`, `row` of a scene that begins `margin_px` before the buffer's picture.
    ///
    /// # Panics
    /// If its diameter was not prepared, or the buffer's edge is narrower than the margin and the kernel's reach.
    pub fn splat(
        &self,
        buffer: &mut LightBuffer,
        [column, row]: [usize; 2],
        margin_px: usize,
        diameter_px: f32,
        light: f32,
    ) {
        let level = diameter_px * LEVELS_PER_PX as f32;
        let kernel = self.kernels[level as usize].as_ref().expect("the diameter was prepared");
        let share = level - level.floor();
        let (low_light, high_light) = (light * (1.0 - share), light * share);
        let (x, y) = (column / FINE, row / FINE);
        let beyond = |at: usize, length: usize| {
            at + kernel.radius < margin_px || at > length - 1 + kernel.radius + margin_px
        };
        if beyond(x, buffer.width) || beyond(y, buffer.height) {
            return;
        }
        let side = 2 * kernel.radius + 1;
        let phase = (row % FINE * FINE + column % FINE) * side * side;
        let stride = buffer.width + 2 * buffer.edge;
        let inward = buffer.edge - margin_px - kernel.radius;
        for line in 0..side {
            let tap = phase + line * side;
            let pixel = (y + inward + line) * stride + x + inward;
            let taps = kernel.low[tap..tap + side].iter().zip(&kernel.high[tap..tap + side]);
            for (value, (low, high)) in buffer.values[pixel..pixel + side].iter_mut().zip(taps) {
                *value += low_light * low + high_light * high;
            }
        }
    }
}

/// Pixels from a sample's own to the last that its light may reach.
fn radius_px(diameter_px: f64) -> usize {
    (diameter_px / 2.0 + REACH_PX - 0.25).ceil() as usize
}

/// One diameter's weights at distances 1/4, 3/4, 5/4… px along both axes.
#[derive(Clone, Debug)]
struct Quadrant {
    side: usize,
    weights: Vec<f64>,
}

impl Quadrant {
    fn new(diameter_px: f64) -> Quadrant {
        let radius_px = diameter_px / 2.0;
        let side = 2 * self::radius_px(diameter_px) + 1;
        let at = |step: usize| 0.25 + 0.5 * step as f64;
        let mut weights = vec![0.0; side * side];
        // Rows at ±v together; v = R cos θ.
        let rows = 12 + (4.0 * diameter_px) as usize;
        for row in 0..rows {
            let (sin, cos) = (std::f64::consts::PI * (row + 1) as f64 / (2 * rows + 1) as f64).sin_cos();
            let (v, half_chord) = (radius_px * cos, (radius_px * sin).max(1e-6));
            let share = 2.0 * sin * sin / (2 * rows + 1) as f64;
            let along: Vec<f64> = (0..side)
                .map(|x| (gathered(at(x) + half_chord) - gathered(at(x) - half_chord)) / (2.0 * half_chord))
                .collect();
            for y in 0..side {
                let across = share * (psi(at(y) - v) + psi(at(y) + v));
                for (weight, along) in weights[y * side..(y + 1) * side].iter_mut().zip(&along) {
                    *weight += across * along;
                }
            }
        }
        // The pixels around a sample stand at each of these distances once, to one side or the other.
        let sum: f64 = weights.iter().sum();
        weights.iter_mut().for_each(|weight| *weight /= sum);
        Quadrant { side, weights }
    }

    /// The weights of the pixels around a sample, for its four places in its own.
    fn phases(&self, radius: usize) -> Vec<f32> {
        let side = 2 * radius as i64 + 1;
        // The left sample stands 1/4 px left of its pixel's centre: a pixel k to the right is k + 1/4 away.
        let step = |at: i64, phase: i64| {
            let quarters = 4 * (at - radius as i64) + 1 - 2 * phase;
            ((quarters.abs() - 1) / 2) as usize
        };
        let mut taps = Vec::with_capacity((4 * side * side) as usize);
        for (lower, right) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            for (y, x) in (0..side).flat_map(|y| (0..side).map(move |x| (y, x))) {
                let (y, x) = (step(y, lower), step(x, right));
                let inside = y < self.side && x < self.side;
                taps.push(if inside { self.weights[y * self.side + x] as f32 } else { 0.0 });
            }
        }
        taps
    }
}

/// The cubic B-spline over samples half a pixel apart, folded with a pixel.
fn psi(x_px: f64) -> f64 {
    let t = x_px * FINE as f64;
    quartic(t - 0.5) + quartic(t + 0.5)
}

/// ∫ψ up to `x_px`.
fn gathered(x_px: f64) -> f64 {
    let t = x_px * FINE as f64;
    (quartic_integral(t - 0.5) + quartic_integral(t + 0.5)) / 2.0
}

/// The quartic B-spline.
fn quartic(t: f64) -> f64 {
    let t = t.abs();
    match t {
        _ if t >= 2.5 => 0.0,
        _ if t >= 1.5 => (2.5 - t).powi(4) / 24.0,
        _ if t >= 0.5 => ((2.5 - t).powi(4) - 5.0 * (1.5 - t).powi(4)) / 24.0,
        _ => ((2.5 - t).powi(4) - 5.0 * (1.5 - t).powi(4) + 10.0 * (0.5 - t).powi(4)) / 24.0,
    }
}

/// Its integral up to `t`.
fn quartic_integral(t: f64) -> f64 {
    if t < 0.0 {
        return 1.0 - quartic_integral(-t);
    }
    let beyond = match t {
        _ if t >= 2.5 => 0.0,
        _ if t >= 1.5 => (2.5 - t).powi(5),
        _ if t >= 0.5 => (2.5 - t).powi(5) - 5.0 * (1.5 - t).powi(5),
        _ => (2.5 - t).powi(5) - 5.0 * (1.5 - t).powi(5) + 10.0 * (0.5 - t).powi(5),
    };
    1.0 - beyond / 120.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_discs_second_moment_is_that_of_theory() {
        // Along an axis: the disc d²/16, the pixel 1/12, the spline's kernel 4/12 of a sample's width squared.
        for diameter_px in [0.0, 0.3, 0.5, 1.0, 2.3, 5.0, 13.0_f32] {
            let mut spreads = PointSpreads::default();
            spreads.prepare(diameter_px);
            let (mut light, mut moment, mut mean) = (0.0, 0.0, 0.0);
            for (column, row) in [(40, 40), (41, 40), (40, 41), (41, 41)] {
                let mut buffer = LightBuffer::new(41, 41, spreads.reach_px());
                spreads.splat(&mut buffer, [column, row], 0, diameter_px, 1.0);
                let centre_px = (column as f64 + 0.5) / FINE as f64 - 0.5;
                for (at, value) in buffer.picture().enumerate() {
                    let off_px = (at % 41) as f64 - centre_px;
                    light += f64::from(value) / 4.0;
                    mean += f64::from(value) * off_px / 4.0;
                    moment += f64::from(value) * off_px * off_px / 4.0;
                }
            }
            let theory = f64::from(diameter_px).powi(2) / 16.0 + 1.0 / 12.0 + 1.0 / 12.0;
            assert!((light - 1.0).abs() < 1e-5 && mean.abs() < 1e-5, "{diameter_px} px: {light}, {mean}");
            assert!((moment - theory).abs() < 0.0005, "{diameter_px} px: {moment:.5}, not {theory:.5} px²");
        }
    }

    #[test]
    fn discs_half_a_step_between_two_kernels_are_as_true() {
        let mut spreads = PointSpreads::default();
        let shape = |diameter_px: f64| {
            let quadrant = Quadrant::new(diameter_px);
            quadrant.phases(8)
        };
        spreads.prepare(3.0625);
        let mut buffer = LightBuffer::new(17, 17, spreads.reach_px());
        spreads.splat(&mut buffer, [16, 16], 0, 3.0625, 1.0);
        for (at, (value, expected)) in buffer.picture().zip(shape(3.0625)).enumerate() {
            assert!((value - expected).abs() < 2e-4, "pixel {at}: {value}, not {expected}");
        }
    }
}
