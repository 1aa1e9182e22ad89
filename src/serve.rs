//! The running service: opens the stores, loads what the aliases name, listens, and shuts down in order.

use std::future::Future;
use std::io;
use std::net::SocketAddr;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use jiff::Timestamp;
use tokio::net::{TcpListener, TcpSocket};
use tokio::sync::watch;
use tokio::task::{JoinError, JoinHandle, JoinSet};
use tokio_util::task::AbortOnDropHandle;
use uuid::Uuid;

use crate::access::Keyring;
use crate::compute::{Compute, ComputeError};
use crate::config::{Limits, Role, Settings, Shared};
use crate::connections;
use crate::database::{Databases, ExemplarCache, Residency};
use crate::events::Events;
use crate::http::body::BodyBudget;
use crate::http::{self, Estimators, Service, Tracks};
use crate::jobs::{Jobs, Runner};
use crate::store::{
    Blobs, Catalogue, CatalogueError, Descriptions, Folder, OpenBucketError, OpenCatalogueError,
    OpenFolderError, OrphanCollection, open_bucket, open_folder, open_postgres,
};
use crate::telemetry::{Metrics, chain};
use crate::tls::{self, TlsError};
use landmarkd_core::imaging::DecodeLimits;

/// Connections that may wait to be accepted: as many as there may be in all.
const BACKLOG: u32 = 1024;
/// Longest time until a change that another process made is served here.
const REFRESH_EVERY: Duration = Duration::from_secs(2);
/// How old the time of a key's last use in the catalogue may be.
const NOTE_USES_EVERY: Duration = Duration::from_secs(30);
/// Time between two collections of blobs that nothing names, and of descriptions of pictures that are gone.
const COLLECT_EVERY: Duration = Duration::from_secs(3600);
/// A blob younger than this may belong to an upload whose row is still to come.
const ORPHAN_AGE: Duration = Duration::from_secs(24 * 3600);
/// Files and sockets that the process needs besides its connections: the catalogue, blobs, pictures being read.
#[cfg(target_os = "linux")]
const OTHER_DESCRIPTORS: u64 = 512;

/// Why the service doesn't start.
#[derive(Debug, thiserror::Error)]
pub enum ServeError {
    /// The data folder can't be opened.
    #[error("can't open the data folder")]
    Folder {
        /// Why.
        #[from]
        source: OpenFolderError,
    },
    /// The computing threads can't be started.
    #[error("can't start the computing threads")]
    Compute {
        /// Why.
        #[from]
        source: ComputeError,
    },
    /// The shared catalogue can't be opened.
    #[error("can't open the shared catalogue")]
    SharedCatalogue {
        /// Why.
        #[from]
        source: OpenCatalogueError,
    },
    /// The shared blobs can't be used.
    #[error("can't use the shared blobs")]
    SharedBlobs {
        /// Why.
        #[from]
        source: OpenBucketError,
    },
    /// The catalogue can't be read.
    #[error("the catalogue can't be read")]
    Catalogue {
        /// Why.
        #[from]
        source: CatalogueError,
    },
    /// The service would let everybody in from other machines.
    #[error(
        "--bind {bind} is reachable from other machines, and there is no key to ask for: make one with \
         landmarkd keys create --name NAME --scope admin (and the --data-dir or --catalogue of this service), or bind \
         a loopback address such as 127.0.0.1:8080, or add --insecure to let everybody in"
    )]
    OpenToAll {
        /// The address to listen on.
        bind: SocketAddr,
    },
    /// The address is taken, or isn't one of this machine.
    #[error("can't listen on {bind}: is another service there? Give another address with --bind")]
    Bind {
        /// The address to listen on.
        bind: SocketAddr,
        /// What the operating system says.
        source: io::Error,
    },
    /// The certificate can't be used.
    #[error("can't serve over TLS")]
    Tls {
        /// Why.
        #[from]
        source: TlsError,
    },
    /// A background task panicked.
    #[error("a part of the service that works in the background died")]
    Background {
        /// Its panic.
        source: Option<JoinError>,
    },
}

/// The service's parts, wired; not yet listening.
pub struct Parts {
    /// What the handlers share.
    pub service: Service,
    /// None in a process that leaves jobs to others.
    runner: Option<Runner>,
    /// Grows with each notification that another process may have changed what this one serves or works on.
    changes: watch::Receiver<u64>,
}

/// Opens the stores and wires the service over them. Its background work and its streams of events end when `shutdown`
/// turns true.
///
/// # Errors
/// A folder in use or unwritable, shared stores that can't be used, or no threads.
pub async fn wire(settings: &Settings, shutdown: watch::Receiver<bool>) -> Result<Parts, ServeError> {
    let (catalogue, blobs) = open_stores(settings).await?;
    let max_connections = affordable_connections(settings.limits.max_connections);
    let limits = Limits { max_connections, ..settings.limits.clone() };
    let compute = Compute::new(settings.threads, limits.waiting_per_thread, limits.max_decode_bytes_total)?;
    let worker: Arc<str> = format!("worker-{}", Uuid::now_v7()).into();
    // A folder's lock is ours, so whoever held a job before is dead; of a shared catalogue nothing is released.
    let released = catalogue.release_dead_leases(&worker).await?;
    if released > 0 {
        tracing::info!(released, "jobs of a dead process are back in the queue");
    }
    let changes = catalogue.change_notifications();
    let keyring = Keyring::open(Arc::clone(&catalogue), settings.is_open_without_keys()).await?;
    let (memory_limit, holds) = (settings.memory_limit_bytes, settings.holds.clone());
    let residency = Residency {
        largest_bytes: settings.resident_limit_bytes,
        cache: Arc::new(ExemplarCache::new(settings.exemplar_cache_bytes)),
    };
    let kept = settings.data_dir.join("descriptions");
    let descriptions = Descriptions::open(&kept, settings.description_limit_bytes).await;
    let rows = Arc::clone(&catalogue);
    let service = Service {
        keyring,
        insecure: settings.insecure,
        databases: Databases::new(rows, blobs, descriptions, compute.clone(), memory_limit, holds, residency),
        jobs: Jobs::new(catalogue),
        compute,
        metrics: Arc::new(Metrics::new()),
        bodies: BodyBudget::new(limits.max_body_bytes_total),
        decode: DecodeLimits {
            max_side_px: limits.max_side_px,
            max_pixels: limits.max_pixels,
            max_alloc_bytes: limits.max_decode_bytes,
        },
        estimators: Estimators::default(),
        tracks: Tracks::new(&limits),
        events: Events::default(),
        limits,
        started_at: Timestamp::now(),
        worker,
        role: settings.role,
        ready: Arc::new(AtomicBool::new(false)),
        shutdown,
    };
    let runner = (settings.role != Role::Serve).then(|| runner(&service));
    Ok(Parts { service, runner, changes })
}

fn runner(service: &Service) -> Runner {
    Runner {
        jobs: service.jobs.clone(),
        databases: service.databases.clone(),
        compute: service.compute.clone(),
        decode: service.decode,
        metrics: Arc::clone(&service.metrics),
        owner: service.worker.to_string(),
    }
}

/// Opens what a fleet shares, or else the data folder.
async fn open_stores(settings: &Settings) -> Result<(Arc<Catalogue>, Blobs), ServeError> {
    match &settings.shared {
        Some(shared) => open_shared(shared, &settings.data_dir).await,
        None => {
            let Folder { catalogue, blobs } = open_folder(&settings.data_dir).await?;
            Ok((catalogue, blobs))
        }
    }
}

/// Opens what a fleet shares; waits for a store that is away.
async fn open_shared(shared: &Shared, data_dir: &Path) -> Result<(Arc<Catalogue>, Blobs), ServeError> {
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
    /// Starts the background tasks. The handle resolves when they have ended after shutdown, or when one of them died.
    pub fn start(self) -> (Service, JoinHandle<Result<(), JoinError>>) {
        let Self { service, runner, changes } = self;
        let (shutdown, keyring) = (&service.shutdown, &service.keyring);
        let mut tasks = JoinSet::new();
        if let Some(runner) = runner {
            tasks.spawn(runner.run(shutdown.clone()));
            tasks.spawn(until(shutdown.clone(), collect_orphans(service.clone())));
        }
        tasks.spawn(until(shutdown.clone(), collect_descriptions(service.clone())));
        tasks.spawn(until(shutdown.clone(), announce(service.clone())));
        tasks.spawn(until(shutdown.clone(), http::events::watch(service.clone())));
        // The keys have tasks of their own: neither a version that takes long to load nor a write may delay a revocation.
        tasks.spawn(until(shutdown.clone(), refresh_keys(keyring.clone(), changes.clone())));
        tasks.spawn(until(shutdown.clone(), note_key_uses(keyring.clone())));
        tasks.spawn(until(shutdown.clone(), wake_jobs(service.jobs.clone(), changes.clone())));
        tasks.spawn(until(shutdown.clone(), refresh_registry(service.clone(), changes)));
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

/// Runs `task` until `shutdown` turns true.
async fn until(mut shutdown: watch::Receiver<bool>, task: impl Future<Output = ()>) {
    tokio::select! {
        () = task => {}
        _ = shutdown.wait_for(|stop| *stop) => {}
    }
}

/// Resolves at the next change notification, at the latest after [`REFRESH_EVERY`].
async fn changed(changes: &mut watch::Receiver<u64>) {
    tokio::select! {
        () = tokio::time::sleep(REFRESH_EVERY) => {}
        Ok(()) = changes.changed() => {}
    }
}

/// Removes blobs that nothing names any more.
async fn collect_orphans(service: Service) {
    loop {
        tokio::time::sleep(COLLECT_EVERY).await;
        match service.databases.collect_orphans(ORPHAN_AGE).await {
            Ok(OrphanCollection { removed, failed, error }) => {
                if removed > 0 {
                    tracing::info!(removed, "removed blobs that nothing names");
                }
                if let Some(error) = error {
                    let error = chain(&error);
                    tracing::warn!(failed, error, "can't remove some orphan blobs: later again");
                }
            }
            Err(error) => tracing::warn!(error = chain(&error), "can't collect orphan blobs"),
        }
    }
}

/// Removes descriptions of pictures that are gone.
async fn collect_descriptions(service: Service) {
    loop {
        match service.databases.collect_descriptions().await {
            Ok(0) => {}
            Ok(removed) => tracing::info!(removed, "removed descriptions of pictures that are gone"),
            Err(error) => {
                tracing::warn!(
                    error = chain(&error),
                    "can't remove descriptions of pictures that are gone: later again"
                );
            }
        }
        tokio::time::sleep(COLLECT_EVERY).await;
    }
}

/// Loads and drops versions as the aliases in the catalogue change.
async fn refresh_registry(service: Service, mut changes: watch::Receiver<u64>) {
    loop {
        match service.databases.registry().refresh().await {
            Ok(()) => service.ready.store(true, Ordering::Relaxed),
            Err(error) => {
                tracing::warn!(error = chain(&error), "can't see what the aliases name; serving on");
            }
        }
        changed(&mut changes).await;
    }
}

/// Writes into the catalogue what this process serves, for the other processes.
async fn announce(service: Service) {
    loop {
        if let Err(error) = service.databases.record_process(&service.process()).await {
            tracing::debug!(error = chain(&error), "can't write what is served here: later again");
        }
        tokio::time::sleep(REFRESH_EVERY).await;
    }
}

/// Reads the keys that were made or revoked elsewhere.
async fn refresh_keys(keyring: Keyring, mut changes: watch::Receiver<u64>) {
    loop {
        changed(&mut changes).await;
        if let Err(error) = keyring.refresh().await {
            tracing::warn!(error = chain(&error), "can't read the keys; those known stay in force");
        }
    }
}

/// Writes the times of the keys' last uses.
async fn note_key_uses(keyring: Keyring) {
    loop {
        tokio::time::sleep(NOTE_USES_EVERY).await;
        if let Err(error) = keyring.record_uses().await {
            tracing::warn!(error = chain(&error), "can't note when keys were last used: later again");
        }
    }
}

/// Wakes the runner and the readers of events when another process may have changed a job.
async fn wake_jobs(jobs: Jobs, mut changes: watch::Receiver<u64>) {
    while changes.changed().await.is_ok() {
        jobs.wake();
    }
}

/// Serves until `stop` resolves; then finishes what runs and hands back the jobs. Calls `listening` with the address once
/// the port is open, and with what is counted.
///
/// # Errors
/// [`ServeError`]: why the service can't start, or stopped.
pub async fn serve(
    settings: &Settings,
    listening: impl FnOnce(SocketAddr, &Metrics),
    stop: impl Future<Output = ()>,
) -> Result<(), ServeError> {
    let (announce, shutdown) = watch::channel(false);
    tokio::pin!(stop);
    let parts = tokio::select! {
        parts = wire(settings, shutdown) => parts?,
        // Shared stores that are away are waited for.
        () = &mut stop => return Ok(()),
    };
    let (tls, following) = follow_certificate(settings).await?;
    let bind = settings.bind;
    if !settings.is_open_without_keys() && !parts.service.keyring.has_keys() {
        return Err(ServeError::OpenToAll { bind });
    }
    let not_bound = |source| ServeError::Bind { bind, source };
    let listener = listen(bind).map_err(not_bound)?;
    let address = listener.local_addr().map_err(not_bound)?;
    let (service, mut background) = parts.start();
    let limits = service.limits.clone();
    let (shutdown, metrics) = (service.shutdown.clone(), Arc::clone(&service.metrics));
    let serving = connections::serve(listener, tls, http::router(service), &limits, shutdown);
    tokio::pin!(serving);
    listening(address, &metrics);
    let stopping = async {
        stop.await;
        tracing::info!("shutting down");
        // Watched by `/readyz`, the runner and streams of events.
        announce.send_replace(true);
    };
    tokio::select! {
        // Neither ends by itself but by failing.
        () = &mut serving => {}
        died = &mut background => return Err(ServeError::Background { source: died.and_then(|died| died).err() }),
        () = stopping => serving.await,
    }
    drop(following);
    background.await.and_then(|died| died).map_err(|source| ServeError::Background { source: Some(source) })
}

/// The TLS settings, and the task that reads the certificate's files again when they change; neither without TLS.
async fn follow_certificate(
    settings: &Settings,
) -> Result<(Option<tls::ConfigReceiver>, Option<AbortOnDropHandle<()>>), TlsError> {
    let Some(files) = &settings.tls else { return Ok((None, None)) };
    let (in_force, following) = tls::follow(files.clone()).await?;
    Ok((Some(in_force), Some(AbortOnDropHandle::new(tokio::spawn(following)))))
}

/// Listens, with room for a burst of clients that connect at once.
fn listen(bind: SocketAddr) -> io::Result<TcpListener> {
    let socket = if bind.is_ipv4() { TcpSocket::new_v4()? } else { TcpSocket::new_v6()? };
    // A service that is started again must not wait for the connections of the one before to be forgotten.
    #[cfg(unix)]
    socket.set_reuseaddr(true)?;
    socket.bind(bind)?;
    socket.listen(BACKLOG)
}

/// The number of connections, at most `wanted`, for which the descriptors of this process suffice once its limit is raised
/// as far as it may be. Some are left for files.
#[cfg(target_os = "linux")]
fn affordable_connections(wanted: usize) -> usize {
    use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
    let needed = wanted as u64 + OTHER_DESCRIPTORS;
    let Rlimit { current, maximum } = getrlimit(Resource::Nofile);
    let raised = maximum.map_or(needed, |maximum| maximum.min(needed));
    let has = match current {
        Some(current) if current < raised => {
            let asked = Rlimit { current: Some(raised), maximum };
            setrlimit(Resource::Nofile, asked).map_or(current, |()| raised)
        }
        current => current.unwrap_or(needed),
    };
    if has >= needed {
        return wanted;
    }
    let fit = (has.saturating_sub(OTHER_DESCRIPTORS).max(has / 2)) as usize;
    tracing::warn!(wanted, fit, "too few file descriptors for all connections: raise ulimit -n");
    fit
}

#[cfg(not(target_os = "linux"))]
fn affordable_connections(wanted: usize) -> usize {
    wanted
}
