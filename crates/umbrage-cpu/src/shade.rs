//! Shade stage: computes colours, for images only.

use rayon::prelude::*;
use umbrage_core::{NO_TRIANGLE, Receivers, Shade};

/// Colours every pixel that shows a triangle; `mask` is the light's visibility.
pub(crate) fn shade(shade: &Shade, receivers: &Receivers, mask: &[f32]) -> Vec<[f32; 4]> {
    let width = receivers.size.x as usize;
    let mut picture = vec![shade.background; receivers.len()];
    let rows = picture.par_chunks_mut(width).zip(mask.par_chunks(width));
    rows.enumerate().for_each(|(row, (out, mask))| {
        shade_row(shade, receivers, row * width, mask, out);
    });
    picture
}

/// Colours one row, from its first pixel that shows a triangle to its last, then restores the
/// background between.
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
    let last = seen.iter().rposition(|&id| id != NO_TRIANGLE);
    let last = last.unwrap_or(start);
    let span = receivers.span(first + start, last + 1 - start);
    let out = &mut out[start..=last];
    shade.kernel.shade(&span, &mask[start..=last], out);
    for (out, &id) in out.iter_mut().zip(&seen[start..=last]) {
        if id == NO_TRIANGLE {
            *out = shade.background;
        }
    }
}
