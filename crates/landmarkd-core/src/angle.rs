//! Angles on the circle: how far apart two directions are, the smaller way round.

use std::f32::consts::TAU;

/// The angular distance of two directions in degrees, 0..=180.
pub fn angular_distance_deg(a_deg: f64, b_deg: f64) -> f64 {
    let turn_deg = (a_deg - b_deg).rem_euclid(360.0);
    turn_deg.min(360.0 - turn_deg)
}

/// The angular distance of two directions in radians, 0..=π.
pub fn angular_distance_rad(a_rad: f32, b_rad: f32) -> f32 {
    let turn_rad = (a_rad - b_rad).rem_euclid(TAU);
    turn_rad.min(TAU - turn_rad)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_compared_on_the_circle() {
        for (a, b, apart) in [
            (359.0, 1.0, 2.0),
            (1.0, 359.0, 2.0),
            (0.0, 180.0, 180.0),
            (0.0, 360.0, 0.0),
            (350.0, 80.0, 90.0),
        ] {
            assert_eq!(angular_distance_deg(a, b), apart, "{a} and {b}");
            let in_radians = angular_distance_rad((a as f32).to_radians(), (b as f32).to_radians());
            assert!((in_radians.to_degrees() - apart as f32).abs() < 1e-4, "{a} and {b}: {in_radians}");
        }
    }
}
