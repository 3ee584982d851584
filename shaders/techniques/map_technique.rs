//! Techniques that look up a shadow map: the map and the filter.

use crate::{
    listing::{DeserializeOwned, ListedTechnique, Serialize},
    shadow_map::ShadowMap,
};
use std::fmt::Debug;
use umbrage_core::{Light, Recipe, RecipeError, ShadowTechnique, View};

/// Filter for shadow map lookups. Its parameters are its public fields.
///
/// [`MapTechnique`] makes it a technique with a name, a list entry, and settings as data. As for
/// [`ListedTechnique`], derive `serde`'s traits with `#[serde(default, deny_unknown_fields)]`. No
/// field may be called `map`.
pub trait MapFilter:
    Clone + Debug + Default + PartialEq + Send + Sync + Serialize + DeserializeOwned + 'static
{
    /// Name of the technique, in lower case: `pcf`.
    const NAME: &'static str;

    /// One-line summary of the technique, with the paper that describes it.
    const SUMMARY: &'static str;

    /// Returns the recipe of a technique that looks up `map` through this filter.
    ///
    /// # Errors
    /// See [`ShadowTechnique::recipe`].
    fn recipe(&self, map: &ShadowMap, view: &View<'_>) -> Result<Recipe, RecipeError>;

    /// Returns the settings in a few words: `3x3`. Empty if there are none.
    fn label(&self) -> String {
        String::new()
    }

    /// Returns the technique's default map.
    fn default_map() -> ShadowMap {
        ShadowMap::default()
    }

    /// Returns the map for a technique with the map `map`. Filters override this if they require
    /// some of its settings.
    fn adapt_map(map: ShadowMap) -> ShadowMap {
        map
    }

    /// Returns whether recipes depend on the camera even if the map doesn't.
    fn follows_camera(&self) -> bool {
        false
    }

    /// Returns the technique that looks up `map` through this filter.
    ///
    /// ```
    /// use umbrage_techniques::{MapFilter as _, MapTechnique, Pcf, ShadowMap};
    /// let technique = Pcf::new(2).on(ShadowMap::default());
    /// assert_eq!(technique.filter.radius, 2);
    /// ```
    fn on(self, map: ShadowMap) -> MapTechnique<Self> {
        MapTechnique { map, filter: self }
    }
}

/// A technique that looks up a shadow map. In files, the filter's fields are next to the table
/// `map`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "presets", derive(serde::Serialize))]
pub struct MapTechnique<F> {
    /// The map.
    pub map: ShadowMap,
    /// Filter of the lookup.
    #[cfg_attr(feature = "presets", serde(flatten))]
    pub filter: F,
}

impl<F: MapFilter> Default for MapTechnique<F> {
    fn default() -> Self {
        F::default().on(F::default_map())
    }
}

#[cfg(feature = "presets")]
impl<'de, F: MapFilter> serde::Deserialize<'de> for MapTechnique<F> {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        use serde::de::Error as _;
        // Not derived: with `flatten`, unknown fields would be ignored.
        let mut table = <toml::Table as serde::Deserialize>::deserialize(deserializer)?;
        let map = table.remove("map").map_or_else(
            || Ok(F::default_map()),
            |map| map.try_into().map_err(D::Error::custom),
        )?;
        let filter: F = table.try_into().map_err(D::Error::custom)?;
        Ok(filter.on(map))
    }
}

impl<F: MapFilter> ShadowTechnique for MapTechnique<F> {
    fn name(&self) -> &'static str {
        F::NAME
    }

    fn recipe(&self, view: &View<'_>) -> Result<Recipe, RecipeError> {
        self.filter.recipe(&F::adapt_map(self.map), view)
    }

    fn follows_camera(&self, light: &Light) -> bool {
        self.filter.follows_camera() || self.map.follows_camera(light)
    }
}

impl<F: MapFilter> ListedTechnique for MapTechnique<F> {
    const SUMMARY: &'static str = F::SUMMARY;

    fn settings(&self) -> String {
        let mut words = vec![self.filter.label(), F::adapt_map(self.map).label()];
        words.retain(|word| !word.is_empty());
        words.join(", ")
    }

    fn map(&self) -> Option<&ShadowMap> {
        Some(&self.map)
    }

    fn with_map(self, map: ShadowMap) -> Self {
        self.filter.on(map)
    }
}
