//! Pairs of timestamp queries: begin and end of a timed section.

use wgpu::{
    Buffer, BufferDescriptor, BufferUsages, CommandEncoder, Device, QUERY_RESOLVE_BUFFER_ALIGNMENT,
    QuerySet, QuerySetDescriptor, QueryType,
};

/// Query pairs, and a buffer for their timestamps.
#[derive(Debug)]
pub(crate) struct QueryPairs {
    pub(crate) set: QuerySet,
    pub(crate) resolved: Buffer,
}

impl QueryPairs {
    pub(crate) fn new(device: &Device, label: &str, pairs: u32) -> Self {
        Self {
            set: device.create_query_set(&QuerySetDescriptor {
                label: Some(label),
                ty: QueryType::Timestamp,
                count: 2 * pairs,
            }),
            resolved: device.create_buffer(&BufferDescriptor {
                label: Some(label),
                size: QUERY_RESOLVE_BUFFER_ALIGNMENT * u64::from(pairs),
                usage: BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            }),
        }
    }

    /// Records the resolution of a written pair. Resolving others could wait forever.
    pub(crate) fn resolve(&self, encoder: &mut CommandEncoder, pair: u32) {
        let offset = QUERY_RESOLVE_BUFFER_ALIGNMENT * u64::from(pair);
        let queries = 2 * pair..2 * pair + 2;
        encoder.resolve_query_set(&self.set, queries, &self.resolved, offset);
    }

    /// Returns the ticks between the two timestamps of a pair, given the contents of the buffer.
    pub(crate) fn elapsed_ticks(bytes: &[u8], pair: u32) -> Option<u64> {
        let begin = pair as usize * QUERY_RESOLVE_BUFFER_ALIGNMENT as usize;
        let tick = |at: usize| Some(u64::from_le_bytes(*bytes.get(at..)?.first_chunk()?));
        tick(begin + size_of::<u64>())?.checked_sub(tick(begin)?)
    }
}
