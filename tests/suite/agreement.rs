//! The fourth net: whole recipes over random scenes, played by both backends.
//!
//! On the pinned software driver, masks must be bit-equal. On any other, decided pixels must be.

use glam::{UVec2, Vec2};
use proptest::test_runner::{Config, RngAlgorithm, TestCaseError, TestRng, TestRunner};
use std::{
    cell::{Cell, RefCell},
    collections::BTreeMap,
};
use umbrage_core::{
    Backend, Camera, Geometry, PlanError, Receivers, Recipe, View,
    metrics::{Agreement, Doubt},
};
use umbrage_cpu::Cpu;
use umbrage_tests::{
    gpu::gpu,
    random_scene::{Case, cases},
};

/// So many that a thousand are rendered with maps; some lights are not supported, and some cases are ray-traced.
const SCENES: u32 = 1_600;
/// Techniques that look up no shadow map.
const MAPLESS: [&str; 4] = ["none", "planar", "volumes", "traced"];
/// Scenes that each technique must have rendered at the least; planar shadows refuse most.
const LEAST_EACH: u32 = 25;

#[test]
fn random_scenes_agree() {
    let config = Config { cases: SCENES, failure_persistence: None, max_shrink_iters: 200, ..Config::default() };
    let mut runner = TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha));
    let (rendered, shadowed) = (RefCell::new(BTreeMap::new()), Cell::new(0_u32));
    let outcome = runner.run(&cases(), |case| {
        let dark = agree(&case).map_err(TestCaseError::fail)?;
        *rendered.borrow_mut().entry(case.technique.name()).or_insert(0) += u32::from(dark.is_some());
        shadowed.set(shadowed.get() + u32::from(dark == Some(true)));
        Ok(())
    });
    if let Err(why) = outcome {
        panic!("{why}");
    }
    let rendered = rendered.into_inner();
    let mapped: u32 = rendered.iter().filter(|(name, _)| !MAPLESS.contains(name)).map(|(_, n)| n).sum();
    assert!(mapped >= 1_000, "only {mapped} scenes were rendered with maps: {rendered:?}");
    for entry in umbrage_techniques::all() {
        let count = rendered.get(entry.name).copied().unwrap_or(0);
        assert!(count >= LEAST_EACH, "only {count} scenes were rendered by {}", entry.name);
    }
    assert!(shadowed.get() >= 400, "only {} scenes had a shadow in them: the others prove little", shadowed.get());
}

/// Whether the mask has any shadow; none if the technique doesn't support the scene.
fn agree(case: &Case) -> Result<Option<bool>, String> {
    let geometry = Geometry::bake(&case.scene).map_err(|e| e.to_string())?;
    let (camera, light) = (&case.scene.cameras[0], &case.scene.lights[0]);
    let view = View::new(camera, light, &geometry);
    let recipe = match case.technique.plan(&view) {
        Ok(recipe) => recipe,
        Err(PlanError::Unsupported(_)) => return Ok(None),
        Err(why) => return Err(why.to_string()),
    };
    let cpu = Cpu::new().render(&view, &recipe).map_err(|e| e.to_string())?;
    let mut gpu = gpu();
    let exact = gpu.is_pinned_lavapipe();
    let other = gpu.render(&view, &recipe).map_err(|e| e.to_string())?;
    let (mine, theirs) = (cpu.receivers.ok_or("no receivers")?, other.receivers.ok_or("no receivers")?);
    if exact {
        same_receivers(&mine, &theirs)?;
    }
    let doubts =
        if exact { vec![Doubt::None; cpu.mask.len()] } else { doubts(&view, &recipe, &cpu.mask, &mine, &theirs)? };
    let tolerance = recipe.receive.kernel.tolerance();
    let agreement = Agreement::measure(cpu.size, &cpu.mask, &other.mask, &doubts, tolerance);
    let agreement = agreement.map_err(|e| e.to_string())?;
    let fine = if exact { agreement.differing == 0 } else { agreement.holds() };
    if !fine {
        return Err(format!("{} {}: {agreement:?}", case.technique.name(), case.technique.settings()));
    }
    Ok(Some(cpu.mask.iter().any(|&v| v < 1.0)))
}

fn same_receivers(a: &Receivers, b: &Receivers) -> Result<(), String> {
    for i in 0..a.len() {
        let bits = |r: &Receivers| {
            let [x, y, z] = r.position(i).to_array().map(f32::to_bits);
            let [nx, ny, nz] = r.normal(i).to_array().map(f32::to_bits);
            (r.triangle[i], [x, y, z, nx, ny, nz])
        };
        if bits(a) != bits(b) {
            let (x, y) = (i % a.size.x as usize, i / a.size.x as usize);
            let show = |r: &Receivers| format!("{} {} {}", r.triangle[i], r.position(i), r.normal(i));
            return Err(format!("receivers differ at pixel ({x}, {y}): {} and {}", show(a), show(b)));
        }
    }
    Ok(())
}

/// Pixels whose answer hangs on rounding: the CPU's own changes when the map moves by 1/512 texel or its depth by the
/// rounding of a depth plane, or the backends see different triangles where moving the camera by 1/16 pixel (the
/// coarsest sub-pixel grid in use) changes the CPU's choice, too.
fn doubts(
    view: &View<'_>,
    recipe: &Recipe,
    mask: &[f32],
    mine: &Receivers,
    theirs: &Receivers,
) -> Result<Vec<Doubt>, String> {
    let mut cpu = Cpu::new();
    let mut out = vec![Doubt::None; mask.len()];
    let geometry = view.geometry.ok_or("no geometry")?;
    for (x, y, z) in [(1.0, 1.0, 1.0), (-1.0, 1.0, -1.0), (1.0, -1.0, -1.0), (-1.0, -1.0, 1.0)] {
        let mut nudged = recipe.clone();
        for cast in &mut nudged.casts {
            let size = recipe.images[cast.image].size;
            cast.space = cast.space.nudged(Vec2::new(x, y) / 512.0, z * 4.0 / 16_777_216.0, size);
        }
        let seen = view.with_receivers(mine);
        let other = cpu.render(&seen, &nudged).map_err(|e| e.to_string())?.mask;
        let pairs = out.iter_mut().zip(mask.iter().zip(&other));
        pairs.filter(|(_, (a, b))| a != b).for_each(|(doubt, _)| *doubt = Doubt::Rounding);
        let camera: Camera = view.camera.nudged(Vec2::new(x, y) / 16.0);
        let moved = cpu.receivers(&camera, geometry).map_err(|e| e.to_string())?;
        for (i, doubt) in out.iter_mut().enumerate() {
            if mine.triangle[i] != theirs.triangle[i] && mine.triangle[i] != moved.triangle[i] {
                *doubt = Doubt::Triangle;
            }
        }
    }
    Ok(out)
}

/// The net must catch what it is for: one pixel of one mask is spoilt.
#[test]
fn a_spoilt_pixel_is_caught() {
    let mask = vec![1.0; 64];
    let mut spoilt = mask.clone();
    spoilt[17] = 0.5;
    let agreement = Agreement::measure(UVec2::splat(8), &mask, &spoilt, &[Doubt::None; 64], 0.0).expect("sizes fit");
    assert_eq!((agreement.differing, agreement.violations), (1, 1));
    let mut receivers = Receivers::empty(UVec2::splat(8));
    let other = receivers.clone();
    assert!(same_receivers(&receivers, &other).is_ok());
    receivers.nx[3] = 1e-30;
    assert!(same_receivers(&receivers, &other).is_err());
}
