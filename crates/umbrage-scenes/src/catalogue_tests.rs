use super::*;
use std::collections::HashSet;
use umbrage_core::depth_range::{ViewPyramid, depth_range};
use umbrage_core::glam::Vec3;
use umbrage_core::{Aabb, Camera, Geometry, Instance, Mesh};

/// Returns the least and greatest distance in the image.
fn seen_depths(camera: &Camera, triangles: impl Iterator<Item = [Vec3; 3]>) -> Option<[f32; 2]> {
    let space = camera.space();
    let tangents = [0, 1].map(|i| 1.0 / f64::from(space.clip_from_view.col(i)[i]));
    depth_range(
        &ViewPyramid {
            view_from_world: space.view_from_world,
            tangents,
        },
        triangles,
    )
}

#[test]
fn names_are_unique_and_fit_for_a_command_line() {
    let mut names = HashSet::new();
    for entry in all() {
        assert!(names.insert(entry.name), "{} twice", entry.name);
        assert!(
            entry
                .name
                .bytes()
                .all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'-'),
            "{}",
            entry.name
        );
        assert!(!entry.summary.is_empty() && !entry.summary.contains('\n'));
        assert_eq!(find(entry.name).map(|found| found.name), Some(entry.name));
    }
    assert!(find("no-such-scene").is_none());
}

#[test]
fn every_scene_is_valid_and_shows_something() {
    for entry in all() {
        let scene = (entry.build)();
        assert_eq!(scene.name, entry.name);
        scene.validate().unwrap();
        assert!(
            !scene.lights.is_empty() && scene.cameras.len() == 1,
            "{}",
            entry.name
        );
        assert!(
            scene.instances.iter().all(|i| i.material.is_some()),
            "{}",
            entry.name
        );
        let geometry = Geometry::bake(&scene).unwrap();
        let all_triangles = (0..geometry.triangles().len() as u32).map(|t| geometry.corners(t));
        let shows = seen_depths(&scene.cameras[0], all_triangles).is_some();
        assert_eq!(shows, entry.name != "only-sky", "{}", entry.name);
    }
}

#[test]
fn scenes_come_out_the_same_each_time() {
    for entry in all().iter().filter(|entry| entry.name != "terrain") {
        assert_eq!((entry.build)(), (entry.build)(), "{}", entry.name);
    }
}

#[test]
fn the_suite_is_light() {
    for entry in all().iter().filter(|entry| entry.suite) {
        let scene = (entry.build)();
        let size = scene.cameras[0].size;
        assert!(size.x <= 640 && size.y <= 360, "{}: {size}", entry.name);
        let triangles = Geometry::bake(&scene).unwrap().triangles().len();
        assert!(triangles < 50_000, "{}: {triangles} triangles", entry.name);
    }
    assert!(!find("terrain").unwrap().suite);
}

#[test]
fn each_demanded_row_of_the_failures_is_there() {
    let rows = |entry: &SceneEntry| match entry.kind {
        Kind::Failure(failure) => Some(failure.row()),
        _ => None,
    };
    let found: HashSet<u8> = all().iter().filter_map(rows).collect();
    assert_eq!(
        found,
        HashSet::from([
            1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 14, 15, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27,
            28, 29, 30, 31, 32, 33, 34, 35, 39, 40
        ])
    );
    let nothing = all()
        .iter()
        .filter(|entry| entry.kind == Kind::Failure(Failure::Nothing));
    assert_eq!(nothing.count(), 3);
}

#[test]
fn speed_scenes_are_as_big_as_they_say() {
    for (name, least, most) in [
        ("hall", 56_000, 58_000),
        ("statue", 69_000, 70_000),
        ("town", 120_000, 123_000),
        ("terrain", 1_000_000, 1_010_000),
        ("ten-thousand-boxes", 120_000, 120_003),
    ] {
        let scene = (find(name).unwrap().build)();
        let triangles = Geometry::bake(&scene).unwrap().casters().len();
        assert!((least..most).contains(&triangles), "{name}: {triangles}");
    }
}

#[test]
fn roles_are_as_named() {
    let roles = |name: &str| {
        let geometry = Geometry::bake(&(find(name).unwrap().build)()).unwrap();
        [
            geometry.casters().is_empty(),
            geometry.receivers().is_empty(),
        ]
    };
    assert_eq!(roles("no-casters"), [true, false]);
    assert_eq!(roles("no-receivers"), [false, true]);
    assert_eq!(roles("cubes"), [false, false]);
}

#[test]
fn the_tower_is_out_of_view_and_its_shadow_is_in_view() {
    let scene = (find("tower-out-of-view").unwrap().build)();
    let geometry = Geometry::bake(&scene).unwrap();
    let is_tower = |t: &u32| {
        geometry
            .corners(*t)
            .iter()
            .any(|p| p.y > 0.0 || p.x == -11.0)
    };
    let camera = &scene.cameras[0];
    let tower: Vec<_> = geometry
        .casters()
        .filter(is_tower)
        .map(|t| geometry.corners(t))
        .collect();
    assert_eq!(tower.len(), 12);
    assert_eq!(seen_depths(camera, tower.into_iter()), None);
    let to_light = scene.lights[0].direction_from(camera.eye()) * 100.0;
    let p = Vec3::new(0.0, 1e-3, 0.5);
    assert!(
        geometry.bvh().is_occluded(p, to_light, u32::MAX),
        "no shadow in the middle of the picture"
    );
}

#[test]
fn scaled_cubes_are_the_cubes_scaled() {
    let corner = |name: &str, scale: f32| {
        let scene = (find(name).unwrap().build)();
        let geometry = Geometry::bake(&scene).unwrap();
        let camera = scene.cameras[0];
        (
            geometry
                .positions()
                .iter()
                .map(|p| *p / scale)
                .collect::<Vec<_>>(),
            camera.eye() / scale,
        )
    };
    let (plain, eye) = corner("cubes", 1.0);
    for (name, scale) in [("cubes-tiny", 1e-3), ("cubes-huge", 1e4)] {
        let (scaled, scaled_eye) = corner(name, scale);
        // Allow a few roundings of 32-bit floats at up to 25 m.
        assert!(
            plain
                .iter()
                .zip(&scaled)
                .all(|(a, b)| a.distance(*b) < 1e-5)
                && eye.distance(scaled_eye) < 1e-5
        );
    }
}

fn build_scene(name: &str) -> (Scene, Geometry) {
    let scene = (find(name).unwrap().build)();
    let geometry = Geometry::bake(&scene).unwrap();
    (scene, geometry)
}

/// Returns the world-space positions of each copy of a mesh.
fn copies<'a>(scene: &'a Scene, geometry: &'a Geometry) -> impl Iterator<Item = Vec<Vec3>> + 'a {
    let mut next = 0;
    scene.instances.iter().map(move |instance| {
        let count = scene.meshes[instance.mesh].triangles.len() as u32;
        next += count;
        geometry.vertices_of(next - count..next).collect()
    })
}

#[test]
fn the_eye_is_in_an_umbra_whose_side_cuts_the_near_plane() {
    for name in ["eye-in-umbra", "eye-in-umbra-lamp"] {
        let (scene, geometry) = build_scene(name);
        let camera = &scene.cameras[0];
        let light = scene.lights[0];
        let is_dark = |p: Vec3| {
            geometry
                .bvh()
                .is_occluded(p, light.direction_from(p) * 100.0, u32::MAX)
        };
        let world_from_clip = camera.space().clip_from_world().inverse();
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        let near = corners.map(|(x, y)| world_from_clip.project_point3(Vec3::new(x, y, 0.0)));
        assert!(is_dark(camera.eye()), "{name}");
        // Check 10 cm along the view, and the corners against the aspect ratio.
        let along = (near[0] + near[2]) * 0.5 - camera.eye();
        assert!((along.length() - 0.1).abs() < 1e-4, "{name}: {along}");
        assert_eq!(
            near.map(is_dark).iter().filter(|d| **d).count(),
            2,
            "{name}"
        );
    }
}

/// Seen from the light, each caster crosses an edge of the cube.
#[test]
fn casters_in_the_room_stand_on_seams() {
    let (scene, geometry) = build_scene("lamp-in-room");
    let lamp = scene.lights[0].position().unwrap();
    let face = |p: &Vec3| {
        let d = *p - lamp;
        (d.abs().max_position(), d[d.abs().max_position()] > 0.0)
    };
    for (i, points) in copies(&scene, &geometry).enumerate() {
        let faces: HashSet<_> = points.iter().map(face).collect();
        assert!(faces.len() >= 2, "caster {i} is on {faces:?} alone");
    }
}

#[test]
fn flat_receivers_meet_casters_on_all_sides() {
    let (scene, geometry) = build_scene("flat-receivers");
    assert_eq!(geometry.casters().end, geometry.receivers().start);
    let lamp = scene.lights[0].position().unwrap();
    let around = |i: &Instance| Aabb::from_points(scene.meshes[i.mesh].positions.iter().copied());
    let casters: Vec<Aabb> = scene
        .instances
        .iter()
        .filter(|i| i.casts)
        .map(around)
        .collect();
    let has = |what: &str, is: fn(&Aabb, Vec3) -> bool| {
        assert!(casters.iter().any(|b| is(b, lamp)), "none {what}")
    };
    has("through the floor", |b, _| b.min.y < 0.0 && b.max.y > 0.0);
    has("below the floor", |b, _| b.max.y < 0.0);
    has("through the wall", |b, _| b.min.z < -2.5 && b.max.z > -2.5);
    has("above the lamp", |b, lamp| b.min.y > lamp.y);
    has("behind the lamp", |b, lamp| b.min.z > lamp.z);
}

/// Reports whether each directed edge, by position, has exactly one counterpart in the other
/// direction.
fn is_closed(mesh: &Mesh) -> bool {
    let key = |v: u32| {
        mesh.positions[v as usize]
            .to_array()
            .map(|x| (x + 0.0).to_bits())
    };
    let edges = mesh
        .triangles
        .iter()
        .flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])]);
    let edges: Vec<_> = edges.map(|(a, b)| (key(a), key(b))).collect();
    let count = |edge| edges.iter().filter(|e| **e == edge).count();
    edges
        .iter()
        .all(|&(a, b)| count((a, b)) == 1 && count((b, a)) == 1)
}

#[test]
fn broken_meshes_are_broken_each_in_its_way() {
    let (scene, _) = build_scene("broken-meshes");
    assert_eq!(scene.meshes.len(), 7);
    assert!(scene.meshes.iter().all(|mesh| !is_closed(mesh)));
    let (whole, _) = build_scene("c1-box-sun");
    assert!(is_closed(&whole.meshes[1]));
}

/// The wall's plane is z = 0; bricks are 25 mm in front of it, joints 25 mm behind.
#[test]
fn the_wall_is_displaced_and_the_flat_caster_is_not() {
    let depths = |vertices: &mut dyn Iterator<Item = Vec3>| {
        vertices
            .filter(|p| p.y > 2.2)
            .fold([f32::MAX, f32::MIN], |[a, b], p| [a.min(p.z), b.max(p.z)])
    };
    let near = |found: [f32; 2], [a, b]: [f32; 2]| {
        (found[0] - a).abs() < 1e-5 && (found[1] - b).abs() < 1e-5
    };
    let (_, relief) = build_scene("displaced-wall");
    assert!(near(
        depths(&mut relief.vertices_of(relief.casters())),
        [-0.025, 0.025]
    ));
    let (_, split) = build_scene("relief-without-depth-pass");
    assert!(near(
        depths(&mut split.vertices_of(split.casters())),
        [-0.03, -0.03]
    ));
    assert!(near(
        depths(&mut split.vertices_of(split.receivers())),
        [-0.025, 0.025]
    ));
}

/// Flat sheets have explicit tangents, which equal those of MikkTSpace.
#[test]
fn tangents_of_flat_walls_are_those_of_mikktspace() {
    let mut checked = 0;
    for name in ["normal-mapped-wall", "textbook-wall", "displaced-wall"] {
        for mesh in build_scene(name)
            .0
            .meshes
            .iter()
            .filter(|mesh| !mesh.tangents.is_empty())
        {
            let made = crate::with_tangents(&Mesh {
                tangents: Vec::new(),
                ..mesh.clone()
            })
            .unwrap();
            assert_eq!(made.positions.len(), mesh.positions.len(), "{name}");
            assert!(
                made.tangents
                    .iter()
                    .all(|t| t.distance(mesh.tangents[0]) < 1e-6),
                "{name}"
            );
            checked += 1;
        }
    }
    assert_eq!(checked, 3);
}
