//! Tight fits of parallel light, which are boxes.

use crate::{
    geometry::{Geometry, aabb::Aabb},
    invalid::Invalid,
    light_space::{
        Extents, LightSpace,
        fit::{
            cull::{Lookups, Need, Receiving},
            input::FitInput,
            map_space::{MapBounds, MapSpace},
            points::{
                bounds_in, caster_points, caster_reach, casters_on, pad_box, receiver_points,
                rounding,
            },
            stable::first_caster,
        },
        look_along, orthographic,
    },
};
use glam::{DAffine3, DVec3, Mat4, Vec3};

/// Returns the light space whose lateral bounds are the intersection of casters and receivers. In
/// depth it begins at the first caster and ends at the last receiver. With `cull`, only casters
/// that can shadow a receiver count.
pub(super) fn tight(
    input: &FitInput<'_>,
    direction: Vec3,
    size: u32,
    margin: f32,
    cull: bool,
) -> Result<LightSpace, Invalid> {
    let view_from_world = view(input, direction, Vec3::Y)?;
    let receivers = bounds_in(&view_from_world, &receiver_points(input));
    let casters = match input.view.geometry.filter(|_| cull) {
        Some(geometry) => {
            needed_casters(input, geometry, &view_from_world, &receivers, size, margin)
        }
        None => bounds_in(&view_from_world, &caster_points(input)),
    };
    let mut b = casters.intersection(&receivers);
    // View z decreases away from the light: from the first caster (greatest z) to the last receiver
    // (least z).
    b.min.z = receivers.min.z;
    b.max.z = casters.max.z;
    if b.is_empty() {
        // Nothing can be shadowed: any space will do.
        b = Aabb {
            min: Vec3::splat(-1.0),
            max: Vec3::splat(1.0),
        };
    }
    show(view_from_world, &with_border(&b, size, margin))
}

/// Returns the light's view for tight fits, oriented so that `up` (world space) is up.
pub(super) fn view(input: &FitInput<'_>, direction: Vec3, up: Vec3) -> Result<Mat4, Invalid> {
    // Place the eye among the casters, to keep numbers small if the scene is far from the origin.
    let eye = if input.view.casters.is_empty() {
        Vec3::ZERO
    } else {
        input.view.casters.center()
    };
    look_along(eye, direction, up)
}

/// Returns the light space for a part of the receivers: those in the box `receivers` of the light's
/// view and, if visible points are known, those of `input`. `None` if no shadow can fall on them.
///
/// Other receivers may also be looked up on the map, if everything within the kernel's reach is on
/// it. So in depth the map begins at the first caster visible on it. Laterally it includes all
/// positions at which a kernel may find a caster.
pub(super) fn tight_part(
    input: &FitInput<'_>,
    view_from_world: Mat4,
    receivers: &Aabb,
    size: u32,
    margin: f32,
) -> Result<Option<LightSpace>, Invalid> {
    // Intersect the casters with the receivers.
    let casters = match input.view.geometry {
        Some(geometry) => {
            needed_casters(input, geometry, &view_from_world, receivers, size, margin)
        }
        None => bounds_in(&view_from_world, &caster_points(input)),
    };
    let b = with_depths(
        &casters.intersection(receivers),
        receivers.min.z,
        casters.max.z,
    );
    if b.is_empty() {
        return Ok(None);
    }
    // A kernel finds casters within its reach, plus one texel for their position within a texel.
    let texel = b.extent() / inner_texels(size, margin);
    let reach = texel * (margin + 2.0);
    let reached = Aabb {
        min: casters.min - reach,
        max: casters.max + reach,
    };
    let b = with_depths(&reached.intersection(receivers), b.min.z, b.max.z);
    let shown = with_border(&b, size, margin);
    // Extend the depth range to the first caster in the column.
    let space = MapSpace {
        view_from_world: DAffine3::from_mat4(view_from_world.as_dmat4()),
        nearest: None,
    };
    let column = MapBounds {
        min: shown.min.as_dvec3().with_z(-f64::from(shown.max.z)),
        max: shown.max.as_dvec3().with_z(-f64::from(shown.min.z)),
    };
    let first = first_caster(&input.view, &space, &column);
    let top = pad_box(
        Aabb::from_points([shown.max.with_z(-first as f32)]),
        caster_reach(input),
    );
    let shown = with_depths(&shown, shown.min.z, shown.max.z.max(top.max.z));
    show(view_from_world, &shown).map(Some)
}

/// Returns a space that contains no part of the scene, for maps that are never looked up.
pub(super) fn nowhere(input: &FitInput<'_>, view_from_world: Mat4) -> Result<LightSpace, Invalid> {
    let casters = bounds_in(&view_from_world, &caster_points(input));
    let receivers = bounds_in(&view_from_world, &receiver_points(input));
    let all = casters.union(&receivers);
    let adjacent = if all.is_empty() { 0.0 } else { all.max.x };
    let side = adjacent.abs().max(1.0);
    let shown = Aabb {
        min: Vec3::new(adjacent + side, -side, -side),
        max: Vec3::new(adjacent + 2.0 * side, side, side),
    };
    show(view_from_world, &shown)
}

/// Returns a box of the light's view with a border for kernels at the outermost receivers.
fn with_border(b: &Aabb, size: u32, margin: f32) -> Aabb {
    // The box covers the inner texels, so that `margin` and one more texel are left on each side.
    let texel = b.extent() / inner_texels(size, margin);
    let grow = (texel * (margin + 1.0)).max(Vec3::splat(f32::MIN_POSITIVE));
    Aabb {
        min: (b.min - grow).with_z(b.min.z),
        max: (b.max + grow).with_z(b.max.z),
    }
}

/// Returns the light space that covers a box of the light's view.
fn show(view_from_world: Mat4, b: &Aabb) -> Result<LightSpace, Invalid> {
    let extents = Extents {
        left: b.min.x,
        right: b.max.x,
        bottom: b.min.y,
        top: b.max.y,
        near: -b.max.z,
        far: -b.min.z,
    };
    Ok(LightSpace {
        view_from_world,
        clip_from_view: orthographic(extents)?,
    })
}

/// Returns a box of a light's view with another depth range: from `last` (the least z) to `first`.
fn with_depths(b: &Aabb, last: f32, first: f32) -> Aabb {
    Aabb {
        min: b.min.with_z(last),
        max: b.max.with_z(first),
    }
}

/// Returns the number of texels along a map's side that are left for receivers: all but the
/// kernel's reach and one texel on each side.
pub(super) fn inner_texels(size: u32, margin: f32) -> f32 {
    (size as f32 - 2.0 * margin - 2.0).max(1.0)
}

/// Returns the box, in the light's view, around the casters that can shadow a receiver. `receivers`
/// is the box around the receivers.
fn needed_casters(
    input: &FitInput<'_>,
    geometry: &Geometry,
    view_from_world: &Mat4,
    receivers: &Aabb,
    size: u32,
    margin: f32,
) -> Aabb {
    let space = MapSpace {
        view_from_world: DAffine3::from_mat4(view_from_world.as_dmat4()),
        nearest: None,
    };
    let last = -f64::from(receivers.min.z);
    let column = MapBounds {
        min: receivers.min.as_dvec3(),
        max: receivers.max.as_dvec3(),
    };
    let all = casters_on(&space, geometry);
    let receiving = Receiving::new(input.seen.as_ref(), geometry, &space, &column);
    // The fit is within both boxes, so its texels are no larger than those of the smaller sides.
    let greatest_side = (all.max - all.min)
        .min(column.max - column.min)
        .max(DVec3::ZERO)
        .truncate();
    let lookups = Lookups {
        texel: greatest_side / f64::from(inner_texels(size, margin)),
        margin: f64::from(margin),
        rounding: f64::from(rounding(receivers, caster_reach(input))),
        tangent: 0.0,
    };
    let need_before = |first: f64| {
        let reach = lookups.reach(input.view.light, first, last);
        Need::new(space, geometry, &receiving, &reach)
    };
    let mut first = all.min.z;
    // For an area light, the blocker search radius depends on the first caster that matters, which
    // may be farther than the first caster.
    if !input.view.light.is_ideal() {
        first = need_before(first).map_or(f64::INFINITY, |need| need.first_rank());
    }
    let found = need_before(first).map_or(MapBounds::EMPTY, |need| need.around_casters());
    if found.is_empty() {
        return Aabb::EMPTY;
    }
    // View z is minus the rank, so the greatest rank becomes the least z.
    let in_view = Aabb {
        min: found.min.with_z(-found.max.z).as_vec3(),
        max: found.max.with_z(-found.min.z).as_vec3(),
    };
    pad_box(in_view, caster_reach(input))
}
