use super::*;
use crate::{
    SceneError,
    primitives::{block, icosphere, quad},
};
use umbrage_core::Mesh;

fn place() -> Place {
    Place {
        file: "model.obj".to_owned(),
        line: None,
        key: None,
    }
}

/// Returns the completed scene of a lone model.
fn first_picture(meshes: Vec<Mesh>) -> Result<Scene, SceneError> {
    let instances = (0..meshes.len()).map(|mesh| Instance::new(mesh, Affine3A::IDENTITY));
    let mut scene = Scene {
        name: "model".to_owned(),
        instances: instances.collect(),
        meshes,
        ..Scene::default()
    };
    let geometry = Geometry::bake(&scene).expect("valid");
    complete(&mut scene, &geometry, &place())?;
    scene.validate().expect("valid");
    Ok(scene)
}

fn scale_mesh(mut mesh: Mesh, scale: f32, offset: f32) -> Mesh {
    for p in &mut mesh.positions {
        *p = *p * scale + offset;
    }
    mesh
}

fn turned_inside_out(mut mesh: Mesh) -> Mesh {
    mesh.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    mesh
}

fn way_of_light(scene: &Scene) -> Vec3 {
    match scene.lights[0] {
        Light::Directional { direction, .. } => direction,
        ref other => panic!("a sun: {other:?}"),
    }
}

fn has_floor(scene: &Scene) -> bool {
    scene.meshes.iter().any(|mesh| mesh.name == "floor")
}

/// Returns the positions of points in the image, -1 to 1.
fn in_picture(scene: &Scene, points: impl Iterator<Item = Vec3>) -> Vec<Vec3> {
    let clip_from_world = scene.cameras[0].space().clip_from_world();
    points.map(|p| clip_from_world.project_point3(p)).collect()
}

#[test]
fn a_solid_of_any_size_stands_on_a_floor_with_its_shadow_in_view() {
    for (scale, offset) in [(1.0, 0.0), (1e-3, 0.0), (1e4, 5e3), (1.0, 500.0)] {
        for mesh in [block(Vec3::ZERO, Vec3::ONE), icosphere(Vec3::ONE, 1.0, 3)] {
            let mesh = scale_mesh(mesh, scale, offset);
            let lowest = mesh
                .positions
                .iter()
                .map(|p| p.y)
                .fold(f32::INFINITY, f32::min);
            let scene = first_picture(vec![mesh.clone()]).expect("of a good size");
            assert!(has_floor(&scene), "{scale}");
            let floor = &scene.meshes[1];
            let height = floor.positions[0].y;
            assert!(
                height <= lowest && height > lowest - 0.01 * scale,
                "{height}: {lowest}"
            );
            let light = way_of_light(&scene);
            let points = mesh.positions.iter().copied();
            let shadows = points
                .clone()
                .map(|p| p + light * ((height - p.y) / light.y));
            for p in in_picture(&scene, points.chain(shadows)) {
                assert!(p.truncate().abs().max_element() < 0.95, "{scale}: {p}");
                assert!(p.z > 0.0 && p.z < 1.0, "{scale}: {p}");
            }
            // The floor continues behind the model and doesn't cast.
            assert!(!scene.instances[1].casts && scene.instances[1].receives);
            let geometry = Geometry::bake(&scene).expect("valid");
            assert_eq!(geometry.casters().len(), mesh.triangles.len());
        }
    }
}

#[test]
fn shadows_fall_to_the_right_and_towards_the_eye() {
    let scene = first_picture(vec![block(Vec3::ZERO, Vec3::ONE)]).expect("of a good size");
    let camera = &scene.cameras[0];
    let light = way_of_light(&scene);
    let in_view = camera.world_from_view.inverse().transform_vector3(light);
    assert!(in_view.x > 0.0 && light.y < 0.0);
    let to_eye = Vec3::from(camera.world_from_view.translation).with_y(0.0);
    assert!(light.dot(to_eye) > 0.0);
}

#[test]
fn ground_of_ones_own_is_enough() {
    let ground = quad([
        Vec3::new(-2.0, 0.0, 2.0),
        Vec3::new(2.0, 0.0, 2.0),
        Vec3::new(2.0, 0.0, -2.0),
        Vec3::new(-2.0, 0.0, -2.0),
    ]);
    let with_block = vec![ground.clone(), block(Vec3::ZERO, Vec3::ONE)];
    assert!(!has_floor(
        &first_picture(with_block).expect("of a good size")
    ));
    // From below, it is no ground.
    let ceiling = vec![turned_inside_out(ground), block(Vec3::ZERO, Vec3::ONE)];
    assert!(has_floor(&first_picture(ceiling).expect("of a good size")));
    // A landscape faces up at all heights.
    let slope = quad([
        Vec3::new(-2.0, 0.0, 2.0),
        Vec3::new(2.0, 0.0, 2.0),
        Vec3::new(2.0, 3.0, -2.0),
        Vec3::new(-2.0, 3.0, -2.0),
    ]);
    assert!(!has_floor(
        &first_picture(vec![slope]).expect("of a good size")
    ));
}

/// Reports whether the eye is within the model's bounds.
fn is_inside(scene: &Scene, bounds: umbrage_core::Aabb) -> bool {
    let eye = Vec3::from(scene.cameras[0].world_from_view.translation);
    eye.cmpgt(bounds.min).all() && eye.cmplt(bounds.max).all()
}

#[test]
fn rooms_are_seen_from_inside_open_ones_through_their_opening_and_bowls_from_outside() {
    let size = Vec3::new(8.0, 3.0, 5.0);
    let closed = turned_inside_out(block(Vec3::ZERO, size));
    let bounds = umbrage_core::Aabb::from_points(closed.positions.iter().copied());
    let room = first_picture(vec![closed.clone()]).expect("of a good size");
    assert!(is_inside(&room, bounds) && !has_floor(&room));
    let mut open = closed.clone();
    let is_front = |t: &[u32; 3]| t.iter().all(|&v| closed.positions[v as usize].z == size.z);
    open.triangles.retain(|t| !is_front(t));
    let seen = first_picture(vec![open]).expect("of a good size");
    let eye = Vec3::from(seen.cameras[0].world_from_view.translation);
    assert!(eye.z > size.z && !has_floor(&seen), "{eye}");
    // An outer surface around it turns it into a bowl.
    let outer = block(Vec3::splat(-0.3), size + 0.3);
    let bowl = first_picture(vec![closed, outer]).expect("of a good size");
    assert!(!is_inside(&bowl, bounds));
}

/// Only a high sun shines into a room with a hole in its roof.
#[test]
fn the_sun_shines_where_it_is_seen() {
    let size = Vec3::new(4.0, 3.0, 4.0);
    let mut room = turned_inside_out(block(Vec3::ZERO, size));
    let corners = room.positions.clone();
    room.triangles
        .retain(|t| !t.iter().all(|&v| corners[v as usize].y == size.y));
    let scene = first_picture(vec![room]).expect("of a good size");
    let geometry = Geometry::bake(&scene).expect("valid");
    let camera = &scene.cameras[0];
    let eye = Vec3::from(camera.world_from_view.translation);
    let ahead = camera.world_from_view.transform_vector3(Vec3::NEG_Z);
    let shot = Shot {
        eye,
        target: eye + ahead,
        up: Vec3::Y,
        fov_y: FOV_Y_DEGREES.to_radians(),
        size: SIZE,
    };
    let light = way_of_light(&scene);
    let seen = sun::seen_points(&geometry, &shot);
    assert!(seen.len() > 100);
    let chosen = sun::score(&geometry, &seen, light);
    let level = sun::score(&geometry, &seen, Vec3::new(1.0, -0.1, 0.0));
    assert!(chosen > 0.1 && chosen > level, "{chosen}, {level}: {light}");
}

#[test]
fn what_32_bit_floats_cannot_hold_is_refused() {
    for scale in [1e-8, 1e10] {
        let mesh = scale_mesh(block(Vec3::ZERO, Vec3::ONE), scale, 0.0);
        let error = first_picture(vec![mesh]).expect_err("refused").to_string();
        assert!(error.contains("m across; scale it"), "{error}");
    }
}
