//! What a method says of a pair, before calibration and lens law: β on a grid, with its evidence.

/// β at every `step`-th pixel of the pictures the method worked on.
#[derive(Clone, Debug)]
pub(super) struct Samples {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Pixels between neighbours of the grid.
    pub(super) step: usize,
    /// What the method measured: β, but for `laplacian` a difference of energies.
    pub(super) beta: Vec<f32>,
    /// Its standard deviation; infinite where there is nothing to go by, NaN where the method has no model of it.
    pub(super) sigma: Vec<f32>,
    /// How badly one depth explains the window: 1 or less if it does.
    pub(super) misfit: Vec<f32>,
    /// Whether there would be enough to go by, but for a second answer.
    pub(super) ambiguous: Vec<bool>,
}

impl Samples {
    /// A grid on which nothing is known yet.
    pub(super) fn new(width: usize, height: usize, step: usize) -> Samples {
        let count = width * height;
        Samples {
            width,
            height,
            step,
            beta: vec![0.0; count],
            sigma: vec![f32::INFINITY; count],
            misfit: vec![0.0; count],
            ambiguous: vec![false; count],
        }
    }
}

/// What a method says of a pair.
#[derive(Clone, Debug)]
pub(super) struct Estimate {
    pub(super) samples: Samples,
    /// Noise of the pictures it worked on, in grey levels; `None` if the method doesn't say.
    pub(super) noise_sigma: Option<f64>,
}
