//! A candidate that was tried.

use crate::estimate::{error::Estimate, scene::Price};
use serde::{Deserialize, Serialize};
use umbrage_techniques::TechniquePreset;

/// A technique with all its settings, its error and its cost.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Setting {
    /// The settings as data, to be kept in a file; [`TechniquePreset::technique`] makes the technique.
    pub preset: TechniquePreset,
    /// The technique's name.
    pub technique: String,
    /// Its settings in words.
    pub settings: String,
    /// Its estimated error, with confidence limits.
    pub estimate: Estimate,
    /// Predicted time of casts, filters and lookup, milliseconds.
    pub milliseconds: f64,
    /// Bytes of images and tables.
    pub bytes: u64,
}

impl Setting {
    pub(super) fn new(preset: TechniquePreset, estimate: Estimate, price: &Price) -> Self {
        let technique = preset.technique();
        Self {
            preset,
            technique: technique.name().to_owned(),
            settings: technique.settings(),
            estimate,
            milliseconds: price.milliseconds,
            bytes: price.work.bytes,
        }
    }

    /// Returns the setting's name for people: `pcf (3x3, 512, bias: receiver plane)`.
    pub fn label(&self) -> String {
        format!("{} ({})", self.technique, self.settings)
    }
}
