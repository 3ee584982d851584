//! Options of tracing truth, and the functions that it calls.

use umbrage_core::{BackendError, Camera, Geometry, Receivers};

/// How carefully truth is traced.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct TruthOptions {
    /// Rays a receiver for lights with an extent; powers of two are best. Ideal lights take one.
    pub samples: u32,
    /// Receivers in penumbra get this many times as many rays, 1 or more.
    pub penumbra_factor: u32,
    /// Rays a receiver for finding out whether its visibility is ambiguous.
    pub probe_samples: u32,
    /// Penumbra values that change by more than this under a nudge are ambiguous, 0..=1. Twice the
    /// noise of `probe_samples` rays across one edge (each misplaced edge costs about one sample
    /// per row of the square they form), and well below what a surface or shadow edge moved by .02
    /// pixels changes.
    pub ambiguous_change: f32,
    /// Side of the square blocks of pixels of each of which one pixel is judged, drawn at random: 1
    /// judges all pixels. The others get a preview of a few rays, which tells where shadows' edges
    /// lie and counts in no error ([`Pixel::Unsampled`](umbrage_core::metrics::Pixel::Unsampled)).
    pub block_side: u32,
}

impl Default for TruthOptions {
    fn default() -> Self {
        Self {
            samples: 1024,
            penumbra_factor: 4,
            probe_samples: 64,
            ambiguous_change: 0.125,
            block_side: 1,
        }
    }
}

/// Finds the receivers that a camera sees, such as `Cpu::receivers`.
pub type FindReceivers<'a> = dyn FnMut(&Camera, &Geometry) -> Result<Receivers, BackendError> + 'a;

/// Called with the work done and the work in all, in receivers, from any thread.
pub type Progress<'a> = dyn Fn(usize, usize) + Sync + 'a;
