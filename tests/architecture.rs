//! The architecture's rules that no compiler checks, held against the source: which room may use which, one door per
//! outside crate, what the core never mentions, and what stands nowhere. Each rule is a table; a failure names file and
//! line. That the core uses no room of the service and none of its crates is checked by the build: it has not got them.
//!
//! A room is a folder of `src` or a file directly in it. Comments and texts are blanked before looking, and a file's
//! unit tests (from `#[cfg(test)] mod tests` on) are left out: they may use what they like.

#![expect(clippy::unwrap_used, reason = "a test fails where its helpers panic")]

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

/// Which rooms a room may use. The rooms that only wire may use all.
const ARROWS: &[(&str, &[&str])] = &[
    ("angle", &[]),
    ("statistics", &[]),
    ("random", &[]),
    ("column", &[]),
    ("imaging", &["statistics", "random"]),
    ("vision", &["imaging", "statistics"]),
    ("eigen", &["random", "column"]),
    ("depth", &["vision", "eigen", "imaging", "statistics"]),
    ("geometry", &[]),
    (
        "localisation",
        &["geometry", "recognition", "vision", "eigen", "imaging", "statistics", "random", "angle"],
    ),
    ("recognition", &["geometry", "vision", "eigen", "imaging", "angle", "statistics", "column"]),
    ("workcell", &["recognition", "depth", "vision", "eigen", "imaging", "statistics"]),
    ("store", &[]),
    ("compute", &[]),
    ("events", &[]),
    // Errors of the core have one code each.
    ("problem", &["depth", "imaging"]),
    ("access", &["store"]),
    ("config", &[]),
    // Settings say how log lines are written.
    ("telemetry", &["config"]),
    ("connections", &["config"]),
    ("tls", &["config", "telemetry"]),
    // Tensors of an artifact are columns of the index.
    (
        "database",
        &[
            "workcell",
            "recognition",
            "depth",
            "vision",
            "eigen",
            "geometry",
            "column",
            "store",
            "compute",
            "telemetry",
        ],
    ),
    // The rows of the job table and the artifact's write order are the store's; pictures are decoded before they are
    // described.
    ("jobs", &["database", "store", "recognition", "depth", "imaging", "compute", "problem", "telemetry"]),
    // Of the store, only the errors that problems are made of (see DOORS).
    (
        "http",
        &[
            "access",
            "database",
            "jobs",
            "compute",
            "problem",
            "config",
            "telemetry",
            "events",
            "geometry",
            "localisation",
            "imaging",
            "vision",
            "recognition",
            "depth",
            "workcell",
            "store",
        ],
    ),
];

/// Rooms that wire the others together.
const WIRING: [&str; 8] = ["lib", "main", "serve", "keys", "client", "bag", "demo", "evaluate"];

/// Where a word of the core may stand: folders or files of `crates/landmarkd-core/src`.
const CORE_DOORS: &[(&str, &[&str])] = &[
    ("image::", &["imaging"]),
    ("jpeg_decoder", &["imaging/decode.rs"]),
    ("embedded_graphics", &["imaging"]),
    ("colorous", &["imaging/false_colour.rs"]),
    ("libm", &["depth"]),
    ("bytemuck", &["eigen/inverted_index"]),
    ("memchr", &["vision/segmentation/components.rs", "imaging/decode.rs"]),
    ("rustfft", &["vision/signature.rs", "depth"]),
    ("faer", &["eigen"]),
    ("glam", &["geometry"]),
    ("kiddo", &["eigen"]),
    ("pulp", &["imaging", "vision", "eigen", "recognition", "depth"]),
];

/// Where a word of the service may stand: folders or files of `src`.
const SERVICE_DOORS: &[(&str, &[&str])] = &[
    ("sqlx", &["store"]),
    ("object_store", &["store"]),
    ("blake3", &["store"]),
    // The one crypto provider of the process is installed there.
    ("rustls", &["store/bucket.rs", "main.rs", "client.rs", "connections.rs", "tls.rs"]),
    ("tokio_rustls", &["connections.rs"]),
    // The sum of an exemplar's bytes is part of the contract, not of the store.
    ("sha2", &["database/exemplar.rs", "access/key.rs"]),
    ("subtle", &["access/key.rs"]),
    ("getrandom", &["access"]),
    ("governor", &["access/loaded_key.rs"]),
    ("safetensors", &["database/artifact"]),
    ("quick_cache", &["database/kept_exemplars.rs"]),
    ("arc_swap", &["database/registry.rs", "access/keyring.rs"]),
    ("glob::", &["config.rs", "database", "access"]),
    ("rayon", &["compute.rs"]),
    ("prometheus", &["telemetry"]),
    ("opentelemetry", &["telemetry/otlp.rs"]),
    ("tracing_opentelemetry", &["telemetry/otlp.rs"]),
    ("csv::", &["http/pose_table.rs"]),
    (
        "tracing",
        &[
            "store/cache.rs",
            "database",
            "jobs",
            "http",
            "connections.rs",
            "serve.rs",
            "tls.rs",
            "telemetry",
            "main.rs",
            "demo",
            "evaluate",
        ],
    ),
    ("tracing_subscriber", &["telemetry"]),
    // The body of an answer is given in pieces there.
    ("axum::", &["http", "connections.rs", "telemetry/otlp.rs"]),
    // One type for what is kept, or given on the command line, and for the wire.
    ("utoipa", &["http", "access/scope.rs", "database", "jobs/training", "store/tables/job_state.rs"]),
    ("tower_http", &["http"]),
    ("http_body_util", &["http"]),
    ("hyper", &["connections.rs"]),
    ("hyper_util", &["connections.rs"]),
    ("rustix", &["compute.rs", "serve.rs"]),
    ("reqwest", &["main.rs", "client.rs", "bag", "demo", "telemetry/otlp.rs"]),
    ("mcap", &["bag"]),
    ("cdr_encoding", &["bag/messages.rs"]),
    ("byteorder", &["bag/messages.rs"]),
    ("indicatif", &["bag", "main.rs"]),
    // The flags of a verb name their variables beside the verb; clap reads them.
    ("env =", &["config.rs", "main.rs", "bag"]),
    ("clap", &["access/scope.rs", "config.rs", "keys.rs", "main.rs", "bag", "demo", "evaluate"]),
    ("anyhow", &["main.rs"]),
    ("crate::store", &["access", "database", "jobs", "keys.rs", "serve.rs", "http/problem.rs"]),
];

/// What the core never mentions: it waits for nothing, and touches neither files nor clocks nor locks.
const IMPURE: [&str; 12] = [
    "async",
    "await",
    "std::fs",
    "std::net",
    "std::time",
    "std::process",
    "std::env",
    "SystemTime",
    "Instant",
    "Mutex",
    "RwLock",
    "Condvar",
];

/// What stands nowhere.
const NOWHERE: [&str; 8] =
    ["todo!", "unimplemented!", "dbg!", "#[allow", "#![allow", "mod utils", "env::var", "env::vars"];

/// A file of a package: its path in its `src`, whether it begins with a comment on its content, and its lines without comments,
/// texts and unit tests.
struct Source {
    path: String,
    documented: bool,
    lines: Vec<String>,
}

impl Source {
    fn room(&self) -> &str {
        self.path.split(['/', '.']).next().unwrap()
    }

    /// Numbers and lines in which a word stands by itself.
    fn mentions<'a>(&'a self, word: &'a str) -> impl Iterator<Item = (usize, &'a str)> {
        let lines = self.lines.iter().enumerate();
        lines.filter(move |(_, line)| stands_in(word, line)).map(|(at, line)| (at + 1, line.trim()))
    }

    fn is_in(&self, places: &[&str]) -> bool {
        places.iter().any(|place| self.path == *place || self.path.starts_with(&format!("{place}/")))
    }
}

/// Whether `word` stands in `line` and is not a part of a longer name.
fn stands_in(word: &str, line: &str) -> bool {
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    line.match_indices(word).any(|(at, _)| {
        let before = line[..at].chars().next_back();
        let after = line[at + word.len()..].chars().next();
        // `other::image::x` is somebody else's `image`.
        let starts = !word.starts_with(is_name) || !before.is_some_and(|c| is_name(c) || c == ':');
        starts && !(word.ends_with(is_name) && after.is_some_and(is_name))
    })
}

/// The text with comments, strings and characters blanked; lines stay where they are.
fn blanked(text: &str) -> String {
    let chars: Vec<char> = text.chars().collect();
    let mut out = String::with_capacity(text.len());
    let mut at = 0;
    let starts = |at: usize, what: &str| what.chars().enumerate().all(|(n, c)| chars.get(at + n) == Some(&c));
    while at < chars.len() {
        let is_name_before = at > 0 && (chars[at - 1].is_alphanumeric() || chars[at - 1] == '_');
        let hashes = chars[at..].iter().skip(1).take_while(|c| **c == '#').count();
        let end = if starts(at, "//") {
            (at..chars.len()).find(|&end| chars[end] == '\n').unwrap_or(chars.len())
        } else if starts(at, "/*") {
            (at + 2..chars.len()).find(|&end| starts(end, "*/")).map_or(chars.len(), |end| end + 2)
        } else if chars[at] == 'r' && !is_name_before && chars.get(at + 1 + hashes) == Some(&'"') {
            let close = format!("\"{}", "#".repeat(hashes));
            let from = at + 2 + hashes;
            (from..chars.len()).find(|&end| starts(end, &close)).map_or(chars.len(), |end| end + close.len())
        } else if chars[at] == '"' {
            let mut end = at + 1;
            while end < chars.len() && chars[end] != '"' {
                end += if chars[end] == '\\' { 2 } else { 1 };
            }
            end + 1
        } else if chars[at] == '\'' && chars.get(at + 1) == Some(&'\\') {
            (at + 3..chars.len()).find(|&end| chars[end] == '\'').map_or(chars.len(), |end| end + 1)
        } else if chars[at] == '\'' && chars.get(at + 2) == Some(&'\'') {
            at + 3
        } else {
            out.push(chars[at]);
            at += 1;
            continue;
        };
        let end = end.min(chars.len());
        out.extend(chars[at..end].iter().map(|c| if *c == '\n' { '\n' } else { ' ' }));
        at = end;
    }
    out
}

fn files_below(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files_below(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

/// The folder of the core's rooms, and of the service's.
const CORE: &str = "crates/landmarkd-core/src";
const SERVICE: &str = "src";

/// The files below a folder of rooms.
fn sources_of(folder: &str) -> Vec<Source> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let mut files = Vec::new();
    files_below(&root, &mut files);
    files.sort();
    assert!(files.len() > 20, "the source was not found");
    let source = |file: PathBuf| {
        let text = fs::read_to_string(&file).unwrap();
        let documented = text.starts_with("//! ");
        let text = blanked(&text);
        let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
        let path = file.strip_prefix(&root).unwrap().to_string_lossy().replace('\\', "/");
        Source { path, documented, lines: text.lines().map(str::to_owned).collect() }
    };
    files.into_iter().map(source).collect()
}

fn sources() -> Vec<Source> {
    [CORE, SERVICE].into_iter().flat_map(sources_of).collect()
}

/// Fails with every offence, one a line.
#[track_caller]
fn none(offences: Vec<String>) {
    let mut text = String::new();
    for offence in &offences {
        writeln!(text, "  {offence}").unwrap();
    }
    assert!(offences.is_empty(), "\n{text}");
}

/// The rooms that a line uses: after `crate::` or `landmarkd_core::`, or the first names inside `crate::{…}`.
fn rooms_used(line: &str) -> Vec<&str> {
    let mut rooms = Vec::new();
    let paths = ["crate::", "landmarkd_core::"];
    for (path, at) in paths.iter().flat_map(|path| line.match_indices(path).map(move |(at, _)| (path, at))) {
        let rest = &line[at + path.len()..];
        match rest.strip_prefix('{') {
            None => rooms.push(rest),
            Some(list) => {
                let mut depth = 0;
                for part in list.split(',') {
                    if depth == 0 {
                        rooms.push(part.trim());
                    }
                    depth += part.matches('{').count() as i64 - part.matches('}').count() as i64;
                }
            }
        }
    }
    let name = |text: &str| text.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(text.len());
    rooms.into_iter().map(|text| &text[..name(text)]).filter(|room| !room.is_empty()).collect()
}

#[test]
fn rooms_use_only_the_rooms_that_the_arrows_allow() {
    let mut offences = Vec::new();
    for source in sources() {
        let room = source.room();
        if WIRING.contains(&room) {
            continue;
        }
        let Some((_, allowed)) = ARROWS.iter().find(|(name, _)| *name == room) else {
            offences.push(format!("{}: the room {room} has no arrows: give it some", source.path));
            continue;
        };
        for (at, line) in source.lines.iter().enumerate() {
            for used in rooms_used(line).into_iter().filter(|used| *used != room && !allowed.contains(used)) {
                offences.push(format!("{}:{}: {room} uses {used}: {}", source.path, at + 1, line.trim()));
            }
        }
    }
    none(offences);
}

#[test]
fn each_outside_crate_has_one_door() {
    let mut offences = Vec::new();
    for (folder, doors) in [(CORE, CORE_DOORS), (SERVICE, SERVICE_DOORS)] {
        let sources = sources_of(folder);
        for &(word, places) in doors {
            for source in sources.iter().filter(|source| !source.is_in(places)) {
                let found =
                    source.mentions(word).filter(|_| word != "crate::store" || source.room() != "store");
                offences.extend(
                    found.map(|(at, line)| format!("{}:{at}: {word} has no door here: {line}", source.path)),
                );
            }
            let is_used =
                sources.iter().any(|source| source.is_in(places) && source.mentions(word).next().is_some());
            if !is_used {
                offences.push(format!("nothing uses {word} at {places:?}: take it out of the table"));
            }
        }
    }
    none(offences);
}

#[test]
fn the_middle_of_the_house_waits_for_nothing_and_touches_nothing() {
    let mut offences = Vec::new();
    for source in sources_of(CORE) {
        for word in IMPURE {
            let found = source.mentions(word);
            offences
                .extend(found.map(|(at, line)| format!("{}:{at}: {word} in the core: {line}", source.path)));
        }
    }
    none(offences);
}

#[test]
fn what_the_house_does_without_stands_nowhere() {
    let mut offences = Vec::new();
    for source in sources() {
        for word in NOWHERE {
            offences.extend(
                source.mentions(word).map(|(at, line)| format!("{}:{at}: {word}: {line}", source.path)),
            );
        }
        if source.path.contains("utils") {
            offences.push(format!("{}: a file is one noun of the field, not utils", source.path));
        }
    }
    none(offences);
}

#[test]
fn every_file_says_what_it_holds() {
    let files = sources().into_iter().filter(|source| !source.documented);
    none(files.map(|source| format!("{}:1: the first line is no `//!`", source.path)).collect());
}

#[test]
fn names_in_comments_and_texts_do_not_count_and_parts_of_names_neither() {
    let text = "let a = \"sqlx \\\" sqlx\"; // sqlx\nlet c = '\"'; sqlx::query(r#\"sqlx \" \"#) /* sqlx\n */ + my_sqlx";
    let blank = blanked(text);
    assert_eq!(blank.lines().count(), 3);
    let lines: Vec<bool> = blank.lines().map(|line| stands_in("sqlx", line)).collect();
    assert_eq!(lines, [false, true, false], "{blank}");
    assert!(!stands_in("image::", "use super::image::Image;") && stands_in("image::", "use image::codecs;"));
    assert!(stands_in("crate::store", "pub use crate::store::{A};"));
}

#[test]
fn the_rooms_of_a_line_are_found_in_lists_too() {
    assert_eq!(rooms_used("use crate::http::{self, Service};"), ["http"]);
    assert_eq!(rooms_used("use crate::{imaging, vision::{a, b}, eigen};"), ["imaging", "vision", "eigen"]);
    assert_eq!(rooms_used("let x: crate::compute::Lane = crate::store::y();"), ["compute", "store"]);
}
