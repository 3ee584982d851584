//! Tests of hierarchies that a device builds, against rays.

use super::alike::{World, count_differing};
use glam::{Vec2, Vec3};
use proptest::{prelude::*, test_runner::RngSeed};
use std::sync::Arc;
use umbrage_core::{
    Backend, Kernel, Light, NO_TRIANGLE, Scene, ShadowTechnique, Uniforms,
    light_sample::{LightSampler, ray_origin, segment},
    math::dot3,
};
use umbrage_techniques::{Exact, ExactUniforms};
use umbrage_tests::{
    driver_model::{is_chosen, nth_case},
    gpu::gpu,
    light_program::Forward,
    light_stage::{Stage, spot},
    random_scene,
};
use umbrage_wgpu::{LightId, LightSet, SetBudget, SetFrame, ShadowedLight, Unserved};

/// Scenes with suns and point lights, with closed and open casters, some with a light among the
/// casters, and some of real size.
const SCENES: [&str; 12] = [
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
];

fn exact(light: Light) -> ShadowedLight {
    ShadowedLight {
        light,
        technique: Arc::new(Exact::default()),
        priority: 1.0,
    }
}

impl World {
    /// A frame of a program without triangles on the CPU.
    fn frame_without_triangles(&self) -> SetFrame<'_> {
        SetFrame {
            camera: &self.scene.cameras[0],
            geometry: None,
        }
    }

    /// Returns the visibility by rays for a light of a set, from each receiver's offset position in
    /// the set's kernel.
    fn trace_mask(&self, set: &LightSet, light: &Light) -> Vec<f32> {
        self.answers(set, light, true)
    }

    /// Returns the visibility by rays, with or without casters.
    fn answers(&self, set: &LightSet, light: &Light, casters_count: bool) -> Vec<f32> {
        let camera = &self.scene.cameras[0];
        let view = set.view(&self.frame_without_triangles(), light);
        let made = Exact::default().device_recipe(&view).expect("a hierarchy");
        let recipe = made.expect("serves the light").recipe;
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
fn mask(world: &World, set: &LightSet, id: LightId) -> Vec<f32> {
    let index = set.index_of(id).expect("is there");
    Forward::default().mask(&world.program, set, index)
}

/// Returns the number of receivers at which rays differ, and the number in shadow.
fn compare(world: &World, set: &mut LightSet, light: Light) -> [usize; 2] {
    let id = set.add_light(exact(light)).expect("valid");
    world.program.update(set, &world.frame_without_triangles());
    let unserved: Vec<_> = set.unserved_lights().collect();
    assert!(unserved.is_empty(), "{unserved:?}");
    let found = mask(world, set, id);
    let expected = world.trace_mask(set, &light);
    set.remove_light(id).expect("is there");
    let shadowed = expected.iter().filter(|&&v| v < 1.0).count();
    [count_differing(&found, &expected), shadowed]
}

/// Returns the allowed number of differences: none on drivers that round like the CPU; on others, a
/// few rays that hit an edge.
fn allowed_pixels(pixels: usize) -> usize {
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
        let mut set = world.set();
        for &light in &world.scene.lights {
            let [wrong, shadowed] = compare(&world, &mut set, light);
            assert!(
                wrong <= allowed_pixels(world.receivers.len()),
                "{name}: {wrong}"
            );
            assert!(shadowed > 100, "{name}: only {shadowed} in shadow");
        }
    }
}

/// Random scenes with one light each.
#[test]
fn random_scenes_answer_as_rays_do() {
    let config = ProptestConfig {
        cases: 75 / nth_case() as u32,
        max_shrink_iters: 100,
        rng_seed: RngSeed::Fixed(11),
        failure_persistence: None,
        ..ProptestConfig::default()
    };
    let in_shadow = std::cell::Cell::new(0);
    proptest!(config, |(scene in random_scene::scenes())| {
        let Some(world) = world_of(scene) else {
            return Ok(());
        };
        let mut set = world.set();
        let [wrong, shadowed] = compare(&world, &mut set, world.scene.lights[0]);
        prop_assert!(wrong <= allowed_pixels(world.receivers.len()), "{} pixels", wrong);
        in_shadow.set(in_shadow.get() + shadowed);
    });
    let in_shadow = in_shadow.get();
    let least = 25_000 / nth_case();
    assert!(in_shadow > least, "only {in_shadow} in shadow");
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
    let found = mask(&world, &set, id);
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
        let mut set = world.set();
        let light = world.scene.lights[0];
        set.limit_references(Some(0));
        let [wrong, shadowed] = compare(&world, &mut set, light);
        assert!(
            wrong <= allowed_pixels(world.receivers.len()),
            "{name}: {wrong}"
        );
        assert!(shadowed > 100, "{name}: only {shadowed} in shadow");
    }
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
    assert_eq!(update(&mut set), 2);
    assert!(set.wgsl() == text.wgsl && set.wgsl_revision() == text.revision);
    let shadowed = mask(&world, &set, ids[1]);
    set.set_enabled(ids[1], false).expect("is there");
    for _ in 0..2 {
        set.touch(&everything).expect("finite");
        assert_eq!(update(&mut set), 1);
        assert!(mask(&world, &set, ids[1]).iter().all(|&lit| lit == 1.0));
        assert_eq!(mask(&world, &set, ids[0]), shadowed);
    }
    set.set_enabled(ids[1], true).expect("is there");
    assert_eq!(update(&mut set), 1);
    assert_eq!(mask(&world, &set, ids[1]), shadowed);
    assert_eq!(update(&mut set), 0);
}

/// Meshes that compute shaders can't read leave the light without shadows, with a reason that names
/// the mesh.
#[test]
fn buffers_without_the_usage_are_named() {
    let mut stage = Stage::new(SetBudget::default(), &[0.0]);
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
