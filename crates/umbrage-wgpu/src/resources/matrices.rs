//! Matrices for vertex shaders.

use crate::resources::{
    bindings::{Binding, Bound, Slot},
    counters::ResourceFactory,
    pipelines::Pipelines,
};
use glam::Mat4;
use std::num::NonZeroU64;
use wgpu::{BindGroupLayout, Buffer, BufferUsages, RenderPass, ShaderStages};

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

/// A uniform buffer of matrices, bound one at a time.
#[derive(Debug, Default)]
pub(crate) struct Matrices {
    buffer: Option<Buffer>,
    binding: Binding,
    /// Bytes from one matrix to the next.
    stride: u32,
    /// What was written last; its memory is used again.
    bytes: Vec<u8>,
}

impl Matrices {
    pub(crate) fn write(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        pipelines: &mut Pipelines,
        matrices: impl Iterator<Item = Mat4>,
    ) {
        self.stride = factory
            .device
            .limits()
            .min_uniform_buffer_offset_alignment
            .max(64);
        self.bytes.clear();
        for (i, matrix) in matrices.enumerate() {
            self.bytes.resize(i * self.stride as usize, 0);
            self.bytes.extend_from_slice(bytemuck::bytes_of(&matrix));
        }
        if self.bytes.is_empty() {
            return;
        }
        let before = self.buffer.clone();
        let buffer = factory.write(
            &mut self.buffer,
            "umbrage matrices",
            BufferUsages::UNIFORM,
            &self.bytes,
        );
        if before.as_ref() == Some(&buffer) && self.binding.group().is_some() {
            return;
        }
        let layout = matrix_layout(factory, pipelines);
        self.binding.set(
            factory,
            "umbrage matrices",
            &layout,
            vec![Bound::Window(buffer, MATRIX)],
        );
    }

    pub(crate) fn bind(&self, pass: &mut RenderPass<'_>, group: u32, index: usize) {
        pass.set_bind_group(group, self.binding.group(), &[self.stride * index as u32]);
    }
}
