//! Images that a recipe's stages write and read: shadow maps and what is filtered from them.

use glam::UVec2;

/// What a texel holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Format {
    /// Depth 0..=1 in 32-bit floats.
    Depth32,
    /// Depth 0..=1 in steps of 1/65535.
    Depth16,
    /// Whole numbers 0..=255, which wrap: what
    /// [`CastMode::StencilDepthFail`](crate::CastMode::StencilDepthFail) writes.
    Stencil8,
    /// Four channels 0..=1 in steps of 1/255, without sRGB.
    Rgba8,
    /// Two channels 0..=1 in steps of 1/65535, which share a 32-bit word on GPUs: no format of core
    /// WebGPU that is drawn into has channels of 16 bits in whole steps. Filters write the nearest
    /// step, halves upwards, by arithmetic that is written out.
    Rg16,
    /// Four of them, in two words.
    Rgba16,
    /// One 32-bit float.
    R32,
    /// Two 32-bit floats.
    Rg32,
    /// Four 32-bit floats.
    Rgba32,
}

impl Format {
    /// Floats a texel.
    pub const fn channels(self) -> usize {
        match self {
            Self::Depth32 | Self::Depth16 | Self::Stencil8 | Self::R32 => 1,
            Self::Rg16 | Self::Rg32 => 2,
            Self::Rgba8 | Self::Rgba16 | Self::Rgba32 => 4,
        }
    }

    /// Bytes a texel takes on a GPU. The CPU backend holds every channel as a 32-bit float that has
    /// one of the values that the format can hold.
    pub const fn bytes(self) -> usize {
        match self {
            Self::Stencil8 => 1,
            Self::Depth16 => 2,
            Self::Depth32 | Self::Rgba8 | Self::Rg16 | Self::R32 => 4,
            Self::Rgba16 | Self::Rg32 => 8,
            Self::Rgba32 => 16,
        }
    }

    /// Whether casts of the nearest depth write it.
    pub const fn is_depth(self) -> bool {
        matches!(self, Self::Depth32 | Self::Depth16)
    }

    /// Whether casts alone write it: filters can't.
    pub const fn is_cast_only(self) -> bool {
        self.is_depth() || matches!(self, Self::Stencil8)
    }

    /// What texels hold before anything is written: 1 for depth, else 0.
    pub const fn start(self) -> f32 {
        if self.is_depth() { 1.0 } else { 0.0 }
    }
}

/// An image to be made. Layers hold the light spaces of a layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ImageDesc {
    /// For error messages and profilers.
    pub label: &'static str,
    /// Texels.
    pub size: UVec2,
    /// One or more.
    pub layers: u32,
    /// What a texel holds.
    pub format: Format,
}

impl ImageDesc {
    /// Texels of all its layers.
    pub fn texels(&self) -> u64 {
        u64::from(self.size.x) * u64::from(self.size.y) * u64::from(self.layers)
    }

    /// Bytes of all its texels on a GPU.
    pub fn bytes(&self) -> u64 {
        self.texels() * self.format.bytes() as u64
    }

    /// How many floats [`Image::texels`] has.
    pub fn floats(&self) -> u64 {
        self.texels() * self.format.channels() as u64
    }
}

/// An image's contents: layers one after the other, rows from the top, channels interleaved.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Size, layers and format.
    pub desc: ImageDesc,
    /// `size.x * size.y * layers * channels` floats.
    pub texels: Vec<f32>,
}

impl Image {
    /// An image whose every float is `value`.
    pub fn filled(desc: ImageDesc, value: f32) -> Self {
        Self {
            desc,
            texels: vec![value; desc.floats() as usize],
        }
    }

    /// For reading in kernels.
    pub fn view(&self) -> ImageView<'_> {
        ImageView {
            desc: self.desc,
            texels: &self.texels,
        }
    }

    /// The floats of one layer.
    pub fn layer_mut(&mut self, layer: u32) -> &mut [f32] {
        let n = self.texels.len() / self.desc.layers as usize;
        &mut self.texels[layer as usize * n..][..n]
    }
}

/// An image seen by a kernel's Rust half.
#[derive(Clone, Copy, Debug)]
pub struct ImageView<'a> {
    /// Size, layers and format.
    pub desc: ImageDesc,
    /// As [`Image::texels`].
    pub texels: &'a [f32],
}

impl ImageView<'_> {
    /// The first channel of a texel that lies within the image.
    ///
    /// # Panics
    /// Panics if it doesn't.
    #[inline(always)]
    pub fn load(&self, x: i32, y: i32, layer: u32) -> f32 {
        self.texels[self.index(x, y, layer)]
    }

    /// Where a texel's channels start in [`ImageView::texels`].
    #[inline(always)]
    pub fn index(&self, x: i32, y: i32, layer: u32) -> usize {
        let row = layer as usize * self.desc.size.y as usize + y as usize;
        (row * self.desc.size.x as usize + x as usize) * self.desc.format.channels()
    }
}
