//! Bags in the verb `evaluate`: what a service of its own is taught by one, and asked about another.

use std::num::NonZeroUsize;

use clap::Args;

use super::ask::AskArgs;
use super::contents::BagArgs;
use super::labels::LabelArgs;
use super::recording::Recording;
use super::selection::SelectionArgs;
use super::teach::TeachArgs;
use crate::evaluate::EvaluateArgs;

/// The database that bags are evaluated with; labels of cells begin so.
const DATABASE: &str = "map";

/// Arguments of `landmarkd evaluate` for bags alone.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Bags")]
pub struct BagEvaluationArgs {
    #[command(flatten)]
    bag: BagArgs,
    #[command(flatten)]
    labels: LabelArgs,
    #[command(flatten)]
    selection: SelectionArgs,
}

impl BagEvaluationArgs {
    /// What to teach and what to ask; `None` if neither the training pictures nor the queries are a bag.
    pub fn teach_and_ask(&self, args: &EvaluateArgs) -> Option<(TeachArgs, AskArgs)> {
        if ![&args.train_dir, &args.queries].into_iter().any(|path| Recording::is_at(path)) {
            return None;
        }
        let BagEvaluationArgs { bag, labels, selection } = self.clone();
        let teach = TeachArgs {
            bags: vec![args.train_dir.clone()],
            database: DATABASE.to_owned(),
            options: args.options.clone(),
            bag: bag.clone(),
            labels: labels.clone(),
            selection,
        };
        let ask = AskArgs {
            recording: args.queries.clone(),
            database: DATABASE.to_owned(),
            every: NonZeroUsize::MIN,
            out: None,
            draw: false,
            bag,
            labels,
        };
        Some((teach, ask))
    }
}
