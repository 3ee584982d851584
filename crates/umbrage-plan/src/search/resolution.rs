//! Maps as fine as the screen: the side that pixels ask for, and what a chosen map makes of its texels.

use super::Setting;
use crate::{
    MeasureError,
    estimate::scene::Look,
    footprint::{self, QUANTILE},
};
use umbrage_techniques::ShadowMap;

/// The side of a map of default fit on which, for nine in ten of the receivers that face the light, no texel is larger
/// than a pixel; none where the light has no map.
pub(super) fn side(look: &Look<'_>) -> Option<u32> {
    ShadowMap::default()
        .sized_for(&look.view(), &look.receivers, QUANTILE)
        .ok()
        .map(|map| map.size)
}

/// How well a chosen map is used; none without one.
pub(super) fn reason(look: &Look<'_>, chosen: &Setting) -> Result<Option<String>, MeasureError> {
    let recipe = look.recipe(&chosen.preset)?;
    let found = footprint::of(
        &*chosen.preset.technique(),
        &look.view(),
        &recipe,
        &look.receivers,
    );
    Ok(found.map(|footprint| footprint.total.words()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::search::families::{SIZES, families_for};
    use glam::UVec2;
    use umbrage_core::{Camera, Geometry, Light};

    fn with_look<R>(name: &str, size: UVec2, f: impl FnOnce(Look<'_>) -> R) -> R {
        let scene = umbrage_scenes::by_argument(name).unwrap();
        let camera: Camera = scene.cameras[0].resized(size);
        let (light, geometry): (&Light, Geometry) =
            (&scene.lights[0], Geometry::bake(&scene).unwrap());
        f(Look::new(&camera, light, &geometry).unwrap())
    }

    /// Sides of the candidates that the sizes of all views lack.
    fn more(name: &str, size: UVec2) -> Vec<u32> {
        with_look(name, size, |look| {
            let families = families_for(&look, true);
            let sides = families
                .iter()
                .flat_map(|f| &f.rungs)
                .filter_map(|rung| Some(rung.map()?.size));
            let mut sides: Vec<u32> = sides.filter(|side| !SIZES.contains(side)).collect();
            let mapped = families
                .iter()
                .filter(|f| f.preset().map().is_some())
                .count();
            assert!(
                sides.is_empty() || sides.len() == mapped,
                "each family has it"
            );
            sides.dedup();
            sides
        })
    }

    /// The more pixels, the finer the map; never coarser than the coarsest nor finer than the finest.
    #[test]
    fn the_side_that_pixels_ask_for_is_a_candidate() {
        // Another size could ask for a side close to one that is there.
        let size = UVec2::new(240, 180);
        let side = with_look("cubes", size, |look| side(&look)).unwrap();
        assert_eq!(more("cubes", size), [side]);
        assert!(side > SIZES[0] && side.is_multiple_of(16), "{side}");
        for size in [UVec2::new(8, 6), UVec2::new(2, 2)] {
            assert_eq!(more("cubes", size), [0; 0], "nothing below {}", SIZES[0]);
        }
        assert_eq!(more("only-sky", size), [0; 0]);
    }
}
