//! The document that a calibration is kept as, JSON. All its parts but the optics are also those of answers. Names never
//! change meaning; a new member needs a default.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::database::words::words;
use landmarkd_core::depth::{
    Aperture, Calibration, Fault, Filters, ImageSize, Method, Noise, Optics, OpticsSpec, Pair, Photometric,
    Registration, Residual, Sensor, Table,
};

/// The version of the document's shape.
pub const CALIBRATION_DOCUMENT_VERSION: u32 = 1;

/// The kept document can't be read back.
#[derive(Debug, thiserror::Error)]
pub enum UnreadableCalibration {
    /// The text is no document of a calibration.
    #[error("it is no document that this release reads")]
    Malformed {
        /// What is wrong with the text.
        #[source]
        source: serde_json::Error,
    },
    /// A newer release wrote the document.
    #[error("its version is {version}; this release reads {CALIBRATION_DOCUMENT_VERSION}")]
    Version {
        /// The document's version.
        version: u32,
    },
    /// No lens can have these optics.
    #[error("its optics can't be: {}", .faults.iter().map(Fault::to_string).collect::<Vec<_>>().join("; "))]
    Optics {
        /// Everything that is wrong with the optics.
        faults: Vec<Fault>,
    },
    /// The table or the filters' scale isn't what a sweep gives.
    #[error("its table has columns of different lengths or doesn't rise, or its scale is no power of two")]
    Misshapen,
}

words!(
    /// What depth is read from: `gram`, the depth that explains both pictures best; `stm`, a closed form, the
    /// cheapest; `laplacian`, the paper's, which needs a calibration with a sweep by this method.
    DepthMethodWord, Method, { Gram, Laplacian, Stm }
);

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

/// The optics as they are kept: of the ways to describe a lens that a request has, the diameters of its apertures and the
/// distances of its sensors.
#[derive(Serialize, Deserialize)]
struct OpticsDocument {
    focal_length_mm: f64,
    #[serde(flatten)]
    pair: PairDocument,
    pixel_pitch_um: f64,
    telecentric: bool,
    principal_point_px: Option<[f64; 2]>,
}

/// What the two pictures differ by, told by its members.
#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum PairDocument {
    Focal { aperture_mm: f64, near_plane_mm: f64, plane_separation_mm: f64 },
    Aperture { apertures_mm: [f64; 2], plane_mm: f64, range_end_mm: f64 },
}

/// Declares a record of the core as the documents and the HTTP contract have it, with the conversions both ways.
macro_rules! records {
    (
        $(#[$doc:meta])*
        $name:ident as $schema:ident, $domain:ident, { $($(#[$field_doc:meta])* $field:ident: $type:ty),+ }
    ) => {
        $(#[$doc])*
        #[derive(Debug, Serialize, Deserialize, ToSchema)]
        #[schema(as = $schema)]
        pub struct $name { $($(#[$field_doc])* $field: $type),+ }

        impl From<$domain> for $name {
            fn from($domain { $($field),+ }: $domain) -> Self {
                Self { $($field),+ }
            }
        }

        impl From<$name> for $domain {
            fn from($name { $($field),+ }: $name) -> Self {
                Self { $($field),+ }
            }
        }
    };
}

records!(
    /// How the far-focused picture is brought into register.
    RegistrationDocument as RegistrationBody, Registration, {
        /// a, b, c, d, e, f: the far pixel (a·x + b·y + c, d·x + e·y + f) shows what the near pixel (x, y) shows.
        affine_far_to_near: [f64; 6],
        /// What is left between both.
        rms_px: f64
    }
);
records!(
    /// Offsets and gain of the two sensors, in grey levels of 255.
    PhotometricDocument as PhotometricBody, Photometric, {
        dark_near: f64,
        dark_far: f64,
        /// What the far-focused picture, without its dark level, is multiplied by.
        gain_far: f64
    }
);
records!(
    /// Noise of a pixel: variance = read_sigma² + shot_gain · level, in grey levels of 255.
    NoiseDocument as NoiseBody, Noise, { read_sigma: f64, shot_gain: f64 }
);
records!(
    /// From what the method says to what is true, by planes at known depths.
    TableDocument as TableBody, Table, {
        /// Where the planes are between the focus distances: 1 near, −1 far.
        beta: Vec<f64>,
        /// What the method said.
        raw: Vec<f64>,
        /// Standard deviation of that over the plane.
        sigma: Vec<f64>,
        depth_mm: Vec<f64>
    }
);
records!(
    /// What is left of the planes' depths after the table.
    ResidualDocument as ResidualBody, Residual, { rms_mm: f64, max_mm: f64 }
);

/// Size of the pictures in pixels, and bits a sample.
#[derive(Debug, Serialize, Deserialize, ToSchema)]
#[schema(as = ImageBody)]
pub struct ImageDocument {
    width: usize,
    height: usize,
    bits: u8,
}

impl From<ImageSize> for ImageDocument {
    fn from(image: ImageSize) -> Self {
        Self { width: image.width_px, height: image.height_px, bits: image.bits }
    }
}

impl From<ImageDocument> for ImageSize {
    fn from(image: ImageDocument) -> Self {
        Self { width_px: image.width, height_px: image.height, bits: image.bits }
    }
}

/// The filters that the table was measured with.
#[derive(Debug, Serialize, Deserialize, ToSchema)]
#[schema(as = FiltersBody)]
pub struct FiltersDocument {
    method: DepthMethodWord,
    /// Side of the kernels.
    #[serde(rename = "K")]
    side: usize,
    /// Pairs of kernels.
    #[serde(rename = "J")]
    rank: usize,
    /// Highest frequency that they let pass, cycles a pixel.
    band: f64,
    /// By how much the pictures are shrunk first.
    scale: u32,
    hash: String,
}

impl From<Filters> for FiltersDocument {
    fn from(filters: Filters) -> Self {
        Self {
            method: filters.method.into(),
            side: filters.side,
            rank: filters.rank,
            band: filters.band,
            scale: 1 << filters.halvings,
            hash: filters.hash,
        }
    }
}

impl TryFrom<FiltersDocument> for Filters {
    type Error = UnreadableCalibration;

    fn try_from(document: FiltersDocument) -> Result<Self, UnreadableCalibration> {
        if !document.scale.is_power_of_two() {
            return Err(UnreadableCalibration::Misshapen);
        }
        Ok(Self {
            method: document.method.into(),
            side: document.side,
            rank: document.rank,
            band: document.band,
            halvings: document.scale.trailing_zeros(),
            hash: document.hash,
        })
    }
}

impl TableDocument {
    /// The table, if its columns are of one length and rise.
    fn checked(self) -> Result<Table, UnreadableCalibration> {
        let Table { beta, raw, sigma, depth_mm } = Table::from(self);
        let alike = [raw.len(), sigma.len(), depth_mm.len()] == [beta.len(); 3];
        let rising =
            beta.is_sorted_by(|a, b| a < b) && raw.is_sorted_by(|a, b| a <= b) && raw.first() < raw.last();
        match alike && rising {
            true => Ok(Table { beta, raw, sigma, depth_mm }),
            false => Err(UnreadableCalibration::Misshapen),
        }
    }
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
            version: CALIBRATION_DOCUMENT_VERSION,
            image: calibration.image.map(ImageDocument::from),
            optics: (&calibration.optics).into(),
            stated: calibration.stated.as_ref().map(OpticsDocument::from),
            registration: calibration.registration.map(RegistrationDocument::from),
            photometric: calibration.photometric.map(PhotometricDocument::from),
            noise: calibration.noise.map(NoiseDocument::from),
            filters: calibration.filters.clone().map(FiltersDocument::from),
            table: calibration.table.clone().map(TableDocument::from),
            residual: calibration.residual.map(ResidualDocument::from),
        }
    }
}

impl From<&Optics> for OpticsDocument {
    fn from(optics: &Optics) -> Self {
        let spec = optics.spec();
        let diameter_mm = |aperture: Aperture| aperture.diameter_mm(spec.focal_length_mm);
        let plane_mm = |sensor: Sensor| {
            sensor.plane_mm(spec.focal_length_mm).expect("a valid optics is focused beyond the focal length")
        };
        Self {
            focal_length_mm: spec.focal_length_mm,
            pair: match spec.pair {
                Pair::Focal { aperture, near_sensor, plane_separation_mm } => PairDocument::Focal {
                    aperture_mm: diameter_mm(aperture),
                    near_plane_mm: plane_mm(near_sensor),
                    plane_separation_mm,
                },
                Pair::Aperture { apertures, sensor, range_end_mm } => PairDocument::Aperture {
                    apertures_mm: apertures.map(diameter_mm),
                    plane_mm: plane_mm(sensor),
                    range_end_mm,
                },
            },
            pixel_pitch_um: spec.pixel_pitch_um,
            telecentric: spec.telecentric,
            principal_point_px: spec.principal_point_px,
        }
    }
}

impl TryFrom<OpticsDocument> for Optics {
    type Error = UnreadableCalibration;

    fn try_from(document: OpticsDocument) -> Result<Self, UnreadableCalibration> {
        let pair = match document.pair {
            PairDocument::Focal { aperture_mm, near_plane_mm, plane_separation_mm } => Pair::Focal {
                aperture: Aperture::DiameterMm(aperture_mm),
                near_sensor: Sensor::PlaneMm(near_plane_mm),
                plane_separation_mm,
            },
            PairDocument::Aperture { apertures_mm, plane_mm, range_end_mm } => Pair::Aperture {
                apertures: apertures_mm.map(Aperture::DiameterMm),
                sensor: Sensor::PlaneMm(plane_mm),
                range_end_mm,
            },
        };
        let optics = Optics::new(&OpticsSpec {
            focal_length_mm: document.focal_length_mm,
            pair,
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
        if document.version != CALIBRATION_DOCUMENT_VERSION {
            return Err(UnreadableCalibration::Version { version: document.version });
        }
        Ok(Calibration {
            image: document.image.map(ImageSize::from),
            optics: document.optics.try_into()?,
            stated: document.stated.map(Optics::try_from).transpose()?,
            registration: document.registration.map(Registration::from),
            photometric: document.photometric.map(Photometric::from),
            noise: document.noise.map(Noise::from),
            filters: document.filters.map(Filters::try_from).transpose()?,
            table: document.table.map(TableDocument::checked).transpose()?,
            residual: document.residual.map(Residual::from),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn full() -> Calibration {
        let optics = Optics::new(&OpticsSpec {
            focal_length_mm: 25.0,
            pair: Pair::Focal {
                aperture: Aperture::FNumber(2.8),
                near_sensor: Sensor::FocusMm(529.0),
                plane_separation_mm: 0.37,
            },
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
    fn an_aperture_pair_comes_back_bit_for_bit() {
        let optics = Optics::new(&OpticsSpec {
            focal_length_mm: 35.0,
            pair: Pair::Aperture {
                apertures: [8.0, 2.8].map(Aperture::FNumber),
                sensor: Sensor::FocusMm(500.0),
                range_end_mm: 540.0,
            },
            pixel_pitch_um: 10.0,
            telecentric: false,
            principal_point_px: None,
        });
        let kept = Calibration::of(optics.unwrap());
        assert_eq!(read(&text(&kept)).unwrap(), kept);
    }

    #[test]
    fn what_an_older_release_kept_is_read_and_kept_as_it_was() {
        let optics = concat!(
            r#"{"focal_length_mm":25.0,"aperture_mm":8.928571428571429,"near_plane_mm":26.240079365079367,"#,
            r#""plane_separation_mm":0.37,"pixel_pitch_um":29.0,"telecentric":true,"principal_point_px":null}"#
        );
        let members = r#""registration":null,"photometric":null,"noise":null,"filters":null,"table":null,"residual":null"#;
        let kept = format!(r#"{{"version":1,"image":null,"optics":{optics},{members}}}"#);
        assert_eq!(text(&read(&kept).unwrap()), kept);
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
    fn what_this_release_cannot_read_is_refused() {
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
