//! One quantity varied from too little to too much: bias, light angle, scale, distance from the
//! origin, map size.
//!
//! Figures are the first backend's. The others render each curve's ends and its middle, and must
//! agree there.

mod bias;
mod chart;
pub(super) mod curve;
mod reach;
mod variants;

pub use curve::{Curve, Sweep};
pub use variants::{move_scene, scale_scene, under_sun};

use super::{
    run::{StabilityOptions, some_backend},
    threads::SharedBackends,
};
use crate::{compare::Backends, error::LabError};

/// Runs all sweeps. [`Sweep::fault`] reports disagreeing backends.
///
/// # Errors
/// Errors if there is no backend, a scene can't be used, or a technique's result breaks the rules
/// (a panic, values outside 0..=1).
pub fn sweeps(
    options: &StabilityOptions,
    backends: &mut Backends,
    on_sweep: &mut dyn FnMut(&str),
) -> Result<Vec<Sweep>, LabError> {
    some_backend(backends)?;
    let backends = &SharedBackends::new(backends);
    let mut out = Vec::new();
    for kind in bias::ALL {
        on_sweep(kind.name);
        out.push(bias::sweep(kind, options, backends)?);
    }
    for kind in reach::ALL {
        on_sweep(kind.name);
        out.push(reach::sweep(kind, options, backends)?);
    }
    Ok(out)
}
