//! A row of a list of techniques.

use super::{ListedTechnique, TechniquePreset};
use std::fmt::{self, Debug, Formatter};

/// A technique of a list: what its [`ListedTechnique`] says, whatever its type.
#[derive(Clone, Copy)]
pub struct TechniqueEntry {
    /// Its name, as [`ShadowTechnique::name`](umbrage_core::ShadowTechnique::name) gives it.
    pub name: &'static str,
    /// What it does, in one line.
    pub summary: &'static str,
    /// Whether it looks up a shadow map.
    pub has_map: bool,
    /// Its default settings.
    pub preset: fn() -> TechniquePreset,
    /// Reads its settings.
    #[cfg(feature = "presets")]
    pub(super) read: fn(toml::Table) -> Result<TechniquePreset, toml::de::Error>,
}

/// Its name alone: addresses of functions differ from run to run.
impl Debug for TechniqueEntry {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.name)
    }
}

impl TechniqueEntry {
    /// Returns the row of a technique.
    pub fn of<T: ListedTechnique>() -> Self {
        let default = T::default();
        Self {
            name: default.name(),
            summary: T::SUMMARY,
            has_map: default.map().is_some(),
            preset: || TechniquePreset::from(T::default()),
            #[cfg(feature = "presets")]
            read: |table| T::deserialize(table).map(TechniquePreset::from),
        }
    }
}
