//! What all techniques with a shadow map share: the map, its fit and bias, and the way from a receiver to a texel.
//!
//! Williams 1978, "Casting curved shadows on curved surfaces": draw the scene's depth as the light sees it; a point is
//! lit if, seen from the light, nothing nearer was drawn at its texel. Points outside the map, beyond its far plane or
//! behind the light are lit.

use crate::Bias;
use glam::{Mat4, UVec2, Vec2, Vec3, Vec4};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use umbrage_core::{
    Cast, Fit, Format, ImageDesc, Invalid, LightSpace, MATH, Module, PlanError, Receive, ReceiveKernel, Recipe, Twin,
    View,
    math::{cross3, dot3, transform, unit3},
    twin, uniforms,
};

/// The WGSL half. It needs the rest of [`MapLookup::modules`].
pub const SHADOW_MAP: Module = Module { name: "shadow_map", text: include_str!("shadow_map.wgsl") };
const PLANE: Module = Module { name: "plane", text: include_str!("plane.wgsl") };
const NO_PLANE: Module = Module { name: "no_plane", text: include_str!("no_plane.wgsl") };
const OFFSET: Module = Module { name: "offset", text: include_str!("offset.wgsl") };
const NO_OFFSET: Module = Module { name: "no_offset", text: include_str!("no_offset.wgsl") };

/// The comparison at one texel of the first image.
pub const TAP: Module = Module { name: "tap", text: include_str!("tap.wgsl") };

/// A square depth map from one light space.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ShadowMap {
    /// Side, texels.
    pub size: u32,
    /// Where it lies.
    pub fit: Fit,
    /// What keeps receivers from shadowing themselves.
    pub bias: Bias,
}

impl Default for ShadowMap {
    fn default() -> Self {
        Self { size: 1024, fit: Fit::Tight, bias: Bias::SLOPE }
    }
}

impl ShadowMap {
    /// A few words for tables.
    pub fn label(&self) -> String {
        let fit = if self.fit == Fit::Tight { "" } else { ", manual fit" };
        format!("{}{fit}, {}", self.size, self.bias.label())
    }

    /// The recipe of a technique that draws one map and looks it up with `kernel`, which reaches `reach` texels beyond
    /// the receiver's own.
    pub(crate) fn recipe<K: ReceiveKernel + 'static>(
        &self,
        view: &View<'_>,
        reach: f32,
        kernel: impl FnOnce(MapLookup) -> K,
    ) -> Result<Recipe, PlanError> {
        self.validate()?;
        view.light.validate()?;
        let space = self.fit.light_space(view, self.size, reach + self.bias.normal_offset.abs())?;
        let map = ImageDesc { label: "shadow map", size: UVec2::splat(self.size), layers: 1, format: Format::Depth32 };
        Ok(Recipe {
            images: vec![map],
            tables: Vec::new(),
            casts: vec![Cast { image: 0, layer: 0, space, cull: self.bias.cull, bias: self.bias.raster }],
            filters: Vec::new(),
            receive: Receive {
                kernel: Arc::new(kernel(MapLookup::new(self, view, &space))),
                inputs: vec![0],
                tables: Vec::new(),
            },
            keep_images: false,
        })
    }

    fn validate(&self) -> Result<(), Invalid> {
        if self.size == 0 {
            return Err(Invalid::new("shadow map", "has a side of 0 texels", "use 1 or more, such as 1024"));
        }
        self.bias.validate().map_err(|e| e.within("shadow map"))
    }
}

uniforms! {
    /// What a lookup needs to know, in both halves.
    pub struct MapLookup {
        /// From world to the light's clip space.
        pub clip_from_world: Mat4,
        /// xyz: unit direction to the light (w = 0) or the light's position (w = 1).
        pub light: Vec4,
        /// Side of the map, texels.
        pub size: f32,
        /// Longer side of a texel: metres without perspective; metres at one metre's distance with it.
        pub texel: f32,
        /// See [`Bias::constant`].
        pub constant: f32,
        /// See [`Bias::slope`].
        pub slope: f32,
        /// See [`Bias::slope_min`].
        pub slope_min: f32,
        /// See [`Bias::normal_offset`].
        pub normal_offset: f32,
        /// See [`Bias::receiver_plane`].
        pub receiver_plane: f32,
    }
}

impl MapLookup {
    /// The WGSL of `look_up` and `depth_at`, with no more in it than this bias needs: what is switched off costs nothing.
    pub fn modules(&self) -> [Module; 3] {
        let plane = if self.receiver_plane > 0.0 { PLANE } else { NO_PLANE };
        let offset = if self.normal_offset != 0.0 { OFFSET } else { NO_OFFSET };
        [SHADOW_MAP, plane, offset]
    }

    /// The lookup into a map of `view.light` that lies in `space`.
    pub fn new(map: &ShadowMap, view: &View<'_>, space: &LightSpace) -> Self {
        let light = match view.light.position() {
            Some(p) => p.extend(1.0),
            None => view.light.direction_from(Vec3::ZERO).extend(0.0),
        };
        let (size, bias) = (map.size as f32, map.bias);
        Self {
            clip_from_world: space.clip_from_world(),
            light,
            size,
            texel: 2.0 / (space.clip_from_view.x_axis.x.min(space.clip_from_view.y_axis.y) * size),
            constant: bias.constant,
            slope: bias.slope,
            slope_min: bias.slope_min,
            normal_offset: bias.normal_offset,
            receiver_plane: bias.receiver_plane,
        }
    }
}

/// A receiver, seen from the map.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lookup {
    /// Texel coordinates, origin top left, centres at .5.
    pub texel: Vec2,
    /// Clip depth to compare with, biased.
    pub depth: f32,
    /// Change of that depth per texel right and down; zero unless the receiver's plane is followed.
    pub gradient: Vec2,
    /// Whether the map can say anything: before the far plane and not behind the light.
    pub seen: bool,
}

/// Unit direction from `p` to the light.
#[inline(always)]
pub fn to_light(light: Vec4, p: Vec3) -> Vec3 {
    if light.w == 0.0 { light.truncate() } else { unit3(light.truncate() - p) }
}

/// Slope-scaled receiver bias, clip depth: `max(slope (1 - n.l), least)`.
#[inline(always)]
pub fn slope_bias(slope: f32, least: f32, n_dot_l: f32) -> f32 {
    (slope * (1.0 - n_dot_l)).max(least)
}

/// Sine of the angle of incidence from its cosine.
#[inline(always)]
pub fn sine(cosine: f32) -> f32 {
    (1.0 - cosine * cosine).max(0.0).sqrt()
}

/// Texel coordinates and depth from clip space.
#[inline(always)]
#[expect(clippy::manual_clamp, reason = "`clamp` lets NaN through, and this must bound it as the shader does")]
pub fn texel_from_clip(clip: Vec4, size: f32) -> Vec3 {
    let (x, y, z) = (clip.x / clip.w, clip.y / clip.w, clip.z / clip.w);
    // Bounded, so that conversion to integers means the same everywhere.
    let (u, v) = ((x * 0.5 + 0.5) * size, (0.5 - y * 0.5) * size);
    Vec3::new(u.min(1e6).max(-1e6), v.min(1e6).max(-1e6), z)
}

/// Depth change per texel, right and down, along the plane with normal `n` through the point at `clip`: a projection
/// maps planes to planes, so two tangents and a two-by-two system give it exactly. Zero for a plane seen edge-on, and
/// never beyond `limit`.
#[inline(always)]
pub fn plane_gradient(clip_from_world: Mat4, clip: Vec4, n: Vec3, size: f32, limit: f32) -> Vec2 {
    let axis = if n.x.abs() < 0.6 { Vec3::X } else { Vec3::Y };
    let t = cross3(n, axis);
    let (a, b) = (slide(clip_from_world, clip, t, size), slide(clip_from_world, clip, cross3(n, t), size));
    let det = a.x * b.y - b.x * a.y;
    if det == 0.0 {
        return Vec2::ZERO;
    }
    let (gx, gy) = ((a.z * b.y - b.z * a.y) / det, (a.x * b.z - b.x * a.z) / det);
    Vec2::new(gx.min(limit).max(-limit), gy.min(limit).max(-limit))
}

/// How texel coordinates and depth change along a world-space tangent, times the point's clip w (which cancels).
#[inline(always)]
pub fn slide(clip_from_world: Mat4, clip: Vec4, tangent: Vec3, size: f32) -> Vec3 {
    let m = clip_from_world;
    let c = m.x_axis * tangent.x + m.y_axis * tangent.y + m.z_axis * tangent.z;
    let half = size * 0.5;
    let (x, y, z) = (clip.x / clip.w, clip.y / clip.w, clip.z / clip.w);
    Vec3::new((c.x - x * c.w) * half, (y * c.w - c.y) * half, c.z - z * c.w)
}

/// Moves a receiver along its normal.
#[inline(always)]
fn offset_along_normal(m: &MapLookup, p: Vec3, n: Vec3, n_dot_l: f32) -> Vec3 {
    let w = transform(m.clip_from_world, p).w;
    let metres = m.normal_offset * sine(n_dot_l) * (m.texel * w);
    Vec3::new(p.x + n.x * metres, p.y + n.y * metres, p.z + n.z * metres)
}

/// From a receiver to the map.
#[inline(always)]
pub fn look_up(m: &MapLookup, p: Vec3, n: Vec3) -> Lookup {
    let (mut p_offset, mut bias) = (p, m.constant);
    if m.slope != 0.0 || m.slope_min != 0.0 || m.normal_offset != 0.0 {
        let n_dot_l = dot3(n, to_light(m.light, p));
        bias += slope_bias(m.slope, m.slope_min, n_dot_l);
        if m.normal_offset != 0.0 {
            p_offset = offset_along_normal(m, p, n, n_dot_l);
        }
    }
    let clip = transform(m.clip_from_world, p_offset);
    let t = texel_from_clip(clip, m.size);
    let mut gradient = Vec2::ZERO;
    if m.receiver_plane > 0.0 {
        gradient = plane_gradient(m.clip_from_world, clip, n, m.size, m.receiver_plane);
    }
    Lookup { texel: Vec2::new(t.x, t.y), depth: t.z - bias, gradient, seen: clip.w > 0.0 && t.z <= 1.0 }
}

/// The depth to compare with the texel at (x, y).
#[inline(always)]
pub fn depth_at(l: &Lookup, x: i32, y: i32) -> f32 {
    depth_on_plane(l.depth, l.gradient, l.texel, x, y)
}

/// `depth` moved along `gradient` from `from` to the centre of texel (x, y).
#[inline(always)]
pub fn depth_on_plane(depth: f32, gradient: Vec2, from: Vec2, x: i32, y: i32) -> f32 {
    depth + gradient.x * (x as f32 + 0.5 - from.x) + gradient.y * (y as f32 + 0.5 - from.y)
}

/// Whether the receiver is lit as far as one texel tells, as 1 or 0. Outside the map it is.
#[inline(always)]
pub fn tap(texels: &[f32], size: i32, l: &Lookup, x: i32, y: i32) -> f32 {
    if x < 0 || y < 0 || x >= size || y >= size {
        return 1.0;
    }
    let stored = texels[y as usize * size as usize + x as usize];
    if depth_at(l, x, y) <= stored { 1.0 } else { 0.0 }
}

/// The pairs, for the lockstep tests.
pub const TWINS: &[Twin] = &[
    twin!(SHADOW_MAP, to_light(light: Vec4, p: Vec3) -> Vec3, needs [MATH, PLANE, OFFSET]),
    twin!(SHADOW_MAP, slope_bias(slope: f32, least: f32, n_dot_l: f32) -> f32, needs [MATH, PLANE, OFFSET]),
    twin!(SHADOW_MAP, sine(cosine: f32) -> f32, needs [MATH, PLANE, OFFSET]),
    twin!(SHADOW_MAP, texel_from_clip(clip: Vec4, size: f32) -> Vec3, needs [MATH, PLANE, OFFSET]),
    twin!(PLANE, slide(clip_from_world: Mat4, clip: Vec4, tangent: Vec3, size: f32) -> Vec3, needs [MATH, SHADOW_MAP, OFFSET]),
    twin!(PLANE, plane_gradient(clip_from_world: Mat4, clip: Vec4, n: Vec3, size: f32, limit: f32) -> Vec2, needs [MATH, SHADOW_MAP, OFFSET]),
    twin!(PLANE, depth_on_plane(depth: f32, gradient: Vec2, from: Vec2, x: i32, y: i32) -> f32, needs [MATH, SHADOW_MAP, OFFSET]),
];
