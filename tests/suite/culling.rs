//! Tests that culling of casters changes no shadow.
//!
//! In one light space, irrelevant casters are culled, and masks must stay bit-equal. The culled
//! fit's mask must be the whole fit's where both are decided. The tests use random scenes, lights
//! and techniques; both comparators have negative controls with wrong culling.

use glam::{UVec2, Vec2};
use proptest::{
    prelude::*,
    test_runner::{Config, RngAlgorithm, TestCaseError, TestRng, TestRunner},
};
use std::{cell::RefCell, sync::Arc};
use umbrage_core::{
    Backend, Cascades, Faces, Fit, Geometry, Layout, Light, LightSpaces, Receivers, Recipe,
    RecipeError, Scene, ShadowTechnique, Source, View, glam::Vec3, relevant_casters,
};
use umbrage_cpu::Cpu;
use umbrage_techniques::{
    Bias, Hard, MapFilter as _, MapTechnique, Pcf, Pcss, ShadowMap, TechniquePreset,
};
use umbrage_tests::{
    random_scene::scenes,
    stage::{camera, geometry},
};

/// A random technique.
#[derive(Clone, Debug)]
struct CullingCase {
    technique: TechniquePreset,
    /// Radius of its kernel beyond the light's extent, texels.
    reach: f32,
}

/// Tests a property on random values, which are the same in every run. Panics with the first
/// counterexample.
fn run<T: std::fmt::Debug>(
    cases: u32,
    strategy: impl Strategy<Value = T>,
    test: impl Fn(T) -> Result<(), String>,
) {
    let config = Config {
        cases,
        failure_persistence: None,
        max_shrink_iters: 100,
        ..Config::default()
    };
    let mut runner =
        TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha));
    if let Err(why) = runner.run(&strategy, |case| test(case).map_err(TestCaseError::fail)) {
        panic!("{why}");
    }
}

fn techniques() -> impl Strategy<Value = CullingCase> {
    let biases = prop_oneof![
        Just(Bias::NONE),
        Just(Bias::CONSTANT),
        Just(Bias::SLOPE),
        Just(Bias::POLYGON_OFFSET),
        Just(Bias::normal_offset(2.0)),
        Just(Bias::RECEIVER_PLANE),
    ];
    let following = || prop_oneof![Just(Fit::Tight), Just(Fit::Stable { range: 9.0 })];
    let fits = prop_oneof![2 => following(), 1 => Just(Fit::Whole)];
    let layouts = prop_oneof![Just(Layout::Auto), Just(Layout::Single), Just(Layout::Cube)];
    let cascades = Layout::Cascades(Cascades {
        blend: 3.0,
        ..Cascades::default()
    });
    let fits_and_layouts = prop_oneof![
        3 => (fits, layouts),
        1 => (following(), Just(cascades)),
    ];
    (0..3, 16..200_u32, 0..4_u32, biases, fits_and_layouts).prop_map(
        |(kind, size, radius, bias, (fit, layout))| {
            let map = ShadowMap {
                size,
                bias,
                fit,
                layout,
                ..ShadowMap::default()
            };
            let technique: TechniquePreset = match kind {
                0 => TechniquePreset::from(Hard {}.on(map)),
                1 => TechniquePreset::from(Pcf::new(radius).on(map)),
                _ => TechniquePreset::from(Pcss::default().on(map)),
            };
            let kernel = if kind == 1 { radius as f32 } else { 0.0 };
            CullingCase {
                technique,
                reach: kernel + bias.normal_offset,
            }
        },
    )
}

/// A baked scene, and its camera's visible surfaces.
struct Seen {
    scene: Scene,
    geometry: Geometry,
    receivers: Receivers,
}

impl Seen {
    fn new(scene: Scene) -> Result<Self, String> {
        let geometry = Geometry::bake(&scene).map_err(|e| e.to_string())?;
        let receivers = Cpu::new()
            .receivers(&scene.cameras[0], &geometry)
            .map_err(|e| e.to_string())?;
        Ok(Self {
            scene,
            geometry,
            receivers,
        })
    }

    fn view(&self) -> View<'_> {
        View::new(
            &self.scene.cameras[0],
            &self.scene.lights[0],
            &self.geometry,
        )
        .with_receivers(&self.receivers)
    }

    /// Returns the recipe. `None` if the technique does not support the scene.
    fn recipe(&self, technique: &dyn ShadowTechnique) -> Result<Option<Recipe>, String> {
        match technique.recipe(&self.view()) {
            Ok(recipe) => Ok(Some(recipe)),
            Err(RecipeError::Unsupported(_)) => Ok(None),
            Err(why) => Err(why.to_string()),
        }
    }

    fn mask(&self, recipe: &Recipe) -> Result<Vec<f32>, String> {
        let shadows = Cpu::new().render(&self.view(), recipe);
        Ok(shadows.map_err(|e| e.to_string())?.mask)
    }

    /// Returns the mask with only these casters.
    fn mask_of(
        &self,
        recipe: &Recipe,
        casters: impl Iterator<Item = u32>,
    ) -> Result<Vec<f32>, String> {
        let mut recipe = recipe.clone();
        let g = &self.geometry;
        let vertices = g.positions().iter().map(|p| p.extend(1.0)).collect();
        let faces = Faces {
            vertices,
            triangles: casters.map(|t| g.triangles()[t as usize]).collect(),
        };
        let faces = Arc::new(faces);
        for cast in &mut recipe.casts {
            cast.source = Source::Faces(faces.clone());
        }
        self.mask(&recipe)
    }

    fn relevant(&self, recipe: &Recipe, reach: f32) -> Vec<u32> {
        let spaces: Vec<_> = recipe.casts.iter().map(|cast| cast.space).collect();
        let spaces = LightSpaces::with_all_casters(spaces);
        let size = recipe.images[0].size.x;
        relevant_casters(&self.view(), &spaces, size, reach)
    }
}

/// Counts of the tested cases.
#[derive(Debug, Default)]
struct Tally {
    masks: u32,
    shadowed: u32,
    casters: usize,
    dropped: usize,
}

#[test]
fn irrelevant_casters_change_no_mask() {
    let tally = RefCell::new(Tally::default());
    run(600, (scenes(), techniques()), |(scene, case)| {
        let seen = Seen::new(scene)?;
        let technique = &case.technique;
        let Some(recipe) = seen.recipe(technique)? else {
            return Ok(());
        };
        let kept = seen.relevant(&recipe, case.reach);
        let all = seen.mask_of(&recipe, seen.geometry.casters())?;
        let culled = seen.mask_of(&recipe, kept.iter().copied())?;
        let mut t = tally.borrow_mut();
        t.masks += 1;
        t.shadowed += u32::from(all.iter().any(|&v| v < 1.0));
        t.casters += seen.geometry.casters().len();
        t.dropped += seen.geometry.casters().len() - kept.len();
        let differing = all
            .iter()
            .zip(&culled)
            .filter(|(a, b)| a.to_bits() != b.to_bits())
            .count();
        let name = format!("{} {}", technique.name(), technique.settings());
        if differing == 0 {
            Ok(())
        } else {
            Err(format!("{name}: {differing} pixels differ"))
        }
    });
    let t = tally.into_inner();
    println!("{t:?}");
    assert!(
        t.masks >= 300 && t.shadowed >= 150,
        "too few masks, or too few with shadows: {t:?}"
    );
    // Cameras look at the middle of the objects, so most of them are relevant.
    assert!(
        t.dropped * 20 >= t.casters,
        "few casters were culled, so the test proves little: {t:?}"
    );
}

/// A box over a floor that is completely visible.
fn box_over_floor(light: Light) -> Seen {
    let geometry = geometry(1.0, Vec3::ZERO);
    let receivers = Cpu::new()
        .receivers(&camera(), &geometry)
        .expect("a good camera");
    let scene = Scene {
        lights: vec![light],
        cameras: vec![camera()],
        ..Scene::default()
    };
    Seen {
        scene,
        geometry,
        receivers,
    }
}

const SUN: Light = Light::Directional {
    direction: Vec3::new(2.0, -4.0, 1.0),
    angular_diameter: 0.0,
};
const LAMP: Light = Light::Point {
    position: Vec3::new(-1.0, 5.0, -1.0),
    radius: 0.0,
};

/// Negative control: the comparison must fail when a relevant caster is culled.
#[test]
fn a_caster_too_few_is_caught() {
    for light in [SUN, LAMP] {
        let seen = box_over_floor(light);
        let technique = MapTechnique::<Hard>::default();
        let recipe = seen
            .recipe(&technique)
            .expect("a good view")
            .expect("a simple scene");
        let kept = seen.relevant(&recipe, 0.0);
        let all = seen
            .mask_of(&recipe, seen.geometry.casters())
            .expect("it renders");
        let relevant = seen
            .mask_of(&recipe, kept.iter().copied())
            .expect("it renders");
        assert_eq!(all, relevant);
        let mut caught = 0;
        for left_out in &kept {
            let others = kept.iter().copied().filter(|id| id != left_out);
            let spoilt = seen.mask_of(&recipe, others).expect("it renders");
            caught += u32::from(spoilt != all);
        }
        assert!(
            caught >= 2,
            "only {caught} of {} casters are missed when they are left out",
            kept.len()
        );
    }
}

/// Shifts of masks that determine decided pixels, in texels of the coarser map.
const SHIFTS: [(f32, f32); 9] = [
    (0.0, 0.0),
    (1.0, 1.0),
    (-1.0, 1.0),
    (1.0, -1.0),
    (-1.0, -1.0),
    (0.5, 0.0),
    (-0.5, 0.0),
    (0.0, 0.5),
    (0.0, -0.5),
];
/// A bias in clip depth. Its length in metres depends on the range of the fit. The depths of
/// [`DEPTHS`] are therefore from a twelfth to twice as much. Pixels that are decided in both fits
/// are decided for a bias of equal length, if [`depth_ratio`] is less.
const CONSTANT: Bias = Bias {
    constant: 0.03,
    ..Bias::NONE
};
const DEPTHS: [f32; 3] = [0.0, 0.0275, -0.0275];
const GREATEST_RATIO: f32 = 12.0;

/// Returns the greatest ratio of the lengths of a step of clip depth on two maps.
fn depth_ratio(a: &Recipe, b: &Recipe) -> f32 {
    let mut longest = 0.0_f32;
    let mut shortest = f32::INFINITY;
    for cast in a.casts.iter().chain(&b.casts) {
        let clip_from_view = cast.space.clip_from_view;
        // Orthographic depth is linear in the distance along the view, perspective depth in its
        // inverse.
        let is_orthographic = clip_from_view.row(3) == glam::Vec4::W;
        let depth_per_unit = if is_orthographic {
            clip_from_view.z_axis.z
        } else {
            clip_from_view.w_axis.z
        };
        let length = 1.0 / depth_per_unit.abs();
        longest = longest.max(length);
        shortest = shortest.min(length);
    }
    longest / shortest
}

/// Returns a mask with NaN at undecided pixels: those whose result changes when the map moves by up
/// to `texels` of its texels sideways, or in depth by [`DEPTHS`].
fn decided_visibilities(seen: &Seen, recipe: &Recipe, texels: f32) -> Result<Vec<f32>, String> {
    let mut out = seen.mask(recipe)?;
    for depth in DEPTHS {
        // With a shift in depth, the centre and the corners are enough.
        let shifts = if depth == 0.0 {
            &SHIFTS[..]
        } else {
            &SHIFTS[..5]
        };
        for &(x, y) in shifts {
            let mut nudged = recipe.clone();
            for cast in &mut nudged.casts {
                let size: UVec2 = recipe.images[cast.image].size;
                cast.space = cast.space.nudge_by(Vec2::new(x, y) * texels, depth, size);
            }
            let other = seen.mask(&nudged)?;
            for (value, moved) in out.iter_mut().zip(&other) {
                if value != moved {
                    *value = f32::NAN;
                }
            }
        }
    }
    Ok(out)
}

/// Returns the longer side of a texel, in metres or tangents.
fn texel(recipe: &Recipe) -> f32 {
    let p = recipe
        .casts
        .first()
        .map_or(glam::Mat4::IDENTITY, |cast| cast.space.clip_from_view);
    2.0 / (p.x_axis.x.min(p.y_axis.y) * recipe.images[0].size.x as f32)
}

/// Number of pixels at which both masks are decided, and dark; and number of decided ones at which
/// they differ.
#[derive(Debug, Default, Clone, Copy)]
struct Decided {
    pixels: usize,
    decided: usize,
    dark: usize,
    differing: usize,
}

/// Reports whether a point is in the light's cone. Shading darkens points outside, and fits ignore
/// them.
fn is_in_cone(light: &Light, p: Vec3) -> bool {
    match *light {
        Light::Spot {
            position,
            direction,
            outer,
            ..
        } => (p - position).angle_between(direction) < outer,
        _ => true,
    }
}

fn compare(seen: &Seen, whole: &Recipe, culled: &Recipe) -> Result<Decided, String> {
    let coarse = texel(whole).max(texel(culled));
    let a = decided_visibilities(seen, whole, coarse / texel(whole))?;
    let b = decided_visibilities(seen, culled, coarse / texel(culled))?;
    let mut out = Decided::default();
    for i in 0..a.len() {
        let position = seen.receivers.position(i);
        if !seen.receivers.receives[i] || !is_in_cone(&seen.scene.lights[0], position) {
            continue;
        }
        out.pixels += 1;
        if a[i].is_nan() || b[i].is_nan() {
            continue;
        }
        out.decided += 1;
        out.dark += usize::from(a[i] == 0.0);
        out.differing += usize::from(a[i] != b[i]);
    }
    Ok(out)
}

#[test]
fn culled_fits_answer_as_whole_ones_wherever_decided() {
    let tally = RefCell::new(Decided::default());
    let compared = std::cell::Cell::new(0_u32);
    run(
        120,
        (scenes(), 150..300_u32, 0..3_u32),
        |(scene, size, radius)| {
            let seen = Seen::new(scene)?;
            let plan = |fit| {
                let map = ShadowMap {
                    size,
                    fit,
                    bias: CONSTANT,
                    ..ShadowMap::default()
                };
                seen.recipe(&Pcf::new(radius).on(map))
            };
            let Some(whole) = plan(Fit::Whole)? else {
                return Ok(());
            };
            let Some(culled) = plan(Fit::Tight)? else {
                return Ok(());
            };
            if depth_ratio(&whole, &culled) > GREATEST_RATIO {
                return Ok(());
            }
            let d = compare(&seen, &whole, &culled)?;
            let mut t = tally.borrow_mut();
            t.pixels += d.pixels;
            t.decided += d.decided;
            t.dark += d.dark;
            compared.set(compared.get() + 1);
            if d.differing == 0 {
                Ok(())
            } else {
                Err(format!("{d:?}, {size} texels, radius {radius}"))
            }
        },
    );
    let t = tally.into_inner();
    println!("{t:?} in {} scenes", compared.get());
    assert!(
        compared.get() >= 40,
        "only {} of 120 scenes have fits that can be compared",
        compared.get()
    );
    assert!(
        t.decided * 4 > t.pixels && t.dark > 1000,
        "too few pixels are decided: {t:?}"
    );
}

/// Negative control: the comparison must fail when the culled fit's map misses a caster.
#[test]
fn a_fit_that_loses_a_caster_is_caught() {
    let seen = box_over_floor(SUN);
    let plan = |fit| {
        let map = ShadowMap {
            size: 256,
            fit,
            bias: CONSTANT,
            ..ShadowMap::default()
        };
        seen.recipe(&Hard {}.on(map))
            .expect("a good view")
            .expect("a simple scene")
    };
    let whole = plan(Fit::Whole);
    let mut culled = plan(Fit::Tight);
    let fine = compare(&seen, &whole, &culled).expect("it renders");
    assert!(fine.differing == 0 && fine.dark > 20, "{fine:?}");
    culled.casts.clear();
    let spoilt = compare(&seen, &whole, &culled).expect("it renders");
    assert!(spoilt.differing > 20, "{spoilt:?}");
}
