//! The sweep job: pictures of textured planes at known depths → what the method says of each → the rig's table.
//!
//! One transaction writes the rig's document and ends the job; a rig that was changed meanwhile keeps what it is.

use bytes::Bytes;
use serde::{Deserialize, Serialize};
use tokio::sync::watch;

use super::runner::{Lease, Stop};
use crate::compute::{Compute, Lane};
use crate::database::{DatabaseError, Databases, JobRow, Name, PictureBlob, Rig};
use crate::telemetry::chain;
use landmarkd_core::depth::{FocalPair, Method, PairError, Sweep, SweepError};
use landmarkd_core::imaging::{self, DecodeError, DecodeLimits};

/// The word for this job in the catalogue.
pub(super) const KIND: &str = "sweep";

/// What a sweep is asked to do, settled when it is queued.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepParams {
    /// The rig's revision then: a sweep is about that rig and no later one.
    pub revision: i64,
    pub method: Method,
    /// Whether aperture, separation and near plane are fitted first.
    pub fit_optics: bool,
    pub planes: Vec<SweepPlane>,
}

/// One plane's depth and pictures.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SweepPlane {
    pub depth_mm: f64,
    pub near: PictureBlob,
    pub far: PictureBlob,
}

#[derive(Serialize, Deserialize)]
struct ParamsDocument {
    revision: i64,
    method: MethodDocument,
    fit_optics: bool,
    planes: Vec<SweepPlane>,
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum MethodDocument {
    Gram,
    Laplacian,
    Stm,
}

impl SweepParams {
    pub(super) fn to_document(&self) -> String {
        let document = ParamsDocument {
            revision: self.revision,
            method: match self.method {
                Method::Gram => MethodDocument::Gram,
                Method::Laplacian => MethodDocument::Laplacian,
                Method::Stm => MethodDocument::Stm,
            },
            fit_optics: self.fit_optics,
            planes: self.planes.clone(),
        };
        serde_json::to_string(&document).expect("numbers and words always serialise")
    }

    fn from_document(text: &str) -> Result<Self, Stop> {
        let unreadable =
            |error: serde_json::Error| Stop::Failed { code: "internal", detail: error.to_string() };
        let document: ParamsDocument = serde_json::from_str(text).map_err(unreadable)?;
        Ok(Self {
            revision: document.revision,
            method: match document.method {
                MethodDocument::Gram => Method::Gram,
                MethodDocument::Laplacian => Method::Laplacian,
                MethodDocument::Stm => Method::Stm,
            },
            fit_optics: document.fit_optics,
            planes: document.planes,
        })
    }

    /// The blobs that the job will read.
    pub(super) fn blobs(&self) -> Vec<String> {
        self.planes.iter().flat_map(|plane| [plane.near.blob.clone(), plane.far.blob.clone()]).collect()
    }
}

/// The word of the problem that a sweep ends with.
pub fn sweep_problem(error: &SweepError) -> &'static str {
    match error {
        SweepError::TooFewPlanes { .. } => "too_few_planes",
        SweepError::TooLittleTexture { .. } => "too_little_texture",
        SweepError::NotMonotone { .. } => "not_monotone",
        SweepError::Estimate(_) => "image_size_mismatch",
        _ => "sweep_refused",
    }
}

impl From<SweepError> for Stop {
    fn from(error: SweepError) -> Self {
        Self::Failed { code: sweep_problem(&error), detail: chain(&error) }
    }
}

/// Measure the planes, fit the table, and end the job with the rig's new document.
pub(super) async fn run(
    job: &JobRow,
    lease: &Lease,
    databases: &Databases,
    compute: &Compute,
    decode: &DecodeLimits,
) -> Result<(), Stop> {
    let params = SweepParams::from_document(&job.params)?;
    let name = job.calibration.as_deref().and_then(|name| Name::parse(name).ok());
    let name =
        name.ok_or(Stop::Failed { code: "internal", detail: "the sweep is about no calibration".into() })?;
    let rig = databases.rig(&name).await?;
    if rig.revision != params.revision {
        return Err(DatabaseError::CalibrationChanged { calibration: rig.name }.into());
    }
    let worker = Worker { lease, databases, compute, decode };
    let swept = worker.measured(&rig, &params).await?;
    let fitted = worker.fitted(swept, params.fit_optics).await?;
    lease.go_on()?;
    Ok(databases.publish_rig((lease.id, lease.token), &rig, &fitted).await?)
}

/// What it takes to read pictures and to compute.
struct Worker<'a> {
    lease: &'a Lease,
    databases: &'a Databases,
    compute: &'a Compute,
    decode: &'a DecodeLimits,
}

impl Worker<'_> {
    /// The sweep with every plane measured, one after another: two pictures are held at a time.
    async fn measured(&self, rig: &Rig, params: &SweepParams) -> Result<Sweep, Stop> {
        let depths_mm: Vec<f64> = params.planes.iter().map(|plane| plane.depth_mm).collect();
        let (calibration, method) = (rig.calibration.clone(), params.method);
        let begin = move || Sweep::new(&calibration, method, &depths_mm);
        let mut sweep = self.on_lane(0, begin).await??;
        let total = params.planes.len() as u64;
        for (done, plane) in params.planes.iter().enumerate() {
            self.lease.progress("measure", done as u64, total).await?;
            let (near, far) = (self.picture(&plane.near).await?, self.picture(&plane.far).await?);
            let limits = *self.decode;
            let memory = [&near, &far]
                .map(|bytes| imaging::read_header(bytes, &limits).map_or(0, |header| header.depth_bytes()));
            let depth_mm = plane.depth_mm;
            let measure = move || {
                sweep.add(depth_mm, &pair(&near, &far, depth_mm, &limits)?)?;
                Ok::<_, Stop>(sweep)
            };
            sweep = self.on_lane(memory.iter().sum(), measure).await??;
        }
        Ok(sweep)
    }

    /// The rig with its table. The wish to cancel is heard between steps.
    async fn fitted(
        &self,
        sweep: Sweep,
        fit_optics: bool,
    ) -> Result<landmarkd_core::depth::Calibration, Stop> {
        self.lease.progress("fit", 0, 1).await?;
        let (tell, mut told) = watch::channel((0, 1));
        let lease = self.lease.clone();
        let fit = move || {
            sweep.fit(fit_optics, &mut |done, total| {
                tell.send_replace((done, total));
                lease.go_on().is_ok()
            })
        };
        let fitting = self.on_lane(0, fit);
        tokio::pin!(fitting);
        let fitted = loop {
            tokio::select! {
                fitted = &mut fitting => break fitted??,
                Ok(()) = told.changed() => {
                    let (done, total) = *told.borrow_and_update();
                    self.lease.progress("fit", done, total).await?;
                }
            }
        };
        self.lease.go_on()?;
        fitted.ok_or(Stop::Cancelled)
    }

    async fn on_lane<T: Send + 'static>(
        &self,
        picture_bytes: u64,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, Stop> {
        let (value, _) =
            self.compute.run(Lane::Training, picture_bytes, work).await.map_err(DatabaseError::from)?;
        Ok(value)
    }

    async fn picture(&self, kept: &PictureBlob) -> Result<Bytes, Stop> {
        self.databases.picture(kept).await.map_err(|error| match Stop::from(error) {
            Stop::Failed { code: "unreadable_exemplar", detail } => {
                Stop::Failed { code: "unreadable_picture", detail }
            }
            stop => stop,
        })
    }
}

/// The focal pair of a plane.
fn pair(near: &Bytes, far: &Bytes, depth_mm: f64, limits: &DecodeLimits) -> Result<FocalPair, Stop> {
    let read =
        |bytes: &Bytes| Ok((imaging::decode(bytes, limits)?, imaging::read_header(bytes, limits)?.bits));
    let unreadable = |error: DecodeError| Stop::Failed {
        code: "unreadable_picture",
        detail: format!("a picture of the plane at {depth_mm} mm: {}", chain(&error)),
    };
    let (near, near_bits) = read(near).map_err(unreadable)?;
    let (far, far_bits) = read(far).map_err(unreadable)?;
    FocalPair::new(near, far, near_bits.min(far_bits)).map_err(|error| Stop::Failed {
        code: match error {
            PairError::SizeMismatch { .. } => "image_size_mismatch",
            PairError::Identical => "identical_images",
            PairError::TooSmall { .. } => "image_too_small",
        },
        detail: format!("the plane at {depth_mm} mm: {error}"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_asked_comes_back_from_its_document() {
        let kept = |name: &str| PictureBlob { blob: name.into(), bytes: 7 };
        let params = SweepParams {
            revision: 3,
            method: Method::Laplacian,
            fit_optics: true,
            planes: vec![SweepPlane { depth_mm: 512.25, near: kept("a"), far: kept("b") }],
        };
        assert_eq!(SweepParams::from_document(&params.to_document()).unwrap(), params);
        assert_eq!(params.blobs(), ["a", "b"]);
        assert!(matches!(SweepParams::from_document("{}"), Err(Stop::Failed { code: "internal", .. })));
    }
}
