//! Points that a fit has to contain.

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

/// World-space points, with boxes around them if they are many.
#[derive(Clone, Debug)]
pub(super) enum Points<'a> {
    /// The corners of a box.
    Corners(Aabb),
    /// The corners of a range of triangles.
    Triangles(&'a Geometry, Range<u32>),
    /// The visible points of a camera.
    Seen(&'a SeenPoints<'a>),
}

impl Points<'_> {
    /// Returns the least `value` of all points; infinity without any. `bound` must be a lower bound
    /// for all points in a box, after rounding, too.
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
            Self::Seen(seen) => seen.tree().enclosing_box(seen.entries()),
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

/// Returns the visible points if known, otherwise all receivers, otherwise the casters.
pub(super) fn receiver_points<'a>(input: &'a FitInput<'_>) -> Points<'a> {
    match (&input.seen, input.view.geometry) {
        (Some(seen), _) => Points::Seen(seen),
        (None, Some(geometry)) => Points::Triangles(geometry, geometry.receivers()),
        (None, None) => Points::Corners(input.view.casters),
    }
}

/// Returns the box around points in view space, padded so that the rounding of later lookups cannot
/// move a point outside.
pub(super) fn bounds_in(view_from_world: &Mat4, points: &Points<'_>) -> Aabb {
    let view_from_world = DAffine3::from_mat4(view_from_world.as_dmat4());
    // Find the least coordinate along an axis, times `sign`, rounded to 32 bits.
    let least = |axis: usize, sign: f64| {
        let bound = |b: &Aabb| {
            let in_view = ViewBox::padded_box(&view_from_world, b);
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
    pad_box(around, reach(&points.bounds()))
}

/// Returns a view-space box, grown by 2^-16 of its reach, and by 8 units in the last place of the
/// world coordinates (up to `world`) from which lookups start.
pub(super) fn pad_box(b: Aabb, world: f32) -> Aabb {
    let pad = rounding(&b, world);
    Aabb {
        min: b.min - pad,
        max: b.max + pad,
    }
}

/// Returns the greatest displacement of a point in view space by rounding, metres.
pub(super) fn rounding(b: &Aabb, world: f32) -> f32 {
    let reach = b.min.abs().max(b.max.abs()).max_element();
    if reach.is_finite() {
        (reach / 65_536.0).max(world / 2_097_152.0)
    } else {
        0.0
    }
}

/// Returns the greatest absolute coordinate of the casters.
pub(super) fn caster_reach(input: &FitInput<'_>) -> f32 {
    reach(&input.view.casters)
}

/// Returns the greatest absolute coordinate of the points in a box; 0 for an empty one.
fn reach(b: &Aabb) -> f32 {
    if b.is_empty() {
        0.0
    } else {
        b.min.abs().max(b.max.abs()).max_element()
    }
}

/// Returns a loose box around all casters on a map.
pub(super) fn casters_on(space: &MapSpace, geometry: &Geometry) -> MapBounds {
    let casters = geometry.casters();
    let runs = geometry.box_tree();
    least_bounds(
        |b| space.group(b),
        |bound, value| runs.least(casters.clone(), bound, |_, b| value(&space.block(b))),
    )
}

/// Returns the box, in map space, around the points of an image within a column.
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
            value(&MapBounds::from_points(inside))
        })
    })
}

/// Returns the box around the boxes of all runs. `group` returns a box around the contents of a
/// world-space box. `search(bound, value)` returns the least `value` of the runs' boxes, using the
/// `least` of their tree.
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
