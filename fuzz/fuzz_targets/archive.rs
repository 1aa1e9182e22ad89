//! The reader of tar archives, with and without checksums corrected.
#![no_main]

use landmarkd_fuzz::service::{Call, send};
use landmarkd_fuzz::{drawn, seeds};
use libfuzzer_sys::fuzz_target;

fuzz_target!(init: seeds::write(seeds::archives), |bytes: &[u8]| {
    let [correct, archive @ ..] = bytes else { return };
    let archive = if correct % 2 == 0 { archive.to_vec() } else { drawn::with_checksums(archive) };
    let headers: [(&[u8], &[u8]); 1] = [(b"content-type", b"application/x-tar")];
    let target = "/v1/databases/lab/exemplars:batch";
    send(Call { method: "POST", target, headers: &headers, body: &archive, piece_bytes: 256 });
});
