//! How sure an answer is: the chance to be right, learnt from rehearsals whose truth is known.
//!
//! A logistic curve over some kinds of evidence, each of which can only add to the chance: the fit is monotone in
//! every one of them.

/// Kinds of evidence.
pub const EVIDENCE: usize = 4;

/// What speaks for an answer, each ≥ 0; all 0 where there is no answer. What they are depends on the method.
pub type Evidence = [f64; EVIDENCE];

/// An answer of a rehearsal, or none, and what would have been right.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rehearsed {
    /// Of the best answer.
    pub evidence: Evidence,
    /// Whether it names what the frame shows.
    pub right: bool,
    /// Whether the frame shows anything that the database knows.
    pub known: bool,
}

/// The fitted curve, and what it takes to be believed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Confidence {
    /// Weight of each kind of evidence, ≥ 0.
    pub weights: Evidence,
    /// Of the same unit.
    pub bias: f64,
    /// Answers below are none, 0.8..=1.
    pub threshold: f64,
}

/// What rehearsals told of the curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Reliability {
    /// Rehearsed frames that show something known, and that don't.
    pub known: usize,
    /// See above.
    pub unknown: usize,
    /// Part of the known ones that were named right at the threshold, by a curve that hadn't seen them.
    pub known_named: f64,
    /// Part of the known ones that were named wrong.
    pub known_misnamed: f64,
    /// Part of the unknown ones that were refused.
    pub unknown_refused: f64,
    /// The curve: of the answers with a confidence in each tenth, how many were right; by a curve that hadn't
    /// seen them.
    pub curve: Vec<ReliabilityBin>,
}

/// Answers of about the same confidence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReliabilityBin {
    /// Mean confidence.
    pub confidence: f64,
    /// Answers.
    pub answers: usize,
    /// Part of them that was right.
    pub right: f64,
}

/// Fewer answers than this say nothing of chances.
const LEAST_ANSWERS: usize = 20;
/// An answer that is wrong one time in five is none that a robot can act on.
const LEAST_THRESHOLD: f64 = 0.8;
/// Part of the frames without anything known that may be answered.
const UNKNOWN_ANSWERED: f64 = 0.02;
/// Evidence that varies less says nothing: rounding.
const LEAST_DEVIATION: f64 = 1e-6;
/// Weights are drawn to 0 as if this many answers said that evidence means nothing.
const RIDGE: f64 = 1.0;
/// Steps of the fit, and the length at which it has converged.
const MOST_STEPS: usize = 4000;
const LEAST_STEP: f64 = 1e-7;

impl Confidence {
    /// Fit to rehearsals in runs of [`REHEARSALS_TOGETHER`], of which every `exemplars`-th is of the same exemplar;
    /// `None` if there are too few answers, or only right or only wrong ones.
    pub fn fit(rehearsed: &[Rehearsed], exemplars: usize) -> Option<(Confidence, Reliability)> {
        let (known, unknown) = (count(rehearsed, |r| r.known), count(rehearsed, |r| !r.known));
        let confidence = Self::fitted(rehearsed)?;
        // each half of the exemplars is judged by the curve of the other
        let half = |odd: usize| -> Vec<Rehearsed> {
            let runs = rehearsed.chunks(REHEARSALS_TOGETHER).enumerate();
            let wanted = runs.filter(|(run, _)| run % exemplars.max(1) % 2 == odd);
            wanted.flat_map(|(_, rows)| rows).copied().collect()
        };
        let (even, odd) = (half(0), half(1));
        let judged_by = |judges: &[Rehearsed], others: &[Rehearsed]| -> Vec<Judged> {
            let curve = Self::fitted(judges).unwrap_or(confidence);
            let judged = |r: &Rehearsed| {
                let confidence = curve.of(&r.evidence);
                Judged { rehearsed: *r, confidence, decided: confidence >= curve.threshold }
            };
            others.iter().map(judged).collect()
        };
        let judged = [judged_by(&odd, &even), judged_by(&even, &odd)].concat();
        let part = |of: usize, wanted: fn(&Judged) -> bool| {
            let met = judged.iter().filter(|judged| wanted(judged)).count();
            if of == 0 { 0.0 } else { met as f64 / of as f64 }
        };
        let reliability = Reliability {
            known,
            unknown,
            known_named: part(known, |j| j.rehearsed.known && j.rehearsed.right && j.decided),
            known_misnamed: part(known, |j| j.rehearsed.known && !j.rehearsed.right && j.decided),
            unknown_refused: part(unknown, |j| !j.rehearsed.known && !j.decided),
            curve: curve(&judged),
        };
        Some((confidence, reliability))
    }

    /// The chance that an answer with this evidence is right, 0..=1.
    pub fn of(&self, evidence: &Evidence) -> f64 {
        let sum: f64 = self.weights.iter().zip(evidence).map(|(w, e)| w * e).sum();
        1.0 / (1.0 + (-(self.bias + sum)).exp())
    }

    /// The curve of greatest likelihood by projected gradients, on evidence of mean 0 and deviation 1, with the
    /// threshold that it takes.
    fn fitted(rehearsed: &[Rehearsed]) -> Option<Confidence> {
        let answers: Vec<(Evidence, f64)> =
            rehearsed.iter().map(|r| (r.evidence, f64::from(u8::from(r.right)))).collect();
        let count = answers.len() as f64;
        let right: f64 = answers.iter().map(|(_, right)| right).sum();
        if answers.len() < LEAST_ANSWERS || right == 0.0 || right == count {
            return None;
        }
        let mut mean = [0.0; EVIDENCE];
        let mut deviation = [0.0; EVIDENCE];
        for k in 0..EVIDENCE {
            mean[k] = answers.iter().map(|(e, _)| e[k]).sum::<f64>() / count;
            deviation[k] =
                (answers.iter().map(|(e, _)| (e[k] - mean[k]).powi(2)).sum::<f64>() / count).sqrt();
        }
        let scaled = |e: &Evidence, k: usize| {
            if deviation[k] > LEAST_DEVIATION { (e[k] - mean[k]) / deviation[k] } else { 0.0 }
        };
        let rows: Vec<(Evidence, f64)> =
            answers.iter().map(|(e, y)| ([0, 1, 2, 3].map(|k| scaled(e, k)), *y)).collect();
        // the curvature of the likelihood is at most a quarter of Σ(1 + ‖e‖²), and that is 1 + EVIDENCE an answer
        let step = 4.0 / (count * (1.0 + EVIDENCE as f64) + RIDGE);
        let (mut weights, mut bias) = ([0.0; EVIDENCE], 0.0);
        for _ in 0..MOST_STEPS {
            let (mut slope, mut bias_slope) = (weights.map(|w| -RIDGE * w), 0.0);
            for (e, y) in &rows {
                let sum: f64 = bias + e.iter().zip(&weights).map(|(e, w)| e * w).sum::<f64>();
                let missed = y - 1.0 / (1.0 + (-sum).exp());
                bias_slope += missed;
                for k in 0..EVIDENCE {
                    slope[k] += missed * e[k];
                }
            }
            let before = (weights, bias);
            bias += step * bias_slope;
            for k in 0..EVIDENCE {
                weights[k] = (weights[k] + step * slope[k]).max(0.0);
            }
            let moved = (0..EVIDENCE)
                .map(|k| (weights[k] - before.0[k]).abs())
                .fold((bias - before.1).abs(), f64::max);
            if moved < LEAST_STEP {
                break;
            }
        }
        let unscaled = [0, 1, 2, 3]
            .map(|k| if deviation[k] > LEAST_DEVIATION { weights[k] / deviation[k] } else { 0.0 });
        let shift: f64 = (0..EVIDENCE).map(|k| unscaled[k] * mean[k]).sum();
        let curve = Confidence { weights: unscaled, bias: bias - shift, threshold: LEAST_THRESHOLD };
        let unknown = rehearsed.iter().filter(|r| !r.known).map(|r| curve.of(&r.evidence));
        Some(Confidence { threshold: threshold(unknown.collect()), ..curve })
    }
}

/// Rehearsals of one exemplar stand together: they are alike, so they are judged by a curve that saw none of them.
pub const REHEARSALS_TOGETHER: usize = 8;

fn count(rehearsed: &[Rehearsed], wanted: impl Fn(&Rehearsed) -> bool) -> usize {
    rehearsed.iter().filter(|r| wanted(r)).count()
}

/// An answer and what a curve that hadn't seen it makes of it.
#[derive(Clone)]
struct Judged {
    rehearsed: Rehearsed,
    confidence: f64,
    decided: bool,
}

/// The least confidence, 0.8 or more, that few of the frames without anything known reach.
fn threshold(mut unknown: Vec<f64>) -> f64 {
    unknown.sort_by(|a, b| b.total_cmp(a));
    let answered = (UNKNOWN_ANSWERED * unknown.len() as f64) as usize;
    unknown.get(answered).map_or(LEAST_THRESHOLD, |c| c.next_up().clamp(LEAST_THRESHOLD, 1.0))
}

fn curve(judged: &[Judged]) -> Vec<ReliabilityBin> {
    const BINS: usize = 10;
    let mut sums = [(0.0, 0, 0); BINS];
    for Judged { rehearsed, confidence, .. } in judged {
        let bin = &mut sums[((confidence * BINS as f64) as usize).min(BINS - 1)];
        *bin = (bin.0 + confidence, bin.1 + 1, bin.2 + usize::from(rehearsed.right));
    }
    let filled = sums.into_iter().filter(|(_, answers, _)| *answers > 0);
    filled
        .map(|(sum, answers, right)| ReliabilityBin {
            confidence: sum / answers as f64,
            answers,
            right: right as f64 / answers as f64,
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::imaging::Random;

    /// Answers whose chance to be right is a logistic curve of the first evidence; the second says nothing, the
    /// third speaks against.
    fn answers(count: usize) -> Vec<Rehearsed> {
        let mut random = Random::new(7, 1);
        let answer = |i: usize| {
            let known = i.is_multiple_of(2);
            let strength = if known { random.between(0.0, 1.6) } else { random.between(0.0, 0.3) };
            let chance = 1.0 / (1.0 + (-(8.0 * strength - 6.0)).exp());
            let right = known && random.uniform() < chance;
            let against = random.uniform() + if right { 0.0 } else { 0.3 };
            Rehearsed { evidence: [strength, random.uniform(), against, 0.0], right, known }
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
        let sure = |strength: f64| confidence.of(&[strength, 0.5, 0.5, 0.0]);
        assert!((0..20).all(|i| sure(f64::from(i) / 10.0) <= sure(f64::from(i + 1) / 10.0)));
    }

    #[test]
    fn evidence_that_never_varies_has_no_weight() {
        let mut rehearsed = answers(400);
        for (number, row) in rehearsed.iter_mut().enumerate() {
            row.evidence[2] = if number % 3 == 0 { 0.3 } else { 0.1 + 0.2 };
        }
        assert_eq!(Confidence::fit(&rehearsed, 50).unwrap().0.weights[2], 0.0);
    }

    #[test]
    fn too_little_says_nothing() {
        assert_eq!(Confidence::fit(&answers(LEAST_ANSWERS - 1), 3), None);
        let mut right = answers(100);
        right.iter_mut().for_each(|answer| answer.right = true);
        assert_eq!(Confidence::fit(&right, 13), None);
        assert_eq!(Confidence::fit(&[], 0), None);
    }
}
