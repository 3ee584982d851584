//! A candidate that was tried.

use crate::estimate::{error::Estimate, scene::Price};
use serde::{Deserialize, Serialize};
use umbrage_techniques::TechniquePreset;

/// A technique with all its settings, what it errs and what it costs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Setting {
    /// To be kept in a file, and to be planned: [`TechniquePreset::technique`].
    pub preset: TechniquePreset,
    /// The technique's name.
    pub technique: String,
    /// Its settings in words.
    pub settings: String,
    /// What it errs, with confidence.
    pub estimate: Estimate,
    /// Predicted time of casts, filters and lookup, milliseconds.
    pub milliseconds: f64,
    /// Bytes of images and tables.
    pub bytes: u64,
}

impl Setting {
    pub(super) fn new(preset: TechniquePreset, estimate: Estimate, price: &Price) -> Self {
        let technique = preset.technique();
        let (milliseconds, bytes) = (price.milliseconds, price.work.bytes);
        let (name, settings) = (technique.name().to_owned(), technique.settings());
        Self {
            preset,
            technique: name,
            settings,
            estimate,
            milliseconds,
            bytes,
        }
    }

    /// For people: `pcf (3x3, 512, bias: receiver plane)`.
    pub fn label(&self) -> String {
        format!("{} ({})", self.technique, self.settings)
    }
}
