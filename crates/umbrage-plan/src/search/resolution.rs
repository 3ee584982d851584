//! Map side that matches the screen resolution.

use crate::{estimate::scene::PlanScene, footprint::QUANTILE};
use umbrage_techniques::ShadowMap;

/// Returns the side of a map of default fit whose texels are no larger than a pixel, for 9 of 10
/// receivers that face the light. Returns `None` if the light has no map.
pub(super) fn side(scene: &PlanScene<'_>) -> Option<u32> {
    ShadowMap::default()
        .sized_for(&scene.view(), &scene.receivers, QUANTILE)
        .ok()
        .map(|map| map.size)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalogue::Catalogue;
    use crate::{
        estimate::weighting::Weighting,
        search::families::{FamilyNeeds, SIZES, families_for},
    };
    use glam::UVec2;
    use umbrage_core::{Camera, Geometry, Light};

    fn with_scene<R>(name: &str, size: UVec2, f: impl FnOnce(PlanScene<'_>) -> R) -> R {
        let scene = umbrage_scenes::by_argument(name).unwrap();
        let camera: Camera = scene.cameras[0].with_size(size);
        let (light, geometry): (&Light, Geometry) =
            (&scene.lights[0], Geometry::bake(&scene).unwrap());
        f(PlanScene::new(&camera, light, &geometry, Weighting::Even).unwrap())
    }

    /// Returns the candidates' sides that are not in [`SIZES`].
    fn more(name: &str, size: UVec2) -> Vec<u32> {
        with_scene(name, size, |scene| {
            let families = families_for(
                &Catalogue::built_in(),
                &scene,
                FamilyNeeds {
                    small: true,
                    stable: false,
                },
            );
            let sides = families
                .iter()
                .flat_map(|f| &f.candidates)
                .filter_map(|candidate| Some(candidate.map()?.size));
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

    /// The side grows with the number of pixels, within the coarsest and the finest map.
    #[test]
    fn the_side_that_pixels_need_is_a_candidate() {
        // Another image size could need a side close to an existing one.
        let size = UVec2::new(240, 180);
        let side = with_scene("cubes", size, |scene| side(&scene)).unwrap();
        assert_eq!(more("cubes", size), [side]);
        assert!(side > SIZES[0] && side.is_multiple_of(16), "{side}");
        for size in [UVec2::new(8, 6), UVec2::new(2, 2)] {
            assert_eq!(more("cubes", size), [0; 0], "nothing below {}", SIZES[0]);
        }
        assert_eq!(more("only-sky", size), [0; 0]);
    }
}
