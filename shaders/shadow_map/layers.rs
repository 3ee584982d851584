//! Layers of a shadow map in kernels: one for a single map, six for a cube, one for each cascade.
//! Each has its own transform, texel size, bias and far bound. Only [`layer_at`] selects a
//! receiver's layer.

use super::{BeyondFar, Border, MapFormat, ShadowMap, cascades::cascade_at, position_error};
use crate::shading::facing::homogeneous;
use glam::{Mat4, Vec3, Vec4};
use umbrage_core::{
    Arrangement, CascadePick, LightSpace, LightSpaces, MAX_CASCADES, Module, View, module, uniforms,
};

/// WGSL half: the structs and `cube_face`.
pub const LAYERS: Module = module!("layers");

/// Maximum number of layers; a cube has six.
pub const MAX_LAYERS: usize = MAX_CASCADES;

/// Value of [`MapLayer::deepest_tap`] if no tap may be compared deeper than the receiver. It is
/// nearer than any depth.
pub const NEVER_DEEPER: f32 = f32::MIN;

uniforms! {
    /// Layer of a shadow map: its light space, and how its depths are compared.
    pub struct MapLayer {
        /// Transform from world space to the light's clip space.
        pub clip_from_world: Mat4,
        /// Longer side of a texel: metres without perspective; metres at a distance of one metre
        /// with perspective.
        pub texel: f32,
        /// Greatest clip depth of receivers that are compared: 1, or unbounded. All others are lit.
        pub far: f32,
        /// Constant part of the bias, clip depth. See [`Bias::constant`](crate::Bias::constant).
        pub constant: f32,
        /// Slope of the bias. See [`Bias::slope`](crate::Bias::slope).
        pub slope: f32,
        /// Lower bound of the slope term. See [`Bias::slope_min`](crate::Bias::slope_min).
        pub slope_min: f32,
        /// Normal offset, texels. See [`Bias::normal_offset`](crate::Bias::normal_offset).
        pub normal_offset: f32,
        /// Greatest depth slope, clip depth per texel, that taps follow along the receiver's plane;
        /// 0 if they follow none.
        pub receiver_plane: f32,
        /// Deepest clip depth of taps on the receiver's plane, unless the receiver itself is
        /// deeper. It is 1, the far plane, or [`NEVER_DEEPER`].
        pub deepest_tap: f32,
        /// Number of texels, each as long as [`texel`](Self::texel) is wide, that fill the layer's
        /// depth from near to far plane. It is 1 with perspective, which cascades don't have.
        pub depth_in_texels: f32,
        /// Upper bound of all compared depths: 1, or unbounded.
        pub deepest: f32,
    }
}

uniforms! {
    /// Data for a lookup in a shadow map, for both languages.
    pub struct ShadowMapUniforms {
        /// Number of layers, 1 to [`MAX_LAYERS`]. It must be first: see `STEADY_FIRST_WORD` in
        /// umbrage-wgpu's drivers.rs.
        pub layer_count: u32,
        /// Set to 1 if depth is packed into four channels, else 0.
        pub packed: u32,
        /// Set to 1 if the map's edge repeats, else 0.
        pub clamped: u32,
        /// Cascades: distance from its edge, texels, within which a layer does not contain a
        /// receiver. It is the reach of the kernel.
        pub pick_reach: f32,
        /// Cascades: number of texels over which the visibilities of two layers blend; 0 disables
        /// blending.
        pub blend: f32,
        /// Layers: one, six in the order of [`Layout::Cube`](umbrage_core::Layout::Cube), or the
        /// cascades from the nearest to the farthest. Unused entries repeat the first.
        pub layers: [MapLayer; MAX_LAYERS],
        /// Unit direction to the light (w = 0) or the light's position (w = 1), world space.
        pub light: Vec4,
        /// Side of each layer, texels.
        pub size: f32,
        /// Fraction of the receiver plane's gain over a sample's four texels that is subtracted
        /// from the compared depth. It is 1, or 0 if casters move away instead.
        pub sample_gain: f32,
    }
}

uniforms! {
    /// Uniforms of kernels that need only the map.
    pub struct MapOnlyUniforms {
        /// Layers of the map and how they are compared.
        pub lookup: ShadowMapUniforms,
    }
}

impl MapLayer {
    /// Returns the layer of `map` for the light space `space`.
    pub fn new(map: &ShadowMap, space: &LightSpace) -> Self {
        let bias = map.bias;
        let projection = space.clip_from_view;
        // The scale of the longer side is the smaller one.
        let scale = projection.x_axis.x.min(projection.y_axis.y);
        let texel = 2.0 / (scale * map.size as f32);
        let constant = if bias.adaptive {
            bias.constant.min(position_error::greatest_constant(space))
        } else {
            bias.constant
        };
        let constant = if bias.covers_rounding() {
            constant.max(position_error::depth_error(space))
        } else {
            constant
        };
        let [far, deepest] = match map.beyond_far {
            BeyondFar::Clamped => [f32::MAX, 1.0],
            BeyondFar::Lit => [1.0, f32::MAX],
            BeyondFar::Compared => [f32::MAX, f32::MAX],
        };
        Self {
            clip_from_world: space.clip_from_world(),
            texel,
            far,
            constant,
            slope: bias.slope,
            slope_min: bias.slope_min,
            normal_offset: bias.normal_offset,
            receiver_plane: bias.plane_limit(),
            deepest_tap: if bias.adaptive { NEVER_DEEPER } else { 1.0 },
            depth_in_texels: depth_in_texels(projection, texel),
            deepest,
        }
    }

    /// Returns whether taps follow the receiver's plane.
    #[inline(always)]
    pub fn follows_plane(&self) -> bool {
        self.receiver_plane > 0.0
    }

    /// Returns whether the bias has a slope or a normal offset.
    #[inline(always)]
    pub fn has_receiver_bias(&self) -> bool {
        self.slope != 0.0 || self.slope_min != 0.0 || self.moves_receivers()
    }

    /// Returns whether receivers are moved along their normals.
    #[inline(always)]
    pub fn moves_receivers(&self) -> bool {
        self.normal_offset != 0.0
    }
}

impl ShadowMapUniforms {
    /// Returns the data for lookups in a map of `view.light` with the light spaces `spaces`.
    ///
    /// Panics if there are no spaces. Panics if there are several that are neither a cube around a
    /// light with a position nor cascades of a directional light.
    pub fn new(map: &ShadowMap, view: &View<'_>, spaces: &LightSpaces) -> Self {
        let bias = map.bias;
        let arrangement = spaces.arrangement;
        let pick = match arrangement {
            Arrangement::Single | Arrangement::Cube => CascadePick::default(),
            Arrangement::Cascades(pick) => pick,
        };
        let spaces = &spaces.spaces;
        let uniforms = Self {
            layer_count: spaces.len() as u32,
            packed: u32::from(map.format == MapFormat::Rgba8),
            clamped: u32::from(map.border == Border::Clamp),
            pick_reach: pick.reach,
            blend: pick.blend,
            layers: std::array::from_fn(|i| {
                // Unused layers repeat the first.
                let space = spaces.get(i).unwrap_or(&spaces[0]);
                MapLayer::new(map, space)
            }),
            light: homogeneous(view.light),
            size: map.size as f32,
            sample_gain: if bias.adaptive { 0.0 } else { 1.0 },
        };
        // Shaders and lookups derive the arrangement from the number of layers and the light.
        let is_known = spaces.len() == 1 || uniforms.arrangement() == arrangement;
        assert!(is_known, "{arrangement:?} under {:?}", view.light);
        uniforms
    }

    /// Returns the index of the layer in which a receiver at `position` (world space) is looked up
    /// first.
    pub fn layer_of(&self, position: Vec3) -> u32 {
        layer_at(self, position) as u32
    }

    /// Returns how receivers select their layer.
    #[inline(always)]
    pub fn arrangement(&self) -> Arrangement {
        if self.layer_count == 1 {
            return Arrangement::Single;
        }
        // Directional lights have cascades, others cubes: only a position has w = 1.
        if self.light.w != 0.0 {
            return Arrangement::Cube;
        }
        Arrangement::Cascades(CascadePick {
            reach: self.pick_reach,
            blend: self.blend,
        })
    }

    /// Returns whether the visibilities of two layers blend.
    #[inline(always)]
    pub fn blends(&self) -> bool {
        matches!(self.arrangement(), Arrangement::Cascades(pick) if pick.blend > 0.0)
    }

    /// Returns the layers that are used.
    #[inline(always)]
    pub fn used_layers(&self) -> &[MapLayer] {
        &self.layers[..self.layer_count as usize]
    }
}

/// Returns [`MapLayer::depth_in_texels`] for texels of this side.
fn depth_in_texels(clip_from_view: Mat4, texel: f32) -> f32 {
    let is_orthographic = clip_from_view.row(3) == Vec4::W;
    if is_orthographic {
        1.0 / (clip_from_view.z_axis.z.abs() * texel)
    } else {
        1.0
    }
}

/// Returns the index of the layer in which a receiver at `p` (world space) is looked up. Twin of
/// `layer_at` in layer_pick.wgsl.
#[inline(always)]
pub fn layer_at(m: &ShadowMapUniforms, p: Vec3) -> i32 {
    match m.arrangement() {
        Arrangement::Single => 0,
        Arrangement::Cube => cube_face(m.light, p),
        Arrangement::Cascades(_) => cascade_at(m, p),
    }
}

/// Returns the face of a cube around `light` that contains `p`: that of the axis along which `p` is
/// farthest. Ties select the first face.
#[inline(always)]
pub fn cube_face(light: Vec4, p: Vec3) -> i32 {
    let x = p.x - light.x;
    let y = p.y - light.y;
    let z = p.z - light.z;
    let ax = x.abs();
    let ay = y.abs();
    let az = z.abs();
    if ax >= ay && ax >= az {
        return if x >= 0.0 { 0 } else { 1 };
    }
    // Use the sign bit: the greatest of three is zero only if the first is.
    if ay >= az {
        2 + sign_bit(y)
    } else {
        4 + sign_bit(z)
    }
}

/// Returns 1 for negative numbers and -0, else 0.
#[inline(always)]
fn sign_bit(v: f32) -> i32 {
    (v.to_bits() >> 31) as i32
}

/// All twins of this module, for the tests that compare them.
#[cfg(feature = "testing")]
pub const TWINS: &[umbrage_core::Twin] =
    &[umbrage_core::twin!(LAYERS, cube_face(light: Vec4, p: Vec3) -> i32, needs [])];
