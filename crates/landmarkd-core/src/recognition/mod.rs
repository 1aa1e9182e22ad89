//! Recognition of places and objects: training and recognition as values in, values out.

mod colour;
pub mod comparison;
pub mod landmarks;
pub mod objects;

pub use crate::vision::OptionFault;
pub use colour::Colour;
pub use comparison::Comparison;
