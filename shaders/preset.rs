//! Techniques as data: any built-in one with its settings, to be kept in a file.

use crate::{
    Midpoint, PcfDisc, PcfDithered, PcfHardware, PcfMerged, Planar, SecondDepth, ShadowVolumes,
    Traced, Unshadowed,
    shadow_map::ShadowMap,
    techniques::{hard::Hard, pcf::Pcf, pcss::Pcss},
};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use umbrage_core::{Invalid, ShadowTechnique};

/// Declares the variants, and what is the same for all of them.
macro_rules! presets {
    ($($(#[$meta:meta])* $variant:ident($technique:ty),)*) => {
        /// A built-in technique and its settings. In a file the field `technique` names it as
        /// [`ShadowTechnique::name`] does, and all other fields are those of its struct; those left out have its defaults.
        ///
        /// ```
        /// use umbrage_techniques::{Pcf, Preset};
        /// let preset = Preset::from_toml("technique = 'pcf'\nradius = 2")?;
        /// assert_eq!(preset, Preset::Pcf(Pcf { radius: 2, ..Pcf::default() }));
        /// # Ok::<(), umbrage_core::Invalid>(())
        /// ```
        #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
        #[serde(tag = "technique", rename_all = "snake_case")]
        pub enum Preset {
            $($(#[$meta])* $variant($technique),)*
        }

        impl Preset {
            /// Every technique with its default settings.
            pub fn defaults() -> Vec<Self> {
                vec![$(Self::$variant(<$technique>::default())),*]
            }

            /// The technique, ready to plan.
            pub fn technique(&self) -> Arc<dyn ShadowTechnique> {
                match *self {
                    $(Self::$variant(technique) => Arc::new(technique),)*
                }
            }
        }

        $(impl From<$technique> for Preset {
            fn from(technique: $technique) -> Self {
                Self::$variant(technique)
            }
        })*
    };
}

presets! {
    /// No shadows.
    None(Unshadowed),
    /// One comparison.
    Hard(Hard),
    /// Comparisons with far sides.
    SecondDepth(SecondDepth),
    /// Comparisons between the nearest two surfaces.
    Midpoint(Midpoint),
    /// Four dithered comparisons.
    PcfDithered(PcfDithered),
    /// Blended comparison samples.
    PcfHardware(PcfHardware),
    /// A smooth filter.
    PcfMerged(PcfMerged),
    /// A square of comparisons.
    Pcf(Pcf),
    /// A disc of comparisons.
    PcfDisc(PcfDisc),
    /// Soft shadows.
    Pcss(Pcss),
    /// Casters flattened onto planes.
    Planar(Planar),
    /// Stencil shadow volumes.
    Volumes(ShadowVolumes),
    /// Any-hit rays.
    Traced(Traced),
}

impl Preset {
    /// Reads a preset from TOML.
    ///
    /// # Errors
    /// When the text is not TOML, names no built-in technique, or has a field that the technique doesn't have.
    pub fn from_toml(text: &str) -> Result<Self, Invalid> {
        toml::from_str(text).map_err(|e| {
            let known: Vec<_> = crate::all().iter().map(|entry| entry.name).collect();
            let mend = format!(
                "write `technique = ..` with one of {}, then its fields",
                known.join(", ")
            );
            Invalid::new("preset", e.to_string().trim_end().to_owned(), mend)
        })
    }

    /// The preset as TOML that [`Preset::from_toml`] reads back bit by bit.
    ///
    /// # Errors
    /// Never with settings that a technique accepts.
    pub fn to_toml(&self) -> Result<String, Invalid> {
        let told = |e: toml::ser::Error| {
            Invalid::new("preset", e.to_string(), "use settings that are numbers")
        };
        toml::to_string(self).map_err(told)
    }

    /// The map that is looked up; none for techniques without one.
    pub fn map(&self) -> Option<&ShadowMap> {
        match self {
            Self::None(_) | Self::Planar(_) | Self::Volumes(_) | Self::Traced(_) => None,
            Self::Hard(Hard { map }) | Self::PcfDithered(PcfDithered { map }) => Some(map),
            Self::SecondDepth(SecondDepth { map, .. }) | Self::Midpoint(Midpoint { map, .. }) => {
                Some(map)
            }
            Self::PcfHardware(PcfHardware { map, .. }) | Self::PcfMerged(PcfMerged { map, .. }) => {
                Some(map)
            }
            Self::Pcf(Pcf { map, .. })
            | Self::PcfDisc(PcfDisc { map, .. })
            | Self::Pcss(Pcss { map, .. }) => Some(map),
        }
    }

    /// The same technique with another map; techniques without one stay as they are.
    #[must_use]
    pub fn with_map(self, map: ShadowMap) -> Self {
        match self {
            Self::None(_) | Self::Planar(_) | Self::Volumes(_) | Self::Traced(_) => self,
            Self::Hard(_) => Self::Hard(Hard { map }),
            Self::SecondDepth(t) => Self::SecondDepth(SecondDepth { map, ..t }),
            Self::Midpoint(t) => Self::Midpoint(Midpoint { map, ..t }),
            Self::PcfDithered(_) => Self::PcfDithered(PcfDithered { map }),
            Self::PcfHardware(t) => Self::PcfHardware(PcfHardware { map, ..t }),
            Self::PcfMerged(t) => Self::PcfMerged(PcfMerged { map, ..t }),
            Self::Pcf(t) => Self::Pcf(Pcf { map, ..t }),
            Self::PcfDisc(t) => Self::PcfDisc(PcfDisc { map, ..t }),
            Self::Pcss(t) => Self::Pcss(Pcss { map, ..t }),
        }
    }
}

#[cfg(test)]
#[path = "preset_tests.rs"]
mod tests;
