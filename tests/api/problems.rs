//! Problems: every wrong request gets a document that says what is wrong, and never a 5xx.

use axum::body::Body;
use axum::http::{Method, Request, header};
use bytes::Bytes;
use landmarkd_core::imaging::encode::png_gray8;
use serde_json::{Value, json};

use crate::app::{App, form, form_type, request, with_bytes, with_json};
use crate::pictures::{SIDE_PX, flat_png, jpeg, scene, scene_png};

async fn lab() -> App {
    let app = App::start().await;
    app.trained("lab", 2).await;
    app
}

fn bare(method: Method, path: &str) -> Request<Body> {
    request(method, path).body(Body::empty()).unwrap()
}

fn json_to(method: Method, path: &str, body: Value) -> Request<Body> {
    with_json(request(method, path), &body)
}

fn text_to(path: &str, media_type: &str, body: &str) -> Request<Body> {
    with_bytes(request(Method::POST, path), media_type, body.to_owned())
}

const NO_ID: &str = "00000000-0000-4000-8000-000000000000";

#[tokio::test(flavor = "multi_thread")]
async fn every_unknown_thing_is_said_to_be_unknown() {
    let app = lab().await;
    let database = "/v1/databases/lab";
    let table = [
        (bare(Method::GET, "/v2/databases"), 404, "unknown_route"),
        (bare(Method::GET, "/v1/databases/lab/"), 404, "unknown_route"),
        (bare(Method::GET, "/v1/databases/lab/exemplars/x/y/z"), 404, "unknown_route"),
        (bare(Method::POST, "/livez"), 405, "method_not_allowed"),
        (bare(Method::PATCH, database), 405, "method_not_allowed"),
        (bare(Method::GET, "/v1/databases/lab/recognitions"), 405, "method_not_allowed"),
        (bare(Method::GET, "/v1/databases/none"), 404, "unknown_database"),
        (bare(Method::DELETE, "/v1/databases/none"), 404, "unknown_database"),
        (bare(Method::GET, "/v1/databases/none/exemplars"), 404, "unknown_database"),
        (bare(Method::DELETE, "/v1/databases/none/exemplars?label=a"), 404, "unknown_database"),
        (bare(Method::GET, &format!("/v1/databases/none/exemplars/{NO_ID}")), 404, "unknown_database"),
        (bare(Method::GET, "/v1/databases/none/versions"), 404, "unknown_database"),
        (bare(Method::GET, "/v1/databases/none/versions/1"), 404, "unknown_database"),
        (bare(Method::GET, "/v1/databases/none/versions/1/artifact"), 404, "unknown_database"),
        (bare(Method::GET, "/v1/databases/none/aliases"), 404, "unknown_database"),
        (bare(Method::GET, "/v1/databases/none/aliases/current"), 404, "unknown_database"),
        (
            json_to(Method::PUT, "/v1/databases/none/aliases/a", json!({"version": 1})),
            404,
            "unknown_database",
        ),
        (json_to(Method::POST, "/v1/databases/none/trainings", json!({})), 404, "unknown_database"),
        (bare(Method::GET, &format!("{database}/exemplars/{NO_ID}")), 404, "unknown_exemplar"),
        (bare(Method::GET, &format!("{database}/exemplars/{NO_ID}/image")), 404, "unknown_exemplar"),
        (bare(Method::DELETE, &format!("{database}/exemplars/{NO_ID}")), 404, "unknown_exemplar"),
        (bare(Method::GET, &format!("{database}/versions/7")), 404, "unknown_version"),
        (bare(Method::GET, &format!("{database}/versions/-1")), 404, "unknown_version"),
        (bare(Method::GET, &format!("{database}/versions/7/artifact")), 404, "unknown_version"),
        (bare(Method::GET, &format!("{database}/versions/7/eigenimages/mean")), 404, "unknown_version"),
        (bare(Method::GET, "/v1/databases/none/versions/1/eigenimages/0"), 404, "unknown_database"),
        (bare(Method::DELETE, &format!("{database}/versions/7")), 404, "unknown_version"),
        (bare(Method::GET, &format!("{database}/aliases/none")), 404, "unknown_alias"),
        (bare(Method::DELETE, &format!("{database}/aliases/none")), 404, "unknown_alias"),
        (bare(Method::GET, &format!("/v1/jobs/{NO_ID}")), 404, "unknown_job"),
        (bare(Method::DELETE, &format!("/v1/jobs/{NO_ID}")), 404, "unknown_job"),
        (bare(Method::GET, &format!("/v1/jobs/{NO_ID}/events")), 404, "unknown_job"),
    ];
    for (asked, status, code) in table {
        app.send(asked).await.expect_problem(status, code);
    }
    for (path, code) in [
        ("/v1/databases/none/recognitions", "unknown_database"),
        ("/v1/databases/none/exemplars?label=a", "unknown_database"),
        ("/v1/databases/lab/recognitions?alias=none", "unknown_alias"),
        ("/v1/databases/lab/recognitions?version=7", "unknown_version"),
    ] {
        app.post_png(path, scene_png(1)).await.expect_problem(404, code);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn impossible_names_numbers_and_fields_are_unprocessable_and_pointed_to() {
    let app = lab().await;
    let picture = |path: &str| with_bytes(request(Method::POST, path), "image/png", scene_png(1));
    let database = json!({"kind": "landmarks"});
    let long = "a".repeat(65);
    let table = [
        (picture("/v1/databases/lab/exemplars?label=a/b"), "#label"),
        (picture("/v1/databases/lab/exemplars?label=a%2Fb"), "#label"),
        (picture("/v1/databases/lab/exemplars?label=.."), "#label"),
        (picture("/v1/databases/lab/exemplars?label="), "#label"),
        (picture("/v1/databases/lab/exemplars?label=a%00"), "#label"),
        (picture("/v1/databases/lab/exemplars"), "#label"),
        (picture("/v1/databases/lab/exemplars?label=a&posed_deg=5"), "#posed_deg"),
        (picture("/v1/databases/lab/exemplars?label=a&pose_deg=NaN"), "#pose_deg"),
        (picture("/v1/databases/lab/exemplars?label=a&pose_deg=inf"), "#pose_deg"),
        (picture("/v1/databases/lab/exemplars?label=a&pose_deg=360"), "#pose_deg"),
        (picture("/v1/databases/lab/exemplars?label=a&pose_deg=-5"), "#pose_deg"),
        (picture("/v1/databases/lab/recognitions?top=0"), "#top"),
        (picture("/v1/databases/lab/recognitions?top=1001"), "#top"),
        (picture("/v1/databases/lab/recognitions?top=many"), "#top"),
        (picture("/v1/databases/lab/recognitions?explain=maybe"), "#explain"),
        (picture("/v1/databases/lab/recognitions?version=1&alias=current"), "#version"),
        (picture("/v1/databases/lab/recognitions?version=99999999999999999999"), "#version"),
        (picture("/v1/databases/lab/recognitions?alias=a%20b"), "#alias"),
        (json_to(Method::PUT, "/v1/databases/.hidden", database.clone()), "#database"),
        (json_to(Method::PUT, "/v1/databases/a%2Fb", database.clone()), "#database"),
        (json_to(Method::PUT, "/v1/databases/%2e%2e", database.clone()), "#database"),
        (json_to(Method::PUT, "/v1/databases/k%C3%BCche", database.clone()), "#database"),
        (json_to(Method::PUT, &format!("/v1/databases/{long}"), database), "#database"),
        (json_to(Method::PUT, "/v1/databases/new", json!({})), ""),
        (json_to(Method::PUT, "/v1/databases/new", json!({"kind": "pictures"})), "/kind"),
        (json_to(Method::PUT, "/v1/databases/new", json!({"kind": "landmarks", "sort": 1})), "/sort"),
        (json_to(Method::PUT, "/v1/databases/new", json!([])), ""),
        (json_to(Method::PUT, "/v1/databases/lab/aliases/a", json!({"version": "one"})), "/version"),
        (json_to(Method::PUT, "/v1/databases/lab/aliases/a", json!({"version": 1.5})), "/version"),
        (json_to(Method::PUT, "/v1/databases/lab/aliases/a", json!({})), ""),
        (json_to(Method::PUT, "/v1/databases/lab/aliases/-", json!({"version": 1})), "#alias"),
        (json_to(Method::POST, "/v1/databases/lab/trainings", json!({"promote": "soon"})), "/promote"),
        (json_to(Method::POST, "/v1/databases/lab/trainings", json!({"options": 5})), "/options"),
        (bare(Method::GET, "/v1/databases?limit=0"), "#limit"),
        (bare(Method::GET, "/v1/databases?limit=1001"), "#limit"),
        (bare(Method::GET, "/v1/databases?limit=-1"), "#limit"),
        (bare(Method::GET, "/v1/databases?page=2"), "#page"),
        (bare(Method::GET, "/v1/databases/lab/exemplars?cursor=next"), "#cursor"),
        (bare(Method::GET, "/v1/databases/lab/versions?cursor=next"), "#cursor"),
        (bare(Method::GET, "/v1/databases/lab/versions/one"), "#version"),
        (bare(Method::GET, "/v1/databases/lab/versions/99999999999999999999"), "#version"),
        (bare(Method::GET, "/v1/databases/lab/exemplars/no-id"), "#id"),
        (bare(Method::GET, "/v1/jobs/no-id"), "#id"),
        (bare(Method::GET, "/v1/jobs?cursor=next"), "#cursor"),
    ];
    for (asked, pointer) in table {
        let what = format!("{} {}", asked.method(), asked.uri());
        let problem = app.send(asked).await.expect_problem(422, "invalid_field");
        assert_eq!(problem["errors"][0]["pointer"], pointer, "{what}: {problem:#}");
        assert!(problem["errors"][0]["detail"].as_str().is_some_and(|text| !text.is_empty()), "{what}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn wrong_unknown_and_conflicting_options_are_named_all_at_once() {
    let app = App::start().await;
    let options = json!({
        "method": "paper", "ringz": 3, "sectors": "many", "epsilon": -1, "taper": "flat", "rings": 2, "dimension": 200,
        "interest_points": 0, "neighbours": 4,
    });
    let problem = app
        .put("/v1/databases/lab", json!({"kind": "landmarks", "options": options}))
        .await
        .expect_problem(422, "invalid_field");
    let mut named: Vec<_> =
        problem["errors"].as_array().unwrap().iter().map(|e| e["pointer"].as_str().unwrap()).collect();
    named.sort_unstable();
    let wrong = ["dimension", "epsilon", "interest_points", "neighbours", "ringz", "sectors", "taper"];
    assert_eq!(named, wrong.map(|option| format!("/options/{option}")), "{problem:#}");
    for option in wrong {
        assert!(problem["detail"].as_str().unwrap().contains(option), "{problem:#}");
    }
    app.get("/v1/databases/lab").await.expect_problem(404, "unknown_database");
}

#[tokio::test(flavor = "multi_thread")]
async fn defaults_are_those_of_the_method_and_the_viewpoint() {
    let app = App::start().await;
    let shown = async |name: &str, options: Value| {
        let body = json!({"kind": "landmarks", "options": options});
        let database = app.put(&format!("/v1/databases/{name}"), body).await.expect(201);
        let options = database["options"].clone();
        ["method", "viewpoint", "interest_points", "neighbours", "subwindow_radius_px", "position_prior_px"]
            .map(|option| options[option].clone())
    };
    let placement = json!(["placement", "free", 600, 30, 14.0, null]);
    assert_eq!(json!(shown("a", json!({})).await), placement);
    let intensity = json!(["placement", "free", 96, 6, [10.0, 14.0], null]);
    assert_eq!(json!(shown("i", json!({"signature": "intensity"})).await), intensity);
    let rings = json!(["placement", "free", 96, 6, [10.0, 14.0], null]);
    assert_eq!(json!(shown("r", json!({"rings": 10})).await), rings, "gradients have no such option");
    let paper = json!(["paper", "free", 64, 1, 5.0, null]);
    assert_eq!(json!(shown("b", json!({"method": "paper"})).await), paper);
    let upright = json!(["placement", "upright", 150, 30, [12.0, 16.0, 21.0], 25.0]);
    let given = json!({"viewpoint": "upright", "position_prior_px": 25});
    assert_eq!(json!(shown("c", given).await), upright);
    shown("harris", json!({"operator": "harris"})).await;
    let blobs = json!({"kind": "landmarks", "options": {"operator": "dog"}});
    let problem = app.put("/v1/databases/dog", blobs).await.expect_problem(422, "invalid_field");
    assert_eq!(problem["errors"][0]["pointer"], "/options/operator");
    for (options, pointer) in [
        (json!({"working_size_px": 100}), "/options/working_size_px"),
        (json!({"working_size_px": 5000}), "/options/working_size_px"),
        (json!({"false_alarms": 0}), "/options/false_alarms"),
        (json!({"turn_prior_deg": 0}), "/options/turn_prior_deg"),
        (json!({"levels_per_octave": 9}), "/options/levels_per_octave"),
        (json!({"method": "paper", "signature": "gradient", "neighbours": 1}), "/options/signature"),
        (json!({"signature": "gradient", "subwindow_radius_px": [10, 14]}), "/options/subwindow_radius_px"),
    ] {
        let body = json!({"kind": "landmarks", "options": options});
        let problem = app.put("/v1/databases/e", body).await.expect_problem(422, "invalid_field");
        assert_eq!(problem["errors"][0]["pointer"], pointer);
    }
    let conflict = json!({"kind": "landmarks", "options": {"method": "paper", "viewpoint": "upright"}});
    let problem = app.put("/v1/databases/d", conflict).await.expect_problem(422, "invalid_field");
    assert_eq!(problem["errors"][0]["pointer"], "/options/viewpoint");
}

#[tokio::test(flavor = "multi_thread")]
async fn json_that_does_not_parse_is_malformed() {
    let app = lab().await;
    let path = "/v1/databases/lab/trainings";
    let deep = format!("{{\"options\":{}{}}}", "[".repeat(5000), "]".repeat(5000));
    let just_too_deep = format!("{}{}", "[".repeat(33), "]".repeat(33));
    let numbers = ["{\"options\":{\"epsilon\":NaN}}", "{\"options\":{\"epsilon\":Infinity}}"];
    let broken =
        ["{", "{\"options\"}", "null null", "\u{feff}{}", "{\"options\":{\"epsilon\":1e999}}", "{'a':1}"];
    for body in broken.into_iter().chain(numbers).chain([deep.as_str(), &just_too_deep]) {
        let asked = text_to(path, "application/json", body);
        app.send(asked).await.expect_problem(400, "malformed_request");
    }
    let not_text = with_bytes(request(Method::POST, path), "application/json", vec![b'"', 0xff, b'"']);
    app.send(not_text).await.expect_problem(400, "malformed_request");
    let long = format!("{{\"a\":\"{}\"}}", "x".repeat(2 << 20));
    app.send(text_to(path, "application/json", &long)).await.expect_problem(413, "body_too_large");
}

#[tokio::test(flavor = "multi_thread")]
async fn content_of_another_type_is_not_taken() {
    let app = lab().await;
    let picture = scene_png(1);
    for (path, media_type) in [
        ("/v1/databases/lab/recognitions", "text/plain"),
        ("/v1/databases/lab/recognitions", "application/json"),
        ("/v1/databases/lab/exemplars?label=a", "video/mp4"),
        ("/v1/databases/lab/exemplars:batch", "image/png"),
        ("/v1/databases/lab/exemplars:batch", "application/zip"),
        ("/v1/databases/lab/trainings", "application/x-www-form-urlencoded"),
    ] {
        let answer = app.post_bytes(path, media_type, picture.clone()).await;
        answer.expect_problem(415, "unsupported_media_type");
    }
    let undeclared = request(Method::POST, "/v1/databases/lab/exemplars:batch");
    let undeclared = undeclared.body(Body::from(picture.clone())).unwrap();
    app.send(undeclared).await.expect_problem(415, "unsupported_media_type");

    for body in
        [&b"GIF89a......"[..], b"RIFF....WEBP", b"<svg/>", b"P9 1 1 255 .", b"{}", b"\0", b"BM........"]
    {
        let answer = app.post_png("/v1/databases/lab/recognitions", body).await;
        answer.expect_problem(415, "unsupported_image_format");
    }
    let accept = request(Method::POST, "/v1/databases/lab/recognitions").header(header::ACCEPT, "text/html");
    app.send(with_bytes(accept, "image/png", picture)).await.expect_problem(406, "not_acceptable");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_mislabelled_or_unlabelled_picture_is_taken_for_what_it_is() {
    let app = lab().await;
    for media_type in
        ["image/jpeg", "image/webp", "image/x-unheard-of", "IMAGE/PNG; q=1", "application/octet-stream"]
    {
        let answer = app.post_bytes("/v1/databases/lab/recognitions", media_type, scene_png(1)).await;
        assert_eq!(answer.expect(200)["votes"][0]["label"], "place-1", "{media_type}");
    }
    let undeclared = request(Method::POST, "/v1/databases/lab/recognitions").body(Body::from(scene_png(1)));
    app.send(undeclared.unwrap()).await.expect(200);
}

#[tokio::test(flavor = "multi_thread")]
async fn an_empty_or_damaged_picture_is_told_apart() {
    let app = lab().await;
    let (png, jpeg) = (scene_png(1), jpeg(&scene(1)));
    let mut flipped = png.to_vec();
    flipped[png.len() / 2] ^= 0xff;
    for path in ["/v1/databases/lab/recognitions", "/v1/databases/lab/exemplars?label=a"] {
        app.post_png(path, Bytes::new()).await.expect_problem(400, "empty_image");
        app.post_png(path, png.slice(..png.len() / 2)).await.expect_problem(400, "corrupt_image");
        app.post_png(path, png.slice(..20)).await.expect_problem(400, "corrupt_image");
        app.post_png(path, flipped.clone()).await.expect_problem(400, "corrupt_image");
        app.post_png(path, jpeg.slice(..100)).await.expect_problem(400, "corrupt_image");
        app.post_png(path, jpeg.slice(..4)).await.expect_problem(400, "corrupt_image");
        app.post_bytes(path, &form_type(), form(&[("image", "")])).await.expect_problem(400, "empty_image");
        app.post_bytes(path, &form_type(), form(&[("photo", &png)])).await.expect_problem(400, "empty_image");
        app.post_bytes(path, &form_type(), "no form").await.expect_problem(400, "malformed_request");
        app.post_bytes(path, "multipart/form-data", "no form").await.expect_problem(400, "malformed_request");
    }
    assert_eq!(app.get("/v1/databases/lab").await.expect(200)["exemplars"], 2, "none of them was kept");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_picture_with_nothing_to_see_is_an_answer_without_a_decision() {
    let app = lab().await;
    let one_pixel = Bytes::from(png_gray8(1, 1, &[200]));
    let thin = Bytes::from(png_gray8(SIDE_PX, 1, &[90; SIDE_PX]));
    for picture in [one_pixel, thin, flat_png(0), flat_png(255), Bytes::from_static(b"P5 1 1 255 x")] {
        let answer = app.recognise("lab", "?explain=true", picture).await;
        assert_eq!(answer["decision"], Value::Null, "{answer:#}");
        assert!(answer["warnings"].as_array().unwrap().contains(&json!("no_interest_points")), "{answer:#}");
        assert_eq!((&answer["votes"], &answer["points"]), (&json!([]), &json!([])));
    }
    let accept = request(Method::POST, "/v1/databases/lab/recognitions").header(header::ACCEPT, "image/png");
    let drawn = app.send(with_bytes(accept, "image/png", png_gray8(1, 1, &[9]))).await;
    assert_eq!((drawn.status, drawn.header("content-type")), (200, "image/png"));
}

/// A PNG that says how large it is and then ends: signature, header chunk with its checksum, an empty data chunk.
fn png_header(width_px: u32, height_px: u32) -> Vec<u8> {
    let chunk = |kind: &[u8; 4], data: &[u8]| {
        let mut chunk = (data.len() as u32).to_be_bytes().to_vec();
        let body = [kind, data].concat();
        let checksum = !body.iter().fold(!0_u32, |sum, byte| {
            (0..8).fold(sum ^ u32::from(*byte), |sum, _| {
                if sum & 1 == 1 { (sum >> 1) ^ 0xedb8_8320 } else { sum >> 1 }
            })
        });
        chunk.extend(body);
        chunk.extend(checksum.to_be_bytes());
        chunk
    };
    let size = [width_px.to_be_bytes(), height_px.to_be_bytes()].concat();
    let header = [size.as_slice(), &[8, 2, 0, 0, 0]].concat();
    [
        b"\x89PNG\r\n\x1a\n".as_slice(),
        &chunk(b"IHDR", &header),
        &chunk(b"IDAT", &[0; 9]),
        &chunk(b"IEND", b""),
    ]
    .concat()
}

/// The JPEG of a scene with another size written into its frame header.
fn jpeg_of_size(width_px: u16, height_px: u16) -> Vec<u8> {
    let mut bytes = jpeg(&scene(1)).to_vec();
    let frame = bytes.windows(2).position(|pair| matches!(pair, [0xff, 0xc0..=0xc2])).unwrap();
    bytes[frame + 5..frame + 7].copy_from_slice(&height_px.to_be_bytes());
    bytes[frame + 7..frame + 9].copy_from_slice(&width_px.to_be_bytes());
    bytes
}

#[tokio::test(flavor = "multi_thread")]
async fn a_header_that_claims_a_huge_picture_is_refused_before_it_costs_anything() {
    let app = lab().await;
    let claims = [
        png_header(60_000, 60_000),
        png_header(8193, 1),
        png_header(8000, 8000),
        png_header(u32::MAX >> 1, u32::MAX >> 1),
        jpeg_of_size(60_000, 60_000),
        b"P6 60000 60000 255\n".to_vec(),
        b"P5\n2000000000 2\n255\n".to_vec(),
    ];
    for (at, claim) in claims.into_iter().enumerate() {
        for path in ["/v1/databases/lab/recognitions", "/v1/databases/lab/exemplars?label=a"] {
            let answer = app.post_png(path, claim.clone()).await;
            assert_eq!(answer.json()["code"], "image_too_large", "claim {at}: {answer:?}");
            assert_eq!(answer.status, 422);
        }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn seventeen_mebibytes_are_too_many() {
    let app = lab().await;
    let large = Bytes::from(vec![0xff; 17 << 20]);
    for path in ["/v1/databases/lab/recognitions", "/v1/databases/lab/exemplars?label=a"] {
        let problem = app.post_png(path, large.clone()).await.expect_problem(413, "body_too_large");
        assert!(problem["detail"].as_str().unwrap().contains("16 MiB"), "{problem:#}");
        // Declared, and refused before a byte of it is read.
        let declared = request(Method::POST, path).header(header::CONTENT_LENGTH, large.len());
        app.send(declared.body(Body::empty()).unwrap()).await.expect_problem(413, "body_too_large");
        let as_form = form(&[("image", large.clone())]);
        app.post_bytes(path, &form_type(), as_form).await.expect_problem(413, "body_too_large");
    }
    // In a batch it is one bad picture.
    let parts = [("image", large), ("image", scene_png(2))];
    let batch =
        app.post_bytes("/v1/databases/lab/recognitions:batch", &form_type(), form(&parts)).await.expect(200);
    assert_eq!(batch["items"][0]["problem"]["code"], "body_too_large");
    assert_eq!(batch["items"][1]["votes"][0]["label"], "place-2");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_broken_archive_says_so() {
    let app = lab().await;
    let path = "/v1/databases/lab/exemplars:batch";
    let tar = crate::app::tar(&[("cup/a.png", scene_png(5))]).await;
    let damaged = [&tar[..300], &[0x55; 100], &tar[400..]].concat();
    app.post_bytes(path, "application/x-tar", damaged).await.expect_problem(400, "malformed_request");
    app.post_bytes(path, "application/x-tar", vec![b'x'; 4096])
        .await
        .expect_problem(400, "malformed_request");
    app.post_bytes(path, "application/x-tar", tar.slice(..700))
        .await
        .expect_problem(400, "malformed_request");
    let batch = app.post_bytes(path, "application/x-tar", Bytes::new()).await.expect(200);
    assert_eq!(batch["items"], json!([]));
}

#[tokio::test(flavor = "multi_thread")]
async fn a_stamp_that_is_no_time_and_preconditions_that_are_no_etags_are_refused() {
    let app = lab().await;
    let sent = request(Method::POST, "/v1/databases/lab/recognitions").header("x-stamp", "yesterday");
    let problem =
        app.send(with_bytes(sent, "image/png", scene_png(1))).await.expect_problem(422, "invalid_field");
    assert_eq!(problem["errors"][0]["pointer"], "#X-Stamp");
    let sent = request(Method::POST, "/v1/databases/lab/recognitions").header("x-robot-id", "r".repeat(129));
    app.send(with_bytes(sent, "image/png", scene_png(1))).await.expect_problem(422, "invalid_field");
    for etag in ["1", "\"1", "\"1\" \"2\""] {
        let sent = request(Method::PUT, "/v1/databases/lab/aliases/current").header(header::IF_MATCH, etag);
        app.send(with_json(sent, &json!({"version": 1}))).await.expect_problem(400, "malformed_request");
    }
    let sent = request(Method::PUT, "/v1/databases/lab/aliases/new").header(header::IF_MATCH, "*");
    app.send(with_json(sent, &json!({"version": 1}))).await.expect_problem(412, "precondition_failed");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_callers_request_id_is_echoed_and_others_get_one_of_their_own() {
    let app = App::start().await;
    let with_id =
        |id: &str| request(Method::GET, "/v1/databases/none").header("x-request-id", id).body(Body::empty());
    let answer = app.send(with_id("frame 17 of robot-3").unwrap()).await;
    assert_eq!(answer.header("x-request-id"), "frame 17 of robot-3");
    assert_eq!(answer.json()["request_id"], "frame 17 of robot-3");
    for unusable in ["", &"x".repeat(129)] {
        let answer = app.send(with_id(unusable).unwrap()).await;
        assert_eq!(answer.header("x-request-id").len(), 36, "{answer:?}");
    }
    let (one, other) = (app.get("/livez").await, app.get("/livez").await);
    assert_ne!(one.header("x-request-id"), other.header("x-request-id"));
}

#[tokio::test(flavor = "multi_thread")]
async fn the_allowed_methods_are_told() {
    let app = App::start().await;
    let answer = app.send(bare(Method::POST, "/v1/jobs")).await;
    answer.expect_problem(405, "method_not_allowed");
    assert!(answer.header("allow").contains("GET"), "{answer:?}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_database_is_created_once_and_its_options_can_be_replaced() {
    let app = App::start().await;
    let path = "/v1/databases/lab";
    let first = app.put(path, json!({"kind": "landmarks"})).await.expect(201);
    assert_eq!(first["options"]["interest_points"], 600);
    assert_eq!(app.put(path, json!({"kind": "landmarks"})).await.expect(200), first);
    let options = json!({"kind": "landmarks", "options": {"interest_points": 32}});
    assert_eq!(app.put(path, options).await.expect(200)["options"]["interest_points"], 32);
    let kept = app.put(path, json!({"kind": "landmarks"})).await.expect(200);
    assert_eq!(kept["options"]["interest_points"], 32, "absent options change nothing");
    assert_eq!(app.get("/v1/databases").await.expect(200)["items"], json!([kept]));
}
