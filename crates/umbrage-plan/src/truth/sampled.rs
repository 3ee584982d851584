//! Truth at a stratified sample of an image's pixels, with a preview at the others.
//!
//! The image is divided into square blocks, and one random pixel of each is drawn (stratified
//! sampling: Cochran 1977, "Sampling techniques", 5). All pixels have the same chance, except in
//! blocks cut by the right and lower edges of the image, where it is greater.

use super::{
    judged::{JudgedPoints, class, judge},
    options::{FindReceivers, Progress, TruthOptions},
    points::{PointTruth, TruthRequest},
    tracer::Tracer,
};
use crate::error::MeasureError;
use glam::UVec2;
use umbrage_core::{Camera, Geometry, Light, Receivers, light_sample, metrics::Pixel};

/// Rays a pixel of a preview, for lights with an extent. They resolve visibility in sixteenths,
/// enough to locate penumbrae (2 % to 98 %).
pub const PREVIEW_SAMPLES: u32 = 16;

/// Input for tracing truth.
#[derive(Clone, Copy)]
pub(super) struct Image<'a> {
    pub(super) camera: &'a Camera,
    pub(super) light: &'a Light,
    pub(super) geometry: &'a Geometry,
    pub(super) receivers: &'a Receivers,
}

/// Truth at all pixels of an image, or a preview of it.
pub(super) struct TracedImage {
    pub(super) seen: Vec<PointTruth>,
    /// False outside the sample.
    pub(super) ambiguous: Vec<bool>,
    pub(super) pixels: Vec<Pixel>,
}

/// Traces truth at the drawn pixels, and a preview at the others.
pub(super) fn trace(
    image: &Image<'_>,
    options: &TruthOptions,
    find: &mut FindReceivers<'_>,
    progress: &Progress<'_>,
) -> Result<TracedImage, MeasureError> {
    let receivers = image.receivers;
    let drawn = stratified_pixels(receivers.size, options.block_side);
    let request = TruthRequest {
        camera: image.camera,
        geometry: image.geometry,
        receivers,
        pixels: &drawn,
    };
    let JudgedPoints { seen, ambiguous } = judge(&request, image.light, options, find, progress)?;
    let mut out = if drawn.len() == receivers.len() {
        TracedImage::nothing(receivers.len())
    } else {
        preview(image, options)?
    };
    for (k, &i) in drawn.iter().enumerate() {
        let i = i as usize;
        out.seen[i] = seen[k];
        out.ambiguous[i] = ambiguous[k];
        out.pixels[i] = class(receivers.receives[i], seen[k], ambiguous[k]);
    }
    Ok(out)
}

/// Traces a few rays at every pixel. Pixels that would count are marked unsampled.
fn preview(image: &Image<'_>, options: &TruthOptions) -> Result<TracedImage, MeasureError> {
    let receivers = image.receivers;
    let all: Vec<u32> = (0..receivers.len() as u32).collect();
    let request = TruthRequest {
        camera: image.camera,
        geometry: image.geometry,
        receivers,
        pixels: &all,
    };
    let few_rays = TruthOptions {
        samples: PREVIEW_SAMPLES.min(options.samples),
        penumbra_factor: 1,
        ..*options
    };
    let tracer = Tracer::new(image.geometry, image.light, &few_rays)?;
    let seen = request.trace(&tracer, 1.0, &|_| {});
    let mut out = TracedImage::nothing(all.len());
    for (i, pixel) in out.pixels.iter_mut().enumerate() {
        *pixel = match class(receivers.receives[i], seen[i], false) {
            Pixel::Counted => Pixel::Unsampled,
            class => class,
        };
    }
    out.seen = seen;
    Ok(out)
}

impl TracedImage {
    /// Returns an image without receivers.
    fn nothing(pixels: usize) -> Self {
        Self {
            seen: vec![PointTruth::NOTHING; pixels],
            ambiguous: vec![false; pixels],
            pixels: vec![Pixel::Empty; pixels],
        }
    }
}

/// Returns the rising indices of one pixel of each block of `side` by `side` pixels.
pub(crate) fn stratified_pixels(size: UVec2, side: u32) -> Vec<u32> {
    let side = side.max(1);
    let mut out = Vec::new();
    for top in (0..size.y).step_by(side as usize) {
        for left in (0..size.x).step_by(side as usize) {
            let width = side.min(size.x - left);
            let height = side.min(size.y - top);
            let random = light_sample::seed(left, top) % (width * height);
            let x = left + random % width;
            let y = top + random / width;
            out.push(y * size.x + x);
        }
    }
    out.sort_unstable();
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_pixel_of_each_block_is_drawn() {
        let size = UVec2::new(30, 18);
        for side in [1, 4, 7, 64] {
            let drawn = stratified_pixels(size, side);
            let blocks = size.x.div_ceil(side) * size.y.div_ceil(side);
            assert_eq!(drawn.len() as u32, blocks);
            let mut of_blocks: Vec<[u32; 2]> = drawn
                .iter()
                .map(|i| [i % size.x / side, i / size.x / side])
                .collect();
            of_blocks.sort_unstable();
            of_blocks.dedup();
            assert_eq!(of_blocks.len() as u32, blocks, "side {side}");
            assert!(drawn.is_sorted() && *drawn.last().expect("some") < size.x * size.y);
        }
    }

    /// All positions within a block are drawn about equally often.
    #[test]
    fn the_draw_prefers_no_place() {
        let size = UVec2::splat(1024);
        let mut count = [0_u32; 16];
        for i in stratified_pixels(size, 4) {
            let x = i % size.x % 4;
            let y = i / size.x % 4;
            count[(4 * y + x) as usize] += 1;
        }
        // 4096 are expected of each; a standard deviation is 62.
        assert!(count.iter().all(|n| n.abs_diff(4096) < 310), "{count:?}");
    }
}
