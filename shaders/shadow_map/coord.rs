//! Projection of a receiver to a texel of a shadow map, the first step of every map technique's
//! kernel, in both languages.
//!
//! The functions take and return plain numbers, so that compilers can vectorise loops over them.
//! [`lanes::batch`](crate::lanes::batch) calls them in such loops, for many receivers at a time.

use super::layers::{MapLayer, ShadowMapUniforms, layer_at};
use glam::{Mat4, Vec2, Vec3, Vec4};
use umbrage_core::{
    Module,
    math::{cross3, dot3, unit3},
    module,
};

/// The WGSL half. It needs the modules [`MATH`](umbrage_core::MATH),
/// [`LAYERS`](super::layers::LAYERS) and [`PROJECTION`], `layer_pick.wgsl` and the map's constants
/// (`variants.rs`).
pub const COORD: Module = module!("coord");

/// Functions without images or uniforms, called by [`COORD`]; their WGSL is `projection.wgsl`.
pub const PROJECTION: Module = module!("projection");

/// Coordinates of a receiver on the map, and the depth that is compared there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ShadowCoord {
    /// Texel coordinates, origin top left, centres at .5.
    pub texel: Vec2,
    /// Clip depth, biased. The compared one is at most `deepest`.
    pub depth: f32,
    /// Change of that depth per texel right (x) and down (y); zero unless taps follow the
    /// receiver's plane.
    pub gradient: Vec2,
    /// Upper bound of the depth along the receiver's plane: see [`deepest_depth`].
    pub deepest: f32,
    /// Index of the map's layer.
    pub layer: i32,
    /// True if the receiver is in front of the light and not beyond the far bound; otherwise it is
    /// lit.
    pub covered: bool,
}

impl ShadowCoord {
    /// Returns the clip depth to compare at the receiver itself. Twin of `own_depth` in coord.wgsl.
    #[inline(always)]
    pub fn own_depth(&self) -> f32 {
        self.depth.min(self.deepest)
    }
}

/// Returns the unit direction from `p` to the light: see [`ShadowMapUniforms::light`].
///
/// If `light.w` is 0, `light.xyz` is the unit direction to the light. If it is 1, `light.xyz` is
/// the light's position.
#[inline(always)]
pub fn to_light(light: Vec4, p: Vec3) -> Vec3 {
    if light.w == 0.0 {
        light.truncate()
    } else {
        unit3(light.truncate() - p)
    }
}

/// Returns the slope-scaled receiver bias, clip depth: `max(slope (1 - n.l), slope_min)`.
#[inline(always)]
pub fn slope_bias(slope: f32, slope_min: f32, n_dot_l: f32) -> f32 {
    (slope * (1.0 - n_dot_l)).max(slope_min)
}

/// Returns the sine of the angle of incidence from its cosine.
#[inline(always)]
pub fn sine(cosine: f32) -> f32 {
    (1.0 - cosine * cosine).max(0.0).sqrt()
}

/// Returns a row of the matrix times a point, summed from left to right.
#[inline(always)]
fn row(m: &Mat4, i: usize, p: Vec3) -> f32 {
    let x = m.x_axis[i] * p.x;
    let y = m.y_axis[i] * p.y;
    let z = m.z_axis[i] * p.z;
    x + y + z + m.w_axis[i]
}

/// Returns the clip w of a point: metres before the light with perspective, otherwise 1.
#[inline(always)]
pub fn clip_w(clip_from_world: &Mat4, p: Vec3) -> f32 {
    row(clip_from_world, 3, p)
}

/// Returns a point's clip coordinates divided by its clip `w`.
#[inline(always)]
pub fn point_over_w(clip_from_world: &Mat4, p: Vec3, w: f32) -> Vec3 {
    Vec3::new(
        row(clip_from_world, 0, p) / w,
        row(clip_from_world, 1, p) / w,
        row(clip_from_world, 2, p) / w,
    )
}

/// Returns texel coordinates (x, y) and the unchanged depth (z) from clip coordinates divided by w.
#[inline(always)]
#[expect(
    clippy::manual_clamp,
    reason = "`clamp` lets NaN through, and this must bound it as the shader does"
)]
pub fn texel_from_point(point: Vec3, size: f32) -> Vec3 {
    let u = (point.x * 0.5 + 0.5) * size;
    let v = (0.5 - point.y * 0.5) * size;
    // Clamp the coordinates, so that conversion to integers has the same result on every device.
    Vec3::new(u.min(1e6).max(-1e6), v.min(1e6).max(-1e6), point.z)
}

/// Returns the depth change per texel, right and down, along the receiver's plane.
///
/// The plane has the normal `n` and passes through `point`, clip coordinates divided by w. A
/// projection maps planes to planes, so two tangents and a two-by-two system give the exact result.
/// The result is zero for a plane that the light views edge-on. Each component is clamped to
/// -limit..=limit.
#[inline(always)]
pub fn plane_gradient(clip_from_world: Mat4, point: Vec3, n: Vec3, size: f32, limit: f32) -> Vec2 {
    let along_x = n.x.abs() < 0.6;
    let axis = Vec3::new(
        if along_x { 1.0 } else { 0.0 },
        if along_x { 0.0 } else { 1.0 },
        0.0,
    );
    let t = cross3(n, axis);
    let a = slide(clip_from_world, point, t, size);
    let b = slide(clip_from_world, point, cross3(n, t), size);
    let det = a.x * b.y - b.x * a.y;
    let right = (a.z * b.y - b.z * a.y) / det;
    let down = (a.x * b.z - b.x * a.z) / det;
    // Clamp both before the selection: arithmetic inside a branch would prevent vectorisation.
    let right = clamp_gradient(right, limit);
    let down = clamp_gradient(down, limit);
    let longest = a.x.abs().max(a.y.abs()).max(b.x.abs().max(b.y.abs()));
    let edge_on = det.abs() <= EDGE_ON * longest * longest;
    Vec2::new(
        if edge_on { 0.0 } else { right },
        if edge_on { 0.0 } else { down },
    )
}

/// Relative threshold of the determinant, 2^-20, below which the light is in the plane. It is
/// scaled by the longest slide's square. Rounding alone gives up to 12 * 2^-24 in maps four times
/// as wide as high, with a sign that differs between devices.
const EDGE_ON: f32 = 1.0 / 1_048_576.0;

/// Returns `g` clamped to -limit..=limit, and `limit` for NaN.
#[inline(always)]
fn clamp_gradient(g: f32, limit: f32) -> f32 {
    let g = if g < limit { g } else { limit };
    if g > -limit { g } else { -limit }
}

/// Returns the change of texel coordinates and depth along a world-space tangent, times the point's
/// clip w.
///
/// The factor w cancels in [`plane_gradient`]: both sides of its quotients contain w squared.
#[inline(always)]
pub fn slide(clip_from_world: Mat4, point: Vec3, tangent: Vec3, size: f32) -> Vec3 {
    let x = row_along(&clip_from_world, 0, tangent);
    let y = row_along(&clip_from_world, 1, tangent);
    let z = row_along(&clip_from_world, 2, tangent);
    let w = row_along(&clip_from_world, 3, tangent);
    let half = size * 0.5;
    // Use the quotient rule: the change of x / w is (x' - (x / w) w') / w. Omit the last division.
    Vec3::new(
        (x - point.x * w) * half,
        (point.y * w - y) * half,
        z - point.z * w,
    )
}

/// Returns a row of the matrix times a direction, summed from left to right.
#[inline(always)]
fn row_along(m: &Mat4, i: usize, direction: Vec3) -> f32 {
    let x = m.x_axis[i] * direction.x;
    let y = m.y_axis[i] * direction.y;
    let z = m.z_axis[i] * direction.z;
    x + y + z
}

/// Returns a receiver moved along its normal by `normal_offset` texels, times the sine of the angle
/// of incidence.
///
/// The width of a texel is that at the receiver.
#[inline(always)]
pub fn offset_along_normal(layer: &MapLayer, p: Vec3, n: Vec3, n_dot_l: f32) -> Vec3 {
    let texel = layer.texel * clip_w(&layer.clip_from_world, p);
    let metres = layer.normal_offset * sine(n_dot_l) * texel;
    Vec3::new(p.x + n.x * metres, p.y + n.y * metres, p.z + n.z * metres)
}

/// Returns the map coordinates of a receiver at `p` with the unit normal `n` (world space).
#[inline(always)]
pub fn shadow_coord(m: &ShadowMapUniforms, p: Vec3, n: Vec3) -> ShadowCoord {
    shadow_coord_in(layer_at(m, p), m, p, n)
}

/// Returns the coordinates of a receiver in the layer `index`, independent of [`layer_at`].
///
/// Panics if there is no such layer.
#[inline(always)]
pub fn shadow_coord_in(index: i32, m: &ShadowMapUniforms, p: Vec3, n: Vec3) -> ShadowCoord {
    let layer = &m.layers[index as usize];
    // Bias the receiver.
    let mut moved = p;
    let mut bias = layer.constant;
    if layer.has_receiver_bias() {
        let n_dot_l = dot3(n, to_light(m.light, p));
        bias += slope_bias(layer.slope, layer.slope_min, n_dot_l);
        if layer.moves_receivers() {
            moved = offset_along_normal(layer, p, n, n_dot_l);
        }
    }
    // Project it to the map.
    let w = clip_w(&layer.clip_from_world, moved);
    let point = point_over_w(&layer.clip_from_world, moved, w);
    let texel = texel_from_point(point, m.size);
    // Follow its plane.
    let mut gradient = Vec2::ZERO;
    if layer.follows_plane() {
        gradient = plane_gradient(
            layer.clip_from_world,
            point,
            n,
            m.size,
            layer.receiver_plane,
        );
    }
    let depth = point.z - bias;
    ShadowCoord {
        texel: Vec2::new(texel.x, texel.y),
        depth,
        gradient,
        deepest: deepest_depth(layer, depth),
        layer: index,
        covered: is_covered(layer, point.z, w),
    }
}

/// Returns the greatest depth that is compared for a receiver of this depth: the greater of it and
/// [`MapLayer::deepest_tap`], but at most [`MapLayer::deepest`]. For the adaptive bias it is the
/// receiver's depth, if that is before the far plane.
#[inline(always)]
pub fn deepest_depth(layer: &MapLayer, depth: f32) -> f32 {
    depth.max(layer.deepest_tap).min(layer.deepest)
}

/// Returns whether a point with this clip depth and clip w is in front of the light and not beyond
/// the layer's far bound.
#[inline(always)]
pub fn is_covered(layer: &MapLayer, depth: f32, w: f32) -> bool {
    w > 0.0 && depth <= layer.far
}

/// All twins of this module, for the tests that compare them.
#[cfg(feature = "testing")]
pub const TWINS: &[umbrage_core::Twin] = &[
    umbrage_core::twin!(PROJECTION, to_light(light: Vec4, p: Vec3) -> Vec3, needs [umbrage_core::MATH, super::layers::LAYERS]),
    umbrage_core::twin!(PROJECTION, slope_bias(slope: f32, slope_min: f32, n_dot_l: f32) -> f32, needs [umbrage_core::MATH, super::layers::LAYERS]),
    umbrage_core::twin!(PROJECTION, sine(cosine: f32) -> f32, needs [umbrage_core::MATH, super::layers::LAYERS]),
    umbrage_core::twin!(PROJECTION, texel_from_point(point: Vec3, size: f32) -> Vec3, needs [umbrage_core::MATH, super::layers::LAYERS]),
    umbrage_core::twin!(PROJECTION, slide(clip_from_world: Mat4, point: Vec3, tangent: Vec3, size: f32) -> Vec3, needs [umbrage_core::MATH, super::layers::LAYERS]),
    umbrage_core::twin!(PROJECTION, plane_gradient(clip_from_world: Mat4, point: Vec3, n: Vec3, size: f32, limit: f32) -> Vec2, needs [umbrage_core::MATH, super::layers::LAYERS]),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shadow_map::{BeyondFar, ShadowMap, texel_compare::depth_on_plane};
    use umbrage_core::{
        Extents, LightSpace,
        light_space::{look_along, orthographic},
        math::transform,
    };

    fn layer(beyond_far: BeyondFar) -> MapLayer {
        let map = ShadowMap {
            beyond_far,
            ..ShadowMap::default()
        };
        let space = LightSpace {
            view_from_world: Mat4::IDENTITY,
            clip_from_view: Mat4::IDENTITY,
        };
        MapLayer::new(&map, &space)
    }

    /// Texels without casters hold 1, all others less. Clamped receivers beyond the far plane are
    /// therefore hidden by exactly the casters of their texel.
    #[test]
    fn receivers_beyond_the_far_plane_are_compared_on_it() {
        let clamped = layer(BeyondFar::Clamped);
        let slope = Vec2::new(0.3, -0.2);
        for depth in [1.01, 1.4, 3.0, 1e6, f32::MAX] {
            assert!(is_covered(&clamped, depth, 1.0));
            let deepest = deepest_depth(&clamped, depth);
            assert_eq!(deepest, 1.0);
            let tap = |x, y| depth_on_plane(depth, slope, deepest, Vec2::ZERO, x, y);
            assert!(tap(2, -2) == 1.0 && tap(-2, 2) <= 1.0);
            let l = ShadowCoord {
                depth,
                deepest,
                ..ShadowCoord::default()
            };
            assert_eq!(l.own_depth(), 1.0);
            assert!(!is_covered(&layer(BeyondFar::Lit), depth, 1.0));
            // No texel is that deep.
            let compared = layer(BeyondFar::Compared);
            assert!(is_covered(&compared, depth, 1.0) && deepest_depth(&compared, depth) > 1.0);
        }
        // Before the far plane, all settings are equal.
        for beyond_far in [BeyondFar::Lit, BeyondFar::Clamped, BeyondFar::Compared] {
            let layer = layer(beyond_far);
            for depth in [-0.5, 0.0, 0.7, 1.0] {
                assert!(is_covered(&layer, depth, 1.0));
                assert_eq!(deepest_depth(&layer, depth), depth);
            }
            assert!(!is_covered(&layer, f32::NAN, 1.0) && !is_covered(&layer, 0.5, -1.0));
        }
    }

    /// Rounding gives a nonzero determinant for planes that contain the light. It must not give a
    /// gradient.
    #[test]
    fn planes_seen_edge_on_have_no_gradient() {
        for i in 1..3000 {
            let at = |n: f32| (i as f32 * n).sin();
            let direction = Vec3::new(at(0.7), at(1.3) - 1.5, at(2.9)).normalize();
            let view = look_along(Vec3::new(3.0, 9.0, at(0.3)), direction, Vec3::Z);
            let view = view.expect("a direction");
            let aspect = [0.25, 1.0, 4.0][i % 3];
            let map = orthographic(Extents {
                left: -9.0 * aspect,
                right: 9.0 * aspect,
                bottom: -9.0,
                top: 9.0,
                near: 0.1,
                far: 40.0,
            });
            let clip_from_world = map.expect("extents in order") * view;
            let right = Vec3::new(view.x_axis.x, view.y_axis.x, view.z_axis.x);
            let up = Vec3::new(view.x_axis.y, view.y_axis.y, view.z_axis.y);
            let random = (at(0.37) * right + at(0.77) * up).normalize();
            let clip = transform(clip_from_world, Vec3::new(at(1.1), 0.3, at(1.9)));
            let point = clip.truncate() / clip.w;
            let gradient = |n: Vec3| plane_gradient(clip_from_world, point, n, 1024.0, 1.0);
            for n in [right, up, random] {
                assert_eq!(gradient(n), Vec2::ZERO, "{i}: {n}");
                // Half a degree off, the gradient is nonzero.
                let inclined = (n - 0.01 * direction).normalize();
                assert_ne!(gradient(inclined), Vec2::ZERO, "{i}: {inclined}");
            }
        }
    }
}
