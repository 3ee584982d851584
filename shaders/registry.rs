//! Registry of the built-in techniques. The command line, help, comparison, planner, presets,
//! charts, tables and tests read it.

use crate::listing::{TechniqueEntry, TechniquePreset};
use std::sync::LazyLock;
#[cfg(feature = "presets")]
use umbrage_core::Invalid;

/// Expands to the type of a registered technique: `Exact`, or `MapTechnique<Hard>` for
/// `Hard in MapTechnique`.
#[doc(hidden)]
#[macro_export]
macro_rules! technique_type {
    ($technique:ident) => { $crate::$technique };
    ($filter:ident in $wrapper:ident) => { $crate::$wrapper<$crate::$filter> };
}

/// Declares the built-in techniques. Each implements [`ListedTechnique`](crate::ListedTechnique) in
/// its own file. Those marked `in MapTechnique` implement [`MapFilter`](crate::MapFilter) instead.
macro_rules! registry {
    ($($(#[$condition:meta])* $module:ident::$technique:ident $(in $wrapper:ident)?,)*) => {
        $($(#[$condition])* pub use crate::techniques::$module::$technique;)*

        #[expect(clippy::vec_init_then_push, reason = "elements of `vec!` take no conditions")]
        fn built_in() -> Vec<TechniqueEntry> {
            let mut out = Vec::new();
            $($(#[$condition])* out.push(TechniqueEntry::for_technique::<technique_type!($technique $(in $wrapper)?)>());)*
            out
        }

        /// Calls a macro with the types of all built-in techniques, cheapest first, each followed
        /// by a comma.
        #[cfg(feature = "rays")]
        #[macro_export]
        macro_rules! for_each_technique {
            ($callback:ident) => {
                $callback! { $($crate::technique_type!($technique $(in $wrapper)?),)* }
            };
        }
    };
}

// Cheapest first: charts, tables and help use this order.
registry! {
    unshadowed::Unshadowed,
    hard::Hard in MapTechnique,
    second_depth::SecondDepth in MapTechnique,
    midpoint::Midpoint in MapTechnique,
    pcf_dithered::PcfDithered in MapTechnique,
    pcf_hardware::PcfHardware in MapTechnique,
    pcf_merged::PcfMerged in MapTechnique,
    pcf::Pcf in MapTechnique,
    pcf_disc::PcfDisc in MapTechnique,
    vsm::Vsm in MapTechnique,
    evsm::Evsm in MapTechnique,
    msm::Msm in MapTechnique,
    pcss::Pcss in MapTechnique,
    planar::Planar,
    volumes::ShadowVolumes,
    exact::Exact,
    #[cfg(feature = "rays")] soft::Soft,
    #[cfg(feature = "rays")] traced::Traced,
}

static BUILT_IN: LazyLock<Vec<TechniqueEntry>> = LazyLock::new(built_in);

/// Returns all built-in techniques, cheapest first.
pub fn all() -> &'static [TechniqueEntry] {
    &BUILT_IN
}

/// Returns the built-in technique with this name.
pub fn find(name: &str) -> Option<&'static TechniqueEntry> {
    all().iter().find(|entry| entry.name == name)
}

impl TechniquePreset {
    /// Returns every built-in technique with its default settings.
    pub fn defaults() -> Vec<Self> {
        all().iter().map(|entry| (entry.preset)()).collect()
    }
}

#[cfg(feature = "presets")]
impl TechniquePreset {
    /// Reads a preset of a built-in technique from TOML. Use [`TechniquePreset::read`] for others.
    ///
    /// # Errors
    /// Errors if the text is not TOML, names no built-in technique, or has a field that is unknown
    /// to the technique.
    pub fn from_toml(text: &str) -> Result<Self, Invalid> {
        Self::read(text, all())
    }
}

/// Presets of built-in techniques.
#[cfg(feature = "presets")]
impl<'de> serde::Deserialize<'de> for TechniquePreset {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let table = <toml::Table as serde::Deserialize>::deserialize(deserializer)?;
        Self::from_table(table, all()).map_err(serde::de::Error::custom)
    }
}

#[cfg(test)]
#[path = "registry_tests.rs"]
mod tests;
