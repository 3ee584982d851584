//! Tests that scenes far from the origin have the same shadows as at the origin, bit for bit, if
//! positions are relative to an anchor.

use glam::{DAffine3, DVec3, Vec3, Vec3A};
use proptest::{
    prelude::*,
    test_runner::{RngSeed, TestCaseError},
};
use std::{cell::RefCell, collections::BTreeMap, sync::Arc};
use umbrage_core::{Anchor, Backend, Geometry, RecipeError, Scene, ShadowTechnique, View};
use umbrage_cpu::Cpu;
use umbrage_techniques::ShadowMap;
use umbrage_tests::{gpu::gpu, random_scene::scenes};

/// Techniques with a map of one comparison, a map of several, and without a map.
const TECHNIQUES: [&str; 6] = ["hard", "pcf", "pcss", "exact", "traced", "soft"];
/// Number of random scenes of each test.
const SCENES: u32 = 24;
/// Grid of the scenes' positions, metres. 32 bits can represent it around the origin, and 64 bits
/// up to 8,000 km away.
const GRID: f32 = 1.0 / (1 << 20) as f32;
/// Distance of far anchors from the origin, in steps between anchors: 1,000,448 m along an axis.
const FAR: i32 = 977;

fn technique(name: &str) -> Arc<dyn ShadowTechnique> {
    let preset = (umbrage_techniques::find(name).expect("built in").preset)();
    let map = preset.map().map(|map| ShadowMap { size: 96, ..*map });
    let preset = map.map_or(preset.clone(), |map| preset.with_map(map));
    preset.technique()
}

fn on_grid(v: Vec3) -> Vec3 {
    (v / GRID).round() * GRID
}

/// Returns a scene whose positions are all on the grid.
fn snap_scene(mut scene: Scene) -> Scene {
    let snap = |v: &mut Vec3A| *v = on_grid((*v).into()).into();
    for instance in &mut scene.instances {
        snap(&mut instance.world_from_local.translation);
    }
    for camera in &mut scene.cameras {
        snap(&mut camera.world_from_view.translation);
    }
    for light in &mut scene.lights {
        if let Some(place) = light.position() {
            *light = light.moved_to(on_grid(place));
        }
    }
    scene
}

/// Returns a scene moved by `away`, relative to an anchor, or without one, relative to the world's
/// origin.
fn move_scene(scene: &Scene, away: DVec3, anchor: Anchor) -> Scene {
    let mut out = scene.clone();
    let place = |world_from_local: &mut glam::Affine3A| {
        let in_world = DAffine3 {
            matrix3: world_from_local.matrix3.as_dmat3(),
            translation: world_from_local.translation.as_dvec3() + away,
        };
        *world_from_local = anchor.placement(&in_world);
    };
    for instance in &mut out.instances {
        place(&mut instance.world_from_local);
    }
    for camera in &mut out.cameras {
        place(&mut camera.world_from_view);
    }
    for light in &mut out.lights {
        if let Some(position) = light.position() {
            *light = light.moved_to(anchor.position(position.as_dvec3() + away));
        }
    }
    out
}

/// Returns the eye of a scene moved by `away`.
fn eye(scene: &Scene, away: DVec3) -> DVec3 {
    scene.cameras[0].eye().as_dvec3() + away
}

/// Returns the masks of both backends for a scene's first light and camera. `None` if the technique
/// refuses.
fn masks(scene: &Scene, technique: &dyn ShadowTechnique) -> Result<Option<[Vec<f32>; 2]>, String> {
    let geometry = Geometry::bake(scene).map_err(|e| e.to_string())?;
    let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
    let recipe = match technique.recipe(&view) {
        Ok(recipe) => recipe,
        Err(RecipeError::Unsupported(_)) => return Ok(None),
        Err(why) => return Err(why.to_string()),
    };
    let on_cpu = Cpu::new().render(&view, &recipe);
    let on_gpu = gpu().render(&view, &recipe);
    let masks = [on_cpu, on_gpu].map(|shadows| shadows.map(|s| s.mask).map_err(|e| e.to_string()));
    let [on_cpu, on_gpu] = masks;
    Ok(Some([on_cpu?, on_gpu?]))
}

fn count_differing(a: &[f32], b: &[f32]) -> usize {
    assert_eq!(a.len(), b.len());
    let pairs = a.iter().zip(b);
    pairs.filter(|(a, b)| a.to_bits() != b.to_bits()).count()
}

/// Counts of a technique.
#[derive(Clone, Copy, Debug, Default)]
struct TechniqueCounts {
    /// Number of scenes that it supports and that have a shadow.
    shadowed: u32,
    /// Number of these with a different mask far away, on the CPU and on the device.
    others: [u32; 2],
}

/// Renders random scenes at the origin and far from it, relative to the anchor that `anchor`
/// returns for an eye.
fn compare(
    seed: u64,
    away: impl Strategy<Value = [i32; 3]>,
    anchor: impl Fn(DVec3) -> Anchor,
) -> BTreeMap<&'static str, TechniqueCounts> {
    let seen = RefCell::new(BTreeMap::<&str, TechniqueCounts>::new());
    let config = ProptestConfig {
        cases: SCENES,
        rng_seed: RngSeed::Fixed(seed),
        failure_persistence: None,
        ..ProptestConfig::default()
    };
    proptest!(config, |(scene in scenes(), steps in away)| {
        let near = snap_scene(scene);
        let away = DVec3::from_array(steps.map(f64::from)) * Anchor::STEP;
        let far = move_scene(&near, away, anchor(eye(&near, away)));
        for name in TECHNIQUES {
            let technique = technique(name);
            let Some(at_origin) = masks(&near, &*technique).map_err(TestCaseError::fail)? else {
                continue;
            };
            if at_origin[0].iter().all(|&v| v == 1.0) {
                continue;
            }
            let mut seen = seen.borrow_mut();
            let entry = seen.entry(name).or_default();
            entry.shadowed += 1;
            // Rounded positions may make planning impossible.
            let far_away = masks(&far, &*technique).ok().flatten();
            for backend in 0..2 {
                let is_other = far_away
                    .as_ref()
                    .is_none_or(|masks| count_differing(&masks[backend], &at_origin[backend]) > 0);
                entry.others[backend] += u32::from(is_other);
            }
        }
    });
    seen.into_inner()
}

#[test]
fn shadows_are_those_at_the_origin() {
    // Up to 8,000 km along each axis, and more than 1e6 m away.
    let away = (FAR..8192, -8192..8192, -8192..8192_i32).prop_map(|(x, y, z)| [x, y, -z]);
    let seen = compare(1, away, |eye| Anchor::nearest_to(eye).expect("finite"));
    for name in TECHNIQUES {
        let seen = seen[name];
        assert!(seen.shadowed >= 10, "{name}: {seen:?}");
        assert_eq!(seen.others, [0, 0], "{name}: {seen:?}");
    }
}

/// Negative control of the comparison above: 32-bit positions 1,000 km from the origin change bits.
#[test]
fn without_an_anchor_shadows_differ() {
    let seen = compare(1, Just([FAR, 0, -FAR]), |_| Anchor::ORIGIN);
    for name in TECHNIQUES {
        let seen = seen[name];
        let fewest = seen.others.into_iter().min().expect("two backends");
        assert!(
            seen.shadowed >= 10 && 10 * fewest >= 9 * seen.shadowed,
            "{name}: {seen:?}"
        );
    }
}

/// Coordinates in units of 2^-20 m, up to 1e7 m. Differences of integers are exact.
fn unit_places() -> impl Strategy<Value = [i64; 3]> {
    prop::array::uniform3(-(10_i64.pow(7) << 20)..10_i64.pow(7) << 20)
}

fn metres(units: i64) -> f64 {
    units as f64 * f64::from(GRID)
}

proptest! {
    #![proptest_config(ProptestConfig { rng_seed: RngSeed::Fixed(3), failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn differences_are_rounded_once(
        eye in unit_places(),
        ways in prop::array::uniform3(-(2000_i64 << 20)..2000 << 20),
    ) {
        let anchor = Anchor::nearest_to(DVec3::from_array(eye.map(metres))).expect("finite");
        let place: [i64; 3] = std::array::from_fn(|axis| eye[axis] + ways[axis]);
        let world = DVec3::from_array(place.map(metres));
        let expected = std::array::from_fn(|axis| {
            let anchor_units = (anchor.point()[axis] / f64::from(GRID)) as i64;
            // Conversions of integers round to the nearest. A power of two adds no error.
            (place[axis] - anchor_units) as f32 * GRID
        });
        prop_assert_eq!(anchor.position(world), Vec3::from_array(expected));
        let placed = anchor.placement(&DAffine3::from_translation(world));
        prop_assert_eq!(placed.translation.to_array(), expected);
    }
}
