//! A low sun, thin contacts, casters out of view, a vertical sun.

use crate::{
    builtin::SIZE,
    primitives::{block, grid, icosphere, pillar},
    stage::{Stage, sun},
};
use umbrage_core::glam::{Affine3A, Vec3};
use umbrage_core::{Light, Scene};

fn low_sun(name: &str, degrees: f64) -> Scene {
    let height = degrees.to_radians();
    let places =
        (0..16).map(|i| Affine3A::from_translation(Vec3::new(-45.0 + 6.0 * i as f32, 1.0, 0.0)));
    Stage::new(name)
        .put(grid([50.0, 50.0], [1, 1], |_, _| 0.0))
        .put_many(icosphere(Vec3::ZERO, 1.0, 3), places)
        .light(sun(
            (0.3 * height.cos()) as f32,
            -height.sin() as f32,
            (-0.954 * height.cos()) as f32,
        ))
        .shoot([-14.0, 6.0, 26.0], [0.0, 0.0, -6.0], 45.0, SIZE)
}

pub(crate) fn low_sun_2() -> Scene {
    low_sun("low-sun-2", 2.0)
}

pub(crate) fn low_sun_5() -> Scene {
    low_sun("low-sun-5", 5.0)
}

pub(crate) fn low_sun_10() -> Scene {
    low_sun("low-sun-10", 10.0)
}

/// Pairs of a ball and a post along 300 m, with the sun 8 degrees high. The depth range of the map
/// exceeds a quarter of a kilometre. The resolution of a 16-bit map is about 5 mm, which is striped
/// acne across its wide texels.
pub(crate) fn far_range() -> Scene {
    let height = 8.0_f64.to_radians();
    let at = |x: f32, z: f32| {
        (0..13).map(move |i| Affine3A::from_translation(Vec3::new(x, 0.0, z - 24.0 * i as f32)))
    };
    Stage::new("far-range")
        .put_many(
            grid([150.0, 170.0], [1, 1], |_, _| 0.0),
            [Affine3A::from_translation(Vec3::Z * -140.0)],
        )
        .put_many(icosphere(Vec3::Y, 1.0, 3), at(-1.5, 0.0))
        .put_many(pillar(0.3, 6.0, 24), at(4.5, -8.0))
        .light(sun(
            (-0.35 * height.cos()) as f32,
            -height.sin() as f32,
            (-0.937 * height.cos()) as f32,
        ))
        .shoot([15.0, 11.0, 16.0], [-3.0, 0.0, -22.0], 45.0, SIZE)
}

/// A plate 2 mm thick and half a metre high, lit from behind at 45 degrees.
pub(crate) fn thin_plate() -> Scene {
    Stage::new("thin-plate")
        .put(grid([2.0, 2.0], [1, 1], |_, _| 0.0))
        .put(block([-0.5, 0.0, -0.001], [0.5, 0.5, 0.001]))
        .light(sun(0.0, -1.0, 1.0))
        .shoot([0.55, 0.6, 1.5], [0.05, 0.1, 0.1], 40.0, SIZE)
}

/// A tower to the left of the image. Only its shadow is visible.
pub(crate) fn tower_out_of_view() -> Scene {
    Stage::new("tower-out-of-view")
        .put(grid([30.0, 30.0], [2, 2], |_, _| 0.0))
        .put(block([-13.0, 0.0, -1.5], [-11.0, 9.0, 1.5]))
        .light(sun(1.0, -0.65, 0.08))
        .shoot([0.0, 5.0, 9.0], [0.0, 0.0, 0.0], 42.0, SIZE)
}

fn posts(name: &str, light: Light) -> Scene {
    Stage::new(name)
        .put(grid([6.0, 6.0], [1, 1], |_, _| 0.0))
        .put(pillar(0.3, 2.0, 32))
        .put(block([1.2, 0.6, -0.8], [2.4, 0.8, 0.8]))
        .put(icosphere([-1.8, 1.2, 0.3], 0.6, 4))
        .light(light)
        .shoot([2.5, 3.2, 6.0], [0.2, 0.4, 0.0], 40.0, SIZE)
}

/// The light's direction is exactly opposite to the up vector of a usual look-at.
pub(crate) fn sun_above() -> Scene {
    posts("sun-above", sun(0.0, -1.0, 0.0))
}

pub(crate) fn spot_above() -> Scene {
    let [inner, outer] = [25.0_f32, 30.0].map(f32::to_radians);
    let position = Vec3::new(0.4, 7.0, 0.1);
    posts(
        "spot-above",
        Light::Spot {
            position,
            direction: Vec3::NEG_Y,
            inner,
            outer,
            radius: 0.0,
        },
    )
}
