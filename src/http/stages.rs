//! The stage clock: the time that each stage of a piece of work takes.

use std::time::{Duration, Instant};

use crate::telemetry::otlp::note_stage;
use crate::telemetry::{Metrics, Work};

/// A time in milliseconds.
pub fn ms(duration: Duration) -> f64 {
    duration.as_secs_f64() * 1e3
}

/// The times of the stages of a piece of work. The times of a stage that comes again are added up.
pub struct StageClock {
    since: Instant,
    took: Vec<(&'static str, Duration)>,
}

impl StageClock {
    /// Starts the first stage.
    pub fn begin() -> Self {
        Self { since: Instant::now(), took: Vec::new() }
    }

    /// Records these stages in any case: with 0 if they never come.
    pub fn expect(&mut self, stages: &[&'static str]) {
        self.took.extend(stages.iter().map(|stage| (*stage, Duration::ZERO)));
    }

    /// Starts the next stage now: what passed since the last ended is none's.
    pub fn resume(&mut self) {
        self.since = Instant::now();
    }

    /// Ends that stage and starts the next.
    pub fn end(&mut self, stage: &'static str) {
        let now = Instant::now();
        let took = now.duration_since(std::mem::replace(&mut self.since, now));
        match self.took.iter_mut().find(|(name, _)| *name == stage) {
            Some((_, sum)) => *sum += took,
            None => self.took.push((stage, took)),
        }
    }

    /// The time of that stage in milliseconds; 0 if it never came.
    pub fn ms(&self, stage: &str) -> f64 {
        self.took.iter().find(|(name, _)| *name == stage).map_or(0.0, |(_, took)| ms(*took))
    }

    /// Adds the times to the request's span and to the metrics of that kind of work, with the time that it waited for a computing thread.
    pub fn record(&self, metrics: &Metrics, work: Work, queue: Duration) {
        for (stage, took) in [("queue", queue)].into_iter().chain(self.took.iter().copied()) {
            metrics.stage(work, stage, took);
            note_stage(stage, took);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stage_that_comes_again_is_added_up_and_counted_once() {
        let mut stages = StageClock::begin();
        for stage in ["cut", "recognise", "cut", "recognise"] {
            std::thread::sleep(Duration::from_millis(1));
            stages.end(stage);
        }
        assert!(stages.ms("cut") >= 2.0 && stages.ms("recognise") >= 2.0);
        assert_eq!(stages.ms("depth"), 0.0);
        let metrics = Metrics::new();
        stages.record(&metrics, Work::Workcell, Duration::ZERO);
        let text = metrics.text();
        for (stage, count) in [("queue", 1), ("cut", 1), ("recognise", 1), ("depth", 0)] {
            let line = format!("landmarkd_workcell_stage_seconds_count{{stage=\"{stage}\"}} {count}");
            assert!(text.contains(&line), "{line}");
        }
    }
}
