//! Compares the default bias with the best manually tuned one.
//!
//! On each scene, light, kernel and map size, all other biases ([`rivals`]) are rendered on the
//! CPU. The one with the least error counts as manually tuned. [`Bias::ADAPTIVE`], the default, is
//! rendered on every backend. The best of some thirty biases profits from chance: each of them
//! moves the edges of shadows a little, some of them towards the true edges. So a bias that is
//! better by at most [`FEW`] wrong pixels counts as equal.

mod rivals;
mod stage;
mod table;

pub use rivals::rivals;
pub use stage::{Staged, lights_around, stage_scene};
pub use table::{Summary, markdown, write};

use crate::{compare::Backends, error::LabError};
use glam::UVec2;
use serde::{Deserialize, Serialize};
use umbrage_core::{
    Backend, FitMemory, Geometry, RecipeError, ShadowTechnique, View,
    metrics::{Errors, ReferenceMask},
};
use umbrage_plan::catalogue::Catalogue;
use umbrage_plan::truth::{self, TruthOptions};
use umbrage_techniques::{
    Bias, Hard, MapFilter as _, Pcf, PcfDisc, PcfHardware, PcfMerged, ShadowMap, TechniquePreset,
};

/// Number of wrong pixels that count as chance. Every bias moves the edge of a shadow, which is
/// some hundred pixels long.
pub const FEW: f64 = 16.0;

/// Options of a comparison of biases.
#[derive(Clone, Debug)]
pub struct BiasOptions {
    /// Image size, pixels. `None` for each scene's own.
    pub size: Option<UVec2>,
    /// Sides of the maps, texels.
    pub sides: Vec<u32>,
}

impl Default for BiasOptions {
    fn default() -> Self {
        Self {
            size: None,
            sides: vec![512, 2048],
        }
    }
}

/// Error of the default bias on one backend.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DefaultBiasError {
    /// [`Backend::name`].
    pub backend: String,
    /// Root mean square error.
    pub rmse: f64,
}

/// Figures of one scene, light, kernel and map size.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BiasRow {
    /// The scene's name.
    pub scene: String,
    /// Name of the light.
    pub light: String,
    /// Number of triangles.
    pub triangles: usize,
    /// The kernel.
    pub kernel: String,
    /// Side of the map, texels.
    pub side: u32,
    /// Number of pixels that count.
    pub counted: u64,
    /// Errors of the default bias on every backend.
    #[serde(rename = "played")]
    pub default_errors: Vec<DefaultBiasError>,
    /// Least error of the other biases.
    pub best: f64,
    /// The bias with that error.
    pub best_bias: String,
    /// Error of the textbook slope bias.
    pub textbook: f64,
    /// Error of Isidoro's receiver plane bias.
    pub plane: f64,
}

impl BiasRow {
    /// Returns the maximum [`BiasRow::ratio_of`] of the default bias over the backends.
    pub fn ratio(&self) -> f64 {
        self.default_errors
            .iter()
            .map(|executed| self.ratio_of(executed.rmse))
            .fold(0.0, f64::max)
    }

    /// Returns the ratio of an error to the best bias's. [`FEW`] wrong pixels are added to both
    /// mean squares, so that differences by chance count little.
    pub fn ratio_of(&self, rmse: f64) -> f64 {
        let chance = FEW / self.counted.max(1) as f64;
        let square = rmse * rmse + chance;
        let best_square = self.best * self.best + chance;
        (square / best_square).sqrt()
    }
}

/// A named kernel, as a function of its map.
pub type NamedKernel = (&'static str, fn(ShadowMap) -> TechniquePreset);

/// Kernels whose biases are compared.
pub const KERNELS: [NamedKernel; 6] = [
    ("hard", |map| TechniquePreset::from(Hard {}.on(map))),
    ("pcf 3x3", |map| TechniquePreset::from(Pcf::new(1).on(map))),
    ("pcf 7x7", |map| TechniquePreset::from(Pcf::new(3).on(map))),
    ("pcf_hardware 1x1", |map| {
        TechniquePreset::from(PcfHardware { samples: 1 }.on(map))
    }),
    ("pcf_merged 3x3", |map| {
        TechniquePreset::from(PcfMerged { radius: 1 }.on(map))
    }),
    ("pcf_disc", |map| {
        TechniquePreset::from(PcfDisc::default().on(map))
    }),
];

/// Measures the default bias and all others under every light of a staged scene. Rows are in the
/// order of light, kernel and side.
///
/// # Errors
/// Errors if the scene is invalid or a backend fails. Kernels and maps that don't support a light
/// are skipped.
pub fn measure(
    staged: &Staged,
    options: &BiasOptions,
    backends: &mut Backends,
) -> Result<Vec<BiasRow>, LabError> {
    let scene = &staged.scene;
    let geometry = Geometry::bake(scene)?;
    let camera = options
        .size
        .map_or(scene.cameras[0], |size| scene.cameras[0].with_size(size));
    let mut rows = Vec::new();
    for (light_name, light) in &staged.lights {
        let truth = truth::trace(
            &camera,
            light,
            &geometry,
            &TruthOptions::default(),
            &mut |camera, geometry| backends.receivers.receivers(camera, geometry),
            &|_, _| {},
        )?;
        let fits = FitMemory::default();
        let view = View::new(&camera, light, &geometry)
            .with_receivers(&truth.receivers)
            .with_fits(&fits);
        let case = BiasCase {
            view,
            reference: ReferenceMask::new(truth.size, &truth.visibility, &truth.pixels)?,
        };
        for kernel in KERNELS {
            for &side in &options.sides {
                let Some(figures) = case.measure_kernel(kernel, side, backends)? else {
                    continue;
                };
                rows.push(BiasRow {
                    scene: scene.name.clone(),
                    light: light_name.clone(),
                    triangles: geometry.triangles().len(),
                    kernel: kernel.0.to_owned(),
                    side,
                    ..figures
                });
            }
        }
    }
    Ok(rows)
}

/// One light of a scene.
struct BiasCase<'a> {
    view: View<'a>,
    reference: ReferenceMask<'a>,
}

impl BiasCase<'_> {
    /// Returns the figures of one kernel and map size, without the names. `None` if the light is
    /// not supported.
    fn measure_kernel(
        &self,
        kernel: NamedKernel,
        side: u32,
        backends: &mut Backends,
    ) -> Result<Option<BiasRow>, LabError> {
        // Render the default bias on every backend.
        let default = technique(kernel, side, Bias::ADAPTIVE);
        let mut executed = Vec::new();
        let mut counted = 0;
        for backend in &mut backends.backends {
            let Some(errors) = self.errors(&default, &mut **backend)? else {
                return Ok(None);
            };
            executed.push(DefaultBiasError {
                backend: backend.name().to_owned(),
                rmse: errors.rmse,
            });
            counted = errors.counted;
        }
        // Find the best of the other biases.
        let cpu = &mut backends.receivers;
        let mut best = f64::INFINITY;
        let mut best_bias = Bias::NONE;
        let unbiased = technique(kernel, side, Bias::NONE);
        let reach = Catalogue::built_in().kernel_reach(&unbiased);
        for rival in rivals(reach.unwrap_or(0.0)) {
            let rmse = self.rmse(&technique(kernel, side, rival), cpu)?;
            if rmse < best {
                best = rmse;
                best_bias = rival;
            }
        }
        let textbook = self.rmse(&technique(kernel, side, Bias::SLOPE), cpu)?;
        let plane = self.rmse(&technique(kernel, side, Bias::RECEIVER_PLANE), cpu)?;
        Ok(Some(BiasRow {
            scene: String::new(),
            light: String::new(),
            triangles: 0,
            kernel: String::new(),
            side,
            counted,
            default_errors: executed,
            best,
            best_bias: best_bias.label(),
            textbook,
            plane,
        }))
    }

    /// Returns a technique's root mean square error. Infinite if it doesn't support the light.
    fn rmse(
        &self,
        technique: &dyn ShadowTechnique,
        backend: &mut dyn Backend,
    ) -> Result<f64, LabError> {
        let errors = self.errors(technique, backend)?;
        Ok(errors.map_or(f64::INFINITY, |errors| errors.rmse))
    }

    /// Returns a technique's errors. `None` if it doesn't support the light.
    fn errors(
        &self,
        technique: &dyn ShadowTechnique,
        backend: &mut dyn Backend,
    ) -> Result<Option<Errors>, LabError> {
        let recipe = match technique.recipe(&self.view) {
            Ok(recipe) => recipe,
            Err(RecipeError::Unsupported(_)) => return Ok(None),
            Err(e) => return Err(e.into()),
        };
        let shadows = backend.render(&self.view, &recipe)?;
        Ok(Some(self.reference.errors(&shadows.mask)?))
    }
}

/// Returns a kernel on a map of this side, texels, with this bias.
fn technique(kernel: NamedKernel, side: u32, bias: Bias) -> TechniquePreset {
    let (_, on_map) = kernel;
    on_map(ShadowMap {
        size: side,
        bias,
        ..ShadowMap::default()
    })
}

#[cfg(test)]
mod tests;
