//! Some receivers alone: what samplers of an image need.

use crate::{Cpu, backend, images};
use rayon::prelude::*;
use umbrage_core::{BackendError, Inputs, Invalid, Receivers, Recipe, View};

/// Pixels that one thread asks before it looks for more.
const CHUNK: usize = 64;

impl Cpu {
    /// What the mask of [`Backend::render`](umbrage_core::Backend::render) would hold at some pixels: casts and filters
    /// are played as there, and only these pixels are asked. Bit by bit the same, in the order of `pixels`. The view needs
    /// its receivers.
    ///
    /// # Errors
    /// As [`Backend::render`](umbrage_core::Backend::render); when the view has no receivers, or not that many.
    pub fn ask(
        &mut self,
        view: &View<'_>,
        recipe: &Recipe,
        pixels: &[u32],
    ) -> Result<Vec<f32>, BackendError> {
        let Some(receivers) = view.receivers else {
            return Err(backend::nothing_seen().into());
        };
        if let Some(beyond) = pixels.iter().find(|&&i| i as usize >= receivers.len()) {
            let why = format!("is asked about, and there are {}", receivers.len());
            return Err(
                Invalid::new(format!("pixel {beyond}"), why, "count from 0, row by row").into(),
            );
        }
        self.install(|cpu| {
            cpu.draw(view, recipe)?;
            let inputs = images::views(&cpu.images, &recipe.receive.inputs);
            let inputs = Inputs {
                images: &inputs,
                simd: cpu.simd,
            };
            let mut out = vec![1.0; pixels.len()];
            out.par_chunks_mut(CHUNK)
                .zip(pixels.par_chunks(CHUNK))
                .for_each(|(out, pixels)| {
                    for (out, &pixel) in out.iter_mut().zip(pixels) {
                        ask_one(&inputs, recipe, receivers, pixel as usize, out);
                    }
                });
            Ok(out)
        })
    }
}

/// One receiver is a span of its own, at its own place in the image: kernels' patterns are those of the whole mask.
fn ask_one(
    inputs: &Inputs<'_>,
    recipe: &Recipe,
    receivers: &Receivers,
    pixel: usize,
    out: &mut f32,
) {
    if receivers.receives[pixel] {
        recipe
            .receive
            .kernel
            .receive(inputs, &receivers.span(pixel, 1), std::slice::from_mut(out));
    }
}
