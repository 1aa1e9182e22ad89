//! Why a catalogue can't be opened, and whether to try again.

use sqlx::migrate::MigrateError;

use super::error::is_damage;

/// PostgreSQL's codes for a server that is starting, stopping, full, fenced off or read-only for now.
const AWAY_CLASSES: [&str; 3] = ["08", "53", "57"];
const AWAY_CODES: [&str; 2] = ["25006", "55P03"];
/// PostgreSQL's code for a database that doesn't exist.
const NO_DATABASE: &str = "3D000";
/// PostgreSQL's codes for a user who is refused, or may not do what is needed.
const REFUSED_CLASS: &str = "28";
const REFUSED_CODE: &str = "42501";

/// Why the catalogue can't be opened.
#[derive(Debug, thiserror::Error)]
pub enum OpenCatalogueError {
    /// It can't be opened, created or read.
    #[error("it cannot be opened")]
    Open(#[source] sqlx::Error),
    /// The file isn't a whole catalogue.
    #[error("it is damaged: restore the folder from a backup")]
    Damaged {
        /// What SQLite reports.
        #[source]
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// PostgreSQL isn't there, or can't serve now: the only one that may heal by itself.
    #[error("PostgreSQL cannot be reached now")]
    Unavailable(#[source] sqlx::Error),
    /// The address can't be read.
    #[error("its address is wrong: write postgres://user:password@host:5432/database")]
    Address(#[source] sqlx::Error),
    /// There is no such database on the server.
    #[error("PostgreSQL has no such database: create it (createdb), or correct the address")]
    NoDatabase(#[source] sqlx::Error),
    /// PostgreSQL refuses this user, or refuses it without TLS, or doesn't allow it to create tables.
    #[error(
        "PostgreSQL refuses: check the user, the password, the user's rights, and sslmode in the address"
    )]
    Refused(#[source] sqlx::Error),
    /// It holds a migration that this program doesn't know.
    #[error(
        "it was written by a newer release (migration {migration}): run that release, or restore a backup"
    )]
    Newer {
        /// Its number.
        migration: i64,
    },
    /// It lacks a migration of this program, and must not be changed while another process may serve it.
    #[error(
        "it was written by an older release (migration {migration} is missing): serve it once with this one"
    )]
    Older {
        /// Its number.
        migration: i64,
    },
    /// Bringing the tables up to date failed.
    #[error("its tables cannot be brought up to date")]
    Migrate(#[source] MigrateError),
}

impl OpenCatalogueError {
    /// The reason why SQLite didn't open.
    pub(super) fn from_sqlite(error: sqlx::Error) -> Self {
        if is_damage(&error) { Self::Damaged { source: error.into() } } else { Self::Open(error) }
    }

    /// The reason why SQLite's tables weren't brought up to date.
    pub(super) fn from_sqlite_migration(error: MigrateError) -> Self {
        match error {
            MigrateError::Execute(error) | MigrateError::ExecuteMigration(error, _) if is_damage(&error) => {
                Self::Damaged { source: error.into() }
            }
            other => other.into(),
        }
    }

    /// The reason why PostgreSQL didn't open.
    pub(super) fn from_postgres(error: sqlx::Error) -> Self {
        let code = match &error {
            sqlx::Error::Configuration(_) => return Self::Address(error),
            sqlx::Error::Tls(_) | sqlx::Error::Protocol(_) => return Self::Refused(error),
            sqlx::Error::Database(reported) => reported.code().unwrap_or_default(),
            _ => return Self::Unavailable(error),
        };
        if AWAY_CODES.contains(&&*code) || code.get(..2).is_some_and(|class| AWAY_CLASSES.contains(&class)) {
            Self::Unavailable(error)
        } else if code == NO_DATABASE {
            Self::NoDatabase(error)
        } else if code == REFUSED_CODE || code.starts_with(REFUSED_CLASS) {
            Self::Refused(error)
        } else {
            Self::Open(error)
        }
    }

    /// The reason why PostgreSQL's tables weren't brought up to date.
    pub(super) fn from_postgres_migration(error: MigrateError) -> Self {
        match error {
            MigrateError::Execute(error) | MigrateError::ExecuteMigration(error, _) => {
                match Self::from_postgres(error) {
                    Self::Open(error) => Self::Migrate(error.into()),
                    away_or_refused => away_or_refused,
                }
            }
            other => other.into(),
        }
    }
}

impl From<MigrateError> for OpenCatalogueError {
    fn from(error: MigrateError) -> Self {
        match error {
            MigrateError::VersionMissing(migration) => Self::Newer { migration },
            other => Self::Migrate(other),
        }
    }
}
