//! Log lines and the metrics registry.
//!
//! Logs go to standard error, one event a line, as text or JSON, each inside its request's span (method, path,
//! request id, trace id). Metrics follow Prometheus: names end in their unit, counters in `_total`.

pub mod otlp;

use std::io::IsTerminal;
use std::time::Duration;

use prometheus::core::Collector;
use prometheus::{
    Histogram, HistogramOpts, HistogramVec, IntCounterVec, IntGauge, IntGaugeVec, Opts, Registry, TextEncoder,
};
use tracing::Level;
use tracing_subscriber::filter::Targets;
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;

use crate::config::LogFormat;

use self::otlp::Otlp;

/// Starts logging for the whole process, and traces where they are exported. `quiet` leaves only warnings: for verbs that print
/// for people.
pub fn start_logging(format: LogFormat, quiet: bool, otlp: Option<&Otlp>) {
    let quieter = [("sqlx", Level::WARN), ("hyper", Level::WARN)];
    let filter =
        Targets::new().with_default(if quiet { Level::WARN } else { Level::INFO }).with_targets(quieter);
    let registry = tracing_subscriber::registry().with(filter).with(otlp.map(Otlp::layer));
    // A second start in one process (tests) keeps the first; try_init's error is no more than that.
    let _ = match format {
        LogFormat::Text => {
            let colours = std::io::stderr().is_terminal();
            let layer = tracing_subscriber::fmt::layer().with_ansi(colours).with_writer(std::io::stderr);
            registry.with(layer).try_init()
        }
        LogFormat::Json => registry
            .with(tracing_subscriber::fmt::layer().json().flatten_event(true).with_writer(std::io::stderr))
            .try_init(),
    };
}

/// The text of an error with those of its causes, in one line.
pub fn chain(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        text = format!("{text}: {error}");
        cause = error.source();
    }
    text
}

/// What the service counts and times.
pub struct Metrics {
    registry: Registry,
    requests: IntCounterVec,
    request_seconds: HistogramVec,
    /// In the order of [`Work::ALL`].
    stage_seconds: [HistogramVec; 3],
    /// Pieces of work that run, by lane.
    pub pool_running: IntGaugeVec,
    /// Pieces of work that wait, by lane.
    pub pool_waiting: IntGaugeVec,
    /// Loaded versions.
    pub versions_loaded: IntGauge,
    /// Bytes that they hold.
    pub versions_loaded_bytes: IntGauge,
    /// Of exemplars of versions whose windows are not held.
    pub exemplar_cache_bytes: IntGauge,
    /// By where they were: `cache` or `store`.
    pub exemplars_read: IntGaugeVec,
    /// Live tracks.
    pub tracks: IntGauge,
    /// Bytes that they hold.
    pub tracks_bytes: IntGauge,
    /// Jobs by state, as the catalogue has them.
    pub jobs: IntGaugeVec,
    training_seconds: Histogram,
}

/// Work on pictures whose stages are timed, each kind by a histogram of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Work {
    /// `landmarkd_recognition_stage_seconds{stage}`
    Recognition,
    /// `landmarkd_depth_stage_seconds{stage}`
    Depth,
    /// `landmarkd_workcell_stage_seconds{stage}`: segmentations, inspections and centrings.
    Workcell,
}

impl Work {
    /// Every kind.
    pub const ALL: [Self; 3] = [Self::Recognition, Self::Depth, Self::Workcell];

    /// Its stages, as the histogram names them.
    pub const fn stages(self) -> &'static [&'static str] {
        match self {
            Self::Recognition => &[
                "queue",
                "decode",
                "attention",
                "signature",
                "fetch",
                "search",
                "vote",
                "locate",
                "appearance",
                "universal",
                "object",
            ],
            Self::Depth => &["queue", "design", "decode", "register", "match", "estimate", "judge", "encode"],
            Self::Workcell => {
                &["queue", "decode", "segment", "cut", "recognise", "design", "depth", "encode"]
            }
        }
    }

    fn histogram(self) -> prometheus::Result<HistogramVec> {
        let (name, help) = match self {
            Self::Recognition => {
                ("landmarkd_recognition_stage_seconds", "Time of each stage of a recognition")
            }
            Self::Depth => ("landmarkd_depth_stage_seconds", "Time of each stage of a depth map"),
            Self::Workcell => (
                "landmarkd_workcell_stage_seconds",
                "Time of each stage of a segmentation, inspection or centring",
            ),
        };
        let buckets =
            vec![0.0001, 0.00025, 0.0005, 0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 1.0, 5.0];
        HistogramVec::new(HistogramOpts::new(name, help).buckets(buckets), &["stage"])
    }
}

impl Default for Metrics {
    fn default() -> Self {
        Self::new()
    }
}

impl Metrics {
    /// A registry with every metric of the service at zero.
    pub fn new() -> Self {
        let registry = Registry::new();
        let gauge = |name: &str, help: &str| register(&registry, IntGauge::new(name, help));
        let gauges = |name: &str, help: &str, label: &str| {
            register(&registry, IntGaugeVec::new(Opts::new(name, help), &[label]))
        };
        let opts = |name: &str, help: &str, buckets: &[f64]| {
            HistogramOpts::new(name, help).buckets(buckets.to_vec())
        };
        let requests = Opts::new("landmarkd_requests_total", "Requests answered, by route and status");
        let requests = IntCounterVec::new(requests, &["method", "route", "status"]);
        let request_buckets = [0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 10.0];
        let request_seconds = opts("landmarkd_request_seconds", "Time to answer, by route", &request_buckets);
        let training_buckets = [0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0];
        let training_help = "Time of one training, start to version";
        let training_seconds = opts("landmarkd_training_seconds", training_help, &training_buckets);
        let metrics = Self {
            requests: register(&registry, requests),
            request_seconds: register(&registry, HistogramVec::new(request_seconds, &["method", "route"])),
            stage_seconds: Work::ALL.map(|work| register(&registry, work.histogram())),
            pool_running: gauges("landmarkd_pool_running", "Pieces of work on a computing thread", "lane"),
            pool_waiting: gauges(
                "landmarkd_pool_waiting",
                "Pieces of work waiting for a computing thread",
                "lane",
            ),
            versions_loaded: gauge("landmarkd_versions_loaded", "Database versions held in memory"),
            versions_loaded_bytes: gauge("landmarkd_versions_loaded_bytes", "Memory of the loaded versions"),
            exemplar_cache_bytes: gauge(
                "landmarkd_exemplar_cache_bytes",
                "Memory of exemplars of versions whose windows are not held",
            ),
            exemplars_read: gauges(
                "landmarkd_exemplars_read",
                "Exemplars that frames needed of such versions since the start, by where they were",
                "from",
            ),
            tracks: gauge("landmarkd_tracks", "Live tracks"),
            tracks_bytes: gauge("landmarkd_tracks_bytes", "Memory of the live tracks"),
            jobs: gauges("landmarkd_jobs", "Jobs in the catalogue, by state", "state"),
            training_seconds: register(&registry, Histogram::with_opts(training_seconds)),
            registry,
        };
        for work in Work::ALL {
            for stage in work.stages() {
                metrics.stage_seconds[work as usize].with_label_values(&[stage]);
            }
        }
        #[cfg(target_os = "linux")]
        metrics
            .registry
            .register(Box::new(prometheus::process_collector::ProcessCollector::for_self()))
            .expect("process metrics have names of their own");
        metrics
    }

    /// Counts one answered request. `route` is the route's pattern, never the path, so labels stay few.
    pub fn request(&self, method: &str, route: &str, status: u16, took: Duration) {
        self.requests.with_label_values(&[method, route, &status.to_string()]).inc();
        self.request_seconds.with_label_values(&[method, route]).observe(took.as_secs_f64());
    }

    /// Times one stage of one piece of work; `stage` is one of [`Work::stages`].
    pub fn stage(&self, work: Work, stage: &str, took: Duration) {
        self.stage_seconds[work as usize].with_label_values(&[stage]).observe(took.as_secs_f64());
    }

    /// Times one finished training.
    pub fn training(&self, took: Duration) {
        self.training_seconds.observe(took.as_secs_f64());
    }

    /// Exports what is counted and timed, too.
    ///
    /// # Errors
    /// The collector's address can't be used.
    pub fn export(&self, otlp: &mut Otlp) -> Result<(), otlp::OtlpError> {
        otlp.export_metrics(&self.registry)
    }

    /// Everything in Prometheus' text format.
    pub fn text(&self) -> String {
        TextEncoder::new().encode_to_string(&self.registry.gather()).unwrap_or_default()
    }
}

/// Register a metric made from constants; a mistake in them shows in every test.
fn register<C: Collector + Clone + 'static>(registry: &Registry, metric: prometheus::Result<C>) -> C {
    let metric = metric.expect("metric options are constants");
    registry.register(Box::new(metric.clone())).expect("metric names are distinct");
    metric
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_text_names_route_status_and_every_stage() {
        let metrics = Metrics::new();
        metrics.request("GET", "/v1/databases/{database}", 404, Duration::from_millis(3));
        let text = metrics.text();
        assert!(text.contains(r#"route="/v1/databases/{database}",status="404"} 1"#), "{text}");
        for (work, name) in Work::ALL.into_iter().zip(["recognition", "depth", "workcell"]) {
            for stage in work.stages() {
                let line = format!("landmarkd_{name}_stage_seconds_count{{stage=\"{stage}\"}} 0");
                assert!(text.contains(&line), "{line} is missing");
            }
        }
    }
}
