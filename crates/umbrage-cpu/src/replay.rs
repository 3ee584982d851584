//! Execution of single stages from given images, so that tests of both backends can find the stage
//! at which they differ.

use crate::{
    Cpu,
    backend::{check_recipe, nothing_seen},
    cast::{self, CastAttachments},
    filter, gbuffer, receive, shade,
};
use umbrage_core::glam::Vec4;
use umbrage_core::{
    BackendError, Cast, CastMode, Format, Geometry, Image, ImageDesc, Invalid, MAX_SIDE, Receivers,
    Recipe, Source, View, glam::UVec2,
};

impl Cpu {
    /// Draws a cast of the nearest depth into a new depth image of one layer. The image and layer
    /// of the cast are ignored.
    ///
    /// # Errors
    /// Errors if the size is zero or too large, or the cast has another mode.
    pub fn cast(
        &mut self,
        geometry: &Geometry,
        cast: &Cast,
        size: UVec2,
    ) -> Result<Image, BackendError> {
        if size.min_element() == 0 || size.max_element() > MAX_SIDE {
            let why = format!("is {} x {} texels", size.x, size.y);
            let help = format!("use 1 to {MAX_SIDE} on each side");
            return Err(Invalid::new("depth image", why, help).into());
        }
        let desc = ImageDesc {
            label: "depth",
            size,
            layers: 1,
            format: Format::Depth32,
        };
        let mut image = Image::filled_with(desc, 1.0);
        let mut cast = cast.clone();
        cast.layer = 0;
        self.cast_into(geometry, &cast, &mut image)?;
        Ok(image)
    }

    /// Clears a layer of a depth image and draws a cast of the nearest depth into it. The image of
    /// the cast is ignored.
    ///
    /// # Errors
    /// Errors if the image has no depth, or doesn't have the cast's layer, or the cast has another
    /// mode.
    pub fn cast_into(
        &mut self,
        geometry: &Geometry,
        cast: &Cast,
        image: &mut Image,
    ) -> Result<(), BackendError> {
        let fits = image.desc.format.is_depth() && image.texels.len() as u64 == image.desc.floats();
        if !fits || cast.layer >= image.desc.layers {
            let what = format!("image `{}`", image.desc.label);
            let why = format!("has no layer {} of depth", cast.layer);
            return Err(Invalid::new(what, why, "use a depth image").into());
        }
        if cast.mode != CastMode::Depth {
            let why = format!("is {:?}, which reads another image", cast.mode);
            return Err(Invalid::new("cast", why, "use `Cpu::replay_cast`").into());
        }
        if let Source::Faces(faces) = &cast.source {
            faces.validate()?;
        }
        let target = CastAttachments {
            image,
            other: &[],
            clear: true,
        };
        self.install(|cpu| cast::draw(&mut cpu.rasterizer, target, cast, geometry, cpu.simd));
        Ok(())
    }

    /// Executes the cast of a recipe with this index on the given images (all of the recipe's, in
    /// order), and returns its target image. The layer is cleared first if no earlier cast of the
    /// recipe draws into it.
    ///
    /// # Errors
    /// Errors if the recipe is not valid or has no such cast, or the images are not the recipe's.
    pub fn replay_cast(
        &mut self,
        geometry: &Geometry,
        recipe: &Recipe,
        index: usize,
        images: &[Image],
    ) -> Result<Image, BackendError> {
        check_recipe(recipe)?;
        check_images(recipe, images)?;
        let cast = recipe
            .casts
            .get(index)
            .ok_or_else(|| no_such("casts", recipe.casts.len(), index))?;
        let mut images = images.to_vec();
        self.install(|cpu| {
            cast::execute_cast(
                &mut cpu.rasterizer,
                &mut images,
                recipe,
                index,
                geometry,
                cpu.simd,
            )
        });
        Ok(images.swap_remove(cast.image))
    }

    /// Executes the filter of a recipe with this index on the given images (all of the recipe's, in
    /// order).
    ///
    /// # Errors
    /// Errors if the recipe has no such filter, or the images are not the recipe's.
    pub fn replay_filter(
        &mut self,
        recipe: &Recipe,
        index: usize,
        images: &[Image],
    ) -> Result<Image, BackendError> {
        check_images(recipe, images)?;
        let filter = recipe
            .filters
            .get(index)
            .ok_or_else(|| no_such("filters", recipe.filters.len(), index))?;
        let desc = images[filter.output].desc;
        let mut out = Image::filled_with(desc, 0.0);
        self.install(|cpu| {
            filter::filter(images, filter, &desc, &mut out.texels, cpu.simd, Vec4::ZERO)
        });
        Ok(out)
    }

    /// Executes a recipe's receive stage on the given images (all of the recipe's, in order), and
    /// returns the mask. The view must have receivers or geometry.
    ///
    /// # Errors
    /// Errors if the view has neither, or the images are not the recipe's.
    pub fn replay_receive(
        &mut self,
        view: &View<'_>,
        recipe: &Recipe,
        images: &[Image],
    ) -> Result<Vec<f32>, BackendError> {
        check_images(recipe, images)?;
        self.with_receivers(view, |cpu, receivers| {
            receive::receive(images, recipe, receivers, cpu.simd)
        })
    }

    /// Executes a recipe's shading with a mask, and returns the image. The view must have receivers
    /// or geometry.
    ///
    /// # Errors
    /// Errors if the view has neither, the recipe does not shade, or the mask does not have one
    /// entry per pixel.
    pub fn replay_shade(
        &mut self,
        view: &View<'_>,
        recipe: &Recipe,
        mask: &[f32],
    ) -> Result<Vec<[f32; 4]>, BackendError> {
        let Some(shade) = &recipe.shade else {
            return Err(Invalid::new("recipe", "does not shade", "set its `shade`").into());
        };
        let pixels = view.camera.size.x as usize * view.camera.size.y as usize;
        if mask.len() != pixels {
            let why = format!("has {} entries for {pixels} pixels", mask.len());
            return Err(Invalid::new("mask", why, "pass one entry per pixel").into());
        }
        self.with_receivers(view, |_, receivers| shade::shade(shade, receivers, mask))
    }

    /// Runs `f` on this backend's threads, with the view's receivers or new ones.
    fn with_receivers<R: Send>(
        &mut self,
        view: &View<'_>,
        f: impl FnOnce(&Self, &Receivers) -> R + Send,
    ) -> Result<R, BackendError> {
        let made = match (view.receivers, view.geometry) {
            (None, Some(geometry)) => Some(self.receivers(view.camera, geometry)?),
            _ => None,
        };
        let receivers = view.receivers.or(made.as_ref()).ok_or_else(nothing_seen)?;
        gbuffer::check(receivers, view.camera.size)?;
        Ok(self.install(|cpu| f(cpu, receivers)))
    }
}

fn no_such(what: &str, count: usize, index: usize) -> Invalid {
    Invalid::new(
        "recipe",
        format!("has {count} {what}, but number {index} was requested"),
        "count from 0",
    )
}

fn check_images(recipe: &Recipe, images: &[Image]) -> Result<(), Invalid> {
    let mut fits = images.len() == recipe.images.len();
    for (image, desc) in images.iter().zip(&recipe.images) {
        fits &= image.desc.size == desc.size
            && image.desc.layers == desc.layers
            && image.desc.format == desc.format
            && image.texels.len() as u64 == desc.floats();
    }
    if fits {
        return Ok(());
    }
    Err(Invalid::new(
        "images",
        "differ in number, size or format from the recipe's",
        "pass images as described by the recipe",
    ))
}
