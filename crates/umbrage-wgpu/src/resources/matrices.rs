//! Matrices for vertex shaders.

use crate::resources::{
    bindings::{Binding, Bound, Slot},
    counters::ResourceFactory,
    pipelines::Pipelines,
    windows::Windows,
};
use glam::Mat4;
use std::num::NonZeroU64;
use wgpu::{BindGroupLayout, RenderPass, ShaderStages};

/// Bytes of a matrix.
const MATRIX: NonZeroU64 = NonZeroU64::new(64).unwrap();

pub(crate) fn matrix_layout(
    factory: &ResourceFactory<'_>,
    pipelines: &mut Pipelines,
) -> BindGroupLayout {
    pipelines
        .layouts
        .get(factory, ShaderStages::VERTEX, &[Slot::Window(MATRIX)])
}

/// Matrices, bound one at a time.
#[derive(Debug, Default)]
pub(crate) struct Matrices {
    matrices: Windows,
    binding: Binding,
}

impl Matrices {
    pub(crate) fn write(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        pipelines: &mut Pipelines,
        matrices: impl Iterator<Item = Mat4>,
    ) {
        let Some(buffer) = self.matrices.write(factory, "umbrage matrices", matrices) else {
            return;
        };
        let window = Bound::Window(buffer, MATRIX);
        if self.binding.is_of(&window) {
            return;
        }
        let layout = matrix_layout(factory, pipelines);
        self.binding
            .set(factory, "umbrage matrices", &layout, vec![window]);
    }

    pub(crate) fn bind(&self, pass: &mut RenderPass<'_>, group: u32, index: usize) {
        pass.set_bind_group(group, self.binding.group(), &[self.matrices.offset(index)]);
    }
}
