//! Area lights over casters with different or overlapping penumbrae.

use super::SMALL;
use crate::{
    builtin::noise::uniform,
    looks::matte,
    primitives::{block, grid, lathe, on_circle, pillar, quad, tube},
    stage::Stage,
};
use umbrage_core::glam::{Affine3A, IVec3, Vec3};
use umbrage_core::{Light, Mesh, Scene};

/// The shadow of a pole close to the light crosses the shadow of a wall on the floor. Where both
/// hide the light, a blocker search finds both and returns their mean depth. The sharp edge of the
/// wall's shadow blurs under the pole.
pub(crate) fn two_blockers() -> Scene {
    let pole = tube(
        &[
            (Vec3::new(-2.4, 3.1, 0.25), 0.07),
            (Vec3::new(2.8, 3.1, -0.25), 0.07),
        ],
        24,
    );
    Stage::new("two-blockers")
        .put(grid([4.0, 4.0], [1, 1], |_, _| 0.0))
        .put(pole)
        .put(block([0.2, 0.0, -1.1], [0.3, 0.9, 1.1]))
        .light(Light::Rect {
            center: Vec3::new(-1.4, 4.6, 0.0),
            half_u: Vec3::X * 0.35,
            half_v: Vec3::Z * 0.35,
        })
        .shoot([2.9, 3.0, 3.1], [0.6, 0.15, 0.0], 42.0, SMALL)
}

/// Centre of the lights.
const LAMP: Vec3 = Vec3::new(-0.4, 5.0, 0.8);
const LAMP_HALF: f32 = 0.4;

/// A pole, whose penumbra widens along its shadow, and boxes from 5 cm to 1.5 m above the floor.
/// Each box has its own penumbra width: (receiver - blocker) / blocker times that of the light.
fn rising_scene(name: &str, light: Light) -> Scene {
    let heights = [0.05, 0.25, 0.55, 0.95, 1.5];
    let places = heights.into_iter().enumerate().map(|(i, y)| {
        let x = 0.75 * i as f32 - 1.3;
        Affine3A::from_translation(Vec3::new(x, y, 0.3))
    });
    Stage::new(name)
        .put(grid([5.0, 4.0], [1, 1], |_, _| 0.0))
        .put_many(block([-0.22, 0.0, -0.22], [0.22, 0.44, 0.22]), places)
        .put_many(
            pillar(0.06, 1.5, 24),
            [Affine3A::from_translation(Vec3::new(-1.8, 0.0, -0.4))],
        )
        .light(light)
        .shoot([0.7, 3.6, 4.8], [0.6, 0.3, -0.2], 44.0, SMALL)
}

pub(crate) fn rising_boxes() -> Scene {
    let half_u = Vec3::X * LAMP_HALF;
    let half_v = Vec3::Z * LAMP_HALF;
    rising_scene(
        "rising-boxes",
        Light::Rect {
            center: LAMP,
            half_u,
            half_v,
        },
    )
}

pub(crate) fn rising_boxes_disc() -> Scene {
    rising_scene(
        "rising-boxes-disc",
        Light::Disc {
            center: LAMP,
            normal: Vec3::NEG_Y,
            radius: LAMP_HALF,
        },
    )
}

/// A canopy of single leaves over a trunk, under an area light as wide as the canopy. The penumbrae
/// of the leaves and of the trunk have different widths. A search that returns one depth blurs all
/// of them with the same width.
pub(crate) fn canopy() -> Scene {
    Stage::new("canopy")
        .put(grid([4.0, 4.0], [1, 1], |_, _| 0.0))
        .put(trunk())
        .look(matte([0.22, 0.12, 0.06]))
        .put(leaves())
        .look(matte([0.10, 0.32, 0.07]))
        .light(Light::Disc {
            center: Vec3::new(-1.6, 6.0, 1.2),
            normal: Vec3::new(0.25, -1.0, -0.2),
            radius: 0.9,
        })
        .shoot([2.2, 2.6, 5.4], [0.2, 0.95, 0.0], 44.0, SMALL)
}

fn trunk() -> Mesh {
    let profile = [
        (0.0, 0.0),
        (0.26, 0.0),
        (0.17, 0.15),
        (0.13, 0.6),
        (0.11, 1.6),
        (0.05, 2.3),
        (0.0, 2.3),
    ];
    Mesh {
        name: "trunk".to_owned(),
        ..lathe(&profile, 24)
    }
}

const LEAVES: i32 = 260;

/// Leaves throughout a flat ball, in all directions.
fn leaves() -> Mesh {
    let mut mesh = Mesh {
        name: "leaves".to_owned(),
        ..Mesh::default()
    };
    for leaf in (0..LEAVES).map(leaf) {
        let base = mesh.positions.len() as u32;
        mesh.positions.extend(&leaf.positions);
        mesh.triangles
            .extend(leaf.triangles.iter().map(|t| t.map(|v| v + base)));
    }
    mesh
}

/// Returns a leaf at a random position in the ball, with a random turn.
fn leaf(i: i32) -> Mesh {
    let random = |what: i32| uniform(IVec3::new(i, what, 18));
    // Take the cube root, to distribute leaves uniformly over the volume of the ball.
    let in_unit_ball = unit_vector(random(0), random(1)) * random(2).cbrt();
    let middle = Vec3::new(0.0, 2.2, 0.0) + in_unit_ball * Vec3::new(1.15, 0.75, 1.15);
    let along = unit_vector(random(3), random(4)) * 0.15;
    let other = unit_vector(random(5), random(6));
    let across = along.cross(other).normalize_or(Vec3::Y) * 0.075;
    quad([
        middle - along,
        middle + across,
        middle + along,
        middle - across,
    ])
}

/// Maps two numbers, each 0 to 1, to a unit vector. Uniform numbers give uniform directions
/// (Archimedes: height is uniform on a sphere).
fn unit_vector(height: f32, turn: f32) -> Vec3 {
    let y = 2.0 * height - 1.0;
    let (cos, sin) = on_circle(f64::from(turn));
    let radius = (1.0 - y * y).max(0.0).sqrt();
    Vec3::new(radius * cos, y, radius * sin)
}
