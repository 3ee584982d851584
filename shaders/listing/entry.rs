//! Entry of a technique list.

use super::{ListedTechnique, TechniquePreset};
use std::fmt::{self, Debug, Formatter};

/// Type-erased entry of a technique list, filled from a [`ListedTechnique`].
#[derive(Clone, Copy)]
pub struct TechniqueEntry {
    /// Technique name, equal to [`ShadowTechnique::name`](umbrage_core::ShadowTechnique::name).
    pub name: &'static str,
    /// One-line summary.
    pub summary: &'static str,
    /// True if the technique looks up a shadow map.
    pub has_map: bool,
    /// Returns the default settings.
    pub preset: fn() -> TechniquePreset,
    /// Parses the settings.
    #[cfg(feature = "presets")]
    pub(super) read: fn(toml::Table) -> Result<TechniquePreset, toml::de::Error>,
}

/// Prints only the name, because function addresses differ between runs.
impl Debug for TechniqueEntry {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.name)
    }
}

impl TechniqueEntry {
    /// Returns the list entry of a technique.
    pub fn for_technique<T: ListedTechnique>() -> Self {
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
