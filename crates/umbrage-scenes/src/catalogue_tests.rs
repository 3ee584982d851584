use super::*;
use std::collections::HashSet;
use umbrage_core::depth_range::{Pyramid, depth_range};
use umbrage_core::{Camera, Geometry};

/// The nearest and farthest thing in the picture.
fn seen(camera: &Camera, triangles: impl Iterator<Item = [umbrage_core::glam::Vec3; 3]>) -> Option<[f32; 2]> {
    let space = camera.space();
    let tangents = [0, 1].map(|i| 1.0 / f64::from(space.clip_from_view.col(i)[i]));
    depth_range(&Pyramid { view_from_world: space.view_from_world, tangents }, triangles)
}

#[test]
fn names_are_unique_and_fit_for_a_command_line() {
    let mut names = HashSet::new();
    for entry in all() {
        assert!(names.insert(entry.name), "{} twice", entry.name);
        assert!(
            entry.name.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'-'),
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
        assert!(!scene.lights.is_empty() && scene.cameras.len() == 1, "{}", entry.name);
        let geometry = Geometry::bake(&scene).unwrap();
        let all_triangles = (0..geometry.triangles().len() as u32).map(|t| geometry.corners(t));
        let shows = seen(&scene.cameras[0], all_triangles).is_some();
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
    assert_eq!(found, HashSet::from([1, 3, 4, 20, 24, 27, 28, 29, 30]));
    let nothing = all().iter().filter(|entry| entry.kind == Kind::Failure(Failure::Nothing));
    assert_eq!(nothing.count(), 3);
}

#[test]
fn speed_scenes_are_as_big_as_they_say() {
    for (name, least, most) in [
        ("hall", 56_000, 58_000),
        ("statue", 69_000, 70_000),
        ("town", 120_000, 123_000),
        ("terrain", 1_000_000, 1_010_000),
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
        [geometry.casters().is_empty(), geometry.receivers().is_empty()]
    };
    assert_eq!(roles("no-casters"), [true, false]);
    assert_eq!(roles("no-receivers"), [false, true]);
    assert_eq!(roles("cubes"), [false, false]);
}

#[test]
fn the_tower_is_out_of_view_and_its_shadow_is_in_view() {
    let scene = (find("tower-out-of-view").unwrap().build)();
    let geometry = Geometry::bake(&scene).unwrap();
    let is_tower = |t: &u32| geometry.corners(*t).iter().any(|p| p.y > 0.0 || p.x == -11.0);
    let camera = &scene.cameras[0];
    let tower: Vec<_> = geometry.casters().filter(is_tower).map(|t| geometry.corners(t)).collect();
    assert_eq!(tower.len(), 12);
    assert_eq!(seen(camera, tower.into_iter()), None);
    let to_light = scene.lights[0].direction_from(camera.eye()) * 100.0;
    let p = umbrage_core::glam::Vec3::new(0.0, 1e-3, 0.5);
    assert!(geometry.bvh().occluded(p, to_light, u32::MAX), "no shadow in the middle of the picture");
}

#[test]
fn scaled_cubes_are_the_cubes_scaled() {
    let corner = |name: &str, scale: f32| {
        let scene = (find(name).unwrap().build)();
        let geometry = Geometry::bake(&scene).unwrap();
        let camera = scene.cameras[0];
        (geometry.positions().iter().map(|p| *p / scale).collect::<Vec<_>>(), camera.eye() / scale)
    };
    let (plain, eye) = corner("cubes", 1.0);
    for (name, scale) in [("cubes-tiny", 1e-3), ("cubes-huge", 1e4)] {
        let (scaled, scaled_eye) = corner(name, scale);
        // A few roundings of 32-bit floats at up to 25 m.
        assert!(plain.iter().zip(&scaled).all(|(a, b)| a.distance(*b) < 1e-5) && eye.distance(scaled_eye) < 1e-5);
    }
}
