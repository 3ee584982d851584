//! The player: stages in order, on threads of its choice.

use crate::{CpuOptions, cast, filter, gbuffer, images, raster::Rasterizer, receive, shade};
use rayon::ThreadPool;
use std::time::{Duration, Instant};
use umbrage_core::{
    Backend, BackendError, BackendLimits, Camera, Cast, Geometry, Image, Invalid, MAX_SIDE,
    Receivers, Recipe, Shadows, Simd, Snapping, Source, Timings, View,
};

/// What the player takes on.
const LIMITS: BackendLimits = BackendLimits {
    image_side: MAX_SIDE,
    layers: 2048,
    table_bytes: 2 << 30,
};

/// The CPU player. Its images and working memory are kept from call to call, so rendering views of the same size again
/// allocates nothing but what it hands out.
#[derive(Debug)]
pub struct Cpu {
    name: String,
    pool: Option<ThreadPool>,
    pub(crate) simd: Simd,
    pub(crate) rasterizer: Rasterizer,
    pub(crate) images: Vec<Image>,
}

impl Default for Cpu {
    fn default() -> Self {
        Self::new()
    }
}

impl Cpu {
    /// Uses all cores and the best instructions there are.
    pub fn new() -> Self {
        Self::build(None, Simd::Native, Snapping::default())
    }

    /// Uses threads, instructions and rounding of the caller's choice.
    ///
    /// # Errors
    /// Errors if the number of threads is zero or absurd, or they can't be started; when the rounding is not known.
    pub fn with_options(options: &CpuOptions) -> Result<Self, BackendError> {
        options.snapping.validate()?;
        Ok(Self::build(options.pool()?, options.simd, options.snapping))
    }

    fn build(pool: Option<ThreadPool>, simd: Simd, snapping: Snapping) -> Self {
        let threads = pool
            .as_ref()
            .map_or_else(rayon::current_num_threads, ThreadPool::current_num_threads);
        let plural = if threads == 1 { "" } else { "s" };
        let name = format!("cpu ({threads} thread{plural}, {})", instructions(simd));
        Self {
            name,
            pool,
            simd,
            rasterizer: Rasterizer::new(snapping),
            images: Vec::new(),
        }
    }

    /// Runs `f` on this player's threads.
    pub(crate) fn install<R: Send>(&mut self, f: impl FnOnce(&mut Self) -> R + Send) -> R {
        // The pool steps aside, so that `f` can have the rest.
        let Some(pool) = self.pool.take() else {
            return f(self);
        };
        let result = pool.install(|| f(self));
        self.pool = Some(pool);
        result
    }

    /// What a camera sees of a geometry, pixel by pixel, without shading normals.
    ///
    /// # Errors
    /// Errors if the camera is unusable.
    pub fn receivers(
        &mut self,
        camera: &Camera,
        geometry: &Geometry,
    ) -> Result<Receivers, BackendError> {
        camera.validate()?;
        Ok(self.install(|cpu| gbuffer::find(&mut cpu.rasterizer, cpu.simd, camera, geometry)))
    }

    /// As [`Cpu::receivers`], with shading normals: interpolated between the vertices', unit, turned to the camera.
    ///
    /// # Errors
    /// Errors if the camera is unusable.
    pub fn shaded_receivers(
        &mut self,
        camera: &Camera,
        geometry: &Geometry,
    ) -> Result<Receivers, BackendError> {
        let mut found = self.receivers(camera, geometry)?;
        self.install(|_| gbuffer::shade(&mut found, camera, geometry));
        Ok(found)
    }

    /// Bytes of working memory beyond images and receivers.
    pub fn working_bytes(&self) -> usize {
        self.rasterizer.bytes()
    }

    fn play(&mut self, view: &View<'_>, recipe: &Recipe) -> Result<Shadows, BackendError> {
        check(view, recipe)?;
        let mut timings = Timings::default();
        let made = match (view.receivers, view.geometry) {
            (None, Some(geometry)) => Some(timed(&mut timings.receivers, || {
                self.receivers(view.camera, geometry)
            })?),
            _ => None,
        };
        let Some(receivers) = view.receivers.or(made.as_ref()) else {
            return Err(nothing_seen().into());
        };
        images::prepare_images(&mut self.images, recipe);
        if !recipe.casts.is_empty() {
            timed(&mut timings.cast, || self.cast_all(view.geometry, recipe));
        }
        if !recipe.filters.is_empty() {
            timed(&mut timings.filter, || {
                filter::filter_all(&mut self.images, recipe, self.simd)
            });
        }
        let mask = timed(&mut timings.receive, || {
            receive::receive(&self.images, recipe, receivers, self.simd)
        });
        let picture = recipe
            .shade
            .as_ref()
            .map(|shade| shade::shade(shade, receivers, &mask));
        let bytes = image_bytes(recipe) + recipe.table_bytes() + gbuffer::bytes(receivers);
        let images = if recipe.keep_images {
            self.images.clone()
        } else {
            Vec::new()
        };
        Ok(Shadows {
            size: view.camera.size,
            mask,
            receivers: made,
            picture,
            images,
            timings,
            bytes,
        })
    }

    /// Plays all that comes before the lookup.
    pub(crate) fn draw(&mut self, view: &View<'_>, recipe: &Recipe) -> Result<(), BackendError> {
        check(view, recipe)?;
        images::prepare_images(&mut self.images, recipe);
        self.cast_all(view.geometry, recipe);
        filter::filter_all(&mut self.images, recipe, self.simd);
        Ok(())
    }

    fn cast_all(&mut self, geometry: Option<&Geometry>, recipe: &Recipe) {
        let nothing = Geometry::default();
        for index in 0..recipe.casts.len() {
            let geometry = geometry.unwrap_or(&nothing);
            cast::play(
                &mut self.rasterizer,
                &mut self.images,
                recipe,
                index,
                geometry,
                self.simd,
            );
        }
    }
}

impl Backend for Cpu {
    fn name(&self) -> &str {
        &self.name
    }

    fn kind(&self) -> &'static str {
        "cpu"
    }

    fn snapping(&self) -> Snapping {
        self.rasterizer.snapping
    }

    fn render(&mut self, view: &View<'_>, recipe: &Recipe) -> Result<Shadows, BackendError> {
        self.install(|cpu| cpu.play(view, recipe))
    }
}

/// Runs `f` and notes how long it took.
fn timed<R>(slot: &mut Option<Duration>, f: impl FnOnce() -> R) -> R {
    let start = Instant::now();
    let result = f();
    *slot = Some(start.elapsed());
    result
}

fn instructions(simd: Simd) -> String {
    match simd {
        Simd::Native => format!("{:?}", pulp::Arch::new())
            .split(['(', ' '])
            .next()
            .unwrap_or("native")
            .to_owned(),
        Simd::Baseline => "baseline".to_owned(),
    }
}

/// Objects to what can't be played.
fn check(view: &View<'_>, recipe: &Recipe) -> Result<(), Invalid> {
    check_recipe(recipe)?;
    view.camera.validate()?;
    let from_geometry = |cast: &Cast| !matches!(cast.source, Source::Faces(_));
    if view.geometry.is_none() && recipe.casts.iter().any(from_geometry) {
        return Err(nothing_to_cast());
    }
    view.receivers
        .map_or(Ok(()), |r| gbuffer::check(r, view.camera.size))
}

/// Objects to recipes that this player cannot play.
pub(crate) fn check_recipe(recipe: &Recipe) -> Result<(), Invalid> {
    recipe.validate(&LIMITS)
}

/// Images hold 32-bit floats, whatever their format.
fn image_bytes(recipe: &Recipe) -> u64 {
    recipe.images.iter().map(|image| 4 * image.floats()).sum()
}

fn nothing_to_cast() -> Invalid {
    Invalid::new(
        "view",
        "has no geometry, but the recipe casts",
        "set `geometry`: the CPU player draws its triangles",
    )
}

pub(crate) fn nothing_seen() -> Invalid {
    Invalid::new(
        "view",
        "has neither receivers nor geometry",
        "set `receivers`, or `geometry` to find them from",
    )
}
