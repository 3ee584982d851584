//! From a receiver to a texel of a [`ShadowMap`]: what every map technique's kernel begins with, in both halves.

use crate::{
    shading::facing::homogeneous,
    shadow_map::{BeyondFar, Border, MapFormat, ShadowMap, position_error},
};
use glam::{Mat4, Vec2, Vec3, Vec4};
use umbrage_core::{
    ImageView, LightSpaces, MATH, Module, Twin, View,
    math::{cross3, dot3, transform, unit3},
    twin, uniforms,
};

/// The WGSL half. It needs the rest of [`ShadowMapUniforms::modules`].
pub const LOOKUP: Module = Module {
    name: "lookup",
    text: include_str!("lookup.wgsl"),
};
const PLANE: Module = Module {
    name: "plane",
    text: include_str!("plane.wgsl"),
};
const NO_PLANE: Module = Module {
    name: "no_plane",
    text: include_str!("no_plane.wgsl"),
};
const OFFSET: Module = Module {
    name: "offset",
    text: include_str!("offset.wgsl"),
};
const NO_OFFSET: Module = Module {
    name: "no_offset",
    text: include_str!("no_offset.wgsl"),
};

const SINGLE: Module = Module {
    name: "single",
    text: include_str!("single.wgsl"),
};
const CUBE: Module = Module {
    name: "cube",
    text: include_str!("cube.wgsl"),
};

const CLAMPED: Module = Module {
    name: "clamped",
    text: include_str!("clamped.wgsl"),
};
const LIT_BORDER: Module = Module {
    name: "lit_border",
    text: include_str!("lit_border.wgsl"),
};

/// The comparison at one texel of the first image.
pub const TAP: Module = Module {
    name: "tap",
    text: include_str!("tap.wgsl"),
};

/// [`ShadowMapUniforms::deepest_tap`] where no tap is compared deeper than the receiver: nearer than any depth.
pub const NEVER_DEEPER: f32 = f32::MIN;

uniforms! {
    /// What a lookup needs to know, in both halves.
    pub struct ShadowMapUniforms {
        /// 1 or 6. It comes first since it has few values: Mesa's lavapipe (seen in 22.3) compiles a shader that branches on
        /// uniforms anew for every value of their buffer's first word.
        pub layers: u32,
        /// 1 if depth is packed into four channels, else 0.
        pub packed: u32,
        /// 1 if the map's edge repeats, else 0.
        pub clamped: u32,
        /// 1 if the bias has a slope or a normal offset, else 0. Shaders branch on this word and not on the floats below:
        /// software drivers compile a variant for each value that a branch depends on.
        pub has_receiver_bias: u32,
        /// From world to the light's clip space: one matrix, or six in the order of [`Layout::Cube`](umbrage_core::Layout::Cube). Unused ones repeat
        /// the first.
        pub faces: [Mat4; 6],
        /// xyz: unit direction to the light (w = 0) or the light's position (w = 1).
        pub light: Vec4,
        /// Greatest depth that is compared: 1, or without bound.
        pub farthest: f32,
        /// Side of the map, texels.
        pub size: f32,
        /// Longer side of a texel: metres without perspective; metres at one metre's distance with it.
        pub texel: f32,
        /// See [`Bias::constant`](crate::Bias::constant).
        pub constant: f32,
        /// See [`Bias::slope`](crate::Bias::slope).
        pub slope: f32,
        /// See [`Bias::slope_min`](crate::Bias::slope_min).
        pub slope_min: f32,
        /// See [`Bias::normal_offset`](crate::Bias::normal_offset).
        pub normal_offset: f32,
        /// Greatest depth slope, clip depth a texel, that taps follow along the receiver's plane; 0 where they follow none.
        pub receiver_plane: f32,
        /// Clip depth down to which taps on the receiver's plane are compared where the receiver itself is nearer: 1, the far
        /// plane, or [`NEVER_DEEPER`].
        pub deepest_tap: f32,
        /// Share of what the receiver's plane gains over a sample's four texels that is taken off the depth that the sample
        /// compares: 1, or 0 where casters move away instead.
        pub sample_gain: f32,
    }
}

impl ShadowMapUniforms {
    /// The WGSL of `shadow_coord`, `depth_at` and `stored_depth`, with no more in it than this map needs: what is switched off
    /// costs nothing.
    pub fn modules(&self) -> Vec<Module> {
        let plane = if self.receiver_plane > 0.0 {
            PLANE
        } else {
            NO_PLANE
        };
        let offset = if self.normal_offset != 0.0 {
            OFFSET
        } else {
            NO_OFFSET
        };
        let layout = if self.layers > 1 { CUBE } else { SINGLE };
        let lookup = [LOOKUP, plane, offset, layout];
        let border = if self.clamped != 0 {
            CLAMPED
        } else {
            LIT_BORDER
        };
        lookup
            .into_iter()
            .chain(crate::shadow_map::packing::stored(self.packed != 0))
            .chain([border])
            .collect()
    }

    /// The lookup into a map of `view.light` that lies in `spaces`.
    pub fn new(map: &ShadowMap, view: &View<'_>, spaces: &LightSpaces) -> Self {
        let light = homogeneous(view.light);
        let (size, bias, spaces) = (map.size as f32, map.bias, &spaces.spaces);
        let face = |i: usize| spaces[if i < spaces.len() { i } else { 0 }];
        let projection = spaces[0].clip_from_view;
        Self {
            faces: std::array::from_fn(|i| face(i).clip_from_world()),
            light,
            layers: spaces.len() as u32,
            packed: u32::from(map.format == MapFormat::Rgba8),
            clamped: u32::from(map.border == Border::Clamp),
            farthest: if map.beyond_far == BeyondFar::Compared {
                f32::MAX
            } else {
                1.0
            },
            size,
            texel: 2.0 / (projection.x_axis.x.min(projection.y_axis.y) * size),
            has_receiver_bias: u32::from(
                bias.slope != 0.0 || bias.slope_min != 0.0 || bias.normal_offset != 0.0,
            ),
            constant: if bias.covers_rounding() {
                bias.constant.max(position_error::of_positions(&spaces[0]))
            } else {
                bias.constant
            },
            slope: bias.slope,
            slope_min: bias.slope_min,
            normal_offset: bias.normal_offset,
            receiver_plane: bias.plane_limit(),
            deepest_tap: if bias.adaptive { NEVER_DEEPER } else { 1.0 },
            sample_gain: if bias.adaptive { 0.0 } else { 1.0 },
        }
    }

    /// The map for the Rust half.
    pub fn map<'a>(&self, image: &ImageView<'a>) -> DepthMap<'a> {
        DepthMap {
            texels: image.texels,
            size: self.size as i32,
            packed: self.packed != 0,
            clamped: self.clamped != 0,
            sample_gain: self.sample_gain,
        }
    }
}

/// The face of a cube around `light` in which `p` lies: the axis along which it is farthest; ties go to the first.
#[inline(always)]
pub fn cube_face(light: Vec4, p: Vec3) -> i32 {
    let (x, y, z) = (p.x - light.x, p.y - light.y, p.z - light.z);
    let (ax, ay, az) = (x.abs(), y.abs(), z.abs());
    if ax >= ay && ax >= az {
        return if x >= 0.0 { 0 } else { 1 };
    }
    // By the sign bit: the greatest of three is only zero if the first is.
    let negative = |v: f32| (v.to_bits() >> 31) as i32;
    if ay >= az {
        2 + negative(y)
    } else {
        4 + negative(z)
    }
}

/// A receiver, seen from the map.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ShadowCoord {
    /// Texel coordinates, origin top left, centres at .5.
    pub texel: Vec2,
    /// Clip depth to compare with, biased.
    pub depth: f32,
    /// Change of that depth per texel right and down; zero unless the receiver's plane is followed.
    pub gradient: Vec2,
    /// Greatest clip depth that any tap is compared with: not less than `depth`.
    pub deepest: f32,
    /// The map's layer.
    pub layer: i32,
    /// Whether the map can say anything: before the far plane and not behind the light.
    pub seen: bool,
}

/// Unit direction from `p` to the light.
#[inline(always)]
pub fn to_light(light: Vec4, p: Vec3) -> Vec3 {
    if light.w == 0.0 {
        light.truncate()
    } else {
        unit3(light.truncate() - p)
    }
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
#[expect(
    clippy::manual_clamp,
    reason = "`clamp` lets NaN through, and this must bound it as the shader does"
)]
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
    let (a, b) = (
        slide(clip_from_world, clip, t, size),
        slide(clip_from_world, clip, cross3(n, t), size),
    );
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
    Vec3::new(
        (c.x - x * c.w) * half,
        (y * c.w - c.y) * half,
        c.z - z * c.w,
    )
}

/// Moves a receiver along its normal.
#[inline(always)]
fn offset_along_normal(m: &ShadowMapUniforms, layer: i32, p: Vec3, n: Vec3, n_dot_l: f32) -> Vec3 {
    let w = transform(m.faces[layer as usize], p).w;
    let metres = m.normal_offset * sine(n_dot_l) * (m.texel * w);
    Vec3::new(p.x + n.x * metres, p.y + n.y * metres, p.z + n.z * metres)
}

/// From a receiver to the map.
#[inline(always)]
pub fn shadow_coord(m: &ShadowMapUniforms, p: Vec3, n: Vec3) -> ShadowCoord {
    let layer = if m.layers > 1 {
        cube_face(m.light, p)
    } else {
        0
    };
    let clip_from_world = m.faces[layer as usize];
    let (mut p_offset, mut bias) = (p, m.constant);
    if m.has_receiver_bias != 0 {
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
    let depth = t.z - bias;
    let deepest = depth.max(m.deepest_tap);
    let seen = clip.w > 0.0 && t.z <= m.farthest;
    ShadowCoord {
        texel: Vec2::new(t.x, t.y),
        depth,
        gradient,
        deepest,
        layer,
        seen,
    }
}

/// The depth to compare with the texel at (x, y).
#[inline(always)]
pub fn depth_at(l: &ShadowCoord, x: i32, y: i32) -> f32 {
    depth_on_plane(l.depth, l.gradient, l.deepest, l.texel, x, y)
}

/// `depth` moved along `gradient` from `from` to the centre of texel (x, y), but not beyond `deepest`. (What lay before the
/// far plane must stay there, since texels that nothing was drawn to hold 1.)
#[inline(always)]
pub fn depth_on_plane(depth: f32, gradient: Vec2, deepest: f32, from: Vec2, x: i32, y: i32) -> f32 {
    let moved =
        depth + gradient.x * (x as f32 + 0.5 - from.x) + gradient.y * (y as f32 + 0.5 - from.y);
    moved.min(deepest)
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
    /// [`ShadowMapUniforms::sample_gain`].
    pub sample_gain: f32,
}

impl<'a> DepthMap<'a> {
    /// The depth at a texel of the map.
    #[inline(always)]
    pub fn load(&self, x: i32, y: i32, layer: i32) -> f32 {
        let i =
            (layer as usize * self.size as usize + y as usize) * self.size as usize + x as usize;
        if self.packed {
            let c = &self.texels[4 * i..4 * i + 4];
            return crate::shadow_map::packing::unpack_depth(Vec4::new(c[0], c[1], c[2], c[3]));
        }
        self.texels[i]
    }

    /// One layer's depths; none if they are packed.
    #[inline(always)]
    pub fn layer(&self, layer: i32) -> Option<&'a [f32]> {
        let texels = self.size as usize * self.size as usize;
        if self.packed {
            None
        } else {
            self.texels.get(layer as usize * texels..)
        }
    }

    /// Whether the receiver is lit as far as one texel tells, as 1 or 0. Outside the map it is, unless the edge repeats.
    #[inline(always)]
    pub fn tap(&self, l: &ShadowCoord, x: i32, y: i32) -> f32 {
        if x < 0 || y < 0 || x >= self.size || y >= self.size {
            return if self.clamped {
                self.tap_edge(l, x, y)
            } else {
                1.0
            };
        }
        if depth_at(l, x, y) <= self.load(x, y, l.layer) {
            1.0
        } else {
            0.0
        }
    }

    /// The tap at the nearest texel of the map.
    #[inline(never)]
    fn tap_edge(&self, l: &ShadowCoord, x: i32, y: i32) -> f32 {
        let inside = |v: i32| v.clamp(0, self.size - 1);
        if depth_at(l, x, y) <= self.load(inside(x), inside(y), l.layer) {
            1.0
        } else {
            0.0
        }
    }
}

/// The pairs, for the lockstep tests.
pub const TWINS: &[Twin] = &[
    twin!(CUBE, cube_face(light: Vec4, p: Vec3) -> i32, needs [MATH, LOOKUP, PLANE, OFFSET]),
    twin!(LOOKUP, to_light(light: Vec4, p: Vec3) -> Vec3, needs [MATH, PLANE, OFFSET, SINGLE]),
    twin!(LOOKUP, slope_bias(slope: f32, least: f32, n_dot_l: f32) -> f32, needs [MATH, PLANE, OFFSET, SINGLE]),
    twin!(LOOKUP, sine(cosine: f32) -> f32, needs [MATH, PLANE, OFFSET, SINGLE]),
    twin!(LOOKUP, texel_from_clip(clip: Vec4, size: f32) -> Vec3, needs [MATH, PLANE, OFFSET, SINGLE]),
    twin!(PLANE, slide(clip_from_world: Mat4, clip: Vec4, tangent: Vec3, size: f32) -> Vec3, needs [MATH, LOOKUP, OFFSET, SINGLE]),
    twin!(PLANE, plane_gradient(clip_from_world: Mat4, clip: Vec4, n: Vec3, size: f32, limit: f32) -> Vec2, needs [MATH, LOOKUP, OFFSET, SINGLE]),
    twin!(PLANE, depth_on_plane(depth: f32, gradient: Vec2, deepest: f32, from: Vec2, x: i32, y: i32) -> f32, needs [MATH, LOOKUP, OFFSET, SINGLE]),
];
