//! The verb `keys`: make, list and revoke the keys of a service, whether or not it runs.

use std::fmt::{self, Display};
use std::path::Path;
use std::sync::Arc;

use clap::{Args, Subcommand};
use serde::Serialize;

use crate::access::{AccessError, Actor, Grant, KeyRow, Keyring, Scope};
use crate::config::{CatalogueArgs, SettingsError};
use crate::store::{
    Catalogue, CatalogueError, OpenCatalogueError, OpenFolderError, open_folder, open_postgres,
    open_unlocked_folder,
};

/// The actor in the audit record for this verb.
const ACTOR: &str = "command line";

/// What to do with the keys, and where they are kept.
#[derive(Debug, Clone, Args)]
pub struct KeysArgs {
    #[command(subcommand)]
    verb: KeysVerb,
}

#[derive(Debug, Clone, Subcommand)]
enum KeysVerb {
    /// Make a key and print it; it is shown this once
    Create {
        /// For people: whose key it is
        #[arg(long)]
        name: String,
        /// What it may do; each scope includes the ones before it
        #[arg(long)]
        scope: Scope,
        /// Databases that it reaches, with * and ? in the name; may be given several times [default: every one]
        #[arg(long, value_name = "PATTERN")]
        database: Vec<String>,
        /// Most calls a second, to each process [default: as many as there is time for]
        #[arg(long, value_name = "N")]
        requests_per_s: Option<u32>,
        #[command(flatten)]
        catalogue: CatalogueArgs,
    },
    /// List the keys, revoked ones too
    List {
        /// As one JSON array
        #[arg(long)]
        json: bool,
        #[command(flatten)]
        catalogue: CatalogueArgs,
    },
    /// End a key, for good
    Revoke {
        /// Its id, as list shows it: the part between the first and the second underscore
        id: String,
        #[command(flatten)]
        catalogue: CatalogueArgs,
    },
}

/// Why the verb failed.
#[derive(Debug, thiserror::Error)]
pub enum KeysError {
    /// The settings file can't be used.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// The data folder can't be opened.
    #[error("can't open the data folder")]
    Folder(#[from] OpenFolderError),
    /// The shared catalogue can't be opened.
    #[error("can't open the shared catalogue")]
    Catalogue(#[from] OpenCatalogueError),
    /// The catalogue is away.
    #[error("can't read the keys")]
    Read(#[from] CatalogueError),
    /// The key can't be made or revoked.
    #[error(transparent)]
    Access(#[from] AccessError),
}

/// What the verb prints to standard output; all else, such as advice, goes to standard error.
pub enum Printed {
    /// The text of a new key.
    Key(String),
    /// A table of the keys.
    List(Vec<ListedKey>),
    /// The same, as JSON.
    Json(Vec<ListedKey>),
    /// A key was revoked.
    Nothing,
}

/// A key as it is listed.
#[derive(Debug, Serialize)]
pub struct ListedKey {
    id: String,
    name: String,
    scope: String,
    databases: Option<Vec<String>>,
    requests_per_s: Option<i64>,
    created_at: String,
    last_used_at: Option<String>,
    revoked_at: Option<String>,
}

impl From<KeyRow> for ListedKey {
    fn from(row: KeyRow) -> Self {
        // Whole seconds are enough for people.
        let time = |time: jiff::Timestamp| format!("{time:.0}");
        Self {
            databases: row.databases.and_then(|kept| serde_json::from_str(&kept).ok()),
            id: row.id,
            name: row.name,
            scope: row.scope,
            requests_per_s: row.requests_per_s,
            created_at: time(row.created_at),
            last_used_at: row.last_used_at.map(time),
            revoked_at: row.revoked_at.map(time),
        }
    }
}

impl Display for Printed {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Key(text) => writeln!(out, "{text}"),
            Self::Json(keys) => {
                let text = serde_json::to_string_pretty(keys).map_err(|_| fmt::Error)?;
                writeln!(out, "{text}")
            }
            Self::List(keys) => {
                writeln!(out, "{:<16}  {:<10}  {:<20}  {:<20}  NAME", "ID", "SCOPE", "CREATED", "LAST USED")?;
                for key in keys {
                    let used = key.last_used_at.as_deref().unwrap_or("never");
                    write!(
                        out,
                        "{:<16}  {:<10}  {:<20}  {used:<20}  {}",
                        key.id, key.scope, key.created_at, key.name
                    )?;
                    if let Some(names) = &key.databases {
                        write!(out, "  [databases {}]", names.join(", "))?;
                    }
                    if let Some(rate) = key.requests_per_s {
                        write!(out, "  [{rate} requests/s]")?;
                    }
                    if let Some(time) = &key.revoked_at {
                        write!(out, "  [revoked {time}]")?;
                    }
                    writeln!(out)?;
                }
                Ok(())
            }
            Self::Nothing => Ok(()),
        }
    }
}

/// Runs the verb.
///
/// # Errors
/// The catalogue can't be opened or reached, the grant isn't right, or there is no such key.
pub async fn run(args: KeysArgs) -> Result<Printed, KeysError> {
    let by = Actor::named(ACTOR);
    match args.verb {
        KeysVerb::Create { name, scope, database, requests_per_s, catalogue } => {
            let databases = (!database.is_empty()).then_some(database);
            let grant = Grant { name, scope, databases, requests_per_s };
            let made = keyring(catalogue, true).await?.create(&grant, &by).await?;
            Ok(Printed::Key(made.key.reveal().to_owned()))
        }
        KeysVerb::List { json, catalogue } => {
            let rows = keyring(catalogue, false).await?.list().await?;
            let keys = rows.into_iter().map(ListedKey::from).collect();
            Ok(if json { Printed::Json(keys) } else { Printed::List(keys) })
        }
        KeysVerb::Revoke { id, catalogue } => {
            keyring(catalogue, false).await?.revoke(&id, &by).await?;
            Ok(Printed::Nothing)
        }
    }
}

/// Opens the keys; makes a missing folder for the first key, and for nothing else.
async fn keyring(catalogue: CatalogueArgs, may_make: bool) -> Result<Keyring, KeysError> {
    let catalogue = match catalogue.settle()? {
        Ok(shared) => open_postgres(shared.url()).await?.0,
        Err(data_dir) if may_make => open_rows(&data_dir).await?,
        Err(data_dir) => open_unlocked_folder(&data_dir).await?.catalogue,
    };
    Ok(Keyring::open(catalogue, false).await?)
}

/// The catalogue of a data folder, made if missing; beside the service that runs there, if one does.
async fn open_rows(data_dir: &Path) -> Result<Arc<Catalogue>, OpenFolderError> {
    match open_folder(data_dir).await {
        Err(OpenFolderError::InUse { .. }) => Ok(open_unlocked_folder(data_dir).await?.catalogue),
        folder => Ok(folder?.catalogue),
    }
}
