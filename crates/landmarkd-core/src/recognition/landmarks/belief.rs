//! Belief of where a robot is, by all the frames of its way so far: a Bayes filter over the exemplars.
//!
//! A belief holds a probability for every exemplar and one for *elsewhere*; together they are 1. Each frame first predicts
//! how the robot may have moved, then weighs the belief by W of the exemplars. Only frames of the past count.
//!
//! Along a path the state is an exemplar and a speed in exemplars a frame, from 3 back to 3 ahead: a robot keeps its
//! speed for about ten frames, drifts by one now and then, and is seldom kidnapped. Frames of a robot that stands
//! show the same twice over, right or wrong, so they count less: without that an exemplar that looks like
//! everything around it would hold the belief.
//!
//! The numbers below were chosen on a corridor walked twice (111 exemplars, 111 frames, within 2 exemplars is right) with
//! votes that name 0.63 and 0.75 of its single frames rightly: 0.99 with either, 0.92 and 0.97 walking back. A robot that
//! is kidnapped is found again after 4 to 9 frames. With the paper's vote, right on 0.30 alone, there is too little to
//! add up.

use super::description::ExemplarName;

/// The motion model of the robot among the exemplars.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Motion {
    /// The order of the exemplars is unknown: the belief stays, and fades a little.
    Still,
    /// The exemplars follow one another: the indices of all in the order in which the robot passes them.
    Path(Vec<usize>),
}

/// The belief in one label.
#[derive(Clone, Debug, PartialEq)]
pub struct LabelBelief {
    /// The class or place.
    pub label: String,
    /// The probability of its exemplars together.
    pub probability: f64,
    /// The most probable of them: index into the model's exemplars.
    pub exemplar: usize,
}

/// The probabilities of where the robot is.
#[derive(Clone, Debug, PartialEq)]
pub struct Belief {
    motion: Motion,
    /// n speeds × n exemplars, row-major: the probability of every place in the order of the path.
    states: Vec<f64>,
    /// The probability of being at no exemplar.
    elsewhere: f64,
}

/// Speeds along a path, exemplars a frame.
const SPEEDS: [isize; 7] = [-3, -2, -1, 0, 1, 2, 3];
/// Probability that a robot takes up each speed when it changes. Standing is rarer by a factor of five: a few frames
/// reveal a robot that stands for long.
const MOVES: f64 = 5.0 / 31.0;
const STANDS: f64 = 1.0 / 31.0;
/// Probability of keeping the speed from one frame to the next.
const KEEPS_SPEED: f64 = 0.9;
/// Probability of being one exemplar ahead of the speed; as much again of being one behind.
const DRIFTS: f64 = 0.05;
/// Probability of being kidnapped between two frames, that is carried to anywhere among the exemplars: along a path and
/// without one.
const KIDNAPPED_ON_PATH: f64 = 0.01;
const KIDNAPPED: f64 = 0.1;
/// Probability of leaving for elsewhere between two frames.
const LEAVES: f64 = 0.001;
/// Probability of coming back from elsewhere between two frames.
const RETURNS: f64 = 0.1;
/// Probability of being elsewhere before the first frame.
const ELSEWHERE_AT_FIRST: f64 = 0.5;
/// The part of the probability beyond the path's end that is elsewhere. The rest is anywhere along the path.
const ELSEWHERE_PAST_THE_END: f64 = 0.5;

/// Log-odds of one standard deviation of W.
const SHARPNESS: f64 = 0.6;
/// The part of the log-odds that counts for a robot that stands.
const STANDING_SHARPNESS: f64 = 0.3;
/// Least standard deviation of W, as a part of the greatest.
const LEAST_DEVIATION: f64 = 0.1;
/// More deviations than this add nothing.
const MOST_DEVIATIONS: f64 = 8.0;
/// Deviations that are evidence neither for an exemplar nor for elsewhere, as a part of what the best of the wrong ones
/// reaches by chance.
const NEUTRAL: f64 = 0.65;

impl Belief {
    /// The belief before the first frame: anywhere among so many exemplars, or elsewhere.
    pub fn new(motion: Motion, exemplars: usize) -> Self {
        let mut belief = Self { motion, states: Vec::new(), elsewhere: ELSEWHERE_AT_FIRST };
        let each = (1.0 - ELSEWHERE_AT_FIRST) / exemplars as f64;
        for &speed in belief.speeds() {
            belief.states.extend(std::iter::repeat_n(belief.prior(speed) * each, exemplars));
        }
        belief
    }

    /// The same belief over the exemplars of another model. `before` has of each its index in the model before, if it was
    /// there. The probability of those that are gone goes to elsewhere.
    pub fn carried_over(&self, motion: Motion, before: &[Option<usize>]) -> Self {
        let mut next = Self { motion, states: Vec::new(), elsewhere: 0.0 };
        let probabilities = self.probabilities();
        let keeps_speed = self.speeds().len() == next.speeds().len();
        for (row, &speed) in next.speeds().iter().enumerate() {
            let of_speed: Vec<f64> = match keeps_speed {
                true => self.by_exemplar(&self.states[row * self.places()..][..self.places()]),
                false => probabilities.iter().map(|probability| next.prior(speed) * probability).collect(),
            };
            let states = (0..before.len()).map(|place| before[next.exemplar_at(place)]);
            let states: Vec<f64> =
                states.map(|before| before.map_or(0.0, |before| of_speed[before])).collect();
            next.states.extend(states);
        }
        next.elsewhere = (1.0 - next.states.iter().sum::<f64>()).max(0.0);
        next
    }

    fn speeds(&self) -> &'static [isize] {
        match self.motion {
            Motion::Still => &[0],
            Motion::Path(_) => &SPEEDS,
        }
    }

    fn prior(&self, speed: isize) -> f64 {
        match self.motion {
            Motion::Still => 1.0,
            Motion::Path(_) => {
                if speed == 0 {
                    STANDS
                } else {
                    MOVES
                }
            }
        }
    }

    fn places(&self) -> usize {
        self.states.len() / self.speeds().len()
    }

    fn exemplar_at(&self, place: usize) -> usize {
        match &self.motion {
            Motion::Still => place,
            Motion::Path(order) => order[place],
        }
    }

    /// The probability of each place, whatever the speed.
    fn by_place(&self) -> Vec<f64> {
        let mut sums = vec![0.0; self.places()];
        for row in self.states.chunks_exact(self.places()) {
            sums.iter_mut().zip(row).for_each(|(sum, probability)| *sum += probability);
        }
        sums
    }

    /// Values in the order of the places, reordered to that of the exemplars.
    fn by_exemplar(&self, of_places: &[f64]) -> Vec<f64> {
        let mut of_exemplars = vec![0.0; of_places.len()];
        of_places
            .iter()
            .enumerate()
            .for_each(|(place, value)| of_exemplars[self.exemplar_at(place)] = *value);
        of_exemplars
    }

    /// The motion model.
    pub fn motion(&self) -> &Motion {
        &self.motion
    }

    /// The probability of each exemplar, in the model's order.
    pub fn probabilities(&self) -> Vec<f64> {
        self.by_exemplar(&self.by_place())
    }

    /// The probability of being at no exemplar.
    pub fn elsewhere(&self) -> f64 {
        self.elsewhere
    }

    /// The probability of being at nothing known: elsewhere, or at a negative exemplar. `exemplars` are the model's.
    pub fn unknown(&self, exemplars: &[ExemplarName]) -> f64 {
        let probabilities = self.probabilities();
        let negative = exemplars.iter().zip(&probabilities).filter(|(exemplar, _)| exemplar.label.is_empty());
        negative.fold(self.elsewhere, |sum, (_, probability)| sum + probability)
    }

    /// The probability of each label, likeliest first; of equals the one that sorts first. `exemplars` are the model's.
    pub fn labels(&self, exemplars: &[ExemplarName]) -> Vec<LabelBelief> {
        let probabilities = self.probabilities();
        let mut beliefs: Vec<LabelBelief> = Vec::new();
        for (exemplar, (ExemplarName { label, .. }, probability)) in
            exemplars.iter().zip(&probabilities).enumerate().filter(|(_, (name, _))| !name.label.is_empty())
        {
            match beliefs.last_mut().filter(|belief| belief.label == *label) {
                Some(belief) => {
                    belief.probability += probability;
                    if *probability > probabilities[belief.exemplar] {
                        belief.exemplar = exemplar;
                    }
                }
                None => {
                    beliefs.push(LabelBelief { label: label.clone(), probability: *probability, exemplar })
                }
            }
        }
        beliefs.sort_by(|a, b| b.probability.total_cmp(&a.probability));
        beliefs
    }

    /// The label that is believed more than all else together, with that probability. Along a path, where pictures overlap, a
    /// label is believed together with the places directly before and after its own. `exemplars` are the model's.
    pub fn decision(&self, exemplars: &[ExemplarName]) -> Option<(String, f64)> {
        let LabelBelief { label, .. } = self.labels(exemplars).into_iter().next()?;
        let is_own = |place: &usize| exemplars[self.exemplar_at(*place)].label == label;
        let reach = match self.motion {
            Motion::Still => 0,
            Motion::Path(_) => 1,
        };
        let by_place = self.by_place();
        let near = |place: &usize| {
            let last = (place + reach).min(by_place.len() - 1);
            (place.saturating_sub(reach)..=last).any(|beside| is_own(&beside))
        };
        let probability: f64 = (0..by_place.len()).filter(near).map(|place| by_place[place]).sum();
        (probability > 0.5).then_some((label, probability))
    }

    /// Adds the next frame, by W of every exemplar in the model's order. Only their proportions count; with none above 0
    /// the belief is predicted, and not weighed.
    pub fn add(&mut self, weights: &[f64]) {
        self.predict();
        self.observe(weights);
    }

    /// Prediction: moves the belief by the motion model.
    fn predict(&mut self) {
        let (places, speeds, by_place) = (self.places(), self.speeds(), self.by_place());
        let mut next = vec![0.0; self.states.len()];
        let mut past_the_end = 0.0;
        for (row, &speed) in speeds.iter().enumerate() {
            let drifts = if speed == 0 { 0.0 } else { DRIFTS };
            for (place, at_any_speed) in by_place.iter().enumerate() {
                let probability = KEEPS_SPEED * self.states[row * places + place]
                    + (1.0 - KEEPS_SPEED) * self.prior(speed) * at_any_speed;
                for (drift, share) in [(-1, drifts), (0, 1.0 - 2.0 * drifts), (1, drifts)] {
                    match place.checked_add_signed(speed + drift).filter(|to| *to < places) {
                        Some(to) => next[row * places + to] += share * probability,
                        None => past_the_end += share * probability,
                    }
                }
            }
        }
        let kidnapped = match self.motion {
            Motion::Still => KIDNAPPED,
            Motion::Path(_) => KIDNAPPED_ON_PATH,
        };
        let here = next.iter().sum::<f64>();
        let anywhere =
            here * kidnapped + self.elsewhere * RETURNS + past_the_end * (1.0 - ELSEWHERE_PAST_THE_END);
        self.elsewhere =
            self.elsewhere * (1.0 - RETURNS) + here * LEAVES + past_the_end * ELSEWHERE_PAST_THE_END;
        for (row, &speed) in next.chunks_exact_mut(places).zip(speeds) {
            let arriving = self.prior(speed) * anywhere / places as f64;
            row.iter_mut().for_each(|state| *state = *state * (1.0 - kidnapped - LEAVES) + arriving);
        }
        self.states = next;
    }

    /// Correction: weighs the belief by the evidence of the frame.
    fn observe(&mut self, weights: &[f64]) {
        let Some(evidence) = evidence(weights) else { return };
        let (places, speeds) = (self.places(), self.speeds());
        let evidence: Vec<f64> = (0..places).map(|place| evidence[self.exemplar_at(place)]).collect();
        let odds: Vec<f64> = evidence.iter().map(|evidence| evidence.exp()).collect();
        let odds_standing: Vec<f64> =
            evidence.iter().map(|evidence| (STANDING_SHARPNESS * evidence).exp()).collect();
        for (row, speed) in self.states.chunks_exact_mut(places).zip(speeds) {
            let stands_along_a_path = *speed == 0 && speeds.len() > 1;
            let odds = if stands_along_a_path { &odds_standing } else { &odds };
            row.iter_mut().zip(odds).for_each(|(state, odds)| *state *= odds);
        }
        let all = self.states.iter().sum::<f64>() + self.elsewhere;
        self.states.iter_mut().for_each(|state| *state /= all);
        self.elsewhere /= all;
    }

    /// Memory held.
    pub fn bytes(&self) -> usize {
        let order = match &self.motion {
            Motion::Still => 0,
            Motion::Path(order) => size_of_val(&order[..]),
        };
        size_of::<Self>() + size_of_val(&self.states[..]) + order
    }
}

/// The log-odds of each exemplar against elsewhere; `None` if no W is above 0, or there is one exemplar alone.
///
/// The scale of W differs from frame to frame, so an exemplar is compared with the others of the same frame: by how many
/// of their standard deviations its W lies above their mean. Of many, some lie high by chance: √(2 ln n) for n normal
/// ones.
fn evidence(weights: &[f64]) -> Option<Vec<f64>> {
    let greatest = weights.iter().copied().fold(0.0, f64::max);
    let others = weights.len().checked_sub(1).filter(|others| *others > 0 && greatest > 0.0)? as f64;
    let scaled = || weights.iter().map(|weight| weight / greatest);
    let (sum, squares) = scaled().fold((0.0, 0.0), |(sum, squares), w| (sum + w, squares + w * w));
    let neutral = NEUTRAL * (2.0 * (weights.len() as f64).ln()).sqrt();
    let deviations = scaled().map(|weight| {
        let mean = (sum - weight) / others;
        let variance = ((squares - weight * weight) / others - mean * mean).max(0.0);
        (weight - mean) / (variance + LEAST_DEVIATION * LEAST_DEVIATION).sqrt()
    });
    Some(deviations.map(|deviations| SHARPNESS * (deviations.min(MOST_DEVIATIONS) - neutral)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLACES: usize = 60;

    /// A number in 0..1 of its own for every pair.
    fn noise(frame: usize, exemplar: usize) -> f64 {
        let mixed = (frame * 7919 + exemplar * 104_729 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let mixed = (mixed ^ (mixed >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        (mixed >> 40) as f64 / (1u64 << 24) as f64
    }

    /// W of a frame taken at a place: mostly high there and beside it, and now and then anywhere else.
    fn weights_at(frame: usize, place: usize) -> Vec<f64> {
        let weight = |exemplar: usize| {
            let near = match exemplar.abs_diff(place) {
                0 => 1.2,
                1 => 0.6,
                _ => 0.0,
            };
            near * (0.4 + 0.6 * noise(frame, 1000)) + noise(frame, exemplar).powi(4)
        };
        (0..PLACES).map(weight).collect()
    }

    #[test]
    fn along_a_path_the_places_beside_a_label_speak_for_it() {
        let names: Vec<ExemplarName> =
            (0..4).map(|place| ExemplarName { id: format!("{place}"), label: format!("{place}") }).collect();
        let believed = |motion: Motion| {
            let mut belief = Belief::new(motion, 4);
            let speeds = belief.speeds().len();
            let of_places = [0.1, 0.3, 0.35, 0.2];
            belief.states = of_places.repeat(speeds).into_iter().map(|p| p / speeds as f64).collect();
            belief.elsewhere = 0.05;
            belief.decision(&names)
        };
        assert_eq!(believed(Motion::Still), None);
        let (label, probability) = believed(Motion::Path((0..4).collect())).unwrap();
        assert_eq!(label, "2");
        assert!((probability - 0.85).abs() < 1e-9);
    }

    fn in_order() -> Belief {
        Belief::new(Motion::Path((0..PLACES).collect()), PLACES)
    }

    fn best(probabilities: &[f64]) -> usize {
        (0..probabilities.len()).max_by(|a, b| probabilities[*a].total_cmp(&probabilities[*b])).unwrap()
    }

    /// After every frame, how far the likeliest exemplar is from where the robot is.
    fn misses(belief: &mut Belief, walk: impl Iterator<Item = usize>) -> Vec<usize> {
        let step = |(frame, place): (usize, usize)| {
            belief.add(&weights_at(frame, place));
            best(&belief.probabilities()).abs_diff(place)
        };
        walk.enumerate().map(step).collect()
    }

    fn sum(belief: &Belief) -> f64 {
        belief.probabilities().iter().sum::<f64>() + belief.elsewhere()
    }

    #[test]
    fn frames_that_are_often_wrong_add_up_along_a_path() {
        let singly = (0..PLACES).filter(|&at| best(&weights_at(at, at)).abs_diff(at) > 1).count();
        assert!(singly > PLACES / 4, "single frames are wrong {singly} times");
        let on = (0..PLACES).collect::<Vec<_>>();
        let back = (0..PLACES).rev().collect::<Vec<_>>();
        let by_twos = (0..PLACES).step_by(2).collect::<Vec<_>>();
        let with_a_stop = (0..30).chain([30; 6]).chain(30..PLACES).collect::<Vec<_>>();
        for walk in [on, back, by_twos, with_a_stop] {
            let misses = misses(&mut in_order(), walk.iter().copied());
            let wrong = misses.iter().skip(6).filter(|miss| **miss > 2).count();
            assert!(wrong * 20 <= misses.len(), "{misses:?}");
        }
    }

    #[test]
    fn the_order_of_the_path_is_what_counts_not_that_of_the_model() {
        let order: Vec<usize> = (0..PLACES).map(|at| at * 7 % PLACES).collect();
        let mut belief = Belief::new(Motion::Path(order.clone()), PLACES);
        let mut straight = in_order();
        for at in 0..40 {
            let along = weights_at(at, at);
            let mut weights = vec![0.0; PLACES];
            order.iter().zip(&along).for_each(|(&exemplar, weight)| weights[exemplar] = *weight);
            belief.add(&weights);
            straight.add(&along);
            let (found, expected) = (belief.probabilities(), straight.probabilities());
            let apart = order.iter().zip(&expected).map(|(&e, p)| (found[e] - p).abs()).fold(0.0, f64::max);
            assert!(apart < 1e-9, "{apart} apart at {at}");
        }
    }

    #[test]
    fn a_kidnapped_robot_is_found_again() {
        let mut belief = in_order();
        let misses = misses(&mut belief, (0..25).chain(45..PLACES));
        assert!(misses[20..25].iter().all(|miss| *miss <= 2), "{misses:?}");
        let lost = misses[25..].iter().take_while(|miss| **miss > 2).count();
        assert!(lost <= 8, "{lost} frames: {misses:?}");
    }

    #[test]
    fn an_exemplar_like_everything_around_it_does_not_hold_a_walking_robot() {
        let mut belief = in_order();
        for at in 0..30 {
            let mut weights = vec![1.0; PLACES];
            weights[at] = 8.0;
            weights[10] = if (10..18).contains(&at) { 9.0 } else { weights[10] };
            belief.add(&weights);
            let found = best(&belief.probabilities());
            assert!(at < 5 || found == at, "at {at} it is taken to be at {found}");
        }
    }

    #[test]
    fn frames_without_an_outstanding_exemplar_are_elsewhere() {
        let mut belief = in_order();
        misses(&mut belief, 0..20);
        let known = belief.elsewhere();
        for frame in 100..130 {
            belief.add(&(0..PLACES).map(|exemplar| noise(frame, exemplar).powi(4)).collect::<Vec<_>>());
        }
        assert!(known < 0.3 && belief.elsewhere() > 0.5, "{known} {}", belief.elsewhere());
    }

    #[test]
    fn without_an_order_a_belief_grows_and_fades() {
        let weights = |best: usize| (0..9).map(|at| if at == best { 3.0 } else { 1.0 }).collect::<Vec<_>>();
        let mut belief = Belief::new(Motion::Still, 9);
        let mut last = 0.0;
        for _ in 0..3 {
            belief.add(&weights(4));
            let probability = belief.probabilities()[4];
            assert!(probability > last);
            last = probability;
        }
        assert!(last > 0.5, "{last}");
        // a frame that says nothing
        belief.add(&[0.0; 9]);
        assert!(belief.probabilities()[4] < last);
        belief.add(&weights(2));
        belief.add(&weights(2));
        assert_eq!(best(&belief.probabilities()), 2);
    }

    #[test]
    fn only_the_proportions_of_weights_count() {
        let (mut belief, mut other) = (in_order(), in_order());
        for at in 0..5 {
            belief.add(&weights_at(at, at));
            other.add(&weights_at(at, at).iter().map(|weight| weight * 1024.0).collect::<Vec<_>>());
        }
        assert_eq!(belief, other);
    }

    #[test]
    fn one_exemplar_alone_can_not_be_held_against_others() {
        let mut belief = Belief::new(Motion::Path(vec![0]), 1);
        belief.add(&[5.0]);
        assert!((sum(&belief) - 1.0).abs() < 1e-12 && belief.probabilities()[0] < 0.6);
    }

    #[test]
    fn what_is_believed_is_carried_over_with_the_speed() {
        let mut belief = in_order();
        misses(&mut belief, (0..40).step_by(2));
        // The first five are gone, three are new, and all have other numbers.
        let before: Vec<Option<usize>> =
            (5..PLACES + 3).rev().map(|at| (at < PLACES).then_some(at)).collect();
        let path = Motion::Path((0..before.len()).rev().collect());
        let mut next = belief.carried_over(path, &before);
        let gone: f64 = belief.probabilities()[..5].iter().sum();
        assert!((next.elsewhere() - belief.elsewhere() - gone).abs() < 1e-9);
        for (found, before) in next.probabilities().iter().zip(&before) {
            assert!((found - before.map_or(0.0, |before| belief.probabilities()[before])).abs() < 1e-12);
        }
        // A frame that says nothing: the robot goes on as fast as it was.
        next.add(&vec![0.0; before.len()]);
        assert_eq!(before[best(&next.probabilities())], Some(40));

        let mut still = next.carried_over(Motion::Still, &(0..before.len()).map(Some).collect::<Vec<_>>());
        assert!((sum(&still) - 1.0).abs() < 1e-9);
        assert_eq!(best(&still.probabilities()), best(&next.probabilities()));
        still.add(&vec![1.0; before.len()]);
        assert!((sum(&still) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn labels_add_up_their_exemplars() {
        let exemplar =
            |(at, label): (usize, &str)| ExemplarName { id: at.to_string(), label: label.to_owned() };
        let exemplars: Vec<_> = ["a", "b", "b", "c"].into_iter().enumerate().map(exemplar).collect();
        let states = vec![0.25, 0.125, 0.25, 0.25];
        let labels = Belief { motion: Motion::Still, states, elsewhere: 0.125 }.labels(&exemplars);
        let found: Vec<_> = labels.iter().map(|l| (l.label.as_str(), l.probability, l.exemplar)).collect();
        assert_eq!(found, [("b", 0.375, 2), ("a", 0.25, 0), ("c", 0.25, 3)]);
    }

    #[test]
    fn at_a_negative_exemplar_is_at_nothing_known() {
        let exemplars =
            ["", "", "a"].map(|label| ExemplarName { id: label.to_owned(), label: label.to_owned() });
        let states = vec![0.25, 0.125, 0.5];
        let belief = Belief { motion: Motion::Still, states, elsewhere: 0.125 };
        let labels = belief.labels(&exemplars);
        assert_eq!(labels, [LabelBelief { label: "a".to_owned(), probability: 0.5, exemplar: 2 }]);
        assert_eq!(belief.unknown(&exemplars), 0.5);
    }
}
