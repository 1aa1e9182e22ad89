//! HTTP: the router is a table of contents; one file per resource. A handler extracts, picks a version, makes one call and
//! renders.
//!
//! Architecture invariant: no arithmetic on pixels or vectors here, no SQL, no files. Wire shapes live beside their
//! handlers; renaming a field of the domain doesn't change them.

pub mod accept;
mod access;
mod aliases;
mod audit;
pub mod body;
mod calibrations;
mod cameras;
mod centrings;
mod console;
mod databases;
mod depth_maps;
mod eigenimages;
mod estimators;
pub(crate) mod events;
mod exemplar_batches;
mod exemplars;
mod extract;
mod inference_protocol;
mod info;
mod inspections;
mod jobs;
mod keys;
mod middleware;
pub mod openapi;
pub(crate) mod optics;
pub(crate) mod options;
mod pages;
mod pairs;
mod paths;
mod pose_table;
mod preconditions;
mod predictions;
pub mod problem;
mod recognitions;
mod regions;
mod segmentations;
mod stages;
mod surveys;
mod sweeps;
mod tracks;
mod trainings;
mod uploads;
mod versions;
mod workcells;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use axum::Router;
use axum::extract::DefaultBodyLimit;
use axum::http::header::{CACHE_CONTROL, X_CONTENT_TYPE_OPTIONS};
use axum::http::{HeaderValue, StatusCode};
use axum::middleware::from_fn_with_state;
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
use crate::events::Events;
use crate::jobs::Jobs;
use crate::telemetry::Metrics;
use landmarkd_core::imaging::DecodeLimits;

/// The state that the handlers share; cheap to clone.
#[derive(Clone)]
pub struct Service {
    /// The keys in force.
    pub keyring: Keyring,
    /// Whether the operator lets everybody in while there is no key.
    pub insecure: bool,
    /// Databases, their versions, calibrations and workcells.
    pub databases: Databases,
    /// The queue of jobs.
    pub jobs: Jobs,
    /// The computing threads.
    pub compute: Compute,
    /// What is counted and timed.
    pub metrics: Arc<Metrics>,
    /// What is refused.
    pub limits: Limits,
    /// Memory for bodies.
    pub bodies: BodyBudget,
    /// Limits of the pictures that are decoded.
    pub decode: DecodeLimits,
    /// Depth estimators used lately.
    pub estimators: Estimators,
    /// Robots on their way.
    pub tracks: Tracks,
    /// What happens here.
    pub events: Events,
    /// When the process started.
    pub started_at: Timestamp,
    /// The name under which this process claims jobs.
    pub worker: Arc<str>,
    /// Its part of a fleet's work.
    pub role: Role,
    /// True from the first complete load of the registry until shutdown.
    pub ready: Arc<AtomicBool>,
    /// Turns true when the service shuts down: endless responses end.
    pub shutdown: watch::Receiver<bool>,
}

impl Service {
    /// This process, with what it serves.
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
        .routes(routes!(events::get))
        .routes(routes!(inference_protocol::live))
        .routes(routes!(inference_protocol::ready))
        .routes(routes!(inference_protocol::metadata))
        .routes(routes!(inference_protocol::model_metadata))
        .routes(routes!(inference_protocol::version_metadata))
        .routes(routes!(inference_protocol::model_ready))
        .routes(routes!(databases::list))
        .routes(routes!(databases::put, databases::get, databases::delete))
        .routes(routes!(exemplars::post, exemplars::list, exemplars::delete_matching))
        .routes(routes!(exemplar_batches::post))
        .routes(routes!(exemplars::get, exemplars::patch, exemplars::delete))
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
        .routes(routes!(cameras::list))
        .routes(routes!(cameras::put, cameras::get, cameras::delete))
        .routes(routes!(calibrations::list))
        .routes(routes!(calibrations::put, calibrations::get, calibrations::delete))
        .routes(routes!(calibrations::register))
        .routes(routes!(sweeps::post))
        .routes(routes!(depth_maps::post))
        .routes(routes!(predictions::post))
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

/// 201 for what was created, 200 for what was there.
fn put_status(created: bool) -> StatusCode {
    if created { StatusCode::CREATED } else { StatusCode::OK }
}

/// The whole service as a router.
pub fn router(service: Service) -> Router {
    let (api, document) = routes().split_for_parts();
    let document = openapi::finished(document);
    let requirements = Arc::new(access::Requirements::of(&document));
    let no_sniffing = HeaderValue::from_static("nosniff");
    let no_store = HeaderValue::from_static("no-store");
    Router::new()
        .merge(api)
        .merge(console::routes())
        .merge(SwaggerUi::new("/docs").url("/openapi.json", document))
        .fallback(middleware::unknown_route)
        .method_not_allowed_fallback(middleware::method_not_allowed)
        // Bodies have limits of their own, see `body`.
        .layer(DefaultBodyLimit::disable())
        .layer(from_fn_with_state((service.clone(), requirements), access::authorise))
        .layer(from_fn_with_state(service.clone(), middleware::request))
        // Outside the request middleware, so that its own responses have them too.
        .layer(SetResponseHeaderLayer::if_not_present(X_CONTENT_TYPE_OPTIONS, no_sniffing))
        .layer(SetResponseHeaderLayer::if_not_present(CACHE_CONTROL, no_store))
        .with_state(service)
}
