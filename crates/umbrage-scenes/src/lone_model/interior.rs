//! Buildings around their own floor, seen from inside: from the place and in the direction that see
//! deepest.

use super::{ground::Ground, sun::seen_points};
use crate::framing::Shot;
use umbrage_core::glam::{UVec2, Vec3};
use umbrage_core::{Bvh, Geometry};

/// Height of the eye over the floor, as a share of the height of the building.
const EYE_HEIGHT: f32 = 0.22;
/// Full vertical angle of the picture, degrees: rooms are narrow.
const FOV_Y_DEGREES: f32 = 60.0;
/// How far the view goes down, as a share of how far it goes ahead.
const DOWN: f32 = 0.12;
/// Places of the eye that are tried: how far back from the middle and how far to the side, as
/// shares of length and width.
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
/// What is nearer than this share of the model's greatest extent is in the way.
const NEAR: f32 = 0.05;
/// How much the share of the picture that is in the way takes from a view's depth.
const NEAR_COUNTS: f32 = 2.0;
/// Level directions in which walls are looked for.
const DIRECTIONS: usize = 32;
/// Walls stand around the middle in at least this share of them: a room that is open to one side
/// has fewer.
const ENCLOSED: f32 = 0.85;
/// Surfaces that a level ray from the middle meets, in the mean. Bowls, cups and boots have two, an
/// inner and an outer one, and are seen from outside; rooms of bare walls have one, buildings with
/// pillars and galleries more.
const BOWLS: [f32; 2] = [1.4, 2.6];
/// Surfaces that are counted along a ray: more make no difference.
const MOST: usize = 6;

/// Returns a shot from inside a building around its own floor; none if the model isn't one.
pub(super) fn shot(geometry: &Geometry, ground: &Ground, size: UVec2) -> Option<Shot> {
    let bounds = geometry.bounds();
    let extent = bounds.extent();
    let floor = ground.own?;
    let height = bounds.max.y - floor;
    let middle = bounds.center().with_y(floor + EYE_HEIGHT * height);
    if !is_enclosed(geometry, middle) {
        return None;
    }
    let mut best: Option<(f32, Shot)> = None;
    for along in [Vec3::X, Vec3::NEG_X, Vec3::Z, Vec3::NEG_Z] {
        let across = Vec3::Y.cross(along);
        for [back, aside] in EYES {
            let length = along.abs().dot(extent);
            let eye =
                middle - along * (back * length) + across * (aside * across.abs().dot(extent));
            let shot = Shot {
                eye,
                target: eye + (along - Vec3::Y * DOWN) * length,
                up: Vec3::Y,
                fov_y: FOV_Y_DEGREES.to_radians(),
                size,
            };
            let depth = depth_of(geometry, &shot);
            if best.as_ref().is_none_or(|(most, _)| depth > *most) {
                best = Some((depth, shot));
            }
        }
    }
    best.map(|(_, shot)| shot)
}

/// Returns how deep a view is: the mean distance of what is seen, less where much of it is near
/// before the eye.
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

/// No triangle is passed over.
const NONE: u32 = u32::MAX;

/// Whether walls stand around a point, and not those of a bowl.
fn is_enclosed(geometry: &Geometry, middle: Vec3) -> bool {
    let reach = geometry.bounds().diagonal();
    let mut enclosed = 0;
    let mut surfaces = 0;
    for i in 0..DIRECTIONS {
        // Between the axes, along which walls and their joints lie.
        let angle = (i as f32 + 0.37) / DIRECTIONS as f32 * std::f32::consts::TAU;
        let way = Vec3::new(angle.cos(), 0.0, angle.sin()) * reach;
        let met = surfaces_along(geometry, middle, way);
        enclosed += usize::from(met > 0);
        surfaces += met;
    }
    let share = enclosed as f32 / DIRECTIONS as f32;
    let mean = surfaces as f32 / DIRECTIONS as f32;
    share >= ENCLOSED && !(BOWLS[0]..=BOWLS[1]).contains(&mean)
}

/// Returns how many surfaces the segment from `from` to `from + way` meets, [`MOST`] at most.
fn surfaces_along(geometry: &Geometry, from: Vec3, way: Vec3) -> usize {
    let bvh: &Bvh = geometry.bvh();
    let mut count = 0;
    let mut at = 0.0;
    while count < MOST {
        let rest = way * (1.0 - at);
        let Some(t) = bvh.nearest(geometry, from + way * at, rest, NONE) else {
            break;
        };
        count += 1;
        // Beyond the surface by a thousandth of the model.
        at += t * (1.0 - at) + 1e-3;
        if at >= 1.0 {
            break;
        }
    }
    count
}
