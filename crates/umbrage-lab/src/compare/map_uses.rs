//! Use of the recipes' maps on a scene, and the locations of their lookups.

use super::seen::SceneView;
use glam::UVec2;
use std::sync::Arc;
use umbrage_core::{Cast, CastMode, LightSpace, Receivers, Recipe};
use umbrage_plan::{
    catalogue::{Catalogue, CataloguedKernel},
    footprint::{self, Heat, MapUse},
};
use umbrage_techniques::TechniquePreset;

/// Side of the lookup heat maps, pixels. Enough detail in files smaller than the masks'.
const HEAT_SIDE: u32 = 256;

/// The measured map uses of a scene.
pub(super) struct MapUses {
    /// Whether to keep the locations of lookups.
    keeps_heat: bool,
    known: Vec<KnownUse>,
}

/// A measured footprint. Most settings differ only in their bias and use their maps in the same
/// way, so that one measurement serves all.
struct KnownUse {
    maps: Vec<CastMap>,
    /// Reach of the kernel, texels.
    reach: f32,
    map_use: MapUse,
    heat: Option<Arc<Heat>>,
}

/// The map that a cast draws.
#[derive(PartialEq)]
struct CastMap {
    space: LightSpace,
    /// Size of the image, texels.
    size: UVec2,
    layers: u32,
}

impl MapUses {
    pub(super) fn new(keeps_heat: bool) -> Self {
        Self {
            keeps_heat,
            known: Vec::new(),
        }
    }

    /// Returns the use of a recipe's maps and, with `heat`, the locations of lookups. `None`
    /// without maps.
    pub(super) fn measure(
        &mut self,
        view: &SceneView<'_>,
        receivers: &Receivers,
        catalogue: &Catalogue,
        technique: &TechniquePreset,
        recipe: &Recipe,
    ) -> Option<(MapUse, Option<Arc<Heat>>)> {
        let reach = catalogue.kernel_reach(technique)?;
        let kernel = catalogue.kernel(recipe);
        let maps: Vec<CastMap> = recipe
            .casts
            .iter()
            .filter(|cast| cast.mode == CastMode::Depth)
            .map(|cast| cast_map(cast, recipe))
            .collect();
        // If the reach differs between receivers, `reach` doesn't identify the kernel.
        let varies = reach_varies(kernel, receivers);
        if !varies {
            let known = self
                .known
                .iter()
                .find(|known| known.maps == maps && known.reach == reach);
            if let Some(known) = known {
                return Some((known.map_use, known.heat.clone()));
            }
        }
        let view = view.core().with_receivers(receivers);
        let footprint = footprint::measure(&view, recipe, receivers, reach, kernel);
        let heat = if self.keeps_heat {
            footprint.heat(HEAT_SIDE).map(Arc::new)
        } else {
            None
        };
        if !varies {
            self.known.push(KnownUse {
                maps,
                reach,
                map_use: footprint.total,
                heat: heat.clone(),
            });
        }
        Some((footprint.total, heat))
    }
}

fn cast_map(cast: &Cast, recipe: &Recipe) -> CastMap {
    let image = &recipe.images[cast.image];
    CastMap {
        space: cast.space,
        size: image.size,
        layers: image.layers,
    }
}

/// Reports whether the kernel's reach differs between receivers ([`CataloguedKernel::reach`]). Only
/// the first receiver is tested.
fn reach_varies(kernel: &dyn CataloguedKernel, receivers: &Receivers) -> bool {
    let Some(first) = receivers.receives.iter().position(|receives| *receives) else {
        return false;
    };
    kernel
        .reach(receivers.position(first), receivers.normal(first))
        .is_some()
}
