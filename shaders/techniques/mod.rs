//! Shadow techniques, each one Rust file with a WGSL file of the same name.

pub mod evsm;
pub mod exact;
pub mod hard;
pub(crate) mod infinite_far;
pub mod map_technique;
pub mod midpoint;
pub mod msm;
pub mod pcf;
pub mod pcf_disc;
pub mod pcf_dithered;
pub mod pcf_hardware;
pub mod pcf_merged;
pub mod pcss;
pub mod planar;
pub mod second_depth;
#[cfg(feature = "rays")]
pub mod soft;
#[cfg(feature = "rays")]
pub mod traced;
pub mod unshadowed;
pub mod volumes;
pub mod vsm;

use umbrage_core::{Geometry, RecipeError};

/// Errors if any caster is alpha-tested, for techniques that treat casters as opaque. `why`
/// describes how they use casters.
fn check_no_holes(geometry: &Geometry, why: &str) -> Result<(), RecipeError> {
    if !geometry.has_cut_out_casters() {
        return Ok(());
    }
    Err(RecipeError::unsupported_because(format!(
        "alpha-tested casters are not supported, {why}: use `traced`, `exact`, `soft` or a map"
    )))
}
