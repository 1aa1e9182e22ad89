//! What is seen, and where: training and recognition as values in, values out.

pub mod landmarks;
pub mod objects;
mod option_fault;

pub use option_fault::OptionFault;
