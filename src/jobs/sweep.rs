//! The sweep job: pictures of textured planes at known depths, the method's measurement of each, the rig's table.
//!
//! One transaction writes the rig's document and ends the job; a rig that was changed meanwhile keeps what it is.

use bytes::Bytes;
use serde::{Deserialize, Serialize};
use tokio::sync::watch;

use super::stop::{Failure, Stop};
use super::worker::Worker;
use crate::database::{DatabaseError, Databases, JobRow, Name, PictureBlob, Rig};
use crate::problem::Code;
use crate::telemetry::chain;
use landmarkd_core::depth::{Calibration, FocalPair, Method, Sweep, SweepError};
use landmarkd_core::imaging::{self, DecodeLimits};

/// The word for this job in the catalogue.
pub(super) const KIND: &str = "sweep";

/// The parameters of a sweep, fixed when it is queued and kept with the job.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SweepParams {
    /// The rig's revision then: a sweep is about that rig and no later one.
    pub revision: i64,
    /// The method that the table is for.
    #[serde(with = "MethodWord")]
    pub method: Method,
    /// Whether aperture, separation and near plane are fitted first.
    pub fit_optics: bool,
    /// The planes, in the order in which they were sent.
    pub planes: Vec<SweepPlane>,
}

/// One plane's depth and pictures.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SweepPlane {
    /// Distance of the plane from the lens.
    pub depth_mm: f64,
    /// The near-focused picture.
    pub near: PictureBlob,
    /// The far-focused picture.
    pub far: PictureBlob,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Method", rename_all = "snake_case")]
enum MethodWord {
    Gram,
    Laplacian,
    Stm,
}

impl SweepParams {
    pub(super) fn to_document(&self) -> String {
        serde_json::to_string(self).expect("numbers and words always serialise")
    }

    fn from_document(text: &str) -> Result<Self, Stop> {
        serde_json::from_str(text).map_err(|error| Stop::failed(Code::Internal, error.to_string()))
    }

    /// The blobs that the job reads.
    pub(super) fn blobs(&self) -> Vec<String> {
        self.planes.iter().flat_map(|plane| [plane.near.blob.clone(), plane.far.blob.clone()]).collect()
    }
}

impl From<SweepError> for Stop {
    fn from(error: SweepError) -> Self {
        Self::failed((&error).into(), chain(&error))
    }
}

/// Measure the planes, fit the table, and end the job with the rig's new document.
pub(super) async fn run(worker: &Worker<'_>, job: &JobRow) -> Result<(), Stop> {
    let Worker { lease, databases, .. } = worker;
    let params = SweepParams::from_document(&job.params)?;
    let name = job.calibration.as_deref().and_then(|name| Name::parse(name).ok());
    let name = name.ok_or_else(|| Stop::failed(Code::Internal, "the sweep is about no calibration"))?;
    let rig = databases.rig(&name).await?;
    if rig.revision != params.revision {
        return Err(DatabaseError::CalibrationChanged { calibration: rig.name }.into());
    }
    let sweep = measure(worker, &rig, &params).await?;
    let fitted = fit(worker, sweep, params.fit_optics).await?;
    lease.check()?;
    Ok(databases.publish_rig((lease.id, lease.token), &rig, &fitted).await?)
}

/// The sweep with every plane measured, one after another: two pictures are held at a time.
async fn measure(worker: &Worker<'_>, rig: &Rig, params: &SweepParams) -> Result<Sweep, Stop> {
    let depths_mm: Vec<f64> = params.planes.iter().map(|plane| plane.depth_mm).collect();
    let (calibration, method) = (rig.calibration.clone(), params.method);
    let mut sweep = worker.run(0, move || Sweep::new(&calibration, method, &depths_mm)).await??;
    let total = params.planes.len() as u64;
    for (done, plane) in params.planes.iter().enumerate() {
        worker.lease.progress("measure", done as u64, total).await?;
        let near = picture(worker.databases, &plane.near).await?;
        let far = picture(worker.databases, &plane.far).await?;
        let (depth_mm, limits) = (plane.depth_mm, *worker.decode);
        let memory = |bytes| imaging::read_header(bytes, &limits).map_or(0, |header| header.depth_bytes());
        let memory = memory(&near) + memory(&far);
        let add = move || {
            sweep.add(depth_mm, &pair(&near, &far, depth_mm, &limits)?)?;
            Ok::<_, Stop>(sweep)
        };
        sweep = worker.run(memory, add).await??;
    }
    Ok(sweep)
}

/// The rig with its table. A request to cancel takes effect between two steps of the fit.
async fn fit(worker: &Worker<'_>, sweep: Sweep, fit_optics: bool) -> Result<Calibration, Stop> {
    worker.lease.progress("fit", 0, 1).await?;
    let (sender, mut steps) = watch::channel((0, 1));
    let lease = worker.lease.clone();
    let fit = move || {
        sweep.fit(fit_optics, &mut |done, total| {
            sender.send_replace((done, total));
            lease.check().is_ok()
        })
    };
    let fitting = worker.run(0, fit);
    tokio::pin!(fitting);
    let fitted = loop {
        tokio::select! {
            fitted = &mut fitting => break fitted??,
            Ok(()) = steps.changed() => {
                let (done, total) = *steps.borrow_and_update();
                worker.lease.progress("fit", done, total).await?;
            }
        }
    };
    worker.lease.check()?;
    fitted.ok_or(Stop::Cancelled)
}

async fn picture(databases: &Databases, kept: &PictureBlob) -> Result<Bytes, Stop> {
    databases.picture(kept).await.map_err(|error| match Stop::from(error) {
        Stop::Failed(failure) if failure.code == Code::UnreadableExemplar => {
            Stop::Failed(Failure { code: Code::UnreadablePicture, ..failure })
        }
        stop => stop,
    })
}

/// The focal pair of a plane.
fn pair(near: &Bytes, far: &Bytes, depth_mm: f64, limits: &DecodeLimits) -> Result<FocalPair, Stop> {
    let read = |bytes: &Bytes| {
        let decoded = imaging::decode(bytes, limits)
            .and_then(|frame| Ok((frame, imaging::read_header(bytes, limits)?.bits)));
        decoded.map_err(|error| {
            let text = format!("a picture of the plane at {depth_mm} mm: {}", chain(&error));
            Stop::failed(Code::UnreadablePicture, text)
        })
    };
    let ((near, near_bits), (far, far_bits)) = (read(near)?, read(far)?);
    FocalPair::new(near, far, near_bits.min(far_bits))
        .map_err(|error| Stop::failed((&error).into(), format!("the plane at {depth_mm} mm: {error}")))
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
        let Err(Stop::Failed(failure)) = SweepParams::from_document("{}") else { panic!("it was read") };
        assert_eq!(failure.code, Code::Internal);
    }
}
