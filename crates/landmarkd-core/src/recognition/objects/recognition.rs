//! What an object database answers.

use std::fmt;

/// The answer to one picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Recognition {
    /// What to act on; `None` if the picture is like nothing that is known.
    pub decision: Option<Decision>,
    /// The objects that were looked at closely, the likeliest first: at most five.
    pub candidates: Vec<Candidate>,
    /// What a reader should know before trusting it.
    pub warnings: Vec<Warning>,
}

/// The object shown.
#[derive(Clone, Debug, PartialEq)]
pub struct Decision {
    pub label: String,
    /// Probability of being right, 0..=1, if as many known things are shown as unknown ones; `None` if the database
    /// could not be calibrated, or has one object.
    pub confidence: Option<f64>,
    /// How it is turned; `None` if fewer than three of its views differ in pose, if they look all the same, or if the
    /// database could not be calibrated.
    pub pose: Option<Pose>,
}

/// How an object is turned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// In [0, 360).
    pub turn_deg: f64,
    /// Standard deviation that held-out views and the residual lead one to expect.
    pub sigma_deg: f64,
    /// Whether the pose may be acted on.
    pub reliable: bool,
    /// Another pose that would look the same to within what is known.
    pub alternative_deg: Option<f64>,
}

/// An object that was looked at closely. Distances are between pictures of unit energy: 0 is equal, √2 nothing
/// in common.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    pub label: String,
    /// From the nearest point of its manifold, in the eigenspace.
    pub distance_in_space: f64,
    /// What of the picture the eigenspace can't express.
    pub distance_from_space: f64,
    /// The largest total distance √(in² + from²) that is accepted as this object; `None` if not calibrated.
    pub threshold: Option<f64>,
    /// B(15), if that is what objects are ordered by.
    pub mahalanobis: Option<f64>,
}

/// A doubt about one answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Warning {
    /// The picture was not of the database's size.
    Resized,
    /// The picture is black.
    Blank,
    /// The object was to be cut out, and nothing stands out from the background.
    NoRegion,
    /// The object was cut out of a picture that may not hold it whole.
    TouchesBorder,
    /// The object was cut out of a picture with another one nearly as large.
    SeveralRegions,
    /// Much of the picture is as bright as can be: its shading is lost.
    OverExposed,
    /// Nothing known is near enough.
    BeyondThreshold,
    /// Another object is nearly as near.
    CloseSecond,
    /// The database could not be calibrated: nothing says when to answer "unknown".
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
            Warning::BeyondThreshold => "beyond_threshold",
            Warning::CloseSecond => "close_second",
            Warning::NotCalibrated => "not_calibrated",
        }
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Warning::Resized => "the picture was scaled to the database's size",
            Warning::Blank => "the picture is black: there is nothing to recognise",
            Warning::NoRegion => "nothing stands out from the background",
            Warning::TouchesBorder => {
                "the picture's border cuts the object: what is missing may change the answer"
            }
            Warning::SeveralRegions => "several things stand out: the largest was looked at",
            Warning::OverExposed => "much of the picture is as bright as can be: its shading is lost",
            Warning::BeyondThreshold => "nothing that is known is near enough",
            Warning::CloseSecond => "another object is nearly as near",
            Warning::NotCalibrated => "too few views to know when to answer \"unknown\"",
        })
    }
}
