//! Scenes that isolate one cause of error each: see `umbrage_core::metrics::Causes`.

use super::SIZE;
use crate::stage::{Stage, sun};
use crate::{
    builtin::closed::{floor, sheet},
    primitives::block,
};
use umbrage_core::glam::Vec3;
use umbrage_core::{Light, Scene};

/// A lit floor without casters. The only possible error is self-shadowing.
pub(crate) fn acne() -> Scene {
    Stage::new("cause-acne")
        .put(floor(5.0))
        .light(sun(1.0, -0.8, 0.3))
        .shoot([0.5, 3.0, 3.5], Vec3::ZERO, 36.0, SIZE)
}

/// The foot of a plate 1 cm thick, from its dark side. The far end of its shadow is out of view.
pub(crate) fn gap() -> Scene {
    Stage::new("cause-gap")
        .put(floor(4.0))
        .put(block([-0.01, 0.0, -3.0], [0.0, 2.0, 3.0]))
        .light(sun(1.0, -1.0, 0.1))
        .shoot([1.1, 0.9, 0.0], [0.3, 0.0, 0.0], 30.0, SIZE)
}

/// A floor completely in the shadow of a sheet high above it.
pub(crate) fn leak() -> Scene {
    Stage::new("cause-leak")
        .put(floor(6.0))
        .put(sheet([-5.0, 5.0], [-5.0, 5.0], 2.0))
        .light(sun(0.2, -1.0, 0.1))
        .shoot([0.5, 1.5, 2.5], Vec3::ZERO, 30.0, SIZE)
}

/// The edge of a sheet's hard shadow.
pub(crate) fn edge() -> Scene {
    under_sheet("cause-edge", sun(0.3, -1.0, 0.2))
}

/// The edge of [`edge`] under a square area light of 40 cm.
pub(crate) fn penumbra() -> Scene {
    let half = 0.2;
    let lamp = Light::Rect {
        center: Vec3::new(0.0, 4.0, 0.0),
        half_u: Vec3::X * half,
        half_v: Vec3::Z * half,
    };
    under_sheet("cause-penumbra", lamp)
}

/// A sheet 1 m above the floor. One edge of its shadow crosses the image at an angle.
fn under_sheet(name: &str, light: Light) -> Scene {
    Stage::new(name)
        .put(floor(4.0))
        .put(sheet([-1.5, 0.0], [-1.5, 1.5], 1.0))
        .light(light)
        .shoot([2.2, 0.8, 0.6], [0.2, 0.0, 0.0], 32.0, SIZE)
}
