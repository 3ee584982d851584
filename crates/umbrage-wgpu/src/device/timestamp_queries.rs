//! Timestamp queries, which tell how long the stages took on the GPU.

use crate::{
    device::readback::{ReadBack, Ticket},
    resources::timestamps::PassTimestamps,
};
use std::time::Duration;
use umbrage_core::{BackendError, Recipe, Timings};
use wgpu::{
    Buffer, BufferDescriptor, BufferUsages, CommandEncoder, Device, Features,
    QUERY_RESOLVE_BUFFER_ALIGNMENT, QuerySet, QuerySetDescriptor, QueryType, Queue,
};

/// Queries for begin and end of four stages: receivers, casts, filters, receive.
#[derive(Debug)]
pub(crate) struct TimestampQueries {
    pub(crate) queries: QuerySet,
    resolved: Buffer,
    /// Nanoseconds a tick.
    nanoseconds: f64,
}

const STAGES: u32 = 4;

impl TimestampQueries {
    /// Returns `None` where the device has no timestamps.
    pub(crate) fn new(device: &Device, queue: &Queue) -> Option<Self> {
        if !device.features().contains(Features::TIMESTAMP_QUERY) {
            return None;
        }
        let queries = device.create_query_set(&QuerySetDescriptor {
            label: Some("umbrage stages"),
            ty: QueryType::Timestamp,
            count: 2 * STAGES,
        });
        let resolved = device.create_buffer(&BufferDescriptor {
            label: Some("umbrage stages"),
            size: QUERY_RESOLVE_BUFFER_ALIGNMENT * u64::from(STAGES),
            usage: BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        Some(Self {
            queries,
            resolved,
            nanoseconds: f64::from(queue.get_timestamp_period()),
        })
    }

    pub(crate) fn stamps(&self) -> PassTimestamps<'_> {
        PassTimestamps {
            queries: &self.queries,
            first: 2,
        }
    }

    /// Records the copy of the queries that were written. Waiting for others could take forever.
    pub(crate) fn read(
        &self,
        encoder: &mut CommandEncoder,
        played: StagesWithPasses,
        back: &mut ReadBack<'_>,
    ) -> Ticket {
        for (stage, has_passes) in (0..STAGES).zip(played.0) {
            if has_passes {
                let pair = 2 * stage..2 * stage + 2;
                let offset = QUERY_RESOLVE_BUFFER_ALIGNMENT * u64::from(stage);
                encoder.resolve_query_set(&self.queries, pair, &self.resolved, offset);
            }
        }
        back.buffer(encoder, &self.resolved)
    }

    pub(crate) fn timings(
        &self,
        played: StagesWithPasses,
        back: &ReadBack<'_>,
        ticket: Ticket,
    ) -> Result<Timings, BackendError> {
        let ticks: Vec<u64> = back.read(ticket)?;
        let stage = |i: usize| -> Option<Duration> {
            if !played.0[i] {
                return None;
            }
            let begin = i * QUERY_RESOLVE_BUFFER_ALIGNMENT as usize / size_of::<u64>();
            let elapsed = ticks[begin + 1].checked_sub(ticks[begin])?;
            let nanoseconds = elapsed as f64 * self.nanoseconds;
            Some(Duration::from_nanos(nanoseconds as u64))
        };
        Ok(Timings {
            receivers: stage(0),
            cast: stage(1),
            filter: stage(2),
            receive: stage(3),
        })
    }
}

/// Which stages had passes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StagesWithPasses([bool; STAGES as usize]);

impl StagesWithPasses {
    pub(crate) fn new(recipe: &Recipe, finds_receivers: bool) -> Self {
        Self([
            finds_receivers,
            !recipe.casts.is_empty(),
            !recipe.filters.is_empty(),
            true,
        ])
    }
}
