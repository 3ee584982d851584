//! The three stages of a recipe.

use crate::raster::{Draw, Rasterizer, Target};
use rayon::prelude::*;
use umbrage_core::{
    Cast, Filter, Format, Geometry, Image, ImageDesc, ImageId, ImageView, Inputs, Receivers, Recipe, Simd, Span,
    glam::UVec2,
};

/// Makes `images` fit a recipe, keeping what has the right size, and clears what isn't written before it is read.
pub(crate) fn prepare_images(images: &mut Vec<Image>, recipe: &Recipe) {
    images.truncate(recipe.images.len());
    for (i, desc) in recipe.images.iter().enumerate() {
        let start = start_value(desc);
        match images.get_mut(i) {
            Some(image) if image.desc.bytes() == desc.bytes() => {
                image.desc = *desc;
                clear_unwritten(image, i, recipe, start);
            }
            Some(image) => *image = Image::filled(*desc, start),
            None => images.push(Image::filled(*desc, start)),
        }
    }
}

/// Depth starts at the far plane, all else at nothing.
fn start_value(desc: &ImageDesc) -> f32 {
    if desc.format == Format::Depth32 { 1.0 } else { 0.0 }
}

fn clear_unwritten(image: &mut Image, id: ImageId, recipe: &Recipe, start: f32) {
    for layer in 0..image.desc.layers {
        // The first cast into a layer clears it on its way; a filter writes every texel.
        let cast = recipe.casts.iter().any(|c| (c.image, c.layer) == (id, layer));
        let first_use = recipe.filters.iter().find(|f| f.output == id || f.inputs.contains(&id));
        if !cast && first_use.is_none_or(|f| f.output != id) {
            image.layer_mut(layer).par_chunks_mut(1 << 14).for_each(|part| part.fill(start));
        }
    }
}

/// Draws the casters into a layer, which is cleared before if `clear` says so.
pub(crate) fn cast(
    rasterizer: &mut Rasterizer,
    image: &mut Image,
    cast: &Cast,
    geometry: &Geometry,
    clear: bool,
    simd: Simd,
) {
    let casters = geometry.casters();
    let draw = Draw {
        positions: geometry.positions(),
        triangles: &geometry.triangles()[casters.start as usize..casters.end as usize],
        first_id: casters.start,
        clip_from_world: cast.space.clip_from_world(),
        size: image.desc.size,
        cull: cast.cull,
        bias: cast.bias,
        simd,
    };
    let width = image.desc.size.x as usize;
    rasterizer.draw(&draw, Target { width, depth: image.layer_mut(cast.layer), ids: &mut [], clear });
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
pub(crate) fn filter(images: &[Image], filter: &Filter, output: &ImageDesc, texels: &mut [f32], simd: Simd) {
    let views = views(images, &filter.inputs);
    let inputs = Inputs { images: &views, simd };
    let (row_len, height) = (output.size.x as usize * output.format.channels(), output.size.y as usize);
    texels.par_chunks_mut(row_len).enumerate().for_each(|(row, out)| {
        let start = UVec2::new(0, (row % height) as u32);
        filter.kernel.filter(&inputs, start, (row / height) as u32, out);
    });
}

/// A block of receivers that is asked before the next one begins, pixels. Neighbours in both directions look up the same
/// part of a map, and a block's part stays in the nearest cache.
const BLOCK: [usize; 2] = [128, 16];

/// Asks every receiver: the mask.
pub(crate) fn receive(images: &[Image], recipe: &Recipe, receivers: &Receivers, simd: Simd) -> Vec<f32> {
    let views = views(images, &recipe.receive.inputs);
    let inputs = Inputs { images: &views, simd };
    let width = receivers.size.x as usize;
    let mut mask = vec![1.0; receivers.len()];
    mask.par_chunks_mut(width * BLOCK[1]).enumerate().for_each(|(band, out)| {
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
fn receive_span(inputs: &Inputs<'_>, recipe: &Recipe, receivers: &Receivers, first: usize, out: &mut [f32]) {
    let receives = &receivers.receives[first..first + out.len()];
    let Some(start) = receives.iter().position(|&r| r) else { return };
    let end = receives.iter().rposition(|&r| r).map_or(start, |last| last + 1);
    let span: Span<'_> = receivers.span(first + start, end - start);
    recipe.receive.kernel.receive(inputs, &span, &mut out[start..end]);
    for (out, &receives) in out[start..end].iter_mut().zip(&receives[start..end]) {
        *out = if receives { *out } else { 1.0 };
    }
}

fn views<'a>(images: &'a [Image], ids: &[ImageId]) -> Vec<ImageView<'a>> {
    ids.iter().map(|&i| images[i].view()).collect()
}
