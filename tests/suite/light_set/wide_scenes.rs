//! Tests of hierarchies that a device builds in scenes of extreme sizes, against rays.

use super::{
    alike::{World, count_differing},
    device_hierarchies::{allowed_pixels, exact, mask, with_comparison},
};
use glam::{Affine3A, UVec2, Vec3};
use umbrage_core::{Camera, Instance, Light, Mesh, Scene};
use umbrage_tests::light_program::Forward;
use umbrage_wgpu::LightSet;

/// Adds triangles to a scene, as casters that also receive.
fn add_triangles(scene: &mut Scene, triangles: &[[Vec3; 3]]) {
    let corners = triangles.as_flattened().to_vec();
    let ids = (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
    let mesh = Mesh::new("added", corners, ids.collect()).expect("valid");
    let instance = Instance::new(scene.meshes.len(), Affine3A::IDENTITY);
    scene.meshes.push(mesh);
    scene.instances.push(instance);
}

/// A triangle over everything puts everything in shadow, and one below everything changes nothing.
#[test]
fn casters_that_cover_everything_answer_as_rays_do() {
    for name in ["cubes", "teapot-lamp"] {
        let [below, above] = [-1e3, 9.0].map(|height| {
            let mut world = World::new(name);
            let corners = [(-1e4, -1e4), (1e4, -1e4), (0.0, 2e4)];
            let triangle = corners.map(|(x, z)| Vec3::new(x, height, z));
            add_triangles(&mut world.scene, &[triangle]);
            if let Some(lamp) = world.scene.lights[0].position() {
                world.scene.lights[0] = Light::Point {
                    position: Vec3::new(lamp.x, 10.0, lamp.z),
                    radius: 0.0,
                };
            }
            let world = World::of_scene(world.scene);
            with_comparison(|comparison| comparison.check(&world, name))
        });
        assert!(above > 4 * below, "{name}: {below} of {above}");
    }
}

/// Returns a generator of numbers from -1 to 1: Numerical Recipes' (Press and others 1992).
fn randoms(mut seed: u32) -> impl FnMut() -> f32 {
    move || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (seed >> 8) as f32 / (1 << 23) as f32 - 1.0
    }
}

/// Returns small casters close around a point light, some of them slivers along its rays. A third is
/// at the border between the faces towards +x and -y, and a third at a corner of three faces.
fn casters_around(lamp: Vec3) -> Vec<[Vec3; 3]> {
    let mut random = randoms(7);
    let mut vector = || Vec3::new(random(), random(), random());
    let mut triangles = Vec::new();
    for i in 0..900 {
        let v = vector();
        let (direction, size) = match i % 3 {
            0 => (Vec3::new(1.0, -1.0, 0.001 * v.z), 2e-4),
            1 => (Vec3::new(-1.0, -1.0, 1.0) + 0.001 * v, 2e-4),
            _ => (Vec3::new(v.x, -v.y.abs(), v.z).normalize(), 0.05),
        };
        let at = lamp + direction * (1.0 + 0.5 * vector().x);
        let mut corners = [0; 3].map(|_| at + size * vector());
        if i % 4 == 0 {
            // A sliver.
            corners[1] = at + (at - lamp) * 0.2;
            corners[2] = at + (at - lamp) * 0.1 + 1e-3 * vector();
        }
        triangles.push(corners);
    }
    triangles
}

/// Small casters close around a point light, high above ground of 20 km. Receivers are so far away
/// that hits round to a part of a caster's width, and across the border of a face.
#[test]
fn casters_around_a_lamp_over_wide_ground_answer_as_rays_do() {
    let lamp = Vec3::new(0.3, 3e3, -0.2);
    let mut triangles = casters_around(lamp);
    triangles.push([(-1e4, -1e4), (1e4, -1e4), (0.0, 2e4)].map(|(x, z)| Vec3::new(x, 0.0, z)));
    let mut scene = World::new("cubes").scene;
    scene.meshes.clear();
    scene.instances.clear();
    add_triangles(&mut scene, &triangles);
    let point = Light::Point {
        position: lamp,
        radius: 0.0,
    };
    let camera = |eye: Vec3, target: Vec3, fov: f32, size: UVec2| {
        Camera::perspective(eye, target, Vec3::Z, fov, [100.0, 2e4], size).expect("valid")
    };
    let above = Vec3::new(0.0, 5e3, 2e3);
    let wide = camera(above, Vec3::ZERO, 1.2, UVec2::new(320, 240));
    // Small images, since each of their rays may hit hundreds of casters.
    let [at_border, at_corner] = [(1.0, 0.0), (-1.0, 1.0)].map(|(x, z)| {
        let target = lamp + 3e3 * Vec3::new(x, -1.0, z);
        camera(lamp + 50.0 * Vec3::Z, target, 0.002, UVec2::new(60, 45))
    });
    let spot = Light::Spot {
        position: lamp,
        direction: Vec3::NEG_Y,
        inner: 1.2,
        outer: 1.3,
        radius: 0.0,
    };
    for (camera, light, most) in [
        (wide, point, None),
        (wide, spot, None),
        (wide, point, Some(0)),
        (at_border, point, None),
        (at_border, point, Some(0)),
        (at_corner, point, None),
    ] {
        scene.cameras[0] = camera;
        scene.lights[0] = light;
        let world = World::of_size(scene.clone(), camera.size);
        let shadowed = with_comparison(|comparison| {
            comparison.set.limit_references(most);
            comparison.check(&world, light.kind())
        });
        let seen = world.receivers.len();
        assert!(
            shadowed > seen / 100 && shadowed < seen / 2,
            "{shadowed} of {seen}"
        );
    }
}

/// Small triangles within a 16,384th of a light's view, between two that are a kilometre apart, if
/// there are more than two. Many keys are equal.
fn crowd(count: usize) -> World {
    let far: &[f32] = if count > 2 { &[-500.0, 500.0] } else { &[] };
    let near = count - far.len();
    let mut generator = randoms(1);
    let mut random = || 0.5 * generator();
    // About half of the crowd's ground is in shadow.
    let size = 0.05 / (count as f32).sqrt();
    let mut triangles: Vec<[Vec3; 3]> = (0..near)
        .map(|_| {
            let at = Vec3::new(0.04 * random(), 0.1 + 0.1 * random(), 0.04 * random());
            [0; 3].map(|_| at + size * Vec3::new(random(), random(), random()) * 2.0)
        })
        .collect();
    for &x in far {
        triangles.push([0.0, 1.0, 2.0].map(|z| Vec3::new(x, 1.0, z)));
    }
    let mut world = World::new("cubes");
    let scene = &mut world.scene;
    scene.meshes.clear();
    scene.instances.clear();
    add_triangles(scene, &triangles);
    scene.instances[0].receives = false;
    let ground = [(-1.0, -1.0), (0.0, 1.0), (1.0, -1.0)].map(|(x, z)| Vec3::new(x, 0.0, z));
    add_triangles(scene, &[ground]);
    scene.instances[1].casts = false;
    scene.lights[0] = Light::Directional {
        direction: Vec3::new(0.1, -1.0, 0.05),
        angular_diameter: 0.0,
    };
    scene.cameras[0] = Camera::perspective(
        Vec3::new(0.0, 0.2, 0.1),
        Vec3::ZERO,
        Vec3::Y,
        0.4,
        [0.01, 10.0],
        scene.cameras[0].size,
    )
    .expect("valid");
    World::of_scene(world.scene)
}

/// The number of casters is 20,000, or that of the environment variable. Far more than a million
/// exceed the iterations of Mesa's lavapipe.
#[test]
fn crowds_of_casters_answer_as_rays_do() {
    let count = std::env::var("UMBRAGE_CROWD").ok();
    let count = count.map_or(20_000, |count| count.parse().expect("a number"));
    let world = crowd(count);
    let shadowed = with_comparison(|comparison| comparison.check(&world, "crowd"));
    assert!(shadowed > 100, "only {shadowed} in shadow");
}

/// Numbers of casters around those that fill nodes of eight children, and around those that need
/// another level. Levels depend on the capacity, which is twice the number of casters, rounded up.
#[test]
fn few_casters_answer_as_rays_do() {
    for count in [1, 2, 4, 5, 8, 9, 32, 33, 64, 65, 256, 257] {
        let world = crowd(count);
        let what = format!("{count} casters");
        let shadowed = with_comparison(|comparison| comparison.check(&world, &what));
        assert!(shadowed > 10, "{what}: only {shadowed} in shadow");
    }
}

/// Memory for many casters is freed when few remain, and the rest with the last light.
#[test]
fn memory_follows_the_number_of_casters() {
    let [many, few] = [20_000, 10].map(crowd);
    let mut set = many.empty_set();
    let light = set.add_light(exact(many.scene.lights[0])).expect("valid");
    let mut forward = Forward::default();
    let mut check_and_count_bytes = |set: &mut LightSet, world: &World| {
        world.program.update(set, &world.frame_without_triangles());
        let found = mask(world, set, light, &mut forward);
        let expected = world.trace_mask(set, &world.scene.lights[0]);
        let wrong = count_differing(&found, &expected);
        assert!(wrong <= allowed_pixels(world.receivers.len()), "{wrong}");
        set.table_bytes()
    };
    let casters = many.add_casters(&mut set);
    let before = check_and_count_bytes(&mut set, &many);
    assert!(before > 100 * 20_000, "{before} bytes");
    for (mesh, caster) in casters {
        set.remove_caster(caster).expect("is there");
        set.remove_mesh(mesh).expect("is there");
    }
    few.add_casters(&mut set);
    let after = check_and_count_bytes(&mut set, &few);
    assert!(after * 5 < before, "{after} bytes, {before} before");
    set.remove_light(light).expect("is there");
    few.program.update(&mut set, &few.frame_without_triangles());
    let rest = set.table_bytes();
    assert!(rest < after && rest <= 1 << 16, "{rest} bytes");
}

/// Plates along a kilometre of the sun's rays: positions round in proportion to the depth, which is
/// much greater than the width.
#[test]
fn casters_far_along_the_light_answer_as_rays_do() {
    let mut world = World::new("cubes");
    let scene = &mut world.scene;
    scene.meshes.clear();
    scene.instances.clear();
    let away = Vec3::new(0.31, -0.87, 0.23).normalize();
    let (across, down) = away.any_orthonormal_pair();
    let plate = |i: usize| {
        let centre = away * (5.0 * i as f32);
        // Small triangles with gaps of their size, and others in each plate.
        (0..200).map(move |j| {
            let angle = 0.7 * j as f32 + 0.013 * i as f32;
            let at = centre + (across * angle.cos() + down * angle.sin()) * (0.004 * j as f32);
            [at, at + across * 0.05, at + (down + away) * 0.05]
        })
    };
    let triangles: Vec<[Vec3; 3]> = (0..200).flat_map(plate).collect();
    add_triangles(scene, &triangles);
    scene.lights[0] = Light::Directional {
        direction: away,
        angular_diameter: 0.0,
    };
    let eye = away * 487.0 + across * 2.0;
    let near_far = [0.1, 100.0];
    let size = scene.cameras[0].size;
    let looks_at = away * 490.0;
    scene.cameras[0] =
        Camera::perspective(eye, looks_at, down, 0.8, near_far, size).expect("valid");
    let shadowed = {
        let world = World::of_scene(world.scene);
        with_comparison(|comparison| comparison.check(&world, "plates"))
    };
    assert!(shadowed > 100, "only {shadowed} in shadow");
}
