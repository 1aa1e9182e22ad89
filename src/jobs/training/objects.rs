//! Training an object database: the appearance of each exemplar, then eigenspaces and manifolds.

use std::collections::BTreeMap;

use super::Trained;
use crate::database::{Counts, ExemplarRow, Model, ObjectsReport, Report, TrainingTimings};
use crate::jobs::stop::Stop;
use crate::jobs::worker::Worker;
use crate::problem::Code;
use crate::telemetry::chain;
use landmarkd_core::recognition::objects::{
    self, MAX_SIDE_PX, Normaliser, ObjectOptions, Resize, TrainingError, View, ViewName, common_size,
    common_step_deg, is_trial,
};

/// Why exemplars can't be trained into an object database, as far as their rows show.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum UnfitExemplars {
    /// Fewer than two exemplars.
    #[error("fewer than two exemplars show anything; two that differ are the least: post more, then train")]
    TooFew,
    /// One picture, several times.
    #[error("all exemplars are one and the same picture: post others, then train")]
    AllEqual,
    /// Sizes that differ, without `resize`.
    #[error(
        "the exemplars must be {wanted} with resize never, and they are: {found}; delete those of another size, or train \
         with resize fit"
    )]
    Sizes {
        /// Width and height, or that all must be of one size.
        wanted: String,
        /// How many of which size, the commonest first.
        found: String,
    },
    /// More numbers than memory holds.
    #[error(
        "{exemplars} exemplars of {samples} samples each are more than can be trained at once ({limit} numbers): give a \
         smaller width_px and height_px, or more smoothing"
    )]
    TooMuch {
        /// Their number.
        exemplars: usize,
        /// Samples of each, as they are trained.
        samples: usize,
        /// Most samples of all.
        limit: usize,
    },
}

impl UnfitExemplars {
    /// What is wrong with these exemplars, as far as their rows show.
    pub(in crate::jobs) fn among(exemplars: &[ExemplarRow], options: &ObjectOptions) -> Option<Self> {
        if exemplars.len() < 2 {
            return Some(Self::TooFew);
        }
        if exemplars.iter().all(|row| row.sha256 == exemplars[0].sha256) {
            return Some(Self::AllEqual);
        }
        let samples = Normaliser::new(options, common_size(exemplars.iter().map(size_px))?).length();
        if exemplars.len().saturating_mul(samples) > MOST_NUMBERS {
            return Some(Self::TooMuch { exemplars: exemplars.len(), samples, limit: MOST_NUMBERS });
        }
        if options.resize == Resize::Fit {
            return None;
        }
        Self::among_sizes(exemplars, options.width_px.zip(options.height_px))
    }

    /// Whether the exemplars differ in size, or from the size that the options want.
    fn among_sizes(exemplars: &[ExemplarRow], wanted: Option<(usize, usize)>) -> Option<Self> {
        let mut sizes = BTreeMap::<(u32, u32), usize>::new();
        for row in exemplars {
            *sizes.entry(size_px(row)).or_default() += 1;
        }
        let fits = |&(width, height): &(u32, u32)| match wanted {
            Some(wanted) => wanted == (width as usize, height as usize),
            None => width.max(height) as usize <= MAX_SIDE_PX,
        };
        if sizes.len() == 1 && sizes.keys().all(fits) {
            return None;
        }
        let mut sizes: Vec<_> = sizes.into_iter().collect();
        sizes.sort_by_key(|&(_, count)| std::cmp::Reverse(count));
        let list = |((width, height), count)| format!("{count} of {width}×{height} px");
        let mut found: Vec<String> = sizes.iter().copied().take(SIZES_NAMED).map(list).collect();
        if let Some(rest @ [_, ..]) = sizes.get(SIZES_NAMED..) {
            let others: usize = rest.iter().map(|(_, count)| count).sum();
            found.push(format!("{others} of {} other sizes", rest.len()));
        }
        Some(Self::Sizes {
            wanted: match wanted {
                Some((width, height)) => format!("{width}×{height} px"),
                None => format!("of one size, {MAX_SIDE_PX} px a side at most,"),
            },
            found: found.join(", "),
        })
    }

    /// The kind of problem.
    pub fn code(&self) -> Code {
        match self {
            Self::TooFew => Code::TooFewExemplars,
            Self::AllEqual => Code::AllEqual,
            Self::Sizes { .. } => Code::ImageSizeMismatch,
            Self::TooMuch { .. } => Code::TrainingTooLarge,
        }
    }
}

/// Numbers that a training may hold: 2 GiB of them.
const MOST_NUMBERS: usize = 1 << 29;
/// Sizes that a problem names one by one.
const SIZES_NAMED: usize = 5;

/// Width and height as decoded: the row has them from the decoder, which follows EXIF.
fn size_px(row: &ExemplarRow) -> (u32, u32) {
    (row.width_px, row.height_px)
}

impl From<UnfitExemplars> for Stop {
    fn from(unfit: UnfitExemplars) -> Self {
        Self::failed(unfit.code(), unfit.to_string())
    }
}

impl From<TrainingError> for Stop {
    fn from(error: TrainingError) -> Self {
        match error {
            TrainingError::TooFew { .. } => UnfitExemplars::TooFew.into(),
            TrainingError::AllEqual => UnfitExemplars::AllEqual.into(),
            error => Self::failed(Code::Internal, chain(&error)),
        }
    }
}

/// Trains the exemplars; returns the times of the stages too.
pub(super) async fn train(
    worker: &Worker<'_>,
    exemplars: Vec<ExemplarRow>,
    options: ObjectOptions,
) -> Result<(Trained, TrainingTimings), Stop> {
    if let Some(unfit) = UnfitExemplars::among(&exemplars, &options) {
        return Err(unfit.into());
    }
    let commonest_px = common_size(exemplars.iter().map(size_px)).ok_or(UnfitExemplars::TooFew)?;
    let posed = exemplars.iter().map(|row| (row.label.as_str(), row.pose_deg));
    let normaliser = Normaliser::new(&options, commonest_px).with_step_deg(common_step_deg(posed));
    let (with, count) = (normaliser.clone(), exemplars.len());
    let described = worker.each("describing", exemplars, None, move |place, row, frame| {
        let name = ViewName { id: row.id.to_string(), label: row.label.clone(), pose_deg: row.pose_deg };
        View::new(&with, name, frame, is_trial(place, count)).map_err(|error| {
            let text = format!("exemplar {}: {error}; delete it, or train with resize fit", row.id);
            Stop::failed(Code::ImageSizeMismatch, text)
        })
    });
    let (views, describe_ms) = described.await?;
    let fit = move || {
        let (model, report) = objects::train(views, &normaliser, &options)?;
        let counts = Counts {
            exemplars: model.views().len() as u64,
            labels: report.labels as u64,
            interest_points: 0,
        };
        let report = Report::Objects(Box::new(ObjectsReport::from(&report)));
        Ok(Trained { model: Model::Objects(Box::new(model)), report, counts })
    };
    let (trained, eigenspace_ms) = worker.alone("eigenspace", fit).await?;
    Ok((trained, TrainingTimings { describe: describe_ms, eigenspace: eigenspace_ms, rehearsal: None }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use jiff::Timestamp;
    use landmarkd_core::recognition::objects::AppearanceOf;
    use uuid::Uuid;

    fn row(sha256: u8, width_px: u32, height_px: u32) -> ExemplarRow {
        ExemplarRow {
            database: "d".into(),
            id: Uuid::new_v8([sha256; 16]),
            label: "cup".into(),
            negative: false,
            pose_deg: None,
            survey: None,
            width_px,
            height_px,
            bytes: 1,
            sha256: sha256.to_string(),
            blob: String::new(),
            media_type: "image/png".into(),
            robot_id: None,
            frame_id: None,
            stamp: None,
            created_at: Timestamp::UNIX_EPOCH,
        }
    }

    #[test]
    fn one_exemplar_or_copies_of_one_are_unfit() {
        let options = ObjectOptions::default();
        assert_eq!(UnfitExemplars::among(&[row(1, 8, 8)], &options), Some(UnfitExemplars::TooFew));
        let copies = [row(1, 8, 8), row(1, 8, 8)];
        assert_eq!(UnfitExemplars::among(&copies, &options), Some(UnfitExemplars::AllEqual));
        assert_eq!(UnfitExemplars::among(&[row(1, 8, 8), row(2, 9, 9)], &options), None);
    }

    #[test]
    fn with_resize_never_sizes_that_differ_are_counted() {
        let never = ObjectOptions { resize: Resize::Never, ..Default::default() };
        let mixed = [row(1, 8, 8), row(2, 16, 8), row(3, 16, 8)];
        let text = UnfitExemplars::among(&mixed, &never).unwrap().to_string();
        assert!(text.contains("of one size") && text.contains("2 of 16×8 px, 1 of 8×8 px"), "{text}");
        assert_eq!(UnfitExemplars::among(&mixed[1..], &never), None);

        let other = ObjectOptions { width_px: Some(32), height_px: Some(32), ..never };
        let text = UnfitExemplars::among(&mixed[1..], &other).unwrap().to_string();
        assert!(text.contains("must be 32×32 px") && text.contains("2 of 16×8 px"), "{text}");
    }

    #[test]
    fn more_than_memory_holds_is_refused_before_anything_is_read() {
        let raw = ObjectOptions { smoothing: 0.0, ..ObjectOptions::of(AppearanceOf::Intensity) };
        let rows: Vec<ExemplarRow> = (0..255).map(|n| row(n, 4000, 3000)).collect();
        assert_eq!(UnfitExemplars::among(&rows, &raw), None, "shrunk to 1024 px they fit");
        let many: Vec<ExemplarRow> = rows.iter().cycle().take(800).cloned().collect();
        assert_eq!(
            UnfitExemplars::among(&many, &raw).map(|unfit| unfit.code()),
            Some(Code::TrainingTooLarge)
        );
        assert_eq!(UnfitExemplars::among(&many, &ObjectOptions::default()), None);
    }

    #[test]
    fn many_sizes_are_summed_up() {
        let never = ObjectOptions { resize: Resize::Never, ..Default::default() };
        let rows: Vec<ExemplarRow> = (1..=9).map(|n| row(n, 8 + u32::from(n), 8)).collect();
        let text = UnfitExemplars::among(&rows, &never).unwrap().to_string();
        assert!(text.contains("4 of 4 other sizes"), "{text}");
    }
}
