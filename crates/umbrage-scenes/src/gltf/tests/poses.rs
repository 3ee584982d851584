//! Morph targets, skins, instances, hidden nodes, and the notices of ignored contents.

use super::{
    model::{SQUARE, TestModel, U8, U16, words},
    scene_of,
};
use serde_json::json;
use umbrage_core::Scene;
use umbrage_core::glam::{Vec3, Vec3A};

/// Returns the world positions of each instance's first vertex.
fn first_corners(scene: &Scene) -> Vec<Vec3> {
    let corner = |instance: &umbrage_core::Instance| {
        let position = scene.meshes[instance.mesh].positions[0];
        instance.world_from_local.transform_point3(position)
    };
    scene.instances.iter().map(corner).collect()
}

fn assert_near(found: Vec3, expected: [f32; 3]) {
    let expected = Vec3::from_array(expected);
    assert!(found.distance(expected) < 1e-5, "{found}, not {expected}");
}

/// A square with a target that moves its corners by (0, 0, 4), and its normals from z to x.
pub(super) fn morphed() -> TestModel {
    let mut model = TestModel::new();
    let positions = model.floats("VEC3", 3, &SQUARE);
    let normals = model.floats("VEC3", 3, &[0.0, 0.0, 1.0].repeat(4));
    let indices = model.numbers(U16, "SCALAR", 6, &words(&[0, 1, 2, 2, 1, 3]));
    let moved = model.floats("VEC3", 3, &[0.0, 0.0, 4.0].repeat(4));
    let turned = model.floats("VEC3", 3, &[1.0, 0.0, -1.0].repeat(4));
    model.mesh(json!({
        "attributes": { "POSITION": positions, "NORMAL": normals }, "indices": indices,
        "targets": [{ "POSITION": moved, "NORMAL": turned }],
    }));
    model
}

#[test]
fn morph_targets_move_vertices_and_normals_by_their_weights() {
    let mut model = morphed();
    model.json["meshes"][0]["weights"] = json!([0.5]);
    model.node(json!({ "mesh": 0 }));
    model.node(json!({ "mesh": 0, "weights": [1.0] }));
    model.node(json!({ "mesh": 0, "weights": [0.0] }));
    model.node(json!({ "mesh": 0 }));
    let scene = scene_of(&model).expect("valid");
    let corners = first_corners(&scene);
    for (corner, z) in corners.into_iter().zip([2.0, 4.0, 0.0, 2.0]) {
        assert_near(corner, [-1.0, -1.0, z]);
    }
    let normal = |i: usize| scene.meshes[scene.instances[i].mesh].normals[0];
    assert_near(normal(0), [0.5, 0.0, 0.5]);
    assert_near(normal(1), [1.0, 0.0, 0.0]);
    // Nodes of equal weights share a mesh.
    assert_eq!(scene.meshes.len(), 3);
    assert_eq!(scene.instances[0].mesh, scene.instances[3].mesh);
    assert_eq!(scene.notices, [""; 0]);
}

#[test]
fn weights_out_of_range_are_refused() {
    let mut model = morphed();
    model.node(json!({ "mesh": 0, "weights": [3e38] }));
    let scene = scene_of(&model);
    let is_refused = match scene {
        Ok(scene) => umbrage_core::Geometry::bake(&scene).is_err(),
        Err(_) => true,
    };
    assert!(is_refused);
}

/// A square with two joints: the left corners follow the first, the right ones both.
pub(super) fn skinned() -> TestModel {
    let mut model = TestModel::new();
    let positions = model.floats("VEC3", 3, &SQUARE);
    let indices = model.numbers(U16, "SCALAR", 6, &words(&[0, 1, 2, 2, 1, 3]));
    let joints: Vec<u8> = [[0, 0, 0, 0], [0, 1, 0, 0]].repeat(2).concat();
    let joints = model.numbers(U8, "VEC4", 4, &joints);
    let weights = [[1.0, 0.0, 0.0, 0.0], [0.5, 0.5, 0.0, 0.0]]
        .repeat(2)
        .concat();
    let weights = model.floats("VEC4", 4, &weights);
    model.mesh(json!({
        "attributes": { "POSITION": positions, "JOINTS_0": joints, "WEIGHTS_0": weights },
        "indices": indices,
    }));
    // The bind pose of the first joint is at x = 1, that of the second at the origin.
    let matrix = |x: f32| {
        let mut matrix = [0.0; 16];
        for i in [0, 5, 10, 15] {
            matrix[i] = 1.0;
        }
        matrix[12] = x;
        matrix
    };
    let inverses = model.floats("MAT4", 16, &[matrix(-1.0), matrix(0.0)].concat());
    let first = model.node(json!({ "translation": [3, 0, 0] }));
    let second = model.node(json!({ "translation": [0, 0, 8] }));
    model.add(
        "skins",
        json!({ "joints": [first, second], "inverseBindMatrices": inverses }),
    );
    model
}

#[test]
fn skins_are_placed_by_their_joints_and_not_by_their_node() {
    let mut model = skinned();
    model.node(json!({ "mesh": 0, "skin": 0, "translation": [9, 9, 9], "scale": [0, 0, 0] }));
    let scene = scene_of(&model).expect("valid");
    assert_eq!(scene.instances.len(), 1);
    assert_eq!(scene.notices, [""; 0]);
    // Meshes without normals are flat, and have separate corners.
    let positions = &scene.meshes[0].positions;
    assert_near(positions[0], [1.0, -1.0, 0.0]);
    assert_near(positions[1], [2.0, -1.0, 4.0]);
    assert_near(positions[2], [1.0, 1.0, 0.0]);
}

#[test]
fn skins_with_a_missing_joint_are_noticed() {
    let mut model = skinned();
    model.node(json!({ "mesh": 0, "skin": 0, "translation": [9, 0, 0] }));
    model.json["scenes"][0]["nodes"] = json!([0, 2]);
    let scene = scene_of(&model).expect("valid");
    assert_near(first_corners(&scene)[0], [8.0, -1.0, 0.0]);
    assert_eq!(
        scene.notices,
        ["model.glb: skin 0 is ignored: a joint is not in the scene"]
    );
}

#[test]
fn damaged_skins_are_refused_by_name() {
    let mut model = skinned();
    model.node(json!({ "mesh": 0, "skin": 0 }));
    model.json["skins"][0]["joints"] = json!([0]);
    let message = scene_of(&model).expect_err("a joint too few");
    assert!(
        message.contains("its joints: name joint 1 of 1"),
        "{message}"
    );
    model.json["skins"][0]["joints"] = json!([0, 1, 0]);
    let message = scene_of(&model).expect_err("a matrix too few");
    assert!(
        message.contains("skin 0, accessor 4: has 2 matrices for 3 joints"),
        "{message}"
    );
}

#[test]
fn instances_of_a_node_are_placed_below_it() {
    let mut model = TestModel::square();
    let translations = model.floats("VEC3", 3, &[0.0, 0.0, 0.0, 0.0, 0.0, 5.0]);
    // A quarter turn about z.
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let turns = [[0.0, 0.0, 0.0, 1.0], [0.0, 0.0, half, half]].concat();
    let rotations = model.floats("VEC4", 4, &turns);
    let scales = model.floats("VEC3", 3, &[1.0, 1.0, 1.0, 2.0, 3.0, 1.0]);
    let attributes = json!({ "TRANSLATION": translations, "ROTATION": rotations, "SCALE": scales });
    model.json["nodes"][0] = json!({
        "mesh": 0, "translation": [10, 0, 0],
        "extensions": { "EXT_mesh_gpu_instancing": { "attributes": attributes } },
    });
    model.json["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing"]);
    model.json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    let scene = scene_of(&model).expect("valid");
    assert_eq!(scene.notices, [""; 0]);
    let [first, second] = first_corners(&scene)[..] else {
        panic!("two instances: {:?}", scene.instances);
    };
    assert_near(first, [9.0, -1.0, 0.0]);
    // (-1, -1) scaled to (-2, -3), turned to (3, -2).
    assert_near(second, [13.0, -2.0, 5.0]);
    // Counts must agree, and accessors must exist.
    let error = |accessor: usize| {
        let mut model = model.clone();
        let extensions = &mut model.json["nodes"][0]["extensions"];
        extensions["EXT_mesh_gpu_instancing"]["attributes"]["SCALE"] = json!(accessor);
        scene_of(&model).expect_err("damaged")
    };
    assert!(error(0).contains("has attributes of 2 and of 4 instances"));
    assert!(error(77).contains("EXT_mesh_gpu_instancing, SCALE: points to a missing element"));
}

#[test]
fn hidden_nodes_hide_all_nodes_below_them() {
    let mut model = TestModel::square();
    let hidden = json!({ "KHR_node_visibility": { "visible": false } });
    let shown = json!({ "KHR_node_visibility": { "visible": true } });
    let child = model.add("nodes", json!({ "mesh": 0, "extensions": shown.clone() }));
    model.node(json!({ "children": [child], "extensions": hidden.clone() }));
    model.node(json!({ "mesh": 0, "extensions": shown, "translation": [7, 0, 0] }));
    model.json["extensions"] =
        json!({ "KHR_lights_punctual": { "lights": [{ "type": "point" }] } });
    let mut light = hidden;
    light["KHR_lights_punctual"] = json!({ "light": 0 });
    model.node(json!({ "extensions": light }));
    let scene = scene_of(&model).expect("valid");
    let places: Vec<Vec3A> = scene
        .instances
        .iter()
        .map(|instance| instance.world_from_local.translation)
        .collect();
    assert_eq!(places, [Vec3A::ZERO, Vec3A::new(7.0, 0.0, 0.0)]);
    assert!(scene.lights.is_empty());
}

#[test]
fn features_that_are_left_aside_are_noticed_once_each() {
    let mut model = TestModel::square();
    let colors = model.floats("VEC3", 3, &SQUARE);
    let primitive = &mut model.json["meshes"][0]["primitives"];
    primitive[0]["attributes"]["COLOR_0"] = json!(colors);
    let mut lines = primitive[0].clone();
    lines["mode"] = json!(1);
    primitive.as_array_mut().expect("a list").push(lines);
    model.add(
        "materials",
        json!({ "occlusionTexture": { "index": 0 }, "emissiveTexture": { "index": 0 } }),
    );
    model.add("textures", json!({}));
    // The crate `gltf` refuses this animation.
    model.add(
        "animations",
        json!({
            "samplers": [{ "input": 0, "output": 0 }],
            "channels": [{ "sampler": 0, "target": { "path": "pointer" } }],
        }),
    );
    model.json["extensionsUsed"] =
        json!(["KHR_materials_sheen", "A_of_mine", "KHR_texture_transform"]);
    let scene = scene_of(&model).expect("valid");
    assert_eq!(scene.instances.len(), 1);
    assert_eq!(
        scene.notices,
        [
            "model.glb: animations are ignored (1): nodes keep their rest pose",
            "model.glb: points and lines are ignored (1 primitives)",
            "model.glb: vertex colours (COLOR_n) are ignored",
            "model.glb: textures are ignored of: occlusion, emission",
            "model.glb: extensions are ignored: A_of_mine, KHR_materials_sheen",
        ]
    );
}

#[test]
fn other_scenes_may_be_empty() {
    let mut model = TestModel::square();
    model.add("scenes", json!({ "name": "drafts" }));
    let scene = scene_of(&model).expect("valid");
    assert_eq!(scene.instances.len(), 1);
}
