//! References that umbrage's times are compared with, apart from hand-written renderers. They are a
//! fixed workload that runs in turn with every row of a comparison, and rays traced by the `obvhs`
//! crate.
//!
//! This is a separate crate because it has to be fully optimised. The laboratory, which writes
//! pages and charts, is not: that would double the time of the first build.

mod rays;
mod yardstick;

pub use rays::{AnyHitRay, ObvhsScene, time_own_rays};
pub use yardstick::{MAX_UNITS, MIN_UNITS, Yardstick, YardstickKernel, YardstickUniforms};
