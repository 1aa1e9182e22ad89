//! Pictures: one concrete image type, decoding under limits, PNG, arrays and point clouds out, evidence drawn on a
//! frame, distances in false colours.
//!
//! Pixels are `f32` gray levels 0..=255, row-major; x right, y down, the origin at the centre of the
//! top-left pixel. One type without a pixel parameter: every operator of both papers works on real
//! numbers, and a single monomorphic plane keeps the arithmetic readable and vectorisable. The outside
//! image codec and the drawing crate are known to this room alone.

mod canvas;
pub mod decode;
pub mod encode;
pub mod false_colour;
pub mod frame;
pub mod image;
pub mod npy;
pub mod overlay;
pub mod ply;
mod reduction;
pub mod resize;
pub mod sampling;

pub use crate::random::{Random, seed_of_name};
pub use decode::{DecodeError, DecodeLimits, Format, Header, decode, decode_reduced, read_header};
pub use frame::Frame;
pub use image::Image;
pub use overlay::Overlay;
pub use resize::fitted;
pub use sampling::{bilinear_inside, bilinear_replicated, bilinear_zero_padded, resampled};
