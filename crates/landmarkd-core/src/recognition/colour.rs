//! The colours that a database compares beside the luminance.

/// The colour planes of signatures or appearances.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colour {
    /// Opponent if every exemplar is in colour, else gray.
    ///
    /// Measured with the vote of paper A and its defaults, gray → opponent. Rooms and corridors seen 1, 2
    /// and 3 s away (20 places, 40 frames each): 0.30 → 0.73, 0.23 → 0.38, 0.08 → 0.25 right. Objects on
    /// photographs, 30 % occluded, and both (12 objects, 240 frames each): 0.48 → 0.50, 0.59 → 0.57,
    /// 0.38 → 0.33: no difference beyond sampling error.
    Auto,
    /// Luminance only.
    Gray,
    /// Luminance, and the two opponent planes r − g and b − (r + g)/2.
    Opponent,
}
