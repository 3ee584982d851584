//! A recipe's images on the GPU.

use crate::counters::Maker;
use glam::UVec2;
use umbrage_core::{Format, ImageDesc};
use wgpu::{
    Extent3d, Texture, TextureDescriptor, TextureDimension, TextureFormat, TextureUsages, TextureView,
    TextureViewDescriptor, TextureViewDimension,
};

/// The wgpu format of a recipe's image.
pub const fn texture_format(format: Format) -> TextureFormat {
    match format {
        Format::Depth32 => TextureFormat::Depth32Float,
        Format::R32 => TextureFormat::R32Float,
        Format::Rg32 => TextureFormat::Rg32Float,
        Format::Rgba32 => TextureFormat::Rgba32Float,
    }
}

/// One image.
#[derive(Debug)]
pub(crate) struct GpuImage {
    pub(crate) desc: ImageDesc,
    pub(crate) texture: Texture,
    /// All layers, for kernels.
    pub(crate) whole: TextureView,
    /// Each layer, for drawing.
    pub(crate) layers: Vec<TextureView>,
}

impl GpuImage {
    pub(crate) fn new(maker: &mut Maker<'_>, desc: ImageDesc) -> Self {
        let texture = maker.texture(&TextureDescriptor {
            label: Some(desc.label),
            size: extent(desc.size, desc.layers),
            mip_level_count: 1,
            sample_count: 1,
            dimension: TextureDimension::D2,
            format: texture_format(desc.format),
            usage: usage(desc.format),
            view_formats: &[],
        });
        let dimension = if desc.layers > 1 { TextureViewDimension::D2Array } else { TextureViewDimension::D2 };
        let view = |dimension, first, count| {
            texture.create_view(&TextureViewDescriptor {
                label: Some(desc.label),
                dimension: Some(dimension),
                base_array_layer: first,
                array_layer_count: Some(count),
                ..TextureViewDescriptor::default()
            })
        };
        let layers = (0..desc.layers).map(|layer| view(TextureViewDimension::D2, layer, 1)).collect();
        Self { desc, whole: view(dimension, 0, desc.layers), layers, texture }
    }
}

/// Copying serves tests, which replay a stage from given images and look at what came out.
fn usage(format: Format) -> TextureUsages {
    let all = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_SRC;
    if format == Format::Depth32 { all } else { all | TextureUsages::COPY_DST }
}

pub(crate) fn extent(size: UVec2, layers: u32) -> Extent3d {
    Extent3d { width: size.x, height: size.y, depth_or_array_layers: layers }
}

/// Makes `held` match the list; what was held and has an equal description is used again.
pub(crate) fn fit_images(maker: &mut Maker<'_>, held: &mut Vec<GpuImage>, wanted: &[ImageDesc]) {
    let mut old = std::mem::take(held);
    *held = wanted
        .iter()
        .map(|&desc| match old.iter().position(|image| image.desc == desc) {
            Some(i) => old.swap_remove(i),
            None => GpuImage::new(maker, desc),
        })
        .collect();
}
