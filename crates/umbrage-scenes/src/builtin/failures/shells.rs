//! Casters that enclose nothing.

use super::SMALL;
use crate::{
    primitives::{block, grid, quad},
    stage::{Stage, sun},
};
use umbrage_core::glam::{Affine3A, Mat3A, Quat, Vec3, Vec3A};
use umbrage_core::{Mesh, Scene};

/// Single quads, a box without lid and front, leaf cards on a stem, and one sheet that turns its back to the sun.
/// Methods that store the faces turned away from the light take these sheets for the far sides of something, or lose
/// them; and where one sheet stands on the floor, a midpoint lies between it and the floor.
pub(crate) fn open_shells() -> Scene {
    let upright =
        quad([(-0.5, 0.0), (0.5, 0.0), (0.5, 1.1), (-0.5, 1.1)].map(|(x, y)| Vec3::new(x, y, 0.0)));
    let place = |x: f32, z: f32, turn: f32| {
        Affine3A::from_rotation_translation(Quat::from_rotation_y(turn), Vec3::new(x, 0.0, z))
    };
    Stage::new("open-shells")
        .put(grid([4.0, 3.5], [1, 1], |_, _| 0.0))
        // One faces the sun and one doesn't: the same sheet, seen from its two sides.
        .put_many(upright, [place(-1.8, 0.2, -0.5), place(-0.6, -1.2, 2.6)])
        .put_many(open_box(), [place(0.7, -0.2, -0.3)])
        .put(cards())
        .light(sun(0.5, -1.0, -0.45))
        .shoot(
            Vec3::new(1.0, 2.9, 4.1),
            Vec3::new(0.35, 0.3, -0.1),
            46.0,
            SMALL,
        )
}

/// A box of sheets without its top and its front.
fn open_box() -> Mesh {
    let mesh = block(Vec3::new(-0.45, 0.0, -0.4), Vec3::new(0.45, 0.7, 0.4));
    let open = |t: &[u32; 3]| [Vec3::Y, Vec3::Z].contains(&mesh.normals[t[0] as usize]);
    let triangles = mesh
        .triangles
        .iter()
        .filter(|t| !open(t))
        .copied()
        .collect();
    Mesh {
        name: "open box".to_owned(),
        triangles,
        ..mesh
    }
}

/// Twelve leaves up a spiral, each one quad that hangs outwards; they grow smaller, and face now up, now down.
fn cards() -> Mesh {
    let mut cards = Mesh {
        name: "leaf cards".to_owned(),
        ..Mesh::default()
    };
    for i in 0..12_u32 {
        let t = i as f32 / 11.0;
        let out = Mat3A::from_rotation_y(2.4 * i as f32) * Vec3A::X;
        let along = (out + Vec3A::Y * (0.7 - 1.2 * t)).normalize() * (0.5 - 0.25 * t);
        let across = out.cross(Vec3A::Y) * if i % 2 == 0 { 0.13 } else { -0.13 };
        let root = Vec3A::new(2.1, 0.15 + 1.1 * t, 0.3);
        let base = cards.positions.len() as u32;
        let corners = [
            root,
            root + along * 0.5 - across,
            root + along,
            root + along * 0.5 + across,
        ];
        cards.positions.extend(corners.map(Vec3::from));
        cards
            .triangles
            .extend([[base, base + 1, base + 2], [base, base + 2, base + 3]]);
    }
    cards
}
