//! Second-depth shadow mapping: only faces turned away from the light are drawn into the map. The
//! compared depth is on the far side of each caster, so the lit side needs no bias.
//!
//! Wang and Molnar 1994, "Second-depth shadow mapping" (technical report UNC TR94-019). It is a map
//! with [`Cull::Front`] and no other bias; the lookup is [`Pcf`]'s.
//!
//! Known failures: open casters that face the light vanish. Light leaks in at the base of a caster
//! whose far side touches its receiver. Walls thinner than a texel's depth span leak. The far sides
//! themselves get acne, which is hidden only if shading darkens faces turned away. Meshes with gaps
//! or with inconsistent winding leak there. The failures of every map also apply: see
//! [`shadow_map`](crate::shadow_map).

use crate::{
    shadow_map::{Bias, ShadowMap},
    techniques::{map_technique::MapFilter, pcf::Pcf},
};
use umbrage_core::{Cull, Recipe, RecipeError, View};

/// Comparisons with the far sides of casters.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct SecondDepth {
    /// Radius of the filter: see [`Pcf::radius`]. 0 has a WGSL text of its own.
    pub radius: u32,
}

impl MapFilter for SecondDepth {
    const NAME: &'static str = "second_depth";
    const SUMMARY: &'static str =
        "comparisons with the far sides of closed casters, no bias (Wang, Molnar 1994)";

    fn recipe(&self, map: &ShadowMap, view: &View<'_>) -> Result<Recipe, RecipeError> {
        Pcf::single_or_square(self.radius).recipe(map, view)
    }

    fn label(&self) -> String {
        Pcf::new(self.radius).label()
    }

    fn default_map() -> ShadowMap {
        ShadowMap {
            bias: Bias::FRONT_CULL,
            ..ShadowMap::default()
        }
    }

    /// Always culls front faces.
    fn adapt_map(mut map: ShadowMap) -> ShadowMap {
        map.bias.cull = Cull::Front;
        map
    }
}
