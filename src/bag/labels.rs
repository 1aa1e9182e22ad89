//! What the pictures of a bag are called: one label for all, or that of the cell of the map that the camera stands in.

use clap::Args;
use landmarkd_core::geometry::MapPose;

use super::BagError;
use super::contents::positive;
use crate::database::Name;

/// How pictures are labelled.
#[derive(Args, Clone, Debug)]
pub struct LabelArgs {
    /// One label for all pictures [default: cells of the map, such as hall_3_-2 in a database hall]
    #[arg(long, value_name = "LABEL")]
    pub label: Option<String>,
    /// Side of a cell in metres; hall_3_-2 reaches from x = 3 cells and y = -2 cells to the next
    #[arg(long, value_name = "M", default_value_t = 2.0, value_parser = positive, conflicts_with = "label")]
    pub cell_m: f64,
}

/// The labels of a bag's pictures.
#[derive(Clone, Debug)]
pub enum Labels {
    /// One for all.
    One(String),
    /// `<prefix>_<column>_<row>` of the map's cells.
    Cells { prefix: String, cell_m: f64 },
}

impl Labels {
    /// As the arguments say; `poses` says whether there are any.
    ///
    /// # Errors
    /// [`BagError::Name`] for a label that can't be one, [`BagError::NoLabels`] with neither label nor poses.
    pub fn of(args: &LabelArgs, database: &Name, poses: bool) -> Result<Labels, BagError> {
        match &args.label {
            Some(label) => match Name::parse(label) {
                Ok(_) => Ok(Labels::One(label.clone())),
                Err(error) => {
                    Err(BagError::Name { what: "the label", name: label.clone(), reason: error.to_string() })
                }
            },
            None if poses => {
                // the longest column and row have eleven characters each
                let prefix = database.as_str().chars().take(40).collect();
                Ok(Labels::Cells { prefix, cell_m: args.cell_m })
            }
            None => Err(BagError::NoLabels),
        }
    }

    /// The label of a picture; `None`: no pose says.
    pub fn label(&self, pose: Option<&MapPose>) -> Option<String> {
        match self {
            Labels::One(label) => Some(label.clone()),
            Labels::Cells { prefix, cell_m } => pose.map(|pose| {
                let [column, row] = [pose.x_m, pose.y_m].map(|at_m| (at_m / cell_m).floor() as i32);
                format!("{prefix}_{column}_{row}")
            }),
        }
    }

    /// Whether two labels are of one cell or of cells that touch.
    pub fn are_near(&self, a: &str, b: &str) -> bool {
        match (self, self.cell(a), self.cell(b)) {
            (Labels::Cells { .. }, Some(a), Some(b)) => (0..2).all(|axis| a[axis].abs_diff(b[axis]) <= 1),
            _ => a == b,
        }
    }

    fn cell(&self, label: &str) -> Option<[i32; 2]> {
        let Labels::Cells { prefix, .. } = self else { return None };
        let (column, row) = label.strip_prefix(prefix)?.strip_prefix('_')?.split_once('_')?;
        Some([column.parse().ok()?, row.parse().ok()?])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_is_labelled_by_its_cell_and_cells_beside_it_are_near() {
        let database = Name::parse("hall").unwrap();
        let args = LabelArgs { label: None, cell_m: 2.0 };
        let labels = Labels::of(&args, &database, true).unwrap();
        let label = |x_m, y_m| labels.label(Some(&MapPose { x_m, y_m, ..MapPose::default() })).unwrap();
        assert_eq!(
            [label(0.0, 0.0), label(7.9, -0.1), label(-2.1, 4.0)],
            ["hall_0_0", "hall_3_-1", "hall_-2_2"]
        );
        assert!(labels.are_near("hall_0_0", "hall_-1_1") && !labels.are_near("hall_0_0", "hall_2_0"));
        assert!(!labels.are_near("hall_0_0", "kitchen"));
        assert_eq!(labels.label(None), None);
        assert!(matches!(Labels::of(&args, &database, false), Err(BagError::NoLabels)));
    }

    #[test]
    fn a_label_of_ones_own_is_for_all_pictures() {
        let database = Name::parse("hall").unwrap();
        let of = |label: &str| {
            Labels::of(&LabelArgs { label: Some(label.to_owned()), cell_m: 2.0 }, &database, false)
        };
        assert_eq!(of("dock").unwrap().label(None).as_deref(), Some("dock"));
        assert!(matches!(of("the dock"), Err(BagError::Name { .. })));
    }
}
