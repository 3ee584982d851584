//! The techniques, one a file in Rust beside one of the same name in WGSL.

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

/// Errors if anything is cut out of casters, for techniques that take them for whole; `why` says
/// what they do with them.
fn check_no_holes(geometry: &Geometry, why: &str) -> Result<(), RecipeError> {
    if !geometry.has_cut_out_casters() {
        return Ok(());
    }
    Err(RecipeError::unsupported(format!(
        "holes that alpha textures cut into casters are not told here, {why}: use `traced`, `exact`, `soft` or a map"
    )))
}
