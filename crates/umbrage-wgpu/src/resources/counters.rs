//! Counts of GPU objects, so that tests detect redundant creation.

use wgpu::{
    Buffer, BufferDescriptor, BufferUsages, Device, Extent3d, Queue, Texture, TextureDescriptor,
    TextureDimension, TextureFormat, TextureUsages,
};

/// Number of GPU objects created by a [`ShadowRenderer`](crate::ShadowRenderer) so far. Once a
/// recipe has been executed, recipes of the same shape (same shaders, image sizes, biases and
/// vertex layouts) don't change it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Pipelines, each with one shader compilation.
    pub pipelines: u32,
    /// Images, masks and colour images.
    pub textures: u32,
    /// Uniforms, tables, faces, and buffers that detect submissions.
    pub buffers: u32,
    /// Bind groups of kernels and casts.
    pub bind_groups: u32,
}

/// Creates GPU objects and counts them.
pub(crate) struct ResourceFactory<'a> {
    pub(crate) device: &'a Device,
    pub(crate) queue: &'a Queue,
    pub(crate) counters: &'a mut Counters,
}

impl<'a> ResourceFactory<'a> {
    pub(crate) fn new(device: &'a Device, queue: &'a Queue, counters: &'a mut Counters) -> Self {
        Self {
            device,
            queue,
            counters,
        }
    }

    /// Creates a two-dimensional texture without mipmaps.
    pub(crate) fn texture(
        &mut self,
        label: &str,
        size: Extent3d,
        format: TextureFormat,
        usage: TextureUsages,
    ) -> Texture {
        self.counters.textures += 1;
        self.device.create_texture(&TextureDescriptor {
            label: Some(label),
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension: TextureDimension::D2,
            format,
            usage,
            view_formats: &[],
        })
    }

    pub(crate) fn buffer(&mut self, label: &str, usage: BufferUsages, size: u64) -> Buffer {
        self.counters.buffers += 1;
        let usage = usage | BufferUsages::COPY_DST;
        self.device.create_buffer(&BufferDescriptor {
            label: Some(label),
            size,
            usage,
            mapped_at_creation: false,
        })
    }

    /// Writes bytes into the slot's buffer, which is replaced only if they don't fit.
    pub(crate) fn write(
        &mut self,
        slot: &mut Option<Buffer>,
        label: &str,
        usage: BufferUsages,
        bytes: &[u8],
    ) -> Buffer {
        let size = (bytes.len() as u64).max(16);
        let buffer = match slot.take() {
            Some(held) if held.size() >= size => held,
            _ => self.buffer(label, usage, size.next_power_of_two()),
        };
        self.queue.write_buffer(&buffer, 0, bytes);
        slot.insert(buffer).clone()
    }
}

/// Smaller needs count as this many bytes, rows or items: small buffers cost more to create again
/// than to keep.
const LEAST_NEED: u64 = 1 << 12;

/// Returns whether a size is kept for what is needed now: it suffices, and is at most eight times
/// the need, so that varying needs seldom create another buffer.
pub(crate) fn is_kept(held: u64, needed: u64) -> bool {
    (needed..=8 * needed.max(LEAST_NEED)).contains(&held)
}
