//! Spot lights, and small area lights: the rim of a cone, and a light that is nearly a point.

use super::SMALL;
use crate::{
    primitives::{block, grid, on_circle, pillar},
    stage::Stage,
};
use umbrage_core::glam::{Affine3A, Vec3};
use umbrage_core::{Light, Scene};

/// Position of the spot. It points at the origin at an angle, so that no texel is parallel to the
/// floor.
const SPOT: Vec3 = Vec3::new(0.9, 4.0, 0.3);
/// Angle from the spot's axis to its rim, degrees: about [`CONE_RADIUS`] metres from the origin on
/// the floor.
const OUTER: f32 = 26.0;
/// Radius of the lit disc on the floor, metres.
const CONE_RADIUS: f32 = 2.0;

/// Distance of the posts from the axis, metres. The posts are just inside, so that each has a
/// shadow within the disc.
const POST_RADIUS: f32 = 0.86 * CONE_RADIUS;

/// Posts on the rim of the lit disc, half inside. Their shadows run along it and across. The map,
/// and the area in which kernels may sample, ends at the rim.
pub(crate) fn cone_rim() -> Scene {
    let posts = (0..8_u8).map(|i| {
        let (cos, sin) = on_circle(f64::from(i) / 8.0);
        Affine3A::from_translation(Vec3::new(cos, 0.0, sin) * POST_RADIUS)
    });
    Stage::new("cone-rim")
        .put(grid([4.0, 4.0], [1, 1], |_, _| 0.0))
        .put_many(pillar(0.08, 0.5, 16), posts)
        .light(Light::Spot {
            position: SPOT,
            direction: -SPOT,
            inner: 0.8 * OUTER.to_radians(),
            outer: OUTER.to_radians(),
            radius: 0.0,
        })
        .shoot([0.6, 3.4, 4.0], [0.0, 0.0, 0.2], 46.0, SMALL)
}

/// Bars 3 to 30 cm above the floor under a disc light of 2 mm. Their penumbrae are at most a
/// quarter of a millimetre wide; a texel of a map of 1,024 is about 4 mm.
pub(crate) fn small_lamp() -> Scene {
    let mut stage = Stage::new("small-lamp").put(grid([1.6, 1.6], [1, 1], |_, _| 0.0));
    for i in 0..7 {
        let x = -0.9 + 0.3 * i as f32;
        let y = 0.03 + 0.045 * i as f32;
        stage = stage.put(block([x - 0.04, y, -0.8], [x + 0.04, y + 0.03, 0.8]));
    }
    stage
        .light(Light::Disc {
            center: Vec3::new(0.3, 3.0, 0.5),
            normal: Vec3::NEG_Y,
            radius: 0.001,
        })
        .shoot([0.4, 1.7, 2.4], [0.0, 0.0, 0.0], 42.0, SMALL)
}
