//! The cast stage: geometry drawn into images.

use crate::raster::{Draw, Mode, Position, Rasterizer, Target};
use std::borrow::Cow;
use umbrage_core::{Cast, CastMode, Format, Geometry, Image, ImageId, Recipe, Simd, Source};

/// What a cast reads and where it draws.
pub(crate) struct CastAttachments<'a> {
    /// The image.
    pub(crate) image: &'a mut Image,
    /// The texels of the image and layer that the mode names; else empty.
    pub(crate) other: &'a [f32],
    /// Whether to clear the layer before.
    pub(crate) clear: bool,
}

/// Returns the image whose depths a mode compares with.
pub(crate) fn other(mode: CastMode) -> Option<ImageId> {
    match mode {
        CastMode::Depth => None,
        CastMode::DepthPeel(id) | CastMode::StencilDepthFail { depth: id } => Some(id),
    }
}

/// Returns whether no earlier cast of the recipe draws into the layer: then the cast clears it.
pub(crate) fn is_first(recipe: &Recipe, index: usize) -> bool {
    let cast = &recipe.casts[index];
    !recipe.casts[..index]
        .iter()
        .any(|earlier| earlier.image == cast.image && earlier.layer == cast.layer)
}

/// Returns whether casts use a layer, and the first that does draws there (and so clears it), rather than only reads it.
pub(crate) fn clears(recipe: &Recipe, image: ImageId, layer: u32) -> bool {
    for cast in &recipe.casts {
        if cast.layer != layer {
            continue;
        }
        if cast.image == image {
            return true;
        }
        if other(cast.mode) == Some(image) {
            return false;
        }
    }
    false
}

/// Plays a recipe's cast number `index`.
pub(crate) fn play(
    rasterizer: &mut Rasterizer,
    images: &mut [Image],
    recipe: &Recipe,
    index: usize,
    geometry: &Geometry,
    simd: Simd,
) {
    let cast = &recipe.casts[index];
    // The image is taken out, since the other one is read meanwhile; they differ.
    let desc = images[cast.image].desc;
    let mut image = Image {
        desc,
        texels: std::mem::take(&mut images[cast.image].texels),
    };
    let other = match other(cast.mode) {
        Some(id) => layer(&images[id], cast.layer),
        None => &[],
    };
    let target = CastAttachments {
        image: &mut image,
        other,
        clear: is_first(recipe, index),
    };
    draw(rasterizer, target, cast, geometry, simd);
    images[cast.image] = image;
}

fn layer(image: &Image, layer: u32) -> &[f32] {
    let n = image.texels.len() / image.desc.layers as usize;
    &image.texels[layer as usize * n..][..n]
}

/// Draws a cast's triangles into a target.
pub(crate) fn draw(
    rasterizer: &mut Rasterizer,
    target: CastAttachments<'_>,
    cast: &Cast,
    geometry: &Geometry,
    simd: Simd,
) {
    let positions = geometry.positions();
    match &cast.source {
        Source::Casters | Source::Everything | Source::SomeCasters(_) => {
            let triangles = drawn_triangles(&cast.source, geometry);
            draw_triangles(rasterizer, target, cast, positions, &triangles, simd);
        }
        Source::Faces(faces) => {
            draw_triangles(
                rasterizer,
                target,
                cast,
                &faces.vertices,
                &faces.triangles,
                simd,
            );
        }
    }
}

/// Returns the triangles of a geometry that a cast draws. Several runs are copied one after the other, since the rasteriser
/// shares out one list among threads.
fn drawn_triangles<'a>(source: &Source, geometry: &'a Geometry) -> Cow<'a, [[u32; 3]]> {
    let runs = source.runs(geometry);
    if let [run] = &runs[..] {
        return Cow::Borrowed(geometry.run(run));
    }
    let mut triangles = Vec::with_capacity(runs.iter().map(ExactSizeIterator::len).sum());
    for run in &runs {
        triangles.extend_from_slice(geometry.run(run));
    }
    Cow::Owned(triangles)
}

fn draw_triangles<P: Position>(
    rasterizer: &mut Rasterizer,
    target: CastAttachments<'_>,
    cast: &Cast,
    positions: &[P],
    triangles: &[[u32; 3]],
    simd: Simd,
) {
    let CastAttachments {
        image,
        other,
        clear,
    } = target;
    let draw = Draw {
        positions,
        triangles,
        first_id: 0,
        clip_from_world: cast.space.clip_from_world(),
        size: image.desc.size,
        cull: cast.cull,
        bias: cast.bias,
        mode: mode(cast.mode, image.desc.format),
        simd,
    };
    let target = Target {
        width: image.desc.size.x as usize,
        texels: image.layer_mut(cast.layer),
        ids: &mut [],
        other,
        clear,
    };
    rasterizer.draw(&draw, target);
}

fn mode(mode: CastMode, format: Format) -> Mode {
    let in_steps = format == Format::Depth16;
    match mode {
        CastMode::Depth if in_steps => Mode::Depth16,
        CastMode::Depth => Mode::Depth,
        CastMode::DepthPeel(_) if in_steps => Mode::DepthPeel16,
        CastMode::DepthPeel(_) => Mode::DepthPeel,
        CastMode::StencilDepthFail { .. } => Mode::StencilDepthFail,
    }
}
