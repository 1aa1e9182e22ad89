//! The mathematics of landmarkd: which place or object a picture shows, how it is turned, how far away it is.
//!
//! Values in, values out: no async, no I/O, no clock, no log. [`imaging`] turns bytes into a [`imaging::Frame`]; [`vision`]
//! describes it; [`eigen`] is the linear algebra; [`recognition`] names places and objects; [`depth`] measures distances
//! from a focal pair; [`geometry`] knows cameras and motions in space, [`localisation`] where a camera stands; [`workcell`]
//! maps what was found to the robot. [`angle`], [`random`] and [`statistics`] are small
//! and shared by several of them. `ARCHITECTURE.md` of the service walks through them.

pub mod angle;
pub mod depth;
pub mod eigen;
pub mod geometry;
pub mod imaging;
pub mod localisation;
pub mod random;
pub mod recognition;
pub mod statistics;
pub mod vision;
pub mod workcell;
