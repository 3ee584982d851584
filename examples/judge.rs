//! Errors of masks and of other renderers' images against ray-traced visibility.

use anyhow::{Result, ensure};
use umbrage::{
    Backend, Geometry, Scene, ShadowTechnique, Shadows, View,
    cpu::Cpu,
    glam::UVec2,
    metrics::{Errors, Pixel, ReferenceMask},
};
use umbrage_plan::truth::{Truth, TruthOptions, trace};

/// A scene with the ray-traced visibility of its first light, as its first camera sees it.
pub struct JudgedScene {
    /// The scene.
    pub scene: Scene,
    /// All its triangles.
    pub geometry: Geometry,
    /// The reference.
    pub truth: Truth,
}

/// A mask, and its distance from the reference.
pub struct JudgedMask {
    /// Visibility of the light, row by row.
    pub mask: Vec<f32>,
    /// The evaluated pixels.
    pub pixels: Vec<Pixel>,
    /// The distance.
    pub errors: Errors,
}

impl JudgedScene {
    /// Traces a built-in scene or a file, with another image size if one is given.
    ///
    /// # Errors
    /// Returns an error if there is no such scene, or it is invalid.
    pub fn by_argument(name: &str, size: Option<UVec2>, options: &TruthOptions) -> Result<Self> {
        let mut scene = umbrage::scenes::by_argument(name)?;
        if let Some(size) = size {
            scene.cameras[0] = scene.cameras[0].with_size(size);
        }
        Self::new(scene, options)
    }

    /// Traces a scene.
    ///
    /// # Errors
    /// Returns an error if the scene is invalid.
    pub fn new(scene: Scene, options: &TruthOptions) -> Result<Self> {
        let geometry = Geometry::bake(&scene)?;
        let mut cpu = Cpu::new();
        let truth = trace(
            &scene.cameras[0],
            &scene.lights[0],
            &geometry,
            options,
            &mut |camera, geometry| cpu.receivers(camera, geometry),
            &|_, _| (),
        )?;
        Ok(Self {
            scene,
            geometry,
            truth,
        })
    }

    /// Returns the view.
    pub fn view(&self) -> View<'_> {
        View::new(
            &self.scene.cameras[0],
            &self.scene.lights[0],
            &self.geometry,
        )
        .with_receivers(&self.truth.receivers)
    }

    /// Executes a technique.
    ///
    /// # Errors
    /// Returns an error if the technique doesn't support the view, or the backend fails.
    pub fn render(
        &self,
        backend: &mut dyn Backend,
        technique: &dyn ShadowTechnique,
    ) -> Result<Shadows> {
        let view = self.view();
        Ok(backend.render(&view, &technique.recipe(&view)?)?)
    }

    /// Judges a mask.
    ///
    /// # Errors
    /// Returns an error if the mask has another size than the reference.
    pub fn judge(&self, mask: Vec<f32>) -> Result<JudgedMask> {
        self.judge_where(mask, self.truth.pixels.clone())
    }

    /// Judges an image with shadows by one without, both linear. Pixels darker than `dark` without
    /// shadows are excluded: the light doesn't reach them in that renderer.
    ///
    /// # Errors
    /// Returns an error if the images have another size than the reference.
    pub fn judge_image(&self, lit: &[f32], shadowed: &[f32], dark: f32) -> Result<JudgedMask> {
        let mut pixels = self.truth.pixels.clone();
        ensure!(
            lit.len() == pixels.len() && shadowed.len() == pixels.len(),
            "images of {} and {} pixels, a reference of {}: use one size",
            lit.len(),
            shadowed.len(),
            pixels.len()
        );
        let mut mask = vec![1.0; lit.len()];
        for i in 0..lit.len() {
            if lit[i] >= dark {
                mask[i] = (shadowed[i] / lit[i]).clamp(0.0, 1.0);
            } else if pixels[i] == Pixel::Counted {
                pixels[i] = Pixel::Elsewhere;
            }
        }
        self.judge_where(mask, pixels)
    }

    fn judge_where(&self, mask: Vec<f32>, pixels: Vec<Pixel>) -> Result<JudgedMask> {
        let truth = &self.truth;
        let reference = ReferenceMask::new(truth.size, &truth.visibility, &truth.pixels)?;
        let errors = reference.with_pixels(&pixels)?.errors(&mask)?;
        Ok(JudgedMask {
            mask,
            pixels,
            errors,
        })
    }
}
