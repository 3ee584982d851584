//! Uniforms of many draws in one buffer; each draw binds its part.

use crate::resources::counters::ResourceFactory;
use bytemuck::Pod;
use wgpu::{Buffer, BufferUsages};

/// A uniform buffer of equal parts, each at an offset that can be bound.
#[derive(Debug, Default)]
pub(crate) struct Windows {
    buffer: Option<Buffer>,
    /// Bytes from one part to the next.
    stride: usize,
    /// The contents written last, kept to reuse the memory.
    bytes: Vec<u8>,
}

impl Windows {
    /// Writes all parts. Returns the buffer; `None` if there are no parts.
    pub(crate) fn write<T: Pod>(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        label: &str,
        parts: impl Iterator<Item = T>,
    ) -> Option<Buffer> {
        let alignment = factory.device.limits().min_uniform_buffer_offset_alignment;
        self.stride = size_of::<T>().next_multiple_of(alignment as usize);
        self.bytes.clear();
        for (i, part) in parts.enumerate() {
            self.bytes.resize(i * self.stride, 0);
            self.bytes.extend_from_slice(bytemuck::bytes_of(&part));
        }
        if self.bytes.is_empty() {
            return None;
        }
        let usage = BufferUsages::UNIFORM;
        Some(factory.write(&mut self.buffer, label, usage, &self.bytes))
    }

    /// Returns the offset of a part, bytes.
    pub(crate) fn offset(&self, part: usize) -> u32 {
        (part * self.stride) as u32
    }
}
