//! Free-form input: whatever bytes or text come, the answer is a document and never a 5xx. [`App`] checks both.

use axum::body::Body;
use axum::http::{Method, Request, Uri};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};

use crate::app::{App, form, form_type, request, tar, with_bytes};
use crate::pictures::scene_png;

/// Many cases; failures are told, not written to files.
fn cases(cases: u32) -> TestRunner {
    TestRunner::new(Config { cases, failure_persistence: None, ..Config::default() })
}

async fn lab() -> App {
    let app = App::start().await;
    app.trained("lab", 2).await;
    app
}

/// Text percent-encoded wherever it isn't a plain letter or digit.
fn encoded(bytes: &[u8]) -> String {
    let plain = |byte: &u8| byte.is_ascii_alphanumeric() || b"-_.~".contains(byte);
    bytes
        .iter()
        .map(|byte| if plain(byte) { char::from(*byte).into() } else { format!("%{byte:02X}") })
        .collect()
}

const ROUTES: [(&str, &str); 18] = [
    ("GET", "/v1/databases/{}"),
    ("PUT", "/v1/databases/{}"),
    ("DELETE", "/v1/databases/{}"),
    ("GET", "/v1/databases/{}/exemplars"),
    ("POST", "/v1/databases/{}/exemplars?label=cup"),
    ("POST", "/v1/databases/{}/trainings"),
    ("POST", "/v1/databases/{}/recognitions"),
    ("GET", "/v1/databases/lab/exemplars/{}"),
    ("GET", "/v1/databases/lab/exemplars/{}/image"),
    ("DELETE", "/v1/databases/lab/exemplars/{}"),
    ("GET", "/v1/databases/lab/versions/{}"),
    ("GET", "/v1/databases/lab/versions/{}/artifact"),
    ("DELETE", "/v1/databases/lab/versions/{}"),
    ("GET", "/v1/databases/lab/aliases/{}"),
    ("DELETE", "/v1/databases/lab/aliases/{}"),
    ("GET", "/v1/jobs/{}"),
    ("GET", "/v1/jobs/{}/events"),
    ("DELETE", "/{}"),
];

/// Text of several kinds: anything, nearly names, numbers, and what has broken others before.
fn text() -> impl Strategy<Value = Vec<u8>> {
    prop_oneof![
        vec(any::<u8>(), 0..80),
        "[A-Za-z0-9_.-]{0,70}".prop_map(String::into_bytes),
        any::<i64>().prop_map(|number| number.to_string().into_bytes()),
        any::<f64>().prop_map(|number| number.to_string().into_bytes()),
        Just(b"' OR 1=1 --".to_vec()),
        Just(b"../../etc/passwd".to_vec()),
        Just(b"\0".to_vec()),
        Just("\u{202e}\u{feff}😀".into()),
    ]
}

#[tokio::test(flavor = "multi_thread")]
async fn whatever_stands_in_a_path_is_answered() {
    let app = lab().await;
    let strategy = (0..ROUTES.len(), text());
    let run = cases(400).run(&strategy, |(route, text)| {
        let (method, path) = ROUTES[route];
        let path = path.replace("{}", &encoded(&text));
        prop_assume!(path.parse::<Uri>().is_ok() && text != b"lab" && text != b"current");
        let asked = request(Method::from_bytes(method.as_bytes()).unwrap(), &path);
        app.now(app.send(asked.body(Body::empty()).unwrap()));
        Ok(())
    });
    run.unwrap();
    app.get("/v1/databases/lab").await.expect(200);
}

#[tokio::test(flavor = "multi_thread")]
async fn whatever_stands_in_a_query_is_answered() {
    let app = lab().await;
    let paths = ["/v1/databases", "/v1/databases/lab/exemplars", "/v1/databases/lab/versions", "/v1/jobs"];
    let names = [
        "limit", "cursor", "label", "robot_id", "database", "state", "alias", "version", "top", "explain",
        "pose_deg",
    ];
    let pairs = vec((0..names.len(), text()), 0..4);
    let run = cases(400).run(&(0..paths.len() + 2, pairs), |(path, pairs)| {
        let pairs = pairs.iter().map(|(name, value)| format!("{}={}", names[*name], encoded(value)));
        let query = pairs.collect::<Vec<_>>().join("&");
        let asked = match paths.get(path) {
            Some(path) => request(Method::GET, &format!("{path}?{query}")).body(Body::empty()).unwrap(),
            None => {
                let call = if path == paths.len() { "recognitions" } else { "exemplars" };
                let asked = request(Method::POST, &format!("/v1/databases/lab/{call}?{query}"));
                with_bytes(asked, "image/png", scene_png(1))
            }
        };
        app.now(app.send(asked));
        Ok(())
    });
    run.unwrap();
}

#[tokio::test(flavor = "multi_thread")]
async fn whatever_stands_in_a_header_is_answered() {
    let app = lab().await;
    let names =
        ["x-robot-id", "x-frame-id", "x-stamp", "x-request-id", "traceparent", "accept", "content-type"];
    let value = vec(prop_oneof![32_u8..=126, 128_u8..=255, Just(b'\t')], 0..200);
    let run = cases(300).run(&(0..names.len(), value), |(name, value)| {
        let asked = Request::post("/v1/databases/lab/recognitions").header(names[name], value);
        app.now(app.send(asked.body(Body::from(scene_png(1))).unwrap()));
        Ok(())
    });
    run.unwrap();
}

/// Bytes of a well-formed file with some of them changed, some lost and some added.
fn mutilated(file: Vec<u8>) -> impl Strategy<Value = Vec<u8>> {
    let length = file.len();
    let changes = vec((0..length, any::<u8>()), 0..6);
    let cut = prop_oneof![3 => Just((0, 0)), 1 => (0..length, 1..length)];
    (changes, cut, vec(any::<u8>(), 0..20)).prop_map(move |(changes, (from, count), tail)| {
        let mut bytes = file.clone();
        changes.into_iter().for_each(|(at, value)| bytes[at] = value);
        bytes.drain(from..(from + count).min(length));
        bytes.extend(tail);
        bytes
    })
}

fn any_or_mutilated(file: Vec<u8>) -> impl Strategy<Value = Vec<u8>> {
    prop_oneof![1 => vec(any::<u8>(), 0..600), 4 => mutilated(file)]
}

/// Post bytes of a type to an address, many times.
fn bombard(app: &App, path: &str, media_type: &str, bytes: impl Strategy<Value = Vec<u8>>, count: u32) {
    let run = cases(count).run(&bytes, |bytes| {
        app.now(app.post_bytes(path, media_type, bytes));
        Ok(())
    });
    run.unwrap();
}

#[tokio::test(flavor = "multi_thread")]
async fn whatever_comes_as_an_archive_is_answered() {
    let app = lab().await;
    let archive = tar(&[("cup/a.png", scene_png(5)), ("can/b__12.png", scene_png(6))]).await;
    // Damage in the headers is what a reader of archives stumbles over.
    let headers = archive[..512].to_vec();
    let path = "/v1/databases/lab/exemplars:batch";
    bombard(&app, path, "application/x-tar", any_or_mutilated(archive.to_vec()), 150);
    let damaged_header =
        mutilated(headers).prop_map(move |header| [header.as_slice(), &archive[512..]].concat());
    bombard(&app, path, "application/x-tar", damaged_header, 150);
}

#[tokio::test(flavor = "multi_thread")]
async fn whatever_comes_as_a_form_is_answered() {
    let app = lab().await;
    let parts = [("manifest", br#"[{"file":"a","label":"cup"}]"#.to_vec()), ("a", scene_png(5).to_vec())];
    let batch = form(&parts).to_vec();
    let frames = form(&[("image", scene_png(1)), ("image", scene_png(2))]).to_vec();
    bombard(&app, "/v1/databases/lab/exemplars:batch", &form_type(), any_or_mutilated(batch), 200);
    bombard(
        &app,
        "/v1/databases/lab/recognitions:batch",
        &form_type(),
        any_or_mutilated(frames.clone()),
        150,
    );
    bombard(&app, "/v1/databases/lab/recognitions", &form_type(), any_or_mutilated(frames), 100);
}

#[tokio::test(flavor = "multi_thread")]
async fn whatever_comes_as_a_manifest_is_answered() {
    let app = lab().await;
    let manifest = br#"[{"file":"a","label":"cup","pose_deg":12.5},{"file":"b","label":"can"}]"#.to_vec();
    let forms = any_or_mutilated(manifest).prop_map(|manifest| form(&[("manifest", manifest)]).to_vec());
    bombard(&app, "/v1/databases/lab/exemplars:batch", &form_type(), forms, 300);
}

#[tokio::test(flavor = "multi_thread")]
async fn whatever_comes_as_an_artifact_is_answered_and_none_is_taken_for_whole() {
    let app = lab().await;
    let file = app.get("/v1/databases/lab/versions/1/artifact").await.body.to_vec();
    app.create("copy").await;
    bombard(&app, "/v1/databases/copy/versions", "application/octet-stream", any_or_mutilated(file), 300);
    // An untouched copy is the only one that may have got in.
    let original = app.get("/v1/databases/lab/versions/1").await.expect(200);
    for version in app.get("/v1/databases/copy/versions").await.expect(200)["items"].as_array().unwrap() {
        assert_eq!(version["digest"], original["digest"]);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn whatever_comes_as_a_picture_is_answered() {
    let app = lab().await;
    let small = crate::pictures::scene(1);
    let files =
        [crate::pictures::png(&small), crate::pictures::jpeg(&small), b"P6 2 2 255 abcdefghijkl"[..].into()];
    for file in files {
        let path = "/v1/databases/lab/recognitions";
        bombard(&app, path, "application/octet-stream", any_or_mutilated(file.to_vec()), 120);
    }
}

/// JSON values of every shape, a few levels deep.
fn json_value() -> impl Strategy<Value = serde_json::Value> {
    let leaf = prop_oneof![
        Just(serde_json::Value::Null),
        any::<bool>().prop_map(Into::into),
        any::<i64>().prop_map(Into::into),
        any::<f64>().prop_map(Into::into),
        ".{0,12}".prop_map(Into::into),
    ];
    let names = "[a-z_]{0,8}|options|kind|version|promote|rings|sectors|dimension|epsilon|taper|landmarks";
    leaf.prop_recursive(3, 24, 5, move |inner| {
        prop_oneof![
            vec(inner.clone(), 0..4).prop_map(Into::into),
            vec((names, inner), 0..4).prop_map(|members| members.into_iter().collect()),
        ]
    })
}

#[tokio::test(flavor = "multi_thread")]
async fn whatever_comes_as_json_is_answered() {
    let app = lab().await;
    let calls = [
        (Method::PUT, "/v1/databases/new"),
        (Method::PUT, "/v1/databases/lab/aliases/new"),
        (Method::POST, "/v1/databases/new/trainings"),
    ];
    let options = [
        "rings",
        "sectors",
        "dimension",
        "epsilon",
        "subwindow_radius_px",
        "interest_points",
        "neighbours",
        "method",
        "viewpoint",
        "operator",
        "position_prior_px",
    ];
    let one_option = (0..options.len(), prop_oneof![any::<i64>().prop_map(|n| n.into()), json_value()])
        .prop_map(
            move |(name, value)| serde_json::json!({"kind": "landmarks", "options": {options[name]: value}}),
        );
    let bodies = prop_oneof![
        json_value().prop_map(|value| value.to_string().into_bytes()),
        one_option.prop_map(|value| value.to_string().into_bytes()),
        any_or_mutilated(br#"{"kind":"landmarks","options":{"rings":4,"epsilon":0.5}}"#.to_vec()),
    ];
    let run = cases(400).run(&(0..calls.len(), bodies), |(call, body)| {
        let (method, path) = calls[call].clone();
        app.now(app.send(with_bytes(request(method, path), "application/json", body)));
        Ok(())
    });
    run.unwrap();
}
