//! Truth at the pixels of a request, with ambiguous pixels marked.

use super::{
    ambiguity::{self, Nudge},
    options::{FindReceivers, Progress, TruthOptions},
    points::{PointTruth, TruthRequest},
    tracer::Tracer,
};
use crate::error::MeasureError;
use std::sync::atomic::{AtomicUsize, Ordering};
use umbrage_core::{Light, metrics::Pixel};

/// Truth at the pixels of a request, in their order.
pub(super) struct JudgedPoints {
    pub(super) seen: Vec<PointTruth>,
    pub(super) ambiguous: Vec<bool>,
}

/// Traces truth at the pixels of a request, and marks the ambiguous ones.
pub(super) fn judge(
    request: &TruthRequest<'_>,
    light: &Light,
    options: &TruthOptions,
    find: &mut FindReceivers<'_>,
    progress: &Progress<'_>,
) -> Result<JudgedPoints, MeasureError> {
    let done = AtomicUsize::new(0);
    let total = request.pixels.len() * (1 + ambiguity::PROBES);
    let report = |n: usize| progress(done.fetch_add(n, Ordering::Relaxed) + n, total);
    let seen = request.trace(
        &Tracer::new(request.geometry, light, options)?,
        1.0,
        &report,
    );
    let ambiguous = ambiguity::find(request, light, options, Nudge::ROUNDING, find, &report)?;
    Ok(JudgedPoints { seen, ambiguous })
}

/// Returns the class of a pixel.
pub(super) fn class(receives: bool, seen: PointTruth, ambiguous: bool) -> Pixel {
    if !receives {
        Pixel::Empty
    } else if seen.unlit {
        Pixel::Unlit
    } else if ambiguous {
        Pixel::Ambiguous
    } else {
        Pixel::Counted
    }
}
