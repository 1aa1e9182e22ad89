//! A cache of depth estimators. Designing one costs more than measuring a picture, and robots use the same rig and options
//! time after time.

use std::sync::{Arc, Mutex, PoisonError};

use landmarkd_core::depth::{Calibration, DepthOptions, Estimator, EstimatorError};

/// Most estimators kept: rigs of a site, or options that somebody tries out. Each holds a few hundred kilobytes.
const MOST: usize = 16;

/// The rig and options of an estimator.
type Key = (Calibration, DepthOptions);

type Entry = (Key, Arc<Estimator>);

/// The estimators that were used last, the latest first; cheap to clone.
#[derive(Clone, Default)]
pub struct Estimators {
    kept: Arc<Mutex<Vec<Entry>>>,
}

impl Estimators {
    /// The estimator of a rig and options, designed if it isn't cached: for a computing thread.
    ///
    /// # Errors
    /// [`EstimatorError`].
    pub fn ready(
        &self,
        calibration: &Calibration,
        options: &DepthOptions,
    ) -> Result<Arc<Estimator>, EstimatorError> {
        let matches = |(key, _): &Entry| key.0 == *calibration && key.1 == *options;
        // A panic elsewhere leaves the list whole: nothing here is half done while the lock is held.
        let lock = || self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        {
            let mut kept = lock();
            if let Some(at) = kept.iter().position(matches) {
                kept[..=at].rotate_right(1);
                return Ok(Arc::clone(&kept[0].1));
            }
        }
        // Without the lock, so that others needn't wait. Two at once design it twice, with the same result.
        let estimator = Arc::new(Estimator::new(calibration, options)?);
        let mut kept = lock();
        kept.retain(|entry| !matches(entry));
        kept.truncate(MOST - 1);
        kept.insert(0, ((calibration.clone(), *options), Arc::clone(&estimator)));
        Ok(estimator)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use landmarkd_core::depth::{Aperture, Method, Optics, OpticsSpec, Pair, Sensor, Window};

    #[test]
    fn the_same_rig_and_options_share_one_estimator_until_many_others_came() {
        let optics = Optics::new(&OpticsSpec {
            focal_length_mm: 25.0,
            pair: Pair::Focal {
                aperture: Aperture::FNumber(2.8),
                near_sensor: Sensor::FocusMm(529.0),
                plane_separation_mm: 0.37,
            },
            pixel_pitch_um: 29.0,
            telecentric: true,
            principal_point_px: None,
        });
        let rig = Calibration::of(optics.unwrap());
        let options = |px: usize| DepthOptions {
            method: Method::Stm,
            window: Window::Px(px as f64),
            ..Default::default()
        };
        let estimators = Estimators::default();
        let first = estimators.ready(&rig, &options(1)).unwrap();
        for px in 2..=MOST {
            estimators.ready(&rig, &options(px)).unwrap();
        }
        assert!(Arc::ptr_eq(&first, &estimators.ready(&rig, &options(1)).unwrap()));
        let second = estimators.ready(&rig, &options(2)).unwrap();
        for px in MOST + 1..2 * MOST {
            estimators.ready(&rig, &options(px)).unwrap();
        }
        assert!(
            Arc::ptr_eq(&second, &estimators.ready(&rig, &options(2)).unwrap()),
            "used last, kept longest"
        );
        assert!(!Arc::ptr_eq(&first, &estimators.ready(&rig, &options(1)).unwrap()));
        assert_eq!(estimators.kept.lock().unwrap().len(), MOST);
        assert!(estimators.ready(&rig, &options(0)).is_err());
    }
}
