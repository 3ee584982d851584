//! What umbrage is timed against, apart from hand-written renderers: fixed work that is played in
//! turn with every row of a comparison, and rays as the `obvhs` crate traces them.
//!
//! This is a crate of its own since it has to be optimised fully, and the laboratory around it,
//! which writes pages and charts, is not: that would double the time that the first build takes.

mod rays;
mod yardstick;

pub use rays::{AnyHitRay, ObvhsScene, time_own_rays};
pub use yardstick::{MAX_UNITS, MIN_UNITS, Yardstick, YardstickKernel, YardstickUniforms};
