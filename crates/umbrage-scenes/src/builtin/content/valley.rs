//! A valley of more than 2 km: hills, a line of poles with wires, a fence, huts, firs, rocks,
//! grass. The sun is low.

use super::{
    SIZE,
    parts::{
        box_at, crease_mesh, merge_parts, scaled_placement, stick, transform_mesh, translation,
        turned_placement, wire,
    },
    plants::{fir, tuft},
    random::Random,
    things::rock,
};
use crate::{
    builtin::noise::fractal,
    looks::matte,
    primitives::{block, grid, lathe, prism},
    stage::Stage,
};
use umbrage_core::glam::{Affine3A, Vec3};
use umbrage_core::{Light, Mesh, Scene};

/// Half the width of the land, and its ends along z, metres. The camera is near z = 0.
const HALF: f32 = 1100.0;
const NEAR: f32 = 160.0;
const FAR: f32 = -2400.0;
/// Cells along x and along z. The smallest are at the camera.
const CELLS: [u32; 2] = [640, 720];
/// Fraction of the cells that are as small as those at the camera.
const EVENNESS: f32 = 0.12;

const MEADOW: [f32; 3] = [0.34, 0.35, 0.15];
const FIR: [f32; 3] = [0.08, 0.17, 0.08];
const WOOD: [f32; 3] = [0.27, 0.20, 0.14];
const PLANKS: [f32; 3] = [0.42, 0.24, 0.13];
const ROOF: [f32; 3] = [0.30, 0.13, 0.10];
const ROCK: [f32; 3] = [0.45, 0.43, 0.40];
const GRASS: [f32; 3] = [0.40, 0.40, 0.14];
const WIRE: [f32; 3] = [0.08, 0.08, 0.09];

/// Tops of the poles, which hold the wires: x, and height above the foot, metres.
const INSULATORS: [[f32; 2]; 3] = [[-0.9, 8.1], [0.9, 8.1], [0.0, 8.9]];

pub(crate) fn valley() -> Scene {
    lit_by("valley", 0.0)
}

pub(crate) fn valley_soft() -> Scene {
    lit_by("valley-soft", 3.0_f32.to_radians())
}

fn lit_by(name: &str, angular_diameter: f32) -> Scene {
    let eye = on_ground(0.0, 0.0) + 3.2 * Vec3::Y;
    let stage = land(Stage::new(name));
    let stage = grow_plants(stones(huts(fence(poles(stage)))));
    stage
        .light(Light::Directional {
            direction: Vec3::new(0.80, -0.31, 0.22),
            angular_diameter,
        })
        .shoot(eye, eye + Vec3::new(-2.6, -2.9, -20.0), 50.0, SIZE)
}

/// Returns the x of the valley's lowest line.
fn bottom(z: f32) -> f32 {
    -30.0 + 190.0 * fractal(Vec3::new(0.0, 0.0, z / 700.0), 2)
}

/// Returns the height of the land, metres.
fn height(x: f32, z: f32) -> f32 {
    let p = Vec3::new(x, 0.0, z);
    let aside = ((x - bottom(z)).abs() / 420.0).min(2.2);
    let slope = 95.0 * aside * aside / (0.6 + aside);
    let hills = 85.0 * fractal(p / 310.0, 5) * (0.10 + aside);
    let knolls = 3.5 * fractal(p / 38.0, 3);
    let clods = 0.10 * fractal(p / 1.7, 2);
    // Let the land fall from the camera towards the valley.
    let ahead = (-z / 240.0).max(0.0);
    let drop = 78.0 * ahead / (1.0 + ahead);
    let away = (-0.001 * z).max(0.0);
    slope + hills + knolls + clods - drop - 14.0 * away + 26.0 * away * away
}

fn on_ground(x: f32, z: f32) -> Vec3 {
    Vec3::new(x, height(x, z), z)
}

fn land(stage: Stage) -> Stage {
    // Space -1 to 1 more finely near 0.
    let finer = |t: f32| t * (EVENNESS + (1.0 - EVENNESS) * t.abs());
    let mut land = grid([1.0, 1.0], CELLS, |_, _| 0.0);
    for p in &mut land.positions {
        let z = 0.5 * (1.0 - p.z);
        *p = on_ground(HALF * finer(p.x), NEAR + (FAR - NEAR) * split(z));
    }
    land.uvs.clear();
    stage.put(land).look(matte(MEADOW))
}

/// Maps a fraction of the cells along z to a fraction of the land's length. One tenth of the cells
/// is behind the camera.
fn split(t: f32) -> f32 {
    const BEHIND: f32 = 0.1;
    let camera = NEAR / (NEAR - FAR);
    if t < BEHIND {
        let back = 1.0 - t / BEHIND;
        return camera * (1.0 - back * (0.3 + 0.7 * back));
    }
    let ahead = (t - BEHIND) / (1.0 - BEHIND);
    camera + (1.0 - camera) * ahead * (0.04 + 0.96 * ahead)
}

/// Returns the foot of a pole of the line that runs along the valley.
fn pole_foot(i: i32) -> Vec3 {
    let z = 22.0 - 48.0 * i as f32;
    on_ground(0.02 * z - 8.5, z)
}

fn poles(stage: Stage) -> Stage {
    const COUNT: i32 = 44;
    let feet: Vec<Vec3> = (0..COUNT).map(pole_foot).collect();
    let mut wires = Vec::new();
    for ends in feet.windows(2) {
        for [x, y] in INSULATORS {
            let top = Vec3::new(x, y, 0.0);
            wires.push(wire(ends[0] + top, ends[1] + top, 0.9, 0.014));
        }
    }
    let places = feet.iter().map(|foot| turned_placement(*foot, 0.0));
    stage
        .put_many(pole(), places)
        .look(matte(WOOD))
        .put(merge_parts("wires", wires))
        .look(matte(WIRE))
}

/// Returns a pole of 9 m with a crossarm and insulators.
fn pole() -> Mesh {
    let outline = [
        (0.0, -0.6),
        (0.17, -0.6),
        (0.16, 1.0),
        (0.11, 8.6),
        (0.0, 8.65),
    ];
    let cup = [
        (0.0, 0.0),
        (0.03, 0.0),
        (0.07, 0.06),
        (0.04, 0.1),
        (0.06, 0.14),
        (0.03, 0.2),
        (0.0, 0.2),
    ];
    let mut parts = vec![
        lathe(&outline, 16),
        box_at(7.9 * Vec3::Y, [1.1, 0.07, 0.06]),
        stick([-0.7, 7.9, 0.0], 7.1 * Vec3::Y, 0.03),
        stick([0.7, 7.9, 0.0], 7.1 * Vec3::Y, 0.03),
    ];
    for [x, y] in INSULATORS {
        parts.push(transform_mesh(
            lathe(&cup, 12),
            translation(x, y - 0.16, 0.0),
        ));
    }
    merge_parts("pole", parts)
}

/// Returns the x of the fence, which leads from the camera to the huts.
fn fence_x(z: f32) -> f32 {
    -5.5 + 0.10 * z + 3.0 * fractal(Vec3::new(5.0, 0.0, z / 30.0), 2)
}

fn fence(stage: Stage) -> Stage {
    const COUNT: i32 = 90;
    let mut random = Random::new(14);
    let mut posts = Vec::new();
    let mut lines = Vec::new();
    let foot = |i: i32| {
        let z = 2.0 - 2.4 * i as f32;
        on_ground(fence_x(z), z)
    };
    for i in 0..COUNT {
        let scale = Vec3::new(1.0, random.number_between(0.9, 1.1), 1.0);
        posts.push(scaled_placement(foot(i), random.signed_number(0.3), scale));
        for y in [0.35, 0.7, 1.05] {
            let up = y * Vec3::Y;
            lines.push(wire(foot(i) + up, foot(i + 1) + up, 0.03, 0.006));
        }
    }
    let post = block([-0.06, -0.4, -0.05], [0.06, 1.2, 0.05]);
    stage
        .put_many(post, posts)
        .look(matte(WOOD))
        .put(merge_parts("fence", lines))
        .look(matte(WIRE))
}

/// Positions and turns of the huts: x and z in metres, angle in radians.
const HUTS: [[f32; 3]; 9] = [
    [-20.0, -42.0, 0.5],
    [-33.0, -58.0, 1.2],
    [14.0, -95.0, -0.4],
    [-44.0, -120.0, 0.2],
    [-70.0, -170.0, 0.9],
    [40.0, -230.0, -0.7],
    [-95.0, -330.0, 0.4],
    [60.0, -480.0, 1.4],
    [-60.0, -620.0, 0.1],
];

fn huts(stage: Stage) -> Stage {
    let places = HUTS.map(|hut| turned_placement(on_ground(hut[0], hut[1]), hut[2]));
    stage
        .put_many(hut_walls(), places)
        .look(matte(PLANKS))
        .put_many(hut_roof(), places)
        .look(matte(ROOF))
        .put_many(hut_stone(), places)
        .look(matte(ROCK))
}

/// Returns walls of upright planks under a gable, with a porch.
fn hut_walls() -> Mesh {
    let gable = [(-2.6, 0.0), (2.6, 0.0), (2.6, 2.4), (0.0, 4.4), (-2.6, 2.4)];
    let mut parts = vec![crease_mesh(&prism(&gable, 3.2, -3.2))];
    for i in 0..32 {
        let z = -3.1 + 0.2 * i as f32;
        for side in [-1.0, 1.0] {
            let x = 2.62 * side;
            parts.push(box_at([x, 1.2, z], [0.03, 1.2, 0.03]));
        }
    }
    for x in [-2.4, -0.8, 0.8, 2.4] {
        parts.push(stick([x, 0.0, 4.6], [x, 2.35, 4.6], 0.07));
    }
    for i in 0..24 {
        let x = -2.4 + 4.8 * i as f32 / 23.0;
        let foot = Vec3::new(x, 0.1, 4.6);
        if x.abs() > 0.8 {
            parts.push(stick(foot, foot + 0.8 * Vec3::Y, 0.02));
        }
    }
    merge_parts("hut walls", parts)
}

/// Returns two slopes with eaves, battens on them, and the porch's roof.
fn hut_roof() -> Mesh {
    let mut parts = Vec::new();
    let slope = (4.4_f32 - 2.4).atan2(2.6);
    for side in [-1.0, 1.0] {
        let tilt = Affine3A::from_rotation_z(-side * slope);
        let place = translation(side * 1.5, 3.35, 0.0) * tilt;
        let slab = box_at(Vec3::ZERO, [2.0, 0.06, 3.7]);
        parts.push(transform_mesh(slab, place));
        for i in 0..10 {
            let x = 1.9 * (2.0 * i as f32 / 9.0 - 1.0);
            let batten = box_at([x, 0.08, 0.0], [0.04, 0.03, 3.72]);
            parts.push(transform_mesh(batten, place));
        }
    }
    let porch = box_at(Vec3::ZERO, [2.8, 0.05, 0.9]);
    parts.push(transform_mesh(
        porch,
        translation(0.0, 2.45, 4.0) * Affine3A::from_rotation_x(0.18),
    ));
    merge_parts("hut roof", parts)
}

/// Returns the base, which reaches into the ground, and the chimney.
fn hut_stone() -> Mesh {
    let base = block([-2.8, -2.5, -3.4], [2.8, 0.1, 4.8]);
    let chimney = block([0.9, 3.0, -1.6], [1.5, 5.2, -1.0]);
    let crown = block([0.85, 5.2, -1.65], [1.55, 5.32, -0.95]);
    merge_parts("hut stone", [base, chimney, crown])
}

/// Reports whether a position is free: away from the camera, the fence and the huts.
fn is_free(x: f32, z: f32) -> bool {
    let from_huts = |hut: &[f32; 3]| (x - hut[0]).hypot(z - hut[1]) > 8.0;
    let from_fence = (x - fence_x(z)).abs() > 0.7;
    x.hypot(z) > 3.0 && from_fence && HUTS.iter().all(from_huts)
}

/// Returns up to `count` free positions. Most are near the camera, and none is farther than `reach`
/// along z.
fn strewn_places(seed: i32, count: u32, reach: f32) -> Vec<[f32; 2]> {
    let mut random = Random::new(seed);
    let mut out = Vec::new();
    for _ in 0..count {
        let near = random.unit();
        let z = 6.0 - reach * near * near;
        let x = random.signed_number(12.0 - 0.75 * z);
        if is_free(x, z) && x.abs() < HALF && z > FAR {
            out.push([x, z]);
        }
    }
    out
}

fn stones(mut stage: Stage) -> Stage {
    let mut random = Random::new(61);
    for kind in 0..4 {
        let mut places = Vec::new();
        for [x, z] in strewn_places(70 + kind, 130, 320.0) {
            let size = 0.15 + 2.2 * random.unit().powi(4);
            let grows = 1.0 - 0.01 * z;
            let angle = random.signed_number(3.1);
            places.push(scaled_placement(
                on_ground(x, z),
                angle,
                Vec3::splat(size * grows.min(3.0)),
            ));
        }
        stage = stage.put_many(rock(kind, 2), places).look(matte(ROCK));
    }
    stage
}

fn grow_plants(mut stage: Stage) -> Stage {
    let mut random = Random::new(62);
    for kind in 0..3 {
        let mut firs = Vec::new();
        for [x, z] in strewn_places(80 + kind, 420, 1900.0) {
            // Group them, away from the camera.
            let grove = fractal(Vec3::new(x, 4.0, z) / 90.0, 2);
            if z < -30.0 && grove > 0.02 {
                let tall = random.number_between(5.0, 15.0);
                let angle = random.signed_number(3.1);
                firs.push(scaled_placement(on_ground(x, z), angle, Vec3::splat(tall)));
            }
        }
        stage = stage.put_many(fir(kind), firs).look(matte(FIR));
        let mut tufts = Vec::new();
        for [x, z] in strewn_places(90 + kind, 1300, 40.0) {
            let angle = random.signed_number(3.1);
            let scale = random.number_between(0.6, 1.4);
            tufts.push(scaled_placement(on_ground(x, z), angle, Vec3::splat(scale)));
        }
        stage = stage
            .put_many(tuft(10 + kind, 26, 0.42), tufts)
            .look(matte(GRASS));
    }
    stage
}
