//! Stable fits of parallel light: a map that a moving camera moves by whole texels.
//!
//! Three things make shadows shimmer while a camera moves: texels that change size, texels that
//! turn, and texels that slide over the world. So the map goes around a sphere, which is as large
//! however it turns; its axes hang on the light alone; and it moves in steps of a texel (Valient
//! 2008, "Stable rendering of cascaded shadow maps").
//!
//! Steps are whole texels in the 32-bit matrix, not only before it is rounded: the view turns about
//! the world's origin, so that its linear part never changes, and translations are whole numbers of
//! texels in clip space, which 32-bit floats hold exactly if the map's side is a power of two and
//! no more than 2^24 texels lie between it and the origin. A point's sum of products is then the
//! same in every frame, and its place within a texel stays.

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

/// Steps in which the near plane moves, as a fraction of the sphere's radius.
const DEPTH_STEP: f64 = 0.25;
/// Steps in which the radius of a slice's sphere doubles.
const RADIUS_STEPS_PER_OCTAVE: f64 = 8.0;
/// Texels beside the sphere for the outermost receivers' own.
const BORDER_TEXELS: f64 = 1.0;
/// Steps of a map's side in which a map around the camera moves.
const CAMERA_STEPS_PER_SIDE: u32 = 32;
/// Steps of the radius to which the camera's place is rounded: a camera's matrix holds it only as
/// well as 32-bit floats turn it.
const CAMERA_STEPS_PER_RADIUS: f64 = 4096.0;
/// Least radius, as a fraction of the coordinates: below, 32-bit positions could not be told apart.
const MIN_RADIUS_OVER_COORDINATE: f64 = 1.0 / 1_048_576.0;

/// Where the sphere has its centre.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SphereCenter {
    /// In the middle of what is seen, so that it is smallest.
    Seen,
    /// At the camera, so that it stays where it is while the camera turns.
    Camera,
}

impl SphereCenter {
    /// Returns where the sphere of a stable fit has its centre.
    pub(super) fn of_fit(fit: &Fit) -> Self {
        match fit {
            Fit::AroundCamera { .. } => Self::Camera,
            _ => Self::Seen,
        }
    }

    /// Returns the whole number of texels in steps of which a map moves.
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

/// Returns the light space around what the camera may see up to `range` metres along its view.
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

/// Returns the light space around what the camera may see in a slice of its view.
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

/// Returns the radius, metres, of the sphere around a slice of what a camera sees.
pub(super) fn slice_radius(frustum: &CameraFrustum, slice: Slice, center: SphereCenter) -> f64 {
    slice_sphere(frustum, slice, center).radius
}

/// Returns the sphere around a slice of what a camera sees, its radius rounded up to a step: so
/// texels seldom change size while a field of view does, or the slices' ends.
fn slice_sphere(frustum: &CameraFrustum, slice: Slice, center: SphereCenter) -> Sphere {
    let near_corners = frustum.corners_at(slice.begin);
    let far_corners = frustum.corners_at(slice.end);
    let sphere = around_view(frustum, &near_corners, &far_corners, center);
    let steps = (sphere.radius.log2() * RADIUS_STEPS_PER_OCTAVE).ceil();
    let radius = (steps / RADIUS_STEPS_PER_OCTAVE).exp2();
    Sphere {
        // Not below, by what the two functions round.
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
    // A step takes the map half of it away from the sphere; one texel is left where that is less.
    let beside = f64::from(margin) + BORDER_TEXELS + (0.5 * step).max(1.0);
    let inner = (f64::from(size) - 2.0 * beside).max(1.0);
    let half_side = sphere.radius * f64::from(size) / inner;
    // Casters count wherever a step may take the map.
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
    // The sphere's centre in clip space, rounded to whole steps, moves to the middle of the map.
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

/// Returns the near plane's distance and the depth of the space behind it, metres. Both go in
/// steps, so that clip depths (and with them biases) seldom change: the near plane by quarters of
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
    let need = Need::new(*space, geometry, &Receiving::within(*column), &no_reach);
    need.map_or(f64::INFINITY, |need| need.first_rank())
}

/// Returns the smallest of the spheres around what the camera may see (`seen`), what casts, and
/// what receives; not so small that 32-bit positions in it could not be told apart.
fn smallest(view: &View<'_>, seen: Sphere) -> Sphere {
    let receivers = view.geometry.map(|g| g.box_tree().around(g.receivers()));
    let boxes = [Some(view.casters), receivers]
        .into_iter()
        .flatten()
        .filter(|b| !b.is_empty());
    let mut sphere = seen;
    for b in boxes {
        let other = around(&b);
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

fn around(b: &Aabb) -> Sphere {
    let min = b.min.as_dvec3();
    let max = b.max.as_dvec3();
    Sphere {
        center: (min + max) * 0.5,
        radius: (max - min).length() * 0.5,
    }
}

/// Returns the sphere, world space, around what a camera sees between two rectangles across its
/// view (view space). The radius depends on the projection alone.
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

/// Returns a sphere around another one, its centre at a place that stays the same whatever 32-bit
/// floats rounded.
fn at_rounded_place(sphere: Sphere) -> Sphere {
    // A power of two, so that places like 0 or 3.5 lie in the middle between the bounds of
    // rounding.
    let step = (sphere.radius / CAMERA_STEPS_PER_RADIUS)
        .log2()
        .floor()
        .exp2();
    Sphere {
        center: (sphere.center / step).round() * step,
        // The centre moves by less than a step: by half of it along each axis.
        radius: sphere.radius + step,
    }
}

/// Returns the point on the line between the middles of two rectangles across a view that is as far
/// from the corners of both as can be.
fn center_of_view(near_corners: &[DVec3; 4], far_corners: &[DVec3; 4]) -> DVec3 {
    let near_middle = middle(near_corners);
    let far_middle = middle(far_corners);
    let near_radius_squared = radius_squared(near_corners, near_middle);
    let far_radius_squared = radius_squared(far_corners, far_middle);
    // With l the distance of the middles and s the centre's share of it, the corners are equally
    // far from the centre where near_radius^2 + (s l)^2 = far_radius^2 + ((1 - s) l)^2.
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
