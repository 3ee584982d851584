//! Device times of each pass of a frame, if the device has timestamps.

use super::readback::{Readback, Timestamps};
use crate::side::SIDES;
use std::time::Duration;
use umbrage::{
    glam::UVec2,
    gpu::{PassCasters, SetPass, SetTimestamps, TimedPass},
};

/// Greatest number of timestamps of a frame.
const QUERIES: u32 = 128;

/// A timed frame.
#[derive(Default)]
struct FrameStamps {
    /// The pass of each pair of timestamps.
    names: Vec<String>,
    /// `true` if each side draws all of its maps and lists.
    draws_all: [bool; 2],
    /// Size of the frame, pixels, if something moves.
    moving: Option<UVec2>,
}

/// Clock that times one frame after the other: the next one after the timestamps of the last one
/// have been read.
pub(crate) struct PassClock {
    stamps: Timestamps,
    frame: FrameStamps,
    /// Timestamps to be read.
    recorded: Option<wgpu::Buffer>,
    pending: Option<Readback>,
    /// Times of passes, milliseconds.
    pub times: Vec<(String, f64)>,
    /// Time to draw all maps and lists of each side, milliseconds. `None` before it is measured.
    pub drawn_ms: [Option<f64>; 2],
    /// The last timed frame in motion: its size, pixels, and its device time. The receiver removes
    /// it.
    pub moving_frame: Option<(UVec2, Duration)>,
}

impl PassClock {
    /// Creates a clock. Returns `None` if the device has no timestamps.
    pub(super) fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Option<Self> {
        Some(Self {
            stamps: Timestamps::new(device, queue, QUERIES)?,
            frame: FrameStamps::default(),
            recorded: None,
            pending: None,
            times: Vec::new(),
            drawn_ms: [None; 2],
            moving_frame: None,
        })
    }

    /// Starts to time a frame. `moving` is its size if something moves. Returns `false` while
    /// timestamps of another frame are pending.
    pub(super) fn begin(&mut self, moving: Option<UVec2>) -> bool {
        self.take();
        if self.pending.is_some() {
            return false;
        }
        self.frame = FrameStamps {
            moving,
            ..FrameStamps::default()
        };
        true
    }

    /// Discards the time of a side's changed maps and lists, and that of a pending frame.
    pub(super) fn forget_drawn(&mut self, side: usize) {
        self.drawn_ms[side] = None;
        self.frame.draws_all[side] = false;
    }

    fn written_count(&self) -> u32 {
        2 * self.frame.names.len() as u32
    }

    /// Returns the remaining queries for a set.
    pub(super) fn for_set(&self) -> SetTimestamps<'_> {
        SetTimestamps {
            queries: &self.stamps.queries,
            // Reserve the last two for the image.
            range: self.written_count()..QUERIES - 2,
        }
    }

    /// Records the timed passes of a side, and whether they draw all of its maps and lists.
    pub(super) fn note(&mut self, side: usize, draws_all: bool, passes: &[TimedPass]) {
        self.frame.draws_all[side] = draws_all;
        for pass in passes {
            let label = pass_label(pass.pass);
            self.frame.names.push(format!("{}: {label}", SIDES[side]));
        }
    }

    /// Returns the timestamps of the image's pass, which is the last one.
    pub(super) fn for_picture(&mut self) -> wgpu::RenderPassTimestampWrites<'_> {
        let begin = self.written_count();
        self.frame.names.push("picture".to_owned());
        wgpu::RenderPassTimestampWrites {
            query_set: &self.stamps.queries,
            beginning_of_pass_write_index: Some(begin),
            end_of_pass_write_index: Some(begin + 1),
        }
    }

    /// Records the copy of the timestamps.
    pub(super) fn resolve(&mut self, device: &wgpu::Device, encoder: &mut wgpu::CommandEncoder) {
        self.recorded = Some(self.stamps.resolve(device, encoder, self.written_count()));
    }

    /// Starts to read the timestamps, once the encoder is submitted.
    pub(super) fn fetch(&mut self) {
        self.pending = self.recorded.take().map(Readback::start);
    }

    /// Receives available timestamps.
    fn take(&mut self) {
        let Some(pending) = &self.pending else {
            return;
        };
        let times = match self.stamps.take(pending) {
            Ok(None) => return,
            Ok(Some(times)) => times,
            // Time the next frame instead.
            Err(_) => Vec::new(),
        };
        self.pending = None;
        if times.is_empty() {
            return;
        }
        let frame = std::mem::take(&mut self.frame);
        self.times = frame.names.into_iter().zip(times).collect();
        let sum = |begin: &str| -> f64 {
            let all = self.times.iter();
            let those = all.filter(|(name, _)| name.starts_with(begin));
            those.map(|(_, time)| time).sum()
        };
        for (side, name) in SIDES.iter().enumerate() {
            if frame.draws_all[side] {
                self.drawn_ms[side] = Some(sum(name));
            }
        }
        if let Some(size) = frame.moving {
            self.moving_frame = Some((size, Duration::from_secs_f64(1e-3 * sum(""))));
        }
    }
}

fn pass_label(pass: SetPass) -> String {
    match pass {
        SetPass::Cast { layer, casters } => {
            let casters = match casters {
                PassCasters::All => "",
                PassCasters::Still => ", what is still",
                PassCasters::Moving => ", what moves",
            };
            format!("map {}{casters}", layer + 1)
        }
        SetPass::Filters => "filters".to_owned(),
        SetPass::Hierarchy => "hierarchy".to_owned(),
        SetPass::Mask => "mask".to_owned(),
    }
}
