//! What the fuzz targets share: the service, drawn inputs, and correct checksums for changed artifacts.

pub mod artifacts;
pub mod drawn;
pub mod seeds;
pub mod service;
