//! What a fit goes around.

use crate::{
    Aabb, Geometry, View,
    light_space::fit::map_space::{MapBounds, MapSpace},
};
use glam::{Mat4, Vec3};

fn points<'a>(
    view: &'a View<'_>,
    aabb: Aabb,
    triangles: impl Fn(&Geometry) -> std::ops::Range<u32>,
) -> Box<dyn Iterator<Item = Vec3> + 'a> {
    match view.geometry {
        Some(g) => Box::new(g.vertices_of(triangles(g))),
        None => Box::new(aabb.corners()),
    }
}

pub(super) fn caster_points<'a>(view: &'a View<'_>) -> Box<dyn Iterator<Item = Vec3> + 'a> {
    points(view, view.casters, Geometry::casters)
}

/// What is seen if it is known, else all that may receive, else the casters themselves.
pub(super) fn receiver_points<'a>(view: &'a View<'_>) -> Box<dyn Iterator<Item = Vec3> + 'a> {
    match view.receivers {
        Some(r) => Box::new(r.positions()),
        None => points(view, view.casters, Geometry::receivers),
    }
}

/// Returns the box around points in view space, grown so that the rounding of later lookups cannot put a point outside.
pub(super) fn bounds_in(view_from_world: &Mat4, points: impl Iterator<Item = Vec3>) -> Aabb {
    let view_from_world = glam::DAffine3::from_mat4(view_from_world.as_dmat4());
    let mut world = 0.0_f32;
    let b = Aabb::around(points.map(|p| {
        world = world.max(p.abs().max_element());
        view_from_world.transform_point3(p.as_dvec3()).as_vec3()
    }));
    padded(b, world)
}

/// A view-space box, grown by 2^-16 of its reach, and by 8 units in the last place of the world coordinates (up to
/// `world`) that lookups start from.
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

/// Greatest coordinate of the casters.
pub(super) fn caster_reach(view: &View<'_>) -> f32 {
    if view.casters.is_empty() {
        0.0
    } else {
        view.casters
            .min
            .abs()
            .max(view.casters.max.abs())
            .max_element()
    }
}

/// A box around all casters on a map; loose.
pub(super) fn casters_on(space: &MapSpace, geometry: &Geometry) -> MapBounds {
    let blocks = geometry.chunk_bounds().of(geometry.casters());
    blocks.fold(MapBounds::EMPTY, |all, (_, b)| all.union(&space.block(&b)))
}
