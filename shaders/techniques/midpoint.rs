//! Midpoint shadow mapping: the map holds the mean of the two nearest surfaces' depths, so that the nearest surface lies
//! before it and all behind the second one lies behind it, without a constant to tune.
//!
//! Woo 1992, "The shadow depth map revisited" (Graphics Gems III). The second surface is found by peeling: of all depths
//! greater than the nearest, the least. On closed casters the margin on both sides is half their thickness. Near
//! silhouettes both surfaces meet and the margin vanishes, while the surface slopes most under its texel: so lookups follow
//! the receiver's plane by default ([`Bias::ADAPTIVE`](crate::Bias::ADAPTIVE), of which it takes that half), which takes the slope out and leaves the margin for the rest.
//! No single constant does as well over casters of different thickness. Known failures: open meshes put the middle between
//! one caster and the next thing behind it, or, where nothing is behind, halfway to the far plane, so receivers close
//! behind a lone sheet are lit; facets near the silhouette keep some acne; thin casters have thin margins; and every map's:
//! see [`shadow_map`](crate::shadow_map).

use crate::{
    listing::ListedTechnique,
    shadow_map::{ShadowMap, Surface},
    techniques::pcf::Pcf,
};
use umbrage_core::{Light, Recipe, RecipeError, ShadowTechnique, View};

/// Comparisons with the middle between the nearest two surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct Midpoint {
    /// The map looked up; [`ShadowMap::surface`] is taken to be [`Surface::Midpoint`].
    pub map: ShadowMap,
    /// As [`Pcf::radius`].
    pub radius: u32,
}

impl Midpoint {
    fn pcf(&self) -> Pcf {
        Pcf {
            map: ShadowMap {
                surface: Surface::Midpoint,
                ..self.map
            },
            radius: self.radius,
        }
    }
}

impl ShadowTechnique for Midpoint {
    fn name(&self) -> &'static str {
        "midpoint"
    }

    fn recipe(&self, view: &View<'_>) -> Result<Recipe, RecipeError> {
        self.pcf().recipe(view)
    }

    fn follows_camera(&self, light: &Light) -> bool {
        self.map.follows_camera(light)
    }
}

impl ListedTechnique for Midpoint {
    const SUMMARY: &'static str =
        "comparisons with the middle of the nearest two surfaces (Woo 1992)";

    fn settings(&self) -> String {
        self.pcf().settings()
    }

    fn map(&self) -> Option<&ShadowMap> {
        Some(&self.map)
    }

    fn with_map(self, map: ShadowMap) -> Self {
        Self { map, ..self }
    }
}
