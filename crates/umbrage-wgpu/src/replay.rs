//! Execution of single stages from given images, so that tests can compare stages separately.

use crate::{
    backend::{Gpu, check, factory},
    device::{readback::ReadBack, results::Tickets},
    frame::FrameInputs,
    gbuffer::ReceiverTextures,
};
use glam::UVec2;
use umbrage_core::{BackendError, Image, Invalid, Recipe, View};
use wgpu::CommandEncoder;

impl Gpu {
    /// Executes only the receive stage, using these images instead of the results of the recipe's
    /// casts and filters. The view needs receivers or geometry. Returns the mask.
    ///
    /// # Errors
    /// Errors if [`Backend::render`](umbrage_core::Backend::render) does, or if the images don't
    /// match the recipe.
    pub fn replay_receive(
        &mut self,
        view: &View<'_>,
        recipe: &Recipe,
        images: &[Image],
    ) -> Result<Vec<f32>, BackendError> {
        check(view, recipe)?;
        let recipe = Recipe {
            filters: Vec::new(),
            ..still(recipe, images)?
        };
        self.catch_errors(|gpu| {
            let found = gpu.prepare(view, &recipe)?;
            let mut encoder = gpu.begin(found);
            gpu.write_images(&mut encoder, images);
            gpu.renderer.encode_receive(&mut encoder)?;
            let mut back = ReadBack::new(&gpu.device, &mut gpu.counters, &mut gpu.spare);
            let tickets = Tickets::record(&mut encoder, &mut back, &gpu.renderer, &[]);
            gpu.queue.submit([encoder.finish()]);
            back.wait()?;
            tickets.mask(&back)
        })
    }

    /// Executes only the filter with this index, from these images. Returns its output.
    ///
    /// # Errors
    /// Errors if [`replay_receive`](Self::replay_receive) does, or if there is no such filter.
    pub fn replay_filter(
        &mut self,
        recipe: &Recipe,
        filter: usize,
        images: &[Image],
    ) -> Result<Image, BackendError> {
        let recipe = still(recipe, images)?;
        let Some(filter) = recipe.filters.get(filter).cloned() else {
            let why = format!("has {} filters", recipe.filters.len());
            return Err(Invalid::new("recipe", why, "use the index of one of them").into());
        };
        let output = filter.output;
        let recipe = Recipe {
            filters: vec![filter],
            ..recipe
        };
        self.catch_errors(|gpu| {
            gpu.prepare_blind(&recipe)?;
            let mut encoder = gpu.begin(None);
            gpu.write_images(&mut encoder, images);
            gpu.renderer.encode_filters_only(&mut encoder)?;
            let kept = gpu.readable_images(&mut encoder);
            let mut back = ReadBack::new(&gpu.device, &mut gpu.counters, &mut gpu.spare);
            let tickets = Tickets::record(&mut encoder, &mut back, &gpu.renderer, &kept);
            gpu.queue.submit([encoder.finish()]);
            back.wait()?;
            Ok(tickets.images(&back, &recipe)?.swap_remove(output))
        })
    }

    /// Prepares with a receiver texture of one pixel, which is not read.
    fn prepare_blind(&mut self, recipe: &Recipe) -> Result<(), BackendError> {
        let mut factory = factory!(self);
        let textures = ReceiverTextures::fit(&mut self.receivers, &mut factory, UVec2::ONE);
        let frame = FrameInputs {
            size: UVec2::ONE,
            casters: &[],
            everything: &[],
            receivers: textures.gbuffer(),
        };
        self.renderer.prepare(recipe, &frame)
    }

    fn write_images(&mut self, encoder: &mut CommandEncoder, images: &[Image]) {
        self.converter.write(
            &mut factory!(self),
            encoder,
            self.renderer.gpu_images(),
            images,
        );
    }
}

/// Returns the recipe without casts and shading. Errors if the images don't match it.
fn still(recipe: &Recipe, images: &[Image]) -> Result<Recipe, BackendError> {
    let mut fits = recipe.images.len() == images.len();
    for (desc, image) in recipe.images.iter().zip(images) {
        fits &= *desc == image.desc && image.texels.len() as u64 == desc.floats();
    }
    if !fits {
        let help = "use those of `Shadows::images`, rendered with `keep_images`";
        return Err(Invalid::new("images to replay", "differ from the recipe's", help).into());
    }
    Ok(Recipe {
        casts: Vec::new(),
        shade: None,
        ..recipe.clone()
    })
}
