//! An artifact without the windows of its exemplars, which are read when they are needed: the file but for the tensor
//! `exemplars`, and where in that each exemplar lies.

use std::ops::Range;

use bytes::Bytes;
use safetensors::tensor::Metadata;

use super::landmarks::{LandmarkHeader, edge_points};
use super::{
    Artifact, ArtifactError, CHECKSUM, File, NO_DIGITS, digits_of, header_of, read_file, read_header,
};
use crate::store::BlobName;
use landmarkd_core::recognition::landmarks::EdgePoint;

/// The tensor that exemplars are read from one by one.
pub(super) const EXEMPLARS: &str = "exemplars";
/// The member of the header with the hash.
pub(super) const MEMBER: &str = "outline";

/// Bytes that say how long the header is.
pub const PREFIX_LENGTH: u64 = 8;

/// Where an exemplar's windows and edge points lie.
#[derive(Debug, Clone, PartialEq)]
pub struct ExemplarPlace {
    /// The hash of the bytes.
    pub name: BlobName,
    /// Where they lie: from the tensor's start, and once the outline is read from the file's.
    pub range: Range<u64>,
    /// How many of them, from the first on, are rows of windows.
    pub(super) rows_length: usize,
}

impl ExemplarPlace {
    /// The rows of windows and the edge points in the exemplar's bytes; `None` if those are of another length.
    pub fn parts<'a>(&self, bytes: &'a [u8]) -> Option<(&'a [u8], Vec<EdgePoint>)> {
        let is_whole = self.range.end - self.range.start == bytes.len() as u64;
        let (rows, edges) = bytes.split_at_checked(self.rows_length).filter(|_| is_whole)?;
        Some((rows, edge_points(edges)))
    }
}

/// The header of an artifact, with the parts of the file to read next.
pub struct OutlineHeader {
    header: Bytes,
    metadata: Metadata,
    /// What stands before the exemplars, and after them.
    pub around: [Range<u64>; 2],
    exemplars: Range<u64>,
}

/// Length of prefix and header, by a file's first [`PREFIX_LENGTH`] bytes.
///
/// # Errors
/// They are not those of an artifact.
pub fn header_length(prefix: &[u8]) -> Result<u64, ArtifactError> {
    /// The library's bound.
    const LONGEST: u64 = 100_000_000;
    let length = prefix.first_chunk().map(|bytes| u64::from_le_bytes(*bytes));
    match length {
        Some(length) if length < LONGEST => Ok(PREFIX_LENGTH + length),
        _ => Err(ArtifactError::Contents),
    }
}

impl OutlineHeader {
    /// Of prefix and header of a file of so many bytes; `None` if the file has no exemplars that can be read by themselves.
    ///
    /// # Errors
    /// They are not those of an artifact.
    pub fn of(header: Bytes, file_bytes: u64) -> Result<Option<OutlineHeader>, ArtifactError> {
        // the library reads it only with all that follows
        let text = header.get(PREFIX_LENGTH as usize..).unwrap_or_default();
        let metadata: Metadata = serde_json::from_slice(text)
            .map_err(|source| ArtifactError::Metadata { source: Some(source) })?;
        let Some(info) = metadata.info(EXEMPLARS) else { return Ok(None) };
        let start = header.len() as u64;
        let within = |offset: usize| start.checked_add(offset as u64).ok_or(ArtifactError::Contents);
        let exemplars = within(info.data_offsets.0)?..within(info.data_offsets.1)?;
        if exemplars.start > exemplars.end || exemplars.end > file_bytes {
            return Err(ArtifactError::Contents);
        }
        let around = [start..exemplars.start, exemplars.end..file_bytes];
        Ok(Some(OutlineHeader { header, metadata, around, exemplars }))
    }

    /// The artifact without its windows, and where those are, of what stands around the exemplars.
    ///
    /// # Errors
    /// [`ArtifactError`]: what is wrong with the file.
    pub fn read(self, [before, after]: [Bytes; 2]) -> Result<(Artifact, Vec<ExemplarPlace>), ArtifactError> {
        let Self { header, metadata, exemplars, .. } = self;
        let text = header_of(&metadata)?;
        verify_parts([&header, &before, &after], text)?;
        let parts = [(header.len(), before), (exemplars.end as usize, after)];
        let (artifact, mut places) = read_file(text, File::of(&metadata, &parts, header.len()))?;
        for place in &mut places {
            let in_file = |at: u64| at.checked_add(exemplars.start).ok_or(ArtifactError::Contents);
            place.range = in_file(place.range.start)?..in_file(place.range.end)?;
        }
        match places.last() {
            Some(last) if last.range.end == exemplars.end => Ok((artifact, places)),
            _ => Err(ArtifactError::Contents),
        }
    }
}

/// Holds a whole file against its outline, if it has one.
pub(super) fn verify(
    file: &[u8],
    text: &str,
    metadata: &Metadata,
    start: usize,
) -> Result<(), ArtifactError> {
    let Some(info) = metadata.info(EXEMPLARS) else { return Ok(()) };
    let (header, data) = file.split_at(start);
    let (first, end) = info.data_offsets;
    verify_parts([header, &data[..first], &data[end..]], text)
}

fn verify_parts(parts: [&[u8]; 3], text: &str) -> Result<(), ArtifactError> {
    let of_kind: LandmarkHeader = read_header(text)?;
    let outline = of_kind.outline.ok_or(ArtifactError::Contents)?;
    if outline_of(parts).is_some_and(|found| found == outline) {
        Ok(())
    } else {
        Err(ArtifactError::Checksum)
    }
}

/// The hash of a file's header and what stands around its exemplars, with the digits of checksum and outline as they are
/// before they are known; `None` if the header hasn't them.
pub(super) fn outline_of([header, before, after]: [&[u8]; 3]) -> Option<String> {
    let mut header = header.to_vec();
    for member in [CHECKSUM, MEMBER] {
        let at = digits_of(&header, member)?;
        header[at].copy_from_slice(NO_DIGITS.as_bytes());
    }
    Some(BlobName::of_parts([&header[..], before, after]).to_string())
}
