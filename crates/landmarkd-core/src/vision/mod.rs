//! From pixels to signatures, in the order of the paper's section 4: smoothing, gradient, symmetry map or
//! another attention operator, interest points (A§4.2); polar sub-windows (A§4.3); signatures (A§4.4) and
//! their colour part. Beside them segmentation (paper B, B§3).
//!
//! The loops are plain arithmetic that a compiler turns into vector instructions; `pulp` compiles them
//! once for the baseline and once for AVX2 and picks at run time. No multiplication is fused with an
//! addition and no sum is reordered, so both give the same bits.

pub mod gradient;
pub mod gradient_field;
pub mod gradient_signature;
pub mod harris;
pub mod interest_points;
pub mod opponent;
mod option_fault;
pub mod scale_space;
pub mod segmentation;
pub mod signature;
pub mod smoothing;
pub mod subwindow;
pub mod symmetry;
pub mod theta_spectrum;

pub use gradient::{Gradient, PaddedGradient, gradient, gradient_at};
pub use gradient_field::{GradientField, Similarity};
pub use harris::harris;
pub use interest_points::{InterestPoint, bucketed, interest_points};
pub use opponent::OpponentPlan;
pub use option_fault::OptionFault;
pub use signature::{Normalise, SignaturePlan, SignatureScratch, Taper};
pub use smoothing::smoothed;
pub use subwindow::{PolarGrid, PolarSubwindow};
pub use symmetry::symmetry_map;
pub use theta_spectrum::{KeptSpectrum, RelativeTurn, ThetaPlan, kept_spectrum, spectrum_length};
