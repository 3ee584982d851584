//! Techniques as data: any listed technique with its settings, for storage in files.

use super::ListedTechnique;
#[cfg(feature = "presets")]
use super::{TechniqueEntry, light_preset};
use crate::shadow_map::ShadowMap;
use std::{any::Any, sync::Arc};
#[cfg(feature = "presets")]
use umbrage_core::Invalid;
use umbrage_core::{CutOuts, Light, Recipe, RecipeError, ShadowTechnique, View};

/// A technique and its settings. In a file, the field `technique` holds the name that
/// [`ShadowTechnique::name`] returns. All other fields are those of its struct; missing ones have
/// their defaults.
///
/// ```
/// use umbrage_techniques::{MapFilter as _, Pcf, ShadowMap, TechniquePreset};
/// let preset = TechniquePreset::from_toml("technique = 'pcf'\nradius = 2")?;
/// assert_eq!(preset, TechniquePreset::from(Pcf::new(2).on(ShadowMap::default())));
/// # Ok::<(), umbrage_core::Invalid>(())
/// ```
#[derive(Clone, Debug)]
pub struct TechniquePreset(Arc<dyn AnyTechnique>);

/// A [`ListedTechnique`] with its type erased.
trait AnyTechnique: ShadowTechnique + Any {
    fn words(&self) -> String;
    fn equals(&self, other: &TechniquePreset) -> bool;
    fn shadow_map(&self) -> Option<&ShadowMap>;
    fn on_map(&self, map: ShadowMap) -> TechniquePreset;
    #[cfg(feature = "presets")]
    fn as_data(&self) -> &dyn erased_serde::Serialize;
}

impl<T: ListedTechnique> AnyTechnique for T {
    fn words(&self) -> String {
        self.settings()
    }

    fn equals(&self, other: &TechniquePreset) -> bool {
        other.get::<T>() == Some(self)
    }

    fn shadow_map(&self) -> Option<&ShadowMap> {
        self.map()
    }

    fn on_map(&self, map: ShadowMap) -> TechniquePreset {
        TechniquePreset::from(self.clone().with_map(map))
    }

    #[cfg(feature = "presets")]
    fn as_data(&self) -> &dyn erased_serde::Serialize {
        self
    }
}

impl<T: ListedTechnique> From<T> for TechniquePreset {
    fn from(technique: T) -> Self {
        Self(Arc::new(technique))
    }
}

impl PartialEq for TechniquePreset {
    fn eq(&self, other: &Self) -> bool {
        self.0.equals(other)
    }
}

/// Delegates to the technique.
impl ShadowTechnique for TechniquePreset {
    fn name(&self) -> &'static str {
        self.0.name()
    }

    fn recipe(&self, view: &View<'_>) -> Result<Recipe, RecipeError> {
        self.0.recipe(view)
    }

    fn device_recipe(
        &self,
        view: &View<'_>,
        cut_outs: Option<&CutOuts>,
    ) -> Option<Result<Recipe, RecipeError>> {
        self.0.device_recipe(view, cut_outs)
    }

    fn follows_camera(&self, light: &Light) -> bool {
        self.0.follows_camera(light)
    }
}

#[cfg(feature = "presets")]
impl serde::Serialize for TechniquePreset {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(serde::Serialize)]
        struct Tagged<'a> {
            technique: &'static str,
            #[serde(flatten)]
            settings: &'a dyn erased_serde::Serialize,
        }
        let tagged = Tagged {
            technique: self.0.name(),
            settings: self.0.as_data(),
        };
        serde::Serialize::serialize(&tagged, serializer)
    }
}

impl TechniquePreset {
    /// Returns the technique.
    pub fn technique(&self) -> Arc<dyn ShadowTechnique> {
        self.0.clone()
    }

    /// Returns the settings in a few words, without the name.
    pub fn settings(&self) -> String {
        self.0.words()
    }

    /// Returns the settings if the technique is a `T`.
    pub fn get<T: ListedTechnique>(&self) -> Option<&T> {
        let technique: &dyn Any = &*self.0;
        technique.downcast_ref()
    }

    /// Returns the shadow map; `None` for techniques without one.
    pub fn map(&self) -> Option<&ShadowMap> {
        self.0.shadow_map()
    }

    /// Returns the same technique with another map. Techniques without a map stay unchanged.
    #[must_use]
    pub fn with_map(&self, map: ShadowMap) -> Self {
        self.0.on_map(map)
    }
}

/// Reading and writing files.
#[cfg(feature = "presets")]
impl TechniquePreset {
    /// Returns the preset as TOML, which [`TechniquePreset::from_toml`] reads back without any
    /// loss.
    ///
    /// # Errors
    /// Errors if the technique's settings are not a TOML table. Those of the built-in techniques
    /// always are.
    pub fn to_toml(&self) -> Result<String, Invalid> {
        toml::to_string(self)
            .map_err(|e| Invalid::new("preset", e.to_string(), "use settings that are numbers"))
    }

    /// Reads a preset of one of `techniques` from TOML.
    ///
    /// # Errors
    /// Errors if the text is not TOML, names none of these techniques, or has a field that is
    /// unknown to the technique.
    pub fn read(text: &str, techniques: &[TechniqueEntry]) -> Result<Self, Invalid> {
        let table: toml::Table =
            toml::from_str(text).map_err(|e| unreadable_preset(&e.to_string(), techniques))?;
        Self::from_table(table, techniques)
    }

    /// Finds the technique that a table names, and reads its settings from the remaining fields.
    pub(crate) fn from_table(
        mut table: toml::Table,
        techniques: &[TechniqueEntry],
    ) -> Result<Self, Invalid> {
        // `LightPreset` reads the frame rules itself.
        table.remove(light_preset::FRAME);
        let Some(name) = table.remove("technique") else {
            return Err(unreadable_preset("has no field `technique`", techniques));
        };
        let entry = techniques
            .iter()
            .find(|entry| name.as_str() == Some(entry.name));
        let Some(entry) = entry else {
            let why = format!("names an unknown technique: {name}");
            return Err(unreadable_preset(&why, techniques));
        };
        (entry.read)(table).map_err(|e| {
            let why = format!("`{}`: {e}", entry.name);
            unreadable_preset(&why, techniques)
        })
    }
}

/// Returns the error for text that is not a preset, with the reason and the expected form.
#[cfg(feature = "presets")]
fn unreadable_preset(why: &str, techniques: &[TechniqueEntry]) -> Invalid {
    let known: Vec<&str> = techniques.iter().map(|entry| entry.name).collect();
    let help = format!(
        "write `technique = ..` with one of {}, then its fields",
        known.join(", ")
    );
    Invalid::new("preset", why.trim_end().to_owned(), help)
}
