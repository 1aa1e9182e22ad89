//! What the service promises its users, one file a promise: the real router over an embedded store in a temporary
//! folder, no ports. Only `restarts` starts the real binary.

mod app;
mod depth_pictures;
mod pictures;
mod process;

mod calibrations;
mod depth_maps;
mod exemplars;
mod freeform;
mod gate;
mod jobs;
mod limits;
mod main_job;
mod objects;
mod placements;
mod problems;
mod restarts;
mod segmentations;
mod service;
mod swaps;
mod tracks;
mod versions;
mod workcells;
