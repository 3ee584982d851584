//! CPU backend: executes the stages of recipes in order, on a configurable number of threads.

use crate::{
    CpuOptions, cast, filter, gbuffer, images,
    raster::{Rasterizer, Rounding},
    receive, shade,
};
use rayon::ThreadPool;
use umbrage_core::glam::Vec4;
use umbrage_core::{
    Backend, BackendError, BackendLimits, Camera, Geometry, Image, Inputs, Invalid, MAX_SIDE,
    Receivers, Recipe, Shadows, Simd, Snapping, Source, Timings, View,
};
// Same as `std::time`, which panics in browsers.
use web_time::{Duration, Instant};

/// Limits of the backend.
const LIMITS: BackendLimits = BackendLimits {
    image_side: MAX_SIDE,
    layers: 2048,
    table_bytes: 2 << 30,
};

/// CPU backend. It keeps its images and working memory between calls, so rendering views of the
/// same size again allocates only the results.
#[derive(Debug)]
pub struct Cpu {
    name: String,
    pool: Option<ThreadPool>,
    pub(crate) simd: Simd,
    pub(crate) rasterizer: Rasterizer,
    /// Fractions by which the channels of filtered images change.
    filter_shift: Vec4,
    pub(crate) images: Vec<Image>,
}

impl Default for Cpu {
    fn default() -> Self {
        Self::new()
    }
}

impl Cpu {
    /// Returns a backend that uses all cores and the best available instructions.
    pub fn new() -> Self {
        Self::build(None, Simd::Native, Rounding::default())
    }

    /// Returns a backend with the given threads, instructions and rounding.
    ///
    /// # Errors
    /// Errors if the number of threads is zero or too large, if they can't be started, or if the
    /// rounding is not supported.
    pub fn with_options(options: &CpuOptions) -> Result<Self, BackendError> {
        options.snapping.validate()?;
        Ok(Self {
            filter_shift: options.filter_shift,
            ..Self::build(options.pool()?, options.simd, options.rounding())
        })
    }

    fn build(pool: Option<ThreadPool>, simd: Simd, rounding: Rounding) -> Self {
        let threads = match &pool {
            Some(pool) => pool.current_num_threads(),
            None => rayon::current_num_threads(),
        };
        let plural = if threads == 1 { "" } else { "s" };
        let name = format!("cpu ({threads} thread{plural}, {})", instructions(simd));
        Self {
            name,
            pool,
            simd,
            rasterizer: Rasterizer::new(rounding),
            filter_shift: Vec4::ZERO,
            images: Vec::new(),
        }
    }

    /// Runs `f` on this backend's threads.
    pub(crate) fn install<R: Send>(&mut self, f: impl FnOnce(&mut Self) -> R + Send) -> R {
        // Take the pool out, so that `f` can borrow the rest.
        let Some(pool) = self.pool.take() else {
            return f(self);
        };
        let result = pool.install(|| f(self));
        self.pool = Some(pool);
        result
    }

    /// Returns the receivers visible to a camera, pixel by pixel, without shading normals.
    ///
    /// # Errors
    /// Errors if the camera is not valid.
    pub fn receivers(
        &mut self,
        camera: &Camera,
        geometry: &Geometry,
    ) -> Result<Receivers, BackendError> {
        camera.validate()?;
        Ok(self.install(|cpu| gbuffer::find(&mut cpu.rasterizer, cpu.simd, camera, geometry)))
    }

    /// Returns the receivers of [`Cpu::receivers`] with shading normals. These are interpolated
    /// between the vertices, normalized, and turned to the camera.
    ///
    /// # Errors
    /// Errors if the camera is not valid.
    pub fn shaded_receivers(
        &mut self,
        camera: &Camera,
        geometry: &Geometry,
    ) -> Result<Receivers, BackendError> {
        let mut found = self.receivers(camera, geometry)?;
        self.install(|_| gbuffer::shade(&mut found, camera, geometry));
        Ok(found)
    }

    /// Returns the bytes of working memory beyond images and receivers.
    pub fn working_bytes(&self) -> usize {
        self.rasterizer.bytes()
    }

    fn execute(&mut self, view: &View<'_>, recipe: &Recipe) -> Result<Shadows, BackendError> {
        check(view, recipe)?;
        let mut timings = Timings::default();
        // Find the receivers if the view has none.
        let found = match (view.receivers, view.geometry) {
            (None, Some(geometry)) => {
                let found = measure_time(&mut timings.receivers, || {
                    self.receivers(view.camera, geometry)
                });
                Some(found?)
            }
            _ => None,
        };
        let Some(receivers) = view.receivers.or(found.as_ref()) else {
            return Err(nothing_seen().into());
        };
        // Execute the stages, and time each.
        images::prepare_images(&mut self.images, recipe);
        if !recipe.casts.is_empty() {
            measure_time(&mut timings.cast, || self.cast_all(view.geometry, recipe));
        }
        if !recipe.filters.is_empty() {
            measure_time(&mut timings.filter, || {
                filter::filter_all(&mut self.images, recipe, self.simd, self.filter_shift)
            });
        }
        let mask = measure_time(&mut timings.receive, || {
            receive::receive(&self.images, recipe, receivers, self.simd)
        });
        let picture = recipe
            .shade
            .as_ref()
            .map(|shade| shade::shade(shade, receivers, &mask));
        let bytes = image_bytes(recipe) + recipe.made_table_bytes() + gbuffer::bytes(receivers);
        let images = if recipe.keep_images {
            self.images.clone()
        } else {
            Vec::new()
        };
        Ok(Shadows {
            size: view.camera.size,
            mask,
            receivers: found,
            picture,
            images,
            timings,
            bytes,
        })
    }

    /// Executes the stages before the receive stage.
    pub(crate) fn draw(&mut self, view: &View<'_>, recipe: &Recipe) -> Result<(), BackendError> {
        check(view, recipe)?;
        images::prepare_images(&mut self.images, recipe);
        self.cast_all(view.geometry, recipe);
        filter::filter_all(&mut self.images, recipe, self.simd, self.filter_shift);
        Ok(())
    }

    /// Executes the stages before the receive stage, then calls `run` with the inputs of the
    /// receive kernel.
    pub(crate) fn with_inputs<R>(
        &mut self,
        view: &View<'_>,
        recipe: &Recipe,
        run: impl FnOnce(&Inputs<'_>) -> R,
    ) -> Result<R, BackendError> {
        self.draw(view, recipe)?;
        let views = images::views(&self.images, &recipe.receive.inputs);
        let inputs = Inputs {
            images: &views,
            simd: self.simd,
        };
        // Build the tables, since kernels may read their sources.
        recipe.make_tables();
        Ok(run(&inputs))
    }

    fn cast_all(&mut self, geometry: Option<&Geometry>, recipe: &Recipe) {
        let empty = Geometry::default();
        let geometry = geometry.unwrap_or(&empty);
        for index in 0..recipe.casts.len() {
            cast::execute_cast(
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
        self.rasterizer.rounding.snapping
    }

    fn render(&mut self, view: &View<'_>, recipe: &Recipe) -> Result<Shadows, BackendError> {
        self.install(|cpu| cpu.execute(view, recipe))
    }
}

/// Runs `f` and stores its duration.
fn measure_time<R>(slot: &mut Option<Duration>, f: impl FnOnce() -> R) -> R {
    let start = Instant::now();
    let result = f();
    *slot = Some(start.elapsed());
    result
}

/// Returns the name of the instruction set, such as `V3`.
fn instructions(simd: Simd) -> String {
    match simd {
        Simd::Native => {
            // Use the variant's name without its fields.
            let arch = format!("{:?}", pulp::Arch::new());
            let name = arch.split(['(', ' ']).next();
            name.unwrap_or("native").to_owned()
        }
        Simd::Baseline => "baseline".to_owned(),
    }
}

/// Errors if the recipe can't be executed for the view.
fn check(view: &View<'_>, recipe: &Recipe) -> Result<(), Invalid> {
    check_recipe(recipe)?;
    view.camera.validate()?;
    if let Some(geometry) = view.geometry {
        recipe.check_holes(geometry)?;
    }
    let casts_geometry = recipe
        .casts
        .iter()
        .any(|cast| !matches!(cast.source, Source::Faces(_)));
    if view.geometry.is_none() && casts_geometry {
        return Err(nothing_to_cast());
    }
    match view.receivers {
        Some(receivers) => gbuffer::check(receivers, view.camera.size),
        None => Ok(()),
    }
}

/// Errors if the CPU backend can't execute the recipe.
pub(crate) fn check_recipe(recipe: &Recipe) -> Result<(), Invalid> {
    recipe.validate(&LIMITS)
}

/// Returns the bytes of the recipe's images, which are stored as 32-bit floats in any format.
fn image_bytes(recipe: &Recipe) -> u64 {
    recipe.images.iter().map(|image| 4 * image.floats()).sum()
}

fn nothing_to_cast() -> Invalid {
    Invalid::new(
        "view",
        "has no geometry, but the recipe casts",
        "set `geometry`: the CPU backend draws its triangles",
    )
}

pub(crate) fn nothing_seen() -> Invalid {
    Invalid::new(
        "view",
        "has neither receivers nor geometry",
        "set `receivers`, or `geometry` to find them from",
    )
}
