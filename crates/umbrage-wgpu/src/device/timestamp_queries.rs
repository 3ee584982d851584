//! Timestamp queries for the GPU times of the stages.

use crate::{
    device::readback::{ReadBack, Ticket},
    resources::{query_pairs::QueryPairs, timestamps::PassTimestamps},
};
use std::time::Duration;
use umbrage_core::{BackendError, Recipe, Timings};
use wgpu::{CommandEncoder, Device, Features, QuerySet, Queue};

/// Queries for begin and end of four stages: receivers, casts, filters, receive.
#[derive(Debug)]
pub(crate) struct TimestampQueries {
    pairs: QueryPairs,
    /// Nanoseconds per tick.
    nanoseconds: f64,
}

const STAGES: u32 = 4;

impl TimestampQueries {
    /// Returns `None` if the device has no timestamps.
    pub(crate) fn new(device: &Device, queue: &Queue) -> Option<Self> {
        if !device.features().contains(Features::TIMESTAMP_QUERY) {
            return None;
        }
        Some(Self {
            pairs: QueryPairs::new(device, "umbrage stages", STAGES),
            nanoseconds: f64::from(queue.get_timestamp_period()),
        })
    }

    pub(crate) fn queries(&self) -> &QuerySet {
        &self.pairs.set
    }

    pub(crate) fn stamps(&self) -> PassTimestamps<'_> {
        PassTimestamps {
            queries: &self.pairs.set,
            first: 2,
        }
    }

    /// Records the copy of the written queries.
    pub(crate) fn read(
        &self,
        encoder: &mut CommandEncoder,
        stages: StagesWithPasses,
        back: &mut ReadBack<'_>,
    ) -> Ticket {
        for (stage, has_passes) in (0..STAGES).zip(stages.0) {
            if has_passes {
                self.pairs.resolve(encoder, stage);
            }
        }
        back.buffer(encoder, &self.pairs.resolved)
    }

    pub(crate) fn timings(
        &self,
        stages: StagesWithPasses,
        back: &ReadBack<'_>,
        ticket: Ticket,
    ) -> Result<Timings, BackendError> {
        let bytes: Vec<u8> = back.read(ticket)?;
        let stage = |stage: u32| -> Option<Duration> {
            if !stages.0[stage as usize] {
                return None;
            }
            let nanoseconds = QueryPairs::elapsed_ticks(&bytes, stage)? as f64 * self.nanoseconds;
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

/// The stages that have passes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StagesWithPasses([bool; STAGES as usize]);

impl StagesWithPasses {
    pub(crate) fn new(recipe: &Recipe, finds_receivers: bool) -> Self {
        Self([
            finds_receivers,
            !recipe.casts.is_empty(),
            !recipe.filters.is_empty() || recipe.hierarchy.is_some(),
            true,
        ])
    }
}
