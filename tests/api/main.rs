//! What the service promises its users, one file a promise: the real router over an embedded store in a temporary
//! folder, no ports. Only `restarts` and `tls` start the real binary, and `connections` listens.

#![expect(clippy::unwrap_used, reason = "a test fails where its helpers panic")]

mod app;
mod depth_pictures;
mod descriptions;
mod pictures;
mod process;
mod waits;

mod audit;
mod calibrations;
mod connections;
mod console;
mod depth_maps;
mod events;
mod exemplars;
mod freeform;
mod gate;
mod golden;
mod growing;
mod hostile;
mod jobs;
mod keys;
mod limits;
mod localisation;
mod main_job;
mod negatives;
mod objects;
mod placements;
mod problems;
mod resident;
mod restarts;
mod rigs;
mod segmentations;
mod self_check;
mod service;
mod surveys;
mod swaps;
mod tls;
mod tracks;
mod unlearning;
mod versions;
mod workcells;
