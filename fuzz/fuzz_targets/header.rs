//! Headers that are read: Accept, X-Stamp and its kin, traceparent, preconditions.
#![no_main]

use axum::http::{HeaderMap, HeaderValue, header};
use landmarkd::http::accept;
use landmarkd_fuzz::service::{Call, send};
use landmarkd_fuzz::{drawn, seeds};
use libfuzzer_sys::fuzz_target;

const CALLS: [(&str, &str); 7] = [
    ("POST", "/v1/databases/lab/recognitions"),
    ("POST", "/v1/segmentations"),
    ("POST", "/v1/databases/lab/tracks/@track/frames"),
    ("PUT", "/v1/databases/lab/aliases/tested"),
    ("GET", "/v1/databases/lab/versions/1/artifact"),
    ("GET", "/v1/jobs/@job/events"),
    ("DELETE", "/v1/databases/lab/aliases/tested"),
];
const OFFERED: [&str; 3] = ["application/json", "image/png", "image/png; preview=turbo"];

fuzz_target!(init: seeds::write(seeds::headers), |bytes: &[u8]| {
    let [call, lines @ ..] = bytes else { return };
    let headers: Vec<(&[u8], &[u8])> = (lines.split(|byte| *byte == b'\n'))
        .filter_map(|line| {
            let colon = line.iter().position(|byte| *byte == b':')?;
            Some((&line[..colon], line[colon + 1..].trim_ascii()))
        })
        .collect();
    let mut accepted = HeaderMap::new();
    for (_, value) in &headers {
        if let Ok(value) = HeaderValue::from_bytes(value) {
            accepted.append(header::ACCEPT, value);
        }
    }
    if let Ok(chosen) = accept::choose(&accepted, &OFFERED) {
        assert!(OFFERED.contains(&chosen));
    }
    let (method, target) = CALLS[usize::from(*call) % CALLS.len()];
    let picture = drawn::scene_png(1);
    let body = match method {
        "POST" => picture.as_slice(),
        "PUT" => br#"{"version":1}"#,
        _ => b"",
    };
    send(Call { method, target, headers: &headers, body, piece_bytes: 0 });
});
