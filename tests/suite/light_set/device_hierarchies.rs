//! Tests of hierarchies that a device builds, against rays.

use super::alike::{World, count_differing};
use bytemuck::cast_slice;
use glam::{Affine3A, Vec2, Vec3};
use proptest::{prelude::*, test_runner::RngSeed};
use std::{
    cell::Cell,
    sync::{Arc, Mutex, PoisonError},
};
use umbrage_core::{
    Backend, DeviceHierarchy, Kernel, Light, NO_TRIANGLE, Scene, ShadowTechnique, Uniforms, join,
    light_sample::{LightSampler, ray_origin, segment},
    math::dot3,
};
use umbrage_techniques::{Exact, ExactStructure, ExactUniforms, LightView};
use umbrage_tests::{
    driver_model::{is_chosen, nth_case},
    foreign,
    gpu::gpu,
    layouts::check,
    light_program::Forward,
    light_stage::{Stage, spot},
    random_scene,
};
use umbrage_wgpu::{
    CasterMesh, LightId, LightSet, SetBudget, SetFrame, ShadowedLight, Unserved, VertexLayout,
};
use wgpu::BufferUsages;

/// Scenes with suns and point lights, with closed, open and alpha-tested casters, some with a light
/// among the casters, some of real size, some small or large, and one far from the origin.
const SCENES: [&str; 17] = [
    "cubes",
    "figure",
    "teapot-lamp",
    "lamp-in-room",
    "two-blockers",
    "bar-at-lamp",
    "broken-meshes",
    "broken-meshes-lamp",
    "stairs-lamp",
    "thin-plate",
    "canopy",
    "low-sun-5",
    "hills-1e6",
    "wire-fence",
    "foliage",
    "cubes-tiny",
    "cubes-huge",
];

pub(super) fn exact(light: Light) -> ShadowedLight {
    ShadowedLight {
        light,
        technique: Arc::new(Exact::default()),
        priority: 1.0,
    }
}

impl World {
    /// A frame of a program without triangles on the CPU.
    pub(super) fn frame_without_triangles(&self) -> SetFrame<'_> {
        SetFrame {
            camera: &self.scene.cameras[0],
            geometry: None,
        }
    }

    /// Returns the visibility by rays for a light of a set, from each receiver's offset position in
    /// the set's kernel.
    pub(super) fn trace_mask(&self, set: &LightSet, light: &Light) -> Vec<f32> {
        self.answers(set, light, true)
    }

    /// Returns the visibility by rays, with or without casters.
    fn answers(&self, set: &LightSet, light: &Light, casters_count: bool) -> Vec<f32> {
        let camera = &self.scene.cameras[0];
        let view = set.view(&self.frame_without_triangles(), light);
        let made = Exact::default().device_recipe(&view, None);
        let made = made.expect("a hierarchy");
        let recipe = made.expect("serves the light");
        let kernel: &dyn Kernel = &*recipe.receive.kernel;
        let bytes = kernel.uniforms().expect("has some").uniform_bytes();
        let [extent, far] = extent_and_far(&bytes);
        let sampler = LightSampler::new(&light.without_extent());
        let seen = &self.receivers;
        let casts = |o: Vec3, d: Vec3| self.geometry.bvh().is_occluded(o, d, NO_TRIANGLE);
        let ray = |i: usize| {
            if !seen.receives[i] {
                return 1.0;
            }
            let n = seen.normal(i);
            let o = ray_origin(seen.position(i), n, camera.eye(), extent);
            let d = segment(&sampler, o, Vec2::ZERO, far);
            let faces = dot3(n, d) > 0.0;
            let is_lit = faces && !(casters_count && casts(o, d));
            f32::from(u8::from(is_lit))
        };
        (0..seen.len()).map(ray).collect()
    }
}

fn extent_and_far(bytes: &[u8]) -> [f32; 2] {
    let layout = ExactUniforms::layout();
    let float = |name: &str, component: usize| {
        let field = layout.fields.iter().find(|(field, _)| *field == name);
        let at = field.expect("is there").1 as usize + 4 * component;
        f32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes"))
    };
    [float("grid", 3), float("far", 0)]
}

/// Returns a light's mask from its set.
pub(super) fn mask(world: &World, set: &LightSet, id: LightId, forward: &mut Forward) -> Vec<f32> {
    let index = set.index_of(id).expect("is there");
    forward.mask(&world.program, set, index)
}

/// A set and a program's renderer of it. All scenes of all tests share them, because pipelines take
/// far longer to compile than a scene takes to draw.
pub(super) struct Comparison {
    pub(super) set: LightSet,
    forward: Forward,
}

static COMPARISON: Mutex<Option<Comparison>> = Mutex::new(None);

/// Calls `run` with the shared comparison, or with a new one if a test failed before.
pub(super) fn with_comparison<T>(run: impl FnOnce(&mut Comparison) -> T) -> T {
    let mut shared = COMPARISON.lock().unwrap_or_else(PoisonError::into_inner);
    let mut comparison = shared.take().unwrap_or_else(|| Comparison {
        set: World::new("cubes").empty_set(),
        forward: Forward::default(),
    });
    comparison.set.limit_references(None);
    let result = run(&mut comparison);
    *shared = Some(comparison);
    result
}

impl Comparison {
    /// Returns the number of receivers at which rays differ, and the number in shadow, summed over
    /// a scene's lights.
    fn count(&mut self, world: &World) -> [usize; 2] {
        let casters = world.add_casters(&mut self.set);
        let mut sums = [0; 2];
        for &light in &world.scene.lights {
            let [wrong, shadowed] = self.count_light(world, light);
            sums[0] += wrong;
            sums[1] += shadowed;
        }
        for (mesh, caster) in casters {
            self.set.remove_caster(caster).expect("is there");
            self.set.remove_mesh(mesh).expect("is there");
        }
        sums
    }

    fn count_light(&mut self, world: &World, light: Light) -> [usize; 2] {
        let set = &mut self.set;
        let id = set.add_light(exact(light)).expect("valid");
        world.program.update(set, &world.frame_without_triangles());
        let unserved: Vec<_> = set.unserved_lights().collect();
        assert!(unserved.is_empty(), "{unserved:?}");
        let found = mask(world, set, id, &mut self.forward);
        let expected = world.trace_mask(set, &light);
        set.remove_light(id).expect("is there");
        let shadowed = expected.iter().filter(|&&v| v < 1.0).count();
        [count_differing(&found, &expected), shadowed]
    }

    /// Checks that a scene's lights have the results of rays, and returns the number of receivers
    /// in shadow.
    pub(super) fn check(&mut self, world: &World, what: &str) -> usize {
        let [wrong, shadowed] = self.count(world);
        let allowed = allowed_pixels(world.receivers.len() * world.scene.lights.len());
        assert!(wrong <= allowed, "{what}: {wrong} of {allowed} pixels");
        shadowed
    }
}

/// Returns the allowed number of differences: none on drivers that round like the CPU; on others, a
/// few rays that hit an edge.
pub(super) fn allowed_pixels(pixels: usize) -> usize {
    if gpu().snapping() == umbrage_core::Snapping::default() {
        0
    } else {
        pixels / 1000
    }
}

#[test]
fn hierarchies_of_the_device_answer_as_rays_do() {
    for (_, name) in SCENES.iter().enumerate().filter(|(i, _)| is_chosen(*i)) {
        let world = World::new(name);
        let shadowed = with_comparison(|comparison| comparison.check(&world, name));
        assert!(shadowed > 100, "{name}: only {shadowed} in shadow");
    }
}

/// Random scenes with one light each.
#[test]
fn random_scenes_answer_as_rays_do() {
    check_random(random_scene::scenes(), 100);
}

/// Random scenes with alpha-tested casters.
#[test]
fn random_scenes_with_holes_answer_as_rays_do() {
    check_random(random_scene::scenes_with_holes(), 50);
}

fn check_random(scenes: impl Strategy<Value = Scene>, cases: u32) {
    let cases = cases / nth_case() as u32;
    let config = ProptestConfig {
        cases,
        max_shrink_iters: 100,
        rng_seed: RngSeed::Fixed(11),
        failure_persistence: None,
        ..ProptestConfig::default()
    };
    let in_shadow = Cell::new(0);
    proptest!(config, |(scene in scenes)| {
        let Some(world) = world_of(scene) else {
            return Ok(());
        };
        // With capacity for strips, and without.
        for most in [None, Some(0)] {
            let [wrong, shadowed] = with_comparison(|comparison| {
                comparison.set.limit_references(most);
                comparison.count(&world)
            });
            prop_assert!(wrong <= allowed_pixels(world.receivers.len()), "{} pixels", wrong);
            in_shadow.set(in_shadow.get() + shadowed);
        }
    });
    let in_shadow = in_shadow.get();
    let least = 500 * cases;
    assert!(in_shadow > least as usize, "only {in_shadow} in shadow");
}

/// Returns the world of a random scene, if it has casters.
fn world_of(scene: Scene) -> Option<World> {
    let world = World::of_scene(scene);
    (!world.geometry.casters().is_empty()).then_some(world)
}

/// Negative control: rays of another light differ.
#[test]
fn rays_of_another_light_answer_otherwise() {
    let world = World::new("cubes");
    let mut set = world.set();
    let light = world.scene.lights[0];
    let id = set.add_light(exact(light)).expect("valid");
    world
        .program
        .update(&mut set, &world.frame_without_triangles());
    let found = mask(&world, &set, id, &mut Forward::default());
    let moved = Light::Directional {
        direction: light.direction_from(Vec3::ZERO) * -1.0 + Vec3::new(0.02, 0.0, 0.0),
        angular_diameter: 0.0,
    };
    assert!(count_differing(&found, &world.trace_mask(&set, &moved)) > 10);
}

/// Without capacity for pieces, casters are whole, and those on several faces of a point light may be
/// anywhere. The answers are the same.
#[test]
fn hierarchies_without_room_answer_alike() {
    for name in ["figure", "lamp-in-room", "bar-at-lamp"] {
        let world = World::new(name);
        let shadowed = with_comparison(|comparison| {
            comparison.set.limit_references(Some(0));
            comparison.check(&world, name)
        });
        assert!(shadowed > 100, "{name}: only {shadowed} in shadow");
    }
}

/// Casters that are not finite cast nothing, and change no other shadow.
#[test]
fn casters_that_are_not_finite_change_nothing() {
    for name in ["cubes", "teapot-lamp"] {
        let world = World::new(name);
        let shadowed = with_comparison(|comparison| comparison.check(&world, name));
        assert!(shadowed > 100, "{name}: only {shadowed} in shadow");
        let d = world.program.d;
        for odd in [f32::INFINITY, f32::NEG_INFINITY, f32::NAN] {
            // A triangle with such a number in each corner, and one with two finite corners.
            let in_each = [[odd, 1.0, 0.0], [0.0, odd, 1.0], [1.0, 0.0, odd]];
            let in_one = [[odd, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]];
            let corners = [in_each, in_one];
            let usage = BufferUsages::STORAGE | BufferUsages::VERTEX;
            let vertices = foreign::buffer(d, usage, cast_slice(&corners));
            let mesh = CasterMesh {
                label: "not finite",
                vertices: &vertices,
                layout: VertexLayout::PACKED,
                indices: None,
                range: 0..6,
                base_vertex: 0,
                bounds: world.geometry.caster_bounds(),
            };
            with_comparison(|comparison| {
                let mesh = comparison.set.add_mesh(&mesh).expect("valid");
                let caster = comparison.set.add_caster(mesh, Affine3A::IDENTITY);
                comparison.check(&world, &format!("{name} and {odd}"));
                let set = &mut comparison.set;
                set.remove_caster(caster.expect("valid")).expect("is there");
                set.remove_mesh(mesh).expect("is there");
            });
        }
    }
}

/// Lights of a set share scratch buffers.
#[test]
fn lights_of_one_set_answer_as_rays_do() {
    let world = World::new("lamp-in-room");
    let mut set = world.set();
    let sun = Light::Directional {
        direction: Vec3::new(0.4, -1.0, 0.3),
        angular_diameter: 0.0,
    };
    let lamp = Light::Point {
        position: Vec3::new(0.3, 1.1, -0.2),
        radius: 0.0,
    };
    let lights = [world.scene.lights[0], sun, lamp];
    let ids = lights.map(|light| set.add_light(exact(light)).expect("valid"));
    world
        .program
        .update(&mut set, &world.frame_without_triangles());
    assert_eq!(set.report().hierarchies, 3);
    let mut forward = Forward::default();
    for (id, light) in ids.into_iter().zip(lights) {
        let found = mask(&world, &set, id, &mut forward);
        let wrong = count_differing(&found, &world.trace_mask(&set, &light));
        assert!(
            wrong <= allowed_pixels(world.receivers.len()),
            "{light:?}: {wrong}"
        );
    }
}

/// Moved casters have the shadows of casters that were there from the start. Removed ones have
/// none, although their nodes were in the tables.
#[test]
fn casters_that_move_leave_nothing_behind() {
    let world = World::new("figure");
    let frame = world.frame_without_triangles();
    let light = world.scene.lights[0];
    let start = || {
        let mut set = world.empty_set();
        let meshes = world.meshes(&mut set);
        let id = set.add_light(exact(light)).expect("valid");
        (set, meshes, id)
    };
    let moved = Affine3A::from_translation(Vec3::new(0.3, 0.1, -0.2));
    let (mut set, meshes, id) = start();
    let add = |set: &mut LightSet, at: Affine3A| {
        let casters = meshes.iter().map(|&mesh| set.add_caster(mesh, at));
        casters.collect::<Result<Vec<_>, _>>().expect("valid")
    };
    let casters = add(&mut set, Affine3A::IDENTITY);
    let mut forward = Forward::default();
    let mut seen = |set: &mut LightSet| {
        world.program.update(set, &frame);
        mask(&world, set, id, &mut forward)
    };
    let first = seen(&mut set);
    assert!(
        count_differing(&first, &world.trace_mask(&set, &light)) <= allowed_pixels(first.len())
    );
    for &caster in &casters {
        set.move_caster(caster, moved).expect("valid");
    }
    let second = seen(&mut set);
    assert!(count_differing(&first, &second) > 100);
    for caster in casters {
        set.remove_caster(caster).expect("is there");
    }
    let empty = seen(&mut set);
    assert_eq!(
        count_differing(&empty, &world.answers(&set, &light, false)),
        0
    );
    add(&mut set, moved);
    assert_eq!(count_differing(&second, &seen(&mut set)), 0);
}

/// With triangles on the CPU, the setting chooses between lists and a hierarchy. Both have the same
/// bits, and casters that go while lists are shown are not in the next hierarchy.
#[test]
fn the_structure_may_change_while_triangles_are_there() {
    let world = World::new("figure");
    let mut set = world.empty_set();
    let casters = world.add_casters(&mut set);
    let light = world.scene.lights[0];
    let id = set.add_light(exact(light)).expect("valid");
    let mut forward = Forward::default();
    let mut seen_with = |set: &mut LightSet, structure: ExactStructure| {
        let technique = Arc::new(Exact { structure });
        set.set_technique(id, technique).expect("is there");
        world.program.update(set, &world.frame());
        let found = mask(&world, set, id, &mut forward);
        (set.report().hierarchies, found)
    };
    let expected = world.trace_mask(&set, &light);
    let allowed = allowed_pixels(expected.len());
    for (structure, expected_count) in [
        (ExactStructure::Lists, 0),
        (ExactStructure::Hierarchy, 1),
        (ExactStructure::Lists, 0),
    ] {
        let (count, found) = seen_with(&mut set, structure);
        assert_eq!(count, expected_count, "{structure:?}");
        let wrong = count_differing(&found, &expected);
        assert!(wrong <= allowed, "{structure:?}: {wrong}");
    }
    for (_, caster) in casters {
        set.remove_caster(caster).expect("is there");
    }
    let (_, found) = seen_with(&mut set, ExactStructure::Hierarchy);
    let without_casters = world.answers(&set, &light, false);
    assert_eq!(count_differing(&found, &without_casters), 0);
    assert!(count_differing(&expected, &without_casters) > 100);
}

/// Constants and structs that passes, lookup and backend share.
#[test]
fn shared_constants_are_equal() {
    let world = World::new("cubes");
    let set = world.set();
    let frame = world.frame_without_triangles();
    let view = set.view(&frame, &world.scene.lights[0]);
    let made = Exact::default().device_recipe(&view, None);
    let made = made.expect("a hierarchy").expect("serves the light");
    let lookup = join(&made.receive.kernel.modules());
    let passes = join(&made.hierarchy.expect("is built").modules);
    check(&LightView::layout(), &passes).expect("equal");
    let constant = |text: &str, name: &str| -> f64 {
        let (_, rest) = text
            .split_once(&format!("const {name} = "))
            .unwrap_or_else(|| panic!("no constant {name}"));
        let (value, _) = rest.split_once(';').expect("ends");
        value.trim_end_matches('u').parse().expect("a number")
    };
    for name in ["FACE_STEP", "TEST_ERROR", "HEADER"] {
        assert_eq!(constant(&passes, name), constant(&lookup, name), "{name}");
    }
    let most_error = constant(&lookup, "TEST_ERROR") / constant(&lookup, "LEAST_HIT");
    assert!((constant(&passes, "MOST_LOOKUP_ERROR") - most_error).abs() < 1e-6);
    let levels = DeviceHierarchy::LEVELS;
    assert_eq!(
        constant(&passes, "HEADER"),
        f64::from(DeviceHierarchy::HEADER)
    );
    assert_eq!(constant(&lookup, "MOST_LEVELS"), levels as f64);
    assert!(passes.contains(&format!("firsts: array<vec4u, {}>", levels / 4)));
    let head = constant(&passes, "MORE_PIECES") + constant(&passes, "STEPS");
    assert!(head <= DeviceHierarchy::HEAD as f64);
}

/// A light that is off keeps its hierarchy, which is rebuilt when it is switched on.
#[test]
fn hierarchies_of_lights_that_are_off_are_not_rebuilt() {
    let world = World::new("figure");
    let mut set = world.set();
    let frame = world.frame_without_triangles();
    let light = world.scene.lights[0];
    let everything = world.geometry.caster_bounds();
    let ids = [0; 2].map(|_| set.add_light(exact(light)).expect("valid"));
    let text = set.text_with(&frame, &[]).expect("supported");
    let update = |set: &mut LightSet| {
        world.program.update(set, &frame);
        set.report().hierarchies
    };
    let mut forward = Forward::default();
    assert_eq!(update(&mut set), 2);
    assert!(set.wgsl() == text.wgsl && set.wgsl_revision() == text.revision);
    let shadowed = mask(&world, &set, ids[1], &mut forward);
    set.set_enabled(ids[1], false).expect("is there");
    for _ in 0..2 {
        set.touch(&everything).expect("finite");
        assert_eq!(update(&mut set), 1);
        assert!(
            mask(&world, &set, ids[1], &mut forward)
                .iter()
                .all(|&lit| lit == 1.0)
        );
        assert_eq!(mask(&world, &set, ids[0], &mut forward), shadowed);
    }
    set.set_enabled(ids[1], true).expect("is there");
    assert_eq!(update(&mut set), 1);
    assert_eq!(mask(&world, &set, ids[1], &mut forward), shadowed);
    assert_eq!(update(&mut set), 0);
}

/// Frames in which only lights go, or are switched on, create objects within error scopes: otherwise
/// the set panics in tests.
#[test]
fn objects_are_created_within_error_scopes() {
    let mut stage = Stage::new(SetBudget::default(), &[0.0]);
    let [first, second, third] =
        [-0.2, 0.0, 0.2].map(|x| stage.set.add_light(exact(spot(x))).expect("valid"));
    stage.frame();
    stage.set.set_enabled(second, false).expect("is there");
    stage.frame();
    // The tables of the others move.
    stage.set.remove_light(first).expect("is there");
    stage.frame();
    stage.set.set_enabled(second, true).expect("is there");
    stage.frame();
    let shadowed = [second, third].map(|id| stage.shadowed_pixels(id));
    assert!(shadowed.iter().all(|&count| count > 0), "{shadowed:?}");
}

/// Meshes that compute shaders can't read leave the light without shadows, with a reason that names
/// the mesh.
#[test]
fn buffers_without_the_usage_are_named() {
    let mut stage = Stage::new(SetBudget::default(), &[]);
    let corners = [[-0.5, 0.0, -0.5], [0.5, 0.0, -0.5], [0.0, 0.0, 0.5]];
    let d = stage.program.d;
    foreign::add_triangle(d, &mut stage.set, BufferUsages::VERTEX, corners);
    let id = stage.set.add_light(exact(spot(0.0))).expect("valid");
    stage.frame();
    let unserved: Vec<_> = stage.set.unserved_lights().collect();
    let [(of, Unserved::Refused(why))] = &unserved[..] else {
        panic!("{unserved:?}");
    };
    assert_eq!(*of, id);
    let why = why.to_string();
    assert!(
        why.contains("`triangle`") && why.contains("STORAGE"),
        "{why}"
    );
}
