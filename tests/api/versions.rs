//! Versions never change; aliases move between them; both say who answered.

use axum::body::Body;
use axum::http::{Method, header};
use serde_json::{Value, json};

use crate::app::{App, request, with_json};
use crate::pictures::{Numbers, scene_png};

/// Versions 1 (two places) and 2 (three places); `current` points to 2.
async fn two_versions(app: &App) {
    app.trained("lab", 2).await;
    app.add("lab", "place-3", 3).await;
    assert_eq!(app.train("lab", json!({})).await["version"], 2);
}

async fn answering(app: &App, query: &str) -> i64 {
    app.recognise("lab", query, scene_png(1)).await["version"].as_i64().unwrap()
}

async fn digest(app: &App, database: &str, version: i64) -> String {
    let version = app.get(&format!("/v1/databases/{database}/versions/{version}")).await.expect(200);
    version["digest"].as_str().unwrap().to_owned()
}

#[tokio::test(flavor = "multi_thread")]
async fn the_same_inputs_give_the_same_digest_in_whatever_order_they_came() {
    let app = App::start().await;
    for (database, order) in [("one", [1, 2, 3]), ("other", [3, 1, 2])] {
        app.create(database).await;
        for number in order {
            app.add(database, &format!("place-{number}"), number).await;
        }
        assert_eq!(app.train(database, json!({})).await["version"], 1);
    }
    assert_eq!(digest(&app, "one", 1).await, digest(&app, "other", 1).await);
    let of = async |database: &str| app.recognise(database, "?explain=true", scene_png(2)).await;
    let (one, other) = (of("one").await, of("other").await);
    assert_eq!((&one["votes"], &one["points"]), (&other["votes"], &other["points"]));
}

#[tokio::test(flavor = "multi_thread")]
async fn training_the_same_again_succeeds_with_the_version_that_is_there() {
    let app = App::start().await;
    app.trained("lab", 2).await;
    assert_eq!(app.train("lab", json!({})).await["version"], 1);
    assert_eq!(app.train("lab", json!({"options": {"interest_points": 8}})).await["version"], 2);
    // The first inputs again: no third version, and `current` goes back to the first.
    assert_eq!(app.train("lab", json!({})).await["version"], 1);
    let versions = app.get("/v1/databases/lab/versions").await.expect(200);
    assert_eq!(versions["items"].as_array().unwrap().len(), 2);
    assert_eq!(answering(&app, "").await, 1);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_second_training_makes_version_two_and_moves_current_unless_it_must_not() {
    let app = App::start().await;
    app.trained("lab", 2).await;
    assert_eq!(answering(&app, "").await, 1);
    app.add("lab", "place-3", 3).await;
    assert_eq!(app.train("lab", json!({"promote": "never"})).await["version"], 2);
    assert_eq!(answering(&app, "").await, 1);
    assert_eq!(answering(&app, "?alias=current").await, 1);
    assert_eq!(answering(&app, "?version=2").await, 2);
    app.add("lab", "place-4", 4).await;
    assert_eq!(app.train("lab", json!({"promote": "always"})).await["version"], 3);
    assert_eq!(answering(&app, "").await, 3);
    let database = app.get("/v1/databases/lab").await.expect(200);
    assert_eq!((&database["current_version"], &database["versions"]), (&json!(3), &json!(3)));
}

#[tokio::test(flavor = "multi_thread")]
async fn a_first_training_with_promote_never_leaves_nothing_current() {
    let app = App::start().await;
    app.create("lab").await;
    app.add("lab", "cup", 1).await;
    app.add("lab", "can", 2).await;
    app.train("lab", json!({"promote": "never"})).await;
    app.post_png("/v1/databases/lab/recognitions", scene_png(1)).await.expect_problem(409, "no_current");
    assert_eq!(answering(&app, "?version=1").await, 1);
}

#[tokio::test(flavor = "multi_thread")]
async fn whoever_reads_of_a_success_is_answered_by_the_new_version() {
    let app = App::start().await;
    app.trained("lab", 4).await;
    for (round, version) in (2..=12).zip(2_i64..) {
        let options = json!({"options": {"interest_points": 16 + round}});
        let job = app.post("/v1/databases/lab/trainings", options).await.expect(202);
        let path = format!("/v1/jobs/{}", job["id"].as_str().unwrap());
        // Without a pause, so that the success is read as early as it can be.
        while app.get(&path).await.expect(200)["state"] != "succeeded" {}
        assert_eq!(answering(&app, "").await, version);
        // Back to a version that is there already: the same promise.
        let job = app.post("/v1/databases/lab/trainings", json!({})).await.expect(202);
        let path = format!("/v1/jobs/{}", job["id"].as_str().unwrap());
        while app.get(&path).await.expect(200)["state"] != "succeeded" {}
        assert_eq!(answering(&app, "").await, 1);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn an_answer_names_the_version_and_digest_that_gave_it() {
    let app = App::start().await;
    two_versions(&app).await;
    for (query, version) in [("", 2), ("?version=1", 1), ("?version=2", 2), ("?alias=current", 2)] {
        let answer = app.recognise("lab", query, scene_png(1)).await;
        assert_eq!(answer["version"], version, "{query}");
        assert_eq!(answer["digest"], digest(&app, "lab", version).await, "{query}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn rolling_back_is_pointing_current_to_an_older_version() {
    let app = App::start().await;
    two_versions(&app).await;
    let current = "/v1/databases/lab/aliases/current";
    let before = app.get(current).await;
    assert_eq!(before.expect(200)["version"], 2);
    let etag = before.header("etag").to_owned();

    let put = async |etag: &str, version: i64| {
        let asked = request(Method::PUT, current).header(header::IF_MATCH, etag);
        app.send(with_json(asked, &json!({"version": version}))).await
    };
    assert_eq!(put(&etag, 1).await.expect(200)["version"], 1);
    assert_eq!(answering(&app, "").await, 1, "the answer to the call is the moment it is served");
    // Somebody who still thinks that 2 is current is told.
    put(&etag, 2).await.expect_problem(412, "precondition_failed");
    assert_eq!(answering(&app, "").await, 1);
    let etag = app.get(current).await.header("etag").to_owned();
    // A weak tag never matches a change; of several, any may be the one.
    put(&format!("W/{etag}"), 2).await.expect_problem(412, "precondition_failed");
    put("\"one\"", 2).await.expect_problem(412, "precondition_failed");
    assert_eq!(put(&format!("\"one\", {etag}"), 2).await.expect(200)["version"], 2);
    assert_eq!(answering(&app, "").await, 2);
}

#[tokio::test(flavor = "multi_thread")]
async fn aliases_are_made_listed_and_removed() {
    let app = App::start().await;
    two_versions(&app).await;
    let stable = "/v1/databases/lab/aliases/stable";
    app.put(stable, json!({"version": 1})).await.expect(201);
    app.put(stable, json!({"version": 1})).await.expect(200);
    assert_eq!(answering(&app, "?alias=stable").await, 1);
    let aliases = app.get("/v1/databases/lab/aliases").await.expect(200);
    let named: Vec<_> =
        aliases["items"].as_array().unwrap().iter().map(|a| (&a["alias"], &a["version"])).collect();
    assert_eq!(named, [(&json!("current"), &json!(2)), (&json!("stable"), &json!(1))]);
    let only_new = request(Method::PUT, stable).header(header::IF_NONE_MATCH, "*");
    app.send(with_json(only_new, &json!({"version": 2}))).await.expect_problem(412, "precondition_failed");
    app.delete(stable).await.expect(204);
    app.delete(stable).await.expect_problem(404, "unknown_alias");
    let asked = "/v1/databases/lab/recognitions?alias=stable";
    app.post_png(asked, scene_png(1)).await.expect_problem(404, "unknown_alias");
    app.put(stable, json!({"version": 9})).await.expect_problem(404, "unknown_version");
}

#[tokio::test(flavor = "multi_thread")]
async fn without_current_the_versions_of_a_database_answer_by_number() {
    let app = App::start().await;
    app.create("lab").await;
    app.post_png("/v1/databases/lab/recognitions", scene_png(1)).await.expect_problem(409, "not_trained");
    app.add("lab", "cup", 1).await;
    app.add("lab", "can", 2).await;
    app.train("lab", json!({})).await;
    app.delete("/v1/databases/lab/aliases/current").await.expect(204);
    app.post_png("/v1/databases/lab/recognitions", scene_png(1)).await.expect_problem(409, "no_current");
    assert_eq!(answering(&app, "?version=1").await, 1);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_version_that_an_alias_names_is_not_deleted() {
    let app = App::start().await;
    two_versions(&app).await;
    app.delete("/v1/databases/lab/versions/2").await.expect_problem(409, "version_in_use");
    app.put("/v1/databases/lab/aliases/current", json!({"version": 1})).await.expect(200);
    assert_eq!(answering(&app, "?version=2").await, 2, "loaded, so that forgetting shows");
    app.delete("/v1/databases/lab/versions/2").await.expect(204);
    app.delete("/v1/databases/lab/versions/2").await.expect_problem(404, "unknown_version");
    let asked = "/v1/databases/lab/recognitions?version=2";
    app.post_png(asked, scene_png(1)).await.expect_problem(404, "unknown_version");
    // The number is never given again.
    app.train("lab", json!({"promote": "never"})).await;
    let versions = app.get("/v1/databases/lab/versions").await.expect(200);
    let numbers: Vec<_> = versions["items"].as_array().unwrap().iter().map(|v| &v["version"]).collect();
    assert_eq!(numbers, [&json!(1), &json!(3)]);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_version_tells_its_options_counts_and_report() {
    let app = App::start().await;
    app.create("lab").await;
    for number in 1..=3 {
        app.add("lab", if number == 3 { "can" } else { "cup" }, number).await;
    }
    let options = json!({"interest_points": 5, "dimension": 4, "taper": "literal", "colour": "gray"});
    app.train("lab", json!({"options": options})).await;
    let version = app.get("/v1/databases/lab/versions/1").await.expect(200);
    let options = &version["options"];
    assert_eq!(
        (&options["interest_points"], &options["dimension"], &options["taper"]),
        (&json!(5), &json!(4), &json!("literal"))
    );
    assert_eq!(options["rings"], 4, "what the training didn't name is the database's");
    let database = app.get("/v1/databases/lab").await.expect(200);
    assert_eq!(database["options"]["interest_points"], 16, "the database's own options stay");
    let counts = &version["counts"];
    assert_eq!((&counts["exemplars"], &counts["labels"]), (&json!(3), &json!(2)));
    assert!((1..=15).contains(&counts["interest_points"].as_u64().unwrap()), "{counts}");
    let report = &version["report"];
    // 4 rings, and of 16 sectors the half of the spectrum that isn't a mirror image, with its ends.
    assert_eq!((&report["dimension"], &report["signature_length"]), (&json!(4), &json!(4 * 9)));
    assert_eq!(report["colour"], "gray");
    let spectrum: Vec<f64> =
        report["spectrum"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
    assert!(spectrum.is_sorted_by(|a, b| a >= b) && spectrum[0] > 0.0, "{spectrum:?}");
    let energy = spectrum[..4].iter().sum::<f64>() / spectrum.iter().sum::<f64>();
    assert!((report["energy_kept"].as_f64().unwrap() - energy).abs() < 1e-6, "{report:#}");
    assert_eq!(report["exemplars_without_points"], json!([]));
    assert!(report["timings_ms"]["describe"].as_f64().unwrap() > 0.0);
}

/// The artifact file of version 1 of `lab`, with its ETag.
async fn artifact(app: &App) -> (Vec<u8>, String) {
    let answer = app.get("/v1/databases/lab/versions/1/artifact").await;
    assert_eq!(answer.status, 200, "{answer:?}");
    (answer.body.to_vec(), answer.header("etag").to_owned())
}

const FILE: &str = "application/octet-stream";

#[tokio::test(flavor = "multi_thread")]
async fn an_artifact_is_downloaded_once_and_then_known() {
    let app = App::start().await;
    app.trained("lab", 2).await;
    let (file, etag) = artifact(&app).await;
    assert!(etag.starts_with('"') && etag.ends_with('"'), "{etag}");
    let described = app.get("/v1/databases/lab/versions/1").await.expect(200);
    assert_eq!(described["artifact_bytes"], file.len());
    let path = "/v1/databases/lab/versions/1/artifact";
    for (have, status) in
        [(etag.as_str(), 304), (&format!("\"x\", W/{etag}"), 304), ("*", 304), ("\"x\"", 200)]
    {
        let asked = request(Method::GET, path).header(header::IF_NONE_MATCH, have);
        let answer = app.send(asked.body(Body::empty()).unwrap()).await;
        assert_eq!((answer.status, answer.header("etag")), (status, etag.as_str()), "{have}");
        assert_eq!(answer.body.is_empty(), status == 304);
    }
}

fn without(mut version: Value, members: &[&str]) -> Value {
    members.iter().for_each(|member| drop(version.as_object_mut().unwrap().remove(*member)));
    version
}

#[tokio::test(flavor = "multi_thread")]
async fn an_artifact_taken_in_elsewhere_answers_as_the_original() {
    let home = App::start().await;
    home.trained("lab", 3).await;
    let (file, etag) = artifact(&home).await;

    let away = App::start().await;
    away.create("copy").await;
    let path = "/v1/databases/copy/versions";
    let taken = away.post_bytes(path, FILE, file.clone()).await.expect(201);
    assert_eq!(taken["version"], 1);
    let again = away.post_bytes(path, FILE, file.clone()).await.expect(200);
    assert_eq!(taken, again, "the same digest is the same version");

    let original = home.get("/v1/databases/lab/versions/1").await.expect(200);
    // Timings, and where descriptions came from, stay where the training was.
    let (mut original, mut taken) = (without(original, &["created_at"]), without(taken, &["created_at"]));
    for version in [&mut original, &mut taken] {
        for member in ["timings_ms", "descriptions"] {
            version["report"].as_object_mut().unwrap().remove(member).unwrap();
        }
    }
    assert_eq!(original, taken);
    let copied = away.get("/v1/databases/copy/versions/1/artifact").await;
    assert_eq!((copied.header("etag"), copied.body.as_ref()), (etag.as_str(), file.as_slice()));

    // Taking in moves no alias; pointing `current` to it does.
    away.post_png("/v1/databases/copy/recognitions", scene_png(1)).await.expect_problem(409, "no_current");
    away.put("/v1/databases/copy/aliases/current", json!({"version": 1})).await.expect(201);
    let at_home = home.recognise("lab", "?explain=true", scene_png(2)).await;
    let abroad = away.recognise("copy", "?explain=true", scene_png(2)).await;
    for member in ["digest", "votes", "points", "decision"] {
        assert_eq!(at_home[member], abroad[member], "{member}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_damaged_artifact_is_refused_with_what_is_wrong() {
    let app = App::start().await;
    app.trained("lab", 2).await;
    let (file, _) = artifact(&app).await;
    app.create("copy").await;
    let path = "/v1/databases/copy/versions";
    let mut numbers = Numbers::seeded(7);
    for _ in 0..40 {
        let at = numbers.below(file.len() as u64) as usize;
        let mut damaged = file.clone();
        damaged[at] ^= 1 << numbers.below(8);
        let problem = app.post_bytes(path, FILE, damaged).await.expect_problem(422, "invalid_artifact");
        assert!(problem["detail"].as_str().unwrap().len() > 20, "byte {at}: {problem:#}");
    }
    for length in [0, 1, 8, 100, file.len() / 2, file.len() - 1] {
        let cut = file[..length].to_vec();
        app.post_bytes(path, FILE, cut).await.expect_problem(422, "invalid_artifact");
    }
    app.post_bytes(path, FILE, [file.as_slice(), b"x"].concat())
        .await
        .expect_problem(422, "invalid_artifact");
    let versions = app.get(path).await.expect(200);
    assert_eq!(versions["items"], json!([]));
}

#[tokio::test(flavor = "multi_thread")]
async fn a_database_made_anew_under_an_old_name_never_answers_with_the_old_one() {
    let app = App::start().await;
    app.trained("lab", 2).await;
    let old = app.recognise("lab", "?version=1", scene_png(1)).await;
    app.delete("/v1/databases/lab").await.expect(204);
    app.post_png("/v1/databases/lab/recognitions", scene_png(1))
        .await
        .expect_problem(404, "unknown_database");
    app.create("lab").await;
    app.post_png("/v1/databases/lab/recognitions", scene_png(1)).await.expect_problem(409, "not_trained");
    app.add("lab", "elsewhere", 5).await;
    app.add("lab", "nowhere", 6).await;
    app.train("lab", json!({})).await;
    for query in ["", "?version=1"] {
        let new = app.recognise("lab", query, scene_png(5)).await;
        assert_eq!((&new["version"], &new["votes"][0]["label"]), (&json!(1), &json!("elsewhere")));
        assert_ne!(new["digest"], old["digest"]);
    }
}
