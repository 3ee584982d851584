//! Tests of absurd numbers in the whole public interface: the result is an error about them or a
//! value, and never a panic or a hang.

use proptest::{prelude::*, test_runner::RngSeed};
use std::cell::{Cell, RefCell};
use umbrage_core::{Aabb, Anchor, Backend as _, Geometry, View};
use umbrage_cpu::Cpu;
use umbrage_plan::catalogue::Catalogue;
use umbrage_plan::{Bounds, PlanOptions, Planner, RendererData};
use umbrage_techniques::all;
use umbrage_tests::absurd_values::{camera, light, number, scene, spoil_preset, vector};

fn config(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        rng_seed: RngSeed::Fixed(11),
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

#[test]
fn techniques_answer_or_refuse() {
    let entries = all();
    let cpu = RefCell::new(Cpu::new());
    let [answered, refused] = [Cell::new(0), Cell::new(0)];
    let settings = (
        0..entries.len(),
        prop::collection::vec((0..24_usize, number()), 0..3),
    );
    proptest!(config(3000), |(scene in scene(), light in light(), camera in camera(), (entry, places) in settings)| {
        let Ok(geometry) = Geometry::bake(&scene) else {
            refused.set(refused.get() + 1);
            return Ok(());
        };
        let (Ok(camera), Some(preset)) = (camera, spoil_preset(&(entries[entry].preset)(), &places)) else {
            refused.set(refused.get() + 1);
            return Ok(());
        };
        let view = View::new(&camera, &light, &geometry);
        let Ok(recipe) = preset.technique().recipe(&view) else {
            refused.set(refused.get() + 1);
            return Ok(());
        };
        match cpu.borrow_mut().render(&view, &recipe) {
            Ok(shadows) => {
                answered.set(answered.get() + 1);
                let is_share = |v: &f32| (0.0..=1.0).contains(v);
                prop_assert!(shadows.mask.iter().all(is_share), "{:?} under {light:?}", preset);
            }
            Err(_) => refused.set(refused.get() + 1),
        }
    });
    // Both outcomes must occur, or the test is void.
    assert!(
        answered.get() > 200 && refused.get() > 200,
        "{answered:?} {refused:?}"
    );
}

#[test]
fn anchors_boxes_and_lights_answer_or_refuse() {
    proptest!(config(2000), |(a in vector(), b in vector(), light in light())| {
        let eye = a.as_dvec3() * f64::from(b.x);
        if let Ok(anchor) = Anchor::nearest_to(eye) {
            prop_assert!(anchor.position(eye).is_finite());
            let _ = anchor.kept_for(b.as_dvec3());
        }
        let bounds = Aabb { min: a, max: b };
        let _ = (bounds.is_empty(), bounds.diagonal(), bounds.center());
        if light.validate().is_ok() {
            prop_assert!(light.without_extent().validate().is_ok(), "{light:?}");
        }
    });
}

/// Limits for a planner: errors, times, bytes, samples and image sizes, sensible or not.
fn bounds() -> impl Strategy<Value = Bounds> {
    let maybe = || {
        prop_oneof![
            12 => Just(None),
            2 => Just(Some(0.5)),
            1 => number().prop_map(|number| Some(f64::from(number))),
        ]
    };
    let bytes = prop::option::of(prop::sample::select(vec![0, 1, 1 << 20, u64::MAX]));
    (maybe(), maybe(), maybe(), maybe(), maybe(), bytes).prop_map(
        |(max_error, max_relative_error, max_ms, max_grain, max_shimmer, max_bytes)| Bounds {
            max_error,
            max_relative_error,
            max_ms,
            max_bytes,
            max_grain,
            max_shimmer,
            renderer: RendererData::default(),
        },
    )
}

#[test]
fn planners_answer_or_refuse() {
    let [answered, refused] = [Cell::new(0), Cell::new(0)];
    let samples = prop::sample::select(vec![0, 1, 64, u32::MAX]);
    proptest!(config(2000), |(scene in scene(), light in light(), camera in camera(), bounds in bounds(), samples in samples)| {
        let (Ok(geometry), Ok(camera)) = (Geometry::bake(&scene), camera) else {
            refused.set(refused.get() + 1);
            return Ok(());
        };
        // Use techniques without maps. Testing maps of all sizes takes seconds a plan, and the
        // subject here is the planner.
        let few = |name: &str| ["none", "exact", "soft", "traced"].contains(&name);
        let options = PlanOptions {
            catalogue: Catalogue::built_in().retain(few),
            samples,
            ..PlanOptions::default()
        };
        let planner = Planner::new(&camera, &light, &geometry, &options, &|_| {});
        match planner.and_then(|mut planner| planner.plan(&bounds)) {
            Ok(plan) => {
                answered.set(answered.get() + 1);
                prop_assert!(plan.chosen.is_some() || plan.miss.is_some(), "neither a setting nor a reason: {bounds:?}");
            }
            Err(error) => {
                refused.set(refused.get() + 1);
                prop_assert!(!error.to_string().is_empty());
            }
        }
    });
    assert!(
        answered.get() > 20 && refused.get() > 20,
        "{answered:?} {refused:?}"
    );
}
