//! Keys: nothing is open by accident, a key does what its scope says and no more, and a revoked one does nothing.

use std::path::Path;
use std::process::Output;
use std::sync::atomic::{AtomicUsize, Ordering};

use axum::body::Body;
use axum::http::{Method, header};
use futures_util::future::join_all;
use landmarkd::compute::Lane;
use landmarkd::http::openapi;
use serde_json::{Value, json};

use crate::app::{Answer, App, Occupied, pointers, request, with_bytes};
use crate::pictures::scene_png;
use crate::process::{Process, landmarkd};
use crate::waits::until;

const SCOPES: [&str; 4] = ["recognise", "contribute", "train", "admin"];

/// Every call of the contract: method, path with its parameters filled in, and the scope that it names.
fn calls() -> Vec<(Method, String, Option<String>)> {
    let document: Value = serde_json::from_str(&openapi::text()).unwrap();
    let mut calls = Vec::new();
    for (route, item) in document["paths"].as_object().unwrap() {
        let mut path = route.clone();
        for (name, value) in [
            ("{database}", "lab"),
            ("{id}", "00000000-0000-4000-8000-000000000000"),
            ("{version}", "1"),
            ("{alias}", "current"),
            ("{name}", "bench"),
            ("{track}", "00000000-0000-4000-8000-000000000000"),
            ("{image}", "1"),
        ] {
            path = path.replace(name, value);
        }
        assert!(!path.contains('{'), "a parameter has no value here: {path}");
        if path == "/v1/events" {
            // who may follow them would get no end
            path.push_str("?kind=none");
        }
        for (method, operation) in item.as_object().unwrap() {
            let Ok(method) = Method::from_bytes(method.to_uppercase().as_bytes()) else { continue };
            let security = operation["security"].as_array();
            let one = security.unwrap_or_else(|| panic!("{method} {route} says nothing of keys")).first();
            let scope = one.unwrap()["key"][0].as_str().map(str::to_owned);
            calls.push((method, path.clone(), scope));
        }
    }
    assert!(calls.len() > 50, "{} calls", calls.len());
    calls
}

async fn ask(app: &App, method: &Method, path: &str) -> Answer {
    app.send_expecting_5xx(request(method.clone(), path).body(Body::empty()).unwrap()).await
}

/// A service with a key of scope admin, which every request sends.
async fn closed() -> App {
    let mut app = App::start().await;
    app.close().await;
    app
}

#[tokio::test(flavor = "multi_thread")]
async fn without_a_key_every_call_of_the_contract_is_refused_but_health() {
    let mut app = closed().await;
    app.trained("lab", 1).await;
    app.use_key(None);
    let mut open = Vec::new();
    let odd = [
        (Method::GET, "/v1/nothing"),
        (Method::PATCH, "/v1/databases"),
        (Method::OPTIONS, "/v1/info"),
        (Method::POST, "/"),
    ];
    let odd = odd.map(|(method, path)| (method, path.to_owned(), None));
    for (method, path, _) in calls().into_iter().chain(odd) {
        if path == "/readyz" {
            assert_eq!(app.readiness().await.0, 200);
            continue;
        }
        let answer = ask(&app, &method, &path).await;
        if answer.status == 401 {
            answer.expect_problem(401, "key_required");
            assert_eq!(answer.header("www-authenticate"), "Bearer realm=\"landmarkd\"");
        } else {
            open.push(format!("{method} {path}"));
        }
    }
    assert_eq!(open, ["GET /livez", "GET /v2/health/live", "GET /v2/health/ready"], "and /readyz");
    // The answer to HEAD has no body, so what every answer promises isn't asked of it.
    let asked = request(Method::HEAD, "/v1/info").body(Body::empty()).unwrap();
    assert_eq!(app.send_as_it_is(asked).await.status, 401);
    let wrong = format!("lmk_{}_{}", "0".repeat(16), "0".repeat(64));
    for value in ["Bearer", "Bearer ", "Basic YTpi", "lmk_x", &format!("Bearer {wrong}"), "Bearer ü"] {
        let asked = request(Method::GET, "/v1/info").header(header::AUTHORIZATION, value);
        app.send(asked.body(Body::empty()).unwrap()).await.expect_problem(401, "key_required");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_key_may_do_what_its_scope_includes_and_nothing_else() {
    let mut app = closed().await;
    let mut keys = Vec::new();
    for scope in SCOPES {
        keys.push(app.make_key(json!({"name": scope, "scope": scope})).await.0);
    }
    for (rank, key) in keys.iter().enumerate() {
        app.use_key(Some(key));
        for (method, path, scope) in calls() {
            if path == "/readyz" {
                continue;
            }
            let needed = scope.map_or(0, |scope| SCOPES.iter().position(|word| *word == scope).unwrap());
            let answer = ask(&app, &method, &path).await;
            if needed > rank {
                answer.expect_problem(403, "not_allowed");
            } else {
                assert!(!matches!(answer.status, 401 | 403), "{} may: {answer:?}", SCOPES[rank]);
            }
        }
        // What isn't there, or isn't in the contract, tells nobody more than it must.
        assert_eq!(ask(&app, &Method::GET, "/v1/nothing").await.status, 404);
        for page in ["/docs/", "/openapi.json"] {
            let asked = request(Method::GET, page).body(Body::empty()).unwrap();
            assert_eq!(app.send_as_it_is(asked).await.status, 200, "{page}");
        }
        let patched = ask(&app, &Method::PATCH, "/v1/databases").await.status;
        assert_eq!(patched, if rank == 3 { 405 } else { 403 });
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_key_for_some_databases_reaches_no_other() {
    let mut app = closed().await;
    for database in ["floor-1", "floor-2", "cellar"] {
        app.trained(database, 1).await;
    }
    app.put("/v1/databases/parts", json!({"kind": "objects"})).await.expect(201);
    let bench = json!({
        "database": "parts",
        "correspondences": [{"image_px": [0, 0], "robot_mm": [0, 0]}, {"image_px": [100, 0], "robot_mm": [50, 0]}],
    });
    app.put("/v1/workcells/bench", bench.clone()).await.expect(201);
    let (floors, _) =
        app.make_key(json!({"name": "floors", "scope": "admin", "databases": ["floor-?", "new*"]})).await;
    app.use_key(Some(&floors));
    app.recognise("floor-1", "", scene_png(1)).await;
    let refused = |answer: Answer| drop(answer.expect_problem(403, "not_allowed"));
    refused(app.post_png("/v1/databases/cellar/recognitions", scene_png(1)).await);
    // The name counts as it is meant, not as it is written.
    app.post_png("/v1/databases/%66loor-1/recognitions", scene_png(1)).await.expect(200);
    refused(app.post_png("/v1/databases/%63ellar/recognitions", scene_png(1)).await);
    refused(app.put("/v1/databases/attic", json!({"kind": "landmarks"})).await);
    app.put("/v1/databases/new-wing", json!({"kind": "landmarks"})).await.expect(201);
    refused(app.delete("/v1/databases/cellar").await);
    refused(app.get("/v1/workcells/bench").await);
    refused(app.put("/v1/workcells/other", bench.clone()).await);
    app.put("/v1/databases/new-parts", json!({"kind": "objects"})).await.expect(201);
    let mut of_its_own = bench;
    of_its_own["database"] = json!("new-parts");
    refused(app.put("/v1/workcells/bench", of_its_own.clone()).await);
    app.put("/v1/workcells/new-bench", of_its_own).await.expect(201);
    refused(app.delete("/v1/workcells/bench").await);
    refused(app.get("/v1/keys").await);
    refused(app.post("/v1/keys", json!({"name": "more", "scope": "admin"})).await);
    refused(app.get("/v1/audit").await);
    let listed = app.get("/v1/databases").await.expect(200);
    let names: Vec<_> = listed["items"].as_array().unwrap().iter().map(|item| &item["name"]).collect();
    assert_eq!(names, ["floor-1", "floor-2", "new-parts", "new-wing"]);
    let benches = app.get("/v1/workcells").await.expect(200);
    assert_eq!(
        (benches["items"].as_array().unwrap().len(), &benches["items"][0]["name"]),
        (1, &json!("new-bench"))
    );
    let served = app.get("/v1/info").await.expect(200);
    assert!(!served.to_string().contains("cellar"), "{served:#}");
    let jobs = app.get("/v1/jobs").await.expect(200);
    assert_eq!(jobs["items"].as_array().unwrap().len(), 2, "{jobs:#}");
    let pages = app.get("/v1/databases?limit=1").await.expect(200);
    assert_eq!((&pages["items"], &pages["next_cursor"]), (&json!([]), &json!("cellar")));
}

#[tokio::test(flavor = "multi_thread")]
async fn a_job_of_another_database_is_neither_seen_nor_cancelled() {
    let mut app = closed().await;
    app.trained("cellar", 1).await;
    let job = app.get("/v1/jobs").await.expect(200)["items"][0]["id"].as_str().unwrap().to_owned();
    let (floors, _) = app.make_key(json!({"name": "f", "scope": "train", "databases": ["floor-*"]})).await;
    app.use_key(Some(&floors));
    for (method, path) in [
        (Method::GET, format!("/v1/jobs/{job}")),
        (Method::GET, format!("/v1/jobs/{job}/events")),
        (Method::DELETE, format!("/v1/jobs/{job}")),
    ] {
        ask(&app, &method, &path).await.expect_problem(403, "not_allowed");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_revoked_key_is_refused_at_once_and_the_service_stays_closed() {
    let mut app = closed().await;
    let (robot, id) = app.make_key(json!({"name": "robot 7", "scope": "recognise"})).await;
    app.use_key(Some(&robot));
    app.get("/v1/info").await.expect(200);
    app.use_key(None);
    let (admin, admin_id) = {
        app.get("/v1/info").await.expect_problem(401, "key_required");
        // Made at the command line, as somebody would who has lost the first one.
        let made = keys(app.folder(), &["create", "--name", "second", "--scope", "admin"]);
        let key = String::from_utf8(made.stdout).unwrap().trim().to_owned();
        (key.clone(), key.split('_').nth(1).unwrap().to_owned())
    };
    app.use_key(Some(&admin));
    until("a key made beside the service is taken", async || app.get("/v1/info").await.status == 200).await;
    let listed = app.get("/v1/keys").await.expect(200);
    let used = listed["items"].as_array().unwrap().iter().find(|key| key["id"] == id.as_str()).unwrap();
    assert!(used["last_used_at"].is_string() && used["revoked_at"].is_null(), "{used:#}");
    assert!(!listed.to_string().contains(&robot[21..]), "a list shows a secret");
    app.delete(&format!("/v1/keys/{id}")).await.expect(204);
    // Once more is no harm.
    app.delete(&format!("/v1/keys/{id}")).await.expect(204);
    app.delete("/v1/keys/nobody").await.expect_problem(404, "unknown_key");
    app.use_key(Some(&robot));
    app.get("/v1/info").await.expect_problem(401, "key_required");
    app.use_key(Some(&admin));
    assert!(app.get(&format!("/v1/keys/{id}")).await.expect(200)["revoked_at"].is_string());
    let keys = app.get("/v1/keys?limit=1").await.expect(200);
    let next = keys["next_cursor"].as_str().unwrap();
    let rest = app.get(&format!("/v1/keys?cursor={next}")).await.expect(200);
    for key in keys["items"].as_array().unwrap().iter().chain(rest["items"].as_array().unwrap()) {
        if key["id"] != admin_id.as_str() {
            app.delete(&format!("/v1/keys/{}", key["id"].as_str().unwrap())).await.expect(204);
        }
    }
    app.delete(&format!("/v1/keys/{admin_id}")).await.expect(204);
    app.get("/v1/info").await.expect_problem(401, "key_required");
    app.use_key(None);
    app.get("/v1/info").await.expect_problem(401, "key_required");
    let folder = app.stop();
    let app = App::open(folder, |_| ()).await;
    app.get("/v1/info").await.expect_problem(401, "key_required");
}

#[tokio::test(flavor = "multi_thread")]
async fn who_follows_a_job_is_cut_off_when_the_key_is_revoked() {
    let mut app = App::start_idle().await;
    app.close().await;
    app.create("lab").await;
    app.add("lab", "cup", 1).await;
    let job = app.post("/v1/databases/lab/trainings", json!({})).await.expect(202);
    app.leave_jobs();
    let (robot, id) = app.make_key(json!({"name": "robot 7", "scope": "recognise"})).await;
    let path = format!("/v1/jobs/{}/events", job["id"].as_str().unwrap());
    let asked = request(Method::GET, &path).header(header::AUTHORIZATION, format!("Bearer {robot}"));
    // The job is queued and stays so: its stream would last for ever.
    let following = app.send(asked.body(Body::empty()).unwrap());
    let revoking = async {
        let path = format!("/v1/keys/{id}");
        let is_used = async || app.get(&path).await.expect(200)["last_used_at"].is_string();
        until("the key is used", is_used).await;
        app.delete(&path).await.expect(204);
    };
    let (followed, ()) = tokio::join!(following, revoking);
    assert_eq!(followed.status, 200);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_key_is_used_as_often_as_it_may_be_and_others_are_not_held_up() {
    let mut app = closed().await;
    let (slow, _) = app.make_key(json!({"name": "slow", "scope": "recognise", "requests_per_s": 5})).await;
    let (free, _) = app.make_key(json!({"name": "free", "scope": "recognise"})).await;
    app.use_key(Some(&slow));
    let mut statuses = Vec::new();
    for _ in 0..12 {
        let answer = app.get("/v1/databases").await;
        if answer.status == 429 {
            answer.expect_problem(429, "rate_limited");
        }
        statuses.push(answer.status);
    }
    // Five at once; while these were asked, one or more may have been earned again.
    assert_eq!(statuses[..5], [200; 5], "{statuses:?}");
    assert!(statuses[5..].contains(&429), "{statuses:?}");
    app.use_key(Some(&free));
    for _ in 0..12 {
        app.get("/v1/databases").await.expect(200);
    }
    app.use_key(Some(&slow));
    until("a request is earned again", async || app.get("/v1/databases").await.status == 200).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_key_that_makes_no_sense_is_refused_with_what_is_wrong() {
    let app = closed().await;
    for (body, at) in [
        (json!({"name": " ", "scope": "admin"}), "/name"),
        (json!({"name": "a\u{7}b", "scope": "admin"}), "/name"),
        (json!({"name": "x".repeat(200), "scope": "admin"}), "/name"),
        (json!({"name": "r", "scope": "admin", "requests_per_s": 0}), "/requests_per_s"),
        (json!({"name": "r", "scope": "root"}), "/scope"),
        (json!({"name": "r", "scope": "admin", "expires": 3}), ""),
    ] {
        let problem = app.post("/v1/keys", body.clone()).await.expect_problem(422, "invalid_field");
        assert!(pointers(&problem)[0].starts_with(at), "{body}: {problem:#}");
    }
    for databases in [json!([]), json!(["***"]), json!(vec!["a"; 65])] {
        let body = json!({"name": "r", "scope": "recognise", "databases": databases});
        let problem = app.post("/v1/keys", body).await.expect_problem(422, "invalid_field");
        assert_eq!(pointers(&problem), ["/databases"]);
    }
    let made = app.get("/v1/keys").await.expect(200);
    assert_eq!(made["items"].as_array().unwrap().len(), 1, "none was made");
}

/// Run `landmarkd keys …` on a folder.
fn keys(folder: &Path, arguments: &[&str]) -> Output {
    let done = landmarkd().arg("keys").args(arguments).arg("--data-dir").arg(folder).output().unwrap();
    assert!(done.status.success(), "{done:?}");
    done
}

#[tokio::test(flavor = "multi_thread")]
async fn other_machines_are_let_in_only_where_a_key_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let serve = |extra: &[&str]| {
        let mut command = landmarkd();
        command.args(["serve", "--bind", "0.0.0.0:0", "--data-dir"]).arg(folder.path()).args(extra);
        command
    };
    let refused = serve(&[]).output().unwrap();
    let said = String::from_utf8_lossy(&refused.stderr);
    assert!(!refused.status.success());
    for advice in ["landmarkd keys create", "127.0.0.1", "--insecure"] {
        assert!(said.contains(advice), "{said}");
    }
    let made = keys(folder.path(), &["create", "--name", "operator", "--scope", "admin"]);
    let key = String::from_utf8(made.stdout).unwrap();
    let key = key.trim();
    // The later flag wins over the one of the test's own.
    let process = Process::start_with(folder.path(), |command| {
        command.args(["--bind", "0.0.0.0:0"]);
    });
    let url = process.url.replace("0.0.0.0", "127.0.0.1");
    rustls::crypto::ring::default_provider().install_default().ok();
    let client = reqwest::Client::new();
    let info = async |key: Option<&str>| {
        let asked = client.get(format!("{url}/v1/info"));
        let asked = key.into_iter().fold(asked, |asked, key| asked.bearer_auth(key));
        asked.send().await.unwrap().status().as_u16()
    };
    assert_eq!((info(None).await, info(Some(key)).await), (401, 200));
    let listed = keys(folder.path(), &["list", "--json"]);
    let listed: Value = serde_json::from_slice(&listed.stdout).unwrap();
    assert_eq!((&listed[0]["name"], &listed[0]["scope"]), (&json!("operator"), &json!("admin")));
    let id = listed[0]["id"].as_str().unwrap();
    keys(folder.path(), &["revoke", id]);
    until("a key revoked beside the service is refused", async || info(Some(key)).await == 401).await;
    let text = String::from_utf8(keys(folder.path(), &["list"]).stdout).unwrap();
    assert!(text.contains(id) && text.contains("revoked"), "{text}");
    let (_, log) = process.terminate();
    // The secret is kept nowhere: neither in the log nor in any file.
    let secret = key.rsplit('_').next().unwrap();
    assert!(log.iter().all(|line| !line.contains(secret)));
    for file in std::fs::read_dir(folder.path()).unwrap().map(Result::unwrap) {
        if file.path().is_file() {
            let bytes = std::fs::read(file.path()).unwrap();
            let held = bytes.windows(secret.len()).any(|bytes| bytes == secret.as_bytes());
            assert!(!held, "{} holds a key", file.path().display());
        }
    }
    // With no key in force it doesn't start again for other machines.
    assert!(!serve(&[]).output().unwrap().status.success());
}

#[test]
fn the_verb_says_what_is_wrong() {
    let folder = tempfile::tempdir().unwrap();
    let fails = |arguments: &[&str], says: &str| {
        let done = landmarkd().arg("keys").args(arguments).arg("--data-dir").arg(folder.path()).output();
        let done = done.unwrap();
        let said = String::from_utf8_lossy(&done.stderr).into_owned();
        assert!(!done.status.success() && said.contains(says), "{arguments:?}: {said}");
    };
    fails(&["revoke", "nobody"], "is no data folder");
    fails(&["create", "--name", "", "--scope", "admin"], "name must be");
    fails(&["create", "--name", "r", "--scope", "root"], "recognise");
    fails(&["create", "--name", "r", "--scope", "admin", "--requests-per-s", "0"], "requests_per_s must be");
    // The folder is there now: a grant that is wrong was refused after it was made.
    fails(&["revoke", "nobody"], "there is no key nobody");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_key_that_floods_the_service_does_not_lock_another_out() {
    let mut app = App::start_with(|settings| {
        settings.threads = 1;
        settings.limits.waiting_per_thread = 8;
    })
    .await;
    app.trained("lab", 2).await;
    app.close().await;
    let (flood, _) = app.make_key(json!({"name": "flood", "scope": "recognise"})).await;
    let (steady, _) = app.make_key(json!({"name": "steady", "scope": "recognise"})).await;
    let ask = |key: &str| {
        let asked = request(Method::POST, "/v1/databases/lab/recognitions")
            .header(header::AUTHORIZATION, format!("Bearer {key}"));
        app.send_expecting_5xx(with_bytes(asked, "image/png", scene_png(1)))
    };
    let occupied = Occupied::lane(&app, Lane::Recognition).await;
    let refused = AtomicUsize::new(0);
    let flooding = join_all((0..20).map(async |_| {
        let answer = ask(&flood).await;
        refused.fetch_add(usize::from(answer.status == 503), Ordering::Relaxed);
        answer
    }));
    let others = async {
        until("eight wait", async || app.service.compute.waiting(Lane::Recognition) == 8).await;
        // The queue is full of the other's; two of them give way.
        let asked = join_all([ask(&steady), ask(&steady)]);
        let releasing = async {
            // Twelve found the queue full.
            until("two gave way", async || refused.load(Ordering::Relaxed) == 14).await;
            drop(occupied);
        };
        tokio::join!(asked, releasing).0
    };
    let (flooding, others) = tokio::join!(flooding, others);
    assert!(others.iter().all(|answer| answer.status == 200), "{others:?}");
    let served = flooding.iter().filter(|answer| answer.status == 200).count();
    assert_eq!(served, 6, "of eight that waited two gave way");
    for answer in flooding.iter().filter(|answer| answer.status != 200) {
        answer.expect_problem(503, "overloaded");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn without_keys_no_page_of_another_site_is_let_in_and_nobody_makes_the_first_key() {
    let mut app = App::start().await;
    app.create("lab").await;
    let ask = async |app: &App, headers: &[(&str, &str)]| {
        let asked = headers
            .iter()
            .fold(request(Method::GET, "/v1/databases"), |asked, (name, value)| asked.header(*name, *value));
        app.send(asked.body(Body::empty()).unwrap()).await.status
    };
    let here = "127.0.0.1:8080";
    for (headers, status) in [
        (&[("host", here)][..], 200),
        (&[("host", "localhost:8080")], 200),
        (&[("host", "[::1]:8080")], 200),
        (&[("host", here), ("origin", "http://127.0.0.1:8080")], 200),
        (&[("host", here), ("origin", "https://elsewhere.example")], 403),
        (&[("host", here), ("origin", "http://127.0.0.1:9")], 403),
        (&[("host", here), ("origin", "null")], 403),
        // Its own name, leading here.
        (&[("host", "elsewhere.example:8080")], 403),
        (&[("host", "elsewhere.example:8080"), ("origin", "http://elsewhere.example:8080")], 403),
    ] {
        assert_eq!(ask(&app, headers).await, status, "{headers:?}");
    }
    let first = json!({"name": "mine", "scope": "admin"});
    let problem = app.post("/v1/keys", first).await.expect_problem(403, "not_allowed");
    assert!(problem["detail"].as_str().unwrap().contains("landmarkd keys create"), "{problem}");
    // Where the operator lets everybody in, a name is as good as an address; a page of another site isn't.
    let open = App::start_with(|settings| settings.insecure = true).await;
    assert_eq!(ask(&open, &[("host", "landmarkd:8080")]).await, 200);
    assert_eq!(ask(&open, &[("host", here), ("origin", "https://elsewhere.example")]).await, 403);
    // A key speaks for itself.
    app.close().await;
    assert_eq!(ask(&app, &[("host", "robots.example"), ("origin", "https://console.example")]).await, 200);
}
