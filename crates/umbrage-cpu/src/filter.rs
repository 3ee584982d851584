//! The filter stage: images made from images.

use crate::images::views;
use rayon::prelude::*;
use umbrage_core::{
    Filter, Format, Image, ImageDesc, Inputs, Recipe, Simd, SimdTask,
    glam::{UVec2, Vec4},
};

/// Runs all filters, and changes what they make by the fractions `shift`, a channel each: before it
/// is stored, as sums round, and after that, as what reads it rounds.
pub(crate) fn filter_all(images: &mut [Image], recipe: &Recipe, simd: Simd, shift: Vec4) {
    for f in &recipe.filters {
        // The output is taken out, since the others are read meanwhile; it isn't among them.
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

/// Runs one filter into `texels`, row by row. `shift` changes what is stored by fractions, a
/// channel each.
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
    // Rows of all layers, one layer after the other.
    let rows = texels.par_chunks_mut(row_len).enumerate();
    rows.for_each(|(row, out)| {
        let start = UVec2::new(0, (row % height) as u32);
        let layer = (row / height) as u32;
        filter.kernel.filter(&inputs, start, layer, out);
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

/// Returns what shaders load from an 8-bit channel into which `v` was written, as Mesa's software
/// rasterisers convert it; NaN becomes 0.
fn stored8(v: f32) -> f32 {
    let v = if v > 0.0 { v.min(1.0) } else { 0.0 };
    (v * 255.0).round_ties_even() * (1.0 / 255.0)
}

/// Turns numbers into what shaders load from a 16-bit channel into which they were written.
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
