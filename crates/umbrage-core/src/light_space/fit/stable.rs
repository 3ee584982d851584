//! Stable fits of parallel light: a map that a moving camera moves by whole texels.
//!
//! Three things make shadows shimmer while a camera moves: texels that change size, texels that turn, and texels that
//! slide over the world. So the map goes around a sphere, which is as large however it turns; its axes hang on the light
//! alone; and it moves in steps of a texel (Valient 2008, "Stable rendering of cascaded shadow maps").
//!
//! Steps are whole texels in the 32-bit matrix, not only before it is rounded: the view turns about the world's origin, so
//! that its linear part never changes, and translations are whole numbers of texels in clip space, which 32-bit floats
//! hold exactly if the map's side is a power of two and no more than 2^24 texels lie between it and the origin. A point's
//! sum of products is then the same in every frame, and its place within a texel stays.

use crate::{
    Aabb, Camera, Invalid, View, invalid,
    light_space::{
        LightSpace,
        fit::{
            cull::{Need, Reach, Receiving},
            map_space::{MapBounds, MapSpace},
        },
        look_along,
    },
};
use glam::{DAffine3, DVec2, DVec3, Mat4, Vec3, Vec4};

/// Steps in which the near plane moves, as a fraction of the sphere's radius.
const DEPTH_STEP: f64 = 0.25;
/// Texels beside the sphere: one for the outermost receivers' own, one for the step.
const BORDER_TEXELS: f64 = 2.0;
/// Least radius, as a fraction of the coordinates: below, 32-bit positions could not be told apart.
const MIN_RADIUS_OVER_COORDINATE: f64 = 1.0 / 1_048_576.0;

#[derive(Clone, Copy, Debug)]
struct Sphere {
    center: DVec3,
    radius: f64,
}

/// The space around what may be seen up to `range` metres.
pub(super) fn parallel(
    view: &View<'_>,
    direction: Vec3,
    range: f32,
    size: u32,
    margin: f32,
) -> Result<LightSpace, Invalid> {
    invalid::positive("stable fit's range", range)?;
    let view_from_world = look_along(Vec3::ZERO, direction, Vec3::Y)?;
    let sphere = smallest(view, f64::from(range));
    let inner = (f64::from(size) - 2.0 * (f64::from(margin) + BORDER_TEXELS)).max(1.0);
    let half_side = sphere.radius * f64::from(size) / inner;
    let [near, depth] = depths(view, &view_from_world, &sphere, half_side);
    let (across, along) = ((1.0 / half_side) as f32, (-1.0 / depth) as f32);
    let still = LightSpace {
        view_from_world,
        clip_from_view: Mat4::from_diagonal(Vec4::new(across, across, along, 1.0)),
    };
    let center = still
        .clip_from_world()
        .as_dmat4()
        .transform_point3(sphere.center);
    let texel = 2.0 / f64::from(size);
    let steps = (center.truncate() / texel).round();
    let shift = (-steps * texel).extend(-near / depth).as_vec3();
    let clip_from_view = Mat4 {
        w_axis: shift.extend(1.0),
        ..still.clip_from_view
    };
    invalid::finite("stable fit", &clip_from_view.to_cols_array())?;
    Ok(LightSpace {
        clip_from_view,
        ..still
    })
}

/// The near plane's distance, and the depth behind it. Both in steps, so that clip depths (and with them biases) seldom
/// change: the near plane by quarters of the radius, the depth by octaves.
fn depths(view: &View<'_>, view_from_world: &Mat4, sphere: &Sphere, half_side: f64) -> [f64; 2] {
    let space = MapSpace {
        view_from_world: DAffine3::from_mat4(view_from_world.as_dmat4()),
        nearest: None,
    };
    let center = space.view_from_world.transform_point3(sphere.center);
    let (first, last) = (-center.z - sphere.radius, -center.z + sphere.radius);
    let side = DVec3::new(half_side, half_side, 0.0);
    let column = MapBounds {
        min: (center - side).with_z(first),
        max: (center + side).with_z(last),
    };
    let step = sphere.radius * DEPTH_STEP;
    let near = (first.min(first_caster(view, &space, &column)) / step).floor() * step;
    let mut depth = 2.0 * sphere.radius + step;
    while near + depth < last {
        depth *= 2.0;
    }
    [near, depth]
}

/// The rank of the first caster in a column.
fn first_caster(view: &View<'_>, space: &MapSpace, column: &MapBounds) -> f64 {
    let found = match view.geometry {
        Some(geometry) => {
            let nothing = Reach {
                across: DVec2::ZERO,
                behind: 0.0,
            };
            let need = Need::new(*space, geometry, &Receiving::within(*column), &nothing);
            need.map_or(MapBounds::EMPTY, |need| need.around_casters())
        }
        None => space.block(&view.casters),
    };
    found.min.z
}

/// The smallest of the spheres around what the camera may see, what casts, and what receives.
fn smallest(view: &View<'_>, range: f64) -> Sphere {
    let receivers = view.geometry.map(|g| {
        let blocks = g.chunk_bounds().of(g.receivers());
        blocks.fold(Aabb::EMPTY, |all, (_, b)| all.union(&b))
    });
    let boxes = [Some(view.casters), receivers]
        .into_iter()
        .flatten()
        .filter(|b| !b.is_empty());
    let mut sphere = boxes
        .map(|b| around(&b))
        .fold(seen(view.camera, range), |a, b| {
            if b.radius < a.radius { b } else { a }
        });
    sphere.radius = sphere
        .radius
        .max(sphere.center.abs().max_element() * MIN_RADIUS_OVER_COORDINATE)
        .max(f64::from(f32::MIN_POSITIVE));
    sphere
}

fn around(b: &Aabb) -> Sphere {
    let (min, max) = (b.min.as_dvec3(), b.max.as_dvec3());
    Sphere {
        center: (min + max) * 0.5,
        radius: (max - min).length() * 0.5,
    }
}

/// The sphere around what a camera sees up to `range` metres along its view: its centre on the line between the middles of
/// the near and the far rectangle, as far from the corners of both as can be. The radius depends on the projection alone.
fn seen(camera: &Camera, range: f64) -> Sphere {
    let camera = camera.standard();
    let view_from_clip = camera.clip_from_view.as_dmat4().inverse();
    let at = |x: f64, y: f64, depth: f64| view_from_clip.project_point3(DVec3::new(x, y, depth));
    let last = -at(0.0, 0.0, 1.0).z;
    // A far plane at infinity comes out as infinite, or beyond it by what the inverse rounds.
    let range = if last.is_finite() && last > 0.0 {
        range.min(last)
    } else {
        range
    };
    let perspective = camera.clip_from_view.row(3) != Vec4::W;
    let corners = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)].map(|(x, y)| {
        let near = at(x, y, 0.0);
        let range = range.max(-near.z);
        [
            near,
            if perspective {
                near * (range / -near.z)
            } else {
                near.with_z(-range)
            },
        ]
    });
    let middle = |i: usize| corners.iter().map(|c| c[i]).sum::<DVec3>() / 4.0;
    let widest = |i: usize| {
        corners
            .iter()
            .map(|c| c[i].distance_squared(middle(i)))
            .fold(0.0, f64::max)
    };
    let (from, to) = (middle(0), middle(1));
    let length = from.distance_squared(to).max(f64::MIN_POSITIVE);
    let share = ((length + widest(1) - widest(0)) / (2.0 * length)).clamp(0.0, 1.0);
    let center = from.lerp(to, share);
    let radius = corners
        .iter()
        .flatten()
        .map(|c| c.distance(center))
        .fold(0.0, f64::max);
    let world_from_view = DAffine3::from_mat4(Mat4::from(camera.world_from_view).as_dmat4());
    Sphere {
        center: world_from_view.transform_point3(center),
        radius,
    }
}
