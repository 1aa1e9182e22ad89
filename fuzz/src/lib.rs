//! What the fuzz targets share: the service, drawn inputs, and what makes a changed artifact look whole again.

pub mod artifacts;
pub mod drawn;
pub mod seeds;
pub mod site;
