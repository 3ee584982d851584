//! Candidate that was evaluated.

use crate::estimate::error::Estimate;
use serde::{Deserialize, Serialize};
use umbrage_techniques::TechniquePreset;

/// Technique with all its settings, its error and its cost.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Setting {
    /// The settings as data for storage in a file. [`TechniquePreset::technique`] returns the
    /// technique.
    pub preset: TechniquePreset,
    /// The technique's name.
    pub technique: String,
    /// The settings in words.
    pub settings: String,
    /// Estimated error with confidence limits; with several cameras, that of the worst one that the
    /// plan [holds](super::Hold) for.
    pub estimate: Estimate,
    /// Predicted time of a frame, milliseconds, for casts, filters and lookup. If drawn images are
    /// kept, it covers the lookup only. With several cameras, it is that of the worst one that the
    /// plan holds for.
    pub milliseconds: f64,
    /// Predicted time of casts and filters, milliseconds, whether or not each frame draws them.
    pub draw_ms: f64,
    /// True if drawn images are kept while the camera moves; `None` if not evaluated.
    pub kept_as_camera_moves: Option<bool>,
    /// Bytes of images and tables.
    pub bytes: u64,
    /// Standard deviation of the noise in penumbrae, 0..=1 (Immerkær 1996): the part that a blur
    /// would remove. `None` if not evaluated, or if there are no penumbrae.
    pub grain: Option<f64>,
    /// Mean change of visibility from frame to frame of a pan, at fixed points, 0..=1. `None` if
    /// not evaluated, or if it can't be measured.
    pub shimmer: Option<f64>,
    /// Measured time of a frame, milliseconds; `None` if it was not timed.
    pub measured_ms: Option<f64>,
    /// Figures of each of several cameras, in order; empty for one camera.
    pub cameras: Vec<CameraFigures>,
}

/// Figures of a setting at one of several cameras.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CameraFigures {
    /// Estimated error at this camera.
    pub estimate: Estimate,
    /// Predicted time of a frame at this camera, milliseconds.
    pub milliseconds: f64,
}

impl Setting {
    /// Returns the setting's display name, such as `pcf (3x3, 512, bias: receiver plane)`.
    pub fn label(&self) -> String {
        if self.settings.is_empty() {
            return self.technique.clone();
        }
        format!("{} ({})", self.technique, self.settings)
    }
}
