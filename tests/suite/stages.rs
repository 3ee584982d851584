//! The third test of twins: single stages. The GPU's receive the CPU's images, so that differences
//! can't pass from one stage to the next, and a failure names the stage.

use glam::UVec2;
use umbrage_core::{Backend, Geometry, Image, Receivers, Recipe, ShadowTechnique, View};
use umbrage_cpu::Cpu;
use umbrage_examples::variance::Variance;
use umbrage_plan::catalogue::all;
use umbrage_scenes::find;
use umbrage_techniques::{MapFilter as _, ShadowMap, TechniquePreset};
use umbrage_tests::gpu::gpu;

/// Scenes with different lights and plenty of edges.
const SCENES: [&str; 3] = ["cubes", "figure", "teapot-lamp"];

struct ExecutedStages {
    recipe: Recipe,
    receivers: Receivers,
    images: Vec<Image>,
    mask: Vec<f32>,
}

/// Executes a recipe on the CPU and keeps all results.
fn run_technique(view: &View<'_>, technique: &dyn ShadowTechnique) -> Option<ExecutedStages> {
    let mut recipe = technique.recipe(view).ok()?;
    recipe.keep_images = true;
    let shadows = Cpu::new()
        .render(view, &recipe)
        .expect("built-in scenes render");
    Some(ExecutedStages {
        recipe,
        receivers: shadows.receivers?,
        images: shadows.images,
        mask: shadows.mask,
    })
}

/// Runs `check` for every technique, with all its kernels and biases, over the scenes.
fn for_each_recipe(check: impl Fn(&View<'_>, ExecutedStages, &str)) {
    let mut rendered = 0;
    for name in SCENES {
        let mut scene = (find(name).expect("a built-in scene").build)();
        scene.cameras[0].size = UVec2::new(160, 120);
        let geometry = Geometry::bake(&scene).expect("built-in scenes are valid");
        let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
        let own = Variance {
            map: ShadowMap {
                size: 128,
                ..ShadowMap::default()
            },
            radius: 2,
            least_variance: 1e-6,
        };
        let built_in = all().iter().flat_map(|entry| (entry.exhaustive)(128));
        for technique in built_in.chain([TechniquePreset::from(own)]) {
            let label = format!("{name}: {} {}", technique.name(), technique.settings());
            if let Some(p) = run_technique(&view, &technique) {
                check(&view, p, &label);
                rendered += 1;
            }
        }
    }
    assert!(rendered > 60, "only {rendered} recipes were executed");
}

/// Fraction of values that may differ by more than a step of an 8-bit image on drivers other than
/// the pinned one: the design's limit for pixels whose result depends on rounding.
const LOOSE_SHARE: f64 = 1e-3;

fn equal(what: &str, label: &str, cpu: &[f32], gpu: &[f32]) {
    assert_eq!(cpu.len(), gpu.len(), "{label}: {what}");
    let exact = umbrage_tests::gpu::gpu().promises_bits();
    let differ = |a: f32, b: f32| {
        if exact {
            a.to_bits() != b.to_bits()
        } else {
            (a - b).abs() > 1.0 / 255.0
        }
    };
    let differing = cpu
        .iter()
        .zip(gpu)
        .filter(|(a, b)| differ(**a, **b))
        .count();
    let largest = cpu
        .iter()
        .zip(gpu)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f32::max);
    let most = if exact {
        0
    } else {
        (cpu.len() as f64 * LOOSE_SHARE) as usize
    };
    assert!(
        differing <= most,
        "{label}: {what}: {differing} of {} differ, by {largest} at most",
        cpu.len()
    );
}

#[test]
fn casts_are_equal() {
    for_each_recipe(|view, mut p, label| {
        p.recipe.filters.clear();
        let cpu = Cpu::new().render(view, &p.recipe).expect("renders").images;
        let gpu = gpu().render(view, &p.recipe).expect("renders").images;
        for (a, b) in cpu.iter().zip(&gpu) {
            equal(a.desc.label, label, &a.texels, &b.texels);
        }
    });
}

#[test]
fn filters_are_equal() {
    for_each_recipe(|_, p, label| {
        for index in 0..p.recipe.filters.len() {
            let output = p.recipe.filters[index].output;
            let cpu = Cpu::new()
                .replay_filter(&p.recipe, index, &p.images)
                .expect("renders");
            let gpu = gpu()
                .replay_filter(&p.recipe, index, &p.images)
                .expect("renders");
            equal(
                p.recipe.images[output].label,
                label,
                &cpu.texels,
                &gpu.texels,
            );
        }
    });
}

#[test]
fn lookups_are_equal() {
    for_each_recipe(|view, p, label| {
        let view = view.with_receivers(&p.receivers);
        let gpu = gpu()
            .replay_receive(&view, &p.recipe, &p.images)
            .expect("renders");
        equal("mask", label, &p.mask, &gpu);
    });
}

/// Negative control: the map is turned upside down for the GPU alone, and the masks must differ.
#[test]
fn a_spoilt_map_is_caught() {
    let scene = (find("cubes").expect("a built-in scene").build)();
    let geometry = Geometry::bake(&scene).expect("valid");
    let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
    let technique = umbrage_techniques::Hard {}.on(ShadowMap {
        size: 16,
        ..ShadowMap::default()
    });
    let mut p = run_technique(&view, &technique).expect("hard serves the sun");
    p.images[0]
        .texels
        .iter_mut()
        .for_each(|depth| *depth = 1.0 - *depth);
    let view = view.with_receivers(&p.receivers);
    let spoilt = gpu()
        .replay_receive(&view, &p.recipe, &p.images)
        .expect("renders");
    assert!(p.mask.iter().zip(&spoilt).any(|(a, b)| a != b));
}
