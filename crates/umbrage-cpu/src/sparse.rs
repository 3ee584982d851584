//! Masks of selected pixels, for sampling an image.

use crate::{Cpu, backend};
use rayon::prelude::*;
use umbrage_core::{BackendError, Inputs, Invalid, Receivers, Recipe, View};

/// Number of pixels that a thread processes at once.
const CHUNK: usize = 64;

impl Cpu {
    /// Returns the mask of [`Backend::render`](umbrage_core::Backend::render) at some pixels, bit
    /// by bit, in the order of `pixels`. Casts and filters run in full; the receive kernel runs for
    /// these pixels only. The view must have receivers.
    ///
    /// # Errors
    /// Errors in the same cases as [`Backend::render`](umbrage_core::Backend::render), or if the
    /// view has no receivers, or too few for a pixel.
    pub fn render_pixels(
        &mut self,
        view: &View<'_>,
        recipe: &Recipe,
        pixels: &[u32],
    ) -> Result<Vec<f32>, BackendError> {
        let Some(receivers) = view.receivers else {
            return Err(backend::nothing_seen().into());
        };
        if let Some(beyond) = pixels.iter().find(|&&i| i as usize >= receivers.len()) {
            let why = format!("is out of range of {} pixels", receivers.len());
            return Err(
                Invalid::new(format!("pixel {beyond}"), why, "count from 0, row by row").into(),
            );
        }
        let execute = |inputs: &Inputs<'_>| {
            let mut out = vec![1.0; pixels.len()];
            let chunks = out.par_chunks_mut(CHUNK).zip(pixels.par_chunks(CHUNK));
            chunks.for_each(|(out, pixels)| {
                for (out, &pixel) in out.iter_mut().zip(pixels) {
                    receive_one(inputs, recipe, receivers, pixel as usize, out);
                }
            });
            out
        };
        self.install(|cpu| cpu.with_inputs(view, recipe, execute))
    }
}

/// Runs the receive kernel for one pixel, as a separate span at its position in the image, so that
/// kernels' patterns are those of the whole mask.
fn receive_one(
    inputs: &Inputs<'_>,
    recipe: &Recipe,
    receivers: &Receivers,
    pixel: usize,
    out: &mut f32,
) {
    if receivers.receives[pixel] {
        let span = receivers.span(pixel, 1);
        let out = std::slice::from_mut(out);
        recipe.receive.kernel.receive(inputs, &span, out);
    }
}
