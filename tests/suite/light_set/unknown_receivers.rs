//! Tests that shadows fall on receivers that a set doesn't know: surfaces that aren't casters.

use super::floor::{Block, SIZE, add_block, camera, expected, wrong_points};
use glam::Vec3;
use std::sync::Arc;
use umbrage_core::{Cascades, Layout, Light, ShadowTechnique};
use umbrage_techniques::{BeyondFar, Hard, MapFilter as _, Pcf, ShadowMap};
use umbrage_tests::{
    adapter::device,
    light_program::{Forward, ForwardProgram},
};
use umbrage_wgpu::{SetBudget, SetFrame, ShadowedLight, StillLayers};

/// Half the size of the floating box, whose centre is at this height.
const HALF: Vec3 = Vec3::new(2.0, 0.5, 1.5);
const HEIGHT: f32 = 5.5;
/// The floor as a caster.
const FLOOR: Block = Block {
    center: Vec3::new(0.0, -0.05, 0.0),
    half: Vec3::new(14.0, 0.05, 10.0),
};

/// Returns the masks of a light's techniques over the floor. The box is a caster, and so is the
/// floor if `has_floor`.
fn masks(
    light: Light,
    block: &Block,
    has_floor: bool,
    techniques: &[Arc<dyn ShadowTechnique>],
) -> Vec<Vec<f32>> {
    let program = ForwardProgram::floor(device(), SIZE);
    let mut set = program.set(SetBudget::default(), StillLayers::Auto);
    add_block(&mut set, block);
    if has_floor {
        add_block(&mut set, &FLOOR);
    }
    let add = |technique: &Arc<dyn ShadowTechnique>| {
        set.add_light(ShadowedLight {
            light,
            technique: technique.clone(),
            priority: 1.0,
        })
        .expect("valid")
    };
    let ids: Vec<_> = techniques.iter().map(add).collect();
    let frame = SetFrame {
        camera: &camera(),
        geometry: None,
    };
    program.update(&mut set, &frame);
    assert_eq!(set.unserved_lights().count(), 0);
    let mut forward = Forward::default();
    ids.iter()
        .map(|&id| forward.mask(&program, &set, set.index_of(id).expect("is there")))
        .collect()
}

/// Returns suns and a lamp, each with the box whose shadow is in the middle of the floor.
fn lights() -> Vec<(Light, Vec3)> {
    let suns = [
        Vec3::new(0.3, -1.0, 0.2),
        Vec3::new(1.0, -0.4, -0.1),
        Vec3::new(-0.2, -0.5, -1.0),
    ];
    let mut lights: Vec<(Light, Vec3)> = suns
        .iter()
        .map(|&direction| {
            let sun = Light::Directional {
                direction: direction.normalize(),
                angular_diameter: 0.0,
            };
            (sun, direction * (HEIGHT / direction.y))
        })
        .collect();
    // The map ends at twice the distance of the box, above the floor.
    let lamp = Light::Spot {
        position: Vec3::Y * (HEIGHT + 1.5),
        direction: Vec3::NEG_Y,
        inner: 1.0,
        outer: 1.1,
        radius: 0.0,
    };
    lights.push((lamp, Vec3::Y * HEIGHT));
    lights
}

/// Returns a map for each layout that a light can have.
fn maps(light: &Light) -> Vec<ShadowMap> {
    let one = ShadowMap {
        size: 256,
        ..ShadowMap::default()
    };
    if light.position().is_some() {
        let cube = ShadowMap {
            layout: Layout::Cube,
            ..one
        };
        return vec![one, cube];
    }
    let cascades = |blend| ShadowMap {
        layout: Layout::Cascades(Cascades {
            count: 3,
            blend,
            ..Cascades::default()
        }),
        ..one
    };
    vec![one, cascades(0.0), cascades(4.0)]
}

#[test]
fn a_floor_that_casts_nothing_has_the_shadows_of_one_that_does() {
    for (light, center) in lights() {
        let block = Block { center, half: HALF };
        let mut techniques: Vec<Arc<dyn ShadowTechnique>> = Vec::new();
        for map in maps(&light) {
            techniques.push(Arc::new(Hard {}.on(map)));
            techniques.push(Arc::new(Pcf::new(1).on(map)));
        }
        let expected = expected(&light, &block, 2);
        for has_floor in [false, true] {
            let masks = masks(light, &block, has_floor, &techniques);
            for (i, mask) in masks.iter().enumerate() {
                let wrong = wrong_points(mask, &expected, 0.0);
                assert_eq!(wrong, 0, "technique {i} under {light:?}, {has_floor}");
            }
        }
        // Negative control: the shadow is beyond the map's far plane.
        let lit = ShadowMap {
            beyond_far: BeyondFar::Lit,
            ..maps(&light)[0]
        };
        let lit: [Arc<dyn ShadowTechnique>; 1] = [Arc::new(Hard {}.on(lit))];
        let masks = masks(light, &block, false, &lit);
        assert!(wrong_points(&masks[0], &expected, 0.0) > 20, "{light:?}");
    }
}

/// All techniques with maps. Their filters are wider, and some are bounds.
#[test]
fn all_map_techniques_shadow_a_floor_that_casts_nothing() {
    for (light, center) in lights() {
        let block = Block { center, half: HALF };
        let expected = expected(&light, &block, 4);
        for map in maps(&light) {
            let mut techniques: Vec<Arc<dyn ShadowTechnique>> = Vec::new();
            for entry in umbrage_techniques::all() {
                let preset = (entry.preset)();
                if preset.map().is_some() {
                    techniques.push(preset.with_map(map).technique());
                }
            }
            assert!(techniques.len() > 8);
            let masks = masks(light, &block, false, &techniques);
            for (technique, mask) in techniques.iter().zip(&masks) {
                let wrong = wrong_points(mask, &expected, 0.05);
                let name = technique.name();
                assert_eq!(wrong, 0, "{name} with {}, {light:?}", map.label());
            }
        }
    }
}
