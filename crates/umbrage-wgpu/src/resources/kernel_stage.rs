//! A filter, the lookup or the shading: a kernel, its uniforms, and what it reads.

use crate::{
    resources::{
        bindings::{Binding, Bound, Slot},
        counters::ResourceFactory,
        images::GpuImage,
        pipelines::Pipelines,
        tables::Tables,
    },
    wgsl::{InputKind, KernelInterface},
};
use umbrage_core::{Kernel, Recipe};
use wgpu::{Buffer, BufferUsages, RenderPipeline, ShaderStages};

/// What is kept from frame to frame for one kernel of a recipe.
#[derive(Debug, Default)]
pub(crate) struct KernelStage {
    pub(crate) pipeline: Option<RenderPipeline>,
    pub(crate) binding: Binding,
    uniforms: Option<Buffer>,
}

/// What the kernels of a recipe read.
pub(crate) struct Sources<'a> {
    pub(crate) recipe: &'a Recipe,
    pub(crate) images: &'a [GpuImage],
    pub(crate) tables: &'a mut Tables,
}

impl KernelStage {
    /// Writes the uniforms and binds what the kernel reads. Returns its shape.
    pub(crate) fn bind(
        &mut self,
        maker: &mut ResourceFactory<'_>,
        pipelines: &mut Pipelines,
        sources: &mut Sources<'_>,
        kernel: &dyn Kernel,
        images: &[usize],
        tables: &[usize],
    ) -> KernelInterface {
        let shape = KernelInterface::new(sources.recipe, kernel, images, tables);
        let mut bound = Vec::new();
        let mut name = "umbrage kernel";
        if let Some(block) = kernel.uniforms() {
            name = block.uniform_layout().name;
            let bytes = block.uniform_bytes();
            let usage = BufferUsages::UNIFORM;
            let buffer = maker.write(&mut self.uniforms, name, usage, &bytes);
            bound.push(Bound::Buffer(buffer));
        }
        for &image in images {
            bound.push(Bound::View(sources.images[image].whole.clone()));
        }
        for &table in tables {
            let buffer = sources.tables.get(maker, &sources.recipe.tables[table]);
            bound.push(Bound::Buffer(buffer));
        }
        if shape.compares() {
            bound.push(Bound::Sampler(pipelines.sampler(maker.device)));
        }
        // Compute, too, so that callers can use the bind group with the pasted text in either kind of shader.
        let visibility = ShaderStages::FRAGMENT | ShaderStages::COMPUTE;
        let layout = pipelines.layouts.get(maker, visibility, &slots(&shape));
        self.binding.set(maker, name, &layout, bound);
        shape
    }
}

fn slots(shape: &KernelInterface) -> Vec<Slot> {
    let images = shape.images.iter().map(|&(kind, layered)| match kind {
        InputKind::Floats => Slot::Floats { layered },
        InputKind::Counts => Slot::Whole { layered },
        InputKind::Compared => Slot::Depth { layered },
    });
    let tables = (0..shape.tables).map(|_| Slot::Table);
    let sampler = shape.compares().then_some(Slot::Sampler);
    let uniforms = shape.uniforms.then_some(Slot::Uniform);
    uniforms
        .into_iter()
        .chain(images)
        .chain(tables)
        .chain(sampler)
        .collect()
}
