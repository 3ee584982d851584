//! The filter stage, and the clearing of layers that no stage writes.

use crate::{
    resources::{
        bindings::{Binding, Bound, Slot},
        counters::ResourceFactory,
        images::{GpuImage, texture_format},
        kernel_stage::{KernelStage, Sources},
        pipelines::Pipelines,
        timestamps::{PassTimestamps, TimedStage, of_compute, pass_stamps},
    },
    targets::attachment,
    wgsl::{
        kernel::kernel_wgsl,
        stages::{FILTER_OUTPUT_GROUP, filter_shader, tile_filter_shader},
    },
};
use glam::{UVec2, UVec3};
use umbrage_core::{Filter, Format, Recipe};
use wgpu::{
    Color, CommandEncoder, ComputePassDescriptor, ComputePipeline, LoadOp, Operations,
    RenderPassColorAttachment, RenderPassDescriptor, RenderPassTimestampWrites, RenderPipeline,
    ShaderStages, StoreOp, TextureView,
};

/// All filters of a recipe, prepared for encoding.
#[derive(Debug, Default)]
pub(crate) struct FilterStage {
    filters: Vec<PreparedFilter>,
    /// Layers that may be read before a stage writes them.
    clears: Vec<(Format, TextureView)>,
}

/// A filter with its passes.
#[derive(Debug, Default)]
struct PreparedFilter {
    stage: KernelStage,
    /// The image that compute passes write.
    output: Binding,
    passes: FilterPasses,
}

/// The passes of one filter.
#[derive(Debug)]
enum FilterPasses {
    /// One render pass for each of these layers.
    Draws {
        pipeline: Option<RenderPipeline>,
        layers: Vec<TextureView>,
    },
    /// One compute pass of this many workgroups along each axis; the third axis has the layers.
    Tiles {
        pipeline: ComputePipeline,
        groups: UVec3,
    },
}

impl Default for FilterPasses {
    fn default() -> Self {
        Self::Draws {
            pipeline: None,
            layers: Vec::new(),
        }
    }
}

impl FilterPasses {
    fn count(&self) -> usize {
        match self {
            Self::Draws { layers, .. } => layers.len(),
            Self::Tiles { .. } => 1,
        }
    }
}

impl PreparedFilter {
    /// Creates the pipeline and the bindings.
    fn prepare(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        pipelines: &mut Pipelines,
        sources: &mut Sources<'_>,
        filter: &Filter,
    ) {
        let kernel = &*filter.kernel;
        let shape = self.stage.bind(
            factory,
            pipelines,
            sources,
            kernel,
            &filter.inputs,
            &filter.tables,
        );
        let text = kernel_wgsl(kernel, &shape, 0);
        let output = &sources.images[filter.output];
        let desc = output.desc;
        let label = format!("umbrage filter into {}", desc.label);
        let format = texture_format(desc.format);
        let inputs = self.stage.binding.layout();
        let Some(tile) = kernel.tile() else {
            let text = filter_shader(&text, desc.format);
            let entry = "umbrage_filter";
            let pipeline = pipelines.kernel(factory, &label, text, entry, format, &[inputs]);
            self.passes = FilterPasses::Draws {
                pipeline: Some(pipeline),
                layers: output.layers.clone(),
            };
            return;
        };
        let layered = desc.layers > 1;
        let slot = Slot::Stored { format, layered };
        let layout = self.output.bind(
            factory,
            &mut pipelines.layouts,
            ShaderStages::COMPUTE,
            &label,
            vec![(slot, Bound::View(output.whole.clone()))],
        );
        let text = tile_filter_shader(&text, desc.format, layered);
        let groups = [inputs, Some(&layout)];
        let pipeline = pipelines.compute(factory, &label, text, "umbrage_filter", &groups);
        let tile = tile.max(UVec2::ONE);
        let columns = desc.size.x.div_ceil(tile.x);
        let rows = desc.size.y.div_ceil(tile.y);
        self.passes = FilterPasses::Tiles {
            pipeline,
            groups: UVec3::new(columns, rows, desc.layers),
        };
    }

    /// Records the passes. `stamps` returns the timestamps of the pass with this index.
    fn encode<'a>(
        &self,
        encoder: &mut CommandEncoder,
        stamps: impl Fn(usize) -> Option<RenderPassTimestampWrites<'a>>,
    ) {
        match &self.passes {
            FilterPasses::Draws { pipeline, layers } => {
                let Some(pipeline) = pipeline else {
                    return;
                };
                for (layer, view) in (0..).zip(layers) {
                    let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
                        label: Some("umbrage filter"),
                        color_attachments: &[Some(color_attachment(view, Color::TRANSPARENT))],
                        timestamp_writes: stamps(layer as usize),
                        ..RenderPassDescriptor::default()
                    });
                    pass.set_pipeline(pipeline);
                    pass.set_bind_group(0, self.stage.binding.group(), &[]);
                    pass.draw(0..3, layer..layer + 1);
                }
            }
            FilterPasses::Tiles { pipeline, groups } => {
                let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor {
                    label: Some("umbrage filter"),
                    timestamp_writes: stamps(0).map(of_compute),
                });
                pass.set_pipeline(pipeline);
                pass.set_bind_group(0, self.stage.binding.group(), &[]);
                pass.set_bind_group(FILTER_OUTPUT_GROUP, self.output.group(), &[]);
                pass.dispatch_workgroups(groups.x, groups.y, groups.z);
            }
        }
    }
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
        self.filters
            .resize_with(recipe.filters.len(), Default::default);
        for (prepared, filter) in self.filters.iter_mut().zip(&recipe.filters) {
            prepared.prepare(factory, pipelines, sources, filter);
        }
    }

    /// Returns the number of filter passes.
    pub(crate) fn pass_count(&self) -> usize {
        let counts = self.filters.iter().map(|filter| filter.passes.count());
        counts.sum()
    }

    /// Clears the layers that may be read before a stage writes them.
    pub(crate) fn clear(&self, encoder: &mut CommandEncoder) {
        for (format, view) in &self.clears {
            clear(encoder, *format, view);
        }
    }

    /// Records all filters: a compute pass for each that computes tiles, otherwise a render pass
    /// for each layer of its output. `earlier` is the number of earlier passes of the timed stage.
    pub(crate) fn encode(
        &self,
        encoder: &mut CommandEncoder,
        stamps: Option<&PassTimestamps<'_>>,
        earlier: usize,
    ) {
        let count = earlier + self.pass_count();
        let mut first = earlier;
        for filter in &self.filters {
            filter.encode(encoder, |pass| {
                pass_stamps(stamps, TimedStage::Filter, first + pass, count)
            });
            first += filter.passes.count();
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
