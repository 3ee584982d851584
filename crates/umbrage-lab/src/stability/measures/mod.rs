//! Measures as pure functions of a mask, truth and places, each tested on known input.

pub mod band;
pub mod cascade_seams;
pub mod cube_seams;
pub mod edge;
pub mod gap;
pub mod open;
pub mod penumbra;
pub mod shimmer;
