//! Traces and metrics to a collector, by the OpenTelemetry protocol over HTTP. A request is a span, with the times of its stages
//! as attributes; the metrics are those of `/metrics`, of histograms count and sum.

use std::collections::HashSet;
use std::time::Duration;

use async_trait::async_trait;
use axum::http::HeaderMap;
use bytes::Bytes;
use opentelemetry::metrics::MeterProvider;
use opentelemetry::propagation::{Extractor, TextMapPropagator};
use opentelemetry::trace::TracerProvider;
use opentelemetry::{Context, KeyValue};
use opentelemetry_http::{HttpClient, HttpError, Request, Response};
use opentelemetry_otlp::{MetricExporter, Protocol, SpanExporter, WithExportConfig, WithHttpConfig};
use opentelemetry_sdk::Resource;
use opentelemetry_sdk::metrics::{PeriodicReader, SdkMeterProvider};
use opentelemetry_sdk::propagation::TraceContextPropagator;
use opentelemetry_sdk::trace::SdkTracerProvider;
use prometheus::proto::{Metric, MetricFamily, MetricType};
use tokio_util::task::AbortOnDropHandle;
use tracing::Span;
use tracing_opentelemetry::{OpenTelemetryLayer, OpenTelemetrySpanExt};
use tracing_subscriber::registry::LookupSpan;

/// Longest time that the collector may take over one export.
const TIMEOUT: Duration = Duration::from_secs(10);
/// Time between two looks for metrics that are new.
const OBSERVE_EVERY: Duration = Duration::from_secs(10);
/// The service, to whoever collects.
const NAME: &str = env!("CARGO_PKG_NAME");

/// Why nothing can be exported.
#[derive(Debug, thiserror::Error)]
pub enum OtlpError {
    /// The exporter can't be built.
    #[error("can't export to {endpoint}")]
    Exporter {
        /// The collector's address.
        endpoint: String,
        /// Why not.
        #[source]
        source: opentelemetry_otlp::ExporterBuildError,
    },
    /// The HTTP client can't be built.
    #[error("can't make a client of the collector")]
    Client {
        /// Why not.
        #[source]
        source: reqwest::Error,
    },
}

/// The exporters' threads have no async runtime: they send on the service's.
#[derive(Debug)]
struct Client {
    runtime: tokio::runtime::Handle,
    client: reqwest::Client,
}

#[async_trait]
impl HttpClient for Client {
    async fn send_bytes(&self, request: Request<Bytes>) -> Result<Response<Bytes>, HttpError> {
        let client = self.client.clone();
        let sending = self.runtime.spawn(async move {
            let answer = client.execute(request.try_into()?).await?;
            let status = answer.status();
            Ok::<_, reqwest::Error>((status, answer.bytes().await?))
        });
        let (status, body) = sending.await??;
        Ok(Response::builder().status(status).body(body)?)
    }
}

/// The exports of this process; what is pending is sent when it is dropped.
pub struct Otlp {
    endpoint: String,
    traces: SdkTracerProvider,
    metrics: Option<(SdkMeterProvider, AbortOnDropHandle<()>)>,
}

impl Otlp {
    /// Traces to the collector at `endpoint`, `http://host:4318`. Must be called on the service's runtime.
    ///
    /// # Errors
    /// The address can't be used.
    pub fn start(endpoint: &str) -> Result<Self, OtlpError> {
        let endpoint = endpoint.trim_end_matches('/').to_owned();
        let exporter = SpanExporter::builder()
            .with_http()
            .with_http_client(client()?)
            .with_protocol(Protocol::HttpBinary)
            .with_endpoint(format!("{endpoint}/v1/traces"))
            .build()
            .map_err(|source| OtlpError::Exporter { endpoint: endpoint.clone(), source })?;
        let traces =
            SdkTracerProvider::builder().with_resource(resource()).with_batch_exporter(exporter).build();
        Ok(Self { endpoint, traces, metrics: None })
    }

    /// The layer that makes traces of spans.
    pub fn layer<S>(&self) -> OpenTelemetryLayer<S, opentelemetry_sdk::trace::Tracer>
    where
        S: tracing::Subscriber + for<'span> LookupSpan<'span>,
    {
        tracing_opentelemetry::layer().with_tracer(self.traces.tracer(NAME))
    }

    /// Exports the metrics of `registry` too, once a minute.
    ///
    /// # Errors
    /// The address can't be used.
    pub fn export_metrics(&mut self, registry: &prometheus::Registry) -> Result<(), OtlpError> {
        let exporter = MetricExporter::builder()
            .with_http()
            .with_http_client(client()?)
            .with_protocol(Protocol::HttpBinary)
            .with_endpoint(format!("{}/v1/metrics", self.endpoint))
            .build()
            .map_err(|source| OtlpError::Exporter { endpoint: self.endpoint.clone(), source })?;
        let reader = PeriodicReader::builder(exporter).build();
        let provider = SdkMeterProvider::builder().with_resource(resource()).with_reader(reader).build();
        let observing = tokio::spawn(observe_all(provider.clone(), registry.clone()));
        self.metrics = Some((provider, AbortOnDropHandle::new(observing)));
        Ok(())
    }
}

impl Drop for Otlp {
    fn drop(&mut self) {
        // A collector that is away is no reason to fail.
        let _ = self.traces.shutdown();
        if let Some((metrics, _)) = &self.metrics {
            let _ = metrics.shutdown();
        }
    }
}

fn resource() -> Resource {
    Resource::builder()
        .with_service_name(NAME)
        .with_attribute(KeyValue::new("service.version", env!("CARGO_PKG_VERSION")))
        .build()
}

fn client() -> Result<Client, OtlpError> {
    let client = reqwest::Client::builder().timeout(TIMEOUT).build();
    let client = client.map_err(|source| OtlpError::Client { source })?;
    Ok(Client { runtime: tokio::runtime::Handle::current(), client })
}

/// Observes metrics as they appear: a registry has none of those with labels before they were counted once.
async fn observe_all(provider: SdkMeterProvider, registry: prometheus::Registry) {
    let mut named = HashSet::new();
    loop {
        observe(&provider, &registry, &mut named);
        tokio::time::sleep(OBSERVE_EVERY).await;
    }
}

/// An instrument for each metric of the registry that has none, read from it whenever it is exported.
fn observe(provider: &SdkMeterProvider, registry: &prometheus::Registry, named: &mut HashSet<String>) {
    let meter = provider.meter(NAME);
    for family in registry.gather() {
        let (name, help) = (family.name().to_owned(), family.help().to_owned());
        if !named.insert(name.clone()) {
            continue;
        }
        let reading = |part: fn(&Metric) -> f64| {
            let (registry, name) = (registry.clone(), name.clone());
            move |observer: &dyn opentelemetry::metrics::AsyncInstrument<f64>| {
                let gathered = registry.gather();
                let found = gathered.iter().find(|family| family.name() == name);
                for metric in found.into_iter().flat_map(MetricFamily::get_metric) {
                    let labels = metric.get_label().iter();
                    let labels: Vec<KeyValue> = labels
                        .map(|label| KeyValue::new(label.name().to_owned(), label.value().to_owned()))
                        .collect();
                    observer.observe(part(metric), &labels);
                }
            }
        };
        match family.get_field_type() {
            MetricType::COUNTER => {
                let value = reading(|metric| metric.get_counter().get_value());
                meter.f64_observable_counter(name).with_description(help).with_callback(value).build();
            }
            MetricType::GAUGE => {
                let value = reading(|metric| metric.get_gauge().get_value());
                meter.f64_observable_gauge(name).with_description(help).with_callback(value).build();
            }
            MetricType::HISTOGRAM => {
                let count = reading(|metric| metric.get_histogram().get_sample_count() as f64);
                let sum = reading(|metric| metric.get_histogram().get_sample_sum());
                let described = |part: &str| meter.f64_observable_counter(format!("{name}_{part}"));
                described("count").with_description(help.clone()).with_callback(count).build();
                described("sum").with_description(help).with_callback(sum).build();
            }
            MetricType::SUMMARY | MetricType::UNTYPED => {}
        }
    }
}

struct Headers<'a>(&'a HeaderMap);

impl Extractor for Headers<'_> {
    fn get(&self, name: &str) -> Option<&str> {
        self.0.get(name)?.to_str().ok()
    }

    fn keys(&self) -> Vec<&str> {
        self.0.keys().map(axum::http::HeaderName::as_str).collect()
    }
}

/// Makes the span part of the trace that the caller's `traceparent` names. Nothing happens where no traces are exported.
pub fn continue_trace(span: &Span, headers: &HeaderMap) {
    let parent = TraceContextPropagator::new().extract_with_context(&Context::new(), &Headers(headers));
    // An error says that the span is not exported.
    let _ = span.set_parent(parent);
}

/// Adds the time of a stage to the request's span.
pub fn note_stage(stage: &'static str, took: Duration) {
    let name = format!("landmarkd.stage.{stage}_ms");
    Span::current().set_attribute(name, took.as_secs_f64() * 1e3);
}

/// Adds what was asked and answered to a request's span.
pub fn note_answer(span: &Span, method: &str, route: &str, status: u16) {
    span.set_attribute("otel.kind", "server");
    span.set_attribute("http.request.method", method.to_owned());
    span.set_attribute("http.route", route.to_owned());
    span.set_attribute("http.response.status_code", i64::from(status));
}
