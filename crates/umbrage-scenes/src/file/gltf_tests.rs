//! Tests of glTF files that scene files name. The files are made here.

use super::read;
use crate::gltf::tests::model::{PICTURE, SQUARE, TestModel};
use crate::{FilesInMemory, SceneError};
use serde_json::json;
use std::path::Path;
use umbrage_core::glam::{Affine3A, Mat3A, Vec2, Vec3, Vec3A};
use umbrage_core::{AlphaFilter, Geometry, Light, Scene, Texels};

const LIGHT: &str = "[[light]]\nkind = \"directional\"\ndirection = [0, -1, 0.5]\n";

/// Reads a scene file next to the model as `model.glb`, and as `model.gltf` with a separate buffer.
/// Both must result in the same scene.
fn scene_of(model: &TestModel, text: &str) -> Result<Scene, SceneError> {
    let in_one = files_with(model, text);
    let apart = files_with(model, &text.replace(".glb", ".gltf"));
    let read = |files: &FilesInMemory| read(Path::new("a/scene.toml"), files);
    let (in_one, apart) = (read(&in_one), read(&apart));
    match (&in_one, &apart) {
        (Ok(in_one), Ok(apart)) => {
            let renamed = |notice: &String| notice.replace(".gltf", ".glb");
            let apart = Scene {
                notices: apart.notices.iter().map(renamed).collect(),
                ..apart.clone()
            };
            assert_eq!(in_one, &apart);
        }
        (Err(in_one), Err(apart)) => {
            let apart = apart.to_string().replace(".gltf", ".glb");
            assert_eq!(in_one.to_string(), apart);
        }
        _ => panic!("as .glb: {in_one:?}, as .gltf: {apart:?}"),
    }
    in_one
}

fn files_with(model: &TestModel, text: &str) -> FilesInMemory {
    let apart = model.text(Some("bytes"));
    let parts: [(&str, Vec<u8>); 4] = [
        ("a/scene.toml", text.as_bytes().to_vec()),
        ("a/models/model.glb", model.glb()),
        ("a/models/model.gltf", apart.into_bytes()),
        ("a/models/bytes", model.bytes.clone()),
    ];
    parts.into_iter().collect()
}

fn object(rest: &str) -> String {
    format!("{LIGHT}[[object]]\nmesh = \"models/model.glb\"\n{rest}")
}

/// A square at the origin, the same mesh below a node that turns, moves and mirrors it, a hidden
/// one, a light and a camera. A second scene has one square far away.
fn rooms() -> TestModel {
    let mut model = TestModel::square();
    let child = model.add("nodes", json!({ "mesh": 0, "scale": [1, -2, 1] }));
    model.node(json!({
        "children": [child], "rotation": [0, 0.6, 0, 0.8], "translation": [1, 2, 3],
    }));
    model.node(json!({ "mesh": 0, "scale": [0, 0, 0] }));
    model.json["extensions"] =
        json!({ "KHR_lights_punctual": { "lights": [{ "type": "point" }] } });
    model.node(json!({ "extensions": { "KHR_lights_punctual": { "light": 0 } } }));
    model.add(
        "cameras",
        json!({ "type": "perspective", "perspective": { "yfov": 0.8, "znear": 0.1 } }),
    );
    model.node(json!({ "camera": 0 }));
    let far = model.add("nodes", json!({ "mesh": 0, "translation": [0, 0, 7] }));
    model.add("scenes", json!({ "name": "far", "nodes": [far] }));
    model
}

#[test]
fn all_meshes_of_a_model_are_placed_by_their_nodes_and_then_by_the_object() {
    let place = "scale = 2\nrotate_degrees = [0, 90, 0]\ntranslate = [10, 0, 0]";
    let scene = scene_of(&rooms(), &object(place)).expect("valid");
    // A quarter turn about y takes z to x and x to -z.
    let turned = Mat3A::from_cols(Vec3A::NEG_Z, Vec3A::Y, Vec3A::X);
    let object = Affine3A {
        matrix3: turned * 2.0,
        translation: Vec3A::X * 10.0,
    };
    // (0, 0.6, 0, 0.8) turns x to (0.28, 0, -0.96).
    let node = Affine3A {
        matrix3: Mat3A::from_cols(
            Vec3A::new(0.28, 0.0, -0.96),
            Vec3A::NEG_Y * 2.0,
            Vec3A::new(0.96, 0.0, 0.28),
        ),
        translation: Vec3A::new(1.0, 2.0, 3.0),
    };
    let expected = [object, object * node];
    assert_eq!(scene.instances.len(), expected.len());
    for (instance, expected) in scene.instances.iter().zip(expected) {
        let found = instance.world_from_local;
        assert!(
            found.abs_diff_eq(expected, 1e-5),
            "{found} instead of {expected}"
        );
    }
    // One mesh with two instances.
    let meshes: Vec<usize> = scene.instances.iter().map(|i| i.mesh).collect();
    assert_eq!((scene.meshes.len(), meshes), (1, vec![0, 0]));
}

#[test]
fn cameras_and_lights_of_a_model_are_left_aside() {
    let alone = crate::read("a/models/model.glb", &files_with(&rooms(), "")).expect("valid");
    assert!(matches!(alone.lights[..], [Light::Point { .. }]));
    let scene = scene_of(&rooms(), &object("")).expect("valid");
    assert!(matches!(scene.lights[..], [Light::Directional { .. }]));
    assert_eq!(scene.cameras.len(), 1);
    assert_ne!(scene.cameras[0], alone.cameras[0]);
    let what = "a/models/model.glb: cameras (1) and lights (1) are ignored: those of the scene file are used";
    assert_eq!(scene.notices, [what]);
    // Another look needs other vertices, and reads the model again.
    let own = object("") + "[[object]]\nmesh = \"models/model.glb\"\ncolor = [1, 0, 0]\n";
    assert_eq!(scene_of(&rooms(), &own).expect("valid").notices, [what]);
    let bare = scene_of(&TestModel::square(), &object("")).expect("valid");
    assert_eq!(bare.notices, [""; 0]);
    // Their errors don't count, either.
    let mut faulty = rooms();
    faulty.json["extensions"]["KHR_lights_punctual"]["lights"][0]["intensity"] = json!(-1);
    assert!(crate::read("a/models/model.glb", &files_with(&faulty, "")).is_err());
    assert_eq!(scene_of(&faulty, &object("")).expect("valid"), scene);
}

#[test]
fn a_model_is_read_as_it_is_alone() {
    let model = rooms();
    let alone = crate::read("a/models/model.glb", &files_with(&model, "")).expect("valid");
    let named = scene_of(&model, &object("")).expect("valid");
    assert_eq!(named.meshes[..], alone.meshes[..1]);
    assert_eq!(named.instances[..], alone.instances[..2]);
    // Expect the same triangles, bit for bit.
    let corners = |scene: &Scene| Geometry::bake(scene).expect("valid").positions().to_vec();
    assert_eq!(corners(&named), corners(&alone)[..corners(&named).len()]);
}

#[test]
fn another_scene_of_the_file_is_named_behind_its_path() {
    let text = |scene: &str| object("").replace("model.glb", &format!("model.glb#{scene}"));
    for which in ["far", "1"] {
        let scene = scene_of(&rooms(), &text(which)).expect("valid");
        let places: Vec<Affine3A> = scene.instances.iter().map(|i| i.world_from_local).collect();
        assert_eq!(places, [Affine3A::from_translation(Vec3::Z * 7.0)]);
    }
    let message = scene_of(&rooms(), &text("near"))
        .expect_err("none")
        .to_string();
    assert!(
        message.starts_with("a/scene.toml:5: `object.mesh`: a/models/model.glb: ")
            && message.contains("has no scene `near`"),
        "{message}"
    );
}

/// An alpha-tested square, and one of glass, with two sets of texture coordinates. The alpha test
/// uses the second set, moved.
fn leaves() -> TestModel {
    let mut model = TestModel::new();
    let positions = model.floats("VEC3", 3, &SQUARE);
    let first = model.floats("VEC2", 2, &[0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0]);
    let second = model.floats("VEC2", 2, &[0.5; 8]);
    let attributes = json!({ "POSITION": positions, "TEXCOORD_0": first, "TEXCOORD_1": second });
    for material in [0, 1] {
        model.mesh(json!({ "attributes": attributes, "mode": 5, "material": material }));
        model.node(json!({ "mesh": material }));
    }
    let moved = json!({ "KHR_texture_transform": { "offset": [0.25, 0] } });
    model.add("materials", json!({
        "alphaMode": "MASK", "alphaCutoff": 0.75,
        "pbrMetallicRoughness": { "baseColorTexture": { "index": 0, "texCoord": 1, "extensions": moved } },
    }));
    model.add(
        "materials",
        json!({ "alphaMode": "BLEND", "pbrMetallicRoughness": { "baseColorFactor": [1, 1, 1, 0.25] } }),
    );
    let view = model.view(PICTURE);
    model.add(
        "images",
        json!({ "bufferView": view, "mimeType": "image/png" }),
    );
    model.add("textures", json!({ "source": 0 }));
    model
}

#[test]
fn a_model_brings_its_looks_with_their_holes() {
    let text = object("[[object]]\nshape = \"box\"\ncolor = [0, 0, 1]\n");
    let scene = scene_of(&leaves(), &text).expect("valid");
    let [leaf, pane, block] = scene.instances[..] else {
        panic!("{:?}", scene.instances);
    };
    let material =
        |instance: umbrage_core::Instance| scene.materials[instance.material.expect("a material")];
    let holes = material(leaf).alpha.expect("holes");
    assert_eq!(holes.cutoff, 0.75);
    assert_eq!(
        scene.textures[holes.texture].texels,
        Texels::Srgb8(vec![[255; 4], [0; 4]].into()),
        "the picture's alpha"
    );
    let uvs = &scene.meshes[leaf.mesh].uvs;
    assert!(uvs.iter().all(|uv| *uv == Vec2::new(0.75, 0.5)), "{uvs:?}");
    let casts = [leaf.casts, pane.casts, block.casts];
    assert_eq!(casts, [true, false, true], "glass throws no shadow");
    assert_eq!(material(pane).alpha, None);
    assert_eq!(material(block).diffuse, Vec3::Z);
    // The object's keys apply to all parts, and add no shadow to glass.
    let without = scene_of(&leaves(), &object("casts = false\n")).expect("valid");
    assert!(without.instances.iter().all(|i| !i.casts && i.receives));
    let none_falls = scene_of(&leaves(), &object("casts = true\nreceives = false\n"));
    let of_both: Vec<_> = none_falls
        .expect("valid")
        .instances
        .iter()
        .map(|i| (i.casts, i.receives))
        .collect();
    assert_eq!(of_both, [(true, false), (false, false)]);
}

/// `alpha_filter` alone is no look: the model keeps its own looks and alpha tests, and another
/// object with the same model has those of the file.
#[test]
fn a_model_s_own_holes_may_be_hashed() {
    let plain = "[[object]]\nmesh = \"models/model.glb\"\n";
    let text = object(&format!(
        "alpha_filter = \"hashed\"\n{plain}{plain}alpha_filter = \"nearest\"\n{plain}alpha_filter = \"hashed\"\n"
    ));
    let scene = scene_of(&leaves(), &text).expect("valid");
    let alone = scene_of(&leaves(), &object("")).expect("valid");
    let materials: Vec<_> = scene.instances.iter().map(|i| i.material).collect();
    // The leaf and the pane of each object. Only one is hashed.
    let [leaf, pane] = [Some(0), Some(1)];
    let hashed = Some(2);
    assert_eq!(
        materials,
        [hashed, pane, leaf, pane, leaf, pane, hashed, pane]
    );
    assert_eq!(scene.materials[..2], alone.materials[..]);
    let mut expected = alone.materials[0];
    expected.alpha.as_mut().expect("holes").filter = AlphaFilter::Hashed;
    assert_eq!(scene.materials[2..], [expected]);
    assert!(!scene.instances[1].casts, "glass stays glass");
    // With other looks, the filter belongs to their own alpha map. It has no effect without an
    // alpha test.
    let message = |model: &TestModel, rest: &str| {
        let scene = scene_of(model, &object(rest));
        scene.expect_err("no holes").to_string()
    };
    let filter = "alpha_filter = \"hashed\"\n";
    let adjacent = message(&leaves(), &format!("{filter}color = [1, 0, 0]\n"));
    assert!(
        adjacent.contains("`object.alpha_filter`: has no effect without `alpha_map`"),
        "{adjacent}"
    );
    let whole = message(&TestModel::square(), filter);
    assert!(
        whole.contains("`object.alpha_filter`: is set, but the model has no alpha test"),
        "{whole}"
    );
    let unknown = message(&leaves(), "alpha_filter = \"blurred\"\n");
    assert!(unknown.contains("object.alpha_filter"), "{unknown}");
}

#[test]
fn an_object_with_a_look_of_its_own_wears_no_other() {
    let mut files = files_with(&leaves(), &object("alpha_map = \"own.png\"\n"));
    files.insert("a/own.png", PICTURE);
    let scene = read(Path::new("a/scene.toml"), &files).expect("valid");
    assert_eq!((scene.materials.len(), scene.textures.len()), (1, 1));
    for instance in &scene.instances {
        assert_eq!(instance.material, Some(0));
        assert!(instance.casts, "what is glass by the model isn't any more");
        let uvs = &scene.meshes[instance.mesh].uvs;
        assert_eq!(uvs[..2], [Vec2::new(0.0, 1.0), Vec2::new(1.0, 1.0)]);
    }
    // Errors of unused looks don't count.
    let mut blank = leaves();
    blank.json["images"] = json!([{ "uri": "nowhere.png" }]);
    let message = scene_of(&blank, &object(""))
        .expect_err("no mask")
        .to_string();
    assert!(
        message.contains("alpha mask: needs the texture"),
        "{message}"
    );
    scene_of(&blank, &object("color = [1, 0, 0]\n")).expect("valid");
    // A part that an alpha test removes completely is visible without it.
    let mut gone = leaves();
    gone.json["materials"][0] = json!({
        "alphaMode": "MASK", "pbrMetallicRoughness": { "baseColorFactor": [1, 1, 1, 0.25] },
    });
    assert_eq!(
        scene_of(&gone, &object("")).expect("valid").instances.len(),
        1
    );
    let colored = scene_of(&gone, &object("color = [1, 0, 0]\n")).expect("valid");
    assert_eq!(colored.instances.len(), 2);
}

#[test]
fn normal_maps_and_textures_need_coordinates_of_the_model() {
    let with = |model: &TestModel, look: &str| {
        let mut files = files_with(model, &object(look));
        files.insert("a/own.png", PICTURE);
        read(Path::new("a/scene.toml"), &files)
    };
    let scene = with(&leaves(), "normal_map = \"own.png\"\n").expect("valid");
    for mesh in &scene.meshes {
        assert_eq!(mesh.tangents.len(), mesh.positions.len());
    }
    let message = with(&rooms(), "texture = \"own.png\"\n")
        .expect_err("no coordinates")
        .to_string();
    assert!(
        message.starts_with("a/scene.toml:6: `object.texture`: needs texture coordinates")
            && message.ends_with("(`vt` lines of .obj files, TEXCOORD_0 of glTF)"),
        "{message}"
    );
}

#[test]
fn objects_that_name_one_model_share_its_meshes() {
    let twice = object("[[object]]\nmesh = \"models/model.glb\"\ntranslate = [9, 0, 0]\n");
    let scene = scene_of(&leaves(), &twice).expect("valid");
    assert_eq!((scene.instances.len(), scene.meshes.len()), (4, 2));
    assert_eq!((scene.materials.len(), scene.textures.len()), (2, 1));
}

#[test]
fn sizes_and_places_are_those_of_the_whole_model() {
    let far_apart = {
        let mut model = TestModel::square();
        model.node(json!({ "mesh": 0, "translation": [9e7, 0, 0] }));
        model
    };
    scene_of(&far_apart, &object("")).expect("valid");
    let message = |rest: &str| {
        let error = scene_of(&far_apart, &object(rest)).expect_err("too far");
        error.to_string()
    };
    let away = message("translate = [2e7, 0, 0]");
    assert!(
        away.starts_with("a/scene.toml:6: `object.translate`: puts the object 1.1"),
        "{away}"
    );
    let across = message("scale = 2");
    assert!(
        across.starts_with("a/scene.toml:6: `object.scale`: makes the object 1.8"),
        "{across}"
    );
}

#[test]
fn faults_of_a_model_are_reported_with_both_places() {
    let start = "a/scene.toml:5: `object.mesh`: a/models/model.glb: ";
    let mut broken = rooms();
    broken.json["meshes"][0]["primitives"][0]["indices"] = json!(9);
    let message = scene_of(&broken, &object(""))
        .expect_err("an index of nothing")
        .to_string();
    assert!(
        message.starts_with(start) && message.contains("points to a missing element"),
        "{message}"
    );
    let empty = TestModel::new();
    let message = scene_of(&empty, &object(""))
        .expect_err("nothing")
        .to_string();
    assert!(
        message.starts_with(start) && message.contains("has no triangles"),
        "{message}"
    );
    let elsewhere = object("").replace("models/model.glb", "models/none.glb");
    let message = read(Path::new("a/scene.toml"), &files_with(&rooms(), &elsewhere))
        .expect_err("no file")
        .to_string();
    assert!(
        message.starts_with("a/scene.toml:5: `object.mesh`: a/models/none.glb: can't be read"),
        "{message}"
    );
}
