//! Timestamp queries: how long the stages took on the GPU.

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

/// Begin and end of four stages: receivers, casts, filters, lookup.
#[derive(Debug)]
pub(crate) struct TimestampQueries {
    pub(crate) queries: QuerySet,
    resolved: Buffer,
    nanoseconds: f64,
}

const STAGES: u32 = 4;

impl TimestampQueries {
    /// None where the device cannot tell the time.
    pub(crate) fn new(device: &Device, queue: &Queue) -> Option<Self> {
        device
            .features()
            .contains(Features::TIMESTAMP_QUERY)
            .then(|| Self {
                queries: device.create_query_set(&QuerySetDescriptor {
                    label: Some("umbrage stages"),
                    ty: QueryType::Timestamp,
                    count: 2 * STAGES,
                }),
                resolved: device.create_buffer(&BufferDescriptor {
                    label: Some("umbrage stages"),
                    size: QUERY_RESOLVE_BUFFER_ALIGNMENT * u64::from(STAGES),
                    usage: BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC,
                    mapped_at_creation: false,
                }),
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
        for (stage, _) in (0..STAGES).zip(played.0).filter(|(_, played)| *played) {
            let offset = QUERY_RESOLVE_BUFFER_ALIGNMENT * u64::from(stage);
            encoder.resolve_query_set(
                &self.queries,
                2 * stage..2 * stage + 2,
                &self.resolved,
                offset,
            );
        }
        back.buffer(encoder, &self.resolved)
    }

    pub(crate) fn timings(
        &self,
        played: StagesWithPasses,
        back: &ReadBack<'_>,
        t: Ticket,
    ) -> Result<Timings, BackendError> {
        let ticks: Vec<u64> = back.read(t)?;
        let stage = |i: usize| {
            let first = i * QUERY_RESOLVE_BUFFER_ALIGNMENT as usize / size_of::<u64>();
            let between = ticks[first + 1]
                .checked_sub(ticks[first])
                .filter(|_| played.0[i])?;
            Some(Duration::from_nanos(
                (between as f64 * self.nanoseconds) as u64,
            ))
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
