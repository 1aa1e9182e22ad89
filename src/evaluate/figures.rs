//! The figures of an evaluation, and how they are printed: rates, times, confusions, errors of the pose.

use std::collections::BTreeMap;
use std::fmt;
use std::time::Instant;

use serde::Serialize;

use super::Skipped;
use landmarkd_core::statistics::nearest_rank;

/// A rate, and how much it rests on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Rate {
    /// Trials that went well.
    pub hits: usize,
    /// All trials.
    pub trials: usize,
    /// hits / trials; 0 without trials.
    pub rate: f64,
}

impl Rate {
    /// The rate of `hits` in `trials`.
    pub fn of(hits: usize, trials: usize) -> Rate {
        Rate { hits, trials, rate: hits as f64 / trials.max(1) as f64 }
    }

    /// How many of the trials are true.
    pub fn among(trials: impl IntoIterator<Item = bool>) -> Rate {
        let (mut hits, mut count) = (0, 0);
        for hit in trials {
            hits += usize::from(hit);
            count += 1;
        }
        Rate::of(hits, count)
    }

    /// The counts alone, such as "9 of 12".
    pub fn counts(self) -> String {
        format!("{} of {}", self.hits, self.trials)
    }
}

impl fmt::Display for Rate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.3} ({} of {})", self.rate, self.hits, self.trials)
    }
}

/// Frames of one label that were taken for another.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Confusion {
    /// What was shown.
    pub shown: String,
    /// What was answered; `None`: nothing.
    pub named: Option<String>,
    /// How often.
    pub times: usize,
}

impl Confusion {
    /// Wrong answers counted, most frequent first; each is what was shown and what was named.
    pub(super) fn counted(wrong: impl IntoIterator<Item = (String, Option<String>)>) -> Vec<Confusion> {
        let mut times: BTreeMap<(String, Option<String>), usize> = BTreeMap::new();
        for pair in wrong {
            *times.entry(pair).or_default() += 1;
        }
        let mut pairs: Vec<Confusion> =
            times.into_iter().map(|((shown, named), times)| Confusion { shown, named, times }).collect();
        pairs.sort_by_key(|pair| std::cmp::Reverse(pair.times)); // stable: equal ones stay in the order of labels
        pairs
    }
}

impl fmt::Display for Confusion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Confusion { shown, named, times } = self;
        write!(f, "{shown} as {}", named.as_deref().unwrap_or("nothing"))?;
        if *times > 1 { write!(f, " ({times})") } else { Ok(()) }
    }
}

/// Times of one step over all queries.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Times {
    /// Half of them took no longer.
    pub p50_ms: f64,
    /// 95 of 100 took no longer.
    pub p95_ms: f64,
}

impl Times {
    /// Percentiles by nearest rank; 0 of nothing.
    pub(super) fn of(mut all_ms: Vec<f64>) -> Times {
        all_ms.sort_by(f64::total_cmp);
        let [p50_ms, p95_ms] = [0.50, 0.95].map(|part| nearest_rank(&all_ms, part).unwrap_or(0.0));
        Times { p50_ms, p95_ms }
    }
}

/// Milliseconds from a moment to now.
pub(super) fn ms_since(started: Instant) -> f64 {
    started.elapsed().as_secs_f64() * 1e3
}

/// Does the work and adds the milliseconds that it took to `total_ms`.
pub(super) fn timed<T>(total_ms: &mut f64, work: impl FnOnce() -> T) -> T {
    let started = Instant::now();
    let done = work();
    *total_ms += ms_since(started);
    done
}

/// How far answered poses were from the true ones, on the circle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PoseErrors {
    /// Answered poses.
    pub trials: usize,
    /// Their mean.
    pub mean_deg: f64,
    /// By nearest rank.
    pub median_deg: f64,
    /// 95 of 100 are no larger.
    pub p95_deg: f64,
    /// The largest error.
    pub worst_deg: f64,
    /// Errors of 5° or less.
    pub within_5_deg: Rate,
}

impl PoseErrors {
    /// Percentiles by nearest rank; `None` of nothing.
    pub fn of(mut errors_deg: Vec<f64>) -> Option<PoseErrors> {
        errors_deg.sort_by(f64::total_cmp);
        let worst_deg = *errors_deg.last()?;
        Some(PoseErrors {
            trials: errors_deg.len(),
            mean_deg: errors_deg.iter().sum::<f64>() / errors_deg.len() as f64,
            median_deg: nearest_rank(&errors_deg, 0.50)?,
            p95_deg: nearest_rank(&errors_deg, 0.95)?,
            worst_deg,
            within_5_deg: Rate::among(errors_deg.iter().map(|error_deg| *error_deg <= 5.0)),
        })
    }
}

impl fmt::Display for PoseErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let PoseErrors { mean_deg, median_deg, p95_deg, worst_deg, within_5_deg, .. } = self;
        write!(
            f,
            "mean {mean_deg:.2}°, median {median_deg:.2}°, p95 {p95_deg:.2}°, worst {worst_deg:.1}°, "
        )?;
        write!(f, "within 5° {within_5_deg}")
    }
}

/// A line of the table: its name, and what there is to say.
pub(super) fn row(f: &mut fmt::Formatter<'_>, name: &str, value: &dyn fmt::Display) -> fmt::Result {
    writeln!(f, "{name:<14}{value}")
}

/// How many confused pairs and skipped pictures the table names; the JSON has them all.
const LISTED: usize = 12;
const PAIRS_A_LINE: usize = 3;

/// The rows that every evaluation ends with: what was confused, and what was left out.
pub(super) fn closing_rows(
    f: &mut fmt::Formatter<'_>,
    confusion: &[Confusion],
    untrained_labels: &[String],
    skipped: &[Skipped],
) -> fmt::Result {
    let listed: Vec<String> = confusion.iter().take(LISTED).map(Confusion::to_string).collect();
    for (n, pairs) in listed.chunks(PAIRS_A_LINE).enumerate() {
        row(f, if n == 0 { "confused" } else { "" }, &pairs.join(", "))?;
    }
    if confusion.len() > LISTED {
        row(f, "", &format_args!("and {} pairs more", confusion.len() - LISTED))?;
    }
    if !untrained_labels.is_empty() {
        row(f, "not trained", &format_args!("{} (no known object)", untrained_labels.join(", ")))?;
    }
    if !skipped.is_empty() {
        row(f, "skipped", &format_args!("{} pictures", skipped.len()))?;
    }
    for picture in skipped.iter().take(LISTED) {
        row(f, "", &format_args!("{}: {}", picture.file, picture.reason))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_by_nearest_rank() {
        let Times { p50_ms, p95_ms } = Times::of((1..=100).rev().map(f64::from).collect());
        assert_eq!((p50_ms, p95_ms), (50.0, 95.0));
        assert_eq!(Times::of(Vec::new()), Times { p50_ms: 0.0, p95_ms: 0.0 });
        assert_eq!(Times::of(vec![3.0]), Times { p50_ms: 3.0, p95_ms: 3.0 });
    }

    #[test]
    fn pose_errors_tell_of_all_trials() {
        let errors = PoseErrors::of(vec![9.0, 1.0, 5.0, 2.0]).unwrap();
        assert_eq!((errors.trials, errors.mean_deg, errors.median_deg), (4, 4.25, 2.0));
        assert_eq!((errors.p95_deg, errors.worst_deg, errors.within_5_deg), (9.0, 9.0, Rate::of(3, 4)));
        assert_eq!(PoseErrors::of(Vec::new()), None);
    }

    #[test]
    fn the_most_frequent_confusion_comes_first() {
        let wrong = [("b", None), ("a", Some("b")), ("b", None), ("a", None)];
        let counted =
            Confusion::counted(wrong.map(|(shown, named)| (shown.to_owned(), named.map(str::to_owned))));
        let printed: Vec<String> = counted.iter().map(Confusion::to_string).collect();
        assert_eq!(printed, ["b as nothing (2)", "a as nothing", "a as b"]);
    }
}
