//! Whole requests: a line with method and target, lines of headers, an empty line, the body.
#![no_main]

use landmarkd_fuzz::seeds;
use landmarkd_fuzz::service::{Call, send};
use libfuzzer_sys::fuzz_target;

fuzz_target!(init: seeds::write(seeds::requests), |bytes: &[u8]| {
    let end = bytes.windows(2).position(|pair| pair == b"\n\n");
    let (head, body) = end.map_or((bytes, &[][..]), |end| (&bytes[..end], &bytes[end + 2..]));
    let mut lines = head.split(|byte| *byte == b'\n');
    let Some(Ok(first)) = lines.next().map(std::str::from_utf8) else { return };
    let Some((method, target)) = first.split_once(' ') else { return };
    let headers: Vec<(&[u8], &[u8])> = lines
        .filter_map(|line| {
            let colon = line.iter().position(|byte| *byte == b':')?;
            Some((&line[..colon], line[colon + 1..].trim_ascii()))
        })
        .collect();
    send(Call { method, target, headers: &headers, body, piece_bytes: 0 });
});
