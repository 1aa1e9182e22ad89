//! Training, asking, counting: the same for every claim.

use landmarkd_core::imaging::Frame;
use landmarkd_core::recognition::landmarks::{
    CalibrationPlan, CalibrationSample, ExemplarName, LandmarkOptions, Landmarks, Reliability,
    calibration_samples, describe, synthetic_views,
};

/// What a claim's trials came to.
#[derive(Clone, Copy)]
pub struct Outcome {
    pub right: usize,
    pub among_five: usize,
    pub trials: usize,
}

impl Outcome {
    pub fn rate(&self) -> f64 {
        self.right as f64 / self.trials as f64
    }

    /// Print top-1 and top-5 under a name.
    pub fn say(&self, name: &str) {
        let Outcome { right, among_five, trials } = self;
        let (rate, five) = (self.rate(), *among_five as f64 / *trials as f64);
        println!("{name}: top-1 {rate:.3} ({right} of {trials}), top-5 {five:.3}");
    }

    /// The rate is not below `expected` by more than chance explains.
    ///
    /// The floor is two standard deviations of a rate measured on so many trials: √(p(1 − p)/n).
    pub fn assert_reaches(&self, expected: f64) {
        let floor = expected - 2.0 * (expected * (1.0 - expected) / self.trials as f64).sqrt();
        assert!(self.rate() >= floor, "{:.3} of {} trials, below {floor:.3}", self.rate(), self.trials);
    }
}

/// Train on one picture each, named by its place in the list.
pub fn trained(pictures: &[Frame], options: &LandmarkOptions) -> Landmarks {
    let described = pictures.iter().enumerate().map(|(n, picture)| {
        describe(ExemplarName { id: n.to_string(), label: n.to_string() }, picture, options)
    });
    let (model, _) = Landmarks::train(described.collect(), options).expect("a model");
    model
}

/// The same, and calibrated as a training job does.
pub fn calibrated(pictures: &[Frame], options: &LandmarkOptions) -> (Landmarks, Reliability) {
    let mut model = trained(pictures, options);
    let plan = CalibrationPlan::of(&model);
    let mut samples: Vec<CalibrationSample> = Vec::new();
    for round in 0..plan.rounds {
        for name in plan.exemplars.iter().map(|&index| model.exemplars()[index].name()) {
            let picture = &pictures[name.label.parse::<usize>().expect("a place in the list")];
            let views = synthetic_views(&name, picture, round, options);
            samples.extend(calibration_samples(&model, &name, &views));
        }
    }
    let reliability = model.calibrate(&samples).expect("enough samples");
    (model, reliability)
}

/// Recognise frames whose truth is the place of a training picture in its list.
pub fn asked<'a>(model: &Landmarks, frames: impl IntoIterator<Item = &'a (usize, Frame)>) -> Outcome {
    let mut outcome = Outcome { right: 0, among_five: 0, trials: 0 };
    for (shown, frame) in frames {
        let votes = model.recognise(frame, |_| ()).votes;
        let rank = votes.iter().position(|vote| vote.label == shown.to_string());
        outcome.right += usize::from(rank == Some(0));
        outcome.among_five += usize::from(rank.is_some_and(|rank| rank < 5));
        outcome.trials += 1;
    }
    outcome
}
