//! Midpoint shadow mapping: the map holds the mean of the two nearest surfaces' depths. The nearest
//! surface is before it, and everything behind the second one is behind it, without any constant to
//! tune.
//!
//! Woo 1992, "The shadow depth map revisited" (Graphics Gems III). Peeling finds the second
//! surface: the least of all depths greater than the nearest. On closed casters, the margin on both
//! sides is half their thickness. Near silhouettes both surfaces meet and the margin vanishes,
//! while the surface's slope within a texel is greatest. So lookups follow the receiver's plane by
//! default (that half of [`Bias::ADAPTIVE`](crate::Bias::ADAPTIVE)). This removes the slope and
//! leaves the margin for other errors. No single constant does as well over casters of different
//! thickness.
//!
//! Known failures: with open meshes, the midpoint is between one caster and the next surface behind
//! it. If there is none, it is halfway to the far plane, so receivers close behind a single sheet
//! are lit. Facets near the silhouette keep some acne. Thin casters have thin margins. The failures
//! of every map also apply: see [`shadow_map`](crate::shadow_map).

use crate::{
    shadow_map::{ShadowMap, Surface},
    techniques::{map_technique::MapFilter, pcf::Pcf},
};
use umbrage_core::{Recipe, RecipeError, View};

/// Comparisons with the midpoint of the nearest two surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct Midpoint {
    /// Radius of the filter: see [`Pcf::radius`]. 0 has a WGSL text of its own.
    pub radius: u32,
}

impl MapFilter for Midpoint {
    const NAME: &'static str = "midpoint";
    const SUMMARY: &'static str =
        "comparisons with the midpoint of the nearest two surfaces (Woo 1992)";

    fn recipe(&self, map: &ShadowMap, view: &View<'_>) -> Result<Recipe, RecipeError> {
        Pcf::single_or_square(self.radius).recipe(map, view)
    }

    fn label(&self) -> String {
        Pcf::new(self.radius).label()
    }

    fn adapt_map(map: ShadowMap) -> ShadowMap {
        ShadowMap {
            surface: Surface::Midpoint,
            ..map
        }
    }
}
