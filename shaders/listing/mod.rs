//! Techniques as rows of lists and as data in files.
//!
//! A technique implements [`ListedTechnique`] in its own file. [`TechniqueEntry::of`] makes the row of a list from it, and
//! [`TechniquePreset`] holds any technique that has the trait as data, and [`LightPreset`] what of its work may be left out besides.

mod entry;
mod light_preset;
mod preset;

pub use entry::TechniqueEntry;
pub use light_preset::{FrameRules, LightPreset, Update};
pub use preset::TechniquePreset;

use crate::shadow_map::ShadowMap;
use umbrage_core::ShadowTechnique;

/// What files need of settings: `serde`'s traits with the feature `presets`, and nothing without it. Every such type implements
/// it. Another package of the program may enable the feature, so derive both traits.
#[cfg(feature = "presets")]
pub trait Stored: serde::Serialize + serde::de::DeserializeOwned {}

#[cfg(feature = "presets")]
impl<T: serde::Serialize + serde::de::DeserializeOwned> Stored for T {}

/// What files need of settings: nothing, without the feature `presets`.
#[cfg(not(feature = "presets"))]
pub trait Stored {}

#[cfg(not(feature = "presets"))]
impl<T> Stored for T {}

/// A technique that lists and files can hold: its settings are plain data.
///
/// Only [`SUMMARY`](Self::SUMMARY) has no default; techniques with a shadow map also say where it is
/// ([`map`](Self::map), [`with_map`](Self::with_map)). In files, fields that are left out should have their defaults and
/// unknown ones be refused: `#[serde(default, deny_unknown_fields)]`.
///
/// ```
/// use serde::{Deserialize, Serialize};
/// use umbrage_core::{RecipeError, Recipe, ShadowTechnique, View};
/// use umbrage_techniques::{Hard, ListedTechnique, ShadowMap, TechniqueEntry, TechniquePreset};
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
///         Hard { map: self.map }.recipe(view)
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
/// let techniques = [TechniqueEntry::of::<Mine>()];
/// let preset = TechniquePreset::read("technique = 'mine'", &techniques)?;
/// assert_eq!(preset.get::<Mine>(), Some(&Mine::default()));
/// # Ok::<(), umbrage_core::Invalid>(())
/// ```
pub trait ListedTechnique:
    ShadowTechnique + Clone + Default + PartialEq + Stored + 'static
{
    /// What it does, in one line, with the paper it comes from.
    const SUMMARY: &'static str;

    /// Returns the settings in a few words, without the name: `3x3, 1024, slope .05/.005`.
    ///
    /// By default those of the map.
    fn settings(&self) -> String {
        self.map().map_or_else(String::new, ShadowMap::label)
    }

    /// The map that is looked up; `None` for techniques without one.
    fn map(&self) -> Option<&ShadowMap> {
        None
    }

    /// The same settings with another map. Techniques without a map stay as they are.
    #[must_use]
    fn with_map(self, map: ShadowMap) -> Self {
        let _ = map;
        self
    }
}
