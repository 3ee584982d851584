//! Single stages, played from given images: what lockstep tests compare, so that a difference names its stage.

use crate::{Cpu, player::nothing_seen, receivers, stages};
use umbrage_core::{
    BackendError, Cast, Format, Geometry, Image, ImageDesc, Invalid, MAX_SIDE, Recipe, View, glam::UVec2,
};

impl Cpu {
    /// Draws the casters into a new depth image of one layer; the image and layer that the cast names play no part.
    ///
    /// # Errors
    /// When the size is zero or too large.
    pub fn cast(&mut self, geometry: &Geometry, cast: &Cast, size: UVec2) -> Result<Image, BackendError> {
        if size.min_element() == 0 || size.max_element() > MAX_SIDE {
            let why = format!("is {} x {} texels", size.x, size.y);
            let mend = format!("use 1 to {MAX_SIDE} on each side");
            return Err(Invalid::new("depth image", why, mend).into());
        }
        let mut image = Image::filled(ImageDesc { label: "depth", size, layers: 1, format: Format::Depth32 }, 1.0);
        self.cast_into(geometry, &Cast { layer: 0, ..*cast }, &mut image)?;
        Ok(image)
    }

    /// Clears a layer of a depth image and draws the casters into it; the image that the cast names plays no part.
    ///
    /// # Errors
    /// When the image holds no depth, or doesn't have the cast's layer.
    pub fn cast_into(&mut self, geometry: &Geometry, cast: &Cast, image: &mut Image) -> Result<(), BackendError> {
        let floats = image.texels.len() as u64;
        if image.desc.format != Format::Depth32 || cast.layer >= image.desc.layers || 4 * floats != image.desc.bytes() {
            let why = format!("has no layer {} of depth", cast.layer);
            return Err(Invalid::new(format!("image `{}`", image.desc.label), why, "use a `Depth32` image").into());
        }
        self.install(|cpu| stages::cast(&mut cpu.rasterizer, image, cast, geometry, true, cpu.simd));
        Ok(())
    }

    /// Plays a recipe's filter number `index` from the given images (all of the recipe's, in its order).
    ///
    /// # Errors
    /// When the recipe has no such filter, or the images are not the recipe's.
    pub fn replay_filter(&mut self, recipe: &Recipe, index: usize, images: &[Image]) -> Result<Image, BackendError> {
        check_images(recipe, images)?;
        let filter = recipe.filters.get(index).ok_or_else(|| {
            let why = format!("has {} filters, and number {index} was asked for", recipe.filters.len());
            Invalid::new("recipe", why, "count from 0")
        })?;
        let desc = images[filter.output].desc;
        let mut out = Image::filled(desc, 0.0);
        self.install(|cpu| stages::filter(images, filter, &desc, &mut out.texels, cpu.simd));
        Ok(out)
    }

    /// Plays a recipe's last stage from the given images (all of the recipe's, in its order): the mask. The view needs
    /// its receivers, or geometry.
    ///
    /// # Errors
    /// When the view has neither, or the images are not the recipe's.
    pub fn replay_receive(
        &mut self,
        view: &View<'_>,
        recipe: &Recipe,
        images: &[Image],
    ) -> Result<Vec<f32>, BackendError> {
        check_images(recipe, images)?;
        let made = match (view.receivers, view.geometry) {
            (None, Some(geometry)) => Some(self.receivers(view.camera, geometry)?),
            _ => None,
        };
        let receivers = view.receivers.or(made.as_ref()).ok_or_else(nothing_seen)?;
        receivers::check(receivers, view.camera.size)?;
        Ok(self.install(|cpu| stages::receive(images, recipe, receivers, cpu.simd)))
    }
}

fn check_images(recipe: &Recipe, images: &[Image]) -> Result<(), Invalid> {
    let fits = |(image, desc): (&Image, &ImageDesc)| {
        let same = (image.desc.size, image.desc.layers, image.desc.format) == (desc.size, desc.layers, desc.format);
        same && image.texels.len() as u64 * 4 == desc.bytes()
    };
    if images.len() == recipe.images.len() && images.iter().zip(&recipe.images).all(fits) {
        return Ok(());
    }
    Err(Invalid::new("images", "differ in number, size or format from the recipe's", "give what the recipe describes"))
}
