//! The report of a training: the document that is kept with the version, written into its artifact and sent in answers.
//! One file a kind.
//!
//! A kept report and one in an artifact leave out what is empty, as those of earlier releases do; an answer has every
//! member ([`Report::complete`]). The members that differ are `Option`s: `None` is absent, `Some` of nothing is written.

mod landmarks;
mod objects;
mod verdict;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

pub use landmarks::{DescriptionsReport, GrownReport, LandmarkReport, ReliabilityReport};
pub use objects::ObjectsReport;
pub use verdict::VerdictReport;

use super::Kind;

/// The warning of a version that isn't asked about its own pictures yet.
const NOT_CHECKED: &str = "not_checked";

/// What a training told of itself, by the kind of its database.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[schema(as = ReportBody)]
#[serde(untagged)]
pub enum Report {
    // Of a database of kind `landmarks`.
    Landmarks(Box<LandmarkReport>),
    // Of a database of kind `objects`.
    Objects(Box<ObjectsReport>),
}

/// How long the parts of a training took.
// Milliseconds. The schema shows documentation of types and members: what it must not show stands in plain comments.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct TrainingTimings {
    /// Reading and describing the exemplars.
    pub describe: f64,
    /// Eigenspace, index and artifact.
    pub eigenspace: f64,
    /// Asking the new version about its exemplars seen otherwise; null where that isn't done.
    #[schema(value_type = Option<f64>)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rehearsal: Option<Option<f64>>,
}

impl Report {
    /// The report as it is kept, one line of JSON.
    pub fn to_document(&self) -> String {
        serde_json::to_string(self).expect("numbers and text always serialise")
    }

    /// Read a kept report of this kind back.
    ///
    /// # Errors
    /// The text is no such report.
    pub fn from_document(kind: Kind, text: &str) -> Result<Self, serde_json::Error> {
        match kind {
            Kind::Landmarks => serde_json::from_str(text).map(Self::Landmarks),
            Kind::Objects => serde_json::from_str(text).map(Self::Objects),
        }
    }

    /// The same with these timings, which an artifact doesn't have: the same inputs give the same file.
    pub fn timed(mut self, timings: TrainingTimings) -> Self {
        *self.timings_ms() = Some(Some(timings));
        self
    }

    /// The same with where the exemplars' descriptions came from, which an artifact doesn't have either.
    pub fn with_descriptions(mut self, descriptions: Option<DescriptionsReport>) -> Self {
        if let Self::Landmarks(report) = &mut self {
            report.descriptions = descriptions.map(Some);
        }
        self
    }

    /// The same of a version that is still to be asked about its own pictures. An artifact doesn't say so.
    pub fn not_checked(mut self) -> Self {
        if let Self::Landmarks(report) = &mut self {
            report.warnings.get_or_insert_default().push(NOT_CHECKED.into());
        }
        self
    }

    /// The same with what the version says of its own pictures, and the milliseconds that asking took.
    pub fn checked(mut self, verdict: VerdictReport, took_ms: f64) -> Self {
        if let Self::Landmarks(report) = &mut self {
            report.verdict = Some(Some(verdict));
            report.warnings.iter_mut().for_each(|warnings| warnings.retain(|warning| warning != NOT_CHECKED));
        }
        if let Some(Some(timings)) = self.timings_ms() {
            timings.rehearsal = Some(Some(took_ms));
        }
        self
    }

    /// Whether it says how well the version knows its own pictures.
    pub fn has_verdict(&self) -> bool {
        matches!(self, Self::Landmarks(report) if report.verdict.as_ref().is_some_and(Option::is_some))
    }

    /// The same with every member present, as answers have it.
    pub fn complete(mut self) -> Self {
        match &mut self {
            Self::Landmarks(report) => report.complete(),
            Self::Objects(report) => report.complete(),
        }
        if let Some(timings) = self.timings_ms().get_or_insert_default() {
            timings.rehearsal.get_or_insert_default();
        }
        self
    }

    fn timings_ms(&mut self) -> &mut Option<Option<TrainingTimings>> {
        match self {
            Self::Landmarks(report) => &mut report.timings_ms,
            Self::Objects(report) => &mut report.timings_ms,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LANDMARKS: &str = r#"{"spectrum":[2.0,1.0],"energy_kept":0.5,"dimension":1,"signature_length":136,"colour":"gray","exemplars_without_points":["a"]}"#;
    const OBJECTS: &str = r#"{"spectrum":[2.0],"energy_kept":0.5,"dimension":1,"width_px":8,"height_px":9,"vector_length":72,"rate_by_dimension":[{"dimension":1,"right":2,"trials":3}],"confusion":[{"shown":"a","named":null,"times":1}],"held_out":null,"objects":[{"label":"a","views":2,"views_with_pose":2,"threshold":null,"pose":{"trials":2,"mean_deg":1.0,"median_deg":1.5,"p95_deg":2.0,"within_5_deg":2},"gaps":[{"from_deg":0.0,"to_deg":90.0}]}],"near_duplicates":[["a","b"]],"repeated_poses":[],"over_exposed":[],"under_exposed":[],"blank":[],"resized":[]}"#;

    fn with(text: &str, members: &str) -> String {
        text.strip_suffix('}').unwrap().to_owned() + members + "}"
    }

    #[test]
    fn a_kept_report_leaves_out_what_is_empty_and_an_answer_has_every_member() {
        let timings = TrainingTimings { describe: 1.0, eigenspace: 2.5, rehearsal: None };
        let kept_timings = r#","timings_ms":{"describe":1.0,"eigenspace":2.5}"#;
        let all_timings = r#","timings_ms":{"describe":1.0,"eigenspace":2.5,"rehearsal":null}"#;
        for (kind, text, empty, last) in [
            (
                Kind::Landmarks,
                LANDMARKS,
                r#","reliability":null,"warnings":[]"#,
                r#","verdict":null,"descriptions":null,"grown":null"#,
            ),
            (Kind::Objects, OBJECTS, r#","touches_border":[],"several_regions":[]"#, ""),
        ] {
            let report = Report::from_document(kind, text).unwrap();
            assert_eq!(report.to_document(), text);
            let answer = serde_json::to_string(&report.clone().complete()).unwrap();
            assert_eq!(answer, with(&with(&with(text, empty), r#","timings_ms":null"#), last));
            let timed = report.timed(timings);
            let kept = with(text, kept_timings);
            assert_eq!(timed.to_document(), kept);
            assert_eq!(Report::from_document(kind, &kept).unwrap(), timed);
            let answer = serde_json::to_string(&timed.complete()).unwrap();
            assert_eq!(answer, with(&with(&with(text, empty), all_timings), last));
        }
    }

    #[test]
    fn what_a_kept_report_has_comes_back() {
        let reliability = r#"{"known":9,"unknown":3,"known_named":0.75,"known_misnamed":0.25,"unknown_refused":1.0,"curve":[{"confidence":0.5,"answers":4,"right":0.5}],"threshold":0.25}"#;
        let rehearsed = r#","timings_ms":{"describe":1.0,"eigenspace":2.5,"rehearsal":3.0}"#;
        let landmarks = format!(r#","reliability":{reliability},"warnings":["not_calibrated"]{rehearsed}"#);
        let objects = r#","touches_border":["a"],"several_regions":["b"]"#.to_owned();
        for (kind, text) in
            [(Kind::Landmarks, with(LANDMARKS, &landmarks)), (Kind::Objects, with(OBJECTS, &objects))]
        {
            let report = Report::from_document(kind, &text).unwrap();
            assert_eq!(report.to_document(), text);
            assert!(serde_json::to_string(&report.complete()).unwrap().starts_with(&text[..text.len() - 1]));
        }
    }
}
