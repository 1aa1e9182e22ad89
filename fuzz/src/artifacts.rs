//! Artifact files: correcting the checksum of a changed one, and what must hold for every one that is read.

use bytes::Bytes;
use landmarkd::database::artifact::{self, Artifact};
use landmarkd::database::{Model, Options};
use landmarkd_core::imaging::{Frame, Image};
use landmarkd_core::recognition::{landmarks, objects};

use crate::drawn;
use crate::service::{Call, send};

/// Artifacts of every kind and method, as the service gives them.
pub fn trained() -> Vec<Vec<u8>> {
    let files = ["lab", "placed", "parts"].map(|database| {
        let target = format!("/v1/databases/{database}/versions/1/artifact");
        let answer = send(Call { method: "GET", target: &target, ..Call::default() });
        answer.expect("this is a request").body.to_vec()
    });
    files.into()
}

const CHECKSUM: &[u8] = br#"\"checksum\":\""#;
const CHECKSUM_DIGITS: usize = 64;

/// The file with its checksum corrected, if there is a place for one.
pub fn with_checksum(file: &[u8]) -> Option<Vec<u8>> {
    let before = file.windows(CHECKSUM.len()).position(|window| window == CHECKSUM)?;
    let digits = before + CHECKSUM.len()..before + CHECKSUM.len() + CHECKSUM_DIGITS;
    let mut corrected = file.to_vec();
    corrected.get_mut(digits.clone())?.fill(b'0');
    let checksum = blake3::hash(&corrected).to_hex();
    corrected[digits].copy_from_slice(checksum.as_bytes());
    Some(corrected)
}

/// Read a file; one that is taken must be whole: it recognises, and it writes itself.
pub fn read(file: &[u8]) {
    let Ok(read) = artifact::read(Bytes::copy_from_slice(file)) else { return };
    let written = Bytes::from(artifact::write(&read));
    let again =
        artifact::read(written.clone()).unwrap_or_else(|error| panic!("what was written isn't read: {error}"));
    assert!(artifact::write(&again) == written, "the same version gives the same bytes");
    use_it(&read);
}

fn use_it(artifact: &Artifact) {
    assert!(artifact.model.options().faults().is_empty(), "options that can't be were taken");
    let flat = |side_px| Frame::gray(Image::from_fn(side_px, side_px, |_, _| 7.0));
    for frame in [drawn::scene(1), flat(1), flat(20)] {
        match &artifact.model {
            Model::Landmarks(model) => {
                let recognition = model.recognise(&frame, |_| ());
                landmarks::annotate(&frame, &recognition, model);
                model.labels();
            }
            Model::Objects(model) => {
                if let Ok(recognition) = model.recognise(&frame, |_| ()) {
                    objects::annotate(&frame, &recognition);
                }
                model.mean_picture();
                model.eigenimage(0);
            }
        }
    }
    let _: Options = artifact.model.options();
}
