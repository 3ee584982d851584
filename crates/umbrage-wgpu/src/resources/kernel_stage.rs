//! A kernel of a filter, of the receive stage or of shading: its uniforms, and what it reads.

use crate::{
    resources::{
        bindings::{Binding, Bound, Slot},
        counters::ResourceFactory,
        images::GpuImage,
        pipelines::Pipelines,
        tables::Tables,
    },
    wgsl::kernel::{InputKind, KernelInterface},
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
    /// Writes the uniforms and binds what the kernel reads. Returns what its shader text depends on.
    pub(crate) fn bind(
        &mut self,
        factory: &mut ResourceFactory<'_>,
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
            let buffer = factory.write(&mut self.uniforms, name, usage, &bytes);
            bound.push(Bound::Buffer(buffer));
        }
        for &image in images {
            bound.push(Bound::View(sources.images[image].whole.clone()));
        }
        for &table in tables {
            let buffer = sources.tables.get(factory, &sources.recipe.tables[table]);
            bound.push(Bound::Buffer(buffer));
        }
        if shape.compares() {
            bound.push(Bound::Sampler(pipelines.sampler(factory.device)));
        }
        // Compute, too, so that callers can use the bind group with the pasted text in either kind of shader.
        let visibility = ShaderStages::FRAGMENT | ShaderStages::COMPUTE;
        let layout = pipelines.layouts.get(factory, visibility, &slots(&shape));
        self.binding.set(factory, name, &layout, bound);
        shape
    }
}

/// Returns the kinds of a kernel's bindings, in the order in which [`KernelStage::bind`] binds them.
fn slots(shape: &KernelInterface) -> Vec<Slot> {
    let mut slots = Vec::new();
    if shape.uniforms {
        slots.push(Slot::Uniform);
    }
    let image_slots = shape.images.iter().map(|i| image_slot(i.kind, i.layered));
    slots.extend(image_slots);
    for _ in 0..shape.tables {
        slots.push(Slot::Table);
    }
    if shape.compares() {
        slots.push(Slot::Sampler);
    }
    slots
}

/// Returns the binding of an image that a kernel reads so.
pub(crate) fn image_slot(kind: InputKind, layered: bool) -> Slot {
    match kind {
        InputKind::Floats => Slot::Floats { layered },
        InputKind::Counts | InputKind::Words => Slot::Whole { layered },
        InputKind::Compared => Slot::Depth { layered },
    }
}
