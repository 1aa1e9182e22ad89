//! What would make a rig measure better, for people.

use super::Rig;
use landmarkd_core::depth::Optics;

/// The largest blur that measures best, in pixels.
const BEST_BLUR_PX: std::ops::RangeInclusive<f64> = 4.0..=7.0;
/// A pattern of a shorter period than the largest blur over this passes the first zero of the transfer function.
const SHORTEST_PERIOD: f64 = 0.9;
/// A pattern of a longer period than this many times the largest blur shows too little of it.
const LONGEST_PERIOD: f64 = 3.0;

/// What would make an optics measure better, a sentence each.
pub fn optics_advice(optics: &Optics) -> Vec<String> {
    let blur_px = optics.largest_blur_px();
    let mut advice = Vec::new();
    if !BEST_BLUR_PX.contains(&blur_px) {
        let how = match blur_px < *BEST_BLUR_PX.start() {
            true => "a wider aperture, a larger separation or smaller pixels make it larger",
            false => {
                "a narrower aperture or a smaller separation make it smaller; as it is, pictures are halved first"
            }
        };
        advice.push(format!(
            "The largest blur is {blur_px:.1} px, and {} to {} px measure best: {how}.",
            BEST_BLUR_PX.start(),
            BEST_BLUR_PX.end()
        ));
    }
    advice.push(format!(
        "Project a pattern onto surfaces without texture: irregular dots, better than stripes, of a period of \
         {:.1} to {:.1} px; hard square patterns finer than 8 px alias.",
        blur_px / SHORTEST_PERIOD,
        blur_px * LONGEST_PERIOD
    ));
    advice
}

impl Rig {
    /// What would make it measure better, a sentence each.
    pub fn advice(&self) -> Vec<String> {
        let optics = &self.calibration.optics;
        let mut advice = optics_advice(optics);
        if self.calibration.registration.is_none() && !optics.spec().telecentric {
            advice.push(
                "Register it by a textured target: the scale is computed from the optics alone.".into(),
            );
        }
        if self.calibration.table.is_none() {
            advice.push(
                "Sweep it: textured planes at 9 to 21 known depths, past both focus distances, take out what the optics \
                 is off by."
                    .into(),
            );
        }
        advice
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use jiff::Timestamp;
    use landmarkd_core::depth::{Aperture, Calibration, OpticsSpec, Pair, Sensor};

    fn advice(aperture_mm: f64, telecentric: bool) -> String {
        let optics = Optics::new(&OpticsSpec {
            focal_length_mm: 25.0,
            pair: Pair::Focal {
                aperture: Aperture::DiameterMm(aperture_mm),
                near_sensor: Sensor::FocusMm(529.0),
                plane_separation_mm: 0.37,
            },
            pixel_pitch_um: 29.0,
            telecentric,
            principal_point_px: None,
        });
        let rig = Rig {
            name: "rig".into(),
            calibration: Calibration::of(optics.unwrap()),
            revision: 1,
            created_at: Timestamp::UNIX_EPOCH,
            updated_at: Timestamp::UNIX_EPOCH,
        };
        rig.advice().join("\n")
    }

    #[test]
    fn blur_that_is_too_small_or_too_large_is_said_and_how_to_mend_it() {
        // Blur in pixels: aperture × 0.37 / (25 × 0.029).
        assert!(
            advice(4.0, true).contains("The largest blur is 2.0 px") && advice(4.0, true).contains("wider")
        );
        assert!(advice(25.0, true).contains("12.8 px") && advice(25.0, true).contains("narrower"));
        assert!(!advice(9.0, true).contains("measure best"));
    }

    #[test]
    fn what_was_not_measured_yet_is_advised() {
        let text = advice(9.0, true);
        assert!(text.contains("of a period of 5.1 to 13.8 px") && text.contains("Sweep it"), "{text}");
        assert!(!text.contains("Register it") && advice(9.0, false).contains("Register it"));
    }
}
