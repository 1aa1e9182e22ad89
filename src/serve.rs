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
use crate::database::Databases;
use crate::http::body::BodyBudget;
use crate::http::{self, Estimators, Service, Tracks};
use crate::jobs::{Jobs, Runner};
use crate::store::{
    Blobs, Catalogue, CatalogueError, Collected, Folder, OpenBucketError, OpenCatalogueError,
    OpenFolderError, open_bucket, open_folder, open_postgres,
};
use crate::telemetry::{Metrics, chain};
use crate::tls::{self, TlsError};
use landmarkd_core::imaging::DecodeLimits;

/// Connections that may wait to be accepted: as many as there may be in all.
const BACKLOG: u32 = 1024;
/// How often the catalogue is asked what the aliases name: a change made elsewhere is served this much later.
const REFRESH_EVERY: Duration = Duration::from_secs(2);
/// How old the time of a key's last use may be in the catalogue.
const NOTE_USES_EVERY: Duration = Duration::from_secs(30);
/// How often blobs that nothing names are looked for.
const COLLECT_EVERY: Duration = Duration::from_secs(3600);
/// A blob younger than this may belong to an upload whose row is still to come.
const ORPHAN_AGE: Duration = Duration::from_secs(24 * 3600);
/// Files and sockets that the process needs besides its connections: the catalogue, blobs, pictures being read.
#[cfg(target_os = "linux")]
const OTHER_DESCRIPTORS: u64 = 512;

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
    #[error("the catalogue can't be read")]
    Catalogue {
        #[from]
        source: CatalogueError,
    },
    #[error(
        "--bind {bind} is reachable from other machines, and there is no key to ask for: make one with \
         landmarkd keys create --name NAME --scope admin (and the --data-dir or --catalogue of this service), or bind \
         a loopback address such as 127.0.0.1:8080, or add --insecure to let everybody in"
    )]
    OpenToAll { bind: SocketAddr },
    #[error("can't listen on {bind}: is another service there? Give another address with --bind")]
    Bind { bind: SocketAddr, source: io::Error },
    #[error("can't serve over TLS")]
    Tls {
        #[from]
        source: TlsError,
    },
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
    let max_connections = room_for(settings.limits.max_connections);
    let limits = Limits { max_connections, ..settings.limits.clone() };
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
    let keyring = Keyring::open(Arc::clone(&catalogue), settings.is_open_without_keys()).await?;
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
        keyring,
        insecure: settings.insecure,
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
        tasks.spawn(refresh_keys(self.service.keyring.clone(), self.hints.clone(), shutdown.clone()));
        tasks.spawn(note_key_uses(self.service.keyring.clone(), shutdown.clone()));
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
            Ok(Collected { removed, failed, error }) => {
                if removed > 0 {
                    tracing::info!(removed, "removed blobs that nothing names");
                }
                if let Some(error) = error {
                    tracing::warn!(
                        failed,
                        error = chain(&error),
                        "can't remove some orphan blobs: later again"
                    );
                }
            }
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
            Ok(()) => service.ready.store(true, Ordering::Relaxed),
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
        let telling = async {
            if let Err(error) = service.databases.tell(&service.process()).await {
                tracing::debug!(error = chain(&error), "can't tell what is served here");
            }
            tokio::time::sleep(REFRESH_EVERY).await;
        };
        tokio::select! {
            () = telling => {}
            _ = shutdown.wait_for(|stop| *stop) => return,
        }
    }
}

/// Know of keys that were made or revoked elsewhere, until shutdown: at once when there is a hint, and every
/// [`REFRESH_EVERY`] in any case. A task of its own: a version that takes long to load must not hold up a revocation.
async fn refresh_keys(
    keyring: Keyring,
    mut hints: watch::Receiver<u64>,
    mut shutdown: watch::Receiver<bool>,
) {
    loop {
        tokio::select! {
            () = tokio::time::sleep(REFRESH_EVERY) => {}
            Ok(()) = hints.changed() => {}
            _ = shutdown.wait_for(|stop| *stop) => return,
        }
        let refreshed = tokio::select! {
            refreshed = keyring.refresh() => refreshed,
            _ = shutdown.wait_for(|stop| *stop) => return,
        };
        if let Err(error) = refreshed {
            tracing::warn!(error = chain(&error), "can't read the keys; those known stay in force");
        }
    }
}

/// Note now and then when keys were last used, until shutdown. A task of its own: a write must not hold up a revocation.
async fn note_key_uses(keyring: Keyring, mut shutdown: watch::Receiver<bool>) {
    loop {
        tokio::select! {
            () = tokio::time::sleep(NOTE_USES_EVERY) => {}
            _ = shutdown.wait_for(|stop| *stop) => return,
        }
        let noted = tokio::select! {
            noted = keyring.note_uses() => noted,
            _ = shutdown.wait_for(|stop| *stop) => return,
        };
        if let Err(error) = noted {
            tracing::warn!(error = chain(&error), "can't note when keys were last used: later again");
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
    let (tls, following) = match &settings.tls {
        None => (None, None),
        Some(files) => {
            let (in_force, following) = tls::follow(files.clone()).await?;
            (Some(in_force), Some(AbortOnDropHandle::new(tokio::spawn(following))))
        }
    };
    let bind = settings.bind;
    if !settings.is_open_without_keys() && !parts.service.keyring.has_keys() {
        return Err(ServeError::OpenToAll { bind });
    }
    let not_bound = |source| ServeError::Bind { bind, source };
    let listener = listen(bind).map_err(not_bound)?;
    let address = listener.local_addr().map_err(not_bound)?;
    let (service, mut background) = parts.start();
    let limits = service.limits.clone();
    let shutdown = service.shutdown.clone();
    let serving = connections::serve(listener, tls, http::router(service), &limits, shutdown);
    tokio::pin!(serving);
    listening(address);
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

/// Listen, with room for a burst of clients that connect at once.
fn listen(bind: SocketAddr) -> io::Result<TcpListener> {
    let socket = if bind.is_ipv4() { TcpSocket::new_v4()? } else { TcpSocket::new_v6()? };
    // A service that is started again must not wait for the connections of the one before to be forgotten.
    #[cfg(unix)]
    socket.set_reuseaddr(true)?;
    socket.bind(bind)?;
    socket.listen(BACKLOG)
}

/// How many of `wanted` connections the descriptors of this process suffice for, after asking for as many as it may
/// have. Without any left files couldn't be opened.
#[cfg(target_os = "linux")]
fn room_for(wanted: usize) -> usize {
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
fn room_for(wanted: usize) -> usize {
    wanted
}
