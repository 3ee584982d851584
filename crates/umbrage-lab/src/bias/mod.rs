//! Compares the default bias with all others: how far it is from the best that tuning by hand would
//! have found.
//!
//! On each scene, light, kernel and map size every other bias ([`rivals`]) is played on the CPU,
//! and the one with the least error counts as tuned by hand; [`Bias::ADAPTIVE`], the default, is
//! played on every backend. The best of some thirty biases profits from chance: each moves every
//! shadow's edge a little, and some edges thereby fall nearer to the true ones. So a bias that is
//! better by no more than [`FEW`] wrong pixels counts as equal.

mod rivals;
mod stage;
mod table;

pub use rivals::rivals;
pub use stage::{Staged, lights_around, staged};
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

/// The number of wrong pixels that count as chance. (Every bias moves a shadow's edge, which is
/// some hundred pixels long.)
pub const FEW: f64 = 16.0;

/// Options of a comparison of biases.
#[derive(Clone, Debug)]
pub struct BiasOptions {
    /// Image size, pixels; none for each scene's own.
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

/// The default's error on one backend.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DefaultBiasError {
    /// [`Backend::name`].
    pub backend: String,
    /// Root mean square error.
    pub rmse: f64,
}

/// One scene, light, kernel and map size.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BiasRow {
    /// The scene's name.
    pub scene: String,
    /// Which of its lights.
    pub light: String,
    /// Triangles.
    pub triangles: usize,
    /// The kernel.
    pub kernel: String,
    /// Side of the map, texels.
    pub side: u32,
    /// Pixels that count.
    pub counted: u64,
    /// The default on every backend.
    pub played: Vec<DefaultBiasError>,
    /// The least error of any rival.
    pub best: f64,
    /// That rival's bias.
    pub best_bias: String,
    /// The error of the textbooks' slope bias.
    pub textbook: f64,
    /// The error of Isidoro's receiver plane.
    pub plane: f64,
}

impl BiasRow {
    /// Returns the default's [`BiasRow::ratio_of`], the greatest over the backends.
    pub fn ratio(&self) -> f64 {
        self.played
            .iter()
            .map(|played| self.ratio_of(played.rmse))
            .fold(0.0, f64::max)
    }

    /// Returns an error over the best rival's. To both mean squares [`FEW`] wrong pixels are added,
    /// so that differences by chance count little.
    pub fn ratio_of(&self, rmse: f64) -> f64 {
        let chance = FEW / self.counted.max(1) as f64;
        let square = rmse * rmse + chance;
        let best_square = self.best * self.best + chance;
        (square / best_square).sqrt()
    }
}

/// A kernel with a name, as a function of its map.
pub type NamedKernel = (&'static str, fn(ShadowMap) -> TechniquePreset);

/// The kernels whose biases are compared.
pub const KERNELS: [NamedKernel; 6] = [
    ("hard", |map| TechniquePreset::from(Hard {}.on(map))),
    ("pcf 3x3", |map| {
        TechniquePreset::from(Pcf { radius: 1 }.on(map))
    }),
    ("pcf 7x7", |map| {
        TechniquePreset::from(Pcf { radius: 3 }.on(map))
    }),
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

/// Plays the default and all rivals under every light of a staged scene. Rows in order of light,
/// kernel and side.
///
/// # Errors
/// Errors if the scene is not valid or a backend fails. Kernels and maps that can't serve a light
/// are left out.
pub fn measure(
    staged: &Staged,
    options: &BiasOptions,
    backends: &mut Backends,
) -> Result<Vec<BiasRow>, LabError> {
    let scene = &staged.scene;
    let geometry = Geometry::bake(scene)?;
    let camera = options
        .size
        .map_or(scene.cameras[0], |size| scene.cameras[0].resized(size));
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
        let case = Case {
            view,
            reference: ReferenceMask::new(truth.size, &truth.visibility, &truth.pixels)?,
        };
        for kernel in KERNELS {
            for &side in &options.sides {
                let Some(figures) = case.play(kernel, side, backends)? else {
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

/// One light of one scene.
struct Case<'a> {
    view: View<'a>,
    reference: ReferenceMask<'a>,
}

impl Case<'_> {
    /// Returns the figures of one kernel and map size, without the names; none where the light is
    /// not served.
    fn play(
        &self,
        kernel: NamedKernel,
        side: u32,
        backends: &mut Backends,
    ) -> Result<Option<BiasRow>, LabError> {
        let default = technique(kernel, side, Bias::ADAPTIVE);
        let mut played = Vec::new();
        let mut counted = 0;
        for backend in &mut backends.playing {
            let Some(errors) = self.errors(&default, &mut **backend)? else {
                return Ok(None);
            };
            played.push(DefaultBiasError {
                backend: backend.name().to_owned(),
                rmse: errors.rmse,
            });
            counted = errors.counted;
        }
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
            played,
            best,
            best_bias: best_bias.label(),
            textbook,
            plane,
        }))
    }

    /// Returns a technique's root mean square error; infinite where it doesn't serve the light.
    fn rmse(
        &self,
        technique: &dyn ShadowTechnique,
        backend: &mut dyn Backend,
    ) -> Result<f64, LabError> {
        let errors = self.errors(technique, backend)?;
        Ok(errors.map_or(f64::INFINITY, |errors| errors.rmse))
    }

    /// Returns a technique's errors; none where it doesn't serve the light.
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
