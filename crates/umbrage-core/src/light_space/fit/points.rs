//! What a fit goes around.

use crate::{
    gbuffer::seen_points::SeenPoints,
    geometry::{Geometry, aabb::Aabb},
    light_space::{
        fit::{
            input::FitInput,
            map_space::{MapBounds, MapSpace},
        },
        view_box::ViewBox,
    },
};
use glam::{DAffine3, DVec3, Mat4, Vec3};
use std::ops::Range;

/// Points of the world, with boxes around them where they are many.
#[derive(Clone, Debug)]
pub(super) enum Points<'a> {
    /// The corners of a box.
    Corners(Aabb),
    /// The corners of a range of triangles.
    Triangles(&'a Geometry, Range<u32>),
    /// What a camera sees.
    Seen(&'a SeenPoints<'a>),
}

impl Points<'_> {
    /// Returns the least `value` of all points; infinity without any. No point in a box may have
    /// less than the `bound` of the box, which is that of rounded values, too.
    pub(super) fn least(&self, bound: impl Fn(&Aabb) -> f64, value: impl Fn(Vec3) -> f64) -> f64 {
        match self {
            Self::Corners(b) => least_of(b.corners(), value),
            Self::Triangles(geometry, triangles) => {
                let tree = geometry.box_tree();
                tree.least(triangles.clone(), bound, |run, _| {
                    tree.count(&run);
                    least_of(geometry.vertices_of(run), &value)
                })
            }
            Self::Seen(seen) => seen.tree().least(seen.entries(), bound, |tile, _| {
                least_of(seen.points_in(&tile), &value)
            }),
        }
    }

    /// Returns the box around all points, world space.
    pub(super) fn bounds(&self) -> Aabb {
        match self {
            Self::Corners(b) if b.is_empty() => Aabb::EMPTY,
            Self::Corners(b) => *b,
            Self::Triangles(geometry, triangles) => geometry.bounds_of(triangles.clone()),
            Self::Seen(seen) => seen.tree().around(seen.entries()),
        }
    }
}

fn least_of(points: impl Iterator<Item = Vec3>, value: impl Fn(Vec3) -> f64) -> f64 {
    points.map(value).fold(f64::INFINITY, f64::min)
}

pub(super) fn caster_points<'a>(input: &FitInput<'a>) -> Points<'a> {
    match input.view.geometry {
        Some(geometry) => Points::Triangles(geometry, geometry.casters()),
        None => Points::Corners(input.view.casters),
    }
}

/// What is seen if it is known, else all that may receive, else the casters themselves.
pub(super) fn receiver_points<'a>(input: &'a FitInput<'_>) -> Points<'a> {
    match (&input.seen, input.view.geometry) {
        (Some(seen), _) => Points::Seen(seen),
        (None, Some(geometry)) => Points::Triangles(geometry, geometry.receivers()),
        (None, None) => Points::Corners(input.view.casters),
    }
}

/// Returns the box around points in view space, grown so that the rounding of later lookups cannot
/// put a point outside.
pub(super) fn bounds_in(view_from_world: &Mat4, points: &Points<'_>) -> Aabb {
    let view_from_world = DAffine3::from_mat4(view_from_world.as_dmat4());
    // Of the coordinate along an axis, the least times `sign`, rounded to 32 bits.
    let least = |axis: usize, sign: f64| {
        let bound = |b: &Aabb| {
            let in_view = ViewBox::padded(&view_from_world, b);
            sign * in_view.center[axis] - in_view.half[axis]
        };
        let value = |p: Vec3| {
            let in_view = view_from_world.transform_point3(p.as_dvec3()).as_vec3();
            sign * f64::from(in_view[axis])
        };
        points.least(bound, value) as f32
    };
    let around = Aabb {
        min: Vec3::new(least(0, 1.0), least(1, 1.0), least(2, 1.0)),
        max: -Vec3::new(least(0, -1.0), least(1, -1.0), least(2, -1.0)),
    };
    padded(around, reach(&points.bounds()))
}

/// A view-space box, grown by 2^-16 of its reach, and by 8 units in the last place of the world
/// coordinates (up to `world`) that lookups start from.
pub(super) fn padded(b: Aabb, world: f32) -> Aabb {
    let pad = rounding(&b, world);
    Aabb {
        min: b.min - pad,
        max: b.max + pad,
    }
}

/// How far rounding may move a point in view space, metres.
pub(super) fn rounding(b: &Aabb, world: f32) -> f32 {
    let reach = b.min.abs().max(b.max.abs()).max_element();
    if reach.is_finite() {
        (reach / 65_536.0).max(world / 2_097_152.0)
    } else {
        0.0
    }
}

/// Returns the greatest coordinate of the casters.
pub(super) fn caster_reach(input: &FitInput<'_>) -> f32 {
    reach(&input.view.casters)
}

/// Returns the greatest coordinate, without its sign, of the points in a box; 0 for an empty one.
fn reach(b: &Aabb) -> f32 {
    if b.is_empty() {
        0.0
    } else {
        b.min.abs().max(b.max.abs()).max_element()
    }
}

/// A box around all casters on a map; loose.
pub(super) fn casters_on(space: &MapSpace, geometry: &Geometry) -> MapBounds {
    let casters = geometry.casters();
    let runs = geometry.box_tree();
    least_bounds(
        |b| space.group(b),
        |bound, value| runs.least(casters.clone(), bound, |_, b| value(&space.block(b))),
    )
}

/// Returns the box, in map space, around those points of an image that lie within a column.
pub(super) fn seen_on(space: &MapSpace, seen: &SeenPoints<'_>, column: &MapBounds) -> MapBounds {
    let group = |b: &Aabb| {
        let group = space.group(b);
        if group.meets(column) {
            group
        } else {
            MapBounds::EMPTY
        }
    };
    let tiles = seen.tree();
    least_bounds(group, |bound, value| {
        tiles.least(seen.entries(), bound, |tile, _| {
            let points = seen.points_in(&tile);
            let inside = points.filter_map(|p| space.point_within(p, column));
            value(&MapBounds::around(inside))
        })
    })
}

/// Returns the box around the boxes of all runs: `group` returns a box around all that a box of the
/// world may hold, and `search(bound, value)` the least `value` of the runs' boxes, by the `least`
/// of their tree.
fn least_bounds(
    group: impl Fn(&Aabb) -> MapBounds,
    search: impl Fn(&dyn Fn(&Aabb) -> f64, &dyn Fn(&MapBounds) -> f64) -> f64,
) -> MapBounds {
    let least = |axis: usize| search(&|b| group(b).min[axis], &|b| b.min[axis]);
    let greatest = |axis: usize| -search(&|b| -group(b).max[axis], &|b| -b.max[axis]);
    MapBounds {
        min: DVec3::new(least(0), least(1), least(2)),
        max: DVec3::new(greatest(0), greatest(1), greatest(2)),
    }
}
