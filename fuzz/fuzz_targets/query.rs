//! Query parameters of the calls that take many.
#![no_main]

use landmarkd_fuzz::service::{Call, send};
use landmarkd_fuzz::{drawn, seeds};
use libfuzzer_sys::fuzz_target;

const CALLS: [(&str, &str); 10] = [
    ("GET", "/v1/databases/lab/exemplars"),
    ("POST", "/v1/databases/lab/exemplars"),
    ("POST", "/v1/databases/lab/recognitions"),
    ("POST", "/v1/databases/lab/tracks/@track/frames"),
    ("POST", "/v1/segmentations"),
    ("GET", "/v1/jobs"),
    ("GET", "/v1/databases/lab/versions"),
    ("POST", "/v1/workcells/bench/inspections"),
    ("POST", "/v1/depth-maps"),
    ("GET", "/v1/workcells"),
];

fuzz_target!(init: seeds::write(seeds::queries), |bytes: &[u8]| {
    let [call, query @ ..] = bytes else { return };
    let Ok(query) = std::str::from_utf8(query) else { return };
    let (method, path) = CALLS[usize::from(*call) % CALLS.len()];
    let picture = drawn::scene_png(1);
    let form = drawn::form(&[("overview", &picture)]);
    let takes_form = path.ends_with("inspections") || path.ends_with("depth-maps");
    let (media_type, body) = if takes_form { (drawn::FORM, &form) } else { ("image/png", &picture) };
    let headers: [(&[u8], &[u8]); 1] = [(b"content-type", media_type.as_bytes())];
    let body = if method == "GET" { &[][..] } else { body };
    send(Call { method, target: &format!("{path}?{query}"), headers: &headers, body, piece_bytes: 0 });
});
