//! The artifact reader on bytes, as they come and with their checksum corrected.
#![no_main]

use landmarkd_fuzz::{artifacts, seeds};
use libfuzzer_sys::fuzz_target;

fuzz_target!(init: seeds::write(seeds::trained), |bytes: &[u8]| {
    artifacts::read(bytes);
    if let Some(with_checksum) = artifacts::with_checksum(bytes) {
        artifacts::read(&with_checksum);
    }
});
