//! Cast stage: draws geometry into images.

use crate::raster::{Draw, Holes, Mode, Position, Rasterizer, Target};
use std::{borrow::Cow, ops::Range};
use umbrage_core::{Cast, CastMode, Format, Geometry, Image, ImageId, Recipe, Simd, Source};

/// Images that a cast reads and draws into.
pub(crate) struct CastAttachments<'a> {
    /// Target image.
    pub(crate) image: &'a mut Image,
    /// Texels of the image and layer that the mode reads; empty for other modes.
    pub(crate) other: &'a [f32],
    /// True if the layer is cleared first.
    pub(crate) clear: bool,
}

/// Returns the image whose depths a mode compares with.
pub(crate) fn other(mode: CastMode) -> Option<ImageId> {
    match mode {
        CastMode::Depth => None,
        CastMode::DepthPeel(id) | CastMode::StencilDepthFail { depth: id } => Some(id),
    }
}

/// Returns whether no earlier cast of the recipe draws into the layer, so that this cast clears it.
pub(crate) fn is_first(recipe: &Recipe, index: usize) -> bool {
    let cast = &recipe.casts[index];
    !recipe.casts[..index]
        .iter()
        .any(|earlier| earlier.image == cast.image && earlier.layer == cast.layer)
}

/// Returns whether the first cast that uses a layer draws into it, and so clears it, instead of
/// only reading it.
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

/// Executes the cast of a recipe with this index.
pub(crate) fn execute_cast(
    rasterizer: &mut Rasterizer,
    images: &mut [Image],
    recipe: &Recipe,
    index: usize,
    geometry: &Geometry,
    simd: Simd,
) {
    let cast = &recipe.casts[index];
    // Take the target image out, since the other image is read at the same time; they differ.
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
    if let Source::Faces(faces) = &cast.source {
        let list = CastTriangles::opaque(&faces.vertices, &faces.triangles);
        return draw_triangles(rasterizer, target, cast, &list, simd);
    }
    let runs = cast.source.runs(geometry);
    // Draw triangles without an alpha test in a single list.
    let Some(cut_outs) = geometry.cut_outs() else {
        let triangles = join_runs(&runs, geometry);
        let list = CastTriangles::opaque(positions, &triangles);
        return draw_triangles(rasterizer, target, cast, &list, simd);
    };
    let CastAttachments {
        image,
        other,
        clear,
    } = target;
    let rays = cast.space.rays(image.desc.size);
    // Draw opaque triangles first, then each run of alpha-tested ones.
    let [whole, cut_out] = cut_outs.split(&runs);
    let triangles = join_runs(&whole, geometry);
    let list = CastTriangles::opaque(positions, &triangles);
    let first = CastAttachments {
        image: &mut *image,
        other,
        clear,
    };
    draw_triangles(rasterizer, first, cast, &list, simd);
    for run in cut_out {
        let list = CastTriangles {
            positions,
            triangles: geometry.run(&run),
            first_id: run.start,
            holes: Some(Holes {
                cut_outs,
                geometry,
                rays: &rays,
            }),
        };
        let next = CastAttachments {
            image: &mut *image,
            other,
            clear: false,
        };
        draw_triangles(rasterizer, next, cast, &list, simd);
    }
}

/// Triangles that a cast draws.
struct CastTriangles<'a, P> {
    positions: &'a [P],
    triangles: &'a [[u32; 3]],
    /// Id of the first triangle, used by the alpha test.
    first_id: u32,
    holes: Option<Holes<'a>>,
}

impl<'a, P> CastTriangles<'a, P> {
    /// Returns a list of triangles without an alpha test.
    fn opaque(positions: &'a [P], triangles: &'a [[u32; 3]]) -> Self {
        Self {
            positions,
            triangles,
            first_id: 0,
            holes: None,
        }
    }
}

/// Returns the triangles of some runs of a geometry. Several runs are copied into one list, since
/// the rasteriser distributes a single list to threads.
fn join_runs<'a>(runs: &[Range<u32>], geometry: &'a Geometry) -> Cow<'a, [[u32; 3]]> {
    if let [run] = runs {
        return Cow::Borrowed(geometry.run(run));
    }
    let mut triangles = Vec::with_capacity(runs.iter().map(ExactSizeIterator::len).sum());
    for run in runs {
        triangles.extend_from_slice(geometry.run(run));
    }
    Cow::Owned(triangles)
}

fn draw_triangles<P: Position>(
    rasterizer: &mut Rasterizer,
    target: CastAttachments<'_>,
    cast: &Cast,
    list: &CastTriangles<'_, P>,
    simd: Simd,
) {
    let CastAttachments {
        image,
        other,
        clear,
    } = target;
    let draw = Draw {
        positions: list.positions,
        triangles: list.triangles,
        first_id: list.first_id,
        clip_from_world: cast.space.clip_from_world(),
        size: image.desc.size,
        cull: cast.cull,
        bias: cast.bias,
        mode: mode(cast.mode, image.desc.format),
        simd,
        holes: list.holes,
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
