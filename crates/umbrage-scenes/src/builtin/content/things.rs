//! Objects that several scenes share or that have one method of construction.

use super::{
    parts::{box_at, crease_mesh, merge_parts, stick, transform_mesh, translation},
    random::Random,
};
use crate::{
    builtin::noise::fractal,
    primitives::{icosphere, lathe, on_circle, pillar, torus},
};
use umbrage_core::Mesh;
use umbrage_core::glam::{Affine3A, Quat, Vec3};

/// Flutes around a column, and the offsets of the vertices across each.
const FLUTES: u32 = 20;
const ACROSS_FLUTE: [f32; 6] = [0.0, 0.5, 0.87, 1.0, 0.87, 0.5];
/// Depth of a flute, as a fraction of the radius.
const FLUTE_DEPTH: f32 = 0.09;
/// Distance between the links of a chain, metres.
const LINK: f32 = 0.14;

/// Returns a column with base, capital and a fluted shaft of this radius, metres.
pub(super) fn fluted_column(height: f32, radius: f32) -> Mesh {
    const SHAFT_RINGS: u32 = 12;
    let base = [
        (1.45, 0.0),
        (1.45, 0.25),
        (1.38, 0.30),
        (1.42, 0.42),
        (1.38, 0.54),
        (1.18, 0.60),
        (1.12, 0.72),
        (1.20, 0.84),
        (1.16, 0.94),
    ];
    let capital = [
        (0.92, 1.9),
        (1.02, 1.82),
        (1.02, 1.72),
        (0.90, 1.64),
        (0.94, 1.3),
        (1.10, 0.9),
        (1.30, 0.55),
        (1.38, 0.5),
        (1.38, 0.25),
        (1.46, 0.2),
        (1.46, 0.0),
    ];
    let mut profile = vec![(0.0, 0.0)];
    profile.extend(base.map(|(r, y)| (r * radius, y * radius)));
    let foot = 1.05 * radius;
    let length = height - foot - 2.0 * radius;
    profile.extend((0..=SHAFT_RINGS).map(|i| {
        let t = i as f32 / SHAFT_RINGS as f32;
        (radius * (1.0 - 0.1 * t * t), foot + length * t)
    }));
    profile.extend(capital.map(|(r, y)| (r * radius, height - y * radius)));
    profile.push((0.0, height));
    let segments = FLUTES * ACROSS_FLUTE.len() as u32;
    let mut column = lathe(&profile, segments);
    column.name = "column".to_owned();
    let first = base.len() * segments as usize;
    let count = (SHAFT_RINGS as usize + 1) * segments as usize;
    for (i, p) in column.positions[first..first + count]
        .iter_mut()
        .enumerate()
    {
        let inwards = 1.0 - FLUTE_DEPTH * ACROSS_FLUTE[i % ACROSS_FLUTE.len()];
        *p *= Vec3::new(inwards, 1.0, inwards);
    }
    column
}

/// Returns a turned post for a rail.
pub(super) fn baluster(height: f32) -> Mesh {
    let outline = [
        (0.055, 0.0),
        (0.055, 0.06),
        (0.04, 0.08),
        (0.03, 0.12),
        (0.05, 0.28),
        (0.052, 0.36),
        (0.03, 0.56),
        (0.022, 0.74),
        (0.036, 0.80),
        (0.022, 0.85),
        (0.05, 0.92),
        (0.05, 1.0),
    ];
    let mut profile = vec![(0.0, 0.0)];
    profile.extend(outline.map(|(r, y)| (r, y * height)));
    profile.push((0.0, height));
    lathe(&profile, 16)
}

/// Returns a bench that faces -z, with a slatted back.
pub(super) fn bench(width: f32) -> Mesh {
    let half = 0.5 * width;
    let mut parts = vec![
        box_at([0.0, 0.45, 0.0], [half, 0.02, 0.2]),
        box_at([0.0, 0.95, 0.24], [half, 0.04, 0.025]),
        box_at([0.0, 0.56, 0.23], [half, 0.025, 0.02]),
    ];
    for side in [-1.0, 0.0, 1.0] {
        let x = side * (half - 0.03);
        parts.push(box_at([x, 0.22, 0.0], [0.025, 0.22, 0.18]));
        parts.push(box_at([x, 0.5, 0.235], [0.025, 0.5, 0.03]));
    }
    let slats = 18;
    for i in 0..slats {
        let x = half * (2.0 * (i as f32 + 0.5) / slats as f32 - 1.0);
        parts.push(box_at([x, 0.74, 0.235], [0.025, 0.19, 0.012]));
    }
    merge_parts("bench", parts)
}

/// Returns a chain that extends upwards from the origin.
pub(super) fn chain(length: f32) -> Mesh {
    let links = (length / LINK) as u32;
    let upright = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
    let stretch = Affine3A::from_scale(Vec3::new(0.7, 1.35, 0.7));
    let link = transform_mesh(
        torus(0.06, 0.012, [10, 4]),
        stretch * Affine3A::from_quat(upright),
    );
    let quarter = Affine3A::from_rotation_y(std::f32::consts::FRAC_PI_2);
    let mut parts = Vec::new();
    for i in 0..=links {
        let up = translation(0.0, LINK * i as f32, 0.0);
        let place = if i % 2 == 0 { up } else { up * quarter };
        parts.push(transform_mesh(link.clone(), place));
    }
    merge_parts("chain", parts)
}

/// Returns a ring with a bowl below it and candles on it. Three rods from 0.5 m above hold it.
pub(super) fn oil_lamp() -> Mesh {
    const RADIUS: f32 = 0.55;
    const CANDLES: u32 = 12;
    let bowl = [
        (0.0, -0.5),
        (0.05, -0.48),
        (0.03, -0.42),
        (0.16, -0.34),
        (0.22, -0.2),
        (0.23, -0.12),
        (0.20, -0.12),
        (0.0, -0.14),
    ];
    let mut parts = vec![torus(RADIUS, 0.035, [48, 10]), lathe(&bowl, 32)];
    for i in 0..CANDLES {
        let (x, z) = on_circle(f64::from(i) / f64::from(CANDLES));
        let rim = Vec3::new(RADIUS * x, 0.0, RADIUS * z);
        parts.push(transform_mesh(
            pillar(0.02, 0.22, 10),
            Affine3A::from_translation(rim),
        ));
        if i % 4 == 0 {
            parts.push(stick(rim, 0.5 * Vec3::Y, 0.01));
            parts.push(stick(rim, [0.2 * x, -0.13, 0.2 * z], 0.01));
        }
    }
    merge_parts("lamp", parts)
}

/// Returns a rock about 1 m across, partly in the ground.
pub(super) fn rock(seed: i32, splits: u32) -> Mesh {
    let mut random = Random::new(seed);
    let place = 50.0 * random.vector();
    let shape = Vec3::new(0.6, 0.42, 0.5) + 0.12 * random.vector();
    let mut rock = icosphere(Vec3::ZERO, 1.0, splits);
    rock.normals.clear();
    rock.name = "rock".to_owned();
    for p in &mut rock.positions {
        let bulges = fractal(1.1 * *p + place, 4);
        let edges = fractal(2.6 * *p - place, 3).abs();
        *p *= shape * (0.85 + 0.7 * bulges - 0.5 * edges);
    }
    rock
}

/// Returns a street lamp with two arms along x, and a ring of ornament at its foot.
pub(super) fn street_lamp() -> Mesh {
    let outline = [
        (0.22, 0.0),
        (0.22, 0.12),
        (0.17, 0.16),
        (0.15, 0.5),
        (0.10, 0.6),
        (0.12, 0.66),
        (0.075, 0.75),
        (0.055, 3.4),
        (0.08, 3.46),
        (0.05, 3.54),
        (0.045, 4.2),
        (0.07, 4.3),
    ];
    let mut profile = vec![(0.0, 0.0)];
    profile.extend(outline);
    profile.push((0.0, 4.4));
    let mut parts = vec![lathe(&profile, 20)];
    for side in [-1.0, 1.0] {
        let end = Vec3::new(0.7 * side, 4.15, 0.0);
        parts.push(stick(4.0 * Vec3::Y, end, 0.025));
        parts.push(transform_mesh(lantern(), Affine3A::from_translation(end)));
    }
    merge_parts("street lamp", parts)
}

/// Returns a lantern that hangs below the origin.
fn lantern() -> Mesh {
    let roof = [
        (0.0, -0.12),
        (0.17, -0.12),
        (0.18, -0.1),
        (0.05, 0.02),
        (0.0, 0.03),
    ];
    let glass = [
        (0.0, -0.5),
        (0.07, -0.5),
        (0.08, -0.47),
        (0.13, -0.12),
        (0.0, -0.12),
    ];
    let solids = [lathe(&roof, 6), lathe(&glass, 6)];
    merge_parts("lantern", solids.map(|solid| crease_mesh(&solid)))
}
