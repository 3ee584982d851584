//! Timestamps around the stages.

use wgpu::{ComputePassTimestampWrites, QuerySet, RenderPassTimestampWrites};

/// Six timestamp queries for [`ShadowRenderer::encode_timed`](crate::ShadowRenderer::encode_timed):
/// begin and end of casts, filters and the receive stage. Those of a stage without passes are not
/// written. Shading is not timed.
#[derive(Clone, Copy, Debug)]
pub struct PassTimestamps<'a> {
    /// A set of kind `Timestamp`.
    pub queries: &'a QuerySet,
    /// Index of the first of the six queries.
    pub first: u32,
}

/// A timed stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TimedStage {
    Cast,
    Filter,
    Receive,
}

/// Returns the timestamps of one of a stage's `count` passes: the first one writes the stage's
/// begin, the last one its end.
pub(crate) fn pass_stamps<'a>(
    stamps: Option<&PassTimestamps<'a>>,
    stage: TimedStage,
    index: usize,
    count: usize,
) -> Option<RenderPassTimestampWrites<'a>> {
    let stamps = stamps?;
    let begin = stamps.first + 2 * stage as u32;
    let is_first = index == 0;
    let is_last = index + 1 == count;
    (is_first || is_last).then_some(RenderPassTimestampWrites {
        query_set: stamps.queries,
        beginning_of_pass_write_index: is_first.then_some(begin),
        end_of_pass_write_index: is_last.then_some(begin + 1),
    })
}

/// Returns the timestamps of a compute pass, given those of a render pass.
pub(crate) fn of_compute(stamps: RenderPassTimestampWrites<'_>) -> ComputePassTimestampWrites<'_> {
    ComputePassTimestampWrites {
        query_set: stamps.query_set,
        beginning_of_pass_write_index: stamps.beginning_of_pass_write_index,
        end_of_pass_write_index: stamps.end_of_pass_write_index,
    }
}
