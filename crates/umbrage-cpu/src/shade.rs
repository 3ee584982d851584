//! The last stage, for pictures alone: colours.

use rayon::prelude::*;
use umbrage_core::{NO_TRIANGLE, Receivers, Shade};

/// Colours every pixel that shows a triangle; `mask` is the light's visibility.
pub(crate) fn shade(shade: &Shade, receivers: &Receivers, mask: &[f32]) -> Vec<[f32; 4]> {
    let width = receivers.size.x as usize;
    let mut picture = vec![shade.background; receivers.len()];
    picture
        .par_chunks_mut(width)
        .zip(mask.par_chunks(width))
        .enumerate()
        .for_each(|(row, (out, mask))| {
            shade_row(shade, receivers, row * width, mask, out);
        });
    picture
}

/// One row: colours from its first pixel that shows a triangle to its last, then restores the background between.
fn shade_row(
    shade: &Shade,
    receivers: &Receivers,
    first: usize,
    mask: &[f32],
    out: &mut [[f32; 4]],
) {
    let seen = &receivers.triangle[first..first + out.len()];
    let Some(start) = seen.iter().position(|&id| id != NO_TRIANGLE) else {
        return;
    };
    let end = seen
        .iter()
        .rposition(|&id| id != NO_TRIANGLE)
        .map_or(start, |last| last + 1);
    shade.kernel.shade(
        &receivers.span(first + start, end - start),
        &mask[start..end],
        &mut out[start..end],
    );
    for (out, &id) in out[start..end].iter_mut().zip(&seen[start..end]) {
        *out = if id == NO_TRIANGLE {
            shade.background
        } else {
            *out
        };
    }
}
