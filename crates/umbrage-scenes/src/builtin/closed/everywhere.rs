//! c7 to c9: all dark, or all lit. Every difference is a leak or acne.

use super::{SIZE, exact, floor};
use crate::{
    ClosedForm, Sample,
    primitives::{block, icosphere},
    stage::{Stage, sun},
};
use umbrage_core::glam::Vec3;
use umbrage_core::{Mesh, Scene};

const ROOM: [Vec3; 2] = [Vec3::new(-2.0, 0.0, -2.0), Vec3::new(2.0, 3.0, 2.0)];

pub(crate) fn closed_room() -> Scene {
    Stage::new("c7-closed-room")
        .put(Mesh {
            name: "room".to_owned(),
            ..block(ROOM[0], ROOM[1])
        })
        .light(sun(1.0, -2.0, 0.5))
        .shoot([1.7, 1.5, 1.7], [-0.6, 1.4, -0.6], 75.0, SIZE)
}

/// Walls without thickness and the sun outside: every inner point more than a thousandth from the
/// corners is dark.
pub(crate) fn closed_room_samples() -> ClosedForm {
    const STEPS: i32 = 24;
    let [min, max] = ROOM.map(|v| v + (Vec3::new(0.0, 1.5, 0.0) - v).signum() * 1e-3);
    let mut samples = Vec::new();
    for axis in 0..3 {
        for (wall, inward) in [(ROOM[0], 1.0), (ROOM[1], -1.0)] {
            // Sample a grid over the wall.
            for i in 0..=STEPS {
                for k in 0..=STEPS {
                    let mut t = Vec3::ZERO;
                    t[(axis + 1) % 3] = i as f32 / STEPS as f32;
                    t[(axis + 2) % 3] = k as f32 / STEPS as f32;
                    let mut point = min + (max - min) * t;
                    point[axis] = wall[axis];
                    samples.push(Sample {
                        point,
                        normal: Vec3::AXES[axis] * inward,
                        visibility: 0.0,
                        weighted: None,
                    });
                }
            }
        }
    }
    ClosedForm {
        samples,
        tolerance: 0.0,
    }
}

/// Direction of c8's light.
const TOWARDS: Vec3 = Vec3::new(1.0, -2.0, 0.5);

fn faceted_mesh() -> Mesh {
    // Give each facet its own vertices, for faceted shading.
    let smooth = icosphere([0.0, 1.0, 0.0], 1.0, 2);
    let positions: Vec<Vec3> = smooth
        .triangles
        .iter()
        .flatten()
        .map(|&v| smooth.positions[v as usize])
        .collect();
    let triangles = (0..positions.len() as u32 / 3)
        .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
        .collect();
    Mesh {
        name: "sphere".to_owned(),
        positions,
        triangles,
        ..Mesh::default()
    }
}

pub(crate) fn faceted_sphere() -> Scene {
    Stage::new("c8-faceted-sphere")
        .put(faceted_mesh())
        .light(sun(TOWARDS.x, TOWARDS.y, TOWARDS.z))
        .shoot([1.5, 2.4, 4.2], [0.0, 1.0, 0.0], 34.0, SIZE)
}

/// The sphere is convex and the only object, so a facet is lit if and only if it faces the light.
/// Each of the 320 facets has four samples, seen from outside: one at its centre and three near its
/// corners.
pub(crate) fn faceted_sphere_samples() -> ClosedForm {
    let mesh = faceted_mesh();
    let samples = mesh.triangles.iter().flat_map(|t| {
        let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
        let normal = (b - a).cross(c - a).normalize();
        let visibility = if normal.dot(-TOWARDS) > 0.0 { 1.0 } else { 0.0 };
        let near = |p: Vec3, q: Vec3, r: Vec3| p * 0.98 + (q + r) * 0.01;
        let middle = (a + b + c) / 3.0;
        [middle, near(a, b, c), near(b, c, a), near(c, a, b)].map(|point| Sample {
            point,
            normal,
            visibility,
            weighted: None,
        })
    });
    ClosedForm {
        samples: samples.collect(),
        tolerance: 0.0,
    }
}

pub(crate) fn bare_floor() -> Scene {
    let height = 0.5_f64.to_radians();
    Stage::new("c9-bare-floor")
        .put(floor(10.0))
        .light(sun(height.cos() as f32, -height.sin() as f32, 0.0))
        .shoot([0.0, 12.0, 19.0], [0.0, 0.0, -1.0], 60.0, SIZE)
}

/// A bare floor with the sun at half a degree: everything is lit.
pub(crate) fn bare_floor_samples() -> ClosedForm {
    let mut points = Vec::new();
    for i in -25..=25 {
        for k in -25..=25 {
            points.push((i as f32 * 0.39, k as f32 * 0.39, 1.0));
        }
    }
    exact(&points)
}
