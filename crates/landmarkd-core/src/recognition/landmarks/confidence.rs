//! Confidence: the probability that an answer is right, calibrated on synthetic views whose truth is known.
//!
//! A logistic regression on the evidence with weights ≥ 0: more evidence of any kind never lowers the probability.

/// Kinds of evidence.
const FEATURES: usize = 4;
/// Evidence as the regression takes it.
type Features = [f64; FEATURES];

/// Samples that one exemplar gives in one round. They stand together and are alike: cross-validation keeps them
/// together.
pub(super) const SAMPLES_TOGETHER: usize = 8;

/// Rivals below this part of the best one's W count as none.
const LEAST_RIVAL: f64 = 0.05;
/// Samples that a fit needs.
const LEAST_SAMPLES: usize = 20;
/// A robot can't act on answers of which more than one in five is wrong.
const LEAST_THRESHOLD: f64 = 0.8;
/// The part of the unknown frames that may reach the threshold.
const UNKNOWN_ACCEPTED: f64 = 0.02;
/// Evidence with a smaller standard deviation varies by rounding only.
const LEAST_DEVIATION: f64 = 1e-6;
/// Ridge penalty, in samples.
const RIDGE: f64 = 1.0;
/// Iterations of the fit at most, and the step at which it has converged.
const MOST_ITERATIONS: usize = 4000;
const LEAST_STEP: f64 = 1e-7;

/// The evidence for the best answer to a frame, each number ≥ 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Evidence {
    /// There is no answer.
    None,
    /// The answer is a verified placement.
    Placement {
        /// ln(1 + 10 W).
        log_weight: f64,
        /// Agreement with the frame's gradients.
        agreement: f64,
        /// Logarithm of the ratio of W to that of the strongest other label in the same place.
        log_margin: f64,
        /// Logarithm of the number of inliers.
        log_inliers: f64,
    },
    /// The answer is an exemplar that explains the frame by a homography.
    AContrario {
        /// ln(1 − log₁₀ of the number of false alarms), 0 where that is above 1.
        log_evidence: f64,
        /// Logarithm of the ratio of −log₁₀ of the number of false alarms to that of the strongest other label.
        log_margin: f64,
        /// Logarithm of the number of windows that agree.
        log_agreeing: f64,
    },
    /// The answer is a vote.
    Vote {
        /// Logarithm of the ratio of W to that of the second label.
        log_margin: f64,
        /// How many points more than for the second label, as a part of all windows.
        lead: f64,
        /// The points as a part of all windows.
        share: f64,
        /// Logarithm of the number of points.
        log_points: f64,
    },
}

impl Evidence {
    fn features(&self) -> Features {
        match *self {
            Evidence::None => [0.0; FEATURES],
            Evidence::Placement { log_weight, agreement, log_margin, log_inliers } => {
                [log_weight, agreement, log_margin, log_inliers]
            }
            Evidence::AContrario { log_evidence, log_margin, log_agreeing } => {
                [log_evidence, log_margin, log_agreeing, 0.0]
            }
            Evidence::Vote { log_margin, lead, share, log_points } => [log_margin, lead, share, log_points],
        }
    }
}

/// The answer to a synthetic view, and the truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CalibrationSample {
    /// Of the best answer.
    pub evidence: Evidence,
    /// Whether the answer names what the view shows.
    pub right: bool,
    /// Whether the view shows anything that the database knows.
    pub known: bool,
}

/// The fitted logistic curve and the threshold of decisions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Confidence {
    /// Weight of each kind of evidence, in the order of the fields of [`Evidence`], ≥ 0.
    pub weights: [f64; FEATURES],
    /// Log-odds without evidence.
    pub bias: f64,
    /// Answers with a lower probability are refused, 0.8..=1.
    pub threshold: f64,
}

/// How reliable the confidence is: rates by two-fold cross-validation.
#[derive(Clone, Debug, PartialEq)]
pub struct Reliability {
    /// Views that show something known.
    pub known: usize,
    /// Views that show nothing known.
    pub unknown: usize,
    /// The part of the known ones that were named right, with a probability that reaches the threshold.
    pub known_named: f64,
    /// The part of the known ones that were named wrong.
    pub known_misnamed: f64,
    /// The part of the unknown ones that were refused.
    pub unknown_refused: f64,
    /// Reliability diagram: the answers in each tenth of the confidence.
    pub curve: Vec<ReliabilityBin>,
}

/// Answers of about the same confidence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReliabilityBin {
    /// Mean confidence.
    pub confidence: f64,
    /// Number of answers.
    pub answers: usize,
    /// The part of them that was right.
    pub right: f64,
}

impl Confidence {
    /// The curve of answers by the number of false alarms. It is of no one database: their number is by construction the
    /// same measure in all. Of 713 decisions on nine sets of photographs and three of composites 0.98 were right, and
    /// the expected calibration error is 0.014.
    pub const A_CONTRARIO: Confidence =
        Confidence { weights: [1.0, 1.0, 0.5, 0.0], bias: -2.0, threshold: 0.0 };

    /// Fits to samples in runs of [`SAMPLES_TOGETHER`], of which every `exemplars`-th is of the same exemplar;
    /// `None` if there are too few samples, or only right or only wrong ones.
    pub fn fit(samples: &[CalibrationSample], exemplars: usize) -> Option<(Confidence, Reliability)> {
        let confidence = Self::fitted(samples)?;
        // each half of the exemplars is scored by the curve of the other
        let half = |odd: usize| -> Vec<CalibrationSample> {
            let runs = samples.chunks(SAMPLES_TOGETHER).enumerate();
            let wanted = runs.filter(|(run, _)| run % exemplars.max(1) % 2 == odd);
            wanted.flat_map(|(_, samples)| samples).copied().collect()
        };
        let (even, odd) = (half(0), half(1));
        let scored = |training: &[CalibrationSample], test: &[CalibrationSample]| -> Vec<Scored> {
            let curve = Self::fitted(training).unwrap_or(confidence);
            let score = |sample: &CalibrationSample| {
                let confidence = curve.of(&sample.evidence);
                Scored { sample: *sample, confidence, accepted: confidence >= curve.threshold }
            };
            test.iter().map(score).collect()
        };
        let reliability = Reliability::of(&[scored(&odd, &even), scored(&even, &odd)].concat());
        Some((confidence, reliability))
    }

    /// The probability that an answer with this evidence is right, 0..=1.
    pub fn of(&self, evidence: &Evidence) -> f64 {
        let sum: f64 = self.weights.iter().zip(evidence.features()).map(|(w, e)| w * e).sum();
        logistic(self.bias + sum)
    }

    /// The regression and its threshold, without cross-validation.
    fn fitted(samples: &[CalibrationSample]) -> Option<Confidence> {
        let right = samples.iter().filter(|sample| sample.right).count();
        if samples.len() < LEAST_SAMPLES || right == 0 || right == samples.len() {
            return None;
        }
        let features: Vec<Features> = samples.iter().map(|sample| sample.evidence.features()).collect();
        let standard = Standardisation::of(&features);
        let standardised = features.iter().map(|x| standard.scaled(|k| x[k] - standard.mean[k]));
        let right = samples.iter().map(|sample| f64::from(u8::from(sample.right)));
        let rows: Vec<(Features, f64)> = standardised.zip(right).collect();
        let (weights, bias) = maximum_likelihood(&rows);
        let weights = standard.scaled(|k| weights[k]);
        let shift: f64 = (0..FEATURES).map(|k| weights[k] * standard.mean[k]).sum();
        let curve = Confidence { weights, bias: bias - shift, threshold: LEAST_THRESHOLD };
        let unknown = samples.iter().filter(|sample| !sample.known).map(|sample| curve.of(&sample.evidence));
        Some(Confidence { threshold: threshold(unknown.collect()), ..curve })
    }
}

fn logistic(log_odds: f64) -> f64 {
    1.0 / (1.0 + (-log_odds).exp())
}

/// Mean and standard deviation of each feature.
struct Standardisation {
    mean: Features,
    deviation: Features,
}

impl Standardisation {
    fn of(rows: &[Features]) -> Standardisation {
        let count = rows.len() as f64;
        let mean: Features = std::array::from_fn(|k| rows.iter().map(|row| row[k]).sum::<f64>() / count);
        let variance = |k: usize| rows.iter().map(|row| (row[k] - mean[k]).powi(2)).sum::<f64>() / count;
        Standardisation { mean, deviation: std::array::from_fn(|k| variance(k).sqrt()) }
    }

    /// Values over the deviations; 0 for features that don't vary.
    fn scaled(&self, value: impl Fn(usize) -> f64) -> Features {
        std::array::from_fn(|k| {
            if self.deviation[k] > LEAST_DEVIATION { value(k) / self.deviation[k] } else { 0.0 }
        })
    }
}

/// Weights ≥ 0 and bias of the logistic regression on standardised rows, by projected gradient ascent.
fn maximum_likelihood(rows: &[(Features, f64)]) -> (Features, f64) {
    // the curvature of the likelihood is at most a quarter of Σ(1 + ‖x‖²), and that is 1 + FEATURES a row
    let step = 4.0 / (rows.len() as f64 * (1.0 + FEATURES as f64) + RIDGE);
    let (mut weights, mut bias) = ([0.0; FEATURES], 0.0);
    for _ in 0..MOST_ITERATIONS {
        let (mut gradient, mut bias_gradient) = (weights.map(|w| -RIDGE * w), 0.0);
        for (x, right) in rows {
            let sum: f64 = bias + x.iter().zip(&weights).map(|(x, w)| x * w).sum::<f64>();
            let residual = right - logistic(sum);
            bias_gradient += residual;
            for k in 0..FEATURES {
                gradient[k] += residual * x[k];
            }
        }
        let before = (weights, bias);
        bias += step * bias_gradient;
        weights = std::array::from_fn(|k| (weights[k] + step * gradient[k]).max(0.0));
        let moved =
            (0..FEATURES).map(|k| (weights[k] - before.0[k]).abs()).fold((bias - before.1).abs(), f64::max);
        if moved < LEAST_STEP {
            break;
        }
    }
    (weights, bias)
}

/// The least threshold, 0.8 or more, that few of the unknown frames reach.
fn threshold(mut unknown: Vec<f64>) -> f64 {
    unknown.sort_by(|a, b| b.total_cmp(a));
    let accepted = (UNKNOWN_ACCEPTED * unknown.len() as f64) as usize;
    unknown.get(accepted).map_or(LEAST_THRESHOLD, |c| c.next_up().clamp(LEAST_THRESHOLD, 1.0))
}

/// Logarithm of the ratio of W to that of a rival; the rival's W is given as a part of W.
pub(super) fn log_margin(rival: Option<f64>) -> f64 {
    -rival.unwrap_or(LEAST_RIVAL).clamp(LEAST_RIVAL, 1.0).ln()
}

/// A sample scored by a curve that wasn't fitted to it.
#[derive(Clone)]
struct Scored {
    sample: CalibrationSample,
    confidence: f64,
    accepted: bool,
}

impl Reliability {
    fn of(scored: &[Scored]) -> Reliability {
        let count = |wanted: fn(&Scored) -> bool| scored.iter().filter(|scored| wanted(scored)).count();
        let rate = |met: usize, all: usize| if all == 0 { 0.0 } else { met as f64 / all as f64 };
        let (known, unknown) = (count(|s| s.sample.known), count(|s| !s.sample.known));
        Reliability {
            known,
            unknown,
            known_named: rate(count(|s| s.sample.known && s.sample.right && s.accepted), known),
            known_misnamed: rate(count(|s| s.sample.known && !s.sample.right && s.accepted), known),
            unknown_refused: rate(count(|s| !s.sample.known && !s.accepted), unknown),
            curve: reliability_diagram(scored),
        }
    }
}

fn reliability_diagram(scored: &[Scored]) -> Vec<ReliabilityBin> {
    const BINS: usize = 10;
    let bin = |number: usize| {
        let inside: Vec<&Scored> = scored
            .iter()
            .filter(|scored| ((scored.confidence * BINS as f64) as usize).min(BINS - 1) == number)
            .collect();
        let answers = inside.len();
        let right = inside.iter().filter(|scored| scored.sample.right).count();
        let sum = inside.iter().fold(0.0, |sum, scored| sum + scored.confidence);
        ReliabilityBin { confidence: sum / answers as f64, answers, right: right as f64 / answers as f64 }
    };
    (0..BINS).map(bin).filter(|bin| bin.answers > 0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::imaging::Random;

    fn evidence(log_margin: f64, lead: f64, share: f64) -> Evidence {
        Evidence::Vote { log_margin, lead, share, log_points: 0.0 }
    }

    /// Answers whose chance to be right is a logistic curve of the first evidence; the second says nothing, the
    /// third speaks against.
    fn answers(count: usize) -> Vec<CalibrationSample> {
        let mut random = Random::new(7, 1);
        let answer = |i: usize| {
            let known = i.is_multiple_of(2);
            let strength = if known { random.between(0.0, 1.6) } else { random.between(0.0, 0.3) };
            let chance = 1.0 / (1.0 + (-(8.0 * strength - 6.0)).exp());
            let right = known && random.uniform() < chance;
            let against = random.uniform() + if right { 0.0 } else { 0.3 };
            CalibrationSample { evidence: evidence(strength, random.uniform(), against), right, known }
        };
        (0..count).map(answer).collect()
    }

    #[test]
    fn of_answers_at_a_confidence_so_many_are_right() {
        let (confidence, reliability) = Confidence::fit(&answers(4000), 500).unwrap();
        assert_eq!((reliability.known, reliability.unknown), (2000, 2000));
        for bin in reliability.curve.iter().filter(|bin| bin.answers >= 150) {
            assert!((bin.right - bin.confidence).abs() < 0.09, "{bin:?}");
        }
        assert!(confidence.weights.iter().all(|w| *w >= 0.0), "{confidence:?}");
        assert_eq!(confidence.weights[2], 0.0);
        assert!(reliability.unknown_refused >= 0.98 && reliability.known_named > 0.35, "{reliability:?}");
        assert!(confidence.threshold >= 0.5);
    }

    #[test]
    fn more_evidence_is_never_less_sure() {
        let (confidence, _) = Confidence::fit(&answers(400), 50).unwrap();
        let sure = |strength: f64| confidence.of(&evidence(strength, 0.5, 0.5));
        assert!((0..20).all(|i| sure(f64::from(i) / 10.0) <= sure(f64::from(i + 1) / 10.0)));
    }

    #[test]
    fn evidence_that_never_varies_has_no_weight() {
        let mut samples = answers(400);
        for (number, row) in samples.iter_mut().enumerate() {
            let Evidence::Vote { share, .. } = &mut row.evidence else { panic!("it is a vote") };
            *share = if number % 3 == 0 { 0.3 } else { 0.1 + 0.2 };
        }
        assert_eq!(Confidence::fit(&samples, 50).unwrap().0.weights[2], 0.0);
    }

    #[test]
    fn too_few_samples_give_no_fit() {
        assert_eq!(Confidence::fit(&answers(LEAST_SAMPLES - 1), 3), None);
        let mut right = answers(100);
        right.iter_mut().for_each(|answer| answer.right = true);
        assert_eq!(Confidence::fit(&right, 13), None);
        assert_eq!(Confidence::fit(&[], 0), None);
    }
}
