//! A person on a floor under a distant spot light.

use super::SIZE;
use crate::{
    looks::{checker, matte},
    primitives::{block, grid, icosphere, lathe, on_circle, tile_mesh, tube},
    stage::Stage,
};
use umbrage_core::glam::{Vec2, Vec3};
use umbrage_core::{Light, Mesh, Scene};

pub(crate) fn figure() -> Scene {
    let position = Vec3::new(-9.0, 14.0, 8.0);
    let inner = 7.0_f32.to_radians();
    let outer = 9.0_f32.to_radians();
    let direction = Vec3::new(0.2, 0.7, -0.2) - position;
    let floor = tile_mesh(grid([6.0, 6.0], [6, 6], |_, _| 0.0), Vec2::splat(6.0));
    let mut stage = Stage::new("figure").put(floor).look(checker());
    for (part, color) in body().into_iter().zip(CLOTHES) {
        stage = stage.put(part).look(matte(color));
    }
    stage
        .light(Light::Spot {
            position,
            direction,
            inner,
            outer,
            radius: 0.0,
        })
        .shoot([1.6, 1.9, 4.2], [0.5, 0.75, -0.2], 40.0, SIZE)
}

const SHIRT: [f32; 3] = [0.09, 0.25, 0.48];
const SKIN: [f32; 3] = [0.56, 0.34, 0.24];
const TROUSERS: [f32; 3] = [0.14, 0.13, 0.16];
const SHOES: [f32; 3] = [0.24, 0.11, 0.05];
/// Colours of the parts of the [`body`], in their order.
const CLOTHES: [[f32; 3]; 11] = [
    SHIRT, SKIN, SKIN, TROUSERS, TROUSERS, SHIRT, SHIRT, SKIN, SKIN, SHOES, SHOES,
];

/// Returns a tube through points. Its radius changes from the first of `radii` to the second,
/// metres.
fn limb(points: &[[f32; 3]], radii: [f32; 2]) -> Mesh {
    let last = (points.len() - 1) as f32;
    let mut path = Vec::new();
    for (i, &point) in points.iter().enumerate() {
        let radius = radii[0] + (radii[1] - radii[0]) * i as f32 / last;
        path.push((Vec3::from(point), radius));
    }
    tube(&path, 16)
}

fn foot(x: f32) -> Mesh {
    block([x - 0.05, 0.0, -0.08], [x + 0.05, 0.07, 0.18])
}

/// Returns the parts of a body, 1.8 m tall, facing +z, with one arm raised.
fn body() -> [Mesh; CLOTHES.len()] {
    [
        torso(),
        icosphere([0.0, 1.66, 0.02], 0.13, 3),
        limb(&[[0.0, 1.4, 0.0], [0.0, 1.6, 0.01]], [0.06, 0.055]),
        limb(
            &[[-0.1, 0.86, 0.0], [-0.12, 0.47, 0.03], [-0.13, 0.05, 0.0]],
            [0.095, 0.05],
        ),
        limb(
            &[[0.1, 0.86, 0.0], [0.12, 0.47, 0.03], [0.13, 0.05, 0.0]],
            [0.095, 0.05],
        ),
        limb(
            &[[-0.2, 1.42, 0.0], [-0.32, 1.15, 0.02], [-0.28, 0.86, 0.12]],
            [0.055, 0.035],
        ),
        limb(
            &[[0.2, 1.42, 0.0], [0.42, 1.5, 0.04], [0.52, 1.8, 0.08]],
            [0.055, 0.035],
        ),
        icosphere([-0.275, 0.82, 0.13], 0.05, 2),
        icosphere([0.535, 1.85, 0.085], 0.05, 2),
        foot(-0.13),
        foot(0.13),
    ]
}

/// Returns the torso from hips to shoulders, flattened from front to back.
fn torso() -> Mesh {
    let profile: Vec<_> = (0..=16)
        .map(|i| {
            let t = i as f32 / 16.0;
            // Turn from pole to pole, with a waist.
            let (_, round) = on_circle(f64::from(t) / 2.0);
            let (waist, _) = on_circle(f64::from(t));
            (round.sqrt() * (0.21 + 0.03 * waist), 0.8 + 0.68 * t)
        })
        .collect();
    let mut mesh = lathe(&profile, 32);
    mesh.positions.iter_mut().for_each(|p| p.z *= 0.6);
    mesh
}
