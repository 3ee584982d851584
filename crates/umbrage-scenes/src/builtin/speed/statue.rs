//! One dense model.

use super::SIZE;
use crate::{
    builtin::noise::fractal,
    primitives::{lathe, on_circle, pillar},
    stage::{Stage, sun},
};
use umbrage_core::glam::{Affine3A, Vec3};
use umbrage_core::{Mesh, Scene};

/// Segments around, and rings between the poles: 2 x 264 x 131 = 69,168 triangles.
const SEGMENTS: u32 = 264;
const RINGS: u32 = 131;

pub(crate) fn statue() -> Scene {
    Stage::new("statue")
        .put_many(
            pillar(1.3, 0.3, 64),
            [Affine3A::from_translation(Vec3::new(0.0, -1.6, 0.0))],
        )
        .put(stone())
        .light(sun(0.7, -1.0, -0.6))
        .shoot([1.6, 1.4, 4.6], [0.0, -0.05, 0.0], 40.0, SIZE)
}

/// A ball of 1 m with strong noise displacement.
fn stone() -> Mesh {
    let profile: Vec<_> = (0..RINGS + 2)
        .map(|i| {
            let (cos, sin) = on_circle(f64::from(i) / f64::from(2 * (RINGS + 1)));
            (sin, -cos)
        })
        .collect();
    let mut mesh = Mesh {
        name: "stone".to_owned(),
        ..lathe(&profile, SEGMENTS)
    };
    for p in &mut mesh.positions {
        let folds = 1.0 - 2.0 * fractal(*p * 2.5 + Vec3::splat(40.0), 5).abs();
        *p *= Vec3::new(0.9, 1.25, 0.9)
            * (0.8 + 0.3 * folds + 0.15 * fractal(*p * 1.3 + Vec3::splat(7.0), 3));
    }
    mesh
}
