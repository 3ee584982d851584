//! A wood with a path: trees with geometric leaves, ferns, grass, rocks and fallen leaves. The sun
//! shines through the crowns.

use super::{
    SIZE,
    parts::scaled_placement,
    plants::{Growth, fern, litter, tree, tuft},
    random::{Random, scatter_points},
    things::rock,
};
use crate::{
    builtin::noise::fractal,
    looks::matte,
    primitives::{grid, tube},
    stage::Stage,
};
use umbrage_core::glam::{Affine3A, Quat, Vec3};
use umbrage_core::{Light, Scene};

/// Half the side of the ground, metres, and its cells.
const HALF: f32 = 70.0;
const CELLS: u32 = 260;
/// Half the width of the path, which runs from the camera along -z, metres.
const PATH: f32 = 0.9;
/// The camera's z, metres.
const EYE: f32 = 14.0;

const BARK: [f32; 3] = [0.22, 0.16, 0.11];
const LEAVES: [[f32; 3]; 4] = [
    [0.15, 0.32, 0.06],
    [0.20, 0.36, 0.08],
    [0.11, 0.26, 0.07],
    [0.34, 0.34, 0.08],
];
const SOIL: [f32; 3] = [0.29, 0.27, 0.14];
const GRASS: [f32; 3] = [0.22, 0.36, 0.09];
const FERN: [f32; 3] = [0.13, 0.33, 0.10];
const ROCK: [f32; 3] = [0.40, 0.39, 0.36];
const FALLEN: [f32; 3] = [0.46, 0.26, 0.09];

pub(crate) fn forest() -> Scene {
    lit_by("forest", 0.0)
}

pub(crate) fn forest_soft() -> Scene {
    lit_by("forest-soft", 2.0_f32.to_radians())
}

fn lit_by(name: &str, angular_diameter: f32) -> Scene {
    let eye_height = height(0.3, EYE) + 1.5;
    undergrowth(trees(ground(Stage::new(name))))
        .light(Light::Directional {
            direction: Vec3::new(0.72, -0.80, -0.28),
            angular_diameter,
        })
        .shoot(
            [0.3, eye_height, EYE],
            [-0.6, eye_height + 0.3, -6.0],
            56.0,
            SIZE,
        )
}

/// Returns the height of the ground, metres: rolling, except on the path.
fn height(x: f32, z: f32) -> f32 {
    let p = Vec3::new(x, 0.0, z);
    let off_path = ((x - bend(z)).abs() / 5.0).min(1.0);
    let rolling = 2.6 * fractal(p / 17.0, 3) * (0.25 + 0.75 * off_path);
    let bumps = 0.16 * fractal(p * 0.9, 3);
    rolling + bumps + 0.35 * off_path
}

/// Returns the x of the path's centre line.
fn bend(z: f32) -> f32 {
    3.5 * fractal(Vec3::new(0.0, 3.0, (z - EYE) / 14.0), 1) - 3.5 * fractal(3.0 * Vec3::Y, 1)
}

fn ground(stage: Stage) -> Stage {
    stage
        .put(grid([HALF, HALF], [CELLS, CELLS], height))
        .look(matte(SOIL))
}

/// Returns a placement on the ground with a random turn and scale.
fn plant_placement(x: f32, z: f32, scale: f32, random: &mut Random) -> Affine3A {
    let angle = random.signed_number(3.1);
    let foot = Vec3::new(x, height(x, z), z);
    scaled_placement(foot, angle, Vec3::splat(scale))
}

/// Returns positions next to the path, at least `clear` from its centre line: one for each cell of
/// a grid, except cells right in front of the camera.
fn places_along_path(seed: i32, half: f32, pitch: f32, clear: f32) -> Vec<[f32; 2]> {
    scatter_points(seed, half, pitch, |[x, z], _| {
        let from_eye = (x - 0.3).hypot(z - EYE);
        let is_clear = (x - bend(z)).abs() > clear && from_eye > 1.5 * clear;
        is_clear.then_some([x, z])
    })
}

/// Returns how trees grow near the path and far from it. Far trees have fewer and larger leaves.
fn growth(kind: usize, is_near: bool) -> Growth {
    let size = kind as f32;
    let near = Growth {
        seed: 40 + kind as i32,
        height: 11.0 + 1.5 * size,
        girth: 0.2 + 0.03 * size,
        reach: 3.4,
        bare: 0.3,
        branches: 22,
        leaves: 19,
        leaf: 0.33,
        has_twigs: true,
    };
    if is_near {
        return near;
    }
    Growth {
        branches: 13,
        leaves: 9,
        leaf: 0.62,
        has_twigs: false,
        ..near
    }
}

/// Adds trees of all kinds. Far kinds start at a distance from the camera.
fn trees(mut stage: Stage) -> Stage {
    const FAR: f32 = 28.0;
    let mut random = Random::new(8);
    let mut stands: [[Vec<Affine3A>; 2]; LEAVES.len()] = Default::default();
    for [x, z] in places_along_path(21, 62.0, 6.6, PATH + 1.0) {
        let kind = random.number_between(0.0, LEAVES.len() as f32 - 0.01) as usize;
        let scale = random.number_between(0.75, 1.2);
        let is_near = x.hypot(z - EYE) < FAR;
        stands[kind][usize::from(is_near)].push(plant_placement(x, z, scale, &mut random));
    }
    for (kind, stand) in stands.into_iter().enumerate() {
        for (places, is_near) in stand.into_iter().zip([false, true]) {
            let grown = tree(&growth(kind, is_near));
            stage = stage
                .put_many(grown.wood, places.clone())
                .look(matte(BARK))
                .put_many(grown.leaves, places)
                .look(matte(LEAVES[kind]));
        }
    }
    stage
}

fn undergrowth(mut stage: Stage) -> Stage {
    let mut random = Random::new(9);
    let mut tufts = [Vec::new(), Vec::new(), Vec::new()];
    for [x, z] in places_along_path(33, 20.0, 0.46, PATH) {
        // Grow grass in patches, with less of it far away.
        let patch = fractal(Vec3::new(x, 9.0, z) / 5.0, 2);
        if patch > -0.12 && random.chance(0.8) {
            let kind = random.number_between(0.0, 2.99) as usize;
            let scale = random.number_between(0.6, 1.3);
            tufts[kind].push(plant_placement(x, z, scale, &mut random));
        }
    }
    for (kind, places) in tufts.into_iter().enumerate() {
        let grass = tuft(kind as i32, 56, 0.34);
        stage = stage.put_many(grass, places).look(matte(GRASS));
    }
    let mut places = |seed: i32, pitch: f32, sizes: [f32; 2]| {
        let mut out = Vec::new();
        for [x, z] in places_along_path(seed, 18.0, pitch, PATH + 0.3) {
            let scale = random.number_between(sizes[0], sizes[1]);
            out.push(plant_placement(x, z, scale, &mut random));
        }
        out
    };
    let ferns = places(51, 2.2, [0.7, 1.6]);
    let rocks = places(52, 4.3, [0.3, 1.3]);
    let boulders = places(53, 7.0, [0.5, 2.0]);
    stage
        .put_many(fern(4, 13, 0.75), ferns)
        .look(matte(FERN))
        .put_many(rock(6, 3), rocks)
        .look(matte(ROCK))
        .put_many(rock(7, 4), boulders)
        .look(matte(ROCK))
        .put_many(litter(3, 160, 0.06), beds())
        .look(matte(FALLEN))
        .put_many(tube(&fallen_trunk(), 24), [Affine3A::IDENTITY])
        .look(matte(BARK))
}

/// Returns squares of fallen leaves along the path.
fn beds() -> Vec<Affine3A> {
    let mut out = Vec::new();
    for i in 0..9 {
        let z = EYE + 2.0 - 3.0 * i as f32;
        let x = bend(z);
        // Tilt it with the ground.
        let step = 1.5;
        let along_x = Vec3::new(2.0 * step, height(x + step, z) - height(x - step, z), 0.0);
        let along_z = Vec3::new(0.0, height(x, z + step) - height(x, z - step), 2.0 * step);
        let up = along_z.cross(along_x).normalize();
        let turn = Quat::from_rotation_arc(Vec3::Y, up);
        let foot = Vec3::new(x, height(x, z) + 0.01, z);
        out.push(Affine3A::from_rotation_translation(turn, foot));
    }
    out
}

/// Returns the axis of a trunk that has fallen next to the path.
fn fallen_trunk() -> Vec<(Vec3, f32)> {
    let mut path = Vec::new();
    for i in 0..=20 {
        let t = i as f32 / 20.0;
        let x = 1.9 + 4.2 * t;
        let z = 6.6 - 1.6 * t;
        let radius = 0.26 - 0.1 * t + 0.02 * fractal(Vec3::new(8.0 * t, 0.0, 0.0), 2);
        let rest = height(1.9, 6.6).max(height(4.0, 5.8));
        path.push((Vec3::new(x, rest + 0.2 + 0.25 * t, z), radius));
    }
    path
}
