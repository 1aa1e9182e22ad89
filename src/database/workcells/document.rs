//! The document a workcell is kept as: JSON with names of its own, so that renaming a field inside changes nothing on
//! the disk. Its names never change meaning; a new member needs a default.
//!
//! Correspondences are kept, and the mapping is fitted anew when they are read: a better fit needs no migration.

use serde::{Deserialize, Serialize};

use super::WorkcellSetup;
use crate::database::Name;
use crate::database::options::words;
use landmarkd_core::vision::OptionFault;
use landmarkd_core::vision::segmentation::{Polarity, SegmentationOptions, Threshold};
use landmarkd_core::workcell::{
    self, Correspondence, LocalCamera, Mapping, MappingError, MappingKind, Workcell,
};

/// The kept document can't be read back.
#[derive(Debug, thiserror::Error)]
pub enum UnreadableWorkcell {
    #[error("it is no document that this release reads")]
    Malformed {
        #[source]
        source: serde_json::Error,
    },
    #[error("what it says can't be: {}", .faults.iter().map(OptionFault::to_string).collect::<Vec<_>>().join("; "))]
    Impossible { faults: Vec<OptionFault> },
    #[error("its correspondences make no mapping")]
    Mapping {
        #[source]
        source: MappingError,
    },
}

words!(MappingKind, MappingKindWord, { Similarity, Affine, Homography });
words!(Polarity, PolarityWord, { LightOnDark, DarkOnLight });

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct WorkcellDocument {
    database: String,
    #[serde(default)]
    calibration: Option<String>,
    correspondences: Vec<CorrespondenceDocument>,
    mapping: MappingKindWord,
    flip_y: bool,
    #[serde(default)]
    local: Option<LocalDocument>,
    tolerance_px: f64,
    #[serde(default)]
    segmentation: SegmentationDocument,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct CorrespondenceDocument {
    image_px: [f64; 2],
    robot_mm: [f64; 2],
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct LocalDocument {
    mm_per_px: f64,
    rotation_deg: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct SegmentationDocument {
    threshold: ThresholdDocument,
    window_px: Option<usize>,
    offset: Option<f64>,
    polarity: PolarityWord,
    min_area_px: Option<usize>,
    max_objects: usize,
}

/// A level, or a word.
#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum ThresholdDocument {
    Level(f64),
    Word(ThresholdWord),
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum ThresholdWord {
    Adaptive,
    Otsu,
}

/// The workcell as one line of JSON.
pub(super) fn text(setup: &WorkcellSetup) -> String {
    serde_json::to_string(&WorkcellDocument::from(setup)).expect("numbers and words always serialise")
}

/// Read a kept document back.
pub(super) fn read(text: &str) -> Result<WorkcellSetup, UnreadableWorkcell> {
    let malformed = |source| UnreadableWorkcell::Malformed { source };
    let document: WorkcellDocument = serde_json::from_str(text).map_err(malformed)?;
    let name = |text: String| {
        Name::parse(&text).map_err(|source| malformed(serde::de::Error::custom(format!("{text:?} {source}"))))
    };
    let correspondences: Vec<Correspondence> = (document.correspondences.into_iter())
        .map(|pair| Correspondence { image_px: pair.image_px, robot_mm: pair.robot_mm })
        .collect();
    let mapping = Mapping::fit(&correspondences, Some(document.mapping.into()), document.flip_y)
        .map_err(|source| UnreadableWorkcell::Mapping { source })?;
    let segmentation = SegmentationOptions::from(document.segmentation);
    let local = (document.local)
        .map(|local| LocalCamera { mm_per_px: local.mm_per_px, rotation_deg: local.rotation_deg });
    let mut faults = segmentation.faults();
    faults.extend(workcell::faults(local, document.tolerance_px));
    if !faults.is_empty() {
        return Err(UnreadableWorkcell::Impossible { faults });
    }
    Ok(WorkcellSetup {
        database: name(document.database)?,
        calibration: document.calibration.map(name).transpose()?,
        correspondences,
        workcell: Workcell {
            mapping,
            flip_y: document.flip_y,
            local,
            tolerance_px: document.tolerance_px,
            segmentation,
        },
    })
}

impl From<&WorkcellSetup> for WorkcellDocument {
    fn from(setup: &WorkcellSetup) -> Self {
        let workcell = &setup.workcell;
        Self {
            database: setup.database.to_string(),
            calibration: setup.calibration.as_ref().map(Name::to_string),
            correspondences: (setup.correspondences.iter())
                .map(|pair| CorrespondenceDocument { image_px: pair.image_px, robot_mm: pair.robot_mm })
                .collect(),
            mapping: workcell.mapping.kind.into(),
            flip_y: workcell.flip_y,
            local: workcell
                .local
                .map(|local| LocalDocument { mm_per_px: local.mm_per_px, rotation_deg: local.rotation_deg }),
            tolerance_px: workcell.tolerance_px,
            segmentation: (&workcell.segmentation).into(),
        }
    }
}

impl From<&SegmentationOptions> for SegmentationDocument {
    fn from(options: &SegmentationOptions) -> Self {
        Self {
            threshold: match options.threshold {
                Threshold::Adaptive => ThresholdDocument::Word(ThresholdWord::Adaptive),
                Threshold::Otsu => ThresholdDocument::Word(ThresholdWord::Otsu),
                Threshold::Fixed(level) => ThresholdDocument::Level(level),
            },
            window_px: options.window_px,
            offset: options.offset,
            polarity: options.polarity.into(),
            min_area_px: options.min_area_px,
            max_objects: options.max_objects,
        }
    }
}

/// What is absent in a kept document: the default of the release that added it.
impl Default for SegmentationDocument {
    fn default() -> Self {
        Self::from(&SegmentationOptions::default())
    }
}

impl From<SegmentationDocument> for SegmentationOptions {
    fn from(document: SegmentationDocument) -> Self {
        Self {
            threshold: match document.threshold {
                ThresholdDocument::Word(ThresholdWord::Adaptive) => Threshold::Adaptive,
                ThresholdDocument::Word(ThresholdWord::Otsu) => Threshold::Otsu,
                ThresholdDocument::Level(level) => Threshold::Fixed(level),
            },
            window_px: document.window_px,
            offset: document.offset,
            polarity: document.polarity.into(),
            min_area_px: document.min_area_px,
            max_objects: document.max_objects,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
            assert_eq!(read(&text(&setup)).unwrap(), setup);
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
    fn what_cannot_be_used_is_told_apart() {
        let impossible = SegmentationOptions { max_objects: 0, ..Default::default() };
        let error = read(&text(&setup(impossible))).unwrap_err();
        assert!(matches!(error, UnreadableWorkcell::Impossible { .. }), "{error}");
        assert!(error.to_string().contains("max_objects"), "{error}");
        let mut wild = setup(SegmentationOptions::default());
        wild.workcell.tolerance_px = -1.0;
        wild.workcell.local = Some(LocalCamera { mm_per_px: 0.0, rotation_deg: 1e9 });
        let error = read(&text(&wild)).unwrap_err();
        for member in ["tolerance_px", "local/mm_per_px", "local/rotation_deg"] {
            assert!(error.to_string().contains(member), "{error}");
        }
        let mut too_few = setup(SegmentationOptions::default());
        too_few.correspondences.truncate(3);
        let error = read(&text(&too_few)).unwrap_err();
        assert!(matches!(error, UnreadableWorkcell::Mapping { .. }), "{error}");
    }
}
