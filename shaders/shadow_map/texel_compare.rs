//! Comparison of a receiver with one texel of a shadow map: the stored depth, the compared depth,
//! and texels outside the map.

use super::{coord::ShadowCoord, layers::ShadowMapUniforms, packing::unpack_depth};
use glam::{Vec2, Vec4};
use umbrage_core::{ImageView, Module, module};

/// The WGSL half: `tap` and `depth_at`. It reads the kernel's first image, and needs the modules
/// [`COORD`](super::coord::COORD), [`DEPTH_ON_PLANE`], `stored_depth.wgsl` and the map's constants.
pub const TEXEL_COMPARE: Module = module!("texel_compare");

/// Functions of [`TEXEL_COMPARE`] that read no image.
pub const DEPTH_ON_PLANE: Module = module!("depth_on_plane");

/// WGSL of `stored_depth`. It reads the kernel's first image.
pub(crate) const STORED_DEPTH: Module = module!("stored_depth");

/// Returns the depth to compare with the texel at (x, y).
#[inline(always)]
pub fn depth_at(l: &ShadowCoord, x: i32, y: i32) -> f32 {
    depth_on_plane(l.depth, l.gradient, l.deepest, l.texel, x, y)
}

/// Returns `depth` moved along `gradient` from `from` to the centre of texel (x, y), but not beyond
/// `deepest`. (A depth before the far plane must stay there, since texels without geometry hold 1.)
#[inline(always)]
pub fn depth_on_plane(depth: f32, gradient: Vec2, deepest: f32, from: Vec2, x: i32, y: i32) -> f32 {
    depth_at_texel(
        depth,
        gradient,
        deepest,
        from,
        Vec2::new(x as f32, y as f32),
    )
}

/// Returns [`depth_on_plane`] at a texel whose integer coordinates are stored as floats. This saves
/// conversions in loops over many receivers.
#[inline(always)]
pub(crate) fn depth_at_texel(
    depth: f32,
    gradient: Vec2,
    deepest: f32,
    from: Vec2,
    texel: Vec2,
) -> f32 {
    let right = gradient.x * (texel.x + 0.5 - from.x);
    let down = gradient.y * (texel.y + 0.5 - from.y);
    (depth + right + down).min(deepest)
}

/// Texels of a shadow map, as read by the Rust halves of kernels.
#[derive(Clone, Copy, Debug)]
pub struct DepthMap<'a> {
    /// Texels of all layers, row by row.
    pub texels: &'a [f32],
    /// Side, texels.
    pub size: i32,
    /// True if each depth occupies four channels.
    pub packed: bool,
    /// True if the map's edge repeats; otherwise receivers outside it are lit.
    pub clamped: bool,
    /// Value of [`ShadowMapUniforms::sample_gain`].
    pub sample_gain: f32,
}

impl ShadowMapUniforms {
    /// Returns the map for the Rust half.
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

impl<'a> DepthMap<'a> {
    /// Returns the index of a layer's first texel.
    #[inline(always)]
    pub fn first_texel(&self, layer: i32) -> usize {
        layer as usize * self.size as usize * self.size as usize
    }

    /// Returns the depth at a texel of an unpacked map, by its index among all texels; `None`
    /// beyond the last.
    #[inline(always)]
    pub(crate) fn plain_depth(&self, index: usize) -> Option<f32> {
        self.texels.get(index).copied()
    }

    /// Returns the depth at a texel of a packed map, like [`plain_depth`](Self::plain_depth).
    #[inline(always)]
    pub(crate) fn packed_depth(&self, index: usize) -> Option<f32> {
        let channels = self.texels.get(4 * index..)?.first_chunk()?;
        Some(unpack_depth(Vec4::from_array(*channels)))
    }

    /// Returns the depth at a texel of the map.
    ///
    /// Panics if there is no such texel.
    #[inline(always)]
    pub fn load(&self, x: i32, y: i32, layer: i32) -> f32 {
        let row = layer as usize * self.size as usize + y as usize;
        let index = row * self.size as usize + x as usize;
        if self.packed {
            let c = &self.texels[4 * index..4 * index + 4];
            return unpack_depth(Vec4::new(c[0], c[1], c[2], c[3]));
        }
        self.texels[index]
    }

    /// Returns the depths from the start of a layer to the end of the map; `None` if they are
    /// packed.
    #[inline(always)]
    pub fn layer(&self, layer: i32) -> Option<&'a [f32]> {
        if self.packed {
            None
        } else {
            self.texels.get(self.first_texel(layer)..)
        }
    }

    /// Returns whether a texel is on the map.
    #[inline(always)]
    pub fn has(&self, x: i32, y: i32) -> bool {
        x >= 0 && y >= 0 && x < self.size && y < self.size
    }

    /// Returns 1 if the receiver is lit according to one texel, else 0. Outside the map it is lit,
    /// unless the edge repeats.
    #[inline(always)]
    pub fn tap(&self, l: &ShadowCoord, x: i32, y: i32) -> f32 {
        if !self.has(x, y) {
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

    /// Returns the result of the tap at the nearest texel of the map.
    #[inline(never)]
    fn tap_edge(&self, l: &ShadowCoord, x: i32, y: i32) -> f32 {
        let last = self.size - 1;
        let stored = self.load(x.clamp(0, last), y.clamp(0, last), l.layer);
        if depth_at(l, x, y) <= stored {
            1.0
        } else {
            0.0
        }
    }
}

/// All twins of this module, for the tests that compare them.
#[cfg(feature = "testing")]
pub const TWINS: &[umbrage_core::Twin] = &[
    umbrage_core::twin!(DEPTH_ON_PLANE, depth_on_plane(depth: f32, gradient: Vec2, deepest: f32, from: Vec2, x: i32, y: i32) -> f32, needs []),
];
