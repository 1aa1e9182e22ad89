//! Names, as text and in paths.
#![no_main]

use landmarkd::database::Name;
use landmarkd_fuzz::seeds;
use landmarkd_fuzz::service::{Call, send};
use libfuzzer_sys::fuzz_target;

const CALLS: [(&str, &str); 10] = [
    ("GET", "/v1/databases/{}"),
    ("PUT", "/v1/databases/{}"),
    ("GET", "/v1/databases/lab/exemplars/{}/image"),
    ("GET", "/v1/databases/lab/versions/{}/artifact"),
    ("GET", "/v1/databases/parts/versions/1/eigenimages/{}"),
    ("GET", "/v1/databases/lab/aliases/{}"),
    ("GET", "/v1/jobs/{}/events"),
    ("GET", "/v1/workcells/{}"),
    ("PUT", "/v1/calibrations/{}"),
    ("GET", "/{}"),
];

fuzz_target!(init: seeds::write(seeds::names), |bytes: &[u8]| {
    let [call, name @ ..] = bytes else { return };
    let Ok(name) = std::str::from_utf8(name) else { return };
    let first = name.chars().next().is_some_and(|c| c.is_ascii_alphanumeric());
    let others = name.chars().all(|c| c.is_ascii_alphanumeric() || "_.-".contains(c));
    assert_eq!(Name::parse(name).is_ok(), first && others && name.len() <= 64);
    let (method, path) = CALLS[usize::from(*call) % CALLS.len()];
    let headers: [(&[u8], &[u8]); 1] = [(b"content-type", b"application/json")];
    let body = if method == "PUT" { &br#"{"kind":"landmarks"}"#[..] } else { b"" };
    let answer = send(Call { method, target: &path.replace("{}", name), headers: &headers, body, piece_bytes: 0 });
    // What was made under the name isn't kept.
    if answer.is_some_and(|answer| answer.status == 201) {
        send(Call { method: "DELETE", target: &path.replace("{}", name), ..Call::default() });
    }
});
