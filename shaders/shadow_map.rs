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
    Cast, CastMode, Filter, Fit, Format, ImageDesc, ImageId, ImageView, Invalid, Layout, LightSpaces, MATH, Module,
    PlanError, Receive, ReceiveKernel, Recipe, Twin, View,
    math::{cross3, dot3, transform, unit3},
    twin, uniforms,
};

/// The WGSL half. It needs the rest of [`MapLookup::modules`].
pub const SHADOW_MAP: Module = Module { name: "shadow_map", text: include_str!("shadow_map.wgsl") };
const PLANE: Module = Module { name: "plane", text: include_str!("plane.wgsl") };
const NO_PLANE: Module = Module { name: "no_plane", text: include_str!("no_plane.wgsl") };
const OFFSET: Module = Module { name: "offset", text: include_str!("offset.wgsl") };
const NO_OFFSET: Module = Module { name: "no_offset", text: include_str!("no_offset.wgsl") };

const SINGLE: Module = Module { name: "single", text: include_str!("single.wgsl") };
const CUBE: Module = Module { name: "cube", text: include_str!("cube.wgsl") };

const CLAMPED: Module = Module { name: "clamped", text: include_str!("clamped.wgsl") };
const LIT_BORDER: Module = Module { name: "lit_border", text: include_str!("lit_border.wgsl") };

/// The comparison at one texel of the first image.
pub const TAP: Module = Module { name: "tap", text: include_str!("tap.wgsl") };

/// Which depth a map keeps of the surfaces that its texels show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Surface {
    /// The nearest surface's.
    #[default]
    Nearest,
    /// The mean of the nearest two: see [`Midpoint`](crate::Midpoint).
    Midpoint,
}

/// How a map stores depth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MapFormat {
    /// 32-bit floats.
    #[default]
    Depth32,
    /// 16 bits: half the memory, steps of 1/65535.
    Depth16,
    /// Four 8-bit channels, for devices that cannot read depth images: see [`packing`](crate::packing).
    Rgba8,
}

/// What a lookup beside the map finds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Border {
    /// Nothing: it is lit, as if the map had a border of depth 1.
    #[default]
    Lit,
    /// The nearest texel of the map's edge, repeated: casters at the edge throw shadow bands without end.
    Clamp,
}

/// What becomes of receivers beyond the map's far plane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BeyondFar {
    /// They are lit.
    #[default]
    Lit,
    /// They are compared as all others; no stored depth is beyond 1, so they are dark.
    Compared,
}

/// Square depth maps of a light, one a light space.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ShadowMap {
    /// Side, texels.
    pub size: u32,
    /// Where it lies.
    pub fit: Fit,
    /// What keeps receivers from shadowing themselves.
    pub bias: Bias,
    /// One space or six.
    pub layout: Layout,
    /// Which depth is kept.
    pub surface: Surface,
    /// How it is stored.
    pub format: MapFormat,
    /// What lies beside it.
    pub border: Border,
    /// What lies behind it.
    pub beyond_far: BeyondFar,
}

impl Default for ShadowMap {
    fn default() -> Self {
        Self {
            size: 1024,
            fit: Fit::Tight,
            bias: Bias::SLOPE,
            layout: Layout::Auto,
            surface: Surface::Nearest,
            format: MapFormat::Depth32,
            border: Border::Lit,
            beyond_far: BeyondFar::Lit,
        }
    }
}

impl ShadowMap {
    /// A few words for tables.
    pub fn label(&self) -> String {
        let mut words = vec![self.size.to_string()];
        let others = [
            (self.fit != Fit::Tight, "manual fit"),
            (self.layout == Layout::Single, "one map"),
            (self.layout == Layout::Cube, "cube"),
            (self.surface == Surface::Midpoint, "midpoint"),
            (self.format == MapFormat::Depth16, "16 bit"),
            (self.format == MapFormat::Rgba8, "rgba8"),
            (self.border == Border::Clamp, "edge repeated"),
            (self.beyond_far == BeyondFar::Compared, "dark beyond far"),
        ];
        words.extend(others.into_iter().filter_map(|(on, word)| on.then(|| word.to_owned())));
        words.push(self.bias.label());
        words.join(", ")
    }

    /// The light spaces for a kernel that reaches `reach` texels beyond the receiver's own.
    ///
    /// # Errors
    /// As [`Fit::light_spaces`]; and `Invalid` for bad parameters.
    pub fn spaces(&self, view: &View<'_>, reach: f32) -> Result<LightSpaces, PlanError> {
        self.validate()?;
        view.light.validate()?;
        self.fit.light_spaces(self.layout, view, self.size, reach + self.bias.normal_offset.abs())
    }

    /// The images, casts and filters that make the map: a recipe still without its lookup. The map to look up is the last
    /// image: of depth, or `R32` ([`Surface::Midpoint`]), or `Rgba8` ([`MapFormat::Rgba8`]).
    pub fn maps(&self, spaces: &LightSpaces) -> Maps {
        let depth = if self.format == MapFormat::Depth16 { Format::Depth16 } else { Format::Depth32 };
        let mut maps = Maps::default();
        let nearest = maps.image(self.desc("shadow map", depth, spaces));
        self.cast(&mut maps, spaces, nearest, CastMode::Nearest);
        if self.surface == Surface::Midpoint {
            let second = maps.image(self.desc("second depth", depth, spaces));
            self.cast(&mut maps, spaces, second, CastMode::Behind(nearest));
            let middle = maps.image(self.desc("midpoint", Format::R32, spaces));
            maps.filter(crate::midpoint::between(), vec![nearest, second], middle);
        }
        if self.format == MapFormat::Rgba8 {
            let packed = maps.image(self.desc("packed depth", Format::Rgba8, spaces));
            maps.filter(crate::packing::pack(), vec![packed - 1], packed);
        }
        maps
    }

    fn desc(&self, label: &'static str, format: Format, spaces: &LightSpaces) -> ImageDesc {
        ImageDesc { label, size: UVec2::splat(self.size), layers: spaces.spaces.len() as u32, format }
    }

    fn cast(&self, maps: &mut Maps, spaces: &LightSpaces, image: ImageId, mode: CastMode) {
        let needed = (0..).zip(&spaces.spaces).zip(&spaces.needed).filter(|(_, needed)| **needed);
        // Peeling compares depths of one surface with itself, which a bias would part.
        let bias = if self.surface == Surface::Midpoint { Default::default() } else { self.bias.raster };
        maps.casts.extend(needed.map(|((layer, &space), _)| Cast {
            mode,
            cull: self.bias.cull,
            bias,
            ..Cast::nearest(image, layer, space)
        }));
    }

    /// The recipe of a technique that draws maps and looks them up with `kernel`, which reaches `reach` texels beyond the
    /// receiver's own.
    pub(crate) fn recipe<K: ReceiveKernel + 'static>(
        &self,
        view: &View<'_>,
        reach: f32,
        kernel: impl FnOnce(MapLookup) -> K,
    ) -> Result<Recipe, PlanError> {
        let spaces = self.spaces(view, reach)?;
        Ok(self.maps(&spaces).recipe(kernel(MapLookup::new(self, view, &spaces))))
    }

    fn validate(&self) -> Result<(), Invalid> {
        if self.size == 0 {
            return Err(Invalid::new("shadow map", "has a side of 0 texels", "use 1 or more, such as 1024"));
        }
        self.bias.validate().map_err(|e| e.within("shadow map"))
    }
}

/// What makes a map: see [`ShadowMap::maps`].
#[derive(Clone, Debug, Default)]
pub struct Maps {
    /// As [`Recipe::images`].
    pub images: Vec<ImageDesc>,
    /// As [`Recipe::casts`].
    pub casts: Vec<Cast>,
    /// As [`Recipe::filters`].
    pub filters: Vec<Filter>,
}

impl Maps {
    fn image(&mut self, desc: ImageDesc) -> ImageId {
        self.images.push(desc);
        self.images.len() - 1
    }

    fn filter(&mut self, kernel: Arc<dyn umbrage_core::FilterKernel>, inputs: Vec<ImageId>, output: ImageId) {
        self.filters.push(Filter { kernel, inputs, tables: Vec::new(), output });
    }

    /// The recipe that looks up the last image alone.
    pub fn recipe<K: ReceiveKernel + 'static>(self, kernel: K) -> Recipe {
        let inputs = vec![self.images.len() - 1];
        Recipe {
            images: self.images,
            tables: Vec::new(),
            casts: self.casts,
            filters: self.filters,
            receive: Receive { kernel: Arc::new(kernel), inputs, tables: Vec::new() },
            shade: None,
            keep_images: false,
        }
    }
}

uniforms! {
    /// What a lookup needs to know, in both halves.
    pub struct MapLookup {
        /// From world to the light's clip space: one matrix, or six in the order of [`Layout::Cube`]. Unused ones repeat
        /// the first.
        pub faces: [Mat4; 6],
        /// For each face what turns depth into distance along its axis: see [`distance_at`].
        pub distances: [Vec4; 6],
        /// xyz: unit direction to the light (w = 0) or the light's position (w = 1).
        pub light: Vec4,
        /// 1 or 6.
        pub layers: u32,
        /// 1 if depth is packed into four channels, else 0.
        pub packed: u32,
        /// 1 if the map's edge repeats, else 0.
        pub clamped: u32,
        /// Greatest depth that is compared: 1, or without bound.
        pub farthest: f32,
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
    /// The WGSL of `look_up`, `depth_at` and `stored_depth`, with no more in it than this map needs: what is switched off
    /// costs nothing.
    pub fn modules(&self) -> Vec<Module> {
        let plane = if self.receiver_plane > 0.0 { PLANE } else { NO_PLANE };
        let offset = if self.normal_offset != 0.0 { OFFSET } else { NO_OFFSET };
        let layout = if self.layers > 1 { CUBE } else { SINGLE };
        let lookup = [SHADOW_MAP, plane, offset, layout];
        let border = if self.clamped != 0 { CLAMPED } else { LIT_BORDER };
        lookup.into_iter().chain(crate::packing::stored(self.packed != 0)).chain([border]).collect()
    }

    /// The lookup into a map of `view.light` that lies in `spaces`.
    pub fn new(map: &ShadowMap, view: &View<'_>, spaces: &LightSpaces) -> Self {
        let light = match view.light.position() {
            Some(p) => p.extend(1.0),
            None => view.light.direction_from(Vec3::ZERO).extend(0.0),
        };
        let (size, bias, spaces) = (map.size as f32, map.bias, &spaces.spaces);
        let face = |i: usize| spaces[if i < spaces.len() { i } else { 0 }];
        let projection = spaces[0].clip_from_view;
        Self {
            faces: std::array::from_fn(|i| face(i).clip_from_world()),
            distances: std::array::from_fn(|i| distances(&face(i).clip_from_view)),
            light,
            layers: spaces.len() as u32,
            packed: u32::from(map.format == MapFormat::Rgba8),
            clamped: u32::from(map.border == Border::Clamp),
            farthest: if map.beyond_far == BeyondFar::Compared { f32::MAX } else { 1.0 },
            size,
            texel: 2.0 / (projection.x_axis.x.min(projection.y_axis.y) * size),
            constant: bias.constant,
            slope: bias.slope,
            slope_min: bias.slope_min,
            normal_offset: bias.normal_offset,
            receiver_plane: bias.receiver_plane,
        }
    }

    /// The map for the Rust half.
    pub fn map<'a>(&self, image: &ImageView<'a>) -> DepthMap<'a> {
        DepthMap { texels: image.texels, size: self.size as i32, packed: self.packed != 0, clamped: self.clamped != 0 }
    }
}

/// See [`MapLookup::distances`].
fn distances(clip_from_view: &Mat4) -> Vec4 {
    let (a, b) = (clip_from_view.z_axis.z, clip_from_view.w_axis.z);
    let perspective = if clip_from_view.row(3) == Vec4::W { 0.0 } else { 1.0 };
    Vec4::new(a, b, perspective, 0.0)
}

/// Distance along the map's axis, metres, from clip depth: `b / (depth + a)` with perspective, `(b - depth) / a` without,
/// where `m` is (a, b, 1 or 0, unused).
#[inline(always)]
pub fn distance_at(m: Vec4, depth: f32) -> f32 {
    if m.z != 0.0 { m.y / (depth + m.x) } else { (m.y - depth) / m.x }
}

/// The face of a cube around `light` in which `p` lies: the axis along which it is farthest; ties go to the first.
#[inline(always)]
pub fn cube_face(light: Vec4, p: Vec3) -> i32 {
    let (x, y, z) = (p.x - light.x, p.y - light.y, p.z - light.z);
    let (ax, ay, az) = (x.abs(), y.abs(), z.abs());
    if ax >= ay && ax >= az {
        return if x >= 0.0 { 0 } else { 1 };
    }
    if ay >= az {
        return if y >= 0.0 { 2 } else { 3 };
    }
    if z >= 0.0 { 4 } else { 5 }
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
    /// The map's layer.
    pub layer: i32,
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
fn offset_along_normal(m: &MapLookup, layer: i32, p: Vec3, n: Vec3, n_dot_l: f32) -> Vec3 {
    let w = transform(m.faces[layer as usize], p).w;
    let metres = m.normal_offset * sine(n_dot_l) * (m.texel * w);
    Vec3::new(p.x + n.x * metres, p.y + n.y * metres, p.z + n.z * metres)
}

/// From a receiver to the map.
#[inline(always)]
pub fn look_up(m: &MapLookup, p: Vec3, n: Vec3) -> Lookup {
    let layer = if m.layers > 1 { cube_face(m.light, p) } else { 0 };
    let clip_from_world = m.faces[layer as usize];
    let (mut p_offset, mut bias) = (p, m.constant);
    if m.slope != 0.0 || m.slope_min != 0.0 || m.normal_offset != 0.0 {
        let n_dot_l = dot3(n, to_light(m.light, p));
        bias += slope_bias(m.slope, m.slope_min, n_dot_l);
        if m.normal_offset != 0.0 {
            p_offset = offset_along_normal(m, layer, p, n, n_dot_l);
        }
    }
    let clip = transform(clip_from_world, p_offset);
    let t = texel_from_clip(clip, m.size);
    let mut gradient = Vec2::ZERO;
    if m.receiver_plane > 0.0 {
        gradient = plane_gradient(clip_from_world, clip, n, m.size, m.receiver_plane);
    }
    Lookup { texel: Vec2::new(t.x, t.y), depth: t.z - bias, gradient, layer, seen: clip.w > 0.0 && t.z <= m.farthest }
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

/// A map, as kernels' Rust halves read it.
#[derive(Clone, Copy, Debug)]
pub struct DepthMap<'a> {
    /// All layers.
    pub texels: &'a [f32],
    /// Side, texels.
    pub size: i32,
    /// Whether each depth takes four channels.
    pub packed: bool,
    /// Whether its edge repeats.
    pub clamped: bool,
}

impl<'a> DepthMap<'a> {
    /// The depth at a texel of the map.
    #[inline(always)]
    pub fn load(&self, x: i32, y: i32, layer: i32) -> f32 {
        let i = (layer as usize * self.size as usize + y as usize) * self.size as usize + x as usize;
        if self.packed {
            let c = &self.texels[4 * i..4 * i + 4];
            return crate::packing::unpack_depth(Vec4::new(c[0], c[1], c[2], c[3]));
        }
        self.texels[i]
    }

    /// One layer's depths; none if they are packed.
    #[inline(always)]
    pub fn layer(&self, layer: i32) -> Option<&'a [f32]> {
        let texels = self.size as usize * self.size as usize;
        if self.packed { None } else { self.texels.get(layer as usize * texels..) }
    }

    /// Whether the receiver is lit as far as one texel tells, as 1 or 0. Outside the map it is, unless the edge repeats.
    #[inline(always)]
    pub fn tap(&self, l: &Lookup, x: i32, y: i32) -> f32 {
        if x < 0 || y < 0 || x >= self.size || y >= self.size {
            return if self.clamped { self.tap_edge(l, x, y) } else { 1.0 };
        }
        if depth_at(l, x, y) <= self.load(x, y, l.layer) { 1.0 } else { 0.0 }
    }

    /// The tap at the nearest texel of the map.
    #[inline(never)]
    fn tap_edge(&self, l: &Lookup, x: i32, y: i32) -> f32 {
        let inside = |v: i32| v.clamp(0, self.size - 1);
        if depth_at(l, x, y) <= self.load(inside(x), inside(y), l.layer) { 1.0 } else { 0.0 }
    }
}

/// The pairs, for the lockstep tests.
pub const TWINS: &[Twin] = &[
    twin!(SHADOW_MAP, distance_at(m: Vec4, depth: f32) -> f32, needs [MATH, PLANE, OFFSET, SINGLE]),
    twin!(CUBE, cube_face(light: Vec4, p: Vec3) -> i32, needs [MATH, SHADOW_MAP, PLANE, OFFSET]),
    twin!(SHADOW_MAP, to_light(light: Vec4, p: Vec3) -> Vec3, needs [MATH, PLANE, OFFSET, SINGLE]),
    twin!(SHADOW_MAP, slope_bias(slope: f32, least: f32, n_dot_l: f32) -> f32, needs [MATH, PLANE, OFFSET, SINGLE]),
    twin!(SHADOW_MAP, sine(cosine: f32) -> f32, needs [MATH, PLANE, OFFSET, SINGLE]),
    twin!(SHADOW_MAP, texel_from_clip(clip: Vec4, size: f32) -> Vec3, needs [MATH, PLANE, OFFSET, SINGLE]),
    twin!(PLANE, slide(clip_from_world: Mat4, clip: Vec4, tangent: Vec3, size: f32) -> Vec3, needs [MATH, SHADOW_MAP, OFFSET, SINGLE]),
    twin!(PLANE, plane_gradient(clip_from_world: Mat4, clip: Vec4, n: Vec3, size: f32, limit: f32) -> Vec2, needs [MATH, SHADOW_MAP, OFFSET, SINGLE]),
    twin!(PLANE, depth_on_plane(depth: f32, gradient: Vec2, from: Vec2, x: i32, y: i32) -> f32, needs [MATH, SHADOW_MAP, OFFSET, SINGLE]),
];
