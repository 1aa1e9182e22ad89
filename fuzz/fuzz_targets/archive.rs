//! The reader of tar archives, with and without checksums put right.
#![no_main]

use landmarkd_fuzz::site::{Asked, ask};
use landmarkd_fuzz::{drawn, seeds};
use libfuzzer_sys::fuzz_target;

fuzz_target!(init: seeds::write(seeds::archives), |bytes: &[u8]| {
    let [mend, archive @ ..] = bytes else { return };
    let mended = if mend % 2 == 0 { archive.to_vec() } else { drawn::with_checksums(archive) };
    let headers: [(&[u8], &[u8]); 1] = [(b"content-type", b"application/x-tar")];
    let target = "/v1/databases/lab/exemplars:batch";
    ask(Asked { method: "POST", target, headers: &headers, body: &mended, piece_bytes: 256 });
});
