//! The image wrapper: a picture's header and its pixels, under limits.
#![no_main]

use landmarkd_core::imaging::{DecodeLimits, decode, decode_reduced, read_header};
use landmarkd_fuzz::seeds;
use libfuzzer_sys::fuzz_target;

const LIMITS: DecodeLimits =
    DecodeLimits { max_side_px: 1024, max_pixels: 1 << 18, max_alloc_bytes: 4 << 20 };

fuzz_target!(init: seeds::write(seeds::pictures), |bytes: &[u8]| {
    let header = read_header(bytes, &LIMITS);
    let Ok(frame) = decode(bytes, &LIMITS) else { return };
    // Memory is set aside by the header, before anything is decoded: it must not say less than comes out.
    let header = header.expect("what decodes has a header");
    let (width_px, height_px) = (header.width_px as usize, header.height_px as usize);
    let size_px = (frame.width(), frame.height());
    assert!(size_px == (width_px, height_px) || size_px == (height_px, width_px), "{header:?} {size_px:?}");
    assert!(header.colour || !frame.is_colour(), "{header:?} says gray");
    assert!(width_px.max(height_px) <= 1024 && width_px * height_px <= 1 << 18);
    let reduced = decode_reduced(bytes, &LIMITS, 64).expect("what decodes whole decodes smaller");
    let whole = frame.at_most(64);
    assert_eq!((reduced.width(), reduced.height()), (whole.width(), whole.height()));
    let levels = frame.luminance.pixels().iter().chain(reduced.luminance.pixels());
    assert!(levels.clone().all(|level| (0.0..=255.01).contains(level)), "{:?}", levels.clone().find(|level| !(0.0..=255.01).contains(*level)));
});
