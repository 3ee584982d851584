//! Tests of map layers. A map of several equal layers has the bits of a single map, regardless of a
//! receiver's layer. A layer draws at least the casters that are visible in it.

use glam::{UVec2, Vec2};
use umbrage_core::{
    Backend, Camera, CasterSet, Geometry, Layout, LightSpaces, Recipe, Scene, ShadowTechnique,
    Source, View,
};
use umbrage_cpu::Cpu;
use umbrage_scenes::find;
use umbrage_techniques::{
    Bias, Border, Hard, HardKernel, HardwareKernel, HardwareUniforms, MapFilter as _, MapFormat,
    PcfDitheredKernel, PcfKernel, PcfUniforms, ShadowMap, shadow_map::layers::MapOnlyUniforms,
};
use umbrage_tests::gpu::gpu;

const CUBE_FACES: usize = 6;
/// Radius that covers every kernel here, texels.
const REACH: f32 = 2.0;

/// Constructor of a recipe with map layers in these spaces.
type MakeRecipe = fn(&ShadowMap, &LightSpaces, &View<'_>) -> Recipe;

const RECIPES: [(&str, MakeRecipe); 4] = [
    ("hard", |map, spaces, view| {
        map.recipe_in(spaces, view, REACH, |lookup| {
            HardKernel(MapOnlyUniforms { lookup })
        })
    }),
    ("pcf_dithered", |map, spaces, view| {
        map.recipe_in(spaces, view, REACH, |lookup| {
            PcfDitheredKernel(MapOnlyUniforms { lookup })
        })
    }),
    ("pcf", |map, spaces, view| {
        map.recipe_in(spaces, view, REACH, |lookup| PcfKernel {
            uniforms: PcfUniforms { lookup, radius: 1 },
            unrolled: false,
        })
    }),
    ("pcf_hardware", |map, spaces, view| {
        map.recipe_in(spaces, view, REACH, |lookup| {
            HardwareKernel(HardwareUniforms { lookup, samples: 2 })
        })
    }),
];

fn maps() -> Vec<ShadowMap> {
    let map = ShadowMap {
        size: 256,
        layout: Layout::Single,
        ..ShadowMap::default()
    };
    let of_bias = |bias| ShadowMap { bias, ..map };
    vec![
        map,
        of_bias(Bias::SLOPE),
        of_bias(Bias::RECEIVER_PLANE),
        of_bias(Bias::NORMAL_OFFSET),
        ShadowMap {
            border: Border::Clamp,
            ..of_bias(Bias::CONSTANT)
        },
        ShadowMap {
            format: MapFormat::Rgba8,
            ..map
        },
    ]
}

/// A point light next to a teapot, with receivers on several faces of its cube.
fn scene() -> (Scene, Geometry, Camera) {
    let mut scene = (find("teapot-lamp").expect("a built-in scene").build)();
    let geometry = Geometry::bake(&scene).expect("built-in scenes are valid");
    let camera = scene.cameras.remove(0).with_size(UVec2::new(160, 120));
    (scene, geometry, camera)
}

/// Reports whether a technique supports a map. Samplers can't compare packed maps.
fn serves(name: &str, map: &ShadowMap) -> bool {
    name != "pcf_hardware" || map.format != MapFormat::Rgba8
}

#[test]
fn several_equal_layers_give_the_bits_of_a_single_map() {
    let (scene, geometry, camera) = scene();
    let view = View::new(&camera, &scene.lights[0], &geometry);
    let mut compared = 0;
    for map in maps() {
        let single = map.spaces(&view, REACH).expect("one map holds all casters");
        let space = single.spaces[0];
        let several = LightSpaces::with_all_casters(vec![space; CUBE_FACES]);
        // Negative control: a displaced layer must be detected. It moves by part of a texel, since
        // map and lookup move together.
        let mut spoilt = several.clone();
        for space in &mut spoilt.spaces[1..] {
            *space = space.nudge_by(Vec2::splat(0.4), 0.0, UVec2::splat(map.size));
        }
        for (name, recipe) in RECIPES {
            if !serves(name, &map) {
                continue;
            }
            let [single, several, spoilt] = [&single, &several, &spoilt]
                .map(|spaces| masks(&view, &recipe(&map, spaces, &view)));
            let label = format!("{name}, {}", map.label());
            assert_eq!(single[0], several[0], "{label} on the CPU");
            assert_eq!(single[1], several[1], "{label} on wgpu");
            assert_ne!(
                single[0], spoilt[0],
                "{label}: a displaced layer on the CPU"
            );
            assert_ne!(single[1], spoilt[1], "{label}: a displaced layer on wgpu");
            compared += 1;
        }
    }
    assert_eq!(compared, 23);
}

/// Returns the bits of each backend's mask.
fn masks(view: &View<'_>, recipe: &Recipe) -> [Vec<u32>; 2] {
    let cpu = Cpu::new().render(view, recipe).expect("renders");
    let gpu = gpu().render(view, recipe).expect("renders");
    [cpu.mask, gpu.mask].map(|mask| mask.into_iter().map(f32::to_bits).collect())
}

/// Culling of casters in layers changes no bit, for every built-in scene with a point light in a
/// cube map.
#[test]
fn casters_that_are_left_out_change_no_bit() {
    let map = ShadowMap {
        size: 128,
        layout: Layout::Cube,
        ..ShadowMap::default()
    };
    let mut left_out = 0;
    for entry in umbrage_scenes::all().iter().filter(|entry| entry.suite) {
        let mut scene = (entry.build)();
        scene.cameras[0].size = UVec2::new(96, 72);
        let geometry = Geometry::bake(&scene).expect("built-in scenes are valid");
        let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
        let Ok(some) = (Hard {}.on(map)).recipe(&view) else {
            continue;
        };
        let all = with_all_casters(&some);
        left_out += some
            .casts
            .iter()
            .filter(|cast| matches!(cast.source, Source::SomeCasters(_)))
            .count();
        assert_eq!(masks(&view, &some), masks(&view, &all), "{}", entry.name);
    }
    assert!(left_out > 20, "{left_out} layers leave casters out");
}

fn with_all_casters(recipe: &Recipe) -> Recipe {
    let mut recipe = recipe.clone();
    for cast in &mut recipe.casts {
        cast.source = Source::from(&CasterSet::All);
    }
    recipe
}

/// Negative control of the test above: a missing visible caster must be detected.
#[test]
fn casters_that_are_missing_are_seen() {
    let (scene, geometry, camera) = scene();
    let view = View::new(&camera, &scene.lights[0], &geometry);
    let technique = Hard {}.on(maps()[0]);
    let whole = technique.recipe(&view).expect("one map holds all casters");
    let mut spoilt = whole.clone();
    let casters = geometry.casters();
    let half = casters.start..casters.start + casters.len() as u32 / 2;
    spoilt.casts[0].source = Source::SomeCasters([half].into());
    let [whole, spoilt] = [whole, spoilt].map(|recipe| masks(&view, &recipe));
    assert_ne!(whole[0], spoilt[0]);
    assert_ne!(whole[1], spoilt[1]);
}
