//! The stages of a recipe after its casts.

use crate::casts;
use rayon::prelude::*;
use umbrage_core::{
    Filter, Format, Image, ImageDesc, ImageId, ImageView, Inputs, NO_TRIANGLE, Receivers, Recipe,
    Shade, Simd, Span, glam::UVec2,
};

/// Makes `images` fit a recipe, keeping what has the right size, and clears what isn't written before it is read.
pub(crate) fn prepare_images(images: &mut Vec<Image>, recipe: &Recipe) {
    images.truncate(recipe.images.len());
    for (i, desc) in recipe.images.iter().enumerate() {
        let start = desc.format.start();
        match images.get_mut(i) {
            Some(image) if image.desc.floats() == desc.floats() => {
                image.desc = *desc;
                clear_unwritten(image, i, recipe, start);
            }
            Some(image) => *image = Image::filled(*desc, start),
            None => images.push(Image::filled(*desc, start)),
        }
    }
}

fn clear_unwritten(image: &mut Image, id: ImageId, recipe: &Recipe, start: f32) {
    for layer in 0..image.desc.layers {
        // A cast that uses a layer first clears it on its way; a filter writes every texel.
        let first_use = recipe
            .filters
            .iter()
            .find(|f| f.output == id || f.inputs.contains(&id));
        if !casts::clears(recipe, id, layer) && first_use.is_none_or(|f| f.output != id) {
            image
                .layer_mut(layer)
                .par_chunks_mut(1 << 14)
                .for_each(|part| part.fill(start));
        }
    }
}

/// Runs all filters.
pub(crate) fn filter_all(images: &mut [Image], recipe: &Recipe, simd: Simd) {
    for f in &recipe.filters {
        // The output is taken out, since the others are read meanwhile; it isn't among them.
        let mut texels = std::mem::take(&mut images[f.output].texels);
        filter(images, f, &images[f.output].desc, &mut texels, simd);
        images[f.output].texels = texels;
    }
}

/// Runs one filter into `texels`, row by row.
pub(crate) fn filter(
    images: &[Image],
    filter: &Filter,
    output: &ImageDesc,
    texels: &mut [f32],
    simd: Simd,
) {
    let views = views(images, &filter.inputs);
    let inputs = Inputs {
        images: &views,
        simd,
    };
    let (row_len, height) = (
        output.size.x as usize * output.format.channels(),
        output.size.y as usize,
    );
    texels
        .par_chunks_mut(row_len)
        .enumerate()
        .for_each(|(row, out)| {
            let start = UVec2::new(0, (row % height) as u32);
            filter
                .kernel
                .filter(&inputs, start, (row / height) as u32, out);
            if output.format == Format::Rgba8 {
                out.iter_mut().for_each(|v| *v = stored8(*v));
            }
        });
}

/// What shaders load from an 8-bit channel into which `v` was written, as Mesa's software rasterisers convert it; what
/// is not a number becomes 0.
fn stored8(v: f32) -> f32 {
    let v = if v > 0.0 { v.min(1.0) } else { 0.0 };
    (v * 255.0).round_ties_even() * (1.0 / 255.0)
}

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

pub(crate) fn views<'a>(images: &'a [Image], ids: &[ImageId]) -> Vec<ImageView<'a>> {
    ids.iter().map(|&i| images[i].view()).collect()
}
