//! Images that a recipe's stages write and read: shadow maps and what is filtered from them.

use glam::UVec2;

/// What a texel holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Format {
    /// Depth 0..=1 in 32-bit floats: the only format that a cast can write.
    Depth32,
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
            Self::Depth32 | Self::R32 => 1,
            Self::Rg32 => 2,
            Self::Rgba32 => 4,
        }
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
    /// Bytes of all its texels.
    pub fn bytes(&self) -> u64 {
        u64::from(self.size.x) * u64::from(self.size.y) * u64::from(self.layers) * self.format.channels() as u64 * 4
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
        Self { desc, texels: vec![value; (desc.bytes() / 4) as usize] }
    }

    /// For reading in kernels.
    pub fn view(&self) -> ImageView<'_> {
        ImageView { desc: self.desc, texels: &self.texels }
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
    /// If it doesn't.
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
