//! Uniforms of many draws in one buffer; each draw binds its part.

use crate::resources::counters::ResourceFactory;
use bytemuck::Pod;
use std::collections::HashMap;
use wgpu::{Buffer, BufferUsages};

/// Number of windows of a new buffer for each part that is written first. With some to spare,
/// contents of earlier frames can be kept while others change.
const SPARE: usize = 4;

/// A uniform buffer of equal windows, each at an offset that can be bound. Parts with known content
/// are not written again: a write costs more than the rest of a small frame.
#[derive(Debug, Default)]
pub(crate) struct Windows {
    buffer: Option<Buffer>,
    /// Number of windows of the buffer.
    capacity: usize,
    /// Bytes from one window to the next; 0 before the first write.
    stride: usize,
    /// The window of each content, from the first one.
    known: HashMap<Box<[u8]>, usize>,
    /// The window of each part.
    windows: Vec<usize>,
    /// The contents of the parts, kept to reuse the memory.
    parts: Vec<u8>,
    /// The contents of new windows, kept to reuse the memory.
    new: Vec<u8>,
}

impl Windows {
    /// Writes the parts that the buffer doesn't contain. Returns the buffer and the number of bytes
    /// written; `None` if there are no parts.
    pub(crate) fn write<T: Pod>(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        label: &str,
        parts: impl Iterator<Item = T>,
    ) -> Option<(Buffer, u64)> {
        if self.stride == 0 {
            // Limits are copied by each query, so query them only once.
            let alignment = factory.device.limits().min_uniform_buffer_offset_alignment;
            self.stride = size_of::<T>().next_multiple_of(alignment as usize);
        }
        self.parts.clear();
        for part in parts {
            self.parts.extend_from_slice(bytemuck::bytes_of(&part));
        }
        if self.parts.is_empty() {
            return None;
        }
        let mut first = self.known.len();
        self.assign_windows(size_of::<T>());
        if self.known.len() > self.capacity {
            // Fill the buffer from its beginning, or a larger one.
            first = 0;
            self.known.clear();
            self.assign_windows(size_of::<T>());
        }
        let needed = self.known.len();
        if needed > self.capacity {
            self.capacity = (SPARE * needed).next_power_of_two();
            self.buffer = None;
        }
        let buffer = self.buffer.get_or_insert_with(|| {
            let size = (self.capacity * self.stride) as u64;
            factory.buffer(label, BufferUsages::UNIFORM, size)
        });
        if !self.new.is_empty() {
            let offset = (first * self.stride) as u64;
            factory.queue.write_buffer(buffer, offset, &self.new);
        }
        Some((buffer.clone(), self.new.len() as u64))
    }

    /// Assigns each part to the window with its content, or to a new one.
    fn assign_windows(&mut self, part_bytes: usize) {
        self.windows.clear();
        self.new.clear();
        for part in self.parts.chunks_exact(part_bytes) {
            let known = self.known.get(part).copied();
            let window = known.unwrap_or_else(|| {
                let window = self.known.len();
                self.known.insert(part.into(), window);
                self.new.extend_from_slice(part);
                let end = self.new.len().next_multiple_of(self.stride);
                self.new.resize(end, 0);
                window
            });
            self.windows.push(window);
        }
    }

    /// Returns the offset of a part, bytes.
    pub(crate) fn offset(&self, part: usize) -> u32 {
        (self.windows[part] * self.stride) as u32
    }
}

#[cfg(test)]
mod tests {
    use super::Windows;

    /// Returns the windows of these parts, and the contents of the new ones.
    fn assigned(windows: &mut Windows, parts: &[u8]) -> (Vec<usize>, Vec<u8>) {
        windows.stride = 2;
        windows.parts = parts.to_vec();
        windows.assign_windows(1);
        (windows.windows.clone(), windows.new.clone())
    }

    #[test]
    fn known_contents_are_not_written_again() {
        let mut windows = Windows::default();
        let first = assigned(&mut windows, &[7, 8, 7]);
        assert_eq!(first, (vec![0, 1, 0], vec![7, 0, 8, 0]));
        assert_eq!(assigned(&mut windows, &[8]), (vec![1], vec![]));
        let third = assigned(&mut windows, &[9, 7]);
        assert_eq!(third, (vec![2, 0], vec![9, 0]));
    }
}
