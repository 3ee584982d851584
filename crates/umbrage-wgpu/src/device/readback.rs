//! Readback of GPU memory.

use crate::resources::{counters::Counters, images::GpuImage, waiting::poll_until};
use bytemuck::Pod;
use std::sync::{Arc, OnceLock};
use umbrage_core::BackendError;
use wgpu::{
    Buffer, BufferDescriptor, BufferUsages, COPY_BYTES_PER_ROW_ALIGNMENT, CommandEncoder, Device,
    MapMode, TexelCopyBufferInfo, TexelCopyBufferLayout, TexelCopyTextureInfo, Texture,
    TextureAspect,
};

/// Readback buffers for reuse by later frames.
#[derive(Debug, Default)]
pub(crate) struct Spare(Vec<Buffer>);

/// Recorded copies, to be read after the submission.
#[derive(Debug)]
pub(crate) struct ReadBack<'a> {
    device: &'a Device,
    counters: &'a mut Counters,
    spare: &'a mut Spare,
    copies: Vec<Copy>,
}

/// Index of a copy in a [`ReadBack`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ticket(usize);

#[derive(Debug)]
struct Copy {
    buffer: Buffer,
    bytes: u64,
    /// Bytes of a row of texels.
    row: usize,
    /// Bytes from one row to the next in the buffer.
    padded_row: usize,
    /// True if mapping succeeded; empty before it is done.
    mapped: Arc<OnceLock<bool>>,
}

impl<'a> ReadBack<'a> {
    pub(crate) fn new(
        device: &'a Device,
        counters: &'a mut Counters,
        spare: &'a mut Spare,
    ) -> Self {
        Self {
            device,
            counters,
            spare,
            copies: Vec::new(),
        }
    }

    /// Records a copy of all layers of a texture.
    pub(crate) fn texture(&mut self, encoder: &mut CommandEncoder, texture: &Texture) -> Ticket {
        self.part(encoder, texture, TextureAspect::All)
    }

    /// Records a copy of all layers of an image, which may be a part of a texture.
    pub(crate) fn image(&mut self, encoder: &mut CommandEncoder, image: &GpuImage) -> Ticket {
        self.part(encoder, &image.texture, image.aspect)
    }

    fn part(
        &mut self,
        encoder: &mut CommandEncoder,
        texture: &Texture,
        aspect: TextureAspect,
    ) -> Ticket {
        let texel = texture.format().block_copy_size(Some(aspect)).unwrap_or(4);
        let row = texture.width() * texel;
        let padded = row.next_multiple_of(COPY_BYTES_PER_ROW_ALIGNMENT);
        let rows = texture.height() * texture.depth_or_array_layers();
        let ticket = self.add(
            u64::from(padded) * u64::from(rows),
            row as usize,
            padded as usize,
        );
        let layout = TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(padded),
            rows_per_image: Some(texture.height()),
        };
        let buffer = &self.copies[ticket.0].buffer;
        let from = TexelCopyTextureInfo {
            aspect,
            ..texture.as_image_copy()
        };
        encoder.copy_texture_to_buffer(
            from,
            TexelCopyBufferInfo { buffer, layout },
            texture.size(),
        );
        ticket
    }

    /// Records a copy of a buffer.
    pub(crate) fn buffer(&mut self, encoder: &mut CommandEncoder, buffer: &Buffer) -> Ticket {
        let bytes = buffer.size() as usize;
        let ticket = self.add(buffer.size(), bytes, bytes);
        encoder.copy_buffer_to_buffer(buffer, 0, &self.copies[ticket.0].buffer, 0, buffer.size());
        ticket
    }

    fn add(&mut self, bytes: u64, row: usize, padded_row: usize) -> Ticket {
        let buffer = match self.spare.0.iter().position(|b| b.size() == bytes) {
            Some(i) => self.spare.0.swap_remove(i),
            None => self.make(bytes),
        };
        self.copies.push(Copy {
            buffer,
            bytes,
            row,
            padded_row,
            mapped: Arc::default(),
        });
        Ticket(self.copies.len() - 1)
    }

    fn make(&mut self, size: u64) -> Buffer {
        self.counters.buffers += 1;
        let usage = BufferUsages::MAP_READ | BufferUsages::COPY_DST;
        let desc = BufferDescriptor {
            label: Some("umbrage read-back"),
            size,
            usage,
            mapped_at_creation: false,
        };
        self.device.create_buffer(&desc)
    }

    /// Waits for the submission and maps all copies.
    pub(crate) fn wait(&self) -> Result<(), BackendError> {
        for copy in &self.copies {
            let mapped = copy.mapped.clone();
            copy.buffer.map_async(MapMode::Read, .., move |result| {
                mapped.set(result.is_ok()).unwrap_or_default()
            });
        }
        let all_called = || self.copies.iter().all(|c| c.mapped.get().is_some());
        poll_until(self.device, all_called).map_err(|e| BackendError::DeviceLost(e.to_string()))?;
        if self.copies.iter().all(|c| c.mapped.get() == Some(&true)) {
            return Ok(());
        }
        Err(BackendError::DeviceLost(
            "its memory could not be read back".to_owned(),
        ))
    }

    /// Returns the copied data, without row padding.
    pub(crate) fn read<T: Pod>(&self, ticket: Ticket) -> Result<Vec<T>, BackendError> {
        let copy = &self.copies[ticket.0];
        let view = copy
            .buffer
            .get_mapped_range(..)
            .map_err(|e| BackendError::DeviceLost(e.to_string()))?;
        let rows = copy.bytes as usize / copy.padded_row;
        let mut out = vec![T::zeroed(); rows * copy.row / size_of::<T>()];
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut out);
        for (to, from) in bytes
            .chunks_exact_mut(copy.row)
            .zip(view.chunks_exact(copy.padded_row))
        {
            to.copy_from_slice(&from[..copy.row]);
        }
        Ok(out)
    }
}

impl Drop for ReadBack<'_> {
    /// Keeps the buffers of this frame that were mapped successfully, which bounds the memory.
    fn drop(&mut self) {
        self.spare.0.clear();
        for copy in self.copies.drain(..) {
            if copy.mapped.get() == Some(&true) {
                copy.buffer.unmap();
                self.spare.0.push(copy.buffer);
            }
        }
    }
}
