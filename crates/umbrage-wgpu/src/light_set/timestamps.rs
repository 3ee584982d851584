//! Timestamps around the passes of a set.

use crate::{
    light_set::{
        ids::{LightId, LightKey, SetNumber},
        prices::FrameMeter,
    },
    resources::timestamps::{PassTimestamps, TimedStage},
};
use std::ops::Range;
use wgpu::{ComputePassTimestampWrites, QuerySet, RenderPassTimestampWrites};

/// Timestamp queries for [`LightSet::encode_timed`](crate::LightSet::encode_timed) and
/// [`encode_masks_timed`](crate::LightSet::encode_masks_timed): two for each pass, its begin and
/// its end.
#[derive(Clone, Debug)]
pub struct SetTimestamps<'a> {
    /// A set of kind `Timestamp`.
    pub queries: &'a QuerySet,
    /// Range of queries that may be written. Passes beyond it are not timed.
    pub range: Range<u32>,
}

/// A pass of a set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SetPass {
    /// Draws casters into one layer of a light.
    Cast {
        /// Index among the light's layers.
        layer: u32,
        /// The casters that it draws.
        casters: PassCasters,
    },
    /// All filter passes of a light's layers.
    Filters,
    /// All passes that build a light's hierarchy of casters; the first one also includes the
    /// transform of the casters.
    Hierarchy,
    /// A light's mask. If it is computed in [`MaskFormat::Unorm8`](crate::MaskFormat), without the
    /// copy to its layer.
    Mask,
}

/// Casters drawn by a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PassCasters {
    /// All casters, into the light's layer.
    All,
    /// The still casters, into a separate layer.
    Still,
    /// The moving casters, on a copy of that layer.
    Moving,
}

/// A timed pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimedPass {
    /// The light.
    pub light: LightId,
    /// The kind of pass.
    pub pass: SetPass,
    /// Index of the query of its begin; that of its end is the next one.
    pub begin: u32,
}

/// Timestamps for the passes of a frame, from the caller's queries or the set's own.
#[derive(Debug, Default)]
pub(crate) struct PassClock<'a, 'out> {
    pub(crate) timer: Option<PassTimer<'a, 'out>>,
    pub(crate) meter: Option<FrameMeter<'a>>,
}

impl PassClock<'_, '_> {
    /// Returns the timestamps of a pass that draws this number of triangles.
    pub(crate) fn cast(
        &mut self,
        light: LightKey,
        layer: u32,
        casters: PassCasters,
        triangles: u64,
    ) -> Option<RenderPassTimestampWrites<'_>> {
        if let Some(timer) = &mut self.timer {
            return timer.writes(light, SetPass::Cast { layer, casters });
        }
        let meter = self.meter.as_mut()?;
        // Skip draws onto a copy: they are not cleared first, unlike other passes.
        if casters == PassCasters::Moving {
            return None;
        }
        meter.draw(triangles)
    }

    /// Returns the timestamps of all filter passes of a light's layers. They follow a cast pass.
    pub(crate) fn filters(&mut self, light: LightKey) -> Option<PassTimestamps<'_>> {
        let timer = self.timer.as_mut()?;
        let begin = timer.begin(light, SetPass::Filters)?;
        Some(PassTimestamps {
            queries: timer.queries,
            first: begin - 2 * TimedStage::Filter as u32,
        })
    }
}

/// Assigns queries to passes, and records the assignment.
#[derive(Debug)]
pub(crate) struct PassTimer<'a, 'out> {
    set: SetNumber,
    queries: &'a QuerySet,
    left: Range<u32>,
    out: &'out mut Vec<TimedPass>,
}

impl<'a, 'out> PassTimer<'a, 'out> {
    pub(crate) fn new(
        set: SetNumber,
        stamps: &SetTimestamps<'a>,
        out: &'out mut Vec<TimedPass>,
    ) -> Self {
        out.clear();
        Self {
            set,
            queries: stamps.queries,
            left: stamps.range.clone(),
            out,
        }
    }

    /// Returns the first of two queries for a pass, if there are any left.
    fn begin(&mut self, light: LightKey, pass: SetPass) -> Option<u32> {
        if self.left.len() < 2 {
            return None;
        }
        let begin = self.left.start;
        self.left.start += 2;
        let light = LightId::new(self.set, light);
        self.out.push(TimedPass { light, pass, begin });
        Some(begin)
    }

    /// Returns the timestamps of one compute pass.
    pub(crate) fn compute_writes(
        &mut self,
        light: LightKey,
        pass: SetPass,
    ) -> Option<ComputePassTimestampWrites<'a>> {
        let begin = self.begin(light, pass)?;
        Some(ComputePassTimestampWrites {
            query_set: self.queries,
            beginning_of_pass_write_index: Some(begin),
            end_of_pass_write_index: Some(begin + 1),
        })
    }

    /// Returns the timestamps of one render pass.
    pub(crate) fn writes(
        &mut self,
        light: LightKey,
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
