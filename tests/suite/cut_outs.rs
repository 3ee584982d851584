//! Tests of alpha-tested casters and receivers, against equivalent scenes without textures.

use glam::{Affine3A, UVec2, Vec2, Vec3};
use std::ops::Range;
use umbrage_core::{
    AlphaCutout, AlphaFilter, Backend, Camera, Cascades, Fit, Geometry, Instance, Layout, Light,
    Material, Mesh, NO_TRIANGLE, Recipe, RecipeError, Scene, ShadowTechnique, Shadows, Source,
    Texture, View, light_sample::hash,
};
use umbrage_cpu::Cpu;
use umbrage_plan::catalogue::Catalogue;
use umbrage_plan::cost::Work;
use umbrage_techniques::{
    MapFilter as _, MapFormat, Pcf, ShadowMap, Surface, TechniquePreset, Traced,
};
use umbrage_tests::gpu::gpu;

/// Texels along each side of the card's texture.
const SIDE: u32 = 6;

/// Techniques that don't support alpha tests.
const WITHOUT_HOLES: [&str; 2] = ["planar", "volumes"];

/// Techniques without a shadow of a card: without any shadow, or with shadows of closed casters
/// alone.
const WITHOUT_SHADOW: [&str; 3] = ["none", "second_depth", "midpoint"];

fn lights() -> [Light; 2] {
    [
        Light::Directional {
            direction: Vec3::new(0.3, -1.0, -0.2),
            angular_diameter: 0.0,
        },
        Light::Point {
            position: Vec3::new(0.6, 3.5, 0.4),
            radius: 0.05,
        },
    ]
}

fn camera() -> Camera {
    let size = UVec2::new(96, 64);
    let eye = Vec3::new(3.0, 5.0, 6.0);
    Camera::perspective(eye, Vec3::ZERO, Vec3::Y, 0.4, [0.5, 30.0], size).expect("a good camera")
}

/// A square of two triangles with uvs from 0 to 1.
fn square(name: &str, half: f32) -> Mesh {
    let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)];
    let position = |(x, z): (f32, f32)| Vec3::new(half * x, 0.0, half * z);
    let uv = |(x, z): (f32, f32)| Vec2::new(0.5 * x + 0.5, 0.5 * z + 0.5);
    Mesh {
        name: name.into(),
        positions: corners.map(position).to_vec(),
        uvs: corners.map(uv).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

/// A floor under a card. Its texture is opaque where `is_there` returns `true`.
fn card(is_there: Option<fn(u32, u32) -> bool>) -> Scene {
    let floor = Instance {
        casts: false,
        ..Instance::new(0, Affine3A::IDENTITY)
    };
    let place = Affine3A::from_translation(Vec3::Y * 0.8) * Affine3A::from_rotation_z(0.2);
    let mut scene = Scene {
        meshes: vec![square("floor", 4.0), square("card", 1.0)],
        instances: vec![floor, Instance::new(1, place)],
        ..Scene::default()
    };
    if let Some(is_there) = is_there {
        let texels = (0..SIDE * SIDE).map(|i| {
            let alpha = f32::from(u8::from(is_there(i % SIDE, i / SIDE)));
            [1.0, 1.0, 1.0, alpha]
        });
        scene.textures = vec![Texture {
            name: "holes".into(),
            size: UVec2::splat(SIDE),
            texels: texels.collect(),
        }];
        let alpha = AlphaCutout {
            texture: 0,
            cutoff: 0.5,
            filter: AlphaFilter::Nearest,
        };
        scene.materials = vec![Material {
            alpha: Some(alpha),
            ..Material::default()
        }];
        scene.instances[1].material = Some(0);
    }
    scene
}

fn is_chequered(x: u32, y: u32) -> bool {
    (x + y).is_multiple_of(2)
}

/// A floor under the card's opaque texels, a square each.
fn squares() -> Scene {
    let mut scene = card(None);
    let whole = scene.meshes[1].clone();
    let mut pieces = Mesh {
        name: "squares".into(),
        ..Mesh::default()
    };
    for y in 0..SIDE {
        for x in (0..SIDE).filter(|&x| is_chequered(x, y)) {
            let first = pieces.positions.len() as u32;
            for corner in &whole.uvs {
                let uv = (Vec2::new(x as f32, y as f32) + *corner) / SIDE as f32;
                pieces
                    .positions
                    .push(Vec3::new(2.0 * uv.x - 1.0, 0.0, 2.0 * uv.y - 1.0));
            }
            pieces.triangles.push([first, first + 1, first + 2]);
            pieces.triangles.push([first, first + 2, first + 3]);
        }
    }
    scene.meshes[1] = pieces;
    scene
}

fn render_shadows(backend: &mut dyn Backend, recipe: &Recipe, view: &View<'_>) -> Shadows {
    backend.render(view, recipe).expect("a good view")
}

/// Calls `check` with the masks and receivers of both scenes, for all default techniques that
/// support alpha tests, all lights, and both backends.
fn for_each_pair(a: &Scene, b: &Scene, mut check: impl FnMut(&str, &Shadows, &Shadows)) {
    let camera = camera();
    let [a, b] = [a, b].map(|scene| Geometry::bake(scene).expect("a good scene"));
    let mut rendered = 0;
    for light in lights() {
        for preset in TechniquePreset::defaults() {
            let technique = preset.technique();
            if WITHOUT_SHADOW.contains(&technique.name()) {
                continue;
            }
            let views = [&a, &b].map(|geometry| View::new(&camera, &light, geometry));
            let recipes = views.each_ref().map(|view| technique.recipe(view));
            let name = technique.name();
            let (first, second) = match recipes {
                [Ok(first), Ok(second)] => (first, second),
                // The technique doesn't support the light.
                [Err(_), Err(_)] => continue,
                [first, second] => {
                    let why = first.err().or(second.err());
                    assert!(WITHOUT_HOLES.contains(&name), "{name}: {why:?}");
                    continue;
                }
            };
            let mut cpu = Cpu::new();
            let mut gpu = gpu();
            let backends: [&mut dyn Backend; 2] = [&mut cpu, &mut *gpu];
            for backend in backends {
                let one = render_shadows(backend, &first, &views[0]);
                let other = render_shadows(backend, &second, &views[1]);
                check(&format!("{name} on {}", backend.name()), &one, &other);
                rendered += 1;
            }
        }
    }
    assert!(rendered >= 30, "only {rendered} pairs were compared");
}

/// An alpha texture whose only hole is outside the mesh's part of it changes no bit, although the
/// alpha test runs everywhere.
#[test]
fn what_shows_no_holes_is_as_without_alpha() {
    let mut full = card(Some(|x, y| x + y < 2 * (SIDE - 1)));
    // The texel of the hole begins at five sixths.
    for uv in &mut full.meshes[1].uvs {
        *uv *= 0.75;
    }
    let geometry = Geometry::bake(&full).expect("a good scene");
    assert!(geometry.has_cut_out_casters());
    for_each_pair(&full, &card(None), |what, full, plain| {
        assert!(full.mask == plain.mask, "{what}");
        assert!(plain.mask.iter().any(|&v| v < 1.0), "{what} has no shadow");
    });
}

/// An alpha texture without any hole causes no alpha test: every technique supports the geometry,
/// even those without alpha tests.
#[test]
fn what_has_no_holes_is_served_by_all() {
    let full = Geometry::bake(&card(Some(|_, _| true))).expect("a good scene");
    let plain = Geometry::bake(&card(None)).expect("a good scene");
    assert!(full.cut_outs().is_none());
    let camera = camera();
    let [sun, _] = lights();
    for preset in TechniquePreset::defaults() {
        let technique = preset.technique();
        let name = technique.name();
        let mask = |geometry: &Geometry| {
            let view = View::new(&camera, &sun, geometry);
            let recipe = technique.recipe(&view).expect("all serve whole casters");
            render_shadows(&mut Cpu::new(), &recipe, &view).mask
        };
        assert!(mask(&full) == mask(&plain), "{name}");
    }
}

/// A completely transparent object neither casts nor is visible.
#[test]
fn what_is_all_holes_is_not_there() {
    let clear = card(Some(|_, _| false));
    let mut nothing = card(None);
    nothing.instances.truncate(1);
    for_each_pair(&clear, &nothing, |what, clear, nothing| {
        // An empty map is darkened by the bias of its moments: 1.71e-5 with rounding, at every
        // receiver, as derived in the unit test `maps_of_one_depth_err_by_their_bias_alone` of
        // `umbrage-techniques`. Cutting off a tenth of the light scales that by 1 / .9.
        let least = if what.starts_with("msm") {
            1.0 - 1.95e-5
        } else {
            1.0
        };
        for shadows in [clear, nothing] {
            let darkest = shadows.mask.iter().fold(1.0, |least: f32, &v| least.min(v));
            assert!(darkest >= least, "{what}: {darkest}");
        }
        let positions = |shadows: &Shadows| {
            let receivers = shadows.receivers.as_ref().expect("the view brings none");
            [
                receivers.x.clone(),
                receivers.y.clone(),
                receivers.z.clone(),
            ]
        };
        assert!(positions(clear) == positions(nothing), "{what}");
    });
}

/// A chequered card casts the shadow of its opaque squares and looks like them, except where a
/// pixel, a ray or a map's texel is on their edges.
#[test]
fn a_chequered_card_is_its_squares() {
    for_each_pair(
        &card(Some(is_chequered)),
        &squares(),
        |what, chequered, squares| {
            let pixels = chequered.mask.len();
            let pairs = chequered.mask.iter().zip(&squares.mask);
            let unlike = pairs.filter(|(a, b)| (*a - *b).abs() > 0.02).count();
            // Texel edges of maps show along all edges of the shadow.
            let most = if what.starts_with("traced") || what.starts_with("exact") {
                4
            } else {
                pixels / 25
            };
            assert!(unlike <= most, "{what}: {unlike} of {pixels}");
        },
    );
}

/// Negative control of the comparison above: other holes must fail.
#[test]
fn other_holes_are_distinguished() {
    let swapped: fn(u32, u32) -> bool = |x, y| !is_chequered(x, y);
    for_each_pair(
        &card(Some(swapped)),
        &squares(),
        |what, swapped, squares| {
            let pairs = swapped.mask.iter().zip(&squares.mask);
            let unlike = pairs.filter(|(a, b)| (*a - *b).abs() > 0.02).count();
            assert!(unlike > swapped.mask.len() / 25, "{what}: {unlike}");
        },
    );
}

/// On both backends, the camera sees receivers through holes.
#[test]
fn the_camera_sees_through_holes() {
    let geometry = Geometry::bake(&card(Some(is_chequered))).expect("a good scene");
    let camera = camera();
    let light = &lights()[0];
    let view = View::new(&camera, light, &geometry);
    let recipe = Traced { samples: 1 }
        .recipe(&view)
        .expect("rays are served");
    let ids = |shadows: Shadows| shadows.receivers.expect("the view brings none").triangle;
    let on_cpu = ids(render_shadows(&mut Cpu::new(), &recipe, &view));
    let mut gpu = gpu();
    let exact = gpu.promises_bits();
    let on_gpu = ids(render_shadows(&mut *gpu, &recipe, &view));
    if exact {
        assert!(on_cpu == on_gpu);
    }
    // Alpha-tested triangles come first, so the card precedes the floor.
    let count = |card: bool| {
        let is_seen = |id: &&u32| **id != NO_TRIANGLE && (**id < 2) == card;
        on_cpu.iter().filter(is_seen).count()
    };
    assert!(
        count(true) > 300 && count(false) > 1000,
        "{} {}",
        count(true),
        count(false)
    );
}

/// Techniques that don't support alpha tests refuse alpha-tested casters.
#[test]
fn techniques_without_holes_refuse_them() {
    let geometry = Geometry::bake(&card(Some(is_chequered))).expect("a good scene");
    let uncast = geometry.without_casters();
    let camera = camera();
    let sun = &lights()[0];
    for preset in TechniquePreset::defaults() {
        let technique = preset.technique();
        let refuses = WITHOUT_HOLES.contains(&technique.name());
        let recipe = technique.recipe(&View::new(&camera, sun, &geometry));
        match recipe {
            Err(RecipeError::Unsupported(why)) => {
                assert!(refuses, "{}: {why}", technique.name());
                assert!(
                    why.to_string()
                        .contains("use `traced`, `exact`, `soft` or a map"),
                    "{why}"
                );
            }
            other => assert!(!refuses && other.is_ok(), "{}", technique.name()),
        }
        // Alpha tests of objects that don't cast only matter for the camera.
        let recipe = technique.recipe(&View::new(&camera, sun, &uncast));
        assert!(recipe.is_ok(), "{}", technique.name());
    }
}

/// Returns the default techniques on small maps, and other kinds of maps: cascades, fits around the
/// camera, 16 bits, peeled layers in 16 bits.
fn techniques() -> Vec<TechniquePreset> {
    let on_small_map = |preset: TechniquePreset| match preset.map() {
        Some(map) => preset.with_map(ShadowMap { size: 400, ..*map }),
        None => preset,
    };
    let mut out: Vec<_> = TechniquePreset::defaults()
        .into_iter()
        .map(on_small_map)
        .collect();
    let cascades = ShadowMap {
        size: 256,
        layout: Layout::Cascades(Cascades::default()),
        ..ShadowMap::default()
    };
    let steady = ShadowMap {
        fit: Fit::Stable { range: 12.0 },
        ..cascades
    };
    let coarse_depth = ShadowMap {
        size: 300,
        format: MapFormat::Depth16,
        ..ShadowMap::default()
    };
    let peeled = ShadowMap {
        surface: Surface::Midpoint,
        ..coarse_depth
    };
    for map in [cascades, steady, coarse_depth, peeled] {
        out.push(TechniquePreset::from(Pcf::new(1).on(map)));
    }
    out
}

/// Masks of the two backends are bit-equal in all layouts of maps.
#[test]
fn both_backends_agree_on_holes() {
    let geometry = Geometry::bake(&card(Some(is_chequered))).expect("a good scene");
    let whole = Geometry::bake(&card(None)).expect("a good scene");
    let camera = camera();
    let mut gpu = gpu();
    if !gpu.promises_bits() {
        return;
    }
    let mut reported = 0;
    for light in lights() {
        for technique in techniques() {
            let view = View::new(&camera, &light, &geometry);
            let Ok(recipe) = technique.recipe(&view) else {
                continue;
            };
            let on_cpu = render_shadows(&mut Cpu::new(), &recipe, &view).mask;
            let on_gpu = render_shadows(&mut *gpu, &recipe, &view).mask;
            let name = technique.name();
            assert_eq!(
                count_differing(&on_cpu, &on_gpu),
                0,
                "{name} under {light:?}"
            );
            // Negative control: without alpha tests, the masks differ.
            let view = View::new(&camera, &light, &whole);
            let Ok(recipe) = technique.recipe(&view) else {
                panic!("{name} serves whole casters, too");
            };
            let spoilt = render_shadows(&mut *gpu, &recipe, &view).mask;
            reported += usize::from(count_differing(&on_cpu, &spoilt) > 100);
        }
    }
    assert!(
        reported >= 20,
        "only {reported} masks differ with alpha tests"
    );
}

/// Returns a scene with a fine alpha texture on a card. Two thirds of it are opaque, and it repeats
/// so often that several texels are in a pixel of the camera and of a map.
fn fine_holes(filter: AlphaFilter) -> Scene {
    const FINE: u32 = 180;
    const REPEATS: f32 = 20.0;
    let mut scene = card(Some(is_chequered));
    for uv in &mut scene.meshes[1].uvs {
        *uv *= REPEATS;
    }
    let texels = (0..FINE * FINE).map(|i| {
        let is_there = hash(i) % 3 < 2;
        [1.0, 1.0, 1.0, f32::from(u8::from(is_there))]
    });
    scene.textures[0] = Texture {
        name: "fine holes".into(),
        size: UVec2::splat(FINE),
        texels: texels.collect(),
    };
    if let Some(alpha) = &mut scene.materials[0].alpha {
        alpha.filter = filter;
    }
    scene
}

/// Hashed alpha tests are bit-equal on both backends, in the camera's image and in all layouts of
/// maps. They differ from those of the nearest texel, and rays ignore them.
#[test]
fn both_backends_agree_on_hashed_holes() {
    let filters = [AlphaFilter::Hashed, AlphaFilter::Nearest];
    let [hashed, nearest] =
        filters.map(|filter| Geometry::bake(&fine_holes(filter)).expect("a good scene"));
    let camera = camera();
    let mut gpu = gpu();
    if !gpu.promises_bits() {
        return;
    }
    // Use the same points of the floor for both.
    let traced = Traced { samples: 1 };
    let uncast = hashed.without_casters();
    let light = &lights()[0];
    let view = View::new(&camera, light, &uncast);
    let recipe = traced.recipe(&view).expect("rays are served");
    let seen = render_shadows(&mut Cpu::new(), &recipe, &view).receivers;
    let seen = seen.expect("the view brings none");
    let mut reported = 0;
    for light in lights() {
        for technique in techniques() {
            let view = View::new(&camera, &light, &hashed);
            let Ok(recipe) = technique.recipe(&view) else {
                continue;
            };
            let on_cpu = render_shadows(&mut Cpu::new(), &recipe, &view);
            let on_gpu = render_shadows(&mut *gpu, &recipe, &view);
            let name = technique.name();
            let off = count_differing(&on_cpu.mask, &on_gpu.mask);
            assert_eq!(off, 0, "{name} under {light:?}");
            let ids = |shadows: &Shadows| shadows.receivers.as_ref().map(|r| r.triangle.clone());
            assert!(ids(&on_cpu) == ids(&on_gpu), "{name} under {light:?}");
            let masks = [&hashed, &nearest].map(|geometry| {
                let view = View::new(&camera, &light, geometry).with_receivers(&seen);
                let recipe = technique.recipe(&view).expect("it served the same before");
                render_shadows(&mut *gpu, &recipe, &view).mask
            });
            let changed = count_differing(&masks[0], &masks[1]);
            if recipe.casts.is_empty() {
                assert_eq!(changed, 0, "{name} asks rays");
            } else {
                reported += usize::from(changed > 100);
            }
        }
    }
    assert!(
        reported >= 20,
        "only {reported} masks differ with hashed alpha tests"
    );
}

/// Returns the number of pixels at which two masks differ.
fn count_differing(a: &[f32], b: &[f32]) -> usize {
    a.iter().zip(b).filter(|(a, b)| a != b).count()
}

/// Runs that end, or even begin, beyond the last caster draw the casters that they contain.
#[test]
fn runs_may_reach_beyond_casters_with_holes() {
    let geometry = Geometry::bake(&card(Some(is_chequered))).expect("a good scene");
    let camera = camera();
    let [sun, _] = lights();
    let view = View::new(&camera, &sun, &geometry);
    let pcf = Pcf::new(1).on(ShadowMap::default());
    let casters = geometry.casters();
    let all = pcf.recipe(&view).expect("maps support alpha tests");
    let with_runs = |first: Range<u32>| {
        let mut recipe = all.clone();
        let beyond = casters.end + 5..casters.end + 9;
        recipe.casts[0].source = Source::SomeCasters([first, beyond].into());
        recipe
    };
    let mut cpu = Cpu::new();
    let mut gpu = gpu();
    let backends: [&mut dyn Backend; 2] = [&mut cpu, &mut *gpu];
    for backend in backends {
        let whole = render_shadows(backend, &all, &view).mask;
        let same = render_shadows(backend, &with_runs(casters.clone()), &view).mask;
        let fewer = with_runs(casters.start..casters.end - 1);
        let fewer = render_shadows(backend, &fewer, &view).mask;
        assert_eq!(count_differing(&whole, &same), 0, "{}", backend.name());
        assert!(count_differing(&whole, &fewer) > 100, "{}", backend.name());
    }
}

/// Alpha-tested texels are counted separately: those of the card, and no others.
#[test]
fn work_counts_alpha_tested_texels() {
    let with_holes = card(Some(is_chequered));
    let mut among_whole_casters = with_holes.clone();
    let adjacent = Affine3A::from_translation(Vec3::new(2.5, 0.8, 0.0));
    among_whole_casters
        .instances
        .push(Instance::new(1, adjacent));
    let camera = camera();
    let [sun, _] = lights();
    let work_of = |scene: &Scene| {
        let geometry = Geometry::bake(scene).expect("a good scene");
        let view = View::new(&camera, &sun, &geometry);
        let pcf = Pcf::new(1).on(ShadowMap {
            fit: Fit::Whole,
            ..ShadowMap::default()
        });
        let recipe = pcf.recipe(&view).expect("maps support alpha tests");
        Work::of_recipe(&view, &recipe, &Catalogue::built_in())
    };
    assert_eq!(work_of(&card(None)).cut_out, 0);
    let alone = work_of(&with_holes);
    assert!(alone.covered > 1000, "{alone:?}");
    assert_eq!(alone.cut_out, alone.covered);
    let among = work_of(&among_whole_casters);
    assert!(among.cut_out > 1000, "{among:?}");
    assert!(among.covered > among.cut_out + 1000, "{among:?}");
    assert_eq!(among.lookup().cut_out, 0);
    assert_eq!(among.drawing_only().cut_out, among.cut_out);
}
