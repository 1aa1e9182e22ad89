//! The reader of forms, at every call that takes one.
#![no_main]

use landmarkd_fuzz::service::{Call, send};
use landmarkd_fuzz::{drawn, seeds};
use libfuzzer_sys::fuzz_target;

const CALLS: [&str; 9] = [
    "/v1/databases/lab/exemplars:batch",
    "/v1/databases/lab/recognitions",
    "/v1/databases/placed/recognitions:batch",
    "/v1/depth-maps",
    "/v1/segmentations",
    "/v1/calibrations/rig/registration",
    "/v1/calibrations/rig/sweep",
    "/v1/workcells/bench/inspections",
    "/v1/workcells/bench/centrings",
];

fuzz_target!(init: seeds::write(seeds::forms), |bytes: &[u8]| {
    let [call, pieces, body @ ..] = bytes else { return };
    let target = CALLS[usize::from(*call) % CALLS.len()];
    let headers: [(&[u8], &[u8]); 1] = [(b"content-type", drawn::FORM.as_bytes())];
    send(Call { method: "POST", target, headers: &headers, body, piece_bytes: 1 << (pieces % 12) });
});
