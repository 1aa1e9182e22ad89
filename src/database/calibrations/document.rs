//! The document a calibration is kept as: JSON with names of its own, so that renaming a field inside changes nothing
//! on the disk. Its names never change meaning; a new member needs a default.

use serde::{Deserialize, Serialize};

use crate::database::options::words;
use landmarkd_core::depth::{
    Aperture, Calibration, Fault, Filters, ImageSize, Method, NearSensor, Noise, Optics, OpticsSpec,
    Photometric, Registration, Residual, Table,
};

/// The version of the document's shape.
const VERSION: u32 = 1;

/// The kept document can't be read back.
#[derive(Debug, thiserror::Error)]
pub enum UnreadableCalibration {
    #[error("it is no document that this release reads")]
    Malformed {
        #[source]
        source: serde_json::Error,
    },
    #[error("its version is {version}; this release reads {VERSION}")]
    Version { version: u32 },
    #[error("its optics can't be: {}", .faults.iter().map(Fault::to_string).collect::<Vec<_>>().join("; "))]
    Optics { faults: Vec<Fault> },
    #[error("its table has columns of different lengths or doesn't rise, or its scale is no power of two")]
    Misshapen,
}

words!(Method, MethodWord, { Gram, Laplacian, Stm });

#[derive(Serialize, Deserialize)]
struct CalibrationDocument {
    version: u32,
    image: Option<ImageDocument>,
    optics: OpticsDocument,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    stated: Option<OpticsDocument>,
    registration: Option<RegistrationDocument>,
    photometric: Option<PhotometricDocument>,
    noise: Option<NoiseDocument>,
    filters: Option<FiltersDocument>,
    table: Option<TableDocument>,
    residual: Option<ResidualDocument>,
}

#[derive(Serialize, Deserialize)]
struct ImageDocument {
    width: usize,
    height: usize,
    bits: u8,
}

#[derive(Serialize, Deserialize)]
struct OpticsDocument {
    focal_length_mm: f64,
    aperture_mm: f64,
    near_plane_mm: f64,
    plane_separation_mm: f64,
    pixel_pitch_um: f64,
    telecentric: bool,
    principal_point_px: Option<[f64; 2]>,
}

#[derive(Serialize, Deserialize)]
struct RegistrationDocument {
    affine_far_to_near: [f64; 6],
    rms_px: f64,
}

#[derive(Serialize, Deserialize)]
struct PhotometricDocument {
    dark_near: f64,
    dark_far: f64,
    gain_far: f64,
}

#[derive(Serialize, Deserialize)]
struct NoiseDocument {
    read_sigma: f64,
    shot_gain: f64,
}

#[derive(Serialize, Deserialize)]
struct FiltersDocument {
    method: MethodWord,
    #[serde(rename = "K")]
    side: usize,
    #[serde(rename = "J")]
    rank: usize,
    band: f64,
    /// How many pixels' side the filters' pixel is: 1, 2, 4, …
    scale: u32,
    hash: String,
}

#[derive(Serialize, Deserialize)]
struct TableDocument {
    beta: Vec<f64>,
    raw: Vec<f64>,
    sigma: Vec<f64>,
    depth_mm: Vec<f64>,
}

#[derive(Serialize, Deserialize)]
struct ResidualDocument {
    rms_mm: f64,
    max_mm: f64,
}

/// The calibration as one line of JSON.
pub(super) fn text(calibration: &Calibration) -> String {
    let document = CalibrationDocument::from(calibration);
    serde_json::to_string(&document).expect("numbers and words always serialise")
}

/// Read a kept document back.
pub(super) fn read(text: &str) -> Result<Calibration, UnreadableCalibration> {
    let malformed = |source| UnreadableCalibration::Malformed { source };
    let document: CalibrationDocument = serde_json::from_str(text).map_err(malformed)?;
    document.try_into()
}

impl From<&Calibration> for CalibrationDocument {
    fn from(calibration: &Calibration) -> Self {
        Self {
            version: VERSION,
            image: calibration.image.map(|image| ImageDocument {
                width: image.width_px,
                height: image.height_px,
                bits: image.bits,
            }),
            optics: (&calibration.optics).into(),
            stated: calibration.stated.as_ref().map(OpticsDocument::from),
            registration: calibration.registration.map(|registration| RegistrationDocument {
                affine_far_to_near: registration.affine_far_to_near,
                rms_px: registration.rms_px,
            }),
            photometric: calibration.photometric.map(|photometric| PhotometricDocument {
                dark_near: photometric.dark_near,
                dark_far: photometric.dark_far,
                gain_far: photometric.gain_far,
            }),
            noise: calibration
                .noise
                .map(|noise| NoiseDocument { read_sigma: noise.read_sigma, shot_gain: noise.shot_gain }),
            filters: calibration.filters.as_ref().map(|filters| FiltersDocument {
                method: filters.method.into(),
                side: filters.side,
                rank: filters.rank,
                band: filters.band,
                scale: 1 << filters.halvings,
                hash: filters.hash.clone(),
            }),
            table: calibration.table.as_ref().map(|table| TableDocument {
                beta: table.beta.clone(),
                raw: table.raw.clone(),
                sigma: table.sigma.clone(),
                depth_mm: table.depth_mm.clone(),
            }),
            residual: calibration
                .residual
                .map(|residual| ResidualDocument { rms_mm: residual.rms_mm, max_mm: residual.max_mm }),
        }
    }
}

impl From<&Optics> for OpticsDocument {
    fn from(optics: &Optics) -> Self {
        let spec = optics.spec();
        Self {
            focal_length_mm: spec.focal_length_mm,
            aperture_mm: match spec.aperture {
                Aperture::DiameterMm(mm) => mm,
                Aperture::FNumber(number) => spec.focal_length_mm / number,
            },
            near_plane_mm: match spec.near_sensor {
                NearSensor::PlaneMm(mm) => mm,
                NearSensor::FocusMm(_) => optics.far_plane_mm() + spec.plane_separation_mm,
            },
            plane_separation_mm: spec.plane_separation_mm,
            pixel_pitch_um: spec.pixel_pitch_um,
            telecentric: spec.telecentric,
            principal_point_px: spec.principal_point_px,
        }
    }
}

impl TryFrom<OpticsDocument> for Optics {
    type Error = UnreadableCalibration;

    fn try_from(document: OpticsDocument) -> Result<Self, UnreadableCalibration> {
        let optics = Optics::new(&OpticsSpec {
            focal_length_mm: document.focal_length_mm,
            aperture: Aperture::DiameterMm(document.aperture_mm),
            near_sensor: NearSensor::PlaneMm(document.near_plane_mm),
            plane_separation_mm: document.plane_separation_mm,
            pixel_pitch_um: document.pixel_pitch_um,
            telecentric: document.telecentric,
            principal_point_px: document.principal_point_px,
        });
        optics.map_err(|faults| UnreadableCalibration::Optics { faults })
    }
}

impl TryFrom<CalibrationDocument> for Calibration {
    type Error = UnreadableCalibration;

    fn try_from(document: CalibrationDocument) -> Result<Self, UnreadableCalibration> {
        if document.version != VERSION {
            return Err(UnreadableCalibration::Version { version: document.version });
        }
        let filters = document.filters.map(|filters| match filters.scale.is_power_of_two() {
            true => Ok(Filters {
                method: filters.method.into(),
                side: filters.side,
                rank: filters.rank,
                band: filters.band,
                halvings: filters.scale.trailing_zeros(),
                hash: filters.hash,
            }),
            false => Err(UnreadableCalibration::Misshapen),
        });
        let table = document.table.map(|TableDocument { beta, raw, sigma, depth_mm }| {
            let alike = [raw.len(), sigma.len(), depth_mm.len()] == [beta.len(); 3];
            let rising = beta.is_sorted_by(|a, b| a < b)
                && raw.is_sorted_by(|a, b| a <= b)
                && raw.first() < raw.last();
            match alike && rising {
                true => Ok(Table { beta, raw, sigma, depth_mm }),
                false => Err(UnreadableCalibration::Misshapen),
            }
        });
        Ok(Calibration {
            image: document.image.map(|image| ImageSize {
                width_px: image.width,
                height_px: image.height,
                bits: image.bits,
            }),
            optics: document.optics.try_into()?,
            stated: document.stated.map(Optics::try_from).transpose()?,
            registration: document.registration.map(|registration| Registration {
                affine_far_to_near: registration.affine_far_to_near,
                rms_px: registration.rms_px,
            }),
            photometric: document.photometric.map(|photometric| Photometric {
                dark_near: photometric.dark_near,
                dark_far: photometric.dark_far,
                gain_far: photometric.gain_far,
            }),
            noise: document
                .noise
                .map(|noise| Noise { read_sigma: noise.read_sigma, shot_gain: noise.shot_gain }),
            filters: filters.transpose()?,
            table: table.transpose()?,
            residual: document
                .residual
                .map(|residual| Residual { rms_mm: residual.rms_mm, max_mm: residual.max_mm }),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn full() -> Calibration {
        let optics = Optics::new(&OpticsSpec {
            focal_length_mm: 25.0,
            aperture: Aperture::FNumber(2.8),
            near_sensor: NearSensor::FocusMm(529.0),
            plane_separation_mm: 0.37,
            pixel_pitch_um: 29.0,
            telecentric: true,
            principal_point_px: Some([320.25, 240.0]),
        });
        Calibration {
            image: Some(ImageSize { width_px: 640, height_px: 480, bits: 16 }),
            registration: Some(Registration {
                affine_far_to_near: [1.001, -0.0002, 0.3, 0.0001, 0.999, -0.7],
                rms_px: 0.03,
            }),
            photometric: Some(Photometric { dark_near: 2.5, dark_far: 2.25, gain_far: 0.97 }),
            noise: Some(Noise { read_sigma: 0.4, shot_gain: 0.01 }),
            filters: Some(Filters {
                method: Method::Gram,
                side: 9,
                rank: 5,
                band: 0.35,
                halvings: 2,
                hash: "0a1b".into(),
            }),
            table: Some(Table {
                beta: vec![-1.1, 0.1, 1.1],
                raw: vec![-1.05, 0.12, 1.0],
                sigma: vec![0.01, 0.02, 0.01],
                depth_mm: vec![900.0, 700.0, 520.0],
            }),
            residual: Some(Residual { rms_mm: 1.5, max_mm: 3.25 }),
            ..Calibration::of(optics.unwrap())
        }
    }

    #[test]
    fn a_document_comes_back_as_the_same_calibration() {
        let full = full();
        assert_eq!(read(&text(&full)).unwrap(), full);
        let level_0 = Calibration::of(full.optics);
        assert_eq!(read(&text(&level_0)).unwrap(), level_0);
    }

    #[test]
    fn the_names_of_the_document_never_change() {
        let value: serde_json::Value = serde_json::from_str(&text(&full())).unwrap();
        assert_eq!(
            value["filters"],
            serde_json::json!({"method": "gram", "K": 9, "J": 5, "band": 0.35, "scale": 4, "hash": "0a1b"})
        );
        assert_eq!(value["image"], serde_json::json!({"width": 640, "height": 480, "bits": 16}));
        let members: Vec<&str> = value.as_object().unwrap().keys().map(String::as_str).collect();
        for member in [
            "version",
            "image",
            "optics",
            "registration",
            "photometric",
            "noise",
            "filters",
            "table",
            "residual",
        ] {
            assert!(members.contains(&member), "{member}");
        }
    }

    #[test]
    fn what_this_release_cannot_read_is_told_so() {
        let with = |from: &str, to: &str| read(&text(&full()).replace(from, to)).unwrap_err();
        assert!(matches!(
            with(r#""version":1"#, r#""version":2"#),
            UnreadableCalibration::Version { version: 2 }
        ));
        assert!(matches!(with("0.37", "-0.37"), UnreadableCalibration::Optics { .. }));
        assert!(matches!(with("[0.01,", "["), UnreadableCalibration::Misshapen));
        assert!(matches!(with(r#""scale":4"#, r#""scale":3"#), UnreadableCalibration::Misshapen));
        assert!(matches!(read("{"), Err(UnreadableCalibration::Malformed { .. })));
    }
}
