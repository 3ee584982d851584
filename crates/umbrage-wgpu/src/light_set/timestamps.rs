//! Timestamps around the passes of a set.

use crate::{
    light_set::{options::LightId, prices::FrameMeter},
    resources::timestamps::{PassTimestamps, TimedStage},
};
use std::ops::Range;
use wgpu::{ComputePassTimestampWrites, QuerySet, RenderPassTimestampWrites};

/// Timestamp queries that [`LightSet::encode_timed`](crate::LightSet::encode_timed) and
/// [`encode_masks_timed`](crate::LightSet::encode_masks_timed) write: two for each pass, its begin
/// and its end.
#[derive(Clone, Debug)]
pub struct SetTimestamps<'a> {
    /// A set of kind `Timestamp`.
    pub queries: &'a QuerySet,
    /// The queries that may be written. Passes for which none are left are not timed.
    pub range: Range<u32>,
}

/// What a pass of a set does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SetPass {
    /// Draws casters into one layer of a light.
    Cast {
        /// Index among the light's layers.
        layer: u32,
        /// Which casters.
        casters: PassCasters,
    },
    /// All passes that filter a light's layers.
    Filters,
    /// All passes that make a light's lists of casters; for the first one, placing the casters,
    /// too.
    Lists,
    /// A light's mask.
    Mask,
}

/// Which casters a pass draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PassCasters {
    /// All of them, into the light's layer.
    All,
    /// Those that are still, into a layer of their own.
    Still,
    /// Those that move, on a copy of that layer.
    Moving,
}

/// A pass that is timed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimedPass {
    /// The light.
    pub light: LightId,
    /// What the pass does.
    pub pass: SetPass,
    /// The query of its begin; that of its end is the next one.
    pub begin: u32,
}

/// What times the passes of a frame: the caller's queries, or else the set's own.
#[derive(Debug, Default)]
pub(crate) struct PassClock<'a, 'out> {
    pub(crate) timer: Option<PassTimer<'a, 'out>>,
    pub(crate) meter: Option<FrameMeter<'a>>,
}

impl PassClock<'_, '_> {
    /// Returns the timestamps of a pass that draws so many triangles.
    pub(crate) fn cast(
        &mut self,
        light: LightId,
        layer: u32,
        casters: PassCasters,
        triangles: u64,
    ) -> Option<RenderPassTimestampWrites<'_>> {
        if let Some(timer) = &mut self.timer {
            return timer.writes(light, SetPass::Cast { layer, casters });
        }
        let meter = self.meter.as_mut()?;
        // What is drawn onto a copy is not cleared first, as other passes are.
        if casters == PassCasters::Moving {
            return None;
        }
        meter.draw(triangles)
    }

    /// Returns the timestamps of all passes that filter a light's layers. They follow one that
    /// casts.
    pub(crate) fn filters(&mut self, light: LightId) -> Option<PassTimestamps<'_>> {
        let timer = self.timer.as_mut()?;
        let begin = timer.begin(light, SetPass::Filters)?;
        Some(PassTimestamps {
            queries: timer.queries,
            first: begin - 2 * TimedStage::Filter as u32,
        })
    }
}

/// Deals out queries to passes, and lists which pass got which.
#[derive(Debug)]
pub(crate) struct PassTimer<'a, 'out> {
    queries: &'a QuerySet,
    left: Range<u32>,
    out: &'out mut Vec<TimedPass>,
}

impl<'a, 'out> PassTimer<'a, 'out> {
    pub(crate) fn new(stamps: &SetTimestamps<'a>, out: &'out mut Vec<TimedPass>) -> Self {
        out.clear();
        Self {
            queries: stamps.queries,
            left: stamps.range.clone(),
            out,
        }
    }

    /// Returns the first of two queries for a pass, if there are any left.
    fn begin(&mut self, light: LightId, pass: SetPass) -> Option<u32> {
        if self.left.len() < 2 {
            return None;
        }
        let begin = self.left.start;
        self.left.start += 2;
        self.out.push(TimedPass { light, pass, begin });
        Some(begin)
    }

    /// Returns the timestamps of the pass that makes a light's lists.
    pub(crate) fn lists(&mut self, light: LightId) -> Option<ComputePassTimestampWrites<'a>> {
        let begin = self.begin(light, SetPass::Lists)?;
        Some(ComputePassTimestampWrites {
            query_set: self.queries,
            beginning_of_pass_write_index: Some(begin),
            end_of_pass_write_index: Some(begin + 1),
        })
    }

    /// Returns the timestamps of one pass.
    pub(crate) fn writes(
        &mut self,
        light: LightId,
        pass: SetPass,
    ) -> Option<RenderPassTimestampWrites<'a>> {
        let begin = self.begin(light, pass)?;
        Some(RenderPassTimestampWrites {
            query_set: self.queries,
            beginning_of_pass_write_index: Some(begin),
            end_of_pass_write_index: Some(begin + 1),
        })
    }
}
