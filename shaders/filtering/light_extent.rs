//! Extent of a light on a shadow map: the distance, texels, by which a blocker moves the light's
//! edge.
//!
//! Let a map with perspective look along -z from the light's centre. A receiver at distance d_r has
//! the tangent coordinates t. A light point s is relative to the centre, in the map's view space.
//! From the receiver, s appears in a blocker's plane at distance d_b at the tangent coordinates t +
//! (s.xy + s.z t) (1/d_b - 1/d_r) / (1 + s.z/d_r). Without perspective, the light's edge at the
//! angle a moves it by tan(a) (d_r - d_b) metres. Clip depth is linear in 1/d with perspective, and
//! in d without. So **both are linear in the difference of clip depths**. The light's half axes are
//! converted to texels per unit of clip depth once for a whole map.
//!
//! Approximations:
//!
//! - The divisor 1 + s.z/d_r is ignored. It is 1 for lights parallel to the map. Otherwise its
//!   error is the light's depth along the axis over the receiver's distance.
//! - A ball's disc faces each receiver, not the map; this is exact only to first order.
//! - The cap of directions of a directional light is treated as flat (an angle's tangent for the
//!   angle).

use crate::{
    filtering::sample_pattern::PatternShape,
    shadow_map::{ShadowMap, layers::MAX_LAYERS},
};
use glam::{DMat4, DVec3, Mat4, Vec2, Vec3, Vec4};
use umbrage_core::{
    FitMemory, Light, LightSpace, LightSpaces, Module, RecipeError, View, module, uniforms,
};

/// The WGSL half.
pub(crate) const LIGHT_EXTENT: Module = module!("light_extent");

/// Greatest fraction of a map's half side that is reserved for the reach of kernels beyond the
/// receivers. Wider lights lose the shadows of casters outside the map on its outermost receivers.
const MAX_REACH: f32 = 0.5;
/// Number of fits. The margin of a fit depends on the texels' size, which depends on the margin.
/// Each fit after the first corrects for the change of the previous one.
const FITS: usize = 3;

uniforms! {
    /// Half axes of a light on each layer of a map, texels per unit of clip depth.
    pub struct LightExtent {
        /// x, y: right and down in the map's plane. z: towards the light's back, times texels from
        /// the map's centre. w: 0. For balls, w is the tangent that a texel from the centre spans,
        /// and y and z are 0.
        pub half_axis_u: [Vec4; MAX_LAYERS],
        /// Second half axis, with the same x, y, z (unused for balls). w: greatest difference of
        /// clip depths that is followed. Beyond it, a tap could be half a map away.
        pub half_axis_v: [Vec4; MAX_LAYERS],
    }
}

/// Returns the half axes, texels per unit of clip depth: x and y of the first, then x and y of the
/// second. The receiver is `from_middle` texels right and down of the map's centre.
///
/// A ball counts as the disc of its radius that faces the receiver. Its projection along the
/// receiver's ray onto the map's plane is the ellipse with the matrix R^2 (1 + t t^T). Any two axes
/// whose outer products add up to this matrix describe it. These are its Cholesky factor.
#[inline(always)]
pub(crate) fn light_axes(half_axis_u: Vec4, half_axis_v: Vec4, from_middle: Vec2) -> Vec4 {
    let x = from_middle.x;
    let y = from_middle.y;
    if half_axis_u.w > 0.0 {
        let tx = x * half_axis_u.w;
        let ty = y * half_axis_u.w;
        let a = (1.0 + tx * tx).sqrt();
        let d = (1.0 + tx * tx + ty * ty).sqrt();
        return Vec4::new(
            half_axis_u.x * a,
            half_axis_u.x * (tx * ty / a),
            0.0,
            half_axis_u.x * (d / a),
        );
    }
    Vec4::new(
        half_axis_u.x + half_axis_u.z * x,
        half_axis_u.y + half_axis_u.z * y,
        half_axis_v.x + half_axis_v.z * x,
        half_axis_v.y + half_axis_v.z * y,
    )
}

/// Returns the shape of a light's points.
pub(crate) fn shape(light: &Light) -> PatternShape {
    match light {
        Light::Rect { .. } => PatternShape::Square,
        Light::Directional { .. }
        | Light::Spot { .. }
        | Light::Point { .. }
        | Light::Disc { .. } => PatternShape::Disc,
    }
}

impl LightExtent {
    /// Returns the extent of `light` on maps with the side `size`, texels, and the light spaces
    /// `spaces`.
    ///
    /// Panics if there are no spaces.
    pub fn new(light: &Light, spaces: &LightSpaces, size: u32) -> Self {
        let mut half_axis_u = [Vec4::ZERO; MAX_LAYERS];
        let mut half_axis_v = [Vec4::ZERO; MAX_LAYERS];
        for i in 0..MAX_LAYERS {
            // Layers without a space repeat the first.
            let space = spaces.spaces.get(i).unwrap_or(&spaces.spaces[0]);
            [half_axis_u[i], half_axis_v[i]] = half_axes_on_map(light, space, size);
        }
        Self {
            half_axis_u,
            half_axis_v,
        }
    }

    /// Returns the greatest distance of taps from the receiver's texel on the faces in use, texels.
    fn reach(&self, light: &Light, spaces: &LightSpaces, size: u32) -> f32 {
        let mut farthest = 0.0_f32;
        for i in 0..spaces.spaces.len() {
            if spaces.is_needed(i) {
                let reach = reach(shape(light), self.half_axis_u[i], self.half_axis_v[i], size);
                farthest = farthest.max(reach);
            }
        }
        farthest
    }
}

/// Returns light spaces that are enlarged by the reach of a search over the light's extent.
/// Anything at the near plane in that margin could hide a part of the light from a receiver at the
/// far plane. The margin is bounded: at least half of a map's side remains for the original extent.
///
/// # Errors
/// Errors if [`ShadowMap::spaces`] does.
pub(crate) fn spaces(map: &ShadowMap, view: &View<'_>) -> Result<LightSpaces, RecipeError> {
    let mut margin = 0.0;
    // Compute the common part of all fits once.
    let memory = FitMemory::default();
    let view = &match view.fits {
        Some(_) => *view,
        None => view.with_fits(&memory),
    };
    let mut spaces = map.spaces(view, margin)?;
    for _ in 1..FITS {
        // The margin leaves `inner` texels of the map, minus one texel at each border.
        let inner = (map.size as f32 - 2.0 * margin - 2.0).max(1.0);
        let extent = LightExtent::new(view.light, &spaces, map.size);
        let reach = extent.reach(view.light, &spaces, map.size);
        // Express the reach as a multiple of half the inner side. This ratio stays the same when
        // the margin changes the texels' size.
        let ratio = (2.0 * reach / inner).min(MAX_REACH / (1.0 - MAX_REACH));
        // Solve margin = ratio (half - margin) for the margin, where half is the map's half side.
        let wanted = (map.size as f32 - 2.0) * 0.5 * ratio / (1.0 + ratio);
        if wanted <= margin * 1.01 {
            break;
        }
        margin = wanted;
        spaces = map.spaces(view, margin)?;
    }
    Ok(spaces)
}

/// Returns the greatest distance along one axis, texels, from a receiver anywhere on the map to a
/// tap at a difference of clip depths of 1. The half axes grow towards the map's corners.
fn reach(shape: PatternShape, half_axis_u: Vec4, half_axis_v: Vec4, size: u32) -> f32 {
    let half = size as f32 * 0.5;
    let corners = [
        Vec2::new(half, half),
        Vec2::new(-half, half),
        Vec2::new(half, -half),
        Vec2::new(-half, -half),
    ];
    corners
        .into_iter()
        .map(|corner| reach_at(shape, half_axis_u, half_axis_v, corner))
        .fold(0.0, f32::max)
}

/// Returns the greatest distance along one axis, texels, for a receiver `from_middle` texels right
/// and down of the map's centre.
pub(crate) fn reach_at(
    shape: PatternShape,
    half_axis_u: Vec4,
    half_axis_v: Vec4,
    from_middle: Vec2,
) -> f32 {
    let square = u32::from(shape == PatternShape::Square);
    reach_along(square, light_axes(half_axis_u, half_axis_v, from_middle)).max_element()
}

/// Returns the greatest extent, right and down, of a parallelogram (`square` is 1) or an ellipse
/// (0) with these half axes.
#[inline(always)]
pub(crate) fn reach_along(square: u32, axes: Vec4) -> Vec2 {
    let a = axes;
    if square != 0 {
        return Vec2::new(a.x.abs() + a.z.abs(), a.y.abs() + a.w.abs());
    }
    Vec2::new(
        (a.x * a.x + a.z * a.z).sqrt(),
        (a.y * a.y + a.w * a.w).sqrt(),
    )
}

/// Returns the difference of clip depths that moves the light's edge by one texel. `reach` is
/// [`reach_along`] for a difference of 1. The result is clamped to 1e-9..=1e9, so that its square
/// is finite.
#[inline(always)]
pub(crate) fn texel_depth(reach: Vec2) -> f32 {
    let farthest = if reach.x > reach.y { reach.x } else { reach.y };
    1.0 / farthest.clamp(1e-9, 1e9)
}

/// Returns [`LightExtent::half_axis_u`] and [`LightExtent::half_axis_v`] of one face.
fn half_axes_on_map(light: &Light, space: &LightSpace, size: u32) -> [Vec4; 2] {
    let projection = space.clip_from_view.as_dmat4();
    let half = f64::from(size) * 0.5;
    // Convert metres (or tangents) along the view's x and y to texels right and down.
    let right = projection.x_axis.x * half;
    let down = -projection.y_axis.y * half;
    let per_depth = per_depth(&space.clip_from_view);
    let view_from_world = space.view_from_world.as_dmat4();
    let on_map = |axis: DVec3| {
        let s = view_from_world.transform_vector3(axis);
        let texels = DVec3::new(s.x * right, s.y * down, s.z) * per_depth;
        texels.as_vec3().extend(0.0)
    };
    let [mut half_axis_u, mut half_axis_v] = match half_axes(light, &view_from_world.inverse()) {
        HalfAxes::Flat(u, v) => [on_map(u), on_map(v)],
        HalfAxes::Ball(radius) => [
            Vec4::new(
                (radius * right * per_depth) as f32,
                0.0,
                0.0,
                (1.0 / right) as f32,
            ),
            Vec4::ZERO,
        ],
    };
    // A ball without a radius is a point, but w would still mark it as a ball.
    if half_axis_u.x == 0.0 && half_axis_u.w > 0.0 {
        half_axis_u = Vec4::ZERO;
    }
    // Limit the reach to half a map.
    let reach = reach(shape(light), half_axis_u, half_axis_v, size);
    half_axis_v.w = if reach > 0.0 {
        half as f32 / reach
    } else {
        1.0
    };
    [half_axis_u, half_axis_v]
}

/// Returns the change per unit of clip depth, positive, of 1/distance with perspective (1/metre) or
/// of distance without (metres).
fn per_depth(clip_from_view: &Mat4) -> f64 {
    // Clip z is a z + b; with perspective, where clip w is -z, clip depth is -a - b / z.
    let a = f64::from(clip_from_view.z_axis.z);
    let b = f64::from(clip_from_view.w_axis.z);
    let is_orthographic = clip_from_view.row(3) == Vec4::W;
    if is_orthographic { -1.0 / a } else { -1.0 / b }
}

/// Half axes of a light, world space.
pub(crate) enum HalfAxes {
    /// Half axes of a parallelogram or an ellipse: metres, or tangents for directional lights.
    Flat(DVec3, DVec3),
    /// Radius of a ball.
    Ball(f64),
}

/// Returns a light's half axes. For directional lights they are along the x and y of the light's
/// map, whose transform is `world_from_view`.
pub(crate) fn half_axes(light: &Light, world_from_view: &DMat4) -> HalfAxes {
    match *light {
        Light::Directional {
            angular_diameter, ..
        } => {
            let tangent = (f64::from(angular_diameter) * 0.5).tan();
            let u = world_from_view.transform_vector3(DVec3::X);
            let v = world_from_view.transform_vector3(DVec3::Y);
            HalfAxes::Flat(u * tangent, v * tangent)
        }
        Light::Spot {
            direction, radius, ..
        } => disc(direction, radius),
        Light::Disc { normal, radius, .. } => disc(normal, radius),
        Light::Rect { half_u, half_v, .. } => HalfAxes::Flat(half_u.as_dvec3(), half_v.as_dvec3()),
        Light::Point { radius, .. } => HalfAxes::Ball(f64::from(radius)),
    }
}

/// Returns the half axes of a disc with this normal (of any length) and this radius, metres.
fn disc(normal: Vec3, radius: f32) -> HalfAxes {
    let normal = normal.as_dvec3().normalize_or(DVec3::Y);
    let (u, v) = normal.any_orthonormal_pair();
    HalfAxes::Flat(u * f64::from(radius), v * f64::from(radius))
}

/// All twins of this module, for the tests that compare them.
#[cfg(feature = "testing")]
pub(crate) const TWINS: &[umbrage_core::Twin] = &[
    umbrage_core::twin!(LIGHT_EXTENT, light_axes(half_axis_u: Vec4, half_axis_v: Vec4, from_middle: Vec2) -> Vec4),
    umbrage_core::twin!(LIGHT_EXTENT, reach_along(square: u32, axes: Vec4) -> Vec2),
    umbrage_core::twin!(LIGHT_EXTENT, texel_depth(reach: Vec2) -> f32),
];

#[cfg(test)]
#[path = "light_extent_tests.rs"]
mod tests;
