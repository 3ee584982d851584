//! Net 2: uniforms, where Rust writes and where shaders read.

use umbrage_core::{
    CameraRays, Kernel, Light, Recipe, ShadowTechnique as _, Uniforms, View, glam::Vec3, join,
    resolve::RESOLVE,
};
use umbrage_tests::{layouts::check, stage};

fn kernels(recipe: &Recipe) -> impl Iterator<Item = &dyn Kernel> {
    let filters = recipe.filters.iter().map(|f| &*f.kernel as &dyn Kernel);
    filters.chain([&*recipe.receive.kernel as &dyn Kernel])
}

#[test]
fn every_kernel_writes_its_uniforms_where_its_shader_reads_them() {
    let geometry = stage::geometry(1.0, Vec3::ZERO);
    let camera = stage::camera();
    let light = Light::Directional {
        direction: Vec3::new(1.0, -3.0, 1.0),
        angular_diameter: 0.0093,
    };
    let bulb = Light::Point {
        position: Vec3::new(0.5, 4.0, 1.0),
        radius: 0.1,
    };
    let views = [
        View::new(&camera, &light, &geometry),
        View::new(&camera, &bulb, &geometry),
    ];
    for entry in umbrage_plan::catalogue::all() {
        for technique in (entry.exhaustive)(64) {
            let name = format!("{}, {}", entry.technique.name, technique.settings());
            // Cubes don't serve the sun; everything serves one of the two.
            let recipe = views.iter().find_map(|view| technique.recipe(view).ok());
            let recipe = recipe.unwrap_or_else(|| panic!("{name}: serves neither light"));
            for kernel in kernels(&recipe) {
                let Some(uniforms) = kernel.uniforms() else {
                    continue;
                };
                let layout = uniforms.uniform_layout();
                check(&layout, &join(&kernel.modules())).unwrap_or_else(|e| panic!("{name}: {e}"));
                // A buffer may end in padding, never before the struct does.
                assert!(
                    uniforms.uniform_bytes().len() as u64 >= layout.size,
                    "{name}: too few bytes"
                );
            }
        }
    }
}

/// Mesa's lavapipe compiles a shader that branches on uniforms anew for every value of their buffer's first word, so that
/// moving lights would be slow there.
#[test]
fn the_first_word_of_uniforms_does_not_hang_on_the_light() {
    let geometry = stage::geometry(1.0, Vec3::ZERO);
    let camera = stage::camera();
    let sun = |x: f32| Light::Directional {
        direction: Vec3::new(x, -3.0, 1.0),
        angular_diameter: 0.0093,
    };
    let bulb = |x: f32| Light::Point {
        position: Vec3::new(x, 4.0, 1.0),
        radius: 0.1,
    };
    let pairs = [[sun(1.0), sun(-0.5)], [bulb(0.5), bulb(-0.25)]];
    for entry in umbrage_plan::catalogue::all() {
        for technique in (entry.exhaustive)(64) {
            let name = format!("{}, {}", entry.technique.name, technique.settings());
            let plan = |light: &Light| technique.recipe(&View::new(&camera, light, &geometry)).ok();
            let plans = |[a, b]: &[Light; 2]| plan(a).zip(plan(b));
            let both: Vec<_> = pairs.iter().filter_map(plans).collect();
            assert!(!both.is_empty(), "{name}: serves neither pair");
            for (a, b) in both {
                let first = |r: &Recipe| {
                    kernels(r)
                        .filter_map(|k| Some(k.uniforms()?.uniform_bytes()[..4].to_vec()))
                        .collect::<Vec<_>>()
                };
                assert!(
                    first(&a) == first(&b) || !entry.branches_on_uniforms,
                    "{name}"
                );
            }
        }
    }
}

#[test]
fn camera_rays_lie_where_the_shader_reads_them() {
    check(&CameraRays::layout(), RESOLVE.text).expect("same layout");
}

#[test]
fn a_swapped_renamed_widened_or_missing_field_is_caught() {
    let good = RESOLVE.text;
    for (from, to) in [
        (
            "origin_dx: vec4f,\n    origin_dy: vec4f",
            "origin_dy: vec4f,\n    origin_dx: vec4f",
        ),
        ("dir_dy: vec4f", "dir_dz: vec4f"),
        ("dir: vec4f", "dir: mat4x4f"),
        ("    dir_dy: vec4f,\n", ""),
        ("struct CameraRays", "struct CameraRay"),
    ] {
        let bad = good.replace(from, to);
        assert_ne!(bad, good, "the spoilt text must differ");
        assert!(
            check(&CameraRays::layout(), &bad).is_err(),
            "not caught: {from} -> {to}"
        );
    }
}
