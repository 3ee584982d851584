//! Techniques as rows of lists and as data in files.
//!
//! A technique implements [`ListedTechnique`] in its own file. [`TechniqueEntry::of`] makes the row
//! of a list from it, and [`TechniquePreset`] holds any technique that has the trait as data, and
//! [`LightPreset`] what of its work may be left out besides.

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

/// Stands in for `serde` without the feature `presets`: any type will do.
#[cfg(not(feature = "presets"))]
mod without_files {
    pub trait Serialize {}
    impl<T> Serialize for T {}

    pub trait DeserializeOwned {}
    impl<T> DeserializeOwned for T {}
}

/// A technique that lists and files can hold: its settings are plain data.
///
/// Only [`SUMMARY`](Self::SUMMARY) has no default; techniques with a shadow map also say where it
/// is ([`map`](Self::map), [`with_map`](Self::with_map)). Without the feature `presets` it need not
/// be data; but another package of the program may enable that, so derive `serde`'s traits. In
/// files, fields that are left out should have their defaults and unknown ones be refused:
/// `#[serde(default, deny_unknown_fields)]`.
///
/// ```
/// use serde::{Deserialize, Serialize};
/// use umbrage_core::{RecipeError, Recipe, ShadowTechnique, View};
/// use umbrage_techniques::{Hard, ListedTechnique, MapFilter as _, ShadowMap, TechniqueEntry, TechniquePreset};
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
/// let techniques = [TechniqueEntry::of::<Mine>()];
/// let preset = TechniquePreset::read("technique = 'mine'", &techniques)?;
/// assert_eq!(preset.get::<Mine>(), Some(&Mine::default()));
/// # Ok::<(), umbrage_core::Invalid>(())
/// ```
pub trait ListedTechnique:
    ShadowTechnique + Clone + Default + PartialEq + Serialize + DeserializeOwned + 'static
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
