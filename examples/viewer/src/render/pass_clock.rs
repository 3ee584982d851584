//! How long each pass of a frame takes on the device, where it has timestamps.

use super::SIDES;
use std::sync::{
    Arc,
    atomic::{AtomicU8, Ordering},
};
use std::time::Duration;
use umbrage::glam::UVec2;
use umbrage::wgpu::{PassCasters, SetPass, TimedPass};

/// Most timestamps of a frame.
const QUERIES: u32 = 128;
const BYTES: u64 = 8 * QUERIES as u64;

const IDLE: u8 = 0;
const UNDER_WAY: u8 = 1;
const READY: u8 = 2;

/// Timestamps of a frame now and then: of the next one once the last ones have been read.
pub(crate) struct PassClock {
    pub queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    read: wgpu::Buffer,
    state: Arc<AtomicU8>,
    nanoseconds_a_tick: f64,
    /// Of the frame that is timed: a pass, and its first query.
    names: Vec<(String, u32)>,
    /// Timestamps that it has written so far.
    pub written: u32,
    /// What passes took, milliseconds.
    pub times: Vec<(String, f64)>,
    /// Whether each side draws all of its maps and lists in the frame that is timed.
    draws_all: [bool; 2],
    /// What the drawing of all of a side's maps and lists took, milliseconds; none before it is timed.
    drawn_ms: [Option<f64>; 2],
    /// The frame that is timed: its size, pixels; none if it rests.
    moving: Option<UVec2>,
    /// The last frame that was timed while something moved, until it is taken.
    timed: Option<TimedFrame>,
}

/// What a frame took on the device.
#[derive(Clone, Copy)]
pub(crate) struct TimedFrame {
    /// Pixels.
    pub size: UVec2,
    pub took: Duration,
}

impl PassClock {
    /// Returns a clock; none where the device has no timestamps.
    pub(crate) fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Option<Self> {
        if !device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
            return None;
        }
        let buffer = |label, usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: BYTES,
                usage,
                mapped_at_creation: false,
            })
        };
        let copied = wgpu::BufferUsages::COPY_SRC;
        Some(Self {
            queries: device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("passes"),
                ty: wgpu::QueryType::Timestamp,
                count: QUERIES,
            }),
            resolved: buffer("resolved", wgpu::BufferUsages::QUERY_RESOLVE | copied),
            read: buffer(
                "read",
                wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            ),
            state: Arc::new(AtomicU8::new(IDLE)),
            nanoseconds_a_tick: f64::from(queue.get_timestamp_period()),
            names: Vec::new(),
            written: 0,
            times: Vec::new(),
            draws_all: [false; 2],
            drawn_ms: [None; 2],
            moving: None,
            timed: None,
        })
    }

    /// Begins to time a frame; `moving` is its size if something moves. Returns whether it can be timed: not while timestamps of another one are
    /// on their way.
    pub(crate) fn begin(&mut self, moving: Option<UVec2>) -> bool {
        self.take();
        if self.state.load(Ordering::Acquire) != IDLE {
            return false;
        }
        self.names.clear();
        self.written = 0;
        self.draws_all = [false; 2];
        self.moving = moving;
        true
    }

    /// Returns what a side's maps and lists, of all lights, took when all of them were drawn, milliseconds; none before they are timed.
    pub(crate) fn drawn_ms(&self, side: usize) -> Option<f64> {
        self.drawn_ms[side]
    }

    /// Forgets what a side's maps and lists took, since they are others now; those of a frame that is on its way, too.
    pub(crate) fn forget_drawn(&mut self, side: usize) {
        self.drawn_ms[side] = None;
        self.draws_all[side] = false;
    }

    /// Returns the last frame that was timed while something moved, once.
    pub(crate) fn take_moving_frame(&mut self) -> Option<TimedFrame> {
        self.timed.take()
    }

    /// Returns the queries that are left.
    pub(crate) fn rest(&self) -> std::ops::Range<u32> {
        // The picture's two stay free.
        self.written..QUERIES - 2
    }

    /// Notes the passes of a side (0 or 1) that were timed, and whether they draw all of its maps and lists.
    pub(crate) fn note(&mut self, side: usize, draws_all: bool, passes: &[TimedPass]) {
        self.draws_all[side] = draws_all;
        let side = SIDES[side];
        for pass in passes {
            let what = match pass.pass {
                SetPass::Cast { layer, casters } => {
                    let casters = match casters {
                        PassCasters::All => "",
                        PassCasters::Still => ", what is still",
                        PassCasters::Moving => ", what moves",
                    };
                    format!("map {}{casters}", layer + 1)
                }
                SetPass::Filters => "filters".to_owned(),
                SetPass::Lists => "lists".to_owned(),
                SetPass::Mask => "mask".to_owned(),
            };
            self.names.push((format!("{side}: {what}"), pass.begin));
            self.written = self.written.max(pass.begin + 2);
        }
    }

    /// Returns the timestamps of the picture's pass.
    pub(crate) fn of_picture(&mut self) -> wgpu::RenderPassTimestampWrites<'_> {
        let begin = self.written;
        self.written += 2;
        self.names.push(("picture".to_owned(), begin));
        wgpu::RenderPassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(begin),
            end_of_pass_write_index: Some(begin + 1),
        }
    }

    /// Records what hands the timestamps out.
    pub(crate) fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.resolve_query_set(&self.queries, 0..self.written, &self.resolved, 0);
        let bytes = 8 * u64::from(self.written);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.read, 0, bytes);
    }

    /// Asks for the timestamps, once the encoder is submitted.
    pub(crate) fn fetch(&self) {
        self.state.store(UNDER_WAY, Ordering::Release);
        let state = self.state.clone();
        self.read.map_async(wgpu::MapMode::Read, .., move |result| {
            // What failed is tried again with the next frame.
            let outcome = if result.is_ok() { READY } else { IDLE };
            state.store(outcome, Ordering::Release);
        });
    }

    /// Takes timestamps that are there.
    fn take(&mut self) {
        if self.state.load(Ordering::Acquire) != READY {
            return;
        }
        if let Ok(view) = self.read.slice(..).get_mapped_range() {
            let ticks: Vec<u64> = view
                .as_chunks::<8>()
                .0
                .iter()
                .map(|bytes| u64::from_le_bytes(*bytes))
                .collect();
            let milliseconds = |begin: u32| {
                let [begin, end] = [ticks[begin as usize], ticks[begin as usize + 1]];
                end.saturating_sub(begin) as f64 * self.nanoseconds_a_tick * 1e-6
            };
            let timed = self.names.iter();
            self.times = timed
                .map(|(name, begin)| (name.clone(), milliseconds(*begin)))
                .collect();
            for (i, side) in SIDES.iter().enumerate() {
                if self.draws_all[i] {
                    let of_side = self.times.iter().filter(|(name, _)| name.starts_with(side));
                    self.drawn_ms[i] = Some(of_side.map(|(_, time)| time).sum());
                }
            }
            if let Some(size) = self.moving {
                let milliseconds: f64 = self.times.iter().map(|(_, time)| time).sum();
                let took = Duration::from_secs_f64(1e-3 * milliseconds);
                self.timed = Some(TimedFrame { size, took });
            }
        }
        self.read.unmap();
        self.state.store(IDLE, Ordering::Release);
    }
}
