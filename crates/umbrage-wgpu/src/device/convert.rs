//! Conversion between images and floats by drawing, where copies don't work. Drivers convert
//! integer steps to floats differently, but readback must equal what shaders load. Data can't be
//! copied to 32-bit depth.

use crate::{
    filter::color_attachment,
    resources::{
        bindings::{Binding, Bound, Layouts, Slot},
        counters::ResourceFactory,
        images::{GpuImage, fit_images, texture_format},
        pipelines::{Targets, fullscreen_pipeline},
    },
    targets::attachment,
    wgsl::stages::shader_of,
};
use std::collections::HashMap;
use umbrage_core::{Format, ImageDesc};
use wgpu::{
    BindGroupLayout, Color, CommandEncoder, RenderPassDescriptor, RenderPipeline, ShaderStages,
    TextureView,
};
#[cfg(feature = "testing")]
use {crate::gbuffer, umbrage_core::Image};

/// Converts all layers of images.
#[derive(Debug, Default)]
pub(crate) struct Converter {
    layouts: Layouts,
    /// Pipelines by output format.
    pipelines: HashMap<Format, RenderPipeline>,
    /// Float copies, one for each image to convert.
    floats: Vec<GpuImage>,
    bindings: Vec<Binding>,
}

/// One layer to convert.
#[derive(Debug)]
struct Layer {
    from: TextureView,
    to: TextureView,
    /// Format of the output image.
    format: Format,
}

impl Converter {
    /// Records the passes that make images readable by copies. Returns the images to copy: the
    /// originals, or float copies.
    pub(crate) fn read(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        encoder: &mut CommandEncoder,
        images: &[GpuImage],
    ) -> Vec<GpuImage> {
        let converted = self.fit_floats(factory, images, readable_format);
        let mut readable = images.to_vec();
        let mut layers = Vec::new();
        for (i, floats) in converted.into_iter().zip(&self.floats) {
            layers.extend(pair_layers(&images[i].reads, floats));
            readable[i] = floats.clone();
        }
        self.convert(factory, encoder, &layers);
        readable
    }

    /// Writes `contents` into the images: records passes for depth, and writes other formats
    /// immediately.
    #[cfg(feature = "testing")]
    pub(crate) fn write(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        encoder: &mut CommandEncoder,
        images: &[GpuImage],
        contents: &[Image],
    ) {
        for (to, from) in images.iter().zip(contents) {
            if !to.desc.format.is_depth() {
                gbuffer::write(factory.queue, &to.texture, &bytes(from));
            }
        }
        let converted = self.fit_floats(factory, images, |format| {
            format.is_depth().then_some(Format::R32)
        });
        let mut layers = Vec::new();
        for (i, floats) in converted.into_iter().zip(&self.floats) {
            gbuffer::write(
                factory.queue,
                &floats.texture,
                bytemuck::cast_slice(&contents[i].texels),
            );
            layers.extend(pair_layers(&floats.reads, &images[i]));
        }
        self.convert(factory, encoder, &layers);
    }

    /// Creates a float image for each image for which `float_format` returns a format. Returns the
    /// indices of those images.
    fn fit_floats(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        images: &[GpuImage],
        float_format: impl Fn(Format) -> Option<Format>,
    ) -> Vec<usize> {
        let mut converted = Vec::new();
        let mut descs = Vec::new();
        for (i, image) in images.iter().enumerate() {
            if let Some(format) = float_format(image.desc.format) {
                converted.push(i);
                descs.push(ImageDesc {
                    format,
                    ..image.desc
                });
            }
        }
        fit_images(factory, &mut self.floats, &descs, &[], |_| false);
        converted
    }

    fn convert(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        encoder: &mut CommandEncoder,
        layers: &[Layer],
    ) {
        self.bindings.resize_with(layers.len(), Binding::default);
        let layout = self.layouts.get(
            factory,
            ShaderStages::FRAGMENT,
            &[Slot::Floats { layered: false }],
        );
        for (layer, binding) in layers.iter().zip(&mut self.bindings) {
            binding.set(
                factory,
                "umbrage conversion",
                &layout,
                vec![Bound::View(layer.from.clone())],
            );
            let pipeline = self
                .pipelines
                .entry(layer.format)
                .or_insert_with(|| pipeline(factory, layer.format, &layout));
            layer.encode(encoder, pipeline, binding);
        }
    }
}

impl Layer {
    fn encode(&self, encoder: &mut CommandEncoder, pipeline: &RenderPipeline, binding: &Binding) {
        let color = [Some(color_attachment(&self.to, Color::TRANSPARENT))];
        let depth = self.format.is_depth();
        let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
            label: Some("umbrage conversion"),
            color_attachments: if depth { &[] } else { &color },
            depth_stencil_attachment: depth.then(|| attachment(&self.to, self.format, true)),
            ..RenderPassDescriptor::default()
        });
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, binding.group(), &[]);
        pass.draw(0..3, 0..1);
    }
}

/// Returns the float format for reading back images of this format; `None` if copies work.
fn readable_format(format: Format) -> Option<Format> {
    match format {
        Format::Depth16 => Some(Format::R32),
        Format::Rgba8 => Some(Format::Rgba32),
        _ => None,
    }
}

fn pair_layers<'a>(from: &'a [TextureView], to: &'a GpuImage) -> impl Iterator<Item = Layer> + 'a {
    let format = to.desc.format;
    from.iter().zip(&to.layers).map(move |(from, to)| Layer {
        from: from.clone(),
        to: to.clone(),
        format,
    })
}

fn pipeline(
    factory: &mut ResourceFactory<'_>,
    to: Format,
    layout: &BindGroupLayout,
) -> RenderPipeline {
    factory.counters.pipelines += 1;
    let text = shader_of(&["convert"]);
    let format = texture_format(to);
    let (entry, targets) = match to.is_depth() {
        true => ("write_depth", Targets::Depth(format)),
        false => ("load_texel", Targets::Colors(&[format])),
    };
    let entries = ["umbrage_fullscreen", entry];
    fullscreen_pipeline(
        factory.device,
        "umbrage conversion",
        &text,
        entries,
        &targets,
        &[Some(layout)],
    )
}

/// Returns an image's texels as bytes in its own format.
#[cfg(feature = "testing")]
fn bytes(image: &Image) -> Vec<u8> {
    match image.desc.format {
        Format::Stencil8 => whole_bytes(&image.texels, 1.0),
        Format::Rgba8 => whole_bytes(&image.texels, 255.0),
        Format::Rg16 | Format::Rgba16 => {
            let step = |v: &f32| (v * 65_535.0).round() as u16;
            let steps: Vec<u16> = image.texels.iter().map(step).collect();
            bytemuck::cast_slice(&steps).to_vec()
        }
        _ => bytemuck::cast_slice(&image.texels).to_vec(),
    }
}

/// Returns the values as integers, multiplied by `scale`.
#[cfg(feature = "testing")]
fn whole_bytes(values: &[f32], scale: f32) -> Vec<u8> {
    values.iter().map(|v| (v * scale).round() as u8).collect()
}
