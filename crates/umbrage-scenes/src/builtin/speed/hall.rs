//! An interior: two rows of columns with arches, outer walls with arched openings, a roof.

use super::{SIZE, area_sun};
use crate::{
    primitives::{block, grid, lathe, on_circle, prism},
    stage::{Stage, sun},
};
use umbrage_core::glam::{Affine3A, Vec3};
use umbrage_core::{Light, Mesh, Scene};

/// Bays along the hall, and their length in metres; columns stand at their ends.
const BAYS: i32 = 8;
const BAY: f32 = 4.0;
/// Half the length of the hall (along x), half the distance between the rows, and half its width
/// (along z).
const LENGTH: f32 = 0.5 * BAY * BAYS as f32;
const ROW: f32 = 3.0;
const WIDTH: f32 = 6.0;
/// Heights of the arches' feet (the springing line) and of the walls.
const SPRING: f32 = 4.2;
const HEIGHT: f32 = 7.5;

pub(crate) fn hall() -> Scene {
    lit_by("hall", sun(0.25, -0.75, 0.8))
}

pub(crate) fn hall_soft() -> Scene {
    lit_by("hall-soft", area_sun(0.25, -0.75, 0.8))
}

fn lit_by(name: &str, light: Light) -> Scene {
    let mut columns = Vec::new();
    for i in 0..=BAYS {
        let x = BAY * i as f32 - LENGTH;
        columns.push(translation(x, 0.0, -ROW));
        columns.push(translation(x, 0.0, ROW));
    }
    let mut arches = Vec::new();
    let mut walls = Vec::new();
    for i in 0..BAYS {
        let x = BAY * (i as f32 + 0.5) - LENGTH;
        arches.push(translation(x, SPRING, -ROW));
        arches.push(translation(x, SPRING, ROW));
        walls.push(translation(x, 0.0, -WIDTH));
        walls.push(translation(x, 0.0, WIDTH));
    }
    let roof = block([-LENGTH, HEIGHT, -WIDTH], [LENGTH, HEIGHT + 0.3, WIDTH]);
    let end = block([-0.3, 0.0, -WIDTH], [0.0, HEIGHT, WIDTH]);
    let ends = [
        translation(-LENGTH, 0.0, 0.0),
        translation(LENGTH + 0.3, 0.0, 0.0),
    ];
    Stage::new(name)
        .put(grid([LENGTH, WIDTH], [72, 28], |_, _| 0.0))
        .put_many(column(), columns)
        .put_many(arch(), arches)
        .put_many(outer_wall(), walls)
        .put_many(end, ends)
        .put(roof)
        .light(light)
        .shoot([-LENGTH + 1.2, 2.6, 1.1], [0.0, 2.2, -0.6], 62.0, SIZE)
}

fn translation(x: f32, y: f32, z: f32) -> Affine3A {
    Affine3A::from_translation(Vec3::new(x, y, z))
}

/// Returns a column: base, tapering shaft and capital.
fn column() -> Mesh {
    let mut profile = vec![
        (0.0, 0.0),
        (0.52, 0.0),
        (0.52, 0.18),
        (0.47, 0.2),
        (0.48, 0.3),
        (0.42, 0.36),
    ];
    profile.extend((0..=14).map(|i| {
        let t = i as f32 / 14.0;
        (0.36 - 0.06 * t * t, 0.4 + 3.2 * t)
    }));
    profile.extend([
        (0.36, 3.65),
        (0.34, 3.72),
        (0.46, 3.9),
        (0.56, 4.0),
        (0.56, SPRING),
        (0.0, SPRING),
    ]);
    Mesh {
        name: "column".to_owned(),
        ..lathe(&profile, 50)
    }
}

/// Returns a wall over one bay with a round opening, with its foot at the springing line.
fn arch() -> Mesh {
    let half = 0.5 * BAY;
    let top = HEIGHT - SPRING;
    let mut outline = vec![(half, 0.0), (half, top), (-half, top), (-half, 0.0)];
    outline.extend((0..=64).map(|i| {
        let (cos, sin) = on_circle(0.5 - f64::from(i) / 128.0);
        (1.6 * cos, 1.6 * sin)
    }));
    Mesh {
        name: "arch".to_owned(),
        ..prism(&outline, 0.3, -0.3)
    }
}

/// Returns an outer wall of one bay around an arched opening that extends down to the floor.
fn outer_wall() -> Mesh {
    let half = 0.5 * BAY;
    let mut outline = vec![
        (0.8, 0.0),
        (half, 0.0),
        (half, HEIGHT),
        (-half, HEIGHT),
        (-half, 0.0),
        (-0.8, 0.0),
    ];
    outline.extend((0..=48).map(|i| {
        let (cos, sin) = on_circle(0.5 - f64::from(i) / 96.0);
        (0.8 * cos, 4.6 + 0.8 * sin)
    }));
    Mesh {
        name: "outer wall".to_owned(),
        ..prism(&outline, 0.2, -0.2)
    }
}
