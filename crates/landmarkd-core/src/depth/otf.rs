//! The transfer function of a blur circle.

use std::f64::consts::PI;

/// Transfer function of a uniform disc of this diameter in pixels at `frequency` cycles a pixel: the transform of
/// B(4), 2 J₁(πdρ)/(πdρ). The diameter's sign doesn't matter.
pub(super) fn pillbox(frequency: f64, diameter_px: f64) -> f64 {
    let x = PI * diameter_px.abs() * frequency;
    if x < 1e-6 { 1.0 } else { 2.0 * libm::j1(x) / x }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The disc itself, summed over a fine grid.
    fn summed(frequency: f64, diameter_px: f64) -> f64 {
        let (radius, steps) = (diameter_px / 2.0, 4000);
        let (mut sum, mut area) = (0.0, 0.0);
        for step in 0..steps {
            let x = radius * ((f64::from(step) + 0.5) / f64::from(steps) * 2.0 - 1.0);
            let chord = (radius * radius - x * x).sqrt();
            sum += chord * (2.0 * PI * frequency * x).cos();
            area += chord;
        }
        sum / area
    }

    #[test]
    fn it_is_the_transform_of_a_disc() {
        for diameter_px in [0.3, 1.0, 4.6, 13.0] {
            for frequency in [0.0, 0.05, 0.2, 0.5] {
                let (fast, slow) = (pillbox(frequency, diameter_px), summed(frequency, diameter_px));
                assert!((fast - slow).abs() < 1e-4, "{diameter_px} px at {frequency}: {fast} is not {slow}");
                assert_eq!(fast, pillbox(frequency, -diameter_px));
            }
        }
    }

    #[test]
    fn its_first_zero_lies_at_1_22_over_the_diameter() {
        assert!(pillbox(1.21 / 5.0, 5.0) > 0.0 && pillbox(1.23 / 5.0, 5.0) < 0.0);
    }
}
