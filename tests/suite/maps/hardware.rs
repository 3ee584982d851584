//! Tests of comparison samplers on a device: `pcf_hardware` and `pcf_merged`.

use super::MapCase;
use umbrage_core::{Backend, RecipeError, ShadowTechnique, metrics::Errors};
use umbrage_cpu::Cpu;
use umbrage_techniques::{
    Bias, Border, Hard, MapFilter as _, MapFormat, PcfHardware, PcfMerged, ShadowMap, Surface,
    TechniquePreset, WEIGHT_ERROR,
};
use umbrage_tests::gpu::gpu;

/// Returns every kernel with every path: borders, layouts, formats, biases.
fn techniques() -> Vec<TechniquePreset> {
    let map = ShadowMap {
        size: 200,
        ..ShadowMap::default()
    };
    let maps = [
        ShadowMap {
            bias: Bias::NONE,
            ..map
        },
        map,
        ShadowMap {
            bias: Bias::ADAPTIVE,
            ..map
        },
        ShadowMap {
            bias: Bias::normal_offset(1.5),
            border: Border::Clamp,
            ..map
        },
        ShadowMap {
            format: MapFormat::Depth16,
            ..map
        },
        ShadowMap { size: 1, ..map },
    ];
    let kernels = |map: ShadowMap| -> Vec<TechniquePreset> {
        let hardware =
            [1, 2, 3, 4].map(|samples| TechniquePreset::from(PcfHardware { samples }.on(map)));
        let merged = [1, 2, 3].map(|radius| TechniquePreset::from(PcfMerged { radius }.on(map)));
        hardware.into_iter().chain(merged).collect()
    };
    maps.into_iter().flat_map(kernels).collect()
}

/// A built-in scene in a small image, since there are many kernels.
fn small(name: &str) -> MapCase {
    let mut scene = (umbrage_scenes::find(name).expect("a built-in scene").build)();
    scene.cameras[0].size = glam::UVec2::new(96, 72);
    MapCase::of_scene(scene)
}

/// On the pinned driver, both halves are bit-equal. Elsewhere, lookups into the same map differ in
/// the weights' bits where no comparison depends on rounding: fewer than one in a thousand.
#[test]
fn both_halves_agree() {
    let mut faults = Vec::new();
    let mut rendered = 0;
    let mut refused = 0;
    for name in ["figure", "lamp-in-room"] {
        let case = small(name);
        for technique in techniques() {
            let label = format!("{name}: {} {}", technique.name(), technique.settings());
            let Ok(mut recipe) = technique.recipe(&case.view()) else {
                refused += 1;
                continue;
            };
            recipe.keep_images = true;
            let cpu = Cpu::new().render(&case.view(), &recipe).expect("renders");
            let theirs = gpu()
                .replay_receive(&case.view(), &recipe, &cpu.images)
                .expect("renders");
            let exact = gpu().promises_bits();
            let bound = if exact { 0.0 } else { WEIGHT_ERROR };
            let off = cpu
                .mask
                .iter()
                .zip(&theirs)
                .filter(|(a, b)| (**a - **b).abs() > bound)
                .count();
            let most = if exact { 0 } else { cpu.mask.len() / 1000 };
            let largest = cpu
                .mask
                .iter()
                .zip(&theirs)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f32::max);
            if off > most {
                faults.push(format!(
                    "{label}: {off} of {} differ, by {largest} at most",
                    cpu.mask.len()
                ));
            }
            rendered += 1;
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    // Every kernel is larger than a cube's face of one texel.
    assert_eq!((rendered, refused), (2 * 6 * 7 - 7, 7));
}

/// Negative control: the comparison must detect a different kernel. The GPU's filter is one texel
/// wider here.
#[test]
fn another_kernel_is_caught() {
    let case = MapCase::with_name("figure");
    let map = ShadowMap {
        size: 200,
        ..ShadowMap::default()
    };
    let plan = |radius| {
        PcfMerged { radius }
            .on(map)
            .recipe(&case.view())
            .expect("serves the scene")
    };
    let mut recipe = plan(2);
    recipe.keep_images = true;
    let cpu = Cpu::new().render(&case.view(), &recipe).expect("renders");
    let theirs = gpu()
        .replay_receive(&case.view(), &plan(1), &cpu.images)
        .expect("renders");
    let off = cpu
        .mask
        .iter()
        .zip(&theirs)
        .filter(|(a, b)| (**a - **b).abs() > WEIGHT_ERROR)
        .count();
    assert!(off > cpu.mask.len() / 1000, "only {off} differ");
}

/// Blending moves a hard edge by no more than it blurs it: the mean error stays close to that of
/// one comparison, and steps vanish.
#[test]
fn blended_edges_are_closer_to_truth() {
    let case = MapCase::with_name("figure");
    let map = |samples: u32| {
        let bias = Bias::normal_offset(PcfHardware::reach(samples));
        ShadowMap {
            size: 512,
            bias,
            ..ShadowMap::default()
        }
    };
    let hard = case.errors(&Hard {}.on(ShadowMap {
        bias: Bias::NORMAL_OFFSET,
        ..map(1)
    }));
    let one = case.errors(&PcfHardware { samples: 1 }.on(map(1)));
    assert!(one.rmse < hard.rmse, "{} against {}", one.rmse, hard.rmse);
    assert_eq!((one.acne, hard.acne), (0.0, 0.0));
    let all: Vec<Errors> = (1..=3)
        .map(|r| case.errors(&PcfMerged { radius: r }.on(map(2 * r + 1))))
        .collect();
    assert!(all.iter().all(|e| e.acne == 0.0), "{all:?}");
}

#[test]
fn maps_that_hold_no_depth_are_not_supported() {
    let case = MapCase::with_name("figure");
    for map in [
        ShadowMap {
            format: MapFormat::Rgba8,
            ..ShadowMap::default()
        },
        ShadowMap {
            surface: Surface::Midpoint,
            ..ShadowMap::default()
        },
    ] {
        let why = PcfHardware { samples: 1 }.on(map).recipe(&case.view());
        assert!(matches!(why, Err(RecipeError::Unsupported(_))), "{why:?}");
    }
    for samples in [0, 5] {
        let why = PcfHardware { samples }
            .on(ShadowMap::default())
            .recipe(&case.view());
        assert!(matches!(why, Err(RecipeError::Invalid(_))), "{why:?}");
    }
    for radius in [0, 4, u32::MAX] {
        let why = PcfMerged { radius }
            .on(ShadowMap::default())
            .recipe(&case.view());
        assert!(matches!(why, Err(RecipeError::Invalid(_))), "{why:?}");
    }
}
