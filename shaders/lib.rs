//! umbrage's built-in shadow techniques: each one file in Rust beside one of the same name in WGSL. Only public API of
//! `umbrage-core` is used, so a technique of yours can do all that these do.

mod batch;
mod bias;
mod catalogue;
mod hard;
mod lanes;
mod pcf;
mod pcf_dithered;
pub mod shadow_map;
mod traced;

pub use bias::Bias;
pub use catalogue::{Entry, Settings, all, find};
pub use hard::{Hard, HardKernel};
pub use pcf::{MAX_RADIUS, Pcf, PcfKernel, PcfUniforms};
pub use pcf_dithered::{PcfDithered, PcfDitheredKernel};
pub use shadow_map::ShadowMap;
pub use traced::{MAX_SAMPLES, Traced, TracedKernel, TracedUniforms};

use umbrage_core::Twin;

/// Every pair of functions that the techniques share between the languages, for the lockstep tests.
pub fn twins() -> impl Iterator<Item = &'static Twin> {
    shadow_map::TWINS.iter()
}
