//! Every setting of the service with its unit, default and limit; read once at start.
//!
//! Precedence: flag, then environment (`LANDMARKD_…`), then the TOML file named by `--config`, then the
//! default. This is the only room that reads environment variables (clap does it, from the attributes below), but for those of
//! AWS and PostgreSQL, which the drivers of `store` read themselves.

use std::fmt;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::{Args, ValueEnum};
use serde::{Deserialize, Serialize};

/// How log lines are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LogFormat {
    /// For people at a terminal.
    Text,
    /// One JSON object a line, for log collectors.
    Json,
}

/// Where the windows of a version are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Resident {
    /// All in memory.
    Memory,
    /// In the artifact, and in memory those that frames needed lately: a descriptor of 256 bytes chooses exemplars.
    Cache,
}

/// What a process of a fleet does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// Hold versions in memory and answer; leave jobs to others.
    Serve,
    /// Do jobs; hold no version before it is asked for.
    Train,
    /// Both.
    All,
}

impl Role {
    /// The word for it.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Serve => "serve",
            Self::Train => "train",
            Self::All => "all",
        }
    }
}

/// The settings as given: each may be absent. The same shape is read from flags, environment and TOML.
#[derive(Debug, Clone, Default, Args, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GivenSettings {
    /// Address to listen on; loopback only, unless there is a key or --insecure is given [default: 127.0.0.1:8080]
    #[arg(long, env = "LANDMARKD_BIND", value_name = "ADDRESS")]
    pub bind: Option<SocketAddr>,
    /// Folder for the catalogue and the blobs, or in a fleet for copies of blobs; made if missing [default: ./landmarkd-data]
    #[arg(long, env = "LANDMARKD_DATA_DIR", value_name = "DIR")]
    pub data_dir: Option<PathBuf>,
    /// Catalogue that a fleet shares, postgres://user:password@host/database; needs --blobs [default: in the data folder]
    #[arg(long, env = "LANDMARKD_CATALOGUE", value_name = "URL", hide_env_values = true)]
    pub catalogue: Option<SharedCatalogue>,
    /// Bucket that a fleet shares, s3://bucket/prefix; endpoint and keys as AWS_… say; needs --catalogue [default: in the data folder]
    #[arg(long, env = "LANDMARKD_BLOBS", value_name = "URL")]
    pub blobs: Option<String>,
    /// Copies of shared blobs kept in the data folder [default: 4096]
    #[arg(long, env = "LANDMARKD_CACHE_LIMIT_MB", value_name = "N")]
    pub cache_limit_mb: Option<u64>,
    /// Descriptions of pictures kept in the data folder, so that trainings describe only new ones; 0 keeps none [default: 4096]
    #[arg(long, env = "LANDMARKD_DESCRIPTION_LIMIT_MB", value_name = "N")]
    pub description_limit_mb: Option<u64>,
    /// What this process does of a fleet's work [default: all]
    #[arg(long, env = "LANDMARKD_ROLE", value_name = "ROLE")]
    pub role: Option<Role>,
    /// Databases whose versions this process holds in memory, with * and ? in the name; others are loaded when asked for [default: *]
    #[arg(long, env = "LANDMARKD_SERVE", value_name = "PATTERN")]
    pub serve: Option<String>,
    /// Threads that compute recognitions [default: one a core]
    #[arg(long, env = "LANDMARKD_THREADS", value_name = "N")]
    pub threads: Option<usize>,
    /// Memory for loaded versions that no alias names, least recently used out first [default: 1024]
    #[arg(long, env = "LANDMARKD_MEMORY_LIMIT_MB", value_name = "N")]
    pub memory_limit_mb: Option<u64>,
    /// Where the windows of landmark versions are that are answered from [default: by --resident-limit-mb]
    #[arg(long, env = "LANDMARKD_RESIDENT", value_name = "WHERE")]
    pub resident: Option<Resident>,
    /// Largest version whose windows are held in memory, where --resident doesn't say [default: 4096]
    #[arg(long, env = "LANDMARKD_RESIDENT_LIMIT_MB", value_name = "N")]
    pub resident_limit_mb: Option<u64>,
    /// Memory for exemplars of versions whose windows are not held; 0 keeps none [default: 1024]
    #[arg(long, env = "LANDMARKD_EXEMPLAR_CACHE_MB", value_name = "N")]
    pub exemplar_cache_mb: Option<u64>,
    /// Listen on an address other than loopback although there is no key and nobody is asked for one
    #[arg(long, env = "LANDMARKD_INSECURE", num_args = 0..=1, default_missing_value = "true", value_name = "BOOL")]
    pub insecure: Option<bool>,
    /// How log lines are written [default: text]
    #[arg(long, env = "LANDMARKD_LOG_FORMAT", value_name = "FORMAT")]
    pub log_format: Option<LogFormat>,
    /// Collector that traces and metrics are sent to, by the OpenTelemetry protocol over HTTP: http://host:4318 [default: none]
    #[arg(long, env = "LANDMARKD_OTLP_ENDPOINT", value_name = "URL")]
    pub otlp_endpoint: Option<String>,
    /// Largest body of one request [default: 16]
    #[arg(long, env = "LANDMARKD_MAX_BODY_MB", value_name = "N")]
    pub max_body_mb: Option<u64>,
    /// Longest side of a picture [default: 8192]
    #[arg(long, env = "LANDMARKD_MAX_SIDE_PX", value_name = "N")]
    pub max_side_px: Option<u32>,
    /// Most pixels of a picture, in millions [default: 40]
    #[arg(long, env = "LANDMARKD_MAX_MEGAPIXELS", value_name = "N")]
    pub max_megapixels: Option<u64>,
    /// Most parts or tar entries of one batch [default: 1000]
    #[arg(long, env = "LANDMARKD_MAX_BATCH_PARTS", value_name = "N")]
    pub max_batch_parts: Option<usize>,
    /// Largest body of one batch [default: 512]
    #[arg(long, env = "LANDMARKD_MAX_BATCH_MB", value_name = "N")]
    pub max_batch_mb: Option<u64>,
    /// Requests that may wait for a computing thread, per thread; more are refused with 503 [default: 64]
    #[arg(long, env = "LANDMARKD_WAITING_PER_THREAD", value_name = "N")]
    pub waiting_per_thread: Option<usize>,
    /// Longest time one request may take, in seconds (batches ten times as long) [default: 60]
    #[arg(long, env = "LANDMARKD_REQUEST_TIMEOUT_S", value_name = "SECONDS")]
    pub request_timeout_s: Option<u64>,
    /// Certificate chain as PEM, the service's own first; with --tls-key the service speaks HTTPS alone [default: none]
    #[arg(long, env = "LANDMARKD_TLS_CERT", value_name = "FILE")]
    pub tls_cert: Option<PathBuf>,
    /// Private key of the certificate as PEM; both files are read again when they change [default: none]
    #[arg(long, env = "LANDMARKD_TLS_KEY", value_name = "FILE")]
    pub tls_key: Option<PathBuf>,
    /// Most connections at once; one more is closed [default: 1024]
    #[arg(long, env = "LANDMARKD_MAX_CONNECTIONS", value_name = "N")]
    pub max_connections: Option<usize>,
    /// Longest time a new connection, or one that has begun a header, may take to finish the header, in seconds [default: 10]
    #[arg(long, env = "LANDMARKD_HEADER_TIMEOUT_S", value_name = "SECONDS")]
    pub header_timeout_s: Option<u64>,
    /// Longest time the body of a request may take to arrive, in seconds [default: 30]
    #[arg(long, env = "LANDMARKD_BODY_TIMEOUT_S", value_name = "SECONDS")]
    pub body_timeout_s: Option<u64>,
    /// Longest time a connection may stay open without a request, in seconds [default: 75]
    #[arg(long, env = "LANDMARKD_IDLE_TIMEOUT_S", value_name = "SECONDS")]
    pub idle_timeout_s: Option<u64>,
}

impl GivenSettings {
    /// What a file gives; no file gives nothing.
    fn of_file(path: Option<&Path>) -> Result<Self, SettingsError> {
        let Some(path) = path else { return Ok(Self::default()) };
        let text = std::fs::read_to_string(path)
            .map_err(|source| SettingsError::Unreadable { path: path.into(), source })?;
        toml::from_str(&text).map_err(|error: toml::de::Error| {
            let before = error.span().and_then(|span| text.get(..span.start)).unwrap_or_default();
            let line = before.matches('\n').count() + 1;
            SettingsError::Malformed { path: path.into(), line, what: error.message().to_owned() }
        })
    }

    /// These settings; what is absent is taken from `other`.
    fn over(self, other: Self) -> Self {
        Self {
            bind: self.bind.or(other.bind),
            data_dir: self.data_dir.or(other.data_dir),
            catalogue: self.catalogue.or(other.catalogue),
            blobs: self.blobs.or(other.blobs),
            cache_limit_mb: self.cache_limit_mb.or(other.cache_limit_mb),
            description_limit_mb: self.description_limit_mb.or(other.description_limit_mb),
            role: self.role.or(other.role),
            serve: self.serve.or(other.serve),
            threads: self.threads.or(other.threads),
            memory_limit_mb: self.memory_limit_mb.or(other.memory_limit_mb),
            resident: self.resident.or(other.resident),
            resident_limit_mb: self.resident_limit_mb.or(other.resident_limit_mb),
            exemplar_cache_mb: self.exemplar_cache_mb.or(other.exemplar_cache_mb),
            insecure: self.insecure.or(other.insecure),
            log_format: self.log_format.or(other.log_format),
            otlp_endpoint: self.otlp_endpoint.or(other.otlp_endpoint),
            max_body_mb: self.max_body_mb.or(other.max_body_mb),
            max_side_px: self.max_side_px.or(other.max_side_px),
            max_megapixels: self.max_megapixels.or(other.max_megapixels),
            max_batch_parts: self.max_batch_parts.or(other.max_batch_parts),
            max_batch_mb: self.max_batch_mb.or(other.max_batch_mb),
            waiting_per_thread: self.waiting_per_thread.or(other.waiting_per_thread),
            request_timeout_s: self.request_timeout_s.or(other.request_timeout_s),
            tls_cert: self.tls_cert.or(other.tls_cert),
            tls_key: self.tls_key.or(other.tls_key),
            max_connections: self.max_connections.or(other.max_connections),
            header_timeout_s: self.header_timeout_s.or(other.header_timeout_s),
            body_timeout_s: self.body_timeout_s.or(other.body_timeout_s),
            idle_timeout_s: self.idle_timeout_s.or(other.idle_timeout_s),
        }
    }

    fn shared(&self) -> Result<Option<Shared>, SettingsError> {
        let cache_limit_mb = ranged("cache_limit_mb", self.cache_limit_mb, 4096, 0, 1 << 24)?;
        match (self.catalogue.clone(), self.blobs.clone()) {
            (None, None) => Ok(None),
            (Some(catalogue), Some(blobs)) => {
                Ok(Some(Shared { catalogue, blobs, cache_limit_bytes: cache_limit_mb << 20 }))
            }
            _ => Err(SettingsError::HalfShared),
        }
    }

    fn tls(&self) -> Result<Option<TlsFiles>, SettingsError> {
        match (self.tls_cert.clone(), self.tls_key.clone()) {
            (None, None) => Ok(None),
            (Some(cert), Some(key)) => Ok(Some(TlsFiles { cert, key })),
            _ => Err(SettingsError::HalfTls),
        }
    }

    fn holds(&self, role: Role) -> Result<Option<glob::Pattern>, SettingsError> {
        let given = self.serve.clone().unwrap_or_else(|| "*".to_owned());
        match glob::Pattern::new(&given) {
            Ok(pattern) => Ok((role != Role::Train).then_some(pattern)),
            Err(source) => Err(SettingsError::NoPattern { given, source }),
        }
    }

    fn limits(&self) -> Result<Limits, SettingsError> {
        let defaults = Limits::default();
        let count = |setting, given: Option<usize>, default: usize, least, most| {
            ranged(setting, given, default as u64, least, most).map(|number| number as usize)
        };
        let mib = |setting, given: Option<u64>, default_bytes: u64, most| {
            ranged(setting, given, default_bytes >> 20, 1, most).map(|number| number << 20)
        };
        let seconds = |setting, given: Option<u64>, default: Duration, most| {
            ranged(setting, given, default.as_secs(), 1, most).map(Duration::from_secs)
        };
        let side_px = u64::from(defaults.max_side_px);
        let megapixels = defaults.max_pixels / 1_000_000;
        Ok(Limits {
            max_body_bytes: mib("max_body_mb", self.max_body_mb, defaults.max_body_bytes, 256)?,
            max_side_px: ranged("max_side_px", self.max_side_px, side_px, 16, 32_768)? as u32,
            max_pixels: ranged("max_megapixels", self.max_megapixels, megapixels, 1, 200)? * 1_000_000,
            max_batch_parts: count(
                "max_batch_parts",
                self.max_batch_parts,
                defaults.max_batch_parts,
                1,
                100_000,
            )?,
            max_batch_bytes: mib("max_batch_mb", self.max_batch_mb, defaults.max_batch_bytes, 64 << 10)?,
            waiting_per_thread: count(
                "waiting_per_thread",
                self.waiting_per_thread,
                defaults.waiting_per_thread,
                0,
                10_000,
            )?,
            request_timeout: seconds(
                "request_timeout_s",
                self.request_timeout_s,
                defaults.request_timeout,
                3600,
            )?,
            max_connections: count(
                "max_connections",
                self.max_connections,
                defaults.max_connections,
                2,
                100_000,
            )?,
            header_timeout: seconds("header_timeout_s", self.header_timeout_s, defaults.header_timeout, 600)?,
            body_timeout: seconds("body_timeout_s", self.body_timeout_s, defaults.body_timeout, 3600)?,
            idle_timeout: seconds("idle_timeout_s", self.idle_timeout_s, defaults.idle_timeout, 3600)?,
            ..defaults
        })
    }
}

/// Where a shared catalogue is; it holds a password, so it isn't shown.
#[derive(Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct SharedCatalogue(String);

impl SharedCatalogue {
    /// The URL with all it holds.
    pub fn url(&self) -> &str {
        &self.0
    }
}

impl From<&str> for SharedCatalogue {
    fn from(url: &str) -> Self {
        Self(url.to_owned())
    }
}

impl fmt::Debug for SharedCatalogue {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("SharedCatalogue(…)")
    }
}

/// Where the catalogue of a service is: for a verb that needs no more of it.
#[derive(Debug, Clone, Args)]
pub struct CatalogueArgs {
    /// Settings of the service as TOML; flags and environment win over it
    #[arg(long, env = "LANDMARKD_CONFIG", value_name = "FILE")]
    config: Option<PathBuf>,
    /// Folder of the service [default: ./landmarkd-data]
    #[arg(long, env = "LANDMARKD_DATA_DIR", value_name = "DIR")]
    data_dir: Option<PathBuf>,
    /// Catalogue that a fleet shares [default: in the data folder]
    #[arg(long, env = "LANDMARKD_CATALOGUE", value_name = "URL", hide_env_values = true)]
    catalogue: Option<SharedCatalogue>,
}

impl CatalogueArgs {
    /// The shared catalogue, or else the data folder.
    ///
    /// # Errors
    /// An unreadable or malformed settings file.
    pub fn settle(self) -> Result<Result<SharedCatalogue, PathBuf>, SettingsError> {
        let file = GivenSettings::of_file(self.config.as_deref())?;
        let data_dir = self.data_dir.or(file.data_dir).unwrap_or_else(default_data_dir);
        // A folder that was named on the command line isn't outdone by a file's catalogue.
        Ok(self.catalogue.or(file.catalogue).ok_or(data_dir))
    }
}

fn default_data_dir() -> PathBuf {
    PathBuf::from("landmarkd-data")
}

/// What the processes of a fleet share.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shared {
    /// Its PostgreSQL catalogue.
    pub catalogue: SharedCatalogue,
    /// `s3://bucket/prefix`.
    pub blobs: String,
    /// Bytes that copies of blobs may take in the data folder.
    pub cache_limit_bytes: u64,
}

/// Where the service's certificate and its key are, both as PEM.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TlsFiles {
    /// The certificate chain, the service's own certificate first.
    pub cert: PathBuf,
    /// The private key.
    pub key: PathBuf,
}

/// What is refused before it costs anything. `GET /v1/info` shows these.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Limits {
    /// A phone's picture of 48 Mpx as JPEG is 8–15 MB; 16 MiB leaves room.
    pub max_body_bytes: u64,
    /// Longest side of a picture.
    pub max_side_px: u32,
    /// Most pixels of a picture. 50 Mpx in colour take 2.4 GB while they are worked on (see `Header::working_bytes`):
    /// more than a lane's budget, so such a picture runs alone.
    pub max_pixels: u64,
    /// What one decoder may allocate: 50 Mpx × 6 bytes (16-bit colour) = 300 MB, rounded up to 288 MiB.
    pub max_decode_bytes: u64,
    /// What all pictures being worked on may take together: 1 GiB is a hundred frames of 640×480 in colour.
    pub max_decode_bytes_total: u64,
    /// What all bodies being read or worked on may take together: a queue of 1024 frames of 1 MB each.
    pub max_body_bytes_total: u64,
    /// Most parts or tar entries of one batch.
    pub max_batch_parts: usize,
    /// Largest body of one batch; it is streamed, never held whole.
    pub max_batch_bytes: u64,
    /// Largest version artifact taken by `POST …/versions`.
    pub max_artifact_bytes: u64,
    /// Most tracks that are live at once: more robots than one process serves.
    pub max_tracks: usize,
    /// What all live tracks may hold: one along a path of 2000 exemplars takes 0.35 MB, so 700 of them.
    pub max_tracks_bytes: u64,
    /// A track without a frame for this long is gone.
    pub track_idle: Duration,
    /// 64 frames at 15 ms are one second of waiting: longer than a robot would want.
    pub waiting_per_thread: usize,
    /// Longest time one request may take.
    pub request_timeout: Duration,
    /// Most connections at once. A thousand robots keep one each; what one may take at worst is in `connections`.
    pub max_connections: usize,
    /// Longest time the header of a request may take to arrive, from the connection or from its first byte; a TLS
    /// handshake counts as a part of the first one.
    pub header_timeout: Duration,
    /// Longest time the body of a request may take to arrive.
    pub body_timeout: Duration,
    /// Longest time between two requests of a connection: over the minute that proxies and clients keep theirs, so
    /// that they are the ones to close.
    pub idle_timeout: Duration,
    /// Longest time a client may take over each 16 KiB of an answer.
    pub write_timeout: Duration,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            max_body_bytes: 16 << 20,
            max_side_px: 8192,
            max_pixels: 50_000_000,
            max_decode_bytes: 288 << 20,
            max_decode_bytes_total: 1 << 30,
            max_body_bytes_total: 1 << 30,
            max_batch_parts: 1000,
            max_batch_bytes: 512 << 20,
            max_artifact_bytes: 512 << 20,
            max_tracks: 1024,
            max_tracks_bytes: 256 << 20,
            track_idle: Duration::from_secs(600),
            waiting_per_thread: 64,
            request_timeout: Duration::from_secs(60),
            max_connections: 1024,
            header_timeout: Duration::from_secs(10),
            body_timeout: Duration::from_secs(30),
            idle_timeout: Duration::from_secs(75),
            write_timeout: Duration::from_secs(30),
        }
    }
}

/// The settings in force.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Address to listen on.
    pub bind: SocketAddr,
    /// Folder of catalogue and blobs, or in a fleet of copies of blobs.
    pub data_dir: PathBuf,
    /// None: the data folder holds everything, and this process alone works in it.
    pub shared: Option<Shared>,
    /// Bytes that descriptions of pictures may take in the data folder.
    pub description_limit_bytes: u64,
    /// The process's part of a fleet's work.
    pub role: Role,
    /// Databases whose versions are held in memory before they are asked for; none for a process that only trains.
    pub holds: Option<glob::Pattern>,
    /// Computing threads, at least one.
    pub threads: usize,
    /// Bytes that loaded versions without an alias may take.
    pub memory_limit_bytes: u64,
    /// Bytes of the largest version whose windows are held in memory.
    pub resident_limit_bytes: u64,
    /// Bytes that exemplars of larger versions may take.
    pub exemplar_cache_bytes: u64,
    /// Whether a service without keys may listen on an address other than loopback.
    pub insecure: bool,
    /// None: HTTP without TLS.
    pub tls: Option<TlsFiles>,
    /// How log lines are written.
    pub log_format: LogFormat,
    /// Where traces and metrics are sent.
    pub otlp_endpoint: Option<String>,
    /// What is refused.
    pub limits: Limits,
}

/// Why the settings can't be used, and what to do.
#[derive(Debug, thiserror::Error)]
pub enum SettingsError {
    /// The file isn't there, or may not be read.
    #[error("can't read the settings file {path}: check the path given with --config")]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        source: std::io::Error,
    },
    /// The file is no TOML, or holds an unknown setting. Its text isn't repeated: it may hold the catalogue's password.
    #[error("the settings file {path} is not right, at its line {line}: {what}")]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Number of the line, from 1.
        line: usize,
        /// What is wrong there.
        what: String,
    },
    /// A shared catalogue without shared blobs, or the other way round.
    #[error(
        "--catalogue and --blobs belong together: a catalogue that several processes share names blobs that all of \
         them must reach. Give both, or neither for one process on --data-dir"
    )]
    HalfShared,
    /// A certificate without its key, or the other way round.
    #[error("--tls-cert and --tls-key belong together: give both for HTTPS, or neither for HTTP")]
    HalfTls,
    /// The names of databases to hold are no pattern.
    #[error("--serve {given} is no pattern: names with * and ? are, such as floor-*")]
    NoPattern {
        /// As given.
        given: String,
        /// What is wrong with it.
        source: glob::PatternError,
    },
    /// A part of a fleet's work for a process that shares nothing.
    #[error("--role {} needs a catalogue that others share: give --catalogue and --blobs", role.as_str())]
    RoleAlone {
        /// As given.
        role: Role,
    },
    /// A number that the service can't work with.
    #[error("{setting} is {given}; it must be between {least} and {most}")]
    OutOfRange {
        /// Name of the setting, as in the file.
        setting: &'static str,
        /// As given, or the default.
        given: u64,
        /// The least that is taken.
        least: u64,
        /// The most that is taken.
        most: u64,
    },
}

impl Settings {
    /// Whether a service without a key lets everybody in: from this machine, or at the operator's word.
    pub fn is_open_without_keys(&self) -> bool {
        self.bind.ip().is_loopback() || self.insecure
    }

    /// The settings as given on the command line and in the environment, over those of the file at `config` if there
    /// is one, over the defaults.
    ///
    /// # Errors
    /// An unreadable or malformed file, a number out of its range, or settings that exclude each other.
    pub fn settle(given: GivenSettings, config: Option<&Path>) -> Result<Self, SettingsError> {
        let given = given.over(GivenSettings::of_file(config)?);
        let cores = std::thread::available_parallelism().map_or(1, usize::from) as u64;
        let (shared, tls) = (given.shared()?, given.tls()?);
        let role = given.role.unwrap_or(Role::All);
        if shared.is_none() && role != Role::All {
            return Err(SettingsError::RoleAlone { role });
        }
        let resident_limit_mb = ranged("resident_limit_mb", given.resident_limit_mb, 4096, 0, 1 << 24)?;
        Ok(Self {
            bind: given.bind.unwrap_or(SocketAddr::from(([127, 0, 0, 1], 8080))),
            shared,
            role,
            description_limit_bytes: ranged(
                "description_limit_mb",
                given.description_limit_mb,
                4096,
                0,
                1 << 24,
            )? << 20,
            holds: given.holds(role)?,
            threads: ranged("threads", given.threads, cores, 1, 1024)? as usize,
            memory_limit_bytes: ranged("memory_limit_mb", given.memory_limit_mb, 1024, 0, 1 << 20)? << 20,
            resident_limit_bytes: match (given.resident, resident_limit_mb) {
                (Some(Resident::Memory), _) => u64::MAX,
                (Some(Resident::Cache), _) => 0,
                (None, limit_mb) => limit_mb << 20,
            },
            exemplar_cache_bytes: ranged("exemplar_cache_mb", given.exemplar_cache_mb, 1024, 0, 1 << 24)?
                << 20,
            insecure: given.insecure.unwrap_or(false),
            tls,
            log_format: given.log_format.unwrap_or(LogFormat::Text),
            otlp_endpoint: given.otlp_endpoint.clone(),
            limits: given.limits()?,
            data_dir: given.data_dir.unwrap_or_else(default_data_dir),
        })
    }
}

/// The number given for a setting, or its default, if it is between `least` and `most`.
fn ranged(
    setting: &'static str,
    given: Option<impl TryInto<u64>>,
    default: u64,
    least: u64,
    most: u64,
) -> Result<u64, SettingsError> {
    let given = given.map_or(default, |number| number.try_into().unwrap_or(u64::MAX));
    if (least..=most).contains(&given) {
        Ok(given)
    } else {
        Err(SettingsError::OutOfRange { setting, given, least, most })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flags_win_over_the_file_and_the_file_over_defaults() {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), "threads = 3\nmax_body_mb = 2\n").unwrap();
        let given = GivenSettings { threads: Some(5), ..Default::default() };
        let settings = Settings::settle(given, Some(file.path())).unwrap();
        assert_eq!(settings.threads, 5);
        assert_eq!(settings.limits.max_body_bytes, 2 << 20);
        assert_eq!(settings.limits.max_side_px, 8192);
    }

    #[test]
    fn a_fleet_shares_both_a_catalogue_and_a_bucket() {
        let settled = |catalogue: Option<&str>, blobs: Option<&str>, role| {
            let given = GivenSettings {
                catalogue: catalogue.map(SharedCatalogue::from),
                blobs: blobs.map(str::to_owned),
                role,
                ..Default::default()
            };
            Settings::settle(given, None)
        };
        let (url, bucket) = (Some("postgres://robot:secret@db/fleet"), Some("s3://fleet/landmarks"));
        let settings = settled(url, bucket, Some(Role::Train)).unwrap();
        assert_eq!(settings.shared.as_ref().unwrap().catalogue.url(), url.unwrap());
        assert!(settings.holds.is_none());
        assert!(!format!("{settings:?}").contains("secret"));
        assert!(matches!(settled(url, None, None), Err(SettingsError::HalfShared)));
        assert!(matches!(settled(None, bucket, None), Err(SettingsError::HalfShared)));
        assert!(matches!(settled(None, None, Some(Role::Serve)), Err(SettingsError::RoleAlone { .. })));
    }

    #[test]
    fn a_certificate_without_its_key_is_refused() {
        let given = GivenSettings { tls_cert: Some("cert.pem".into()), ..Default::default() };
        assert!(matches!(Settings::settle(given.clone(), None), Err(SettingsError::HalfTls)));
        let given = GivenSettings { tls_key: Some("key.pem".into()), ..given };
        assert!(Settings::settle(given, None).unwrap().tls.is_some());
    }

    #[test]
    fn a_misspelt_setting_in_the_file_is_named() {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), "treads = 3\n").unwrap();
        let error = Settings::settle(GivenSettings::default(), Some(file.path())).unwrap_err();
        assert!(error.to_string().contains("treads"), "{error}");
        let secret = "bind = \"127.0.0.1:1\"\ncatalog = \"postgres://robot:secret@db/fleet\"\n";
        std::fs::write(file.path(), secret).unwrap();
        let error = Settings::settle(GivenSettings::default(), Some(file.path())).unwrap_err();
        assert!(error.to_string().contains("line 2") && error.to_string().contains("catalog"), "{error}");
        assert!(!format!("{error:?}").contains("secret"), "{error:?}");
    }
}
