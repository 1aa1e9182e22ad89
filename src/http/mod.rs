//! HTTP: the router is a table of contents; one file per resource. A handler extracts, picks, makes one call, renders.
//!
//! Architecture invariant: no arithmetic on pixels or vectors here, no SQL, no files. Wire shapes live beside their
//! handlers; renaming a field inside the house doesn't change them.

pub mod accept;
mod access;
mod aliases;
mod audit;
pub mod body;
mod calibrations;
mod centrings;
mod console;
mod databases;
mod depth_maps;
mod eigenimages;
mod estimators;
mod exemplar_batches;
mod exemplars;
mod extract;
mod info;
mod inspections;
mod jobs;
mod keys;
pub mod openapi;
mod optics;
mod options;
mod pages;
mod preconditions;
pub mod problem;
mod recognitions;
mod regions;
mod reports;
mod rim;
mod segmentations;
mod stages;
mod sweeps;
mod tracks;
mod trainings;
mod uploads;
mod versions;
mod workcells;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use axum::extract::DefaultBodyLimit;
use axum::http::HeaderValue;
use axum::http::header::{CACHE_CONTROL, X_CONTENT_TYPE_OPTIONS};
use axum::{Router, middleware};
use jiff::Timestamp;
use tokio::sync::watch;
use tower_http::set_header::SetResponseHeaderLayer;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use utoipa_swagger_ui::SwaggerUi;

use self::body::BodyBudget;
pub use self::estimators::Estimators;
pub use self::tracks::Tracks;
use crate::access::Keyring;
use crate::compute::Compute;
use crate::config::{Limits, Role};
use crate::database::{Databases, Process};
use crate::jobs::Jobs;
use crate::telemetry::Metrics;
use landmarkd_core::imaging::DecodeLimits;

/// What the handlers share; cheap to clone.
#[derive(Clone)]
pub struct Service {
    pub keyring: Keyring,
    /// Whether the operator lets everybody in where no key is asked for.
    pub insecure: bool,
    pub databases: Databases,
    pub jobs: Jobs,
    pub compute: Compute,
    pub metrics: Arc<Metrics>,
    pub limits: Limits,
    pub bodies: BodyBudget,
    pub decode: DecodeLimits,
    /// Depth estimators used lately.
    pub estimators: Estimators,
    /// Robots on their way.
    pub tracks: Tracks,
    pub started_at: Timestamp,
    /// The name under which this process claims jobs.
    pub worker: Arc<str>,
    /// Its part of a fleet's work.
    pub role: Role,
    /// True from the first complete load of the registry until shutdown.
    pub ready: Arc<AtomicBool>,
    /// Turns true when the service shuts down: endless answers end.
    pub shutdown: watch::Receiver<bool>,
}

impl Service {
    /// This process, and what it serves.
    pub fn process(&self) -> Process {
        Process {
            worker: self.worker.to_string(),
            role: self.role.as_str().to_owned(),
            databases: self.databases.registry().states(),
            started_at: self.started_at,
        }
    }
}

fn routes() -> OpenApiRouter<Service> {
    OpenApiRouter::with_openapi(openapi::preamble())
        .routes(routes!(info::livez))
        .routes(routes!(info::readyz))
        .routes(routes!(info::metrics))
        .routes(routes!(info::info))
        .routes(routes!(databases::list))
        .routes(routes!(databases::put, databases::get, databases::delete))
        .routes(routes!(exemplars::post, exemplars::list, exemplars::delete_matching))
        .routes(routes!(exemplar_batches::post))
        .routes(routes!(exemplars::get, exemplars::delete))
        .routes(routes!(exemplars::image))
        .routes(routes!(trainings::post))
        .routes(routes!(versions::list, versions::import))
        .routes(routes!(versions::get, versions::delete))
        .routes(routes!(versions::artifact))
        .routes(routes!(eigenimages::get))
        .routes(routes!(aliases::list))
        .routes(routes!(aliases::put, aliases::get, aliases::delete))
        .routes(routes!(recognitions::post))
        .routes(routes!(recognitions::post_batch))
        .routes(routes!(tracks::post, tracks::list))
        .routes(routes!(tracks::get, tracks::delete))
        .routes(routes!(tracks::post_frame))
        .routes(routes!(calibrations::list))
        .routes(routes!(calibrations::put, calibrations::get, calibrations::delete))
        .routes(routes!(calibrations::register))
        .routes(routes!(sweeps::post))
        .routes(routes!(depth_maps::post))
        .routes(routes!(segmentations::post))
        .routes(routes!(workcells::list))
        .routes(routes!(workcells::put, workcells::get, workcells::delete))
        .routes(routes!(inspections::post))
        .routes(routes!(centrings::post))
        .routes(routes!(jobs::list))
        .routes(routes!(jobs::get, jobs::cancel))
        .routes(routes!(jobs::events))
        .routes(routes!(keys::post, keys::list))
        .routes(routes!(keys::get, keys::delete))
        .routes(routes!(audit::list))
}

/// The whole service as a router.
pub fn router(service: Service) -> Router {
    let (api, document) = routes().split_for_parts();
    let document = openapi::finished(document);
    let needs = Arc::new(access::Needs::of(&document));
    let no_sniffing = HeaderValue::from_static("nosniff");
    let no_store = HeaderValue::from_static("no-store");
    Router::new()
        .merge(api)
        .merge(console::routes())
        .merge(SwaggerUi::new("/docs").url("/openapi.json", document))
        .fallback(rim::unknown_route)
        .method_not_allowed_fallback(rim::method_not_allowed)
        // Bodies have limits of their own, see `body`.
        .layer(DefaultBodyLimit::disable())
        .layer(middleware::from_fn_with_state((service.clone(), needs), access::ask))
        .layer(middleware::from_fn_with_state(service.clone(), rim::rim))
        // Outside the rim, so that answers of its own have them too.
        .layer(SetResponseHeaderLayer::if_not_present(X_CONTENT_TYPE_OPTIONS, no_sniffing))
        .layer(SetResponseHeaderLayer::if_not_present(CACHE_CONTROL, no_store))
        .with_state(service)
}
