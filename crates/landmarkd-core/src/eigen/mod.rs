//! Linear algebra that knows nothing of images: eigenspaces of row vectors, and the nearest of a set of
//! eigenpoints (A§4.1, A§4.5, B(10)–(16)). Vectors are rows of row-major `f32` matrices; training is done in `f64`.

pub mod eigenspace;
pub mod hermitian;
pub mod inverted_index;
pub mod mahalanobis;
pub mod neighbours;
pub mod radius_index;
mod real_roots;
pub mod symmetric;
mod tree;

pub use eigenspace::{EigenError, Eigenspace};
pub use inverted_index::{Code, Codebook, InvertedIndex, lists_for};
pub use mahalanobis::ClassCovariance;
pub use neighbours::{EigenpointIndex, Neighbour};
pub use radius_index::{RadiusIndex, Search};
pub use real_roots::real_roots;
pub use symmetric::Symmetric;
