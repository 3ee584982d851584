//! Open casters.

use super::SMALL;
use crate::{
    primitives::{block, grid, quad},
    stage::{Stage, sun},
};
use umbrage_core::glam::{Affine3A, Mat3A, Quat, Vec3, Vec3A};
use umbrage_core::{Mesh, Scene};

/// Single quads, a box without lid and front, leaf cards on a stem, and one sheet that faces away
/// from the sun. Methods that store back faces treat these sheets as the far sides of solids, or
/// lose them. Where a sheet touches the floor, a midpoint is between the sheet and the floor.
pub(crate) fn open_shells() -> Scene {
    let upright = quad([
        Vec3::new(-0.5, 0.0, 0.0),
        Vec3::new(0.5, 0.0, 0.0),
        Vec3::new(0.5, 1.1, 0.0),
        Vec3::new(-0.5, 1.1, 0.0),
    ]);
    let towards_sun = turned_at(-1.8, 0.2, -0.5);
    let away_from_sun = turned_at(-0.6, -1.2, 2.6);
    Stage::new("open-shells")
        .put(grid([4.0, 3.5], [1, 1], |_, _| 0.0))
        // Show the same sheet from its two sides.
        .put_many(upright, [towards_sun, away_from_sun])
        .put_many(open_box(), [turned_at(0.7, -0.2, -0.3)])
        .put(cards())
        .light(sun(0.5, -1.0, -0.45))
        .shoot([1.0, 2.9, 4.1], [0.35, 0.3, -0.1], 46.0, SMALL)
}

/// Returns a placement on the floor, turned about y by `turn` radians.
fn turned_at(x: f32, z: f32, turn: f32) -> Affine3A {
    Affine3A::from_rotation_translation(Quat::from_rotation_y(turn), Vec3::new(x, 0.0, z))
}

/// Returns a box of sheets without its top and its front.
fn open_box() -> Mesh {
    let mut mesh = block([-0.45, 0.0, -0.4], [0.45, 0.7, 0.4]);
    mesh.name = "open box".to_owned();
    mesh.triangles.retain(|triangle| {
        let normal = mesh.normals[triangle[0] as usize];
        normal != Vec3::Y && normal != Vec3::Z
    });
    mesh
}

/// Returns twelve leaves up a spiral, each an outward quad. They become smaller, and alternately
/// face up and down.
fn cards() -> Mesh {
    let mut cards = Mesh {
        name: "leaf cards".to_owned(),
        ..Mesh::default()
    };
    for i in 0..12_u32 {
        // 0 at the lowest leaf, 1 at the highest.
        let height = i as f32 / 11.0;
        let out = Mat3A::from_rotation_y(2.4 * i as f32) * Vec3A::X;
        let direction = (out + Vec3A::Y * (0.7 - 1.2 * height)).normalize();
        let along = direction * (0.5 - 0.25 * height);
        let half_width = if i % 2 == 0 { 0.13 } else { -0.13 };
        let across = out.cross(Vec3A::Y) * half_width;
        let root = Vec3A::new(2.1, 0.15 + 1.1 * height, 0.3);
        let base = cards.positions.len() as u32;
        let corners = [
            root,
            root + along * 0.5 - across,
            root + along,
            root + along * 0.5 + across,
        ];
        cards.positions.extend(corners.map(Vec3::from));
        cards.triangles.push([base, base + 1, base + 2]);
        cards.triangles.push([base, base + 2, base + 3]);
    }
    cards
}
