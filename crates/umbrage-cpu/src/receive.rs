//! Receive stage: computes the light's visibility for every receiver.

use crate::images::views;
use rayon::prelude::*;
use umbrage_core::{Image, Inputs, Receivers, Recipe, Simd, Span};

/// Width, pixels, of a block of receivers that is finished before the next one begins.
///
/// Neighbours in both directions look up the same part of a map, and a block's part stays in the
/// nearest cache.
const BLOCK_WIDTH: usize = 128;
const BLOCK_HEIGHT: usize = 16;

/// Runs the receive kernel for every receiver, and returns the mask.
pub(crate) fn receive(
    images: &[Image],
    recipe: &Recipe,
    receivers: &Receivers,
    simd: Simd,
) -> Vec<f32> {
    if let Some(mask) = recipe.receive.kernel.receive_all(simd, receivers) {
        return mask;
    }
    // Build the tables, since kernels may read their sources.
    recipe.make_tables();
    let views = views(images, &recipe.receive.inputs);
    let inputs = Inputs {
        images: &views,
        simd,
    };
    let width = receivers.size.x as usize;
    let mut mask = vec![1.0; receivers.len()];
    let bands = mask.par_chunks_mut(width * BLOCK_HEIGHT).enumerate();
    bands.for_each(|(band, out)| {
        let first = band * BLOCK_HEIGHT * width;
        for left in (0..width).step_by(BLOCK_WIDTH) {
            let right = (left + BLOCK_WIDTH).min(width);
            for (row, out) in out.chunks_exact_mut(width).enumerate() {
                let pixel = first + row * width + left;
                receive_span(&inputs, recipe, receivers, pixel, &mut out[left..right]);
            }
        }
    });
    mask
}

/// Runs the kernel for a part of one row, from its first receiving pixel to its last, then sets the
/// pixels between that don't receive shadows to lit.
pub(crate) fn receive_span(
    inputs: &Inputs<'_>,
    recipe: &Recipe,
    receivers: &Receivers,
    first: usize,
    out: &mut [f32],
) {
    let receives = &receivers.receives[first..first + out.len()];
    let Some(start) = receives.iter().position(|&r| r) else {
        return;
    };
    let last = receives.iter().rposition(|&r| r).unwrap_or(start);
    let span: Span<'_> = receivers.span(first + start, last + 1 - start);
    let out = &mut out[start..=last];
    recipe.receive.kernel.receive(inputs, &span, out);
    for (out, &receives) in out.iter_mut().zip(&receives[start..=last]) {
        if !receives {
            *out = 1.0;
        }
    }
}
