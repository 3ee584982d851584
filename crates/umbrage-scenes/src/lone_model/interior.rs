//! Buildings around their own floor, seen from inside: from the position and in the direction with
//! the greatest depth.
//!
//! A building encloses at least half of the candidate positions that are free of solids. The centre alone
//! would not do: it may be inside a table or a pillar.

use super::{ground::Ground, sun::seen_points, twice_area};
use crate::framing::Shot;
use umbrage_core::glam::{UVec2, Vec3};
use umbrage_core::{Bvh, Geometry};

/// Height of the eye over the floor, as a fraction of the building's height.
const EYE_HEIGHT: f32 = 0.22;
/// Full vertical angle of the image, degrees. It is wide, since rooms are narrow.
const FOV_Y_DEGREES: f32 = 60.0;
/// Slope of the view: downwards, as a fraction of forwards.
const DOWN: f32 = 0.12;
/// Candidate positions of the eye: backwards and sideways from the centre, as fractions of length
/// and width.
const EYES: [[f32; 2]; 12] = [
    [0.0, 0.0],
    [0.1, 0.0],
    [0.2, 0.0],
    [0.25, 0.0],
    [0.3, 0.0],
    [0.35, 0.0],
    [0.2, 0.06],
    [0.2, -0.06],
    [0.3, 0.06],
    [0.3, -0.06],
    [0.3, 0.15],
    [0.3, -0.15],
];
/// Geometry closer than this fraction of the model's greatest extent is an obstruction.
const NEAR: f32 = 0.05;
/// Factor by which the obstructed fraction of the image reduces a view's depth.
const NEAR_COUNTS: f32 = 2.0;
/// Number of horizontal directions in which walls are searched.
const DIRECTIONS: usize = 32;
/// Least fraction of these directions with a wall. A room that is open to one side has fewer.
const ENCLOSED: f32 = 0.85;
/// Mean number of surfaces on a horizontal ray from an eye. Bowls, cups and boots have two, an
/// inner and an outer one, and are seen from outside. Rooms of bare walls have one, buildings with
/// pillars and galleries more. Furnished rooms may have as many as bowls, but the last surface of
/// a bowl faces outwards.
const BOWLS: [f32; 2] = [1.4, 2.6];
/// Number of directions over the whole sphere, from an eye.
const SPHERE: usize = 96;
/// Least fraction of these directions that meet the front of a surface first. Yards between houses
/// have less, since they have no roof, and so have points inside solids, which see backs.
const FRONTS: f32 = 0.8;
/// Greatest number of surfaces counted along a ray.
const MOST: usize = 6;

/// Returns a shot from inside a building around its own floor. `None` for other models, and if no
/// candidate position is in a room.
pub(super) fn shot(geometry: &Geometry, ground: &Ground, size: UVec2) -> Option<Shot> {
    let bounds = geometry.bounds();
    let extent = bounds.extent();
    let floor = ground.own?;
    let height = bounds.max.y - floor;
    let middle = bounds.center().with_y(floor + EYE_HEIGHT * height);
    // Collect the candidates that are free of solids.
    let mut free: Vec<(Vec3, Vec3)> = Vec::new();
    for along in [Vec3::X, Vec3::NEG_X, Vec3::Z, Vec3::NEG_Z] {
        let across = Vec3::Y.cross(along);
        for [back, aside] in EYES {
            let eye = middle - along * (back * along.abs().dot(extent))
                + across * (aside * across.abs().dot(extent));
            if is_in_room(geometry, eye) {
                free.push((eye, along));
            }
        }
    }
    let free_count = free.len();
    free.retain(|(eye, _)| is_enclosed(geometry, *eye));
    if 2 * free.len() < free_count {
        return None;
    }
    // Choose the view with the greatest depth from an enclosed eye.
    let mut best: Option<(f32, Shot)> = None;
    for (eye, along) in free {
        let shot = Shot {
            eye,
            target: eye + (along - Vec3::Y * DOWN) * along.abs().dot(extent),
            up: Vec3::Y,
            fov_y: FOV_Y_DEGREES.to_radians(),
            size,
        };
        let depth = depth_of(geometry, &shot);
        if best.as_ref().is_none_or(|(most, _)| depth > *most) {
            best = Some((depth, shot));
        }
    }
    best.map(|(_, shot)| shot)
}

/// Returns the depth of a view: the mean distance of visible points, reduced by obstructions close
/// to the eye.
fn depth_of(geometry: &Geometry, shot: &Shot) -> f32 {
    let seen = seen_points(geometry, shot);
    let near = NEAR * geometry.bounds().extent().max_element();
    let mut sum = 0.0;
    let mut in_the_way = 0;
    for point in &seen {
        let distance = point.distance(shot.eye);
        sum += distance;
        in_the_way += usize::from(distance < near);
    }
    let count = seen.len().max(1) as f32;
    let share = in_the_way as f32 / count;
    sum / count * (1.0 - NEAR_COUNTS * share)
}

/// Index that excludes no triangle from a ray query.
const NONE: u32 = u32::MAX;

/// Reports whether the fronts of surfaces surround a point.
fn is_in_room(geometry: &Geometry, eye: Vec3) -> bool {
    let reach = geometry.bounds().diagonal();
    let fronts = (0..SPHERE)
        .filter(|&i| sees_front(geometry, eye, sphere_direction(i) * reach))
        .count();
    fronts as f32 >= FRONTS * SPHERE as f32
}

/// Returns one of [`SPHERE`] evenly distributed directions: points of a Fibonacci spiral.
fn sphere_direction(i: usize) -> Vec3 {
    let y = 1.0 - 2.0 * (i as f32 + 0.5) / SPHERE as f32;
    let angle = i as f32 * std::f32::consts::PI * (3.0 - 5.0_f32.sqrt());
    let radius = (1.0 - y * y).sqrt();
    Vec3::new(radius * angle.cos(), y, radius * angle.sin())
}

/// Reports whether the first surface on the segment from `from` to `from + way` faces `from`.
fn sees_front(geometry: &Geometry, from: Vec3, way: Vec3) -> bool {
    let first = geometry.bvh().nearest_triangle(geometry, from, way, NONE);
    first.is_some_and(|(_, triangle)| faces_start(geometry, triangle, way))
}

/// Reports whether walls other than those of a bowl enclose a point.
fn is_enclosed(geometry: &Geometry, eye: Vec3) -> bool {
    let reach = geometry.bounds().diagonal();
    let mut walls = 0;
    let mut inner_walls = 0;
    let mut surfaces = 0;
    for i in 0..DIRECTIONS {
        // Avoid the axes, along which walls and their joints are aligned.
        let angle = (i as f32 + 0.37) / DIRECTIONS as f32 * std::f32::consts::TAU;
        let way = Vec3::new(angle.cos(), 0.0, angle.sin()) * reach;
        let met = surfaces_along(geometry, eye, way);
        walls += usize::from(met.count > 0);
        inner_walls += usize::from(met.ends_at_front);
        surfaces += met.count;
    }
    let are_most = |count: usize| count as f32 >= ENCLOSED * DIRECTIONS as f32;
    let mean = surfaces as f32 / DIRECTIONS as f32;
    are_most(walls) && (are_most(inner_walls) || !(BOWLS[0]..=BOWLS[1]).contains(&mean))
}

/// Surfaces on a segment.
#[derive(Clone, Copy, Debug, Default)]
struct Met {
    /// Number of surfaces, at most [`MOST`].
    count: usize,
    /// True if the last one faces the segment's start.
    ends_at_front: bool,
}

/// Returns the surfaces on the segment from `from` to `from + way`.
fn surfaces_along(geometry: &Geometry, from: Vec3, way: Vec3) -> Met {
    let bvh: &Bvh = geometry.bvh();
    let mut met = Met::default();
    let mut at = 0.0;
    while met.count < MOST {
        let rest = way * (1.0 - at);
        let Some((t, triangle)) = bvh.nearest_triangle(geometry, from + way * at, rest, NONE)
        else {
            break;
        };
        met.count += 1;
        met.ends_at_front = faces_start(geometry, triangle, way);
        // Continue beyond the surface by a thousandth of the segment.
        at += t * (1.0 - at) + 1e-3;
        if at >= 1.0 {
            break;
        }
    }
    met
}

/// Reports whether a triangle faces the start of a segment along `way`.
fn faces_start(geometry: &Geometry, triangle: u32, way: Vec3) -> bool {
    twice_area(geometry.corners(triangle)).dot(way) < 0.0
}
