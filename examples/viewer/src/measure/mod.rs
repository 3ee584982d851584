//! What is measured of the view while nothing moves: truth, errors, and where lookups go.

pub(crate) mod against_cpu;
pub(crate) mod cost;
pub(crate) mod figures;
pub(crate) mod places;
pub(crate) mod truth;
pub(crate) mod view_figures;
pub(crate) mod worker;

use umbrage::{Aabb, Camera, Geometry, Light, View};

/// Returns the view for which a light set plans: for its box around the casters, which is a little larger than they are. For another box
/// maps lie a rounding elsewhere.
pub(crate) fn planned_view<'a>(
    camera: &'a Camera,
    light: &'a Light,
    geometry: &'a Geometry,
    casters: Aabb,
) -> View<'a> {
    View {
        casters,
        ..View::new(camera, light, geometry)
    }
}
