//! Stable fits of parallel light: a map that moves with the camera by whole texels.
//!
//! Three things make shadows shimmer while a camera moves: texels that change size, texels that
//! turn, and texels that slide over the world. So the map covers a sphere, whose size doesn't
//! depend on the camera's orientation. Its axes depend only on the light. It moves in steps of a
//! texel (Valient 2008, "Stable rendering of cascaded shadow maps").
//!
//! Steps are whole texels in the 32-bit matrix, not only before rounding. The view turns about the
//! world's origin, so that its linear part never changes. Translations are whole numbers of texels
//! in clip space. 32-bit floats represent these exactly if the map's side is a power of two and at
//! most 2^24 texels separate it from the origin. A point's sum of products is then the same in
//! every frame, and its position within a texel stays.

use crate::{
    geometry::aabb::Aabb,
    invalid::{self, Invalid},
    light_space::{
        LightSpace,
        fit::{
            cull::{Need, Reach, Receiving},
            frustum::{CameraFrustum, Slice},
            kind::Fit,
            map_space::{MapBounds, MapSpace},
        },
        look_along,
    },
    view::View,
};
use glam::{DAffine3, DVec2, DVec3, Mat4, Vec3, Vec4};

/// Step of the near plane, as a fraction of the sphere's radius.
const DEPTH_STEP: f64 = 0.25;
/// Number of steps per doubling of the radius of a slice's sphere.
const RADIUS_STEPS_PER_OCTAVE: f64 = 8.0;
/// Texels around the sphere for the outermost receivers' own texels.
const BORDER_TEXELS: f64 = 1.0;
/// Number of steps per side for a map around the camera.
const CAMERA_STEPS_PER_SIDE: u32 = 32;
/// Steps per radius to which the camera's position is rounded: 32-bit rounding in a camera's
/// rotation disturbs the position in its matrix.
const CAMERA_STEPS_PER_RADIUS: f64 = 4096.0;
/// Least radius, as a fraction of the coordinates: the resolution of 32-bit positions.
const MIN_RADIUS_OVER_COORDINATE: f64 = 1.0 / 1_048_576.0;

/// Centre of the sphere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SphereCenter {
    /// The centre of the visible volume: the smallest sphere.
    Seen,
    /// The camera: the sphere doesn't move while the camera turns.
    Camera,
}

impl SphereCenter {
    /// Returns the centre of the sphere of a stable fit.
    pub(super) fn of_fit(fit: &Fit) -> Self {
        match fit {
            Fit::AroundCamera { .. } => Self::Camera,
            _ => Self::Seen,
        }
    }

    /// Returns the step of the map's position, a whole number of texels.
    fn step(self, size: u32) -> f64 {
        match self {
            Self::Seen => 1.0,
            Self::Camera => f64::from((size / CAMERA_STEPS_PER_SIDE).max(1)),
        }
    }
}

#[derive(Clone, Copy, Debug)]
struct Sphere {
    center: DVec3,
    radius: f64,
}

/// Returns the light space around the camera's view up to `range` metres along it.
///
/// Errors if `range` is not positive, or the result is not finite.
pub(super) fn parallel(
    view: &View<'_>,
    direction: Vec3,
    range: f32,
    center: SphereCenter,
    size: u32,
    margin: f32,
) -> Result<LightSpace, Invalid> {
    invalid::positive("stable fit's range", range)?;
    let frustum = CameraFrustum::new(view.camera);
    let far_corners = frustum.corners_at(frustum.before_far(f64::from(range)));
    let seen = around_view(&frustum, &frustum.near_corners, &far_corners, center);
    let sphere = smallest(view, seen);
    around_sphere(view, direction, sphere, center.step(size), size, margin)
}

/// Returns the light space around a slice of the camera's view.
///
/// Errors if the result is not finite.
pub(super) fn slice(
    view: &View<'_>,
    direction: Vec3,
    slice: Slice,
    center: SphereCenter,
    size: u32,
    margin: f32,
) -> Result<LightSpace, Invalid> {
    let frustum = CameraFrustum::new(view.camera);
    let seen = slice_sphere(&frustum, slice, center);
    let sphere = smallest(view, seen);
    around_sphere(view, direction, sphere, center.step(size), size, margin)
}

/// Returns the radius, metres, of the sphere around a slice of a camera's view.
pub(super) fn slice_radius(frustum: &CameraFrustum, slice: Slice, center: SphereCenter) -> f64 {
    slice_sphere(frustum, slice, center).radius
}

/// Returns the sphere around a slice of a camera's view, its radius rounded up to a step. Texels
/// then rarely change size when the field of view or the slices' ends do.
fn slice_sphere(frustum: &CameraFrustum, slice: Slice, center: SphereCenter) -> Sphere {
    let near_corners = frustum.corners_at(slice.begin);
    let far_corners = frustum.corners_at(slice.end);
    let sphere = around_view(frustum, &near_corners, &far_corners, center);
    let steps = (sphere.radius.log2() * RADIUS_STEPS_PER_OCTAVE).ceil();
    let radius = (steps / RADIUS_STEPS_PER_OCTAVE).exp2();
    Sphere {
        // Guard against the rounding of the two functions.
        radius: radius.max(sphere.radius),
        ..sphere
    }
}

/// Returns the light space around a sphere, which moves in steps of `step` texels.
fn around_sphere(
    view: &View<'_>,
    direction: Vec3,
    sphere: Sphere,
    step: f64,
    size: u32,
    margin: f32,
) -> Result<LightSpace, Invalid> {
    let view_from_world = look_along(Vec3::ZERO, direction, Vec3::Y)?;
    // Allow for half a step of displacement from the sphere, but at least one texel.
    let adjacent = f64::from(margin) + BORDER_TEXELS + (0.5 * step).max(1.0);
    let inner = (f64::from(size) - 2.0 * adjacent).max(1.0);
    let half_side = sphere.radius * f64::from(size) / inner;
    // Casters count at all positions of the map within a step.
    let column_half_side = if step > 1.0 {
        half_side * (1.0 + step / f64::from(size))
    } else {
        half_side
    };
    let [near, depth] = depths(view, &view_from_world, &sphere, column_half_side);
    let scale_xy = (1.0 / half_side) as f32;
    let scale_z = (-1.0 / depth) as f32;
    let unmoved = LightSpace {
        view_from_world,
        clip_from_view: Mat4::from_diagonal(Vec4::new(scale_xy, scale_xy, scale_z, 1.0)),
    };
    // Move the sphere's centre in clip space, rounded to whole steps, to the centre of the map.
    let center = unmoved
        .clip_from_world()
        .as_dmat4()
        .transform_point3(sphere.center);
    let texel = 2.0 / f64::from(size);
    let whole_steps = (center.truncate() / (texel * step)).round();
    let shift = (-whole_steps * step * texel)
        .extend(-near / depth)
        .as_vec3();
    let clip_from_view = Mat4 {
        w_axis: shift.extend(1.0),
        ..unmoved.clip_from_view
    };
    invalid::finite("stable fit", &clip_from_view.to_cols_array())?;
    Ok(LightSpace {
        clip_from_view,
        ..unmoved
    })
}

/// Returns the near plane's distance and the depth of the space behind it, metres. Both change in
/// steps, so that clip depths (and with them biases) rarely change: the near plane by quarters of
/// the radius, the depth by factors of two. `half_side` is that of the column in which casters
/// count, metres.
fn depths(view: &View<'_>, view_from_world: &Mat4, sphere: &Sphere, half_side: f64) -> [f64; 2] {
    let space = MapSpace {
        view_from_world: DAffine3::from_mat4(view_from_world.as_dmat4()),
        nearest: None,
    };
    let center = space.view_from_world.transform_point3(sphere.center);
    let first = -center.z - sphere.radius;
    let last = -center.z + sphere.radius;
    let side = DVec3::new(half_side, half_side, 0.0);
    let column = MapBounds {
        min: (center - side).with_z(first),
        max: (center + side).with_z(last),
    };
    let step = sphere.radius * DEPTH_STEP;
    let nearest = first.min(first_caster(view, &space, &column));
    let near = (nearest / step).floor() * step;
    let mut depth = 2.0 * sphere.radius + step;
    while near + depth < last {
        depth *= 2.0;
    }
    [near, depth]
}

/// Returns the least rank of a caster in a column; infinity if there is none.
pub(super) fn first_caster(view: &View<'_>, space: &MapSpace, column: &MapBounds) -> f64 {
    let Some(geometry) = view.geometry else {
        return space.block(&view.casters).min.z;
    };
    let no_reach = Reach {
        across: DVec2::ZERO,
        behind: 0.0,
    };
    let need = Need::new(
        *space,
        geometry,
        &Receiving::from_bounds(*column),
        &no_reach,
    );
    need.map_or(f64::INFINITY, |need| need.first_rank())
}

/// Returns the smallest of the spheres around the camera's view (`seen`), the casters, and the
/// receivers. Its radius is at least the resolution of 32-bit positions in it.
fn smallest(view: &View<'_>, seen: Sphere) -> Sphere {
    let receivers = view
        .geometry
        .map(|g| g.box_tree().enclosing_box(g.receivers()));
    let boxes = [Some(view.casters), receivers]
        .into_iter()
        .flatten()
        .filter(|b| !b.is_empty());
    let mut sphere = seen;
    for b in boxes {
        let other = bounding_sphere(&b);
        if other.radius < sphere.radius {
            sphere = other;
        }
    }
    sphere.radius = sphere
        .radius
        .max(sphere.center.abs().max_element() * MIN_RADIUS_OVER_COORDINATE)
        .max(f64::from(f32::MIN_POSITIVE));
    sphere
}

fn bounding_sphere(b: &Aabb) -> Sphere {
    let min = b.min.as_dvec3();
    let max = b.max.as_dvec3();
    Sphere {
        center: (min + max) * 0.5,
        radius: (max - min).length() * 0.5,
    }
}

/// Returns the sphere, world space, around a camera's view between two rectangles across it (view
/// space). The radius depends only on the projection.
fn around_view(
    frustum: &CameraFrustum,
    near_corners: &[DVec3; 4],
    far_corners: &[DVec3; 4],
    center: SphereCenter,
) -> Sphere {
    let in_view = match center {
        SphereCenter::Seen => center_of_view(near_corners, far_corners),
        SphereCenter::Camera => DVec3::ZERO,
    };
    let radius = near_corners
        .iter()
        .chain(far_corners)
        .map(|corner| corner.distance(in_view))
        .fold(0.0, f64::max);
    let sphere = Sphere {
        center: frustum.world_from_view.transform_point3(in_view),
        radius,
    };
    match center {
        SphereCenter::Seen => sphere,
        SphereCenter::Camera => at_rounded_place(sphere),
    }
}

/// Returns a sphere around another one, with a rounded centre that doesn't depend on 32-bit
/// rounding.
fn at_rounded_place(sphere: Sphere) -> Sphere {
    // Use a power of two, so that coordinates like 0 or 3.5 are midway between rounding boundaries.
    let step = (sphere.radius / CAMERA_STEPS_PER_RADIUS)
        .log2()
        .floor()
        .exp2();
    Sphere {
        center: (sphere.center / step).round() * step,
        // The centre moves by less than a step: by half a step along each axis.
        radius: sphere.radius + step,
    }
}

/// Returns the point on the line between the centres of two rectangles across a view that minimizes
/// the greatest distance to their corners.
fn center_of_view(near_corners: &[DVec3; 4], far_corners: &[DVec3; 4]) -> DVec3 {
    let near_middle = middle(near_corners);
    let far_middle = middle(far_corners);
    let near_radius_squared = radius_squared(near_corners, near_middle);
    let far_radius_squared = radius_squared(far_corners, far_middle);
    // With l the distance of the centres and s the position along it, the corners are equally far
    // from the point where near_radius^2 + (s l)^2 = far_radius^2 + ((1 - s) l)^2.
    let length_squared = near_middle
        .distance_squared(far_middle)
        .max(f64::MIN_POSITIVE);
    let share = ((length_squared + far_radius_squared - near_radius_squared)
        / (2.0 * length_squared))
        .clamp(0.0, 1.0);
    near_middle.lerp(far_middle, share)
}

/// Returns the mean of a rectangle's corners.
fn middle(corners: &[DVec3; 4]) -> DVec3 {
    corners.iter().sum::<DVec3>() / 4.0
}

/// Returns the square of the greatest distance from `center` to a corner.
fn radius_squared(corners: &[DVec3; 4], center: DVec3) -> f64 {
    corners
        .iter()
        .map(|corner| corner.distance_squared(center))
        .fold(0.0, f64::max)
}
