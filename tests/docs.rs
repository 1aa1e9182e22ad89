//! What the pages say about the code is there: problem codes, settings, files, tests, links.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use landmarkd::problem::Code;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: impl AsRef<Path>) -> String {
    let path = root().join(path);
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Every file with this ending below a folder.
fn files_below(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let paths = entries.map(|entry| entry.expect("the folder is listed").path());
    paths
        .flat_map(|path| match path.is_dir() {
            true => files_below(&path, ending),
            false => Vec::from_iter(path.extension().is_some_and(|found| found == ending).then_some(path)),
        })
        .collect()
}

/// The cells of the rows of the one table of a page that has this head, without head and rule.
fn table(page: &str, head: &[&str]) -> Vec<Vec<String>> {
    let cells = |line: &str| -> Vec<String> {
        let inner = line.trim().trim_start_matches('|').trim_end_matches('|');
        inner.split(" | ").map(|cell| cell.trim().to_owned()).collect()
    };
    let text = read(page);
    let mut lines = text.lines().skip_while(|line| !line.starts_with('|') || cells(line) != head);
    assert!(lines.next().is_some(), "{page} has no table {head:?}");
    lines.skip(1).take_while(|line| line.starts_with('|')).map(cells).collect()
}

/// What stands between backquotes.
fn code_spans(text: &str) -> impl Iterator<Item = &str> {
    text.split('`').skip(1).step_by(2)
}

#[test]
fn every_problem_code_stands_in_the_table_with_its_status_and_advice_and_no_other() {
    let table = table("docs/operating.md", &["code", "status", "what to do"]);
    let written: BTreeSet<(String, u16, String)> = table
        .iter()
        .map(|row| {
            let status = row[1].parse().expect("a status is a number");
            (row[0].trim_matches('`').to_owned(), status, row[2].clone())
        })
        .collect();
    let known: BTreeSet<(String, u16, String)> = Code::ALL
        .iter()
        .map(|code| (code.word().to_owned(), code.status(), code.advice().to_owned()))
        .collect();
    let differing: Vec<_> = written.symmetric_difference(&known).collect();
    assert!(differing.is_empty(), "in the table or in the code, not in both: {differing:?}");
    assert_eq!(written.len(), table.len(), "each code stands once");
    assert!(table.iter().all(|row| row.len() == 3 && row[2].ends_with('.')), "each says what to do");
}

#[test]
fn every_setting_stands_in_the_table_and_no_other() {
    let sources = read("src/config.rs") + &read("src/main.rs");
    let known: BTreeSet<&str> =
        sources.split("env = \"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
    assert!(known.contains("LANDMARKD_BIND"), "settings are found by their attribute");
    let table = table("docs/operating.md", &["flag", "environment", "default", "range", "what"]);
    let written: BTreeSet<&str> = table.iter().map(|row| row[1].trim_matches('`')).collect();
    let differing: Vec<_> = written.symmetric_difference(&known).collect();
    assert!(differing.is_empty(), "in the table or in the code, not in both: {differing:?}");
    for row in &table {
        let flag = row[0].trim_matches('`').trim_start_matches("--").replace('-', "_").to_uppercase();
        assert_eq!(row[1], format!("`LANDMARKD_{flag}`"), "flag and variable have one name");
    }
}

#[test]
fn every_file_of_the_map_is_there() {
    let page = read("ARCHITECTURE.md");
    let map = page.split("## Map").nth(1).and_then(|rest| rest.split("```").nth(1)).expect("there is a map");
    let mut above: Vec<&str> = Vec::new();
    let mut named = BTreeSet::new();
    for line in map.lines().skip(1) {
        let name = line.split_whitespace().next().expect("no line of the map is empty");
        let depth = (line.len() - line.trim_start().len()) / 2;
        above.truncate(depth);
        assert_eq!(above.len(), depth, "{line:?} is indented by two a folder");
        let path = above.concat() + name;
        let there = root().join(&path);
        assert!(if name.ends_with('/') { there.is_dir() } else { there.is_file() }, "{path} isn't there");
        named.insert(path);
        above.push(name);
    }
    let rooms = fs::read_dir(root().join("src")).expect("src is there").map(|entry| {
        let entry = entry.expect("src is listed");
        let slash = if entry.path().is_dir() { "/" } else { "" };
        format!("src/{}{slash}", entry.file_name().to_string_lossy())
    });
    let missing: Vec<String> = rooms.filter(|room| !named.contains(room)).collect();
    assert!(missing.is_empty(), "the map lacks {missing:?}");
}

#[test]
fn every_test_that_the_ledgers_name_is_there() {
    let files =
        ["src", "crates", "tests"].into_iter().flat_map(|folder| files_below(&root().join(folder), "rs"));
    let mut tests = BTreeSet::new();
    for file in files {
        let text = read(file);
        let mut marked = false;
        for line in text.lines().map(str::trim) {
            if line == "#[test]" || line.starts_with("#[tokio::test") {
                marked = true;
            } else if let Some(rest) = line.strip_prefix("async fn ").or(line.strip_prefix("fn ")) {
                if marked {
                    tests.insert(rest.split('(').next().unwrap_or_default().to_owned());
                }
                marked = false;
            }
        }
    }
    let ledger: [&str; 5] = ["where", "what the text says", "wrong or open", "what is done", "shown by"];
    for (page, head, from_end) in
        [("docs/papers.md", &ledger[..], 1), ("docs/reliability.md", &["promise", "test", "figure"][..], 2)]
    {
        let rows = table(page, head);
        let named: Vec<&str> = rows.iter().flat_map(|row| code_spans(&row[row.len() - from_end])).collect();
        assert!(named.len() >= rows.len(), "{page} names its tests");
        let is_there = |name: &str| match name.contains('/') {
            true => root().join(name.split(' ').next().unwrap_or_default()).exists(),
            false => tests.contains(name),
        };
        let missing: Vec<&str> = named.into_iter().filter(|name| !is_there(name)).collect();
        assert!(missing.is_empty(), "{page}: no such tests or files: {missing:?}");
    }
}

#[test]
fn every_file_that_the_ledger_names_is_there() {
    let page = read("docs/papers.md");
    let paths = code_spans(&page).filter(|span| span.ends_with(".rs"));
    let missing: Vec<&str> = paths
        .filter(|path| {
            ["", "src", "crates/landmarkd-core/src"]
                .iter()
                .all(|house| !root().join(house).join(path).is_file())
        })
        .collect();
    assert!(missing.is_empty(), "no such files: {missing:?}");
}

#[test]
fn relative_links_lead_somewhere() {
    let pages = [
        "README.md",
        "ARCHITECTURE.md",
        "CHANGELOG.md",
        "CONTRIBUTING.md",
        "SECURITY.md",
        "clients/README.md",
        "clients/python/README.md",
        "clients/ros2/landmarkd_ros/README.md",
        "clients/vda5050/README.md",
        "docs/bags.md",
        "docs/choosing.md",
        "docs/data.md",
        "docs/limits.md",
        "docs/operating.md",
        "docs/papers.md",
        "docs/reliability.md",
        "docs/robots.md",
        "docs/threat-model.md",
    ];
    for page in pages {
        let text = read(page);
        let links = text.split("](").skip(1).filter_map(|rest| rest.split([')', '#']).next());
        let folder = root().join(page).parent().expect("a page stands in a folder").to_owned();
        let broken: Vec<&str> =
            links.filter(|link| !link.contains("://") && !folder.join(link).exists()).collect();
        assert!(broken.is_empty(), "{page} links to {broken:?}");
    }
}

#[test]
fn the_changelog_counts_the_packages() {
    let packages = read("Cargo.lock").lines().filter(|line| *line == "[[package]]").count();
    let counted = format!("{packages} packages in `Cargo.lock`");
    assert!(read("CHANGELOG.md").contains(&counted), "CHANGELOG.md should say: {counted}");
}
