//! The third stage: every receiver is asked how much light arrives.

use crate::images::views;
use rayon::prelude::*;
use umbrage_core::{Image, Inputs, Receivers, Recipe, Simd, Span};

/// A block of receivers that is asked before the next one begins, pixels. Neighbours in both directions look up the
/// same part of a map, and a block's part stays in the nearest cache.
const BLOCK: [usize; 2] = [128, 16];

/// Asks every receiver: the mask.
pub(crate) fn receive(
    images: &[Image],
    recipe: &Recipe,
    receivers: &Receivers,
    simd: Simd,
) -> Vec<f32> {
    let views = views(images, &recipe.receive.inputs);
    let inputs = Inputs {
        images: &views,
        simd,
    };
    let width = receivers.size.x as usize;
    let mut mask = vec![1.0; receivers.len()];
    mask.par_chunks_mut(width * BLOCK[1])
        .enumerate()
        .for_each(|(band, out)| {
            let first = band * BLOCK[1] * width;
            for left in (0..width).step_by(BLOCK[0]) {
                for (row, out) in out.chunks_exact_mut(width).enumerate() {
                    let out = &mut out[left..(left + BLOCK[0]).min(width)];
                    receive_span(&inputs, recipe, receivers, first + row * width + left, out);
                }
            }
        });
    mask
}

/// A part of one row: asks from its first receiving pixel to its last, then lights those between that receive nothing.
fn receive_span(
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
    let end = receives
        .iter()
        .rposition(|&r| r)
        .map_or(start, |last| last + 1);
    let span: Span<'_> = receivers.span(first + start, end - start);
    recipe
        .receive
        .kernel
        .receive(inputs, &span, &mut out[start..end]);
    for (out, &receives) in out[start..end].iter_mut().zip(&receives[start..end]) {
        *out = if receives { *out } else { 1.0 };
    }
}
