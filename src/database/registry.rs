//! The registry: which versions are in memory, and which one an alias names.
//!
//! Everything that aliases name is one immutable snapshot behind one atomic pointer. A request loads the pointer
//! once and keeps its version to the end; a refresh builds the next snapshot beside it and swaps. A version that
//! can't load leaves the one before it serving, and the snapshot says why.
//! Versions asked for by number load on demand into a cache bounded in bytes, least recently used out first.

use std::collections::{BTreeMap, HashMap};
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::time::{Duration, Instant};

use arc_swap::ArcSwap;
use bytes::Bytes;
use serde::{Deserialize, Serialize};
use tokio::sync::OwnedSemaphorePermit;

use super::artifact::outline::{self, ExemplarPlace, OutlineHeader};
use super::artifact::{self, Artifact, ArtifactError};
use super::kept_exemplars::{ExemplarCache, KeptExemplars, ReadExemplars};
use super::survey::{Surveys, bytes_of};
use super::{CURRENT, DatabaseError, Databases, Model, Name, VersionRow};
use crate::compute::{Compute, Lane};
use crate::store::{AliasTarget, BlobError, BlobName, Blobs, Catalogue, InvalidBlobName};
use crate::telemetry::chain;

/// A version in memory.
pub struct LoadedVersion {
    /// The database's name.
    pub database: String,
    /// The version's number; 0 for one that has none yet.
    pub version: i64,
    /// Digest of the inputs it was trained from.
    pub digest: String,
    /// What it recognises with.
    pub model: Model,
    /// Where its exemplars were taken.
    pub surveys: Surveys,
    /// Where the windows of its exemplars are; `None`: in the model.
    pub kept: Option<KeptExemplars>,
    /// Memory that the model holds, in bytes.
    pub bytes: u64,
}

impl LoadedVersion {
    /// A turn for a frame whose exemplars have to be read: what frames hold meanwhile is bounded. `None` where the windows are
    /// in the model.
    pub async fn turn(&self) -> Option<OwnedSemaphorePermit> {
        match &self.kept {
            Some(kept) => kept.turn().await,
            None => None,
        }
    }

    /// What a frame needs of exemplars whose windows are not in the model; empty if they are.
    ///
    /// # Errors
    /// [`DatabaseError::Unloadable`] when the artifact is damaged or gone, or the error of a store that is unavailable.
    pub async fn read_exemplars(&self, indices: &[usize]) -> Result<ReadExemplars, DatabaseError> {
        let Some(kept) = &self.kept else { return Ok(ReadExemplars::default()) };
        kept.read(indices).await.map_err(|source| match source.is_damage() {
            true => {
                let (database, version, reason) = (&self.database, self.version, chain(&source));
                tracing::error!(database, version, reason, "windows of a version can't be read");
                DatabaseError::Unloadable {
                    database: database.clone(),
                    version,
                    reason: format!("{reason}; train again, or import it again, or restore a backup"),
                }
            }
            false => source.into(),
        })
    }
}

/// Where the windows of versions are that are served.
#[derive(Debug, Clone)]
pub struct Residency {
    /// Bytes of the largest artifact whose windows are held in memory. Of others they are read when a frame needs them:
    /// exemplars are chosen by a descriptor each, then the frame is recognised among them.
    pub largest_bytes: u64,
    /// What was read of those lately.
    pub cache: Arc<ExemplarCache>,
}

/// An alias that doesn't serve what the catalogue says it should.
#[derive(Debug, Clone)]
struct Failure {
    digest: String,
    blob: String,
    reason: String,
    at: Instant,
}

/// How long a version that didn't load is left alone before it is tried again.
const RETRY_AFTER: Duration = Duration::from_secs(10);

/// Largest budget for loading by number: a TiB.
const MAX_MIB: u32 = 1 << 20;

/// What the aliases name.
#[derive(Default)]
struct Snapshot {
    /// By database, then alias.
    databases: HashMap<String, BTreeMap<String, Served>>,
}

/// What one alias serves: the version it names, or the one before it and why that is so.
#[derive(Clone, Default)]
struct Served {
    version: Option<Arc<LoadedVersion>>,
    failure: Option<Failure>,
}

/// How a database is served by this process.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ServedState {
    /// The database's name.
    pub database: String,
    /// What `current` answers with; none when it names nothing, or its version never loaded.
    pub version: Option<i64>,
    /// Why an alias doesn't serve what it should.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

/// Locked while a version is loaded, so that it is loaded once.
type LoadLock = tokio::sync::Mutex<()>;

/// The versions in memory, by alias and by number.
pub struct Registry {
    catalogue: Arc<Catalogue>,
    blobs: Blobs,
    compute: Compute,
    /// Databases whose aliased versions are held; none at all in a process that only trains.
    holds: Option<glob::Pattern>,
    residency: Residency,
    snapshot: ArcSwap<Snapshot>,
    refreshing: tokio::sync::Mutex<()>,
    /// By database and version.
    load_locks: Mutex<HashMap<(String, i64), Weak<LoadLock>>>,
    /// One permit for each MiB of versions that are loaded by number at once: as much again as the cache may hold.
    loading_budget: tokio::sync::Semaphore,
    loading_budget_mib: u32,
    cache: Mutex<VersionCache>,
}

/// Versions asked for by number, the most recently used last.
struct VersionCache {
    versions: Vec<Arc<LoadedVersion>>,
    limit_bytes: u64,
}

impl Registry {
    /// An empty registry; [`Registry::refresh`] fills it with what the aliases of the databases that it `holds`
    /// name.
    pub fn new(
        catalogue: Arc<Catalogue>,
        blobs: Blobs,
        compute: Compute,
        memory_limit_bytes: u64,
        holds: Option<glob::Pattern>,
        residency: Residency,
    ) -> Self {
        let loading_budget_mib = mib(memory_limit_bytes);
        Self {
            catalogue,
            blobs,
            compute,
            holds,
            residency,
            snapshot: ArcSwap::default(),
            refreshing: tokio::sync::Mutex::default(),
            load_locks: Mutex::default(),
            loading_budget: tokio::sync::Semaphore::new(loading_budget_mib as usize),
            loading_budget_mib,
            cache: Mutex::new(VersionCache { versions: Vec::new(), limit_bytes: memory_limit_bytes }),
        }
    }

    /// The version that the alias names, if this process serves it. One atomic load.
    pub fn by_alias(&self, database: &str, alias: &str) -> Option<Arc<LoadedVersion>> {
        self.snapshot.load().databases.get(database)?.get(alias)?.version.clone()
    }

    /// The version of that number, if it is in memory.
    pub fn by_number(&self, database: &str, version: i64) -> Option<Arc<LoadedVersion>> {
        let is_wanted =
            |loaded: &&Arc<LoadedVersion>| loaded.version == version && loaded.database == database;
        let snapshot = self.snapshot.load();
        let aliased = snapshot.databases.get(database).and_then(|aliases| {
            aliases.values().filter_map(|served| served.version.as_ref()).find(is_wanted).cloned()
        });
        aliased.or_else(|| {
            let mut cache = self.cache();
            let at = cache.versions.iter().position(|loaded| is_wanted(&loaded))?;
            let found = cache.versions.remove(at);
            cache.versions.push(Arc::clone(&found));
            Some(found)
        })
    }

    /// Read what the aliases name now, load what isn't in memory, and swap. A version that can't load doesn't
    /// stop the others.
    ///
    /// # Errors
    /// The catalogue is unavailable: then everything stays as it is.
    pub async fn refresh(&self) -> Result<(), DatabaseError> {
        let _one_at_a_time = self.refreshing.lock().await;
        let mut targets = self.catalogue.all_aliases().await?;
        let held = |target: &AliasTarget| self.holds.as_ref().is_some_and(|p| p.matches(&target.database));
        targets.retain(held);
        let before = self.snapshot.load_full();
        let mut next = Snapshot::default();
        let mut outage = None;
        for target in targets {
            let served = self.serve(&target, &before, &mut outage).await;
            next.databases.entry(target.database).or_default().insert(target.alias, served);
        }
        self.snapshot.store(Arc::new(next));
        self.forget_deleted().await
    }

    /// Refreshes after a version got its number that was loaded, whole, to be checked: it isn't read again to be served.
    ///
    /// # Errors
    /// As [`Registry::refresh`].
    pub(crate) async fn serve_checked(
        &self,
        checked: Arc<LoadedVersion>,
        row: &VersionRow,
    ) -> Result<(), DatabaseError> {
        let is_served_whole = row.bytes <= self.residency.largest_bytes;
        if let Some(checked) = Arc::into_inner(checked).filter(|_| is_served_whole) {
            self.cache_version(&Arc::new(LoadedVersion { version: row.version, ..checked }));
        }
        let refreshed = self.refresh().await;
        // whoever serves it has it by now
        self.forget(&row.database, Some(row.version));
        refreshed
    }

    /// Drop versions loaded by number that another process deleted, alone or with their database.
    async fn forget_deleted(&self) -> Result<(), DatabaseError> {
        let loaded = self.cache().versions.clone();
        if loaded.is_empty() {
            return Ok(());
        }
        let key = |version: &LoadedVersion| (version.database.clone(), version.version);
        let asked: Vec<_> = loaded.iter().map(|version| key(version)).collect();
        let kept = self.catalogue.digests(&asked).await?;
        let is_kept = |version: &LoadedVersion| {
            let (database, number) = key(version);
            kept.contains(&(database, number, version.digest.clone()))
        };
        let gone: Vec<_> = loaded.into_iter().filter(|version| !is_kept(version)).collect();
        self.cache().versions.retain(|held| !gone.iter().any(|gone| Arc::ptr_eq(gone, held)));
        Ok(())
    }

    /// The lock under which this version is loaded by number.
    fn load_lock(&self, database: &str, version: i64) -> Arc<LoadLock> {
        let mut locks = self.load_locks.lock().unwrap_or_else(PoisonError::into_inner);
        locks.retain(|_, lock| lock.strong_count() > 0);
        let lock = locks.entry((database.to_owned(), version)).or_default();
        lock.upgrade().unwrap_or_else(|| {
            let new = Arc::default();
            *lock = Arc::downgrade(&new);
            new
        })
    }

    /// What the alias serves from now on. `outage` is set once the blob store is found unavailable: each further version
    /// would wait for an answer that doesn't come, and delay those after it.
    async fn serve(&self, target: &AliasTarget, before: &Snapshot, outage: &mut Option<String>) -> Served {
        let old = before.databases.get(&target.database).and_then(|aliases| aliases.get(&target.alias));
        let in_memory = self.by_number(&target.database, target.version);
        // The digest is compared too: a database deleted and made anew counts its versions from 1 again.
        if let Some(version) = in_memory.filter(|loaded| loaded.digest == target.digest) {
            return Served { version: Some(version), failure: None };
        }
        if let Some(Served { failure: Some(failure), .. }) = old
            && (&failure.digest, &failure.blob) == (&target.digest, &target.blob)
            && failure.at.elapsed() < RETRY_AFTER
        {
            return old.cloned().unwrap_or_default();
        }
        let loaded = match outage {
            Some(reason) => Err(reason.clone()),
            None => self
                .load_to_serve(&target.database, target.version, &target.digest, &target.blob, target.bytes)
                .await
                .map_err(|error| {
                    let reason = chain(&error);
                    let (database, alias, version) = (&target.database, &target.alias, target.version);
                    tracing::error!(database, alias, version, reason, "a version can't be loaded");
                    if matches!(error, DatabaseError::Blobs { source: BlobError::Unavailable { .. } }) {
                        *outage = Some(reason.clone());
                    }
                    reason
                }),
        };
        match loaded {
            Ok(version) => Served { version: Some(version), failure: None },
            Err(reason) => {
                let failure = Failure {
                    digest: target.digest.clone(),
                    blob: target.blob.clone(),
                    reason,
                    at: Instant::now(),
                };
                Served { version: old.and_then(|old| old.version.clone()), failure: Some(failure) }
            }
        }
    }

    /// Reads a version to answer from: whole, or without its windows, as the residency says.
    ///
    /// # Errors
    /// As [`Registry::load`].
    async fn load_to_serve(
        &self,
        database: &str,
        version: i64,
        digest: &str,
        blob: &str,
        bytes: u64,
    ) -> Result<Arc<LoadedVersion>, DatabaseError> {
        let unloadable =
            |reason: String| DatabaseError::Unloadable { database: database.into(), version, reason };
        let name: BlobName = blob.parse().map_err(|error: InvalidBlobName| unloadable(chain(&error)))?;
        let is_larger = bytes > self.residency.largest_bytes;
        let outline = if is_larger { self.outline(&name, bytes).await } else { Ok(None) };
        let (artifact, places) = match outline {
            Ok(Some(outline)) => outline,
            Ok(None) => return self.load(database, version, digest, blob).await,
            Err(DatabaseError::InvalidArtifact { source }) => return Err(unloadable(chain(&source))),
            Err(DatabaseError::Blobs { source }) if source.is_damage() => {
                return Err(unloadable(format!("{}; {}", chain(&source), self.remedy(database).await)));
            }
            Err(error) => return Err(error),
        };
        let Artifact { digest: found, model, surveys, .. } = artifact;
        if found != digest {
            return Err(unloadable(format!("its artifact is that of digest {found}, not {digest}")));
        }
        let kept = KeptExemplars::new(self.blobs.clone(), name, places, Arc::clone(&self.residency.cache));
        let bytes = model.bytes() + kept.bytes() + bytes_of(&surveys);
        let (database, kept) = (database.into(), Some(kept));
        Ok(Arc::new(LoadedVersion { database, version, digest: found, model, surveys, kept, bytes }))
    }

    /// Reads an artifact without its windows; `None` if it has none that can be read by themselves.
    async fn outline(
        &self,
        name: &BlobName,
        bytes: u64,
    ) -> Result<Option<(Artifact, Vec<ExemplarPlace>)>, DatabaseError> {
        let invalid = |source| DatabaseError::InvalidArtifact { source };
        if self.blobs.size(name).await? != bytes {
            return Err(invalid(ArtifactError::Contents));
        }
        let prefix = self.one_range(name, 0..outline::PREFIX_LENGTH.min(bytes)).await?;
        let length = outline::header_length(&prefix).map_err(invalid)?.min(bytes);
        let header = self.one_range(name, 0..length).await?;
        let of = move || OutlineHeader::of(header, bytes);
        let (header, _) = self.compute.run(Lane::Maintenance, 0, of).await?;
        let Some(header) = header.map_err(invalid)? else { return Ok(None) };
        let [before, after] = header.around.clone();
        let around = [self.one_range(name, before).await?, self.one_range(name, after).await?];
        let (read, _) = self.compute.run(Lane::Maintenance, 0, move || header.read(around)).await?;
        Ok(Some(read.map_err(invalid)?))
    }

    async fn one_range(&self, name: &BlobName, range: Range<u64>) -> Result<Bytes, BlobError> {
        if range.is_empty() {
            return Ok(Bytes::new());
        }
        Ok(self.blobs.ranges(name, &[range]).await?.into_iter().next().unwrap_or_default())
    }

    /// The exemplars that are held of versions whose windows are elsewhere.
    pub fn exemplar_cache(&self) -> &ExemplarCache {
        &self.residency.cache
    }

    /// Read, verify and index one version whole, whether or not it is in memory.
    ///
    /// # Errors
    /// [`DatabaseError::Unloadable`], or the error of a store that is unavailable.
    pub(crate) async fn load(
        &self,
        database: &str,
        version: i64,
        digest: &str,
        blob: &str,
    ) -> Result<Arc<LoadedVersion>, DatabaseError> {
        let unloadable =
            |reason: String| DatabaseError::Unloadable { database: database.into(), version, reason };
        let name = blob.parse().map_err(|error: InvalidBlobName| unloadable(chain(&error)))?;
        let bytes = match self.blobs.get(&name, u64::MAX).await {
            Err(error) if error.is_damage() => {
                return Err(unloadable(format!("{}; {}", chain(&error), self.remedy(database).await)));
            }
            other => other?,
        };
        let read = self.compute.run(Lane::Maintenance, 0, move || {
            let artifact = artifact::read(bytes)?;
            Ok::<_, artifact::ArtifactError>((artifact.digest, artifact.model, artifact.surveys))
        });
        let (found, model, surveys) = read.await?.0.map_err(|error| unloadable(chain(&error)))?;
        if found != digest {
            return Err(unloadable(format!("its artifact is that of digest {found}, not {digest}")));
        }
        let bytes = model.bytes() + bytes_of(&surveys);
        let (database, kept) = (database.into(), None);
        Ok(Arc::new(LoadedVersion { database, version, digest: found, model, surveys, kept, bytes }))
    }

    /// What to do about a version whose artifact is lost, for people.
    async fn remedy(&self, database: &str) -> String {
        let exemplars = self.catalogue.database_counts(database).await.map_or(0, |counts| counts.exemplars);
        match exemplars {
            0 => "import it again, or restore a backup".into(),
            kept => format!(
                "train again ({kept} exemplars are still there: the same ones with the same options make it whole), or \
                 restore a backup"
            ),
        }
    }

    /// Put a version into the cache of those asked for by number.
    fn cache_version(&self, version: &Arc<LoadedVersion>) {
        let mut cache = self.cache();
        cache.versions.push(Arc::clone(version));
        let mut total: u64 = cache.versions.iter().map(|loaded| loaded.bytes).sum();
        // The one just asked for stays even when it is larger than the limit: it is being used.
        while total > cache.limit_bytes && cache.versions.len() > 1 {
            total -= cache.versions.remove(0).bytes;
        }
    }

    /// Drop a deleted version, or all of a deleted database, from the cache.
    pub(super) fn forget(&self, database: &str, version: Option<i64>) {
        let gone = |loaded: &LoadedVersion| {
            loaded.database == database && version.is_none_or(|version| loaded.version == version)
        };
        self.cache().versions.retain(|loaded| !gone(loaded));
    }

    fn cache(&self) -> std::sync::MutexGuard<'_, VersionCache> {
        self.cache.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// How each database with an alias is served, by name.
    pub fn states(&self) -> Vec<ServedState> {
        let snapshot = self.snapshot.load();
        let mut states: Vec<ServedState> = snapshot
            .databases
            .iter()
            .map(|(database, aliases)| ServedState {
                database: database.clone(),
                version: aliases.get(CURRENT).and_then(|served| served.version.as_ref()).map(|v| v.version),
                reason: aliases.iter().find_map(|(alias, served)| {
                    served.failure.as_ref().map(|failure| format!("alias {alias}: {}", failure.reason))
                }),
            })
            .collect();
        states.sort_by(|a, b| a.database.cmp(&b.database));
        states
    }

    /// Number and bytes of the versions in memory.
    pub fn held(&self) -> (usize, u64) {
        let snapshot = self.snapshot.load();
        let aliased = snapshot.databases.values().flat_map(BTreeMap::values);
        let mut held: Vec<Arc<LoadedVersion>> = aliased.filter_map(|served| served.version.clone()).collect();
        held.extend(self.cache().versions.iter().cloned());
        held.sort_by_key(Arc::as_ptr);
        held.dedup_by_key(|loaded| Arc::as_ptr(loaded));
        (held.len(), held.iter().map(|loaded| loaded.bytes).sum())
    }
}

fn mib(bytes: u64) -> u32 {
    u32::try_from(bytes.div_ceil(1 << 20)).unwrap_or(u32::MAX).clamp(1, MAX_MIB)
}

impl Databases {
    /// The version of that number, loaded if need be.
    ///
    /// # Errors
    /// [`DatabaseError::UnknownVersion`], [`DatabaseError::Unloadable`].
    pub async fn version_model(
        &self,
        database: &Name,
        version: i64,
    ) -> Result<Arc<LoadedVersion>, DatabaseError> {
        let registry = self.registry();
        if let Some(loaded) = registry.by_number(database.as_str(), version) {
            return Ok(loaded);
        }
        let lock = registry.load_lock(database.as_str(), version);
        let _locked = lock.lock().await;
        if let Some(loaded) = registry.by_number(database.as_str(), version) {
            return Ok(loaded);
        }
        self.get(database).await?;
        let row = self.version(database, version).await?;
        // A load that hangs delays no other as long as the budget lasts; a version larger than the budget is loaded alone.
        let budget_mib = mib(row.bytes).min(registry.loading_budget_mib);
        let _permits = registry.loading_budget.acquire_many(budget_mib).await;
        let loaded =
            registry.load_to_serve(database.as_str(), version, &row.digest, &row.blob, row.bytes).await?;
        // Deleted while it was loading, it must not come back.
        if self.version(database, version).await?.digest == row.digest {
            registry.cache_version(&loaded);
        }
        Ok(loaded)
    }

    /// A version with all of its windows, in memory already or loaded for this caller.
    ///
    /// # Errors
    /// As [`Databases::version_model`].
    pub(crate) async fn whole_version(&self, row: &VersionRow) -> Result<Arc<LoadedVersion>, DatabaseError> {
        let registry = self.registry();
        match registry.by_number(&row.database, row.version) {
            Some(loaded) if loaded.kept.is_none() && loaded.digest == row.digest => Ok(loaded),
            _ => registry.load(&row.database, row.version, &row.digest, &row.blob).await,
        }
    }

    /// The version that answers for an alias, by default `current`.
    ///
    /// # Errors
    /// [`DatabaseError::UnknownDatabase`], [`DatabaseError::NotTrained`], [`DatabaseError::NoCurrent`],
    /// [`DatabaseError::UnknownAlias`], or [`DatabaseError::Unloadable`] when the alias names a version that this process could never load.
    pub async fn alias_model(
        &self,
        database: &Name,
        alias: Option<&Name>,
    ) -> Result<Arc<LoadedVersion>, DatabaseError> {
        let wanted = alias.map_or(CURRENT, Name::as_str);
        if let Some(loaded) = self.registry().by_alias(database.as_str(), wanted) {
            return Ok(loaded);
        }
        self.get(database).await?;
        let rows = self.aliases(database).await?;
        match rows.into_iter().find(|row| row.alias == wanted) {
            // Known to the catalogue and not here: another process moved it a moment ago, or it doesn't load.
            Some(row) => self.version_model(database, row.version).await,
            None if alias.is_some_and(|alias| alias.as_str() != CURRENT) => {
                Err(DatabaseError::UnknownAlias { database: database.to_string(), alias: wanted.into() })
            }
            None if self.versions(database, None, 1).await?.is_empty() => {
                Err(DatabaseError::NotTrained { database: database.to_string() })
            }
            None => Err(DatabaseError::NoCurrent { database: database.to_string() }),
        }
    }
}
