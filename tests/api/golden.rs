//! Artifacts and answers of the release before (`tests/golden`): they stay readable, and stay what they are.
//!
//! Each database of [`DATABASES`] was trained by that release on pictures drawn here. The file `<name>.artifact` is its
//! version 1, `<name>.json` the version and the answers to drawn frames. `vectors` names the widest vectors of the machine
//! that made them: on one that has the same, all is compared bit for bit; elsewhere sums have another order, and
//! what was asked and decided is compared within [`TOLERANCE`]. Only with an intended change of what
//! is learned are the files made anew: `LANDMARKD_GOLDEN_WRITE=1 cargo test --test api golden`.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::{env, fs};

use bytes::Bytes;
use serde_json::{Value, json};

use crate::app::{App, tar};
use crate::pictures::{Thing, png, scene_png, thing};

/// Side of a picture of the objects, in pixels.
const VIEW_PX: usize = 24;

/// A database whose answers are kept.
struct Database {
    name: &'static str,
    kind: &'static str,
    /// Of the database, as JSON: few points and short vectors, so that the file is small.
    options: &'static str,
}

const DATABASES: [Database; 4] = [
    Database {
        name: "placement",
        kind: "landmarks",
        options: r#"{"method": "placement", "interest_points": 8, "query_points": 12, "subwindow_radius_px": [6, 10],
            "rings": 4, "sectors": 16, "dimension": 6}"#,
    },
    Database {
        name: "upright",
        kind: "landmarks",
        options: r#"{"viewpoint": "upright", "interest_points": 8, "query_points": 12, "dimension": 6,
            "position_prior_px": 20}"#,
    },
    Database {
        name: "paper",
        kind: "landmarks",
        options: r#"{"method": "paper", "interest_points": 8, "query_points": 12, "rings": 4, "sectors": 16,
            "dimension": 6}"#,
    },
    Database {
        name: "objects",
        kind: "objects",
        options: r#"{"appearance": "intensity", "dimension": 6, "distance": "mahalanobis"}"#,
    },
];

/// The members of an answer that another run need not repeat.
const PASSING: [&str; 2] = ["timings_ms", "created_at"];

/// How far numbers may differ where vectors are of another width: confidences, pixels, degrees.
const TOLERANCE: f64 = 1e-2;
/// The members of a version that say what was asked for and of what.
const ASKED: [&str; 3] = ["version", "options", "counts"];
/// The members of an answer that are its decision.
const DECIDED: [&str; 5] = ["database", "kind", "decision", "instances", "pose"];

/// The widest vectors of this machine.
fn vectors() -> &'static str {
    #[cfg(target_arch = "x86_64")]
    {
        if is_x86_feature_detected!("avx512f") {
            return "avx512f";
        } else if is_x86_feature_detected!("avx2") {
            return "avx2";
        }
    }
    env::consts::ARCH
}

/// Whether this machine's vectors are those of the machine that made the files.
fn same_vectors() -> bool {
    fs::read_to_string(golden("vectors")).unwrap().trim() == vectors()
}

fn golden(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(file)
}

impl Database {
    fn file(&self, ending: &str) -> PathBuf {
        golden(&format!("{}.{ending}", self.name))
    }

    /// The training pictures: paths in an archive, and files.
    fn exemplars(&self) -> Vec<(String, Bytes)> {
        if self.kind == "landmarks" {
            return (1..=4).map(|n| (format!("place-{n}/a.png"), scene_png(n))).collect();
        }
        let views = [("bar", Thing::Bar), ("wedge", Thing::Wedge)].into_iter().flat_map(|(label, which)| {
            (0..8).map(move |n| {
                let turn_deg = 45.0 * f64::from(n);
                (format!("{label}/view__{turn_deg}.png"), png(&thing(which, turn_deg, VIEW_PX)))
            })
        });
        views.collect()
    }

    /// The frames asked: known ones, then one that is not.
    fn frames(&self) -> Vec<Bytes> {
        match self.kind {
            "landmarks" => [1, 3, 4, 99].map(scene_png).to_vec(),
            _ => [(Thing::Bar, 20.0), (Thing::Wedge, 200.0), (Thing::Wedge, 45.0), (Thing::Ring, 0.0)]
                .map(|(which, turn_deg)| png(&thing(which, turn_deg, VIEW_PX)))
                .to_vec(),
        }
    }

    async fn create(&self, app: &App) {
        let options: Value = serde_json::from_str(self.options).unwrap();
        let body = json!({"kind": self.kind, "options": options});
        app.put(&format!("/v1/databases/{}", self.name), body).await.expect(201);
    }

    /// Version 1 with its digest, report and options, and its answers to the frames; with the evidence, but of `upright`,
    /// whose points are a grid over the frame, for the last frame alone.
    async fn answers(&self, app: &App) -> Value {
        let version = app.get(&format!("/v1/databases/{}/versions/1", self.name)).await.expect(200);
        let mut answers = Vec::new();
        let frames = self.frames();
        let last = frames.len() - 1;
        for (n, frame) in frames.into_iter().enumerate() {
            let query = format!("?version=1&explain={}", self.name != "upright" || n == last);
            answers.push(app.recognise(self.name, &query, frame).await);
        }
        lasting(json!({"version": version, "answers": answers}))
    }

    fn kept_answers(&self) -> Value {
        serde_json::from_slice(&fs::read(self.file("json")).unwrap()).unwrap()
    }
}

/// A value without the members that another run need not repeat.
fn lasting(value: Value) -> Value {
    match value {
        Value::Object(members) => {
            let kept = members.into_iter().filter(|(name, _)| !PASSING.contains(&name.as_str()));
            kept.map(|(name, member)| (name, lasting(member))).collect()
        }
        Value::Array(items) => items.into_iter().map(lasting).collect(),
        other => other,
    }
}

/// What a version was asked for, and what its answers decide; without the evidence.
fn decided(answers: &Value) -> Value {
    let members = |of: &Value, names: &[&str]| {
        names.iter().map(|name| ((*name).to_owned(), of[*name].clone())).collect()
    };
    let version: Value = members(&answers["version"], &ASKED);
    let mut decisions: Vec<Value> =
        answers["answers"].as_array().unwrap().iter().map(|answer| members(answer, &DECIDED)).collect();
    // Counts of points, which a rounding error may move.
    for instance in decisions.iter_mut().filter_map(|answer| answer["instances"].as_array_mut()).flatten() {
        if let Some(placement) = instance["placement"].as_object_mut() {
            placement.remove("inliers");
        }
    }
    json!({"version": version, "answers": decisions})
}

/// The answers are those of the file: what they decide, and bit for bit where vectors are as wide.
#[track_caller]
fn assert_kept(database: &Database, now: &Value) {
    let kept = database.kept_answers();
    assert_same(&decided(&kept), &decided(now), TOLERANCE, database.name);
    if same_vectors() {
        assert_same(&kept, now, 0.0, database.name);
    }
}

/// Fails with the first member that differs, by its path: a fractional number by more than the tolerance, anything else
/// at all.
#[track_caller]
fn assert_same(kept: &Value, now: &Value, tolerance: f64, path: &str) {
    match (kept, now) {
        (Value::Object(a), Value::Object(b)) => {
            let names =
                |members: &serde_json::Map<_, _>| members.keys().cloned().collect::<BTreeSet<String>>();
            // later releases add members
            assert!(names(a).is_subset(&names(b)), "members of {path}: {:?} and {:?}", names(a), names(b));
            a.iter().for_each(|(name, member)| {
                assert_same(member, &b[name], tolerance, &format!("{path}/{name}"))
            });
        }
        (Value::Array(a), Value::Array(b)) => {
            assert_eq!(a.len(), b.len(), "items of {path}");
            a.iter()
                .zip(b)
                .enumerate()
                .for_each(|(n, (a, b))| assert_same(a, b, tolerance, &format!("{path}/{n}")));
        }
        (Value::Number(a), Value::Number(b)) if tolerance > 0.0 && a.is_f64() && b.is_f64() => {
            let apart = (a.as_f64().unwrap() - b.as_f64().unwrap()).abs();
            assert!(apart <= tolerance, "{path}: {a} and {b}");
        }
        _ => assert_eq!(kept, now, "{path}"),
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn artifacts_of_the_release_before_answer_as_they_did() {
    let app = App::start().await;
    for database in &DATABASES {
        database.create(&app).await;
        let path = format!("/v1/databases/{}/versions", database.name);
        let artifact = fs::read(database.file("artifact")).unwrap();
        app.post_bytes(&path, "application/octet-stream", artifact).await.expect(201);
        let (kept, now) = (database.kept_answers(), database.answers(&app).await);
        assert_eq!(kept["version"]["digest"], now["version"]["digest"], "{}", database.name);
        assert_kept(database, &now);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn the_same_pictures_train_to_the_artifacts_of_the_release_before() {
    let app = App::start().await;
    for database in &DATABASES {
        database.create(&app).await;
        let base = format!("/v1/databases/{}", database.name);
        let archive = tar(&database.exemplars()).await;
        let batch = app.post_bytes(&format!("{base}/exemplars:batch"), "application/x-tar", archive).await;
        assert_eq!(batch.expect(200)["created"], database.exemplars().len());
        app.train(database.name, json!({})).await;
        let answers = database.answers(&app).await;
        let artifact = app.get(&format!("{base}/versions/1/artifact")).await.body;
        if env::var_os("LANDMARKD_GOLDEN_WRITE").is_some() {
            fs::write(database.file("artifact"), &artifact).unwrap();
            fs::write(database.file("json"), format!("{answers:#}\n")).unwrap();
            fs::write(golden("vectors"), format!("{}\n", vectors())).unwrap();
        }
        assert_kept(database, &answers);
        if same_vectors() {
            assert!(
                artifact == fs::read(database.file("artifact")).unwrap(),
                "{}: other bytes",
                database.name
            );
        }
    }
}
