//! Manifests of exemplars and of a sweep's planes, in forms that hold the files a, b and c.
#![no_main]

use landmarkd_fuzz::service::{Call, send};
use landmarkd_fuzz::{drawn, seeds};
use libfuzzer_sys::fuzz_target;

const CALLS: [&str; 2] = ["/v1/databases/lab/exemplars:batch", "/v1/calibrations/rig/sweep"];

fuzz_target!(init: seeds::write(seeds::manifests), |bytes: &[u8]| {
    let [call, manifest @ ..] = bytes else { return };
    let picture = drawn::scene_png(3);
    let form = drawn::form(&[("manifest", manifest), ("a", &picture), ("b", &picture), ("c", b"none")]);
    let headers: [(&[u8], &[u8]); 1] = [(b"content-type", drawn::FORM.as_bytes())];
    let target = CALLS[usize::from(*call) % CALLS.len()];
    send(Call { method: "POST", target, headers: &headers, body: &form, piece_bytes: 0 });
});
