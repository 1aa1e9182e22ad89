//! Recognition of places and objects: training and recognition as values in, values out.

pub mod comparison;
pub mod landmarks;
pub mod objects;

pub use crate::vision::OptionFault;
pub use comparison::Comparison;
