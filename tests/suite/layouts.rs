//! Test 2 of twins: the layout of uniforms in Rust and in shaders.

use std::{collections::BTreeSet, fs, path::Path};
use umbrage_core::{
    CameraRays, Kernel, Light, Module, Recipe, ShadowTechnique as _, UniformBlock, UniformLayout,
    Uniforms, View, glam::Vec3, join, resolve::RESOLVE,
};
use umbrage_techniques::shadow_map::layers::{MapLayer, ShadowMapUniforms};
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
            // Cubes don't support the sun. Every technique supports one of the two.
            let recipe = views.iter().find_map(|view| technique.recipe(view).ok());
            let recipe = recipe.unwrap_or_else(|| panic!("{name}: serves neither light"));
            for kernel in kernels(&recipe) {
                let Some(uniforms) = kernel.uniforms() else {
                    continue;
                };
                let layout = uniforms.uniform_layout();
                check(&layout, &join(&kernel.modules())).unwrap_or_else(|e| panic!("{name}: {e}"));
                // A buffer may have padding at its end, and must contain the struct.
                assert!(
                    uniforms.uniform_bytes().len() as u64 >= layout.size,
                    "{name}: too few bytes"
                );
            }
        }
    }
}

/// Returns the modules of every kernel of every built-in technique, under a sun and a point light.
fn all_modules() -> Vec<(Option<UniformLayout>, Vec<Module>)> {
    let geometry = stage::geometry(1.0, Vec3::ZERO);
    let camera = stage::camera();
    let lights = [
        Light::Directional {
            direction: Vec3::new(1.0, -3.0, 1.0),
            angular_diameter: 0.0093,
        },
        Light::Point {
            position: Vec3::new(0.5, 4.0, 1.0),
            radius: 0.1,
        },
    ];
    let mut out = Vec::new();
    for entry in umbrage_plan::catalogue::all() {
        for technique in (entry.exhaustive)(64) {
            for light in &lights {
                let Ok(recipe) = technique.recipe(&View::new(&camera, light, &geometry)) else {
                    continue;
                };
                for kernel in kernels(&recipe) {
                    let layout = kernel.uniforms().map(UniformBlock::uniform_layout);
                    out.push((layout, kernel.modules()));
                }
            }
        }
    }
    out
}

/// Appends the texts of all WGSL files below a folder.
fn wgsl_files(folder: &Path, texts: &mut BTreeSet<String>) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            wgsl_files(&path, texts);
        } else if path.extension().is_some_and(|e| e == "wgsl") {
            texts.insert(fs::read_to_string(path).expect("text"));
        }
    }
}

/// Every module is a file or a single constant.
#[test]
fn every_function_is_in_a_file() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut texts = BTreeSet::new();
    for folder in ["shaders", "crates/umbrage-core/src"] {
        wgsl_files(&root.join(folder), &mut texts);
    }
    for (_, modules) in all_modules() {
        for module in modules {
            let is_constant = module.name.contains(':')
                && module.text.starts_with("const ")
                && module.text.matches(';').count() == 1;
            assert!(
                is_constant || texts.contains(module.text),
                "{}: its text is in no file",
                module.name
            );
        }
    }
}

/// Fields whose effect on shaders is a constant that `modules` defines.
const KNOWN_BY_CONSTANTS: [&str; 2] = ["clamped", "packed"];

#[test]
fn every_field_is_read() {
    let mut unread: BTreeSet<(&str, &str)> = BTreeSet::new();
    let mut read: BTreeSet<(&str, &str)> = BTreeSet::new();
    for (layout, modules) in all_modules() {
        let text = join(&modules);
        let of_map = [ShadowMapUniforms::layout(), MapLayer::layout()];
        for layout in of_map.into_iter().chain(layout) {
            for (field, _) in layout.fields {
                // Shaders read the map's uniforms as `kernel.lookup.NAME`, or with the parameter
                // `m`.
                let patterns = match layout.name {
                    "ShadowMapUniforms" => vec![format!("lookup.{field}"), format!("m.{field}")],
                    _ => vec![format!(".{field}")],
                };
                let mut found = patterns
                    .iter()
                    .flat_map(|pattern| text.match_indices(pattern));
                let is_read = found.any(|(at, found)| {
                    let next = text[at + found.len()..].chars().next();
                    next.is_none_or(|c| !c.is_alphanumeric() && c != '_')
                });
                let known = if is_read { &mut read } else { &mut unread };
                known.insert((layout.name, field));
            }
        }
    }
    let never: BTreeSet<&str> = unread.difference(&read).map(|&(_, field)| field).collect();
    assert_eq!(never, BTreeSet::from(KNOWN_BY_CONSTANTS), "{unread:?}");
}

/// Techniques whose shaders don't branch on uniforms. Their uniforms may start with the light.
const WITHOUT_BRANCHES: [&str; 3] = ["none", "planar", "volumes"];

/// A first word that depends on the light would make moving lights slow on the driver of
/// [`STEADY_FIRST_WORD`](umbrage_wgpu::STEADY_FIRST_WORD).
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
                let is_exempt = WITHOUT_BRANCHES.contains(&entry.technique.name);
                assert!(first(&a) == first(&b) || is_exempt, "{name}");
            }
            for [a, b] in &pairs {
                let first = |light: &Light| {
                    let view = View::new(&camera, light, &geometry);
                    let made = technique.device_recipe(&view, None)?;
                    Some(made.expect("is served").hierarchy?.uniforms[..4].to_vec())
                };
                assert_eq!(first(a), first(b), "{name}: its hierarchy");
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
        assert_ne!(bad, good, "the mutated text must differ");
        assert!(
            check(&CameraRays::layout(), &bad).is_err(),
            "not caught: {from} -> {to}"
        );
    }
}
