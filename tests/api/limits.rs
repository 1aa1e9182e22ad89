//! Limits: too much is refused quickly, and what is refused never takes the rest down.

use std::time::Duration;

use axum::body::Body;
use axum::http::Method;
use bytes::Bytes;
use futures_util::future::join_all;
use landmarkd::compute::Lane;

use crate::app::{App, Occupied, form, form_type, in_pieces, request, tar, with_bytes};
use crate::pictures::{jpeg, png, scene, scene_png};
use crate::waits::until;

#[tokio::test(flavor = "multi_thread")]
async fn too_much_load_is_refused_at_once_with_a_time_to_come_back() {
    let app = App::start_with(|settings| {
        settings.threads = 1;
        settings.limits.waiting_per_thread = 2;
    })
    .await;
    app.trained("lab", 2).await;
    let occupied = Occupied::lane(&app, Lane::Recognition).await;
    let ask =
        || with_bytes(request(Method::POST, "/v1/databases/lab/recognitions"), "image/png", scene_png(1));
    let crowd = join_all((0..10).map(|_| app.send_expecting_5xx(ask())));
    let watch = async {
        until("two wait", async || app.service.compute.waiting(Lane::Recognition) == 2).await;
        // The pool is full and stays so until the release: neither answer waits for it.
        app.get("/livez").await.expect(200);
        let refused = app.send_expecting_5xx(ask()).await;
        refused.expect_problem(503, "overloaded");
        assert!(refused.header("retry-after").parse::<u64>().unwrap() >= 1);
        drop(occupied);
    };
    let (answers, ()) = tokio::join!(crowd, watch);
    let statuses: Vec<u16> = answers.iter().map(|answer| answer.status).collect();
    assert!(statuses.iter().all(|status| matches!(status, 200 | 503)), "{statuses:?}");
    assert_eq!(
        statuses.iter().filter(|status| **status == 200).count(),
        2,
        "two fit the queue: {statuses:?}"
    );
    // And it recovers by itself.
    app.send(ask()).await.expect(200);
    assert!(app.get("/metrics").await.body.windows(12).any(|text| text == b"status=\"503\""));
}

#[tokio::test(flavor = "multi_thread")]
async fn a_batch_has_at_most_so_many_parts() {
    let app = App::start_with(|settings| settings.limits.max_batch_parts = 3).await;
    app.trained("lab", 2).await;
    let frames = |count: usize| form(&vec![("image", scene_png(1)); count]);
    let path = "/v1/databases/lab/recognitions:batch";
    let batch = app.post_bytes(path, &form_type(), frames(3)).await.expect(200);
    assert_eq!(batch["items"].as_array().unwrap().len(), 3);
    app.post_bytes(path, &form_type(), frames(5)).await.expect_problem(413, "body_too_large");

    let files = |count: u64| (1..=count).map(|n| (format!("cup/{n}.png"), scene_png(n))).collect::<Vec<_>>();
    let path = "/v1/databases/lab/exemplars:batch";
    app.post_bytes(path, "application/x-tar", tar(&files(3)).await).await.expect(200);
    app.post_bytes(path, "application/x-tar", tar(&files(4)).await)
        .await
        .expect_problem(413, "body_too_large");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_batch_has_at_most_so_many_bytes_and_keeps_what_came_before() {
    let app = App::start_with(|settings| settings.limits.max_batch_bytes = 30_000).await;
    app.create("lab").await;
    let path = "/v1/databases/lab/exemplars:batch";
    let archive = tar(&(1..=40).map(|n| (format!("cup/{n}.png"), scene_png(n))).collect::<Vec<_>>()).await;
    assert!(archive.len() > 60_000);
    let body = in_pieces(archive, 1000);
    let asked = request(Method::POST, path).header("content-type", "application/x-tar").body(body).unwrap();
    app.send(asked).await.expect_problem(413, "body_too_large");
    let kept = app.get("/v1/databases/lab").await.expect(200)["exemplars"].as_u64().unwrap();
    assert!((1..40).contains(&kept), "{kept} were kept");
}

#[tokio::test(flavor = "multi_thread")]
async fn bodies_that_fill_their_memory_are_refused_until_one_ends() {
    let app = App::start_with(|settings| {
        settings.limits.max_body_bytes_total = 1 << 20;
        settings.limits.body_timeout = Duration::from_secs(1);
    })
    .await;
    app.trained("lab", 2).await;
    let path = "/v1/databases/lab/recognitions";
    let ask = || with_bytes(request(Method::POST, path), "image/png", scene_png(1));
    let endless = Body::from_stream(futures_util::stream::pending::<Result<Bytes, std::io::Error>>());
    let slow = app.send(request(Method::POST, path).body(endless).unwrap());
    let others = async {
        // Of unknown length, so the slow one takes all the room there is.
        while app.send_expecting_5xx(ask()).await.status == 200 {}
        app.send_expecting_5xx(ask()).await.expect_problem(503, "overloaded");
        app.get("/v1/databases/lab").await.expect(200);
    };
    let (slow, ()) = tokio::join!(slow, others);
    slow.expect_problem(408, "body_timeout");
    app.send(ask()).await.expect(200);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_body_that_does_not_come_is_given_up() {
    let app = App::start_with(|settings| settings.limits.body_timeout = Duration::from_millis(200)).await;
    app.trained("lab", 2).await;
    for (path, media_type) in [
        ("/v1/databases/lab/recognitions", "image/png".to_owned()),
        ("/v1/databases/lab/recognitions", form_type()),
        ("/v1/databases/lab/recognitions:batch", form_type()),
        ("/v1/databases/lab/exemplars:batch", "application/x-tar".to_owned()),
        ("/v1/databases/lab/trainings", "application/json".to_owned()),
    ] {
        let endless = Body::from_stream(futures_util::stream::pending::<Result<Bytes, std::io::Error>>());
        let asked = request(Method::POST, path).header("content-type", media_type).body(endless).unwrap();
        app.send(asked).await.expect_problem(408, "body_timeout");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_body_that_breaks_off_is_malformed() {
    let app = App::start().await;
    app.trained("lab", 2).await;
    for (path, media_type) in [
        ("/v1/databases/lab/recognitions", "image/png".to_owned()),
        ("/v1/databases/lab/recognitions:batch", form_type()),
        ("/v1/databases/lab/exemplars:batch", "application/x-tar".to_owned()),
    ] {
        let pieces = [Ok(scene_png(1).slice(..50)), Err(std::io::Error::other("the line went dead"))];
        let body = Body::from_stream(futures_util::stream::iter(pieces));
        let asked = request(Method::POST, path).header("content-type", media_type).body(body).unwrap();
        app.send(asked).await.expect_problem(400, "malformed_request");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_request_that_takes_too_long_is_answered_all_the_same() {
    let app = App::start_with(|settings| {
        settings.threads = 1;
        settings.limits.request_timeout = Duration::from_millis(300);
    })
    .await;
    app.trained("lab", 2).await;
    let occupied = Occupied::lane(&app, Lane::Recognition).await;
    let ask =
        || with_bytes(request(Method::POST, "/v1/databases/lab/recognitions"), "image/png", scene_png(1));
    app.send_expecting_5xx(ask()).await.expect_problem(503, "deadline_exceeded");
    until("nobody waits", async || app.service.compute.waiting(Lane::Recognition) == 0).await;
    drop(occupied);
    app.send(ask()).await.expect(200);
}

#[tokio::test(flavor = "multi_thread")]
async fn pictures_cut_off_anywhere_are_answered_with_a_problem_or_what_can_be_seen() {
    let app = App::start().await;
    app.trained("lab", 2).await;
    // Noise, so that the files are long: no compressor shortens it.
    let mut numbers = crate::pictures::Numbers::seeded(11);
    let pixels: Vec<u8> = (0..3 * 96 * 96).map(|_| numbers.next() as u8).collect();
    let noise = landmarkd_core::imaging::Frame::from_rgb8(96, 96, &pixels);
    for picture in [png(&noise), jpeg(&noise), jpeg(&scene(1))] {
        assert!(picture.len() > 2000);
        let kilobytes = (0..picture.len()).step_by(1024);
        let ends = (0..64.min(picture.len())).chain(kilobytes).chain(picture.len() - 8..picture.len());
        for length in ends {
            let answer = app.post_png("/v1/databases/lab/recognitions", picture.slice(..length)).await;
            assert!(matches!(answer.status, 200 | 400 | 415), "{length} bytes: {answer:?}");
        }
        app.post_png("/v1/databases/lab/recognitions", picture).await.expect(200);
    }
}
