//! The artifact file: one version as one self-describing file.
//!
//! It is a safetensors file, so Python, JAX or a notebook reads its tensors without us; each kind has its own, see
//! [`landmarks`] and [`objects`]. Everything else is one JSON text under the metadata key `landmarkd` (one key, so
//! that the same version gives the same bytes): format, kind, algorithm revision, digest of the inputs, checksum,
//! options, counts, and what the kind adds, its report among it.
//!
//! The checksum is the hash of the whole file with the checksum's own digits set to `0`: no byte can change
//! unseen. The file may come from anywhere: a wrong one is refused with what is wrong, never a panic.

mod landmarks;
mod objects;
pub mod outline;

use std::borrow::Cow;
use std::collections::HashMap;
use std::error::Error;
use std::ops::Range;

use bytes::Bytes;
use outline::ExemplarPlace;
use safetensors::tensor::{Dtype, Metadata, SafeTensors, TensorInfo, TensorView};
use serde::{Deserialize, Serialize};

use super::options::{DocumentError, Options};
use super::report::Report;
use super::survey::{Survey, Surveys};
use super::{ALGORITHM_REVISION, Counts, Kind, Model};
use crate::store::BlobName;
use landmarkd_core::recognition::landmarks::LandmarkParts;
use landmarkd_core::recognition::objects::ObjectParts;

/// The newest format; older ones are read for ever.
const FORMAT: u32 = 2;
/// The format of all but windows in lists: as earlier releases have it, so that they read it.
const EARLIER_FORMAT: u32 = 1;
const METADATA_KEY: &str = "landmarkd";

/// A version as its file has it.
pub struct Artifact {
    /// Digest of the inputs, hex.
    pub digest: String,
    /// The revision of the algorithm that trained it.
    pub algorithm_revision: i64,
    /// How much it was trained from.
    pub counts: Counts,
    /// The report of its training, without timings.
    pub report: Report,
    /// What it recognises with.
    pub model: Model,
    /// Where its exemplars were taken.
    pub surveys: Surveys,
}

impl Artifact {
    /// The kind of database it belongs to.
    pub fn kind(&self) -> Kind {
        self.model.kind()
    }

    /// The options it was trained with, as they are kept.
    pub fn options_document(&self) -> String {
        self.model.options().to_document()
    }
}

/// Why a file is no artifact that can be used.
#[derive(Debug, thiserror::Error)]
pub enum ArtifactError {
    /// The file can't be parsed.
    #[error("the file is no safetensors file, or it is cut off")]
    NotSafetensors {
        /// Why not.
        #[source]
        source: safetensors::SafeTensorError,
    },
    /// The header is missing or can't be parsed.
    #[error("the file's metadata is not that of a landmarkd artifact")]
    Metadata {
        /// What is wrong with the header; none where it is missing.
        #[source]
        source: Option<serde_json::Error>,
    },
    /// A newer release wrote the file.
    #[error("the file has format {found}; this release reads up to {FORMAT}: update the service")]
    TooNew {
        /// The file's format.
        found: u32,
    },
    /// A newer release trained the version.
    #[error("the file comes from algorithm revision {found}; this release knows up to {ALGORITHM_REVISION}")]
    Revision {
        /// The file's algorithm revision.
        found: i64,
    },
    /// No kind has that name.
    #[error("the file is of kind {kind}, which this release can't use")]
    KindUnknown {
        /// The file's kind.
        kind: String,
    },
    /// A byte of the file isn't what was written.
    #[error("the file's checksum doesn't match: it was damaged or changed")]
    Checksum,
    /// The options aren't those of a version.
    #[error("the options in the file can't be used")]
    Options {
        /// What is wrong with them.
        #[source]
        source: DocumentError,
    },
    /// A tensor can't be read.
    #[error("tensor {name} is missing, or not of the type it must have")]
    Tensor {
        /// The tensor's name.
        name: String,
    },
    /// The tensors are no model.
    #[error("the parts of the file don't fit together")]
    Parts {
        /// What is wrong with them.
        #[source]
        source: Box<dyn Error + Send + Sync>,
    },
    /// The header doesn't describe the model.
    #[error("the counts, names or digest in the file are not those of an artifact")]
    Contents,
}

/// The members of the header that every kind has.
#[derive(Serialize, Deserialize)]
struct Header {
    format: u32,
    kind: String,
    algorithm_revision: i64,
    digest: String,
    checksum: String,
    /// The options' document, as text: its digits are part of the digest.
    options: String,
    counts: Counts,
}

/// The header with what the kind adds, as it is written.
#[derive(Serialize)]
struct WholeHeader<K> {
    #[serde(flatten)]
    common: Header,
    #[serde(flatten)]
    of_kind: K,
}

/// A tensor to write.
struct Tensor<'a> {
    name: &'static str,
    dtype: Dtype,
    shape: Vec<usize>,
    /// The values row by row, little-endian.
    bytes: Cow<'a, [u8]>,
}

impl<'a> Tensor<'a> {
    fn new(name: &'static str, dtype: Dtype, shape: Vec<usize>, bytes: Cow<'a, [u8]>) -> Self {
        Self { name, dtype, shape, bytes }
    }

    /// A tensor of 32-bit floating point numbers.
    fn of_f32(name: &'static str, shape: Vec<usize>, values: &[f32]) -> Self {
        Self::new(name, Dtype::F32, shape, le_bytes(values, f32::to_le_bytes))
    }

    /// A vector of 64-bit floating point numbers.
    fn of_f64(name: &'static str, values: &[f64]) -> Self {
        Self::new(name, Dtype::F64, vec![values.len()], le_bytes(values, f64::to_le_bytes))
    }
}

const CHECKSUM: &str = "checksum";
/// The digits of a hash before they are known.
const NO_DIGITS: &str = "0000000000000000000000000000000000000000000000000000000000000000";

/// The artifact as a file.
///
/// # Panics
/// If the report is not of the model's kind.
pub fn write(artifact: &Artifact) -> Vec<u8> {
    let header = common_header(artifact);
    match (&artifact.model, &artifact.report) {
        (Model::Landmarks(model), Report::Landmarks(report)) => {
            let parts = LandmarkParts::from(&**model);
            write_parts(header, landmarks::header_and_tensors(&parts, report, &artifact.surveys))
        }
        (Model::Objects(model), Report::Objects(report)) => {
            let parts = ObjectParts::from(&**model);
            write_parts(header, objects::header_and_tensors(&parts, report))
        }
        _ => panic!("the report is of the model's kind"),
    }
}

fn common_header(artifact: &Artifact) -> Header {
    Header {
        format: if artifact.model.options().have_gradients() { FORMAT } else { EARLIER_FORMAT },
        kind: artifact.kind().as_str().into(),
        algorithm_revision: artifact.algorithm_revision,
        digest: artifact.digest.clone(),
        checksum: NO_DIGITS.into(),
        options: artifact.options_document(),
        counts: artifact.counts,
    }
}

fn write_parts(common: Header, (of_kind, tensors): (impl Serialize, Vec<Tensor<'_>>)) -> Vec<u8> {
    let header = WholeHeader { common, of_kind };
    let header = serde_json::to_string(&header).expect("numbers and text always serialise");
    let views = tensors.iter().map(|tensor| {
        let view = TensorView::new(tensor.dtype, tensor.shape.clone(), &tensor.bytes);
        (tensor.name, view.expect("each shape is that of its vector"))
    });
    let metadata = HashMap::from([(METADATA_KEY.to_owned(), header)]);
    let mut file = safetensors::serialize(views, Some(metadata)).expect("each name stands once");
    let put = |file: &mut Vec<u8>, member: &str, digits: String| {
        let at = digits_of(file, member).expect("the header was written with it");
        file[at].copy_from_slice(digits.as_bytes());
    };
    if let Some(outline) = outline_of_file(&file) {
        put(&mut file, outline::MEMBER, outline);
    }
    let checksum = BlobName::of(&file).to_string();
    put(&mut file, CHECKSUM, checksum);
    file
}

/// Where the digits of a hash stand in a file, by the name of the header's member: quoted, so that no label reads like it.
fn digits_of(file: &[u8], member: &str) -> Option<Range<usize>> {
    let quoted = format!(r#"\"{member}\":\""#);
    let at = find(file, quoted.as_bytes())? + quoted.len();
    (at + NO_DIGITS.len() <= file.len()).then(|| at..at + NO_DIGITS.len())
}

/// The outline of a file that is being written, if it has exemplars that can be read by themselves.
fn outline_of_file(file: &[u8]) -> Option<String> {
    let (length, metadata) = SafeTensors::read_metadata(file).expect("it was written just now");
    let (header, data) = file.split_at(outline::PREFIX_LENGTH as usize + length);
    let (start, end) = metadata.info(outline::EXEMPLARS)?.data_offsets;
    outline::outline_of([header, &data[..start], &data[end..]])
}

/// Read an artifact file, checked whole.
///
/// # Errors
/// [`ArtifactError`]: what is wrong with the file.
pub fn read(file: Bytes) -> Result<Artifact, ArtifactError> {
    let (length, metadata) = SafeTensors::read_metadata(&file).map_err(not_safetensors)?;
    let text = header_of(&metadata)?;
    // before the checksum: a newer one may be computed otherwise
    let header: Header = read_header(text)?;
    if header.format <= FORMAT {
        verify_checksum(&file, &header.checksum)?;
    }
    let start = outline::PREFIX_LENGTH as usize + length;
    outline::verify(&file, text, &metadata, start)?;
    match read_file(text, File::of(&metadata, &[(0, file)], start))? {
        (artifact, places) if places.is_empty() => Ok(artifact),
        _ => Err(ArtifactError::Tensor { name: outline::EXEMPLARS.to_owned() }),
    }
}

fn not_safetensors(source: safetensors::SafeTensorError) -> ArtifactError {
    ArtifactError::NotSafetensors { source }
}

/// The text under the file's metadata key.
fn header_of(metadata: &Metadata) -> Result<&str, ArtifactError> {
    let text = metadata.metadata().as_ref().and_then(|metadata| metadata.get(METADATA_KEY));
    Ok(text.ok_or(ArtifactError::Metadata { source: None })?)
}

/// The artifact of a header and tensors whose hash is right, and where its exemplars lie if they are elsewhere.
fn read_file(text: &str, file: File) -> Result<(Artifact, Vec<ExemplarPlace>), ArtifactError> {
    let header: Header = read_header(text)?;
    if header.format > FORMAT {
        return Err(ArtifactError::TooNew { found: header.format });
    }
    if !(1..=ALGORITHM_REVISION).contains(&header.algorithm_revision) {
        return Err(ArtifactError::Revision { found: header.algorithm_revision });
    }
    let Some(kind) = Kind::parse(&header.kind) else {
        return Err(ArtifactError::KindUnknown { kind: header.kind });
    };
    let options =
        Options::from_document(kind, &header.options).map_err(|source| ArtifactError::Options { source })?;
    let (model, report, counts, places, surveys) = match options {
        Options::Landmarks(options) => {
            let of_kind: landmarks::LandmarkHeader = read_header(text)?;
            let report = Box::new(of_kind.report.clone());
            let surveys = of_kind.surveys.clone();
            let (model, counts, places) = landmarks::assemble(options, of_kind, file)?;
            (Model::Landmarks(Box::new(model)), Report::Landmarks(report), counts, places, surveys)
        }
        Options::Objects(options) => {
            let of_kind: objects::ObjectHeader = read_header(text)?;
            let report = Box::new(of_kind.report.clone());
            let (model, counts) = objects::assemble(options, of_kind, &file)?;
            (Model::Objects(Box::new(model)), Report::Objects(report), counts, Vec::new(), Surveys::new())
        }
    };
    let is_sound = surveys.values().all(Survey::is_sound);
    if !is_sound || counts != header.counts || header.digest.parse::<BlobName>().is_err() {
        return Err(ArtifactError::Contents);
    }
    let Header { digest, algorithm_revision, .. } = header;
    Ok((Artifact { digest, algorithm_revision, counts, report, model, surveys }, places))
}

/// The common part of a header, or that of a kind: each leaves the members of the other alone.
fn read_header<'a, H: Deserialize<'a>>(text: &'a str) -> Result<H, ArtifactError> {
    serde_json::from_str(text).map_err(|source| ArtifactError::Metadata { source: Some(source) })
}

/// Hash the file with the checksum's digits set to `0`.
fn verify_checksum(file: &[u8], checksum: &str) -> Result<(), ArtifactError> {
    let at = digits_of(file, CHECKSUM).ok_or(ArtifactError::Checksum)?;
    let parts = [&file[..at.start], NO_DIGITS.as_bytes(), &file[at.end..]];
    if BlobName::of_parts(parts).to_string() == checksum { Ok(()) } else { Err(ArtifactError::Checksum) }
}

fn find(text: &[u8], part: &[u8]) -> Option<usize> {
    (!part.is_empty()).then(|| text.windows(part.len()).position(|window| window == part)).flatten()
}

fn le_bytes<T: Copy, const N: usize>(values: &[T], bytes: impl Fn(T) -> [u8; N]) -> Cow<'static, [u8]> {
    values.iter().flat_map(|&value| bytes(value)).collect::<Vec<u8>>().into()
}

/// The tensors of a file, or some of them.
struct File {
    tensors: HashMap<String, (Dtype, Bytes)>,
}

impl File {
    /// Those that lie in parts of a file, each with its place in that; tensors start at `start`.
    fn of(metadata: &Metadata, parts: &[(usize, Bytes)], start: usize) -> Self {
        let within = |range: Range<usize>| {
            parts.iter().find_map(|(from, part)| {
                let first = start.checked_add(range.start)?.checked_sub(*from)?;
                let end = start.checked_add(range.end)?.checked_sub(*from)?;
                (first <= end && end <= part.len()).then(|| part.slice(first..end))
            })
        };
        let tensor = |(name, info): (String, &TensorInfo)| {
            Some((name, (info.dtype, within(info.data_offsets.0..info.data_offsets.1)?)))
        };
        Self { tensors: metadata.tensors().into_iter().filter_map(tensor).collect() }
    }

    fn has(&self, name: &str) -> bool {
        self.tensors.contains_key(name)
    }

    /// The bytes of a tensor of that type.
    fn data(&self, name: &str, dtype: Dtype) -> Result<&[u8], ArtifactError> {
        match self.tensors.get(name) {
            Some((found, bytes)) if *found == dtype => Ok(bytes),
            _ => Err(ArtifactError::Tensor { name: name.to_owned() }),
        }
    }

    /// The values of a tensor.
    fn values<T, const N: usize>(
        &self,
        name: &str,
        dtype: Dtype,
        value: impl Fn([u8; N]) -> T,
    ) -> Result<Vec<T>, ArtifactError> {
        let (values, rest) = self.data(name, dtype)?.as_chunks::<N>();
        if !rest.is_empty() {
            return Err(ArtifactError::Tensor { name: name.to_owned() });
        }
        Ok(values.iter().map(|bytes| value(*bytes)).collect())
    }

    /// The same for a tensor that may be absent.
    fn optional<T, const N: usize>(
        &self,
        name: &str,
        dtype: Dtype,
        value: impl Fn([u8; N]) -> T,
    ) -> Result<Option<Vec<T>>, ArtifactError> {
        self.has(name).then(|| self.values(name, dtype, value)).transpose()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::database::LandmarkReport;
    use landmarkd_core::imaging::{Frame, Image};
    use landmarkd_core::recognition::landmarks::{
        CalibrationSample, Evidence, ExemplarName, KeptExemplar, LandmarkOptions, Landmarks, Method,
        Signature, Viewpoint, describe,
    };
    use proptest::prelude::*;
    use serde_json::{Value, json};
    use uuid::Uuid;

    /// One with all that an artifact can hold.
    fn artifact() -> Artifact {
        let free = LandmarkOptions::with_signature(Method::Placement, Viewpoint::Free, Signature::Intensity);
        let mut artifact = of(free);
        let sample = |n: usize| {
            let (log_margin, lead, share, log_points) = (n as f64, n as f64, n as f64, n as f64);
            let evidence = Evidence::Vote { log_margin, lead, share, log_points };
            CalibrationSample { evidence, right: n > 12, known: n.is_multiple_of(2) }
        };
        let Model::Landmarks(model) = &mut artifact.model else { panic!("it is one of landmarks") };
        model.calibrate(&(0..24).map(sample).collect::<Vec<_>>()).unwrap();
        artifact
    }

    /// Two exemplars of 40×40 with a disc and a square; few rings, so that the file is small.
    fn of(options: LandmarkOptions) -> Artifact {
        let options = LandmarkOptions { interest_points: 4, rings: 4, sectors: 16, dimension: 2, ..options };
        let disc = Image::from_fn(40, 40, |x, y| {
            let (dx, dy) = (x as f32 - 17.0, y as f32 - 21.0);
            if dx * dx + dy * dy < 40.0 { 220.0 } else { 20.0 }
        });
        let square =
            Image::from_fn(
                40,
                40,
                |x, y| {
                    if (12..25).contains(&x) && (9..20).contains(&y) { 200.0 } else { 40.0 }
                },
            );
        trained(&options, [("disc", disc), ("square", square)])
    }

    /// A picture with something to see everywhere.
    fn tiles(seed: usize) -> Image {
        Image::from_fn(72, 64, |x, y| ((x / 5 * 131 + y / 7 * (37 + seed)) * 2_654_435 % 251) as f32)
    }

    /// Two exemplars with signatures of gradients.
    fn of_gradients() -> Artifact {
        let options = LandmarkOptions { interest_points: 20, dimension: 3, ..LandmarkOptions::default() };
        trained(&options, [("a", tiles(0)), ("bb", tiles(1))])
    }

    fn trained(options: &LandmarkOptions, pictures: [(&str, Image); 2]) -> Artifact {
        let described = pictures.map(|(label, image)| {
            let id = Uuid::new_v8([label.len() as u8; 16]).to_string();
            let name = ExemplarName { id, label: label.into() };
            describe(name, &Frame::gray(image), options)
        });
        let (landmarks, report) = Landmarks::train(described.into(), options).unwrap();
        Artifact {
            digest: BlobName::of(b"inputs").to_string(),
            algorithm_revision: 1,
            counts: Counts { exemplars: 2, labels: 2, interest_points: report.interest_points as u64 },
            report: Report::Landmarks(Box::new(LandmarkReport::from(&report))),
            model: Model::Landmarks(Box::new(landmarks)),
            surveys: [(
                Uuid::new_v8([1; 16]).to_string(),
                Survey { size_mm: Some(210.0), ..Survey::default() },
            )]
            .into(),
        }
    }

    /// What a file gives that is read without its windows, and its bytes exemplar by exemplar.
    fn outlined(file: &Bytes) -> Result<Option<(Artifact, Vec<ExemplarPlace>)>, ArtifactError> {
        let length = outline::header_length(&file[..8])? as usize;
        let Some(header) = file.get(..length) else { return Err(ArtifactError::Contents) };
        let header = Bytes::copy_from_slice(header);
        let Some(header) = outline::OutlineHeader::of(header, file.len() as u64)? else { return Ok(None) };
        let around = header.around.clone().map(|range| file.slice(range.start as usize..range.end as usize));
        header.read(around).map(Some)
    }

    #[test]
    fn a_file_read_without_its_windows_answers_with_those_it_needs() {
        let file = Bytes::from(write(&of_gradients()));
        let whole = read(file.clone()).unwrap();
        assert_eq!(write(&whole), file);
        let (outline, places) = outlined(&file).unwrap().unwrap();
        assert_eq!((&outline.digest, outline.counts), (&whole.digest, whole.counts));
        let (Model::Landmarks(outline), Model::Landmarks(whole)) = (&outline.model, &whole.model) else {
            panic!("it is one of landmarks")
        };
        assert!(!outline.has_windows() && outline.bytes() < whole.bytes() && places.len() == 2);
        let frame = Frame::gray(tiles(1));
        let asked = outline.ask(&frame, |_| ()).unwrap();
        assert_eq!(outline.likest(&asked, 1), [1]);
        let kept = places.iter().enumerate().map(|(index, place)| {
            let bytes = &file[place.range.start as usize..place.range.end as usize];
            assert_eq!(BlobName::of(bytes), place.name);
            let (rows, edges) = place.parts(bytes).unwrap();
            KeptExemplar { index, rows, edges }
        });
        let kept: Vec<KeptExemplar> = kept.collect();
        let among = |kept: &[KeptExemplar]| {
            outline.of_kept(kept.to_vec()).unwrap().recognise_asked(&asked, |_| ()).unwrap()
        };
        assert_eq!(among(&kept), whole.recognise(&frame, |_| ()));
        let second = among(&kept[1..]);
        assert_eq!((&second.votes[0].label[..], second.exemplar_weights.len()), ("bb", 1));
        assert!(outlined(&Bytes::from(write(&artifact()))).unwrap().is_none(), "signatures of intensities");
    }

    #[test]
    fn a_label_that_reads_like_a_hash_changes_nothing() {
        for digit in ["0", "1"] {
            let label = digit.repeat(64);
            let options = LandmarkOptions { interest_points: 20, dimension: 3, ..LandmarkOptions::default() };
            let file = Bytes::from(write(&trained(&options, [("a", tiles(0)), (&label, tiles(1))])));
            assert!(outlined(&file).unwrap().is_some());
            let Model::Landmarks(model) = read(file).unwrap().model else { panic!("it is one of landmarks") };
            assert!(model.labels().contains(&&label[..]));
        }
    }

    #[test]
    fn a_file_without_its_windows_or_with_wrong_names_is_refused() {
        let artifact = of_gradients();
        for lost in ["exemplars", "names", "descriptors", "vlad_centroids", "centroids"] {
            let without = changed(&artifact, |(_, tensors)| tensors.retain(|tensor| tensor.name != lost));
            assert!(without.is_err(), "{lost} is not missed");
        }
        let renamed = changed(&artifact, |(_, tensors)| {
            let names = tensors.iter_mut().find(|tensor| tensor.name == "names").unwrap();
            names.bytes.to_mut()[40] ^= 1;
        });
        assert!(renamed.is_err());
    }

    #[test]
    fn every_flipped_byte_of_an_outline_is_found() {
        let file = Bytes::from(write(&of_gradients()));
        let (_, places) = outlined(&file).unwrap().unwrap();
        let exemplars = places[0].range.start..places[1].range.end;
        let checksum = digits_of(&file, CHECKSUM).unwrap().start as u64;
        // the digits of the checksum are of the whole file
        let covered = |at: &u64| !exemplars.contains(at) && !(checksum..checksum + 64).contains(at);
        for at in (0..file.len() as u64).filter(covered) {
            let mut damaged = file.to_vec();
            damaged[at as usize] ^= 0x10;
            let read = outlined(&damaged.into());
            assert!(!matches!(read, Ok(Some(_))), "byte {at} of {} was flipped unseen", file.len());
        }
    }

    #[test]
    fn a_file_comes_back_as_the_same_version_and_the_same_bytes() {
        let written = artifact();
        let file = Bytes::from(write(&written));
        let read = read(file.clone()).unwrap();
        let (Model::Landmarks(before), Model::Landmarks(after)) = (&written.model, &read.model) else {
            panic!("a landmark database comes back as one")
        };
        assert_eq!(LandmarkParts::from(&**before), LandmarkParts::from(&**after));
        assert_eq!((read.digest.as_str(), read.counts), (written.digest.as_str(), written.counts));
        assert_eq!(write(&read), file);
        assert_eq!(write(&artifact()), file, "training the same twice gives the same bytes");
    }

    type Parts = (Value, Vec<Tensor<'static>>);

    fn owned(tensor: Tensor<'_>) -> Tensor<'static> {
        Tensor { bytes: tensor.bytes.into_owned().into(), ..tensor }
    }

    /// What reads back of an artifact with its own header and tensors changed.
    fn changed(artifact: &Artifact, change: impl Fn(&mut Parts)) -> Result<Artifact, ArtifactError> {
        let (Model::Landmarks(model), Report::Landmarks(report)) = (&artifact.model, &artifact.report) else {
            panic!("it is one of landmarks")
        };
        let parts = LandmarkParts::from(&**model);
        let (header, tensors) = landmarks::header_and_tensors(&parts, report, &artifact.surveys);
        let tensors = tensors.into_iter().map(owned).collect();
        let mut parts = (serde_json::to_value(header).unwrap(), tensors);
        change(&mut parts);
        read(write_parts(common_header(artifact), parts).into())
    }

    #[test]
    fn a_file_of_an_earlier_release_answers_as_it_did() {
        let written = of(LandmarkOptions::of(Method::Paper, Viewpoint::Free));
        let earlier = changed(&written, |(header, tensors)| {
            tensors.retain(|tensor| tensor.name != "radius");
            assert_eq!(tensors.len(), 6, "what there was before");
            for exemplar in header["exemplars"].as_array_mut().unwrap() {
                exemplar.as_object_mut().unwrap().remove("contour_points").unwrap();
            }
        });
        let earlier = earlier.unwrap();
        let (Model::Landmarks(before), Model::Landmarks(after)) = (&written.model, &earlier.model) else {
            panic!("a landmark database comes back as one")
        };
        assert_eq!(LandmarkParts::from(&**before), LandmarkParts::from(&**after));
        assert!(after.confidence().is_none());
    }

    #[test]
    fn parts_that_do_not_fit_are_refused() {
        let artifact = artifact();
        assert!(changed(&artifact, |_| ()).is_ok());
        let without = |lost: &'static str| {
            changed(&artifact, |(_, tensors)| tensors.retain(|tensor| tensor.name != lost))
        };
        for lost in ["basis", "owner", "spectra", "contours"] {
            assert!(without(lost).is_err(), "{lost} is not missed");
        }
        for (pointer, value) in [
            ("/exemplars/0/contour_points", json!(0)),
            ("/exemplars/1/contour_points", json!(100_000)),
            ("/exemplars/0/points", json!(1)),
            ("/confidence/threshold", json!(1.5)),
            ("/confidence/weights/2", json!(-1.0)),
            ("/confidence/weights", json!([1.0, 2.0])),
        ] {
            let changed =
                changed(&artifact, |(header, _)| *header.pointer_mut(pointer).unwrap() = value.clone());
            assert!(changed.is_err(), "{pointer} may be {value}");
        }
        let radius = |byte: u8| {
            changed(&artifact, |(_, tensors)| {
                let radius = tensors.iter_mut().find(|tensor| tensor.name == "radius").unwrap();
                *radius.bytes.to_mut().last_mut().unwrap() = byte;
            })
        };
        assert!(radius(1).is_ok() && radius(2).is_err());
    }

    #[test]
    fn every_flipped_byte_is_found() {
        let file = Bytes::from(write(&artifact()));
        for at in 0..file.len() {
            let mut damaged = file.to_vec();
            damaged[at] ^= 0x10;
            assert!(read(damaged.into()).is_err(), "byte {at} of {} was flipped unseen", file.len());
        }
    }

    #[test]
    fn a_file_cut_off_anywhere_is_refused() {
        let file = Bytes::from(write(&artifact()));
        for length in 0..file.len() {
            assert!(read(file.slice(..length)).is_err(), "cut off after {length} bytes");
        }
    }

    /// A number that some part may not expect.
    fn number() -> impl Strategy<Value = [u8; 4]> {
        let odd = [f32::NAN, f32::INFINITY, f32::MAX, f32::MIN_POSITIVE, -1.0, 0.0].map(f32::to_le_bytes);
        prop_oneof![
            proptest::sample::select(odd.to_vec()),
            any::<f32>().prop_map(f32::to_le_bytes),
            any::<[u8; 4]>()
        ]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(300))]

        /// The checksum is right and what it covers is wrong: refused, or a version that recognises.
        #[test]
        fn whatever_the_tensors_hold_is_refused_or_of_use(
            edits in proptest::collection::vec((any::<usize>(), any::<usize>(), number()), 1..4),
            rows in proptest::option::of((any::<usize>(), 0_usize..40)),
            gradients in any::<bool>(),
        ) {
            static TRAINED: std::sync::LazyLock<[Artifact; 2]> =
                std::sync::LazyLock::new(|| [artifact(), of_gradients()]);
            let changed = changed(&TRAINED[usize::from(gradients)], |(_, tensors)| {
                for (tensor, at, value) in &edits {
                    let count = tensors.len();
                    let bytes = tensors[tensor % count].bytes.to_mut();
                    let words = bytes.len() / 4;
                    if let Some(word) = at.checked_rem(words) {
                        bytes[4 * word..4 * word + 4].copy_from_slice(value);
                    }
                }
                if let Some((tensor, rows)) = rows {
                    let count = tensors.len();
                    let Tensor { shape, bytes, .. } = &mut tensors[tensor % count];
                    if let Some(row_bytes) = bytes.len().checked_div(shape[0]) {
                        shape[0] = rows;
                        bytes.to_mut().resize(rows * row_bytes, 0);
                    }
                }
            });
            if let Ok(Artifact { model: Model::Landmarks(model), .. }) = changed {
                model.recognise(&Frame::gray(tiles(0)), |_| ());
            }
        }
    }

    #[test]
    fn a_newer_format_says_so() {
        let file = Bytes::from(write(&artifact()));
        let at = find(&file, br#"\"format\":1"#).unwrap();
        let mut newer = file.to_vec();
        newer[at + 11] = b'9';
        assert!(matches!(read(newer.into()), Err(ArtifactError::TooNew { found: 9 })));
    }
}
