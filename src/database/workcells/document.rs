//! The document of a workcell: what is sent and what is kept, as JSON. Its names never change meaning; a new member
//! needs a default.
//!
//! Correspondences are kept, and the mapping is fitted anew when they are read: a better fit needs no migration.

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::{Map, Value};
use utoipa::ToSchema;

use super::WorkcellSetup;
use crate::database::Name;
use crate::database::options::SegmentationOptionsDocument;
use crate::database::words::words;
use landmarkd_core::vision::OptionFault;
use landmarkd_core::vision::segmentation::SegmentationOptions;
use landmarkd_core::workcell::{
    self, Correspondence, LocalCamera, Mapping, MappingError, MappingKind, Workcell,
};

/// The kept document can't be read back.
#[derive(Debug, thiserror::Error)]
pub enum UnreadableWorkcell {
    /// A member is missing, unknown or misshapen.
    #[error("it is no document that this release reads")]
    Malformed {
        /// Where and why.
        #[source]
        source: serde_json::Error,
    },
    /// Members are out of range.
    #[error("what it says can't be: {}", .faults.iter().map(OptionFault::to_string).collect::<Vec<_>>().join("; "))]
    Impossible {
        /// All of them.
        faults: Vec<OptionFault>,
    },
    /// The correspondences are degenerate.
    #[error("its correspondences make no mapping")]
    Mapping {
        /// Why.
        #[source]
        source: MappingError,
    },
}

words!(
    /// What a mapping keeps: shapes (turned, scaled and moved); parallels; straight lines (a camera that looks aslant).
    MappingKindWord, MappingKind, { Similarity, Affine, Homography }
);

/// A pixel of the overview camera and the place on the table that it shows.
#[derive(Debug, Clone, Copy, Serialize, Deserialize, ToSchema)]
#[schema(as = CorrespondenceBody)]
#[serde(deny_unknown_fields)]
pub struct CorrespondenceDocument {
    /// x and y.
    pub image_px: [f64; 2],
    /// X and Y.
    pub robot_mm: [f64; 2],
}

/// The camera at the gripper.
#[derive(Debug, Clone, Copy, Serialize, Deserialize, ToSchema)]
#[schema(as = LocalCameraBody)]
#[serde(deny_unknown_fields)]
pub struct LocalCameraDocument {
    /// Scale on the table.
    #[schema(exclusive_minimum = 0, maximum = 1e6)]
    pub mm_per_px: f64,
    /// Direction of the image's x axis in the robot's plane, from X towards Y.
    #[serde(default)]
    #[schema(minimum = -360, maximum = 360)]
    pub rotation_deg: f64,
}

/// What is known of a workcell.
#[derive(Debug, Clone, Default, Serialize, Deserialize, ToSchema)]
#[schema(as = PutWorkcell)]
#[serde(deny_unknown_fields)]
pub struct WorkcellDocument {
    /// The database that names the parts, of kind `objects`.
    #[schema(value_type = String, pattern = "^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$")]
    pub database: Option<Name>,
    /// The rig that measures distances, for inspections with a focal pair.
    #[schema(value_type = Option<String>, pattern = "^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$")]
    pub calibration: Option<Name>,
    /// What the mapping is fitted to: two at the least for a similarity, three for an affine map, four for a
    /// homography; more even out their errors.
    #[schema(value_type = Vec<CorrespondenceDocument>, min_items = 2, max_items = 100)]
    pub correspondences: Option<Vec<CorrespondenceDocument>>,
    /// By default the kind that foretells each correspondence from the others best, simple ones preferred; of three
    /// an affine map, of two a similarity.
    #[schema(required = false)]
    pub mapping: Option<MappingKindWord>,
    /// Whether the robot's Y grows where the image's y falls, as seen by both cameras.
    #[schema(default = true)]
    pub flip_y: Option<bool>,
    /// The camera at the gripper: without it centrings are told in pixels alone.
    #[schema(required = false)]
    pub local: Option<LocalCameraDocument>,
    /// A part counts as centred within so many pixels.
    #[schema(minimum = 0, maximum = 1000, default = 1)]
    pub tolerance_px: Option<f64>,
    /// Of both cameras' pictures.
    #[serde(default, deserialize_with = "object")]
    pub segmentation: Option<SegmentationOptionsDocument>,
}

/// Of an object or null, and of nothing else.
fn object<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<SegmentationOptionsDocument>, D::Error> {
    let members = Option::<Map<String, Value>>::deserialize(deserializer)?;
    members
        .map(|members| serde_json::from_value(Value::Object(members)).map_err(D::Error::custom))
        .transpose()
}

impl WorkcellDocument {
    /// Everything that is wrong with the local camera and the tolerance.
    pub fn faults(&self) -> Vec<OptionFault> {
        workcell::faults(self.local.map(LocalCamera::from), self.tolerance_px())
    }

    /// Fit the mapping to the correspondences.
    ///
    /// # Errors
    /// [`MappingError`] for too few and for degenerate ones.
    pub fn fit(&self) -> Result<Mapping, MappingError> {
        Mapping::fit(&self.correspondences(), self.mapping.map(MappingKind::from), self.flip_y())
    }

    /// The workcell, once nothing is wrong with its members.
    pub fn setup(self, database: Name, mapping: Mapping, segmentation: SegmentationOptions) -> WorkcellSetup {
        WorkcellSetup {
            database,
            correspondences: self.correspondences(),
            workcell: Workcell {
                mapping,
                flip_y: self.flip_y(),
                local: self.local.map(LocalCamera::from),
                tolerance_px: self.tolerance_px(),
                segmentation,
            },
            calibration: self.calibration,
        }
    }

    fn correspondences(&self) -> Vec<Correspondence> {
        self.correspondences.iter().flatten().copied().map(Correspondence::from).collect()
    }

    fn flip_y(&self) -> bool {
        self.flip_y.unwrap_or(true)
    }

    fn tolerance_px(&self) -> f64 {
        self.tolerance_px.unwrap_or(1.0)
    }

    /// The document as one line of JSON.
    pub(super) fn to_text(&self) -> String {
        serde_json::to_string(self).expect("numbers and words always serialise")
    }
}

/// Members that every kept document has. A request may leave them out; a damaged document must not be read with defaults.
const KEPT: [&str; 4] = ["/correspondences", "/mapping", "/flip_y", "/tolerance_px"];

/// Members that may be absent from a kept document, but not null.
const NEVER_NULL: [&str; 4] =
    ["/segmentation", "/segmentation/threshold", "/segmentation/polarity", "/segmentation/max_objects"];

/// Refuses a kept document that is incomplete.
fn check_complete(document: &Value) -> Result<(), serde_json::Error> {
    let is_null = |pointer: &&&str| document.pointer(pointer).is_some_and(Value::is_null);
    let is_missing = |pointer: &&&str| document.pointer(pointer).is_none_or(Value::is_null);
    let of_local = document.get("local").is_some_and(Value::is_object).then_some(&"/local/rotation_deg");
    let missing = KEPT.iter().chain(of_local).find(is_missing).or(NEVER_NULL.iter().find(is_null));
    missing.map_or(Ok(()), |pointer| Err(serde_json::Error::custom(format!("{pointer} is missing"))))
}

/// Read a kept document back.
pub(super) fn read(text: &str) -> Result<WorkcellSetup, UnreadableWorkcell> {
    let malformed = |source| UnreadableWorkcell::Malformed { source };
    let kept: Value = serde_json::from_str(text).map_err(malformed)?;
    check_complete(&kept).map_err(malformed)?;
    let document: WorkcellDocument = serde_json::from_value(kept).map_err(malformed)?;
    let Some(database) = document.database.clone() else {
        return Err(malformed(serde_json::Error::missing_field("database")));
    };
    let mapping = document.fit().map_err(|source| UnreadableWorkcell::Mapping { source })?;
    let segmentation = SegmentationOptions::from(document.segmentation.clone().unwrap_or_default());
    let mut faults = segmentation.faults();
    faults.extend(document.faults());
    if !faults.is_empty() {
        return Err(UnreadableWorkcell::Impossible { faults });
    }
    Ok(document.setup(database, mapping, segmentation))
}

/// Every member is present.
impl From<&WorkcellSetup> for WorkcellDocument {
    fn from(setup: &WorkcellSetup) -> Self {
        let workcell = &setup.workcell;
        Self {
            database: Some(setup.database.clone()),
            calibration: setup.calibration.clone(),
            correspondences: Some(
                setup.correspondences.iter().copied().map(CorrespondenceDocument::from).collect(),
            ),
            mapping: Some(workcell.mapping.kind.into()),
            flip_y: Some(workcell.flip_y),
            local: workcell.local.map(LocalCameraDocument::from),
            tolerance_px: Some(workcell.tolerance_px),
            segmentation: Some((&workcell.segmentation).into()),
        }
    }
}

impl From<Correspondence> for CorrespondenceDocument {
    fn from(Correspondence { image_px, robot_mm }: Correspondence) -> Self {
        Self { image_px, robot_mm }
    }
}

impl From<CorrespondenceDocument> for Correspondence {
    fn from(CorrespondenceDocument { image_px, robot_mm }: CorrespondenceDocument) -> Self {
        Self { image_px, robot_mm }
    }
}

impl From<LocalCamera> for LocalCameraDocument {
    fn from(LocalCamera { mm_per_px, rotation_deg }: LocalCamera) -> Self {
        Self { mm_per_px, rotation_deg }
    }
}

impl From<LocalCameraDocument> for LocalCamera {
    fn from(LocalCameraDocument { mm_per_px, rotation_deg }: LocalCameraDocument) -> Self {
        Self { mm_per_px, rotation_deg }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use landmarkd_core::vision::segmentation::{Polarity, Threshold};

    fn setup(segmentation: SegmentationOptions) -> WorkcellSetup {
        let correspondences: Vec<Correspondence> =
            [[10.0, 10.0], [600.0, 20.0], [30.0, 460.0], [610.0, 450.0]]
                .into_iter()
                .map(|[x, y]| Correspondence {
                    image_px: [x, y],
                    robot_mm: [0.5 * x + 100.0, 300.0 - 0.5 * y],
                })
                .collect();
        let mapping = Mapping::fit(&correspondences, Some(MappingKind::Homography), true).unwrap();
        WorkcellSetup {
            database: Name::parse("parts").unwrap(),
            calibration: Some(Name::parse("rig").unwrap()),
            correspondences,
            workcell: Workcell {
                mapping,
                flip_y: true,
                local: Some(LocalCamera { mm_per_px: 0.25, rotation_deg: -90.0 }),
                tolerance_px: 1.5,
                segmentation,
            },
        }
    }

    fn kept(setup: &WorkcellSetup) -> String {
        WorkcellDocument::from(setup).to_text()
    }

    #[test]
    fn a_document_comes_back_as_the_same_workcell() {
        let other = SegmentationOptions {
            threshold: Threshold::Fixed(127.5),
            window_px: Some(101),
            offset: Some(12.5),
            polarity: Polarity::DarkOnLight,
            min_area_px: Some(40),
            max_objects: 7,
        };
        let otsu = SegmentationOptions { threshold: Threshold::Otsu, ..Default::default() };
        for segmentation in [SegmentationOptions::default(), other, otsu] {
            let setup = setup(segmentation);
            assert_eq!(read(&kept(&setup)).unwrap(), setup);
        }
    }

    #[test]
    fn an_older_document_without_a_member_is_still_read_and_a_newer_one_is_not() {
        let least = r#"{"database":"parts","correspondences":[{"image_px":[0,0],"robot_mm":[0,0]},
            {"image_px":[100,0],"robot_mm":[50,0]}],"mapping":"similarity","flip_y":true,"tolerance_px":1}"#;
        let setup = read(least).unwrap();
        assert_eq!((setup.calibration, setup.workcell.local), (None, None));
        assert_eq!(setup.workcell.segmentation, SegmentationOptions::default());
        for newer in [
            least.replace("\"flip_y\"", "\"lens\":1,\"flip_y\""),
            least.replace("\"flip_y\"", "\"segmentation\":{\"colour\":1},\"flip_y\""),
            least.replace("similarity", "spline"),
            least.replace("parts", "no name"),
        ] {
            let error = read(&newer).unwrap_err();
            assert!(matches!(error, UnreadableWorkcell::Malformed { .. }), "{newer}: {error}");
        }
    }

    #[test]
    fn a_damaged_document_is_not_read_with_the_defaults_of_a_request() {
        let whole: Value = serde_json::from_str(&kept(&setup(SegmentationOptions::default()))).unwrap();
        for member in ["database", "correspondences", "mapping", "flip_y", "tolerance_px"] {
            let mut damaged = whole.clone();
            damaged.as_object_mut().unwrap().remove(member);
            let error = read(&damaged.to_string()).unwrap_err();
            assert!(matches!(error, UnreadableWorkcell::Malformed { .. }), "{member}: {error}");
        }
        for (pointer, value) in [("/local", r#"{"mm_per_px":1}"#), ("/segmentation/threshold", "null")] {
            let mut damaged = whole.clone();
            *damaged.pointer_mut(pointer).unwrap() = serde_json::from_str(value).unwrap();
            let error = read(&damaged.to_string()).unwrap_err();
            assert!(matches!(error, UnreadableWorkcell::Malformed { .. }), "{pointer}: {error}");
        }
    }

    #[test]
    fn what_cannot_be_used_is_told_apart() {
        let impossible = SegmentationOptions { max_objects: 0, ..Default::default() };
        let error = read(&kept(&setup(impossible))).unwrap_err();
        assert!(matches!(error, UnreadableWorkcell::Impossible { .. }), "{error}");
        assert!(error.to_string().contains("max_objects"), "{error}");
        let mut wild = setup(SegmentationOptions::default());
        wild.workcell.tolerance_px = -1.0;
        wild.workcell.local = Some(LocalCamera { mm_per_px: 0.0, rotation_deg: 1e9 });
        let error = read(&kept(&wild)).unwrap_err();
        for member in ["tolerance_px", "local/mm_per_px", "local/rotation_deg"] {
            assert!(error.to_string().contains(member), "{error}");
        }
        let mut too_few = setup(SegmentationOptions::default());
        too_few.correspondences.truncate(3);
        let error = read(&kept(&too_few)).unwrap_err();
        assert!(matches!(error, UnreadableWorkcell::Mapping { .. }), "{error}");
    }

    #[test]
    fn the_kept_text_of_a_workcell_never_changes() {
        assert_eq!(
            kept(&setup(SegmentationOptions::default())),
            r#"{"database":"parts","calibration":"rig","correspondences":[{"image_px":[10.0,10.0],"robot_mm":[105.0,295.0]},{"image_px":[600.0,20.0],"robot_mm":[400.0,290.0]},{"image_px":[30.0,460.0],"robot_mm":[115.0,70.0]},{"image_px":[610.0,450.0],"robot_mm":[405.0,75.0]}],"mapping":"homography","flip_y":true,"local":{"mm_per_px":0.25,"rotation_deg":-90.0},"tolerance_px":1.5,"segmentation":{"threshold":"adaptive","window_px":null,"offset":null,"polarity":"either","min_area_px":null,"max_objects":100}}"#
        );
    }
}
