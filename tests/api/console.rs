//! The console is in the binary, asks no key for its own files, and nothing from anywhere else.

use axum::body::Body;
use axum::http::Method;

use crate::app::{App, request};

/// The text of a page that is there.
async fn page(app: &App, path: &str) -> String {
    let answer = app.get(path).await;
    assert_eq!(answer.status, 200, "{path}");
    String::from_utf8(answer.body.to_vec()).unwrap()
}

/// Every file that the first page leads to, from page to page.
async fn files(app: &App) -> Vec<(String, String)> {
    let mut found = vec![("/".to_owned(), page(app, "/").await)];
    let mut at = 0;
    while at < found.len() {
        let text = found[at].1.clone();
        let quoted = text.split(['"', '\'']).skip(1).step_by(2);
        for name in quoted.filter_map(|word| word.strip_prefix("./").or(word.strip_prefix("console/"))) {
            let path = format!("/console/{name}");
            if name.contains('.') && !found.iter().any(|(known, _)| *known == path) {
                found.push((path.clone(), page(app, &path).await));
            }
        }
        at += 1;
    }
    found
}

#[tokio::test(flavor = "multi_thread")]
async fn every_file_of_the_console_is_served_and_together_they_are_small() {
    let app = App::start().await;
    let files = files(&app).await;
    assert!(files.len() > 10, "{:?}", files.iter().map(|(path, _)| path).collect::<Vec<_>>());
    let bytes: usize = files.iter().map(|(_, text)| text.len()).sum();
    // What is loaded at first is held to 300 kB in a browser.
    assert!(bytes <= 400_000, "{bytes} bytes");
}

#[tokio::test(flavor = "multi_thread")]
async fn no_file_of_the_console_names_another_host() {
    let app = App::start().await;
    for (path, text) in files(&app).await {
        let hosts = text
            .split("://")
            .skip(1)
            .map(|rest| rest.split(['/', '"', '`', ' ', '\'']).next().unwrap_or_default());
        // Names of XML, and what a person is told to type.
        let foreign: Vec<&str> = hosts.filter(|host| !["www.w3.org", "…"].contains(host)).collect();
        assert!(foreign.is_empty(), "{path}: {foreign:?}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn pages_may_load_what_is_their_own_and_nothing_else() {
    let app = App::start().await;
    for path in ["/", "/console/app.js", "/problems/not_trained"] {
        let response = app.get(path).await;
        let policy = response.header("content-security-policy");
        assert!(policy.starts_with("default-src 'none'") && !policy.contains("unsafe"), "{policy}");
        assert_eq!(response.header("x-content-type-options"), "nosniff");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn pages_need_no_key_where_every_call_does() {
    let mut app = App::start().await;
    app.close().await;
    app.use_key(None);
    for path in ["/", "/console/app.js", "/problems/key_required", "/docs/", "/openapi.json"] {
        page(&app, path).await;
    }
    app.get("/v1/info").await.expect_problem(401, "key_required");
}

#[tokio::test(flavor = "multi_thread")]
async fn who_has_a_file_is_told_so() {
    let app = App::start().await;
    let first = app.get("/console/app.js").await;
    assert_eq!(first.header("cache-control"), "no-cache");
    let known = request(Method::GET, "/console/app.js").header("if-none-match", first.header("etag"));
    let again = app.send(known.body(Body::empty()).unwrap()).await;
    assert_eq!((again.status, again.body.len()), (304, 0));
}

#[tokio::test(flavor = "multi_thread")]
async fn what_the_console_lacks_is_a_problem_whose_type_leads_to_a_page() {
    let app = App::start().await;
    for path in
        ["/console/nothing.js", "/console/../Cargo.toml", "/console/%2e%2e/Cargo.toml", "/problems/nothing"]
    {
        let problem = app.get(path).await.expect_problem(404, "unknown_route");
        assert_eq!(problem["type"], "/problems/unknown_route");
    }
    let text = page(&app, "/problems/unknown_route").await;
    assert!(
        text.contains("There is nothing at this address") && text.contains("<code>/docs</code>"),
        "{text}"
    );
}

#[tokio::test(flavor = "multi_thread")]
async fn every_kind_of_problem_has_a_page_that_says_what_to_do() {
    let app = App::start().await;
    for code in landmarkd::problem::Code::ALL {
        let text = page(&app, &format!("/problems/{}", code.word())).await;
        assert!(text.contains(code.word()) && text.contains("What to do"), "{}: {text}", code.word());
        assert!(!text.contains("<key>"), "what looks like an element is text");
    }
}
