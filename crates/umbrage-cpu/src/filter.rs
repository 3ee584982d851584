//! Filter stage: computes images from images.

use crate::images::views;
use rayon::prelude::*;
use umbrage_core::{Filter, Format, Image, ImageDesc, Inputs, Recipe, Simd, SimdTask, glam::Vec4};

/// Runs all filters, and changes their outputs by the fractions `shift`, one per channel. It
/// changes them before storage, as a different order of sums would, and after it, as a different
/// rounding of reads would.
pub(crate) fn filter_all(images: &mut [Image], recipe: &Recipe, simd: Simd, shift: Vec4) {
    for f in &recipe.filters {
        // Take the output out, since the inputs are read at the same time; it is not among them.
        let mut texels = std::mem::take(&mut images[f.output].texels);
        filter(images, f, &images[f.output].desc, &mut texels, simd, shift);
        if shift != Vec4::ZERO {
            shift_channels(&mut texels, images[f.output].desc.format.channels(), shift);
        }
        images[f.output].texels = texels;
    }
}

fn shift_channels(texels: &mut [f32], channels: usize, shift: Vec4) {
    let factors = (Vec4::ONE + shift).to_array();
    for texel in texels.chunks_exact_mut(channels) {
        for (value, factor) in texel.iter_mut().zip(&factors) {
            *value *= factor;
        }
    }
}

/// Greatest number of rows that a thread computes together, for kernels whose rows share work.
const MOST_ROWS: usize = 256;
/// Least number of such rows: with fewer, most of the work would not be shared.
const LEAST_ROWS: usize = 8;

/// Runs one filter into `texels`. `shift` changes the values before storage by fractions, one per
/// channel.
pub(crate) fn filter(
    images: &[Image],
    filter: &Filter,
    output: &ImageDesc,
    texels: &mut [f32],
    simd: Simd,
    shift: Vec4,
) {
    let views = views(images, &filter.inputs);
    let inputs = Inputs {
        images: &views,
        simd,
    };
    let row_len = output.size.x as usize * output.format.channels();
    let height = output.size.y as usize;
    // Choose the number of rows that a thread computes together.
    let parts = 4 * rayon::current_num_threads();
    let rows_of_part = match filter.kernel.tile() {
        Some(_) => height.div_ceil(parts).clamp(LEAST_ROWS, MOST_ROWS),
        None => 1,
    };
    // Compute the parts of all layers.
    let layers = texels.par_chunks_mut(row_len * height).enumerate();
    let parts = layers.flat_map(|(layer, texels)| {
        let parts = texels.par_chunks_mut(row_len * rows_of_part).enumerate();
        parts.map(move |(part, out)| (layer, part, out))
    });
    parts.for_each(|(layer, part, out)| {
        let first = (part * rows_of_part) as u32;
        let kernel = &filter.kernel;
        kernel.filter_rows(&inputs, first, layer as u32, row_len, out);
        if shift != Vec4::ZERO {
            shift_channels(out, output.format.channels(), shift);
        }
        match output.format {
            Format::Rgba8 => out.iter_mut().for_each(|v| *v = stored8(*v)),
            Format::Rg16 | Format::Rgba16 => simd.run_task(Stored16(out)),
            _ => {}
        }
    });
}

/// Returns the value that shaders load from an 8-bit channel after `v` was stored, with the
/// conversion of Mesa's software rasterisers. NaN becomes 0.
fn stored8(v: f32) -> f32 {
    let v = if v > 0.0 { v.min(1.0) } else { 0.0 };
    (v * 255.0).round_ties_even() * (1.0 / 255.0)
}

/// Converts numbers to the values that shaders load from a 16-bit channel after storage.
struct Stored16<'a>(&'a mut [f32]);

impl SimdTask for Stored16<'_> {
    type Output = ();

    #[inline(always)]
    #[expect(
        clippy::manual_clamp,
        reason = "WGSL's min and max, in this order, also for NaN"
    )]
    fn run(self) {
        for v in self.0 {
            let step = (v.max(0.0).min(1.0) * 65_535.0 + 0.5).floor();
            *v = step * (1.0 / 65_535.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_channel_is_shifted_by_its_own_fraction() {
        let mut texels = [1.0, 2.0, -4.0, 0.0];
        shift_channels(&mut texels, 2, Vec4::new(0.5, -0.25, 9.0, 9.0));
        assert_eq!(texels, [1.5, 1.5, -6.0, 0.0]);
    }
}
