//! A light's extent as a shadow map sees it: how far its rim moves a blocker's shadow, texels.
//!
//! Let a map with perspective look along -z from the light's middle. A receiver at distance d_r sees a light point s (from
//! the middle, in the map's view space) through a blocker's plane at distance d_b at the tangent coordinates
//! t + (s.xy + s.z t) (1/d_b - 1/d_r) / (1 + s.z/d_r), where t are the receiver's own. Without perspective, the light's rim
//! at the angle a moves it by tan(a) (d_r - d_b) metres. With perspective, clip depth is linear in 1/d, and without in d:
//! so **both are linear in the difference of clip depths**, and the light's half axes turn into texels per unit of clip
//! depth once for a whole map.
//!
//! What is neglected: the divisor 1 + s.z/d_r, which is 1 for lights parallel to the map and wrong by the light's depth
//! along the axis over the receiver's distance else; that a ball's disc faces each receiver, not the map, beyond first
//! order; and for suns that the cap of directions is flat (an angle's tangent for the angle).

use crate::{filtering::sample_pattern::PatternShape, shadow_map::ShadowMap};
use glam::{DMat4, DVec3, Mat4, Vec2, Vec4};
use umbrage_core::{
    Light, LightSpace, LightSpaces, Module, RecipeError, Twin, View, twin, uniforms,
};

/// The WGSL half.
pub(crate) const LIGHT_EXTENT: Module = Module {
    name: "light_extent",
    text: include_str!("light_extent.wgsl"),
};

/// Greatest part of a map's half side that is spent on what kernels reach beyond the receivers. Wider lights lose the
/// shadows of casters outside the map on its outermost receivers.
const MOST_REACH: f32 = 0.5;
/// How often the fit is repeated to learn what reach it needs; each repetition corrects for what the last one changed.
const FITS: usize = 3;

uniforms! {
    /// The light's half axes on each face of a map, texels per unit of clip depth.
    pub struct LightExtent {
        /// x, y: right and down in the map's plane. z: towards the light's back, times texels from the map's middle. w: 0;
        /// for balls the tangent that a texel from the middle spans, and y and z are 0.
        pub half_axis_u: [Vec4; 6],
        /// The other half axis, x, y, z as before (unused for balls). w: greatest difference of clip depths that is
        /// followed; beyond, a tap could be half a map away.
        pub half_axis_v: [Vec4; 6],
    }
}

/// The half axes for a receiver `from_middle` texels right and down of the map's middle: x, y of one, x, y of the other.
///
/// A ball counts as the disc of its radius that faces the receiver. Along the receiver's ray it falls on the map's plane as
/// the ellipse with the matrix R^2 (1 + t t^T); any two axes whose outer products add up to it do, and these are its
/// Cholesky factor.
#[inline(always)]
pub(crate) fn light_axes(half_axis_u: Vec4, half_axis_v: Vec4, from_middle: Vec2) -> Vec4 {
    let (x, y) = (from_middle.x, from_middle.y);
    if half_axis_u.w > 0.0 {
        let (tx, ty) = (x * half_axis_u.w, y * half_axis_u.w);
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

/// The shape over which the light's points are spread.
pub(crate) fn shape(light: &Light) -> PatternShape {
    if matches!(light, Light::Rect { .. }) {
        PatternShape::Square
    } else {
        PatternShape::Disc
    }
}

impl LightExtent {
    /// The extent of `light` on maps of `size` texels that lie in `spaces`.
    pub fn new(light: &Light, spaces: &LightSpaces, size: u32) -> Self {
        let face = |i: usize| {
            axes_on(
                light,
                &spaces.spaces[if i < spaces.spaces.len() { i } else { 0 }],
                size,
            )
        };
        let faces: [[Vec4; 2]; 6] = std::array::from_fn(face);
        Self {
            half_axis_u: faces.map(|f| f[0]),
            half_axis_v: faces.map(|f| f[1]),
        }
    }

    /// How far taps reach beyond the receiver's texel on the faces that are needed, texels.
    fn reach(&self, light: &Light, spaces: &LightSpaces, size: u32) -> f32 {
        let needed = (0..spaces.spaces.len()).filter(|&i| spaces.is_needed(i));
        needed
            .map(|i| reach(shape(light), self.half_axis_u[i], self.half_axis_v[i], size))
            .fold(0.0, f32::max)
    }
}

/// Light spaces with room around them for what the light's extent makes a search reach: the region in which something at
/// the near plane would hide a part of the light from a receiver at the far plane. Bounded, so that at least half of a
/// map's side is left to what it is for.
///
/// # Errors
/// As [`ShadowMap::spaces`].
pub(crate) fn spaces(map: &ShadowMap, view: &View<'_>) -> Result<LightSpaces, RecipeError> {
    let mut margin = 0.0;
    let mut spaces = map.spaces(view, margin)?;
    for _ in 1..FITS {
        // In a map of which `inner` texels are left, `reach` texels become `e` of the half side that those had; and the
        // margin that is e times the new half side's inner part is found by solving for it.
        let inner = (map.size as f32 - 2.0 * margin - 2.0).max(1.0);
        let reach =
            LightExtent::new(view.light, &spaces, map.size).reach(view.light, &spaces, map.size);
        let e = (2.0 * reach / inner).min(MOST_REACH / (1.0 - MOST_REACH));
        let wanted = (map.size as f32 - 2.0) * 0.5 * e / (1.0 + e);
        if wanted <= margin * 1.01 {
            break;
        }
        margin = wanted;
        spaces = map.spaces(view, margin)?;
    }
    Ok(spaces)
}

/// Greatest distance, along one axis, from a receiver to a tap that follows a clip depth difference of 1. The half axes
/// grow towards the map's corners.
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

/// The same for a receiver `from_middle` texels right and down of the map's middle.
pub(crate) fn reach_at(
    shape: PatternShape,
    half_axis_u: Vec4,
    half_axis_v: Vec4,
    from_middle: Vec2,
) -> f32 {
    let square = u32::from(shape == PatternShape::Square);
    reach_along(square, light_axes(half_axis_u, half_axis_v, from_middle)).max_element()
}

/// How far a parallelogram (`square` is 1) or an ellipse (0) with these half axes reaches from its middle, right and down.
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

/// The difference of clip depths that moves the light's rim by one texel, for what [`reach_along`] says of a unit of it.
/// Bounded, so that its square is a number.
#[inline(always)]
pub(crate) fn texel_depth(reach: Vec2) -> f32 {
    let farthest = if reach.x > reach.y { reach.x } else { reach.y };
    1.0 / farthest.clamp(1e-9, 1e9)
}

/// [`LightExtent::half_axis_u`] and [`LightExtent::half_axis_v`] of one face.
fn axes_on(light: &Light, space: &LightSpace, size: u32) -> [Vec4; 2] {
    let projection = space.clip_from_view.as_dmat4();
    let half = f64::from(size) * 0.5;
    let (right, down) = (projection.x_axis.x * half, -projection.y_axis.y * half);
    let per_depth = per_depth(&space.clip_from_view);
    let view_from_world = space.view_from_world.as_dmat4();
    let on_map = |axis: DVec3| {
        let s = view_from_world.transform_vector3(axis);
        (DVec3::new(s.x * right, s.y * down, s.z) * per_depth)
            .as_vec3()
            .extend(0.0)
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
    if half_axis_u.x == 0.0 && half_axis_u.w > 0.0 {
        half_axis_u = Vec4::ZERO;
    }
    let reach = reach(shape(light), half_axis_u, half_axis_v, size);
    half_axis_v.w = if reach > 0.0 {
        half as f32 / reach
    } else {
        1.0
    };
    [half_axis_u, half_axis_v]
}

/// What a unit of clip depth makes of 1/distance (with perspective) or of distance (without), per metre: positive.
fn per_depth(clip_from_view: &Mat4) -> f64 {
    let (a, b) = (
        f64::from(clip_from_view.z_axis.z),
        f64::from(clip_from_view.w_axis.z),
    );
    if clip_from_view.row(3) == Vec4::W {
        -1.0 / a
    } else {
        -1.0 / b
    }
}

/// A light's half axes, world space.
pub(crate) enum HalfAxes {
    /// Of a parallelogram or an ellipse: metres, or tangents for suns.
    Flat(DVec3, DVec3),
    /// A ball's radius.
    Ball(f64),
}

/// `world_from_view` is of the light's map: a sun's axes lie along it.
pub(crate) fn half_axes(light: &Light, world_from_view: &DMat4) -> HalfAxes {
    let disc = |normal: glam::Vec3, radius: f32| {
        let (u, v) = normal
            .as_dvec3()
            .normalize_or(DVec3::Y)
            .any_orthonormal_pair();
        HalfAxes::Flat(u * f64::from(radius), v * f64::from(radius))
    };
    match *light {
        Light::Directional {
            angular_diameter, ..
        } => {
            let tangent = (f64::from(angular_diameter) * 0.5).tan();
            let along = |axis: DVec3| world_from_view.transform_vector3(axis) * tangent;
            HalfAxes::Flat(along(DVec3::X), along(DVec3::Y))
        }
        Light::Spot {
            direction, radius, ..
        } => disc(direction, radius),
        Light::Disc { normal, radius, .. } => disc(normal, radius),
        Light::Rect { half_u, half_v, .. } => HalfAxes::Flat(half_u.as_dvec3(), half_v.as_dvec3()),
        Light::Point { radius, .. } => HalfAxes::Ball(f64::from(radius)),
    }
}

/// The pairs, for the lockstep tests.
pub(crate) const TWINS: &[Twin] = &[
    twin!(LIGHT_EXTENT, light_axes(half_axis_u: Vec4, half_axis_v: Vec4, from_middle: Vec2) -> Vec4),
    twin!(LIGHT_EXTENT, reach_along(square: u32, axes: Vec4) -> Vec2),
    twin!(LIGHT_EXTENT, texel_depth(reach: Vec2) -> f32),
];

#[cfg(test)]
#[path = "light_extent_tests.rs"]
mod tests;
