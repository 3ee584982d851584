//! c1 to c3b: a box and spheres under lights without extent.

use super::{SIZE, exact, floor};
use crate::{
    ClosedForm,
    primitives::{block, icosphere},
    stage::{Stage, bulb, sun},
};
use umbrage_core::Scene;

/// Number of subdivisions, for 20,480 triangles. Their outline is within 6e-4 of the sphere's.
const SPLITS: u32 = 5;

pub(crate) fn box_sun() -> Scene {
    Stage::new("c1-box-sun")
        .put(floor(4.0))
        .put(block([-1.0, 0.0, -1.0], [1.0, 2.0, 1.0]))
        .light(sun(1.0, -2.0, 0.5))
        .shoot([1.5, 9.0, 5.0], [0.4, 0.0, 0.4], 36.0, SIZE)
}

/// The shadow is the hexagon (-1,-1) (1,-1) (2,-.5) (2,1.5) (0,1.5) (-1,1) in (x, z).
pub(crate) fn box_sun_samples() -> ClosedForm {
    exact(&[
        (1.5, 0.5, 0.0),
        (1.5, -0.7, 0.0),
        (1.5, -0.8, 1.0),
        (1.99, 0.5, 0.0),
        (2.01, 0.5, 1.0),
        // Contact: half a millimetre from the foot of the box, on its dark and on its lit side.
        (1.0005, 0.0, 0.0),
        (-1.0005, 0.0, 1.0),
        (-0.5, 1.24, 0.0),
        (-0.5, 1.26, 1.0),
        (1.999, 1.499, 0.0),
        (2.001, 1.501, 1.0),
    ])
}

pub(crate) fn sphere_sun() -> Scene {
    let thirty = 30.0_f64.to_radians();
    Stage::new("c2-sphere-sun")
        .put(floor(7.0))
        .put(icosphere([0.0, 2.0, 0.0], 1.0, SPLITS))
        .light(sun(thirty.cos() as f32, -thirty.sin() as f32, 0.0))
        .shoot([4.0, 7.0, 7.0], [2.8, 0.0, 0.0], 42.0, SIZE)
}

/// The shadow is the ellipse ((x - 2 sqrt 3) / 2)^2 + z^2 < 1.
pub(crate) fn sphere_sun_samples() -> ClosedForm {
    exact(&[
        (5.4541, 0.0, 0.0),
        (5.4741, 0.0, 1.0),
        (1.4741, 0.0, 0.0),
        (1.4541, 0.0, 1.0),
        (3.4641, 0.995, 0.0),
        (3.4641, 1.005, 1.0),
    ])
}

pub(crate) fn sphere_bulb() -> Scene {
    Stage::new("c3-sphere-bulb")
        .put(floor(5.0))
        .put(icosphere([1.0, 2.0, 0.0], 0.5, SPLITS))
        .light(bulb(0.0, 4.0, 0.0))
        .shoot([3.5, 4.5, 5.0], [1.9, 0.3, 0.0], 42.0, SIZE)
}

/// The shadow is bounded by the ellipse (x + 8)^2 = 4.75 (x^2 + z^2 + 16).
pub(crate) fn sphere_bulb_samples() -> ClosedForm {
    exact(&[
        (0.96096, 0.0, 1.0),
        (0.98096, 0.0, 0.0),
        (3.2757, 0.0, 0.0),
        (3.3157, 0.0, 1.0),
        (2.1333, 1.0228, 0.0),
        (2.1333, 1.0428, 1.0),
    ])
}

pub(crate) fn sphere_level_bulb() -> Scene {
    Stage::new("c3b-sphere-level-bulb")
        .put(floor(40.0))
        .put(icosphere([1.5, 2.0, 0.0], 0.5, SPLITS))
        .light(bulb(0.0, 2.0, 0.0))
        .shoot([14.0, 22.0, 30.0], [16.0, 0.0, 2.0], 48.0, SIZE)
}

/// The light is as high as the sphere's centre: one branch of the hyperbola x^2 / 32 - z^2 / 4 = 1
/// bounds the shadow.
pub(crate) fn sphere_level_bulb_samples() -> ClosedForm {
    exact(&[
        (5.63, 0.0, 1.0),
        (5.69, 0.0, 0.0),
        (10.0, 2.8955, 0.0),
        (10.0, 2.9355, 1.0),
        (30.0, 10.366, 0.0),
        (30.0, 10.466, 1.0),
    ])
}
