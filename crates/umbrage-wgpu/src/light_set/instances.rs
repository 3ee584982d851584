//! The casters' placements on the device.

use crate::resources::counters::ResourceFactory;
use std::{iter, ops::Range};
use wgpu::{Buffer, BufferSize, BufferUsages, CommandEncoder, util::StagingBelt};

/// World from local as three columns and a translation: the data of an instance.
pub(crate) type Columns = [f32; 12];

/// Bytes of an instance.
const STRIDE: u64 = size_of::<Columns>() as u64;
/// Greatest number of unchanged instances between changed ones that are written along: a separate
/// write costs about as much as 12 kB.
const GREATEST_GAP: u32 = 256;
/// Greatest number of bytes that the next encoder copies. `Queue::write_buffer` creates a buffer
/// for each write: for few bytes this takes longer than copying them from a buffer that is kept.
const MOST_STAGED: u64 = 1 << 16;
/// Casts read instances as vertices, and the passes that list casters read them as a table.
const INSTANCES: BufferUsages = BufferUsages::VERTEX.union(BufferUsages::STORAGE);

/// The buffer of instances, and the changes that the next encoder copies into it.
#[derive(Debug, Default)]
pub(crate) struct Instances {
    buffer: Option<Buffer>,
    /// True if copies were lost with an encoder that was not submitted.
    is_outdated: bool,
    /// Slots with changes that the buffer doesn't contain, in rising order.
    waiting: Vec<u32>,
    /// Content of the runs of these slots, one after the other.
    staged: Vec<u8>,
    belt: Option<StagingBelt>,
}

impl Instances {
    /// Uploads the placements in changed slots, or all of them into a larger buffer if they don't
    /// fit. The next [`encode`](Self::encode) copies few changes. Returns the number of bytes.
    pub(crate) fn upload(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        columns: &[Columns],
        changed: &[u32],
    ) -> u64 {
        self.staged.clear();
        let size = columns.len() as u64 * STRIDE;
        if size == 0 {
            return 0;
        }
        // Write everything.
        let held = self.buffer.take().filter(|held| held.size() >= size);
        let is_complete = held.is_some() && !self.is_outdated;
        let capacity = size.next_power_of_two();
        let buffer =
            held.unwrap_or_else(|| factory.buffer("umbrage instances", INSTANCES, capacity));
        let buffer = self.buffer.insert(buffer);
        if !is_complete {
            factory
                .queue
                .write_buffer(buffer, 0, bytemuck::cast_slice(columns));
            self.is_outdated = false;
            self.waiting.clear();
            return size;
        }
        // Add the changes to those that no encoder copied.
        self.waiting.extend_from_slice(changed);
        self.waiting.sort_unstable();
        self.waiting.dedup();
        let bytes = runs(&self.waiting)
            .map(|run| run.len() as u64 * STRIDE)
            .sum();
        if bytes <= MOST_STAGED {
            for run in runs(&self.waiting) {
                self.staged
                    .extend_from_slice(bytemuck::cast_slice(&columns[run]));
            }
        } else {
            for run in runs(&self.waiting) {
                let offset = run.start as u64 * STRIDE;
                factory
                    .queue
                    .write_buffer(buffer, offset, bytemuck::cast_slice(&columns[run]));
            }
            self.waiting.clear();
        }
        if self.belt.is_none() {
            self.belt = Some(StagingBelt::new(factory.device.clone(), MOST_STAGED));
        }
        bytes
    }

    /// Records copies of the changes that wait.
    pub(crate) fn encode(&mut self, encoder: &mut CommandEncoder) {
        let (Some(buffer), Some(belt)) = (&self.buffer, &mut self.belt) else {
            return;
        };
        if self.staged.is_empty() {
            return;
        }
        let mut rest = &self.staged[..];
        for run in runs(&self.waiting) {
            let (bytes, others) = rest.split_at(run.len() * STRIDE as usize);
            rest = others;
            let Some(size) = BufferSize::new(bytes.len() as u64) else {
                continue;
            };
            let offset = run.start as u64 * STRIDE;
            belt.write_buffer(encoder, buffer, offset, size)
                .copy_from_slice(bytes);
        }
        belt.finish_and_recall_on_submit(encoder);
        self.staged.clear();
        self.waiting.clear();
    }

    /// Makes the next upload write everything: an encoder with copies may be lost.
    pub(crate) fn mark_outdated(&mut self) {
        self.is_outdated = true;
    }

    /// Drops the buffer: the next upload creates and fills another.
    pub(crate) fn lose_buffer(&mut self) {
        *self = Self::default();
    }

    /// Returns the buffer, with all slots.
    pub(crate) fn buffer(&self) -> Option<&Buffer> {
        self.buffer.as_ref()
    }
}

/// Returns the runs of slots to write together, for rising slots with changes.
fn runs(slots: &[u32]) -> impl Iterator<Item = Range<usize>> {
    let mut rest = slots;
    iter::from_fn(move || {
        let &first = rest.first()?;
        let is_gap = |pair: &[u32]| pair[1] - pair[0] > GREATEST_GAP;
        let end = rest.windows(2).position(is_gap);
        let count = end.map_or(rest.len(), |i| i + 1);
        let last = rest[count - 1];
        rest = &rest[count..];
        Some(first as usize..last as usize + 1)
    })
}

#[cfg(test)]
mod tests {
    use super::runs;

    #[test]
    fn near_slots_are_written_together() {
        let found: Vec<_> = runs(&[3, 4, 9, 40, 400, 401]).collect();
        assert_eq!(found, [3..41, 400..402], "a gap of 360");
        assert_eq!(runs(&[]).count(), 0);
    }
}
