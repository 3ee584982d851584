//! Midpoint shadow mapping: the map holds the mean of the two nearest surfaces' depths, so that the
//! nearest surface lies before it and all behind the second one lies behind it, without a constant
//! to tune.
//!
//! Woo 1992, "The shadow depth map revisited" (Graphics Gems III). The second surface is found by
//! peeling: of all depths greater than the nearest, the least. On closed casters the margin on both
//! sides is half their thickness. Near silhouettes both surfaces meet and the margin vanishes,
//! while the surface slopes most under its texel: so lookups follow the receiver's plane by default
//! ([`Bias::ADAPTIVE`](crate::Bias::ADAPTIVE), of which it takes that half), which takes the slope
//! out and leaves the margin for the rest. No single constant does as well over casters of
//! different thickness. Known failures: open meshes put the middle between one caster and the next
//! thing behind it, or, where nothing is behind, halfway to the far plane, so receivers close
//! behind a lone sheet are lit; facets near the silhouette keep some acne; thin casters have thin
//! margins; and every map's: see [`shadow_map`](crate::shadow_map).

use crate::{
    shadow_map::{ShadowMap, Surface},
    techniques::{map_technique::MapFilter, pcf::Pcf},
};
use umbrage_core::{Recipe, RecipeError, View};

/// Comparisons with the middle between the nearest two surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct Midpoint {
    /// As [`Pcf::radius`].
    pub radius: u32,
}

impl MapFilter for Midpoint {
    const NAME: &'static str = "midpoint";
    const SUMMARY: &'static str =
        "comparisons with the middle of the nearest two surfaces (Woo 1992)";

    fn recipe(&self, map: &ShadowMap, view: &View<'_>) -> Result<Recipe, RecipeError> {
        self.pcf().recipe(map, view)
    }

    fn label(&self) -> String {
        self.pcf().label()
    }

    fn adapted(map: ShadowMap) -> ShadowMap {
        ShadowMap {
            surface: Surface::Midpoint,
            ..map
        }
    }
}

impl Midpoint {
    fn pcf(&self) -> Pcf {
        Pcf {
            radius: self.radius,
        }
    }
}
