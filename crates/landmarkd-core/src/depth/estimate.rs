//! What a method measures of a pair, before calibration and lens law: β on a grid, with its evidence.

/// What a method measured at one point of the grid.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    /// β, but for `laplacian` a difference of energies.
    pub(super) beta: f32,
    /// Standard deviation of `beta`; infinite without a measurement, NaN where the method has no model of its error.
    pub(super) sigma: f32,
    /// How badly one depth explains the window: at most 1 if it does.
    pub(super) misfit: f32,
    /// Whether the texture suffices, but two depths explain it.
    pub(super) ambiguous: bool,
    /// Whether the estimates about the point differ by more than their errors: there is a step in depth.
    pub(super) scattered: bool,
}

impl Sample {
    /// No measurement.
    pub(super) const UNKNOWN: Sample =
        Sample { beta: 0.0, sigma: f32::INFINITY, misfit: 0.0, ambiguous: false, scattered: false };
}

/// Samples at every `step`-th pixel of the pictures that the method worked on.
#[derive(Clone, Debug)]
pub(super) struct Samples {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Pixels between neighbours of the grid.
    pub(super) step: usize,
    /// `width` × `height`, row-major.
    pub(super) points: Vec<Sample>,
}

/// What a method measures of a pair.
#[derive(Clone, Debug)]
pub(super) struct Estimate {
    pub(super) samples: Samples,
    /// Noise of the pictures that the method worked on, in gray levels; `None` if the method estimates none.
    pub(super) noise_sigma: Option<f64>,
}
