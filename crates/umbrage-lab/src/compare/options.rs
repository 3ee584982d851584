//! What is to be compared, and how.

use crate::{LabError, truth::TruthOptions};
use glam::UVec2;
use std::sync::Arc;
use umbrage_core::{Camera, Fit, Invalid, Scene, ShadowTechnique};

/// A scene to be compared.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneInput {
    /// The scene; its first camera and first light count.
    pub scene: Scene,
    /// One line about it for the report, maybe empty.
    pub summary: String,
    /// A light space that a textbook sets by hand: techniques with a map are compared with it, too.
    pub fit: Option<Fit>,
}

/// How a comparison is made.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Names of the techniques; all when empty.
    pub techniques: Vec<String>,
    /// Sides of the shadow maps, texels.
    pub map_sizes: Vec<u32>,
    /// Image size in place of the cameras' own, pixels; the vertical field of view stays.
    pub size: Option<UVec2>,
    /// How truth is traced.
    pub truth: TruthOptions,
    /// Timed runs a row, 1 or more; their median counts.
    pub runs: u32,
    /// Whether every row is shaded in colour, too.
    pub color: bool,
    /// Runs before the timed ones; the first of them compiles and uploads.
    pub warmup: u32,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            techniques: Vec::new(),
            map_sizes: vec![512, 1024, 2048],
            size: None,
            truth: TruthOptions::default(),
            runs: 9,
            color: false,
            warmup: 2,
        }
    }
}

impl Options {
    /// For a first look: small images, one map size, few samples, few runs.
    pub fn quick() -> Self {
        Self {
            map_sizes: vec![512],
            size: Some(UVec2::new(160, 120)),
            truth: TruthOptions { samples: 64, probe_samples: 16, ..TruthOptions::default() },
            runs: 3,
            warmup: 1,
            ..Self::default()
        }
    }

    /// The technique settings to be compared, with maps that lie so.
    ///
    /// # Errors
    /// When a name is unknown or a map size is missing.
    pub(super) fn settings(&self, fit: Fit) -> Result<Vec<Arc<dyn ShadowTechnique>>, LabError> {
        let all = umbrage_techniques::all();
        let known = || all.iter().map(|e| e.name).collect::<Vec<_>>().join(", ");
        if let Some(unknown) = self.techniques.iter().find(|n| all.iter().all(|e| e.name != n.as_str())) {
            let why = format!("there is none called `{unknown}`");
            return Err(Invalid::new("technique", why, format!("use some of {}", known())).into());
        }
        if self.map_sizes.is_empty() {
            return Err(Invalid::new("map sizes", "are missing", "give at least one, such as 1024").into());
        }
        let wanted = |name: &str| self.techniques.is_empty() || self.techniques.iter().any(|n| n == name);
        Ok(all.iter().filter(|e| wanted(e.name)).flat_map(|e| (e.settings)(&self.map_sizes, fit)).collect())
    }

    /// A scene's camera at the size wanted.
    pub(super) fn camera(&self, camera: &Camera) -> Camera {
        self.size.map_or(*camera, |size| camera.resized(size))
    }
}
