//! Images that a recipe's stages write and read: shadow maps and filtered maps.

use glam::UVec2;

/// Texel format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Format {
    /// Depth 0..=1 as 32-bit float.
    Depth32,
    /// Depth 0..=1 in steps of 1/65535.
    Depth16,
    /// Wrapping integers 0..=255, written by
    /// [`CastMode::StencilDepthFail`](crate::CastMode::StencilDepthFail).
    Stencil8,
    /// Four channels 0..=1 in steps of 1/255, without sRGB.
    Rgba8,
    /// Two channels 0..=1 in steps of 1/65535, packed into a 32-bit word on GPUs: core WebGPU has
    /// no renderable format with 16-bit normalized channels. Filters round to the nearest step,
    /// halves upwards, with explicit arithmetic.
    Rg16,
    /// Four such channels, in two words.
    Rgba16,
    /// One 32-bit float.
    R32,
    /// Two 32-bit floats.
    Rg32,
    /// Four 32-bit floats.
    Rgba32,
}

impl Format {
    /// Returns the number of floats per texel.
    pub const fn channels(self) -> usize {
        match self {
            Self::Depth32 | Self::Depth16 | Self::Stencil8 | Self::R32 => 1,
            Self::Rg16 | Self::Rg32 => 2,
            Self::Rgba8 | Self::Rgba16 | Self::Rgba32 => 4,
        }
    }

    /// Returns the number of bytes per texel on a GPU. The CPU backend stores every channel as a
    /// 32-bit float, rounded to a value of the format.
    pub const fn bytes(self) -> usize {
        match self {
            Self::Stencil8 => 1,
            Self::Depth16 => 2,
            Self::Depth32 | Self::Rgba8 | Self::Rg16 | Self::R32 => 4,
            Self::Rgba16 | Self::Rg32 => 8,
            Self::Rgba32 => 16,
        }
    }

    /// Returns whether nearest-depth casts write this format.
    pub const fn is_depth(self) -> bool {
        matches!(self, Self::Depth32 | Self::Depth16)
    }

    /// Returns whether only casts write this format, not filters.
    pub const fn is_cast_only(self) -> bool {
        self.is_depth() || matches!(self, Self::Stencil8)
    }

    /// Returns the initial value of texels: 1 for depth, otherwise 0.
    pub const fn start(self) -> f32 {
        if self.is_depth() { 1.0 } else { 0.0 }
    }
}

/// Description of an image. Layers store the light spaces of a layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ImageDesc {
    /// Label for error messages and profilers.
    pub label: &'static str,
    /// Size in texels.
    pub size: UVec2,
    /// Number of layers, at least one.
    pub layers: u32,
    /// Texel format.
    pub format: Format,
}

impl ImageDesc {
    /// Returns the number of texels of all layers.
    pub fn texels(&self) -> u64 {
        u64::from(self.size.x) * u64::from(self.size.y) * u64::from(self.layers)
    }

    /// Returns the number of bytes of all texels on a GPU.
    pub fn bytes(&self) -> u64 {
        self.texels() * self.format.bytes() as u64
    }

    /// Returns the number of floats in [`Image::texels`].
    pub fn floats(&self) -> u64 {
        self.texels() * self.format.channels() as u64
    }
}

/// Contents of an image: layer by layer, rows from the top, channels interleaved.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Size, layers and format.
    pub desc: ImageDesc,
    /// `size.x * size.y * layers * channels` floats.
    pub texels: Vec<f32>,
}

impl Image {
    /// Returns an image filled with `value`.
    pub fn filled_with(desc: ImageDesc, value: f32) -> Self {
        Self {
            desc,
            texels: vec![value; desc.floats() as usize],
        }
    }

    /// Returns a view for reading in kernels.
    pub fn view(&self) -> ImageView<'_> {
        ImageView {
            desc: self.desc,
            texels: &self.texels,
        }
    }

    /// Returns the floats of one layer.
    pub fn layer_mut(&mut self, layer: u32) -> &mut [f32] {
        let n = self.texels.len() / self.desc.layers as usize;
        &mut self.texels[layer as usize * n..][..n]
    }
}

/// View of an image for a kernel's Rust half.
#[derive(Clone, Copy, Debug)]
pub struct ImageView<'a> {
    /// Size, layers and format.
    pub desc: ImageDesc,
    /// See [`Image::texels`].
    pub texels: &'a [f32],
}

impl ImageView<'_> {
    /// Returns the first channel of a texel.
    ///
    /// # Panics
    /// Panics if the texel is outside the image.
    #[inline(always)]
    pub fn load(&self, x: i32, y: i32, layer: u32) -> f32 {
        self.texels[self.index(x, y, layer)]
    }

    /// Returns the index of a texel's first channel in [`ImageView::texels`].
    #[inline(always)]
    pub fn index(&self, x: i32, y: i32, layer: u32) -> usize {
        let row = layer as usize * self.desc.size.y as usize + y as usize;
        (row * self.desc.size.x as usize + x as usize) * self.desc.format.channels()
    }
}
