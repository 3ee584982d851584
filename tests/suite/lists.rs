//! Tests that `exact` has the bits of `traced` with one ray, with lists and without: on random
//! scenes, built-in ones, around point lights among triangles, and far from the origin.

use glam::{Affine3A, UVec2, Vec2, Vec3};
use proptest::test_runner::{Config, RngAlgorithm, TestCaseError, TestRng, TestRunner};
use std::{cell::Cell, sync::Arc};
use umbrage_core::{
    Aabb, AlphaCutout, AlphaFilter, Backend, Camera, Geometry, Instance, Light, Material, Mesh,
    Receivers, Recipe, Scene, ShadowTechnique, Simd, Texture, View,
    light_sample::{LightSampler, hash, origin_offset, segment},
    math::dot3,
};
use umbrage_cpu::Cpu;
use umbrage_techniques::{Exact, Traced};
use umbrage_tests::{
    driver_model::{is_chosen, runs_all_cases},
    gpu::gpu,
    random_scene,
};

/// Greatest width, pixels.
const WIDTH: u32 = 320;

/// Greatest number of triangles of the built-in scenes. A hierarchy of more takes seconds in tests.
const MOST_TRIANGLES: usize = 150_000;

/// Summary of masks.
#[derive(Clone, Copy, Debug, Default)]
struct MaskSummary {
    dark: usize,
    lit: usize,
}

/// Compares the lists' results with those of rays on the CPU, and optionally on the adapter.
/// Returns an error with the first different pixel.
fn compare(
    camera: &Camera,
    light: &Light,
    geometry: &Geometry,
    on_gpu: bool,
) -> Result<MaskSummary, String> {
    let mut cpu = Cpu::new();
    let receivers = cpu.receivers(camera, geometry).map_err(|e| e.to_string())?;
    let light = light.without_extent();
    let view = View::new(camera, &light, geometry).with_receivers(&receivers);
    let lists = recipe(&Exact::default(), &view)?;
    let expected = rays(&view, geometry, &receivers);
    let found = Exact::default().answers_without_lists(Simd::Native, &view);
    let found = found.map_err(|e| e.to_string())?;
    same(&expected, &found, &receivers, &light)
        .map_err(|why| format!("CPU, without lists: {why}"))?;
    let found = cpu.render(&view, &lists).map_err(|e| e.to_string())?.mask;
    same(&expected, &found, &receivers, &light).map_err(|why| format!("CPU: {why}"))?;
    if on_gpu {
        let found = gpu().render(&view, &lists).map_err(|e| e.to_string())?.mask;
        same(&expected, &found, &receivers, &light).map_err(|why| format!("adapter: {why}"))?;
    }
    let dark = expected.iter().filter(|&&v| v == 0.0).count();
    Ok(MaskSummary {
        dark,
        lit: expected.len() - dark,
    })
}

/// Returns the result of one ray from each receiver, like [`Traced`], for hierarchies of any depth.
fn rays(view: &View<'_>, geometry: &Geometry, receivers: &Receivers) -> Vec<f32> {
    let light = LightSampler::new(view.light);
    let eye = view.camera.eye();
    let plane_reach = geometry.receiver_reach();
    let far = 2.0
        * geometry
            .bounds()
            .union(&Aabb::from_points([eye]))
            .diagonal();
    let bvh = geometry.bvh();
    (0..receivers.len())
        .map(|i| {
            if !receivers.receives[i] {
                return 1.0;
            }
            let [p, n] = [receivers.position(i), receivers.normal(i)];
            let reach = (eye - p).abs().max_element().max(plane_reach);
            let o = p + n * origin_offset(p, reach);
            let ray = segment(&light, o, Vec2::ZERO, far);
            let is_lit = dot3(n, ray) > 0.0 && !bvh.is_occluded(o, ray, receivers.triangle[i]);
            f32::from(u8::from(is_lit))
        })
        .collect()
}

/// Returns an error unless lists and the ray-tracing technique have the same masks on both
/// backends.
fn same_as_traced(camera: &Camera, light: &Light, geometry: &Geometry) -> Result<(), String> {
    let light = light.without_extent();
    let view = View::new(camera, &light, geometry);
    let recipes = [
        recipe(&Traced { samples: 1 }, &view)?,
        recipe(&Exact::default(), &view)?,
    ];
    let mut cpu = Cpu::new();
    let [traced, exact] = recipes
        .each_ref()
        .map(|r| cpu.render(&view, r).expect("renders").mask);
    let mut gpu = gpu();
    let [gpu_traced, gpu_exact] = recipes
        .each_ref()
        .map(|r| gpu.render(&view, r).expect("renders").mask);
    if traced == exact && gpu_traced == gpu_exact {
        Ok(())
    } else {
        Err("masks of `traced` and `exact` differ".to_owned())
    }
}

fn recipe(technique: &dyn ShadowTechnique, view: &View<'_>) -> Result<Recipe, String> {
    technique.recipe(view).map_err(|e| e.to_string())
}

fn same(
    expected: &[f32],
    found: &[f32],
    receivers: &Receivers,
    light: &Light,
) -> Result<(), String> {
    let Some(i) = (0..expected.len()).find(|&i| expected[i] != found[i]) else {
        return Ok(());
    };
    let count = expected.iter().zip(found).filter(|(a, b)| a != b).count();
    Err(format!(
        "{count} of {} pixels differ; pixel {i} at {} on triangle {}: rays say {}, lists {}, under {light:?}",
        expected.len(),
        receivers.position(i),
        receivers.triangle[i],
        expected[i],
        found[i],
    ))
}

fn runner(seed: u8, cases: u32) -> TestRunner {
    let config = Config {
        cases,
        failure_persistence: None,
        max_shrink_iters: 100,
        ..Config::default()
    };
    let random = TestRng::from_seed(RngAlgorithm::ChaCha, &[seed; 32]);
    TestRunner::new_with_rng(config, random)
}

/// Random scenes under all of their lights.
#[test]
fn random_scenes_have_the_answers_of_rays() {
    let shadowed = Cell::new(0);
    let check = |scene: Scene| {
        let geometry = Geometry::bake(&scene).expect("valid");
        for light in &scene.lights {
            let reported =
                compare(&scene.cameras[0], light, &geometry, false).map_err(TestCaseError::fail)?;
            shadowed.set(shadowed.get() + u32::from(reported.dark > 0 && reported.lit > 0));
        }
        Ok(())
    };
    for seed in [4, 9] {
        if let Err(why) = runner(seed, 300).run(&random_scene::scenes(), check) {
            panic!("seed {seed}: {why}");
        }
    }
    assert!(
        shadowed.get() > 200,
        "only {} scenes have shadows",
        shadowed.get()
    );
    shadowed.set(0);
    if let Err(why) = runner(5, 200).run(&random_scene::scenes_with_holes(), check) {
        panic!("alpha-tested scenes: {why}");
    }
    assert!(
        shadowed.get() > 60,
        "only {} alpha-tested scenes have shadows",
        shadowed.get()
    );
}

/// Negative control: casters treated as opaque must be detected.
#[test]
fn lists_of_whole_casters_are_separated_from_those_with_holes() {
    let mut scene = (umbrage_scenes::find("wire-fence")
        .expect("a built-in scene")
        .build)();
    let camera = scene.cameras[0].with_size(UVec2::new(240, 135));
    let light = scene.lights[0];
    let mask = |scene: &Scene| {
        let geometry = Geometry::bake(scene).expect("valid");
        let view = View::new(&camera, &light, &geometry);
        let lists = recipe(&Exact::default(), &view).expect("lists serve all");
        Cpu::new().render(&view, &lists).expect("renders").mask
    };
    let with_holes = mask(&scene);
    for material in &mut scene.materials {
        material.alpha = None;
    }
    let whole = mask(&scene);
    let differing = with_holes.iter().zip(&whole).filter(|(a, b)| a != b);
    let differing = differing.count();
    assert!(differing > 1000, "{differing} pixels tell");
}

/// Built-in scenes, on both backends.
#[test]
fn built_in_scenes_have_the_answers_of_rays() {
    let mut rendered = 0;
    for entry in umbrage_scenes::all() {
        if entry.kind.is_full_size() {
            continue;
        }
        let scene = (entry.build)();
        let geometry = Geometry::bake(&scene).expect("built-in scenes are valid");
        if geometry.triangles().len() > MOST_TRIANGLES {
            continue;
        }
        let camera = scene.cameras[0];
        let width = camera.size.x.min(WIDTH);
        let size = UVec2::new(width, (width * camera.size.y / camera.size.x).max(1));
        for light in &scene.lights {
            let camera = camera.with_size(size);
            let outcome = compare(&camera, light, &geometry, true)
                .and_then(|_| same_as_traced(&camera, light, &geometry));
            if let Err(why) = outcome {
                panic!("{}: {why}", entry.name);
            }
            rendered += 1;
        }
    }
    assert!(rendered > 50, "only {rendered} lights were tested");
}

/// A floor under triangles of all sizes around the origin, at distances from a tenth of a
/// millimetre to ten metres, some of them without area; moved by `shift`. With `has_holes`, every
/// second triangle except the floor's is alpha-tested.
fn soup(seed: u32, shift: Vec3, has_holes: bool) -> Scene {
    let state = Cell::new(hash(seed));
    let unit = || {
        state.set(hash(state.get()));
        state.get() as f32 / u32::MAX as f32
    };
    let signed = || 2.0 * unit() - 1.0;
    let vector = || Vec3::new(signed(), signed(), signed());
    let mut positions = Vec::new();
    for i in 0..400 {
        let distance = 10.0_f32.powf(5.0 * unit() - 4.0);
        let size = distance * 10.0_f32.powf(2.0 * unit() - 1.5);
        let center = vector() * distance;
        let corner = || center + vector() * size;
        let [a, b, c] = [corner(), corner(), corner()];
        positions.extend(match i % 8 {
            0 => [a, b, a.lerp(b, 0.3)],
            1 => [a.with_y(0.2), b.with_y(0.2), c.with_y(0.2)],
            _ => [a, b, c],
        });
    }
    let floor = [-1.0, 1.0].map(|x| [-1.0, 1.0].map(|z| Vec3::new(x * 20.0, -2.0, z * 20.0)));
    positions.extend([floor[0][0], floor[0][1], floor[1][1]]);
    positions.extend([floor[0][0], floor[1][1], floor[1][0]]);
    let count = positions.len() as u32 / 3;
    let uvs = positions
        .iter()
        .map(|p| Vec2::new(p.x + p.y, p.z))
        .collect();
    let positions = positions.into_iter().map(|p| p + shift).collect();
    let triangles = (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
    let mut mesh = Mesh::new("soup", positions, triangles.collect()).expect("valid");
    if !has_holes {
        return Scene {
            name: "soup".into(),
            meshes: vec![mesh],
            instances: vec![Instance::new(0, Affine3A::IDENTITY)],
            ..Scene::default()
        };
    }
    mesh.uvs = uvs;
    soup_with_holes(mesh)
}

/// Returns a soup in which every second triangle, except the floor's, is alpha-tested.
fn soup_with_holes(mut mesh: Mesh) -> Scene {
    let mut with_holes = mesh.clone();
    let is_cut_out = |i: usize| i % 2 == 1 && i < 400;
    let number = Cell::new(0);
    let next = || number.replace(number.get() + 1);
    mesh.triangles.retain(|_| !is_cut_out(next()));
    number.set(0);
    with_holes.triangles.retain(|_| is_cut_out(next()));
    let texels = (0..64_u32).map(|i| [1.0, 1.0, 1.0, (hash(i) % 2) as f32]);
    let alpha = AlphaCutout {
        texture: 0,
        cutoff: 0.5,
        filter: AlphaFilter::Nearest,
    };
    let cut_out = Instance {
        material: Some(0),
        ..Instance::new(1, Affine3A::IDENTITY)
    };
    Scene {
        name: "soup with holes".into(),
        meshes: vec![mesh, with_holes],
        instances: vec![Instance::new(0, Affine3A::IDENTITY), cut_out],
        materials: vec![Material {
            alpha: Some(alpha),
            ..Material::default()
        }],
        textures: vec![Texture {
            name: "holes".into(),
            size: UVec2::splat(8),
            texels: texels.collect(),
        }],
        ..Scene::default()
    }
}

/// Point lights among triangles, some of them closer than a ray's end, and suns along planes, up to
/// 1e6 m from the origin.
#[test]
fn lamps_amid_triangles_have_the_answers_of_rays() {
    let mut shadowed = 0;
    let soups = (0..24_u32).zip([0.0, 0.0, 1e3, 1e5, 1e6].into_iter().cycle());
    // The first of each four also runs on the adapter.
    for (seed, metres) in soups.filter(|(seed, _)| is_chosen(*seed as usize / 4)) {
        let shift = Vec3::new(1.0, 0.0, -0.7) * metres;
        let scene = soup(seed, shift, seed % 8 >= 4);
        let geometry = Geometry::bake(&scene).expect("valid");
        let eye = shift + Vec3::new(6.0, 5.0, 7.0);
        let size = UVec2::new(160, 120);
        let camera = Camera::perspective(eye, shift, Vec3::Y, 0.9, [0.1, 100.0], size);
        let camera = camera.expect("valid");
        let near = Vec3::new(0.003, 0.001, -0.002) * (seed % 3) as f32;
        let lights = [
            Light::Point {
                position: shift + near,
                radius: 0.0,
            },
            Light::Directional {
                direction: Vec3::new(0.3, -1.0, 0.2),
                angular_diameter: 0.0,
            },
            // Put the light into the planes of some triangles.
            Light::Directional {
                direction: Vec3::new(1.0, 0.0, 0.0),
                angular_diameter: 0.0,
            },
        ];
        for light in &lights {
            match compare(&camera, light, &geometry, seed % 4 == 0) {
                Ok(reported) => shadowed += usize::from(reported.dark > 500 && reported.lit > 500),
                Err(why) => panic!("soup {seed} at {metres} m: {why}"),
            }
        }
    }
    let least = if runs_all_cases() { 30 } else { 3 };
    assert!(shadowed > least, "only {shadowed} images have shadows");
}

/// Many casters that were not queried recently are tested without lists. Lists are built for
/// casters that stay.
#[test]
fn lists_are_made_for_casters_that_stay() {
    let scene = (umbrage_scenes::find("town")
        .expect("a built-in scene")
        .build)();
    let geometry = Geometry::bake(&scene).expect("valid");
    let camera = scene.cameras[0].with_size(UVec2::new(160, 90));
    let view = View::new(&camera, &scene.lights[0], &geometry);
    let exact = recipe(&Exact::default(), &view).expect("lists serve all");
    let mut cpu = Cpu::new();
    let first = cpu.render(&view, &exact).expect("renders").mask;
    assert_eq!(
        exact.made_table_bytes(),
        0,
        "no list is built for one image"
    );
    for _ in 0..8 {
        let again = cpu.render(&view, &exact).expect("renders").mask;
        assert!(again == first);
    }
    assert!(exact.made_table_bytes() > 0, "the ninth image uses lists");
    assert!(first.contains(&0.0) && first.contains(&1.0));
}

/// Negative control: lists of other casters, and cells without a list, must be detected.
#[test]
fn spoilt_lists_are_found_out() {
    let scene = (umbrage_scenes::find("cubes")
        .expect("a built-in scene")
        .build)();
    let geometry = Geometry::bake(&scene).expect("valid");
    let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
    let rays = recipe(&Traced { samples: 1 }, &view).expect("rays serve all");
    let expected = gpu().render(&view, &rays).expect("renders").mask;
    let spoil = |table: usize, change: &dyn Fn(usize, &mut [u32; 4])| {
        let mut spoilt = recipe(&Exact::default(), &view).expect("lists serve all");
        let mut rows = spoilt.tables[table].rows().to_vec();
        for (i, row) in rows.iter_mut().enumerate() {
            change(i, row);
        }
        spoilt.tables[table].rows = rows.into();
        let found = gpu().render(&view, &spoilt).expect("renders").mask;
        expected.iter().zip(&found).filter(|(a, b)| a != b).count()
    };
    assert_eq!(spoil(2, &|_, _| {}), 0, "nothing is changed");
    let other_casters = spoil(2, &|_, row| {
        row[0] ^= 1;
        row[2] ^= 1;
    });
    assert!(other_casters > 100, "{other_casters} pixels tell");
    // Put all boxes at the far corner of their cell.
    let no_boxes = spoil(2, &|_, row| {
        row[1] |= 0x7df;
        row[3] |= 0x7df;
    });
    assert!(no_boxes > 100, "{no_boxes} pixels tell");
    // Give each cell the list of the first.
    let first = recipe(&Exact::default(), &view)
        .expect("lists serve all")
        .tables[1]
        .rows()[0][0];
    let no_lists = spoil(1, &|_, row| row[0] = first);
    assert!(no_lists > 100, "{no_lists} pixels tell");
}

/// Lists are kept for the lights that were last queried, regardless of the camera. They don't
/// depend on the number of threads.
#[test]
fn lists_are_kept_and_do_not_depend_on_threads() {
    let scene = (umbrage_scenes::find("figure")
        .expect("a built-in scene")
        .build)();
    let geometry = Geometry::bake(&scene).expect("valid");
    let camera = scene.cameras[0];
    let other_camera = camera.with_size(UVec2::new(64, 64));
    let sun = |x: f32| Light::Directional {
        direction: Vec3::new(x, -1.0, 0.1),
        angular_diameter: 0.0,
    };
    let tables = |light: &Light, camera: &Camera, geometry: &Geometry| {
        let view = View::new(camera, light, geometry);
        recipe(&Exact::default(), &view)
            .expect("lists serve all")
            .tables
    };
    let first = tables(&sun(0.0), &camera, &geometry);
    let again = tables(&sun(0.0), &other_camera, &geometry);
    let other = tables(&sun(0.3), &camera, &geometry);
    let back = tables(&sun(0.0), &camera, &geometry);
    for (i, table) in first.iter().enumerate() {
        assert!(
            Arc::ptr_eq(table.rows(), again[i].rows()),
            "{}",
            table.label
        );
        assert!(Arc::ptr_eq(table.rows(), back[i].rows()), "{}", table.label);
    }
    assert!(!Arc::ptr_eq(first[2].rows(), other[2].rows()));
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let made = pool
            .expect("threads")
            .install(|| tables(&sun(0.0), &camera, &geometry.without_hierarchies()));
        for (a, b) in first.iter().zip(&made) {
            assert!(!Arc::ptr_eq(a.rows(), b.rows()), "rebuilt");
            assert!(a.rows() == b.rows(), "{} with {threads} threads", a.label);
        }
    }
}
