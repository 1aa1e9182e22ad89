//! The answer of an object database.

use super::reason::Reason;

/// The answer to one picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Recognition {
    /// The object and its pose; `None` if no known object is near enough.
    pub decision: Option<Decision>,
    /// The objects that were compared in their own eigenspaces, the likeliest first: at most five.
    pub candidates: Vec<Candidate>,
    /// Why nothing was decided, the likeliest first; empty with a decision.
    pub reasons: Vec<Reason>,
    /// Reasons to doubt the answer.
    pub warnings: Vec<Warning>,
}

/// The object shown.
#[derive(Clone, Debug, PartialEq)]
pub struct Decision {
    /// Its label.
    pub label: String,
    /// Probability of being right, 0..=1, if known and unknown objects are equally frequent; `None` if no object has
    /// two views, or there is one object.
    pub confidence: Option<f64>,
    /// Its pose; `None` if fewer than three of its views differ in pose, if they look all the same, or if no object
    /// has two views.
    pub pose: Option<Pose>,
    /// Where the object stands in the picture; `None` of intensities, which aren't aligned.
    pub alignment: Option<Alignment>,
}

/// Where an object stands in a picture, relative to where its exemplars stand in theirs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alignment {
    /// Shift to the right, in px of the database's pictures.
    pub shift_x_px: f64,
    /// Shift down.
    pub shift_y_px: f64,
    /// Size in the picture over that in the exemplars.
    pub scale: f64,
    /// Turn in the picture's plane, clockwise as seen.
    pub turn_deg: f64,
}

/// The pose of an object: its turn about the vertical.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// In [0, 360).
    pub turn_deg: f64,
    /// Standard deviation, estimated from held-out views and the residual.
    pub sigma_deg: f64,
    /// Whether the pose may be acted on.
    pub reliable: bool,
    /// Another pose whose picture is as near, to within the residual.
    pub alternative_deg: Option<f64>,
}

/// An object that was compared in its own eigenspace. Distances are between pictures of unit energy: 0 is equal, √2
/// is orthogonal.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// Its label.
    pub label: String,
    /// From the nearest point of its manifold, in the eigenspace.
    pub distance_in_space: f64,
    /// Of the picture from the eigenspace: the residual of its reconstruction.
    pub distance_from_space: f64,
    /// The largest total distance √(in² + from²) that is accepted as this object; `None` if not calibrated.
    pub threshold: Option<f64>,
    /// B(15), if that is what objects are ordered by.
    pub mahalanobis: Option<f64>,
    /// The part of the object that the picture shows, 0..=1, once aligned; `None` of intensities.
    pub explained: Option<f64>,
    /// The least such part that is accepted; `None` if not calibrated.
    pub least_explained: Option<f64>,
}

/// A doubt about one answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Warning {
    /// The picture was not of the database's size.
    Resized,
    /// The picture is black.
    Blank,
    /// The object was to be cropped, and nothing stands out from the background.
    NoRegion,
    /// The object was cropped from a picture whose border cuts it.
    TouchesBorder,
    /// The object was cropped from a picture with another one nearly as large.
    SeveralRegions,
    /// Much of the picture is saturated: its shading is lost.
    OverExposed,
    /// The picture is gray, and the database compares colours: those say nothing here.
    GrayFrame,
    /// No known object is near enough.
    BeyondThreshold,
    /// Another object is nearly as near.
    CloseSecond,
    /// No object has two views: there is no threshold beyond which the answer is "unknown".
    NotCalibrated,
}

impl Warning {
    /// A short name for programs.
    pub fn code(&self) -> &'static str {
        match self {
            Warning::Resized => "resized",
            Warning::Blank => "blank_picture",
            Warning::NoRegion => "no_region",
            Warning::TouchesBorder => "touches_border",
            Warning::SeveralRegions => "several_regions",
            Warning::OverExposed => "over_exposed",
            Warning::GrayFrame => "gray_frame",
            Warning::BeyondThreshold => "beyond_threshold",
            Warning::CloseSecond => "close_second",
            Warning::NotCalibrated => "not_calibrated",
        }
    }
}
