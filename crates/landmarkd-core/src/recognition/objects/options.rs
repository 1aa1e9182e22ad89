//! The options of an object database; each says where the text of paper B has it.

pub use crate::eigen::Search;
use crate::recognition::{Colour, OptionFault};

/// What an appearance is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AppearanceOf {
    /// Orientation histograms of the gradient: light, contrast and a few pixels of shift hardly matter. A query is
    /// aligned before its distance is taken.
    Gradient,
    /// The gray levels, as paper B has it (B(7)).
    Intensity,
}

/// What to do with a picture that is not of the database's size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Resize {
    /// Scale it to fit, centred on black; the answer or report warns.
    Fit,
    /// Refuse it.
    Never,
}

/// Coordinates of an eigenpoint in the universal eigenspace.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    /// The least that recognises held-out views as well as any.
    Auto,
    /// So many, or as many as there are.
    Fixed(usize),
}

/// Which eigenspaces answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stages {
    /// B§5: the universal eigenspace proposes objects, their own eigenspaces decide which it is, and its pose.
    UniversalThenObject,
    /// B§6: the universal eigenspace alone, for small sets.
    UniversalOnly,
}

/// The distance by which the universal eigenspace orders objects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Distance {
    /// B(14): the distance to an object's nearest eigenpoint.
    Euclidean,
    /// B(15): the distance to an object's mean by the covariance of its eigenpoints.
    Mahalanobis,
}

/// All options of an object database.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectOptions {
    /// What an appearance is made of.
    pub appearance: AppearanceOf,
    /// The colours of an appearance of gradients; gray of one of intensities.
    pub colour: Colour,
    /// Size of the database's pictures, 8..=1024 px; `None`: the commonest size among the exemplars,
    /// shrunk to 1024 px a side. Both or neither.
    pub width_px: Option<usize>,
    /// As `width_px`.
    pub height_px: Option<usize>,
    /// What to do with a picture of another size.
    pub resize: Resize,
    /// Whether the object is cropped from its picture first: the largest region that stands out from the background, in
    /// the square about its centroid, on black (B§3). Pictures are then square, of 128 px unless a size is given.
    pub segment: bool,
    /// Standard deviation of the Gaussian that pictures are smoothed with, as a part of their longer side, 0..=0.1.
    /// The paper does not smooth: 0. See [`ObjectOptions::of`].
    pub smoothing: f64,
    /// Coordinates of an eigenpoint in the universal eigenspace.
    pub dimension: Dimension,
    /// Which eigenspaces answer.
    pub stages: Stages,
    /// The search for eigenpoints.
    pub search: Search,
    /// The distance by which objects are ordered.
    pub distance: Distance,
    /// Part of the known objects that is to be accepted, 0.5..=0.9999 (B(16) leaves the threshold open).
    pub accept: f64,
}

/// Most pixels a side of a database's pictures.
pub const MAX_SIDE_PX: usize = 1024;
/// Most coordinates of the universal eigenspace.
pub const MAX_DIMENSION: usize = 256;

impl ObjectOptions {
    /// The defaults of an appearance: smoothed by 1.5 px of 128 before gradients are taken, of which more are accepted, as
    /// they are told from unknown ones more surely; intensities by 3 px of 128, and without colours.
    pub fn of(appearance: AppearanceOf) -> ObjectOptions {
        let (smoothing, colour, accept) = match appearance {
            AppearanceOf::Gradient => (1.5 / 128.0, Colour::Auto, 0.98),
            AppearanceOf::Intensity => (3.0 / 128.0, Colour::Gray, 0.97),
        };
        ObjectOptions {
            appearance,
            colour,
            width_px: None,
            height_px: None,
            resize: Resize::Fit,
            segment: false,
            smoothing,
            dimension: Dimension::Auto,
            stages: Stages::UniversalThenObject,
            search: Search::KdTree,
            distance: Distance::Euclidean,
            accept,
        }
    }

    /// Everything that is wrong with the options, all at once; empty if they can be used.
    pub fn faults(&self) -> Vec<OptionFault> {
        let mut faults = Vec::new();
        let mut fault = |option, message| faults.push(OptionFault { option, message });
        for (option, side) in [("width_px", self.width_px), ("height_px", self.height_px)] {
            if let Some(side) = side.filter(|side| !(8..=MAX_SIDE_PX).contains(side)) {
                fault(option, format!("{side} is not in 8..={MAX_SIDE_PX}"));
            }
        }
        match (self.width_px, self.height_px) {
            (Some(_), None) => fault("height_px", "must be given with width_px".to_owned()),
            (None, Some(_)) => fault("width_px", "must be given with height_px".to_owned()),
            _ => {}
        }
        if self.appearance == AppearanceOf::Intensity && self.colour != Colour::Gray {
            fault("colour", "must be gray with appearance intensity".to_owned());
        }
        if !(0.0..=0.1).contains(&self.smoothing) {
            fault("smoothing", format!("{} is not in 0..=0.1", self.smoothing));
        }
        if let Dimension::Fixed(dimension) = self.dimension
            && !(1..=MAX_DIMENSION).contains(&dimension)
        {
            fault("dimension", format!("{dimension} is not in 1..={MAX_DIMENSION}, nor auto"));
        }
        if !(0.5..=0.9999).contains(&self.accept) {
            fault("accept", format!("{} is not in 0.5..=0.9999", self.accept));
        }
        faults
    }
}

impl Default for ObjectOptions {
    fn default() -> Self {
        ObjectOptions::of(AppearanceOf::Gradient)
    }
}
