//! Why nothing was decided, and what would help.

use super::model::Landmarks;
use super::recognition::{AContrario, LabelVote};
use crate::imaging::Frame;

/// Mean gray levels below and above which a picture is dark, or over-exposed.
const DARK: f64 = 25.0;
const BRIGHT: f64 = 230.0;
/// With fewer points for each 10 000 px there is little to see.
const SPARSE: f64 = 6.0;

/// Agreement that chance reaches so often (log₁₀ a frame) says nothing.
const WEAK: f64 = 3.0;
/// Labels that are listed at most.
const MOST_LABELS: usize = 5;

/// Why a frame is answered with nothing.
#[derive(Clone, Debug, PartialEq)]
pub enum Reason {
    /// The frame is nearly black.
    TooDark,
    /// The frame is nearly white.
    OverExposed,
    /// Hardly anything in the frame draws attention: flat, out of focus, or moved.
    LittleToSee {
        /// Windows that were asked.
        windows: usize,
    },
    /// Something agrees with what is known, but chance might do as well.
    WeakEvidence {
        /// The label that agrees most.
        label: String,
        /// How much agrees.
        a_contrario: AContrario,
        /// Pictures of that label.
        pictures: usize,
    },
    /// Labels are about equally likely, though chance explains none of them.
    Ambiguous {
        /// The labels, likeliest first.
        labels: Vec<String>,
    },
    /// The frame, mirrored back, agrees far better.
    Mirrored {
        /// The label that it agrees with.
        label: String,
    },
    /// The frame shows what a negative exemplar shows.
    KnownBackground {
        /// Id of that exemplar.
        exemplar: String,
    },
    /// Nothing in the frame agrees with anything known.
    UnlikeAnything,
}

impl Reason {
    /// A short name for programs.
    pub fn code(&self) -> &'static str {
        match self {
            Reason::TooDark => "too_dark",
            Reason::OverExposed => "over_exposed",
            Reason::LittleToSee { .. } => "little_to_see",
            Reason::WeakEvidence { .. } => "weak_evidence",
            Reason::Ambiguous { .. } => "ambiguous",
            Reason::Mirrored { .. } => "mirrored",
            Reason::KnownBackground { .. } => "known_background",
            Reason::UnlikeAnything => "unlike_anything",
        }
    }

    /// What was seen, in a sentence.
    pub fn detail(&self) -> String {
        match self {
            Reason::TooDark => "the picture is nearly black".to_owned(),
            Reason::OverExposed => "the picture is nearly white".to_owned(),
            Reason::LittleToSee { windows } => {
                format!(
                    "only {windows} windows of the picture show any structure: it is flat, out of focus or moved"
                )
            }
            Reason::WeakEvidence { label, a_contrario: AContrario { agreeing, asked, .. }, .. } => {
                format!("{agreeing} of {asked} windows agree on {label:?}: chance might do as well")
            }
            Reason::Ambiguous { labels } => {
                format!("chance explains none of {}, and nothing tells which it is", labels.join(", "))
            }
            Reason::Mirrored { label } => {
                format!(
                    "flipped from left to right the picture agrees with {label:?} far better: it is mirrored"
                )
            }
            Reason::KnownBackground { exemplar } => {
                format!("the picture shows what the negative exemplar {exemplar} shows")
            }
            Reason::UnlikeAnything => "nothing in the picture agrees with anything known".to_owned(),
        }
    }

    /// What to do about it.
    pub fn remedy(&self) -> String {
        match self {
            Reason::TooDark => "give more light, or a longer exposure".to_owned(),
            Reason::OverExposed => "shorten the exposure".to_owned(),
            Reason::LittleToSee { .. } => {
                "hold the camera still, focus, and show something with structure".to_owned()
            }
            Reason::WeakEvidence { label, pictures: 1, .. } => {
                format!("{label:?} has one picture: if this is it, teach this view too, or come nearer")
            }
            Reason::WeakEvidence { label, .. } => {
                format!("if this is {label:?}, teach this view too, or come nearer")
            }
            Reason::Ambiguous { .. } => {
                "teach this view under its label; merge the labels if they show the same".to_owned()
            }
            Reason::Mirrored { .. } => {
                "switch the camera's mirroring off (front cameras often have it), or teach the mirrored view"
                    .to_owned()
            }
            Reason::KnownBackground { exemplar } => format!(
                "nothing, if this is background; if it should be known, come nearer, or delete the exemplar {exemplar} where \
                 that shows what should be known"
            ),
            Reason::UnlikeAnything => "if this should be known, teach this picture".to_owned(),
        }
    }
}

/// The reasons, the likeliest first. `votes` are likeliest first; `known` is what else is known to be the reason.
pub(super) fn reasons(
    model: &Landmarks,
    working: &Frame,
    windows: usize,
    votes: &[LabelVote],
    known: Option<Reason>,
) -> Vec<Reason> {
    let mut reasons = Vec::new();
    let mean = working.luminance.mean();
    if mean < DARK {
        reasons.push(Reason::TooDark);
    } else if mean > BRIGHT {
        reasons.push(Reason::OverExposed);
    }
    let area = (working.width() * working.height()) as f64;
    if (windows as f64) < SPARSE * area / 1e4 {
        reasons.push(Reason::LittleToSee { windows });
    }
    let least = model.options.least_evidence();
    let evident =
        votes.iter().filter(|vote| vote.a_contrario.is_some_and(|found| -found.log10_false_alarms >= least));
    let labels: Vec<String> = evident.map(|vote| vote.label.clone()).take(MOST_LABELS).collect();
    if let Some(reason) = known {
        reasons.push(reason);
        return reasons;
    }
    reasons.push(match (votes.first(), votes.first().and_then(|vote| vote.a_contrario)) {
        _ if !labels.is_empty() => Reason::Ambiguous { labels },
        (Some(vote), Some(a_contrario)) if a_contrario.log10_false_alarms < WEAK => Reason::WeakEvidence {
            label: vote.label.clone(),
            a_contrario,
            pictures: model.exemplars.iter().filter(|exemplar| exemplar.label == vote.label).count(),
        },
        _ => Reason::UnlikeAnything,
    });
    reasons
}
