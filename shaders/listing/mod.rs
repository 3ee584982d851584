//! Techniques as list entries and as data in files.
//!
//! A technique implements [`ListedTechnique`] in its own file. [`TechniqueEntry::for_technique`]
//! builds its list entry. [`TechniquePreset`] stores any such technique as data. [`LightPreset`]
//! adds rules for the work that may be skipped.

mod entry;
mod light_preset;
mod preset;

pub use entry::TechniqueEntry;
pub use light_preset::{FrameRules, LightPreset, Update};
pub use preset::TechniquePreset;

use crate::shadow_map::ShadowMap;
#[cfg(feature = "presets")]
pub(crate) use serde::{Serialize, de::DeserializeOwned};
use umbrage_core::ShadowTechnique;
#[cfg(not(feature = "presets"))]
pub(crate) use without_files::{DeserializeOwned, Serialize};

/// Replacement for `serde` without the feature `presets`, implemented by every type.
#[cfg(not(feature = "presets"))]
mod without_files {
    pub trait Serialize {}
    impl<T> Serialize for T {}

    pub trait DeserializeOwned {}
    impl<T> DeserializeOwned for T {}
}

/// A technique that can be listed and stored in files: its settings are plain data.
///
/// Only [`SUMMARY`](Self::SUMMARY) has no default. Techniques with a shadow map also implement
/// [`map`](Self::map) and [`with_map`](Self::with_map). Without the feature `presets` the settings
/// need no `serde` traits. Derive them anyway, because another package of the program may enable
/// that feature. When reading files, use defaults for missing fields and refuse unknown ones:
/// `#[serde(default, deny_unknown_fields)]`.
///
/// ```
/// use serde::{Deserialize, Serialize};
/// use umbrage_core::{RecipeError, Recipe, ShadowTechnique, View};
/// use umbrage_techniques::{Hard, ListedTechnique, MapFilter as _, ShadowMap};
/// use umbrage_techniques::{TechniqueEntry, TechniquePreset};
///
/// /// One comparison, under another name.
/// #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
/// #[serde(default, deny_unknown_fields)]
/// struct Mine {
///     map: ShadowMap,
/// }
///
/// impl ShadowTechnique for Mine {
///     fn name(&self) -> &'static str {
///         "mine"
///     }
///     fn recipe(&self, view: &View<'_>) -> Result<Recipe, RecipeError> {
///         Hard {}.on(self.map).recipe(view)
///     }
/// }
///
/// impl ListedTechnique for Mine {
///     const SUMMARY: &'static str = "one comparison, mine";
///     fn map(&self) -> Option<&ShadowMap> {
///         Some(&self.map)
///     }
///     fn with_map(self, map: ShadowMap) -> Self {
///         Self { map }
///     }
/// }
///
/// let techniques = [TechniqueEntry::for_technique::<Mine>()];
/// let preset = TechniquePreset::read("technique = 'mine'", &techniques)?;
/// assert_eq!(preset.get::<Mine>(), Some(&Mine::default()));
/// # Ok::<(), umbrage_core::Invalid>(())
/// ```
pub trait ListedTechnique:
    ShadowTechnique + Clone + Default + PartialEq + Serialize + DeserializeOwned + 'static
{
    /// One-line summary with the paper that describes the technique.
    const SUMMARY: &'static str;

    /// Returns the settings in a few words, without the name: `3x3, 1024, slope .05/.005`.
    ///
    /// Defaults to the settings of the map.
    fn settings(&self) -> String {
        self.map().map_or_else(String::new, ShadowMap::label)
    }

    /// Returns the shadow map; `None` for techniques without one.
    fn map(&self) -> Option<&ShadowMap> {
        None
    }

    /// Returns the same settings with another map. Techniques without a map stay unchanged.
    #[must_use]
    fn with_map(self, map: ShadowMap) -> Self {
        let _ = map;
        self
    }
}
