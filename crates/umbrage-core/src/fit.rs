//! Fitting light spaces: where a shadow map's texels go.

use crate::{
    Aabb, Invalid, Light, PlanError, View,
    light_space::{Extents, LightSpace, look_along, orthographic, perspective},
};
use glam::{Mat4, Vec3};

/// How a single light space is laid around a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Fit {
    /// As tight as it goes without changing any shadow: sideways around what both casts and is seen to receive, in
    /// depth from the first caster to the last seen receiver.
    #[default]
    Tight,
    /// Textbook style: from `eye` along the light, with explicit extents. Perspective lights use `near` and `far` alone.
    Manual {
        /// Where depth is counted from, world space. Lights with a position use theirs instead.
        eye: Vec3,
        /// The volume, in the light's view space.
        extents: Extents,
    },
}

/// Widest half angle, degrees, of the cone that one perspective map may have to cover.
const WIDEST_HALF_ANGLE: f32 = 75.0;
/// Nearest plane of a perspective fit, as a fraction of its far plane: 2^-20, where 32-bit depth is still good.
const NEAREST: f32 = 1.0 / 1_048_576.0;

impl Fit {
    /// One light space for the view. `size` is the map's side in texels; `margin` is how far, in texels, a kernel
    /// reaches beyond the texel that a receiver falls on.
    ///
    /// # Errors
    /// `Unsupported` when casters surround the light, so that no single map can see them all; `Invalid` for bad input.
    pub fn light_space(&self, view: &View<'_>, size: u32, margin: f32) -> Result<LightSpace, PlanError> {
        match (self, *view.light) {
            (Self::Tight, Light::Directional { direction, .. }) => {
                Ok(tight_orthographic(view, direction, size, margin)?)
            }
            (Self::Manual { eye, extents }, Light::Directional { direction, .. }) => Ok(LightSpace {
                view_from_world: look_along(*eye, direction, Vec3::Y)?,
                clip_from_view: orthographic(*extents)?,
            }),
            (_, light) => self.perspective(view, &light, size, margin),
        }
    }

    fn perspective(&self, view: &View<'_>, light: &Light, size: u32, margin: f32) -> Result<LightSpace, PlanError> {
        let eye = light.position().unwrap_or_default();
        let (axis, half_angle) = match *light {
            Light::Spot { direction, outer, .. } => (direction, outer),
            _ => cone_around_casters(view, eye)?,
        };
        if half_angle.to_degrees() > WIDEST_HALF_ANGLE {
            return Err(PlanError::unsupported(format!(
                "the light needs a cone of {:.0} degrees to reach all casters, and one map covers at most {:.0}: \
                 use a technique with a cube of maps",
                2.0 * half_angle.to_degrees(),
                2.0 * WIDEST_HALF_ANGLE
            )));
        }
        let view_from_world = look_along(eye, axis, Vec3::Y)?;
        let [near, far] = match self {
            Self::Manual { extents, .. } => [extents.near, extents.far],
            Self::Tight => perspective_range(view, &view_from_world),
        };
        // Widen by the kernel's reach, so that the outermost receivers' taps stay on the map.
        let widened = (half_angle.tan() * size as f32 / (size as f32 - 2.0 * margin - 2.0).max(1.0)).atan();
        Ok(LightSpace { view_from_world, clip_from_view: perspective(2.0 * widened, 1.0, near, far)? })
    }
}

fn points<'a>(
    view: &'a View<'_>,
    aabb: Aabb,
    triangles: impl Fn(&crate::Geometry) -> std::ops::Range<u32>,
) -> Box<dyn Iterator<Item = Vec3> + 'a> {
    match view.geometry {
        Some(g) => Box::new(g.vertices_of(triangles(g))),
        None => Box::new(aabb.corners()),
    }
}

fn caster_points<'a>(view: &'a View<'_>) -> Box<dyn Iterator<Item = Vec3> + 'a> {
    points(view, view.casters, crate::Geometry::casters)
}

/// What is seen if it is known, else all that may receive, else the casters themselves.
fn receiver_points<'a>(view: &'a View<'_>) -> Box<dyn Iterator<Item = Vec3> + 'a> {
    match view.receivers {
        Some(r) => Box::new(r.positions()),
        None => points(view, view.casters, crate::Geometry::receivers),
    }
}

/// Bounds in view space, grown by a relative 2^-16 so that rounding cannot put a point outside.
fn bounds_in(view_from_world: &Mat4, points: impl Iterator<Item = Vec3>) -> Aabb {
    let mut b = Aabb::around(points.map(|p| view_from_world.transform_point3(p)));
    let reach = b.min.abs().max(b.max.abs()).max_element();
    let pad = if reach.is_finite() { reach / 65_536.0 } else { 0.0 };
    (b.min, b.max) = (b.min - pad, b.max + pad);
    b
}

fn tight_orthographic(view: &View<'_>, direction: Vec3, size: u32, margin: f32) -> Result<LightSpace, Invalid> {
    // An eye amid the casters keeps numbers small when the scene is far from the origin.
    let eye = if view.casters.is_empty() { Vec3::ZERO } else { view.casters.center() };
    let view_from_world = look_along(eye, direction, Vec3::Y)?;
    let casters = bounds_in(&view_from_world, caster_points(view));
    let receivers = bounds_in(&view_from_world, receiver_points(view));
    let mut b = casters.intersection(&receivers);
    // View z falls away from the light: from the first caster (greatest z) to the last receiver (least z).
    (b.min.z, b.max.z) = (receivers.min.z, casters.max.z);
    if b.is_empty() {
        // Nothing can fall on anything: any space will do.
        b = Aabb { min: Vec3::splat(-1.0), max: Vec3::splat(1.0) };
    }
    let grow =
        (b.extent() / (size as f32 - 2.0 * margin - 2.0).max(1.0) * (margin + 1.0)).max(Vec3::splat(f32::MIN_POSITIVE));
    let extents = Extents {
        left: b.min.x - grow.x,
        right: b.max.x + grow.x,
        bottom: b.min.y - grow.y,
        top: b.max.y + grow.y,
        near: -b.max.z,
        far: -b.min.z,
    };
    Ok(LightSpace { view_from_world, clip_from_view: orthographic(extents)? })
}

/// The axis and half angle (radians) of a cone from `eye` that holds all casters.
fn cone_around_casters(view: &View<'_>, eye: Vec3) -> Result<(Vec3, f32), PlanError> {
    let directions = || caster_points(view).map(move |p| (p - eye).as_dvec3().normalize_or_zero());
    let sum: glam::DVec3 = directions().sum();
    let center = Aabb::around(caster_points(view)).center() - eye;
    let axis = if sum.length() > 1e-9 { sum.normalize() } else { center.as_dvec3().normalize_or(-glam::DVec3::Y) };
    let widest = directions().map(|d| d.dot(axis)).fold(1.0, f64::min);
    if view.casters.is_empty() {
        return Ok((Vec3::NEG_Y, 0.5));
    }
    let half_angle = widest.clamp(-1.0, 1.0).acos() as f32 + 1e-3;
    Ok((axis.as_vec3(), half_angle))
}

/// Distances along the view to the nearest caster and the farthest receiver.
fn perspective_range(view: &View<'_>, view_from_world: &Mat4) -> [f32; 2] {
    let casters = bounds_in(view_from_world, caster_points(view));
    let receivers = bounds_in(view_from_world, receiver_points(view));
    let far = if receivers.is_empty() { -casters.min.z } else { -receivers.min.z };
    let far = if far.is_finite() && far > 0.0 { far } else { 1.0 };
    let near = nearest_along(view_from_world, view).unwrap_or(far * 0.5).clamp(far * NEAREST, far * 0.5);
    [near, far]
}

/// The least distance along the view of any caster in front of the light, less a little for rounding. A triangle that
/// crosses the light's plane reaches all the way to it.
fn nearest_along(view_from_world: &Mat4, view: &View<'_>) -> Option<f32> {
    let depth = |p: Vec3| -view_from_world.transform_point3(p).z;
    let (mut nearest, mut crossing) = (f32::INFINITY, false);
    match view.geometry {
        Some(g) => g.casters().for_each(|t| {
            let [a, b, c] = g.corners(t).map(depth);
            let (lo, hi) = (a.min(b).min(c), a.max(b).max(c));
            crossing |= lo <= 0.0 && hi > 0.0;
            nearest = if lo > 0.0 { nearest.min(lo) } else { nearest };
        }),
        None => view.casters.corners().map(depth).for_each(|d| {
            crossing |= d <= 0.0;
            nearest = nearest.min(d);
        }),
    }
    match (crossing, nearest.is_finite()) {
        (true, _) => Some(0.0),
        (false, true) => Some(nearest * 0.999),
        (false, false) => None,
    }
}
