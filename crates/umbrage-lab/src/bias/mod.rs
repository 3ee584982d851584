//! The default bias against all others: how far it is from the best that tuning by hand would have found.
//!
//! On each scene, light, kernel and map size every rival ([`rivals`]) is played on the CPU, and the one with the least error
//! counts as tuned by hand; [`Bias::ADAPTIVE`] is played on every backend. The best of some thirty rivals profits from chance:
//! each moves every shadow's edge a little, and some edges thereby fall nearer to the true ones. So a rival that is better
//! by no more than [`FEW`] wrong pixels counts as equal.

mod rivals;
mod stage;
mod table;

pub use rivals::rivals;
pub use stage::{Staged, lights_around, staged};
pub use table::{Summary, markdown, write};

use crate::{LabError, compare::Backends};
use glam::UVec2;
use serde::{Deserialize, Serialize};
use umbrage_core::{
    Backend, FitMemory, Geometry, RecipeError, ShadowTechnique, View, metrics::ReferenceMask,
};
use umbrage_plan::truth::{self, TruthOptions};
use umbrage_techniques::{Bias, Hard, Pcf, PcfDisc, PcfHardware, PcfMerged, ShadowMap};

/// As many wrong pixels are left to chance. (A shadow's edge that is some hundred pixels long is moved by every bias.)
pub const FEW: f64 = 16.0;

/// What is played.
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
    /// The default's [`BiasRow::ratio_of`], the greatest over the backends.
    pub fn ratio(&self) -> f64 {
        self.played
            .iter()
            .map(|played| self.ratio_of(played.rmse))
            .fold(0.0, f64::max)
    }

    /// An error over the best rival's, both with [`FEW`] wrong pixels added in squares.
    pub fn ratio_of(&self, rmse: f64) -> f64 {
        let chance = FEW / self.counted.max(1) as f64;
        let square = |error: f64| error * error + chance;
        (square(rmse) / square(self.best)).sqrt()
    }
}

/// A kernel with a name, as a function of its map.
pub type NamedKernel = (&'static str, fn(ShadowMap) -> Box<dyn ShadowTechnique>);

/// The kernels whose biases are compared.
pub const KERNELS: [NamedKernel; 6] = [
    ("hard", |map| Box::new(Hard { map })),
    ("pcf 3x3", |map| Box::new(Pcf { map, radius: 1 })),
    ("pcf 7x7", |map| Box::new(Pcf { map, radius: 3 })),
    ("pcf_hardware 1x1", |map| {
        Box::new(PcfHardware { map, samples: 1 })
    }),
    ("pcf_merged 3x3", |map| {
        Box::new(PcfMerged { map, radius: 1 })
    }),
    ("pcf_disc", |map| {
        Box::new(PcfDisc {
            map,
            ..PcfDisc::default()
        })
    }),
];

/// Plays the default and all rivals under every light of a staged scene. Rows in order of light, kernel and side.
///
/// # Errors
/// Errors if the scene is not valid or a backend fails. Kernels and maps that can't serve a light are left out.
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
        let receivers = &mut backends.receivers;
        let mut find = |camera: &_, geometry: &_| receivers.receivers(camera, geometry);
        let truth = truth::trace(
            &camera,
            light,
            &geometry,
            &TruthOptions::default(),
            &mut find,
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
    /// The figures of one kernel and side, without the names; none where the light is not served.
    fn play(
        &self,
        kernel: NamedKernel,
        side: u32,
        backends: &mut Backends,
    ) -> Result<Option<BiasRow>, LabError> {
        let with = |bias: Bias| {
            kernel.1(ShadowMap {
                size: side,
                bias,
                ..ShadowMap::default()
            })
        };
        let mut played = Vec::new();
        let mut counted = 0;
        for backend in &mut backends.playing {
            let Some((rmse, pixels)) = self.error(&*with(Bias::ADAPTIVE), &mut **backend)? else {
                return Ok(None);
            };
            played.push(DefaultBiasError {
                backend: backend.name().to_owned(),
                rmse,
            });
            counted = pixels;
        }
        let cpu = &mut backends.receivers;
        let mut of = |bias: Bias| {
            self.error(&*with(bias), cpu)
                .map(|found| found.map_or(f64::INFINITY, |(rmse, _)| rmse))
        };
        let (mut best, mut best_bias) = (f64::INFINITY, Bias::NONE);
        for rival in rivals(with(Bias::NONE).kernel_reach().unwrap_or(0.0)) {
            let rmse = of(rival)?;
            if rmse < best {
                (best, best_bias) = (rmse, rival);
            }
        }
        let (textbook, plane) = (of(Bias::SLOPE)?, of(Bias::RECEIVER_PLANE)?);
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

    /// A technique's error and the pixels that count; none where it doesn't serve the light.
    fn error(
        &self,
        technique: &dyn ShadowTechnique,
        backend: &mut dyn Backend,
    ) -> Result<Option<(f64, u64)>, LabError> {
        let recipe = match technique.recipe(&self.view) {
            Ok(recipe) => recipe,
            Err(RecipeError::Unsupported(_)) => return Ok(None),
            Err(e) => return Err(e.into()),
        };
        let shadows = backend.render(&self.view, &recipe)?;
        let errors = self.reference.errors(&shadows.mask)?;
        Ok(Some((errors.rmse, errors.counted)))
    }
}

#[cfg(test)]
mod tests;
