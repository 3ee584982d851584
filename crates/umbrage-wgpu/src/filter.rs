//! The filter stage, and the clearing of layers that no stage writes.

use crate::{
    resources::{
        counters::ResourceFactory,
        images::{GpuImage, texture_format},
        kernel_stage::{KernelStage, Sources},
        pipelines::Pipelines,
        timestamps::{PassTimestamps, TimedStage, pass_stamps},
    },
    targets::attachment,
    wgsl::{kernel::kernel_wgsl, stages::filter_shader},
};
use umbrage_core::{Format, Recipe};
use wgpu::{
    Color, CommandEncoder, LoadOp, Operations, RenderPassColorAttachment, RenderPassDescriptor,
    StoreOp, TextureView,
};

/// All filters of a recipe, prepared for encoding.
#[derive(Debug, Default)]
pub(crate) struct FilterStage {
    /// Each filter, with the layers that it writes.
    filters: Vec<(KernelStage, Vec<TextureView>)>,
    /// Layers that may be read before a stage writes them.
    clears: Vec<(Format, TextureView)>,
}

impl FilterStage {
    pub(crate) fn prepare(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        pipelines: &mut Pipelines,
        sources: &mut Sources<'_>,
    ) {
        let recipe = sources.recipe;
        self.clears = unwritten_layers(recipe, sources.images);
        self.filters.truncate(recipe.filters.len());
        self.filters
            .resize_with(recipe.filters.len(), Default::default);
        for ((stage, targets), filter) in self.filters.iter_mut().zip(&recipe.filters) {
            let kernel = &*filter.kernel;
            let shape = stage.bind(
                factory,
                pipelines,
                sources,
                kernel,
                &filter.inputs,
                &filter.tables,
            );
            let output = &sources.images[filter.output];
            let text = filter_shader(&kernel_wgsl(kernel, &shape, 0), output.desc.format);
            let format = texture_format(output.desc.format);
            let label = format!("umbrage filter into {}", output.desc.label);
            stage.pipeline = Some(pipelines.kernel(
                factory,
                &label,
                text,
                "umbrage_filter",
                format,
                &[stage.binding.layout()],
            ));
            targets.clone_from(&output.layers);
        }
    }

    /// Returns whether there are any filter passes.
    pub(crate) fn has_passes(&self) -> bool {
        self.filters.iter().any(|(_, layers)| !layers.is_empty())
    }

    /// Clears the layers that may be read before a stage writes them.
    pub(crate) fn clear(&self, encoder: &mut CommandEncoder) {
        for (format, view) in &self.clears {
            clear(encoder, *format, view);
        }
    }

    /// Records one pass for each layer of each filter's output.
    pub(crate) fn encode(&self, encoder: &mut CommandEncoder, stamps: Option<&PassTimestamps<'_>>) {
        let count = self.filters.iter().map(|(_, layers)| layers.len()).sum();
        let mut index = 0;
        for (stage, layers) in &self.filters {
            let Some(pipeline) = &stage.pipeline else {
                continue;
            };
            for (layer, view) in (0..).zip(layers) {
                let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
                    label: Some("umbrage filter"),
                    color_attachments: &[Some(color_attachment(view, Color::TRANSPARENT))],
                    timestamp_writes: pass_stamps(stamps, TimedStage::Filter, index, count),
                    ..RenderPassDescriptor::default()
                });
                pass.set_pipeline(pipeline);
                pass.set_bind_group(0, stage.binding.group(), &[]);
                pass.draw(0..3, layer..layer + 1);
                index += 1;
            }
        }
    }
}

/// Returns the attachment of a pass that clears a layer and stores the result.
pub(crate) fn color_attachment(view: &TextureView, clear: Color) -> RenderPassColorAttachment<'_> {
    let ops = Operations {
        load: LoadOp::Clear(clear),
        store: StoreOp::Store,
    };
    RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: None,
        ops,
    }
}

/// Records a pass that clears a layer to the initial contents of a recipe's images.
pub(crate) fn clear(encoder: &mut CommandEncoder, format: Format, view: &TextureView) {
    let color = [Some(color_attachment(view, Color::TRANSPARENT))];
    let cast_only = format.is_cast_only();
    encoder.begin_render_pass(&RenderPassDescriptor {
        label: Some("umbrage clear"),
        color_attachments: if cast_only { &[] } else { &color },
        depth_stencil_attachment: cast_only.then(|| attachment(view, format, true)),
        ..RenderPassDescriptor::default()
    });
}

/// Returns the layers that may be read before a stage writes them. They must have the initial
/// contents that recipes specify, not those of the last frame.
fn unwritten_layers(recipe: &Recipe, images: &[GpuImage]) -> Vec<(Format, TextureView)> {
    let mut out = Vec::new();
    for (id, image) in images.iter().enumerate() {
        for (layer, view) in (0..).zip(&image.layers) {
            let is_cast = recipe
                .casts
                .iter()
                .any(|cast| cast.image == id && cast.layer == layer);
            if !is_cast && !is_filtered_before_read(recipe, id) {
                out.push((image.desc.format, view.clone()));
            }
        }
    }
    out
}

/// Returns whether a filter writes the image and none reads it before that.
fn is_filtered_before_read(recipe: &Recipe, image: usize) -> bool {
    let Some(writer) = recipe.filters.iter().position(|f| f.output == image) else {
        return false;
    };
    !recipe.filters[..writer]
        .iter()
        .any(|f| f.inputs.contains(&image))
}
