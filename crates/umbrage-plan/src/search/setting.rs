//! A candidate that was tried.

use crate::estimate::error::Estimate;
use serde::{Deserialize, Serialize};
use umbrage_techniques::TechniquePreset;

/// A technique with all its settings, its error and its cost.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Setting {
    /// The settings as data, to be kept in a file; [`TechniquePreset::technique`] makes the
    /// technique.
    pub preset: TechniquePreset,
    /// The technique's name.
    pub technique: String,
    /// Its settings in words.
    pub settings: String,
    /// Its estimated error, with confidence limits; of several cameras that of the worst one that
    /// the plan [holds](super::Hold) for.
    pub estimate: Estimate,
    /// Predicted time of a frame, milliseconds: of casts, filters and lookup, or of the lookup
    /// alone where what is drawn is kept; of several cameras likewise.
    pub milliseconds: f64,
    /// The part of a frame that draws casts and filters, milliseconds, whether each frame does it
    /// or not.
    pub draw_ms: f64,
    /// Whether what it draws is kept while the camera moves; none if that was not asked.
    pub kept_as_camera_moves: Option<bool>,
    /// Bytes of images and tables.
    pub bytes: u64,
    /// Standard deviation of the noise in penumbrae, 0..=1 (Immerkær 1996): what a blur would
    /// remove. None if it was not asked or there are no penumbrae.
    pub grain: Option<f64>,
    /// Mean change of visibility from frame to frame of a pan at points that stand still, 0..=1.
    /// None if it was not asked, or can't be measured.
    pub shimmer: Option<f64>,
    /// The time of a frame by the clock, milliseconds; none if it was not timed.
    pub measured_ms: Option<f64>,
    /// Of several cameras, each one's figures in their order; empty for one camera.
    pub cameras: Vec<CameraFigures>,
}

/// A setting's figures at one of several cameras.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CameraFigures {
    /// Its estimated error there.
    pub estimate: Estimate,
    /// Predicted time of a frame there, milliseconds.
    pub milliseconds: f64,
}

impl Setting {
    /// Returns the setting's name for people: `pcf (3x3, 512, bias: receiver plane)`.
    pub fn label(&self) -> String {
        if self.settings.is_empty() {
            return self.technique.clone();
        }
        format!("{} ({})", self.technique, self.settings)
    }
}
