//! A point of one picture and a point of another that may show the same.

/// A point of one picture and a point of another that may show the same, with the surroundings of both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointPair {
    /// In the first picture.
    pub from_px: [f64; 2],
    /// In the second.
    pub to_px: [f64; 2],
    /// How coarse the positions are, in pixels of the first and of the second picture: their errors are in proportion, and
    /// what is seen in the second is so many times as large as in the first.
    pub scale_px: [f64; 2],
    /// By how much the surroundings are turned in the second picture against the first, from x towards y.
    pub turn_rad: f64,
    /// How much speaks for the pair: greater is likelier.
    pub weight: f64,
}
