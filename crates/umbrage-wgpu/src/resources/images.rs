//! A recipe's images on the GPU.

use crate::resources::{counters::ResourceFactory, counts::CountingPair};
use glam::UVec2;
use std::ops::Range;
use umbrage_core::{Format, ImageDesc};
use wgpu::{
    Extent3d, Texture, TextureAspect, TextureFormat, TextureUsages, TextureView,
    TextureViewDescriptor, TextureViewDimension,
};

/// Returns the wgpu format of a recipe's image. Counting casts are an exception: their image and
/// its depth image share one texture of `Depth32FloatStencil8`.
pub const fn texture_format(format: Format) -> TextureFormat {
    match format {
        Format::Depth32 => TextureFormat::Depth32Float,
        Format::Depth16 => TextureFormat::Depth16Unorm,
        Format::Stencil8 => TextureFormat::Stencil8,
        Format::Rgba8 => TextureFormat::Rgba8Unorm,
        Format::Rg16 => TextureFormat::R32Uint,
        Format::Rgba16 => TextureFormat::Rg32Uint,
        Format::R32 => TextureFormat::R32Float,
        Format::Rg32 => TextureFormat::Rg32Float,
        Format::Rgba32 => TextureFormat::Rgba32Float,
    }
}

/// One image.
#[derive(Clone, Debug)]
pub(crate) struct GpuImage {
    pub(crate) desc: ImageDesc,
    pub(crate) texture: Texture,
    /// Aspect of a texture that two images share; otherwise all aspects.
    pub(crate) aspect: TextureAspect,
    /// All layers, for kernels.
    pub(crate) whole: TextureView,
    /// Each layer, for drawing into.
    pub(crate) layers: Vec<TextureView>,
    /// Each layer, for reading.
    pub(crate) reads: Vec<TextureView>,
}

impl GpuImage {
    fn new(factory: &mut ResourceFactory<'_>, desc: ImageDesc, usage: TextureUsages) -> Self {
        let texture = make_texture(factory, &desc, texture_format(desc.format), usage);
        Self::part(texture, desc, TextureAspect::All)
    }

    /// Returns a depth image and an image of counts in one texture.
    fn new_pair(
        factory: &mut ResourceFactory<'_>,
        depth: ImageDesc,
        counts: ImageDesc,
    ) -> [Self; 2] {
        let format = TextureFormat::Depth32FloatStencil8;
        let texture = make_texture(factory, &depth, format, usage(format, false));
        let depth = Self::part(texture.clone(), depth, TextureAspect::DepthOnly);
        let counts = Self::part(texture, counts, TextureAspect::StencilOnly);
        [depth, counts]
    }

    /// Returns an image in some layers of a texture, beginning at `first`.
    pub(crate) fn window(texture: Texture, desc: ImageDesc, first: u32) -> Self {
        Self::in_layers(texture, desc, TextureAspect::All, first)
    }

    fn part(texture: Texture, desc: ImageDesc, aspect: TextureAspect) -> Self {
        Self::in_layers(texture, desc, aspect, 0)
    }

    fn in_layers(texture: Texture, desc: ImageDesc, aspect: TextureAspect, first: u32) -> Self {
        let dimension = if desc.layers > 1 {
            TextureViewDimension::D2Array
        } else {
            TextureViewDimension::D2
        };
        let layers = first..first + desc.layers;
        let whole = layers_view(&texture, desc.label, dimension, aspect, layers);
        // Attachments must have all aspects of a texture.
        let layers = layer_views(&texture, &desc, TextureAspect::All, first);
        let reads = if aspect == TextureAspect::All {
            layers.clone()
        } else {
            layer_views(&texture, &desc, aspect, first)
        };
        Self {
            desc,
            aspect,
            whole,
            layers,
            reads,
            texture,
        }
    }
}

/// Returns a view of each layer of an image that begins at the texture's layer `first`.
fn layer_views(
    texture: &Texture,
    desc: &ImageDesc,
    aspect: TextureAspect,
    first: u32,
) -> Vec<TextureView> {
    let view = |layer| {
        let dimension = TextureViewDimension::D2;
        layers_view(texture, desc.label, dimension, aspect, layer..layer + 1)
    };
    (first..first + desc.layers).map(view).collect()
}

/// Returns a view of a range of layers of a texture.
pub(crate) fn layers_view(
    texture: &Texture,
    label: &str,
    dimension: TextureViewDimension,
    aspect: TextureAspect,
    layers: Range<u32>,
) -> TextureView {
    texture.create_view(&TextureViewDescriptor {
        label: Some(label),
        dimension: Some(dimension),
        aspect,
        base_array_layer: layers.start,
        array_layer_count: Some(layers.end - layers.start),
        ..TextureViewDescriptor::default()
    })
}

/// Creates a texture for the layers of several images.
pub(crate) fn layered_texture(factory: &mut ResourceFactory<'_>, desc: &ImageDesc) -> Texture {
    let format = texture_format(desc.format);
    // Layers are copied from others of the same format, including depth. Compute filters store
    // moments.
    let holds_moments = matches!(
        desc.format,
        Format::Rg16 | Format::Rgba16 | Format::Rg32 | Format::Rgba32
    );
    let usage = usage(format, holds_moments) | TextureUsages::COPY_DST;
    factory.texture(desc.label, extent(desc.size, desc.layers), format, usage)
}

fn make_texture(
    factory: &mut ResourceFactory<'_>,
    desc: &ImageDesc,
    format: TextureFormat,
    usage: TextureUsages,
) -> Texture {
    let size = extent(desc.size, desc.layers);
    factory.texture(desc.label, size, format, usage)
}

/// Returns the usage of a texture. Tests need copies, to replay a stage from given images and to
/// inspect its output. Data can't be copied to 32-bit depth. `is_stored` is true for outputs of
/// compute passes; others don't get this usage, which may turn off compression.
fn usage(format: TextureFormat, is_stored: bool) -> TextureUsages {
    let mut all =
        TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_SRC;
    if !format.has_depth_aspect() {
        all |= TextureUsages::COPY_DST;
    }
    if is_stored {
        all |= TextureUsages::STORAGE_BINDING;
    }
    all
}

pub(crate) fn extent(size: UVec2, layers: u32) -> Extent3d {
    Extent3d {
        width: size.x,
        height: size.y,
        depth_or_array_layers: layers,
    }
}

/// Makes `held` match the list `wanted`. Reuses held images with an equal description. `pairs`
/// share textures. `is_stored` returns whether a compute pass writes the image with this index.
pub(crate) fn fit_images(
    factory: &mut ResourceFactory<'_>,
    held: &mut Vec<GpuImage>,
    wanted: &[ImageDesc],
    pairs: &[CountingPair],
    is_stored: impl Fn(usize) -> bool,
) {
    let mut old = std::mem::take(held);
    let mut paired: Vec<Option<GpuImage>> = vec![None; wanted.len()];
    for pair in pairs {
        let depth_desc = wanted[pair.depth];
        let counts_desc = wanted[pair.counts];
        let [depth, counts] = take_pair(&mut old, depth_desc, counts_desc)
            .unwrap_or_else(|| GpuImage::new_pair(factory, depth_desc, counts_desc));
        paired[pair.depth] = Some(depth);
        paired[pair.counts] = Some(counts);
    }
    for (i, (paired, &desc)) in paired.into_iter().zip(wanted).enumerate() {
        let usage = usage(texture_format(desc.format), is_stored(i));
        let image = paired
            .or_else(|| take_single(&mut old, desc, usage))
            .unwrap_or_else(|| GpuImage::new(factory, desc, usage));
        held.push(image);
    }
}

fn take_single(old: &mut Vec<GpuImage>, desc: ImageDesc, usage: TextureUsages) -> Option<GpuImage> {
    take(old, |image| {
        let is_single = image.aspect == TextureAspect::All;
        is_single && image.desc == desc && image.texture.usage() == usage
    })
}

/// Removes and returns two images that share a texture.
fn take_pair(
    old: &mut Vec<GpuImage>,
    depth: ImageDesc,
    counts: ImageDesc,
) -> Option<[GpuImage; 2]> {
    let depth = take(old, |image| {
        image.desc == depth && image.aspect == TextureAspect::DepthOnly
    })?;
    // The partner exists: both were created and kept together.
    let counts = take(old, |image| {
        image.desc == counts
            && image.texture == depth.texture
            && image.aspect == TextureAspect::StencilOnly
    })?;
    Some([depth, counts])
}

/// Removes and returns the first image for which `wanted` is true.
fn take(old: &mut Vec<GpuImage>, wanted: impl Fn(&GpuImage) -> bool) -> Option<GpuImage> {
    let i = old.iter().position(wanted)?;
    // Keep the order, so that equal images keep their positions and their bind groups stay valid.
    Some(old.remove(i))
}
