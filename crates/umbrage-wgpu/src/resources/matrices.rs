//! Matrices for vertex shaders.

use crate::resources::{
    bindings::{Binding, Bound},
    counters::ResourceFactory,
    pipelines::{MATRIX_SLOT, Pipelines},
    windows::Windows,
};
use glam::Mat4;
use wgpu::{RenderPass, ShaderStages};

/// Matrices, bound one at a time.
#[derive(Debug, Default)]
pub(crate) struct Matrices {
    matrices: Windows,
    binding: Binding,
}

impl Matrices {
    /// Writes the matrices that can be bound. Returns the number of written bytes: 0 if none
    /// changed.
    pub(crate) fn write(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        pipelines: &mut Pipelines,
        matrices: impl Iterator<Item = Mat4>,
    ) -> u64 {
        let Some((buffer, written)) = self.matrices.write(factory, "umbrage matrices", matrices)
        else {
            return 0;
        };
        let window = Bound::of_slot(MATRIX_SLOT, buffer);
        if !self.binding.is_of(&window) {
            let layouts = &mut pipelines.layouts;
            let stage = ShaderStages::VERTEX;
            let entries = vec![(MATRIX_SLOT, window)];
            self.binding
                .bind(factory, layouts, stage, "umbrage matrices", entries);
        }
        written
    }

    pub(crate) fn bind(&self, pass: &mut RenderPass<'_>, group: u32, index: usize) {
        pass.set_bind_group(group, self.binding.group(), &[self.matrices.offset(index)]);
    }
}
