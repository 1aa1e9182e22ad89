//! First inputs of each target, drawn: `LANDMARKD_FUZZ_SEEDS=folder` makes a target write its own into the folder when it
//! starts. `words` makes a dictionary of what stands in the OpenAPI document.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use landmarkd_core::imaging::random::Random;
use serde_json::{Value, json};

use crate::artifacts;
use crate::drawn::{self, archive, form, scene_colour_png, scene_jpeg, scene_png};

/// Write the seeds of a target, if they are asked for.
pub fn write(seeds: impl FnOnce() -> Vec<Vec<u8>>) {
    let Some(folder) = std::env::var_os("LANDMARKD_FUZZ_SEEDS") else { return };
    let folder = Path::new(&folder);
    fs::create_dir_all(folder).expect("the folder of seeds is made");
    for (number, seed) in seeds().iter().enumerate() {
        fs::write(folder.join(format!("seed-{number:02}")), seed).expect("a seed is written");
    }
    let words = words().iter().map(|word| format!("{word:?}\n")).collect::<String>();
    fs::write(folder.with_file_name("words"), words).expect("the words are written");
}

/// Names, words and paths of the OpenAPI document, for every target to try.
fn words() -> BTreeSet<String> {
    let document: Value =
        serde_json::from_str(&landmarkd::http::openapi::text()).expect("the document is JSON");
    let mut words = BTreeSet::new();
    let plain = |word: &str| {
        word.len() > 1
            && word.len() < 64
            && word.bytes().all(|c| (b' '..=b'~').contains(&c) && !b"\"\\".contains(&c))
    };
    let mut stack = vec![&document];
    while let Some(value) = stack.pop() {
        match value {
            Value::Object(members) => {
                for (name, member) in members {
                    if name == "enum" || name == "required" {
                        words.extend(
                            member
                                .as_array()
                                .into_iter()
                                .flatten()
                                .filter_map(Value::as_str)
                                .map(str::to_owned),
                        );
                    }
                    if name == "properties" || name == "paths" {
                        words.extend(
                            member.as_object().into_iter().flat_map(|members| members.keys().cloned()),
                        );
                    }
                    if name == "name" {
                        words.extend(member.as_str().map(str::to_owned));
                    }
                    stack.push(member);
                }
            }
            Value::Array(items) => stack.extend(items),
            _ => {}
        }
    }
    words.retain(|word| plain(word));
    words
}

/// Pictures of every format that is read.
pub fn pictures() -> Vec<Vec<u8>> {
    vec![
        scene_png(1),
        scene_colour_png(2),
        scene_jpeg(3),
        b"P5 2 2 255\nabcd".into(),
        b"P6 2 1 65535\nabcdefghijkl".into(),
        b"P1 3 2\n0 1 0 1 0 1".into(),
        b"P4 9 1\nab".into(),
        b"P2\n# a comment\n2 2\n15\n0 5 10 15\n".into(),
        b"P7\nWIDTH 2\nHEIGHT 1\nDEPTH 4\nMAXVAL 255\nTUPLTYPE RGB_ALPHA\nENDHDR\nabcdefgh".into(),
    ]
}

/// A call and a body for each of so many calls.
fn each(calls: u8, bodies: &[Vec<u8>]) -> Vec<Vec<u8>> {
    let whole = |call: u8| bodies.iter().map(move |body| [&[call], body.as_slice()].concat());
    (0..calls).flat_map(whole).collect()
}

/// Forms for every call that takes one; the first byte names the call, the second the size of pieces.
pub fn forms() -> Vec<Vec<u8>> {
    let (near, far) = (scene_png(1), scene_png(2));
    let line = br#"[{"file":"a","label":"cup"}]"#;
    let planes: Vec<Value> =
        (0..5).map(|n| json!({"depth_mm": 540 + 30 * n, "near": "n", "far": "f"})).collect();
    let planes = Value::Array(planes).to_string();
    let optics = drawn::optics().to_string();
    [
        form(&[("manifest", line), ("a", &near)]),
        form(&[("image", &near)]),
        form(&[("image", &near), ("image", &far)]),
        form(&[("near", &near), ("far", &far), ("optics", optics.as_bytes())]),
        form(&[("image", &near), ("options", br#"{"threshold":"otsu"}"#)]),
        form(&[("near", &near), ("far", &far), ("dark_near", &near), ("dark_far", &near)]),
        form(&[("manifest", planes.as_bytes()), ("n", &near), ("f", &far)]),
        form(&[("overview", &near), ("near", &near), ("far", &far)]),
        form(&[("image", &near)]),
    ]
    .into_iter()
    .zip(0..)
    .map(|(form, call)| [&[call, 3], form.as_slice()].concat())
    .collect()
}

/// Archives; the first byte says whether checksums are corrected.
pub fn archives() -> Vec<Vec<u8>> {
    let picture = scene_png(1);
    let plain = archive(&[("cup/a__12.5.png", &picture), ("can/b.png", &picture)]);
    let mut long = archive(&[("././@LongLink", b"cup/long.png\0"), ("short", &picture)]);
    long[156] = b'L';
    let long = drawn::with_checksums(&long);
    let mut pax = archive(&[("x", b"21 path=cup/pax.png\n"), ("short", &picture)]);
    pax[156] = b'x';
    let pax = drawn::with_checksums(&pax);
    each(2, &[plain, long, pax])
}

/// Manifests of exemplars and of planes; the first byte names the call.
pub fn manifests() -> Vec<Vec<u8>> {
    let exemplars = br#"[{"file":"a","label":"cup","pose_deg":12.5},{"file":"b","label":"can"}]"#.to_vec();
    let planes =
        br#"[{"depth_mm":540.5,"near":"a","far":"b"},{"depth_mm":600,"near":"a","far":"b"}]"#.to_vec();
    each(2, &[exemplars, planes])
}

/// JSON documents; the first byte names the call.
pub fn documents() -> Vec<Vec<u8>> {
    let texts = [
        json!({"kind": "landmarks", "options": {"rings": 4, "epsilon": 0.5, "subwindow_radius_px": [6, 9]}}),
        json!({"kind": "objects", "options": {"dimension": "auto", "width_px": 16, "search": "slabs"}}),
        json!({"options": {"interest_points": 6}, "promote": "if_not_worse"}),
        drawn::optics(),
        drawn::workcell(),
        json!({"version": 1}),
        json!({"version": 1, "motion": {"stay": 0.5}}),
        json!({"threshold": 128, "window_px": 5, "offset": 2, "polarity": "dark_on_light", "min_area_px": 4}),
        json!({"method": "stm", "window": 9, "align": "none", "photometric": "none", "median": 3}),
        json!({"fit_optics": true}),
    ];
    let texts = texts.map(|text| text.to_string().into_bytes());
    each(12, &texts).into_iter().enumerate().filter(|(at, _)| at % 7 < 3).map(|(_, seed)| seed).collect()
}

/// Queries; the first byte names the call.
pub fn queries() -> Vec<Vec<u8>> {
    let texts: [&[u8]; 6] = [
        b"limit=5&cursor=1",
        b"label=cup&pose_deg=12.5&robot_id=r",
        b"alias=current&top=3&explain=true",
        b"version=1&region=1&pair_view=overview",
        b"planes=depth,sigma,flags",
        b"threshold=otsu&window_px=5&offset=2&polarity=light_on_dark&min_area_px=3&max_objects=9",
    ];
    each(6, &texts.map(<[u8]>::to_vec))
}

/// Names; the first byte names the call.
pub fn names() -> Vec<Vec<u8>> {
    let texts = ["lab", "place-1", "a..b", "%2e%2e%2f", "%00", "-a", "current", "1", "mean"];
    each(4, &texts.map(|text| text.as_bytes().to_vec()))
}

/// Lines of headers; the first byte names the call.
pub fn headers() -> Vec<Vec<u8>> {
    let texts = [
        "accept: image/png;q=0.5, */*;q=0.1\nx-stamp: 1700000000.5",
        "accept: image/png; preview=\"turbo\"\naccept: application/x-npy",
        "traceparent: 00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01\nx-request-id: abc",
        "x-stamp: 2026-01-31T12:00:00.25+01:00\nx-robot-id: rover\nx-frame-id: 7",
        "if-match: \"1\", W/\"2\"\nif-none-match: *",
        "content-type: image/png; charset=utf-8\ncontent-length: 5\nlast-event-id: 1",
    ];
    each(5, &texts.map(|text| text.as_bytes().to_vec()))
}

/// Whole requests as text: method and target, headers, an empty line, the body.
pub fn requests() -> Vec<Vec<u8>> {
    let document: Value =
        serde_json::from_str(&landmarkd::http::openapi::text()).expect("the document is JSON");
    let mut requests = Vec::new();
    for (path, item) in document["paths"].as_object().into_iter().flatten() {
        for (method, operation) in
            item.as_object().into_iter().flatten().filter(|(_, found)| found.is_object())
        {
            let id = [("exemplars", "@exemplar"), ("jobs", "@job"), ("tracks", "@track")];
            let id = id.iter().find(|(word, _)| path.contains(word)).map_or("1", |(_, id)| id);
            let name = if path.contains("workcells") { "bench" } else { "rig" };
            let target = path.replace("{database}", "lab").replace("{id}", id).replace("{version}", "1");
            let target =
                target.replace("{alias}", "current").replace("{image}", "mean").replace("{name}", name);
            let content = operation["requestBody"]["content"].as_object();
            let media_type = content.and_then(|content| content.keys().next()).map_or("", String::as_str);
            let body = match media_type {
                "" => Vec::new(),
                "application/json" => b"{}".to_vec(),
                "multipart/form-data" => form(&[("image", &scene_png(1))]),
                "application/x-tar" => archive(&[("cup/a.png", &scene_png(4))]),
                _ => scene_png(1),
            };
            let media_type = if media_type == "multipart/form-data" { drawn::FORM } else { media_type };
            let head = format!("{} {target}\ncontent-type: {media_type}\n\n", method.to_uppercase());
            requests.push([head.as_bytes(), &body].concat());
        }
    }
    requests
}

/// Artifacts as they are.
pub fn trained() -> Vec<Vec<u8>> {
    artifacts::trained()
}

/// Bytes that changes of artifacts are made of.
pub fn noise() -> Vec<Vec<u8>> {
    let mut random = Random::new(7, 7);
    (0..12_usize).map(|n| (0..16 * n).map(|_| random.between(0.0, 256.0) as u8).collect()).collect()
}
