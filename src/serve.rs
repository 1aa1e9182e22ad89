//! The running service: opens the stores, loads what the aliases name, listens, and shuts down in order.

use std::future::Future;
use std::io;
use std::net::SocketAddr;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use axum_server::Handle;
use hyper_util::rt::TokioTimer;
use jiff::Timestamp;
use tokio::sync::watch;
use tokio::task::{JoinError, JoinHandle, JoinSet};
use uuid::Uuid;

use crate::compute::{Compute, ComputeError};
use crate::config::{Role, Settings, Shared};
use crate::database::Databases;
use crate::http::body::BodyBudget;
use crate::http::{self, Estimators, Service, Tracks};
use crate::imaging::DecodeLimits;
use crate::jobs::{Jobs, Runner};
use crate::store::{
    Blobs, Catalogue, CatalogueError, Folder, OpenBucketError, OpenCatalogueError, OpenFolderError,
    open_bucket, open_folder, open_postgres,
};
use crate::telemetry::{Metrics, chain};

/// How often the catalogue is asked what the aliases name: a change made elsewhere is served this much later.
const REFRESH_EVERY: Duration = Duration::from_secs(2);
/// How often blobs that nothing names are looked for.
const COLLECT_EVERY: Duration = Duration::from_secs(3600);
/// A blob younger than this may belong to an upload whose row is still to come.
const ORPHAN_AGE: Duration = Duration::from_secs(24 * 3600);
/// Longest header of a request.
const MAX_HEADER_BYTES: usize = 16 << 10;
/// How long requests in flight may take to end at shutdown.
const SHUTDOWN_PATIENCE: Duration = Duration::from_secs(20);

/// Why the service doesn't start.
#[derive(Debug, thiserror::Error)]
pub enum ServeError {
    #[error("can't open the data folder")]
    Folder {
        #[from]
        source: OpenFolderError,
    },
    #[error("can't start the computing threads")]
    Compute {
        #[from]
        source: ComputeError,
    },
    #[error("can't open the shared catalogue")]
    SharedCatalogue {
        #[from]
        source: OpenCatalogueError,
    },
    #[error("can't use the shared blobs")]
    SharedBlobs {
        #[from]
        source: OpenBucketError,
    },
    #[error("can't take over the jobs of the run before")]
    Catalogue {
        #[from]
        source: CatalogueError,
    },
    #[error("can't listen on {bind}: is another service there? Give another address with --bind")]
    Bind { bind: SocketAddr, source: io::Error },
    #[error("the server stopped")]
    Server { source: io::Error },
    #[error("a part of the service that works in the background died")]
    Background { source: Option<JoinError> },
}

/// The service's parts, wired; not yet listening.
pub struct Parts {
    pub service: Service,
    /// None in a process that leaves jobs to others.
    runner: Option<Runner>,
    /// Grows when another process may have changed what this one serves or works on.
    hints: watch::Receiver<u64>,
}

/// Open the stores in the data folder and wire the service over them. Its background work and its streams of events
/// end when `shutdown` turns true.
///
/// # Errors
/// A folder in use or unwritable, or no threads.
pub async fn wire(settings: &Settings, shutdown: watch::Receiver<bool>) -> Result<Parts, ServeError> {
    let (catalogue, blobs) = match &settings.shared {
        Some(shared) => open_shared(shared, &settings.data_dir).await?,
        None => {
            let Folder { catalogue, blobs } = open_folder(&settings.data_dir).await?;
            (catalogue, blobs)
        }
    };
    let limits = settings.limits.clone();
    let compute = Compute::new(settings.threads, limits.waiting_per_thread, limits.max_decode_bytes_total)?;
    let worker: Arc<str> = format!("worker-{}", Uuid::now_v7()).into();
    // A folder's lock is ours, so whoever held a job before is dead; of a shared catalogue nothing is released.
    let released = catalogue.release_dead_leases(&worker).await?;
    if released > 0 {
        tracing::info!(released, "jobs that a dead process left are taken up again");
    }
    let decode = DecodeLimits {
        max_side_px: limits.max_side_px,
        max_pixels: limits.max_pixels,
        max_alloc_bytes: limits.max_decode_bytes,
    };
    let bodies = BodyBudget::new(limits.max_body_bytes_total);
    let metrics = Arc::new(Metrics::new());
    let hints = catalogue.hints();
    let (memory_limit, holds) = (settings.memory_limit_bytes, settings.holds.clone());
    let databases = Databases::new(Arc::clone(&catalogue), blobs, compute.clone(), memory_limit, holds);
    let jobs = Jobs::new(catalogue);
    let runner = Runner::new(
        jobs.clone(),
        databases.clone(),
        compute.clone(),
        decode,
        Arc::clone(&metrics),
        worker.to_string(),
    );
    let runner = (settings.role != Role::Serve).then_some(runner);
    let service = Service {
        databases,
        jobs,
        compute,
        metrics,
        tracks: Tracks::new(&limits),
        limits,
        bodies,
        decode,
        estimators: Estimators::default(),
        started_at: Timestamp::now(),
        worker,
        role: settings.role,
        ready: Arc::new(AtomicBool::new(false)),
        shutdown,
    };
    Ok(Parts { service, runner, hints })
}

/// Open what a fleet shares; one that is away is waited for.
async fn open_shared(shared: &Shared, data_dir: &Path) -> Result<(Arc<dyn Catalogue>, Blobs), ServeError> {
    let (catalogue, id) = loop {
        match open_postgres(shared.catalogue.url()).await {
            Ok(opened) => break opened,
            Err(error @ OpenCatalogueError::Unavailable(_)) => {
                tracing::warn!(error = chain(&error), "the shared catalogue is away: waiting for it");
                tokio::time::sleep(REFRESH_EVERY).await;
            }
            Err(error) => return Err(error.into()),
        }
    };
    let copies = data_dir.join("copies");
    let blobs = loop {
        match open_bucket(&shared.blobs, id, &copies, shared.cache_limit_bytes).await {
            Ok(blobs) => break blobs,
            Err(error @ OpenBucketError::Unavailable { .. }) => {
                tracing::warn!(error = chain(&error), "the shared blobs are away: waiting for them");
                tokio::time::sleep(REFRESH_EVERY).await;
            }
            Err(error) => return Err(error.into()),
        }
    };
    Ok((catalogue, blobs))
}

impl Parts {
    /// Start what runs in the background: the refresh of the registry, the runner of jobs, the collector of orphans.
    /// The handle resolves when they have ended after shutdown, or when one of them died.
    pub fn start(self) -> (Service, JoinHandle<Result<(), JoinError>>) {
        let service = self.service.clone();
        let shutdown = service.shutdown.clone();
        let mut tasks = JoinSet::new();
        if let Some(runner) = self.runner {
            tasks.spawn(runner.run(shutdown.clone()));
            tasks.spawn(collect_orphans(self.service.clone(), shutdown.clone()));
        }
        tasks.spawn(tell(self.service.clone(), shutdown.clone()));
        tasks.spawn(wake_jobs(self.service.jobs.clone(), self.hints.clone(), shutdown.clone()));
        tasks.spawn(refresh(self.service, self.hints, shutdown));
        let background = tokio::spawn(async move {
            while let Some(ended) = tasks.join_next().await {
                // The others end with the set.
                ended?;
            }
            Ok(())
        });
        (service, background)
    }
}

/// Remove blobs that nothing names any more, until shutdown.
async fn collect_orphans(service: Service, mut shutdown: watch::Receiver<bool>) {
    loop {
        tokio::select! {
            () = tokio::time::sleep(COLLECT_EVERY) => {}
            _ = shutdown.wait_for(|stop| *stop) => return,
        }
        let collected = tokio::select! {
            collected = service.databases.collect_orphans(ORPHAN_AGE) => collected,
            _ = shutdown.wait_for(|stop| *stop) => return,
        };
        match collected {
            Ok(0) => {}
            Ok(removed) => tracing::info!(removed, "removed blobs that nothing names"),
            Err(error) => tracing::warn!(error = chain(&error), "can't collect orphan blobs"),
        }
    }
}

/// Keep the registry as the catalogue says, until shutdown: at once when there is a hint of a change, and every
/// [`REFRESH_EVERY`] in any case.
async fn refresh(service: Service, mut hints: watch::Receiver<u64>, mut shutdown: watch::Receiver<bool>) {
    loop {
        let refreshed = tokio::select! {
            refreshed = service.databases.registry().refresh() => refreshed,
            _ = shutdown.wait_for(|stop| *stop) => return,
        };
        match refreshed {
            Ok(()) => service.ready.store(!*shutdown.borrow(), Ordering::Relaxed),
            Err(error) => {
                tracing::warn!(error = chain(&error), "can't see what the aliases name; serving on");
            }
        }
        tokio::select! {
            () = tokio::time::sleep(REFRESH_EVERY) => {}
            Ok(()) = hints.changed() => {}
            _ = shutdown.wait_for(|stop| *stop) => return,
        }
    }
}

/// Tell the other processes what this one serves, until shutdown; a catalogue that is away is told later.
async fn tell(service: Service, mut shutdown: watch::Receiver<bool>) {
    loop {
        if let Err(error) = service.databases.tell(&service.process()).await {
            tracing::debug!(error = chain(&error), "can't tell what is served here");
        }
        tokio::select! {
            () = tokio::time::sleep(REFRESH_EVERY) => {}
            _ = shutdown.wait_for(|stop| *stop) => return,
        }
    }
}

/// Pass hints of other processes' changes on to those who wait for jobs, until shutdown.
async fn wake_jobs(jobs: Jobs, mut hints: watch::Receiver<u64>, mut shutdown: watch::Receiver<bool>) {
    loop {
        tokio::select! {
            Ok(()) = hints.changed() => jobs.wake(),
            _ = shutdown.wait_for(|stop| *stop) => return,
        }
    }
}

/// Serve until `stop` resolves, then finish what runs and hand back the jobs. `listening` is told the address.
///
/// # Errors
/// [`ServeError`]: why the service can't start, or stopped.
pub async fn serve(
    settings: &Settings,
    listening: impl FnOnce(SocketAddr),
    stop: impl Future<Output = ()>,
) -> Result<(), ServeError> {
    let (announce, shutdown) = watch::channel(false);
    tokio::pin!(stop);
    let parts = tokio::select! {
        parts = wire(settings, shutdown) => parts?,
        // What a fleet shares may be waited for.
        () = &mut stop => return Ok(()),
    };
    let bind = settings.bind;
    let listener = std::net::TcpListener::bind(bind).map_err(|source| ServeError::Bind { bind, source })?;
    listener.set_nonblocking(true).map_err(|source| ServeError::Bind { bind, source })?;
    let (service, mut background) = parts.start();

    let handle = Handle::new();
    let mut server = axum_server::from_tcp(listener)
        .map_err(|source| ServeError::Bind { bind, source })?
        .handle(handle.clone())
        // HTTP/2 without TLS is nobody's habit, and telling the two apart would wait for a first byte for ever.
        .http1_only();
    server
        .http_builder()
        .http1()
        .timer(TokioTimer::new())
        .header_read_timeout(service.limits.header_timeout)
        .max_buf_size(MAX_HEADER_BYTES);
    let ready = Arc::clone(&service.ready);
    let served = server.serve(http::router(service).into_make_service());
    let stopping = async {
        if let Some(address) = handle.listening().await {
            listening(address);
        }
        stop.await;
        tracing::info!("shutting down");
        ready.store(false, Ordering::Relaxed);
        // Watched by the runner and by streams of events.
        announce.send_replace(true);
        handle.graceful_shutdown(Some(SHUTDOWN_PATIENCE));
    };
    tokio::pin!(served);
    let served = tokio::select! {
        // Neither ends by itself but by failing.
        served = &mut served => served,
        died = &mut background => return Err(ServeError::Background { source: died.and_then(|died| died).err() }),
        () = stopping => served.await,
    };
    if let Err(source) = background.await.and_then(|died| died) {
        return Err(ServeError::Background { source: Some(source) });
    }
    served.map_err(|source| ServeError::Server { source })
}
