//! Tests of nodes, scenes, cameras and lights.

use super::{model::TestModel, read_plain, scene_of};
use crate::{FilesInMemory, scene_of_file::SceneOfFile};
use serde_json::{Value, json};
use std::{
    f32::consts::{FRAC_PI_2, FRAC_PI_4},
    path::Path,
};
use umbrage_core::glam::{Affine3A, DMat4, DQuat, DVec3, Mat4, UVec2, Vec3, Vec4};
use umbrage_core::light_space::Extents;
use umbrage_core::{Camera, Light};

#[test]
fn placements_are_the_product_of_matrices() {
    let mut model = TestModel::square();
    let mirror = [
        1.0, 0.5, 0.0, 0.0, 0.0, -3.0, 0.0, 0.0, 0.0, 0.25, 2.0, 0.0, 4.0, 5.0, 6.0, 1.0,
    ];
    let leaf = model.add("nodes", json!({ "mesh": 0, "matrix": mirror }));
    let turned = json!({ "children": [leaf], "rotation": [0.1, 0.2, 0.3, 0.927_361_85], "scale": [2, 2, -0.5] });
    let middle = model.add("nodes", turned);
    model.node(json!({ "children": [middle], "translation": [10, -20, 30.5], "mesh": 0 }));
    let scene = scene_of(&model).expect("valid");
    let places: Vec<Affine3A> = scene.instances.iter().map(|i| i.world_from_local).collect();
    // The square's node, then the root, then its leaf: parents before their children.
    assert_eq!(places.len(), 3);
    assert_eq!(places[0], Affine3A::IDENTITY);
    let root = DMat4::from_translation(DVec3::new(10.0, -20.0, 30.5));
    assert_eq!(places[1], Affine3A::from_mat4(root.as_mat4()));
    let turn = DQuat::from_array([0.1_f32, 0.2, 0.3, 0.927_361_85].map(f64::from)).normalize();
    let middle = DMat4::from_quat(turn) * DMat4::from_scale(DVec3::new(2.0, 2.0, -0.5));
    let expected = root * middle * DMat4::from_cols_array(&mirror);
    let found = Mat4::from(places[2]).as_dmat4();
    assert!(
        found.abs_diff_eq(expected, 1e-5),
        "{found} instead of {expected}"
    );
    assert!(expected.determinant() > 0.0, "mirrored twice");
}

#[test]
fn a_scene_brings_light_if_one_of_its_lights_is_on() {
    let mut model = TestModel::square();
    let brings_light = |model: &TestModel, path: &str| {
        let files: FilesInMemory = [("a.glb", model.glb())].into_iter().collect();
        let wanted = SceneOfFile::of_path(Path::new(path)).expect("a glTF file");
        super::super::brings_light(&wanted, &files).map_err(|e| e.to_string())
    };
    assert_eq!(brings_light(&model, "a.glb"), Ok(false));
    let lamp = |intensity: f32| json!({ "type": "point", "intensity": intensity });
    model.json["extensions"] =
        json!({ "KHR_lights_punctual": { "lights": [lamp(0.0), lamp(1.0), lamp(-1.0)] } });
    let node =
        |light: usize| json!({ "extensions": { "KHR_lights_punctual": { "light": light } } });
    model.node(node(0));
    assert_eq!(brings_light(&model, "a.glb"), Ok(false), "it is off");
    let lit = model.add("nodes", node(1));
    model.add("scenes", json!({ "name": "night", "nodes": [lit] }));
    assert_eq!(brings_light(&model, "a.glb"), Ok(false), "another scene's");
    assert_eq!(brings_light(&model, "a.glb#night"), Ok(true));
    model.node(node(1));
    assert_eq!(brings_light(&model, "a.glb"), Ok(true));
    model.node(node(2));
    let message = brings_light(&model, "a.glb").expect_err("a negative light");
    assert!(message.contains("intensity"), "{message}");
    let missing = super::super::brings_light(
        &SceneOfFile::of_path(Path::new("b.glb")).expect("a glTF file"),
        &FilesInMemory::default(),
    );
    assert!(missing.is_err());
}

#[test]
fn nodes_of_no_size_are_hidden_and_flat_ones_are_noticed() {
    let with_scale = |scale: Value| {
        let mut model = TestModel::square();
        model.node(json!({ "mesh": 0, "scale": scale, "name": "sign" }));
        scene_of(&model)
    };
    let hidden = with_scale(json!([0, 0, 0])).expect("valid");
    assert_eq!(hidden.instances.len(), 1);
    assert_eq!(hidden.notices, [""; 0]);
    let flat = with_scale(json!([1, 0, 1])).expect("valid");
    assert_eq!(flat.instances.len(), 1);
    let [notice] = &flat.notices[..] else {
        panic!("one line: {:?}", flat.notices);
    };
    assert!(
        notice.ends_with(": node 1 `sign` is ignored: a size of zero flattens its mesh"),
        "{notice}"
    );
}

#[test]
fn a_file_s_scenes_are_named_behind_its_path() {
    let mut model = TestModel::square();
    let far = model.add("nodes", json!({ "mesh": 0, "translation": [7, 0, 0] }));
    model.add("scenes", json!({ "name": "night", "nodes": [far] }));
    let files: FilesInMemory = [("a#b.glb", model.glb())].into_iter().collect();
    let x = |path: &str| {
        let scene = read_plain(path, &files).expect("there is such a scene");
        (
            scene.name,
            scene.instances[0].world_from_local.translation.x,
        )
    };
    assert_eq!(x("a#b.glb"), ("a#b".into(), 0.0));
    assert_eq!(x("a#b.glb#0"), ("a#b-0".into(), 0.0));
    assert_eq!(x("a#b.glb#1"), ("a#b-1".into(), 7.0));
    assert_eq!(x("a#b.glb#night"), ("a#b-night".into(), 7.0));
    let message = read_plain("a#b.glb#day", &files)
        .expect_err("no such scene")
        .to_string();
    assert_eq!(
        message,
        "file: has no scene `day`; there are: scene 0, scene 1 `night`; name one after `#`, by its name or number"
    );
    // Without a default, the first scene is used.
    model
        .json
        .as_object_mut()
        .expect("an object")
        .remove("scene");
    assert_eq!(scene_of(&model).expect("valid").instances.len(), 1);
}

/// Returns the first camera of a model with this one, at (1, 2, 9), turned by a quarter about y, in
/// a node of twice the size.
fn camera(camera: Value) -> Result<Camera, String> {
    let mut model = TestModel::square();
    model.add("cameras", camera);
    let half = 0.5_f64.sqrt();
    model.node(json!({ "camera": 0, "translation": [1, 2, 9], "rotation": [0, half, 0, half], "scale": [2, 2, 2] }));
    Ok(scene_of(&model)?.cameras[0])
}

fn assert_near(found: &Camera, expected: &Camera) {
    assert_eq!(found.size, expected.size);
    assert!(
        found
            .world_from_view
            .abs_diff_eq(expected.world_from_view, 1e-6),
        "{found:?}"
    );
    assert!(
        found
            .clip_from_view
            .abs_diff_eq(expected.clip_from_view, 1e-6),
        "{found:?}"
    );
}

#[test]
fn cameras_look_along_their_nodes() {
    let [eye, target] = [Vec3::new(1.0, 2.0, 9.0), Vec3::new(0.0, 2.0, 9.0)];
    let made = |near_far, size| {
        Camera::perspective(eye, target, Vec3::Y, 0.75, near_far, size).expect("valid")
    };
    let perspective = json!({ "yfov": 0.75, "znear": 0.5, "zfar": 20, "aspectRatio": 2 });
    let found =
        camera(json!({ "type": "perspective", "perspective": perspective })).expect("valid");
    assert_near(&found, &made([0.5, 20.0], UVec2::new(720, 360)));
    let endless = json!({ "yfov": 0.75, "znear": 0.5 });
    let found = camera(json!({ "type": "perspective", "perspective": endless })).expect("valid");
    // Approach the same limit with a far plane as distant as 32-bit floats allow.
    assert_near(&found, &made([0.5, 1e9], UVec2::new(640, 360)));
    assert_eq!(
        found.clip_from_view * Vec4::new(0.0, 0.0, -1.0, 0.0),
        Vec4::new(0.0, 0.0, 1.0, 1.0),
        "depth 1 at infinity"
    );
    let flat = json!({ "xmag": 3, "ymag": 4, "znear": 0, "zfar": 50 });
    let found = camera(json!({ "type": "orthographic", "orthographic": flat })).expect("valid");
    let extents = Extents {
        left: -3.0,
        right: 3.0,
        bottom: -4.0,
        top: 4.0,
        near: 0.0,
        far: 50.0,
    };
    let expected = Camera::orthographic(eye, target, Vec3::Y, extents, UVec2::new(270, 360));
    assert_near(&found, &expected.expect("valid"));
}

#[test]
fn cameras_that_see_nothing_are_refused() {
    for (camera_of_file, expected) in [
        (
            json!({ "type": "perspective", "perspective": { "yfov": 4, "znear": 1 } }),
            "field of view: is 229",
        ),
        (
            json!({ "type": "perspective", "perspective": { "yfov": 1, "znear": 0 } }),
            "znear: is 0",
        ),
        (
            json!({ "type": "perspective", "perspective": { "yfov": 1, "znear": 2, "zfar": 1 } }),
            "near and far: are 2 and 1",
        ),
        (
            json!({ "type": "perspective", "perspective": { "yfov": 1, "znear": 1, "aspectRatio": -1 } }),
            "aspect ratio: is -1",
        ),
        (
            json!({ "type": "orthographic", "orthographic": { "xmag": 0, "ymag": 1, "znear": 0, "zfar": 1 } }),
            "xmag: is 0",
        ),
        (
            json!({ "type": "orthographic", "perspective": { "yfov": 1, "znear": 1 } }),
            "`cameras[0].type`: names a projection",
        ),
    ] {
        let message = camera(camera_of_file).expect_err("no camera");
        assert!(message.contains(expected), "{message}");
        assert!(
            expected.contains("type") || message.contains("node 1, camera 0, "),
            "{message}"
        );
    }
}

/// Returns the lights of a model with this one: at (0, 3, 0), turned so that it shines down, in a
/// mirrored node.
fn lights(light: Value, extras_of_node: Value) -> Result<Vec<Light>, String> {
    let mut model = TestModel::square();
    model.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [light] } });
    let half = 0.5_f64.sqrt();
    model.node(json!({
        "extensions": { "KHR_lights_punctual": { "light": 0 } }, "extras": extras_of_node,
        "translation": [0, 3, 0], "rotation": [-half, 0, 0, half], "scale": [-4, 4, 4],
    }));
    Ok(scene_of(&model)?.lights)
}

#[test]
fn lights_shine_along_their_nodes_and_have_blender_s_sizes() {
    let sun = lights(
        json!({ "type": "directional", "extras": { "angle": 0.01 } }),
        json!(null),
    );
    let [
        Light::Directional {
            direction,
            angular_diameter,
        },
    ] = sun.expect("valid")[..]
    else {
        panic!("no sun");
    };
    assert!(direction.distance(Vec3::NEG_Y) < 1e-6, "{direction}");
    assert_eq!(angular_diameter, 0.01);
    let position = Vec3::new(0.0, 3.0, 0.0);
    let half = json!({ "radius": 0.5 });
    let bulb = lights(json!({ "type": "point", "range": 10 }), half.clone()).expect("valid");
    assert_eq!(
        bulb,
        [Light::Point {
            position,
            radius: 0.5
        }]
    );
    // The light's size has precedence over its node's.
    let own = json!({ "shadow_soft_size": 0.25, "radius": 9 });
    let wide = json!({ "type": "spot", "spot": { "outerConeAngle": FRAC_PI_2 }, "extras": own });
    let spot = lights(wide, half).expect("valid");
    let [
        Light::Spot {
            position: at,
            direction,
            inner,
            outer,
            radius,
        },
    ] = spot[..]
    else {
        panic!("no spot");
    };
    assert!(direction.distance(Vec3::NEG_Y) < 1e-6, "{direction}");
    assert_eq!((at, inner, radius), (position, 0.0, 0.25));
    assert_eq!(outer, 89.9_f32.to_radians());
    let usual = lights(json!({ "type": "spot", "spot": {} }), json!("text")).expect("valid");
    assert!(
        matches!(
            usual[..],
            [Light::Spot {
                outer: FRAC_PI_4,
                radius: 0.0,
                ..
            }]
        ),
        "{usual:?}"
    );
    let off = lights(json!({ "type": "point", "intensity": 0 }), json!(null)).expect("valid");
    let black = lights(json!({ "type": "point", "color": [0, 0, 0] }), json!(null)).expect("valid");
    assert_eq!([off, black], [[], []]);
}

#[test]
fn lights_that_cannot_shine_are_refused() {
    let wide = json!({ "type": "spot", "spot": { "outerConeAngle": 2 } });
    let inverse =
        json!({ "type": "spot", "spot": { "outerConeAngle": 0.2, "innerConeAngle": 0.4 } });
    for (light, expected) in [
        (json!({ "type": "area" }), "lights[0].type`: is not among"),
        (json!({ "type": "spot" }), "lights[0].spot`: is missing"),
        (
            json!({ "type": "point", "intensity": -1, "name": "bulb" }),
            "node 1, light 0 `bulb`, intensity: is -1",
        ),
        (json!({ "type": "point", "range": 0 }), "range: is 0"),
        (
            json!({ "type": "point", "extras": { "radius": -1 } }),
            "`radius` in extras: is -1",
        ),
        (
            json!({ "type": "directional", "extras": { "angle": 4 } }),
            "angular diameter: is 229",
        ),
        (wide, "outerConeAngle: is 2"),
        (inverse, "inner angle: is 22"),
    ] {
        let message = lights(light, json!(null)).expect_err("no light");
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn what_a_file_lacks_is_what_a_model_alone_gets() {
    let whole = |model: &TestModel| {
        let files: FilesInMemory = [("model.glb", model.glb())].into_iter().collect();
        crate::read("model.glb", &files).expect("valid")
    };
    let alone = whole(&TestModel::square());
    assert_eq!(
        (
            alone.cameras.len(),
            alone.lights.len(),
            alone.instances.len()
        ),
        (1, 1, 2)
    );
    let text = "v -1 -1 0\nv 1 -1 0\nv -1 1 0\nv 1 1 0\nf 1 2 3\nf 3 2 4";
    let files: FilesInMemory = [("model.obj", text)].into_iter().collect();
    let obj = crate::read("model.obj", &files).expect("valid");
    assert_eq!((&alone.cameras, &alone.lights), (&obj.cameras, &obj.lights));
    let mut lit = TestModel::square();
    lit.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [{ "type": "point" }] } });
    let light = json!({ "KHR_lights_punctual": { "light": 0 } });
    lit.node(json!({ "extensions": light, "translation": [0, 0, 5] }));
    let lit = whole(&lit);
    assert_eq!(
        (lit.cameras.len(), lit.lights.len(), lit.instances.len()),
        (1, 1, 1)
    );
    assert!(matches!(lit.lights[0], Light::Point { .. }));
    let mut seen = TestModel::square();
    seen.add(
        "cameras",
        json!({ "type": "perspective", "perspective": { "yfov": 1, "znear": 0.1 } }),
    );
    seen.node(json!({ "camera": 0, "translation": [0, 0, 5] }));
    let seen = whole(&seen);
    assert_eq!(
        (seen.cameras.len(), seen.lights.len(), seen.instances.len()),
        (1, 1, 1)
    );
    assert_eq!(seen.cameras[0].eye(), Vec3::new(0.0, 0.0, 5.0));
    assert!(matches!(seen.lights[0], Light::Directional { .. }));
}
