//! Between images and plain floats, where copies of memory won't do: drivers differ in how they turn whole steps into
//! floats, and what is handed out must be what shaders load; and nothing can be copied to depth of 32 bits.

use crate::{
    filter::color_attachment,
    resources::{
        bindings::{Binding, Bound, Layouts, Slot},
        counters::ResourceFactory,
        images::{GpuImage, fit_images, texture_format},
        pipelines::{Targets, fullscreen_pipeline},
    },
    targets::attachment,
    wgsl::FULLSCREEN,
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
    /// By what they write.
    pipelines: HashMap<Format, RenderPipeline>,
    /// Plain floats, for each image that is converted.
    floats: Vec<GpuImage>,
    bindings: Vec<Binding>,
}

/// One layer to be converted.
#[derive(Debug)]
struct Layer {
    from: TextureView,
    to: TextureView,
    /// Of the image that is written.
    format: Format,
}

impl Converter {
    /// Records what makes images readable by copies of memory, and returns what to copy: the images themselves, or
    /// floats in their place.
    pub(crate) fn read(
        &mut self,
        maker: &mut ResourceFactory<'_>,
        encoder: &mut CommandEncoder,
        images: &[GpuImage],
    ) -> Vec<GpuImage> {
        let jobs = self.fit_floats(maker, images, |f| match f {
            Format::Depth16 => Some(Format::R32),
            Format::Rgba8 => Some(Format::Rgba32),
            _ => None,
        });
        let mut readable = images.to_vec();
        let mut layers = Vec::new();
        for (i, floats) in jobs.into_iter().zip(&self.floats) {
            layers.extend(pair_layers(&images[i].reads, floats));
            readable[i] = floats.clone();
        }
        self.convert(maker, encoder, &layers);
        readable
    }

    /// Gives images the contents of others like them: some at once, depth in passes that it records.
    #[cfg(feature = "testing")]
    pub(crate) fn write(
        &mut self,
        maker: &mut ResourceFactory<'_>,
        encoder: &mut CommandEncoder,
        images: &[GpuImage],
        contents: &[Image],
    ) {
        for (to, from) in images
            .iter()
            .zip(contents)
            .filter(|(to, _)| !to.desc.format.is_depth())
        {
            gbuffer::write(maker.queue, &to.texture, &bytes(from));
        }
        let jobs = self.fit_floats(maker, images, |f| f.is_depth().then_some(Format::R32));
        let mut layers = Vec::new();
        for (i, floats) in jobs.into_iter().zip(&self.floats) {
            gbuffer::write(
                maker.queue,
                &floats.texture,
                bytemuck::cast_slice(&contents[i].texels),
            );
            layers.extend(pair_layers(&floats.reads, &images[i]));
        }
        self.convert(maker, encoder, &layers);
    }

    /// Makes floats for the images whose format has some. Returns which.
    fn fit_floats(
        &mut self,
        maker: &mut ResourceFactory<'_>,
        images: &[GpuImage],
        floats: impl Fn(Format) -> Option<Format>,
    ) -> Vec<usize> {
        let wanted = (0..).zip(images).filter_map(|(i, image)| {
            let format = floats(image.desc.format)?;
            Some((
                i,
                ImageDesc {
                    format,
                    ..image.desc
                },
            ))
        });
        let (jobs, descs): (Vec<usize>, Vec<ImageDesc>) = wanted.unzip();
        fit_images(maker, &mut self.floats, &descs, &[]);
        jobs
    }

    fn convert(
        &mut self,
        maker: &mut ResourceFactory<'_>,
        encoder: &mut CommandEncoder,
        layers: &[Layer],
    ) {
        self.bindings.resize_with(layers.len(), Binding::default);
        let layout = self.layouts.get(
            maker,
            ShaderStages::FRAGMENT,
            &[Slot::Floats { layered: false }],
        );
        for (layer, binding) in layers.iter().zip(&mut self.bindings) {
            binding.set(
                maker,
                "umbrage conversion",
                &layout,
                vec![Bound::View(layer.from.clone())],
            );
            let pipeline = self
                .pipelines
                .entry(layer.format)
                .or_insert_with(|| pipeline(maker, layer.format, &layout));
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

fn pair_layers<'a>(from: &'a [TextureView], to: &'a GpuImage) -> impl Iterator<Item = Layer> + 'a {
    let format = to.desc.format;
    from.iter().zip(&to.layers).map(move |(from, to)| Layer {
        from: from.clone(),
        to: to.clone(),
        format,
    })
}

fn pipeline(
    maker: &mut ResourceFactory<'_>,
    to: Format,
    layout: &BindGroupLayout,
) -> RenderPipeline {
    maker.counters.pipelines += 1;
    let text = include_str!("convert.wgsl").to_owned() + FULLSCREEN;
    let format = texture_format(to);
    let (entry, targets) = match to.is_depth() {
        true => ("write_depth", Targets::Depth(format)),
        false => ("load_texel", Targets::Colors(&[format])),
    };
    let entries = ["umbrage_fullscreen", entry];
    fullscreen_pipeline(
        maker.device,
        "umbrage conversion",
        &text,
        entries,
        &targets,
        &[Some(layout)],
    )
}

/// An image's texels as its own format has them.
#[cfg(feature = "testing")]
fn bytes(image: &Image) -> Vec<u8> {
    let whole = |scale: f32| {
        image
            .texels
            .iter()
            .map(|v| (v * scale).round() as u8)
            .collect()
    };
    match image.desc.format {
        Format::Stencil8 => whole(1.0),
        Format::Rgba8 => whole(255.0),
        _ => bytemuck::cast_slice(&image.texels).to_vec(),
    }
}
