//! The one list of techniques: command line, help, comparison, planner, presets, charts, tables and tests read it.

use crate::listing::{TechniqueEntry, TechniquePreset};
use serde::{Deserialize, Deserializer, de::Error as _};
use std::sync::LazyLock;
use umbrage_core::Invalid;

/// Declares the built-in techniques. Each implements [`ListedTechnique`](crate::ListedTechnique) in its own file.
macro_rules! registry {
    ($($module:ident::$technique:ident,)*) => {
        $(pub use crate::techniques::$module::$technique;)*

        fn built_in() -> Vec<TechniqueEntry> {
            vec![$(TechniqueEntry::of::<$technique>()),*]
        }
    };
}

// Cheapest first: charts, tables and help keep this order.
registry! {
    unshadowed::Unshadowed,
    hard::Hard,
    second_depth::SecondDepth,
    midpoint::Midpoint,
    pcf_dithered::PcfDithered,
    pcf_hardware::PcfHardware,
    pcf_merged::PcfMerged,
    pcf::Pcf,
    pcf_disc::PcfDisc,
    vsm::Vsm,
    evsm::Evsm,
    msm::Msm,
    pcss::Pcss,
    planar::Planar,
    volumes::ShadowVolumes,
    exact::Exact,
    soft::Soft,
    traced::Traced,
}

static BUILT_IN: LazyLock<Vec<TechniqueEntry>> = LazyLock::new(built_in);

/// Returns all built-in techniques, cheapest first.
pub fn all() -> &'static [TechniqueEntry] {
    &BUILT_IN
}

/// The built-in technique with this name.
pub fn find(name: &str) -> Option<&'static TechniqueEntry> {
    all().iter().find(|entry| entry.name == name)
}

/// The techniques that a program knows: the built-in ones, and those that it brings.
#[derive(Clone, Debug)]
pub struct Techniques(Vec<TechniqueEntry>);

impl Default for Techniques {
    fn default() -> Self {
        Self::built_in()
    }
}

/// Lists are equal if they have the same names in the same order.
impl PartialEq for Techniques {
    fn eq(&self, other: &Self) -> bool {
        self.names() == other.names()
    }
}

impl Techniques {
    /// The built-in techniques, cheapest first.
    pub fn built_in() -> Self {
        Self(all().to_vec())
    }

    /// The same list and one technique more.
    ///
    /// # Errors
    /// Errors if a technique of that name is in the list.
    pub fn with(mut self, entry: TechniqueEntry) -> Result<Self, Invalid> {
        if self.find(entry.name).is_some() {
            let why = format!("`{}` is in the list already", entry.name);
            return Err(Invalid::new("technique", why, "give it another name"));
        }
        self.0.push(entry);
        Ok(self)
    }

    /// The same list without the techniques whose names `keep` refuses.
    #[must_use]
    pub fn retain(mut self, keep: impl Fn(&str) -> bool) -> Self {
        self.0.retain(|entry| keep(entry.name));
        self
    }

    /// All of them, in order.
    pub fn all(&self) -> &[TechniqueEntry] {
        &self.0
    }

    /// The technique with this name.
    pub fn find(&self, name: &str) -> Option<&TechniqueEntry> {
        self.0.iter().find(|entry| entry.name == name)
    }

    /// All names, in order.
    pub fn names(&self) -> Vec<&'static str> {
        self.0.iter().map(|entry| entry.name).collect()
    }

    /// The techniques with these names, in the list's order; all of them if no names are given.
    ///
    /// # Errors
    /// Errors if there is no technique with one of the names.
    pub fn select(&self, names: &[String]) -> Result<Vec<&TechniqueEntry>, Invalid> {
        if let Some(unknown) = names.iter().find(|name| self.find(name).is_none()) {
            let why = format!("there is none called `{unknown}`");
            let help = format!("use some of {}", self.names().join(", "));
            return Err(Invalid::new("technique", why, help));
        }
        let wanted =
            |entry: &&TechniqueEntry| names.is_empty() || names.iter().any(|n| n == entry.name);
        Ok(self.0.iter().filter(wanted).collect())
    }

    /// Reads a preset of one of these techniques from TOML.
    ///
    /// # Errors
    /// Errors if the text is not TOML, names none of these techniques, or has a field that the technique doesn't have.
    pub fn preset_from_toml(&self, text: &str) -> Result<TechniquePreset, Invalid> {
        TechniquePreset::read(text, &self.0)
    }
}

impl TechniquePreset {
    /// Every built-in technique with its default settings.
    pub fn defaults() -> Vec<Self> {
        all().iter().map(|entry| (entry.preset)()).collect()
    }

    /// Reads a preset of a built-in technique from TOML. For others: [`Techniques::preset_from_toml`].
    ///
    /// # Errors
    /// Errors if the text is not TOML, names no built-in technique, or has a field that the technique doesn't have.
    pub fn from_toml(text: &str) -> Result<Self, Invalid> {
        Self::read(text, all())
    }
}

/// Presets of built-in techniques.
impl<'de> Deserialize<'de> for TechniquePreset {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let table = toml::Table::deserialize(deserializer)?;
        Self::from_table(table, all()).map_err(D::Error::custom)
    }
}

#[cfg(test)]
#[path = "registry_tests.rs"]
mod tests;
