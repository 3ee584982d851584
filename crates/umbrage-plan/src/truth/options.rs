//! Options for tracing truth, and its callbacks.

use umbrage_core::{BackendError, Camera, Geometry, Receivers};

/// Precision of truth.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct TruthOptions {
    /// Rays a receiver for lights with an extent; powers of two are best. Ideal lights use one.
    pub samples: u32,
    /// Factor on the rays of receivers in penumbra, 1 or more.
    pub penumbra_factor: u32,
    /// Rays a receiver for finding ambiguous pixels.
    pub probe_samples: u32,
    /// Change of a penumbra's visibility above which a moved pixel is ambiguous, 0..=1. The default
    /// is twice the noise of `probe_samples` rays across one edge (each misplaced edge costs about
    /// one sample per row of the square they form). It is well below the change from moving a
    /// surface or shadow edge by .02 pixels.
    pub ambiguous_change: f32,
    /// Side of the square blocks of pixels of which one random pixel each is evaluated; 1 evaluates
    /// all. The other pixels get a preview of a few rays. It shows the shadows' edges and counts in
    /// no error ([`Pixel::Unsampled`](umbrage_core::metrics::Pixel::Unsampled)).
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

/// Callback that finds the receivers visible to a camera, such as `Cpu::receivers`.
pub type FindReceivers<'a> = dyn FnMut(&Camera, &Geometry) -> Result<Receivers, BackendError> + 'a;

/// Callback that receives the work done and the total work, in receivers, from any thread.
pub type Progress<'a> = dyn Fn(usize, usize) + Sync + 'a;
