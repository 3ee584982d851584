//! Second-depth shadow mapping: only faces turned away from the light are drawn into the map, so the depth compared with
//! lies on the far side of each caster and the lit side needs no bias.
//!
//! Wang and Molnar 1994, "Second-depth shadow mapping" (technical report UNC TR94-019). It is a map with
//! [`Cull::Front`] and no other bias; the lookup is [`Pcf`]'s. Known failures: open casters turned to the light
//! vanish; light leaks in at the base of a caster that stands on its receiver, whose far side touches it; walls thinner
//! than a texel's depth span leak; the far sides themselves get acne, which hides in their own shadow only as long as
//! shading darkens faces turned away. Meshes with holes, or with a side that winds the wrong way, leak there. And every
//! map's: see [`shadow_map`](crate::shadow_map).

use crate::{
    listing::ListedTechnique,
    shadow_map::{Bias, ShadowMap},
    techniques::pcf::Pcf,
};
use umbrage_core::{Cull, Light, Recipe, RecipeError, ShadowTechnique, View};

/// Comparisons with the far sides of casters.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct SecondDepth {
    /// The map looked up; its bias culls front faces, whatever else it says.
    pub map: ShadowMap,
    /// As [`Pcf::radius`].
    pub radius: u32,
}

impl Default for SecondDepth {
    fn default() -> Self {
        Self {
            map: ShadowMap {
                bias: Bias::FRONT_CULL,
                ..ShadowMap::default()
            },
            radius: 0,
        }
    }
}

impl SecondDepth {
    /// What is played.
    fn pcf(&self) -> Pcf {
        let map = ShadowMap {
            bias: Bias {
                cull: Cull::Front,
                ..self.map.bias
            },
            ..self.map
        };
        Pcf {
            map,
            radius: self.radius,
        }
    }
}

impl ShadowTechnique for SecondDepth {
    fn name(&self) -> &'static str {
        "second_depth"
    }

    fn recipe(&self, view: &View<'_>) -> Result<Recipe, RecipeError> {
        self.pcf().recipe(view)
    }

    fn follows_camera(&self, light: &Light) -> bool {
        self.map.follows_camera(light)
    }
}

impl ListedTechnique for SecondDepth {
    const SUMMARY: &'static str =
        "comparisons with the far sides of closed casters, no bias (Wang, Molnar 1994)";

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
