//! The artifact reader on bytes, as they come and with their checksum put right.
#![no_main]

use landmarkd_fuzz::{artifacts, seeds};
use libfuzzer_sys::fuzz_target;

fuzz_target!(init: seeds::write(seeds::trained), |bytes: &[u8]| {
    artifacts::read(bytes);
    if let Some(sealed) = artifacts::sealed(bytes) {
        artifacts::read(&sealed);
    }
});
