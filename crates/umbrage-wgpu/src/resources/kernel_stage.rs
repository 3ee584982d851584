//! A kernel of a filter, receive or shade stage, with its uniforms and bindings.

use crate::{
    hierarchy::one::RecipeHierarchy,
    resources::{
        bindings::{Binding, Bound, Slot},
        counters::ResourceFactory,
        images::GpuImage,
        pipelines::Pipelines,
        tables::Tables,
    },
    wgsl::kernel::{InputImage, InputKind, KernelInterface},
};
use umbrage_core::{Kernel, Recipe, TableId};
use wgpu::{Buffer, BufferUsages, ShaderStages};

/// Resources of one kernel of a recipe, kept between frames.
#[derive(Debug, Default)]
pub(crate) struct KernelStage {
    pub(crate) binding: Binding,
    uniforms: Option<Buffer>,
}

/// Inputs of the kernels of a recipe.
pub(crate) struct Sources<'a> {
    pub(crate) recipe: &'a Recipe,
    pub(crate) images: &'a [GpuImage],
    pub(crate) tables: &'a mut Tables,
    /// Contains some of the tables.
    pub(crate) hierarchy: Option<&'a RecipeHierarchy>,
}

impl Sources<'_> {
    /// Returns the binding of a table, which is uploaded unless the hierarchy contains it.
    fn table(&mut self, factory: &mut ResourceFactory<'_>, id: TableId) -> Bound {
        let of_hierarchy = self.hierarchy.and_then(|hierarchy| hierarchy.table(id));
        of_hierarchy
            .unwrap_or_else(|| Bound::Buffer(self.tables.get(factory, &self.recipe.tables[id])))
    }
}

impl KernelStage {
    /// Writes the uniforms and creates the bindings of the kernel. Returns its interface, which
    /// determines the shader text.
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
        let mut entries = Vec::new();
        let mut name = "umbrage kernel";
        if let Some(block) = kernel.uniforms() {
            name = block.uniform_layout().name;
            let bytes = block.uniform_bytes();
            let usage = BufferUsages::UNIFORM;
            let buffer = factory.write(&mut self.uniforms, name, usage, &bytes);
            entries.push((Slot::Uniform, Bound::Buffer(buffer)));
        }
        for (&image, input) in images.iter().zip(&shape.images) {
            let view = sources.images[image].whole.clone();
            entries.push((image_slot(*input), Bound::View(view)));
        }
        for &table in tables {
            entries.push((Slot::Table, sources.table(factory, table)));
        }
        if shape.compares() {
            let sampler = pipelines.sampler(factory.device);
            entries.push((Slot::Sampler, Bound::Sampler(sampler)));
        }
        // Include compute, so that callers can use the bind group with the text in both kinds of
        // shaders.
        let stages = ShaderStages::FRAGMENT | ShaderStages::COMPUTE;
        let layouts = &mut pipelines.layouts;
        self.binding.bind(factory, layouts, stages, name, entries);
        shape
    }
}

/// Returns the binding slot of a kernel's input image.
pub(crate) fn image_slot(image: InputImage) -> Slot {
    let InputImage { kind, layered } = image;
    match kind {
        InputKind::Floats => Slot::Floats { layered },
        InputKind::Counts | InputKind::Words => Slot::Whole { layered },
        InputKind::Compared => Slot::Depth { layered },
    }
}
