//! Scenes far from the origin equal the same scenes at the origin, in every format.

use crate::{FilesInMemory, read};
use umbrage_core::Scene;
use umbrage_core::glam::Vec3;

/// Returns the world positions of a scene's triangles.
fn corners(scene: &Scene) -> Vec<Vec3> {
    let geometry = umbrage_core::Geometry::bake(scene).expect("valid");
    geometry.positions().to_vec()
}

fn assert_same(far: &Scene, near: &Scene, offset: Vec3) {
    let (far_corners, near_corners) = (corners(far), corners(near));
    assert_eq!(far_corners.len(), near_corners.len());
    for (a, b) in far_corners.iter().zip(&near_corners) {
        // The added floor depends on sizes that are rounded at 479 m.
        assert!(a.distance(*b + offset) < 1e-3, "{a} is not {b} + {offset}");
    }
    let (a, b) = (far.cameras[0].eye(), near.cameras[0].eye());
    assert!(
        a.distance(b + offset) < 2e-3,
        "eye {a} is not {b} + {offset}"
    );
    assert_eq!(far.notices.len(), 1, "{:?}", far.notices);
    assert!(far.notices[0].contains("far from the origin"));
    assert_eq!(near.notices, [""; 0]);
}

/// A tetrahedron around this point.
fn obj(point: [f64; 3]) -> Vec<u8> {
    let [x, y, z] = point;
    let corner = |a: f64, b: f64, c: f64| format!("v {} {} {}\n", x + a, y + b, z + c);
    let corners = [
        corner(0.0, 0.0, 0.0),
        corner(1.25, 0.0, 0.0),
        corner(0.0, 0.0, 1.375),
        corner(0.0, 2.3, 0.0),
    ];
    let faces = "f 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n";
    (corners.concat() + faces).into_bytes()
}

/// Map coordinates (UTM), and earth-centred ones. Multiples of 1/128 are exact in text and in 32
/// bits near the anchor.
const FAR: [[f64; 3]; 2] = [
    [691_234.375, 412.25, -5_336_543.25],
    [4_177_281.5, 855_124.75, 4_728_512.125],
];

/// Returns the position relative to the anchor nearest to `point`.
fn relative(far: [f64; 3], point: [f64; 3]) -> Vec3 {
    let anchor = |x: f64| (x / 1024.0).round() * 1024.0;
    let parts = [0, 1, 2].map(|i| (far[i] - anchor(point[i])) as f32);
    Vec3::from_array(parts)
}

#[test]
fn models_with_far_vertices_are_read_near_the_anchor() {
    for far in FAR {
        let files: FilesInMemory = [("near.obj", obj([0.0; 3])), ("far.obj", obj(far))]
            .into_iter()
            .collect();
        let [near, scene] = ["near.obj", "far.obj"].map(|path| read(path, &files).expect("valid"));
        let center = [far[0] + 0.625, far[1] + 1.15, far[2] + 0.6875];
        assert_same(&scene, &near, relative(far, center));
    }
}

#[test]
fn anchors_reach_the_vertices_of_models() {
    let toml = |anchor: &str, mesh: &str, [x, y, z]: [f64; 3]| {
        let (eye, target) = ([x + 3.0, y + 2.0, z + 4.0], [x, y, z]);
        format!(
            "{anchor}\n[camera]\neye = {eye:?}\ntarget = {target:?}\n\
             [[light]]\nkind = \"directional\"\ndirection = [-1, -1, -1]\n\
             [[object]]\nmesh = \"{mesh}\"\n"
        )
        .into_bytes()
    };
    for far in FAR {
        let anchor = format!("anchor = {far:?}");
        let files: FilesInMemory = [
            ("near.obj", obj([0.0; 3])),
            ("far.obj", obj(far)),
            ("near.toml", toml("", "near.obj", [0.0; 3])),
            ("far.toml", toml("", "far.obj", far)),
            ("anchored.toml", toml(&anchor, "far.obj", far)),
        ]
        .into_iter()
        .collect();
        let near = read("near.toml", &files).expect("valid");
        let scene = read("far.toml", &files).expect("valid");
        let eye = [far[0] + 3.0, far[1] + 2.0, far[2] + 4.0];
        assert_same(&scene, &near, relative(far, eye));
        // The anchor of the file is used as it is, without a notice.
        let mut anchored = read("anchored.toml", &files).expect("valid");
        assert_eq!(anchored.notices, [""; 0]);
        anchored.notices.clone_from(&scene.notices);
        assert_same(&anchored, &near, relative(far, far));
    }
}

#[cfg(feature = "gltf")]
#[test]
fn far_nodes_of_gltf_are_read_with_64_bits() {
    use crate::gltf::tests::model::TestModel;
    use serde_json::json;
    for far in FAR {
        let model = |root: serde_json::Value| {
            let mut model = TestModel::square();
            model.add(
                "cameras",
                json!({ "type": "perspective", "perspective": { "yfov": 0.8, "znear": 0.1 } }),
            );
            let square = model.add("nodes", json!({ "mesh": 0, "scale": [1, 2, 3] }));
            let camera = model.add("nodes", json!({ "camera": 0, "translation": [0, 1, 9] }));
            let mut root = root;
            root["children"] = json!([square, camera]);
            let root = model.add("nodes", root);
            model.json["scenes"][0]["nodes"] = json!([root]);
            model.glb()
        };
        let [x, y, z] = far;
        let matrix = [
            1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, x, y, z, 1.0,
        ];
        let files: FilesInMemory = [
            ("near.glb", model(json!({}))),
            ("moved.glb", model(json!({ "translation": far }))),
            ("matrix.glb", model(json!({ "matrix": matrix }))),
        ]
        .into_iter()
        .collect();
        let near = read("near.glb", &files).expect("valid");
        for path in ["moved.glb", "matrix.glb"] {
            let scene = read(path, &files).expect("valid");
            assert_same(&scene, &near, relative(far, [x, y + 1.0, z + 9.0]));
        }
    }
}
