//! A match: a window of the frame and a trained window that resembles it.

/// A window of the frame and a trained window that resembles it. Alone it predicts a similarity of the exemplar onto the
/// frame: turn and scale, about two points that correspond.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Match {
    /// Index of the frame's window.
    pub query: u32,
    /// Index of the trained window's exemplar.
    pub exemplar: u32,
    /// How many trained windows are nearer to the frame's window.
    pub rank: u32,
    /// Offset of the trained window from the exemplar's centre, exemplar pixels.
    pub from: [f32; 2],
    /// Position of the frame's window, frame pixels.
    pub to: [f32; 2],
    /// Turn of the frame's window against the trained one, from x towards y, in (−π, π].
    pub turn_rad: f32,
    /// Frame pixels per exemplar pixel.
    pub scale: f32,
    /// Radius of the frame's window, frame pixels.
    pub radius_px: f32,
    /// How much nearer the trained window is than the background, in (0, 1].
    pub weight: f32,
    /// What the match adds to its exemplar's votes: by how much the square of its distance is less than the background's.
    pub vote: f32,
}

impl Match {
    /// Where the match alone places the exemplar's centre.
    pub fn centre(&self) -> [f32; 2] {
        let (sin, cos) = self.turn_rad.sin_cos();
        let [x, y] = self.from;
        [self.to[0] - self.scale * (cos * x - sin * y), self.to[1] - self.scale * (sin * x + cos * y)]
    }

    /// The two points that correspond, in exemplar and frame.
    pub fn pair(&self) -> ([f64; 2], [f64; 2]) {
        (self.from.map(f64::from), self.to.map(f64::from))
    }
}
