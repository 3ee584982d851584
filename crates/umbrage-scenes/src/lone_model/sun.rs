//! Directions of the sun.

use crate::framing::Shot;
use umbrage_core::glam::Vec3;
use umbrage_core::{Geometry, light_space::look_along};

/// Direction of the sun's light in view space: from the left, above and behind the model. Shadows
/// fall to the right and towards the eye, and are nearly as long as the model is high.
const IN_VIEW: Vec3 = Vec3::new(0.75, -1.0, -0.15);
/// Least ratio of scores at which another sun is preferred.
const BETTER: f32 = 1.5;
/// Candidate heights of the sun, as tangents of their angles above the horizon.
const HEIGHTS: [f32; 4] = [0.6, 1.2, 2.5, 6.0];
/// Number of candidate directions in the plane.
const AROUND: usize = 12;
/// Number of visible test points, across and down.
const GRID: [usize; 2] = [32, 18];

/// Returns the direction of the usual sun's light.
pub(super) fn from_left(shot: &Shot) -> Vec3 {
    let forward = (shot.target - shot.eye).normalize();
    let right = forward.cross(shot.up).normalize();
    let up = right.cross(forward);
    right * IN_VIEW.x + up * IN_VIEW.y - forward * IN_VIEW.z
}

/// Returns the direction of the usual sun, or of another one with a clearly greater score: the
/// product of the fractions of visible points in light and in shadow.
pub(super) fn that_shows_most(geometry: &Geometry, shot: &Shot, usual: Vec3) -> Vec3 {
    let seen = seen_points(geometry, shot);
    let usual_score = score(geometry, &seen, usual);
    let mut best = (usual_score * BETTER, usual);
    for height in HEIGHTS {
        for i in 0..AROUND {
            let angle = i as f32 / AROUND as f32 * std::f32::consts::TAU;
            let way = Vec3::new(angle.cos(), -height, angle.sin());
            let score = score(geometry, &seen, way);
            if score > best.0 {
                best = (score, way);
            }
        }
    }
    best.1
}

/// Returns visible points, slightly in front of their surfaces.
pub(super) fn seen_points(geometry: &Geometry, shot: &Shot) -> Vec<Vec3> {
    let Ok(view_from_world) = look_along(shot.eye, shot.target - shot.eye, shot.up) else {
        return Vec::new();
    };
    let world_from_view = view_from_world.inverse();
    let up = (0.5 * shot.fov_y).tan();
    let across = up * shot.size.x as f32 / shot.size.y as f32;
    let reach = shot.eye.distance(geometry.bounds().center()) + geometry.bounds().diagonal();
    let mut out = Vec::new();
    for y in 0..GRID[1] {
        for x in 0..GRID[0] {
            let place = |i: usize, of: usize| 2.0 * (i as f32 + 0.5) / of as f32 - 1.0;
            let (x, y) = (place(x, GRID[0]) * across, place(y, GRID[1]) * up);
            let way = world_from_view.transform_vector3(Vec3::new(x, y, -1.0)) * reach;
            let met = geometry.bvh().nearest(geometry, shot.eye, way, u32::MAX);
            out.extend(met.map(|t| shot.eye + way * (t * (1.0 - 1e-4))));
        }
    }
    out
}

/// Returns the product of the fractions of points in light and in shadow; 0 without points.
pub(super) fn score(geometry: &Geometry, points: &[Vec3], light: Vec3) -> f32 {
    let to_sun = -light.normalize() * geometry.bounds().diagonal();
    let lit = points
        .iter()
        .filter(|p| !geometry.bvh().is_occluded(**p, to_sun, u32::MAX))
        .count();
    let share = lit as f32 / points.len().max(1) as f32;
    share * (1.0 - share)
}
