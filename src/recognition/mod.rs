//! What is seen, and where: training and recognition as values in, values out.

pub mod landmarks;
