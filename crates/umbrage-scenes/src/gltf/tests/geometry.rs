//! Tests of meshes against the same meshes built in code.

use super::{
    model::{F32, I8, I16, SQUARE, TestModel, U8, U16, U32, words},
    scene_of,
};
use serde_json::{Value, json};
use umbrage_core::glam::{Affine3A, Vec3};
use umbrage_core::{Geometry, Instance, Mesh, Scene};

const CORNERS: [u16; 6] = [0, 1, 2, 2, 1, 3];

/// Returns the fingerprint of triangles with separate vertices.
fn fingerprint(positions: &[f32], triangles: &[[u32; 3]]) -> u64 {
    let positions = positions.as_chunks::<3>().0;
    let corners = triangles.as_flattened().iter();
    let apart: Vec<Vec3> = corners
        .map(|&v| Vec3::from_array(positions[v as usize]))
        .collect();
    let triangles = (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
    let scene = Scene {
        meshes: vec![Mesh::new("mesh", apart, triangles.collect()).expect("valid")],
        instances: vec![Instance::new(0, Affine3A::IDENTITY)],
        ..Scene::default()
    };
    Geometry::bake(&scene).expect("valid").fingerprint()
}

fn fingerprint_of(model: &TestModel) -> u64 {
    let scene = scene_of(model).expect("valid");
    Geometry::bake(&scene).expect("valid").fingerprint()
}

/// A model of one mesh at one node.
fn model_of(make: impl Fn(&mut TestModel) -> Value) -> TestModel {
    let mut model = TestModel::new();
    let primitive = make(&mut model);
    model.mesh(primitive);
    model.node(json!({ "mesh": 0 }));
    model
}

#[test]
fn indices_of_every_width_and_none_give_the_same_triangles() {
    let expected = fingerprint(&SQUARE, &[[0, 1, 2], [2, 1, 3]]);
    let bytes = CORNERS.map(|i| i as u8).to_vec();
    let long: Vec<u8> = CORNERS
        .iter()
        .flat_map(|&i| u32::from(i).to_le_bytes())
        .collect();
    for (component, bytes) in [(U8, bytes), (U16, words(&CORNERS)), (U32, long)] {
        let model = model_of(|model| {
            let positions = model.floats("VEC3", 3, &SQUARE);
            let indices = model.numbers(component, "SCALAR", 6, &bytes);
            json!({ "attributes": { "POSITION": positions }, "indices": indices })
        });
        assert_eq!(fingerprint_of(&model), expected, "component {component}");
    }
    let corner = |i: u16| SQUARE[3 * usize::from(i)..][..3].to_vec();
    let apart: Vec<f32> = CORNERS.into_iter().flat_map(corner).collect();
    let model = model_of(|model| {
        let positions = model.floats("VEC3", 3, &apart);
        json!({ "attributes": { "POSITION": positions } })
    });
    assert_eq!(
        fingerprint_of(&model),
        fingerprint(&apart, &[[0, 1, 2], [3, 4, 5]])
    );
}

#[test]
fn strips_and_fans_face_one_way() {
    // A row of five vertices. The strip has a jump in its middle.
    let row: Vec<f32> = (0..5)
        .flat_map(|i| [i as f32, (i % 2) as f32, 0.0])
        .collect();
    let shown = |mode: u32, indices: &[u16]| {
        model_of(|model| {
            let positions = model.floats("VEC3", 3, &row);
            let indices = model.numbers(U16, "SCALAR", indices.len(), &words(indices));
            json!({ "attributes": { "POSITION": positions }, "indices": indices, "mode": mode })
        })
    };
    let strip = shown(5, &[0, 1, 2, 3, 3, 2, 4]);
    let triangles = [[0, 1, 2], [1, 3, 2], [3, 2, 4]];
    assert_eq!(fingerprint_of(&strip), fingerprint(&row, &triangles));
    let fan = shown(6, &[0, 1, 2, 3, 4]);
    let triangles = [[1, 2, 0], [2, 3, 0], [3, 4, 0]];
    assert_eq!(fingerprint_of(&fan), fingerprint(&row, &triangles));
    for mode in 0..4 {
        let message = scene_of(&shown(mode, &[0, 1, 2])).expect_err("no triangles");
        assert!(message.contains("has no triangles"), "{message}");
    }
}

#[test]
fn sparse_elements_replace_those_of_the_base_or_zeros() {
    let expected = fingerprint(&SQUARE, &[[0, 1, 2], [2, 1, 3]]);
    let replaced: Vec<u8> = SQUARE[3..].iter().flat_map(|n| n.to_le_bytes()).collect();
    for (component, at) in [(U8, vec![1, 2, 3]), (U16, words(&[1, 2, 3]))] {
        let model = model_of(|model| {
            let wrong: Vec<f32> = [&SQUARE[..3], &[9.0; 9]].concat();
            let positions = model.floats("VEC3", 3, &wrong);
            let at = model.view(&at);
            let values = model.view(&replaced);
            model.json["accessors"][positions]["sparse"] = json!({
                "count": 3,
                "indices": { "bufferView": at, "componentType": component },
                "values": { "bufferView": values },
            });
            let indices = model.numbers(U16, "SCALAR", 6, &words(&CORNERS));
            json!({ "attributes": { "POSITION": positions }, "indices": indices })
        });
        assert_eq!(fingerprint_of(&model), expected);
    }
    let model = model_of(|model| {
        let at = model.view(&words(&[1, 2]));
        let values = model.view(&replaced[..24]);
        let sparse = json!({
            "count": 2,
            "indices": { "bufferView": at, "componentType": U16 },
            "values": { "bufferView": values },
        });
        let accessor =
            json!({ "componentType": F32, "type": "VEC3", "count": 3, "sparse": sparse });
        let positions = model.add("accessors", accessor);
        json!({ "attributes": { "POSITION": positions } })
    });
    let from_zero = [&[0.0; 3], &SQUARE[3..9]].concat();
    assert_eq!(
        fingerprint_of(&model),
        fingerprint(&from_zero, &[[0, 1, 2]])
    );
}

/// Accessors without bytes occur in files for morph targets that move nothing.
#[test]
fn accessors_without_bytes_hold_zeros() {
    let model = model_of(|model| {
        let positions = model.floats("VEC3", 3, &SQUARE);
        let normals = model.add(
            "accessors",
            json!({ "componentType": F32, "type": "VEC3", "count": 4 }),
        );
        let indices = model.numbers(U16, "SCALAR", 6, &words(&CORNERS));
        json!({ "attributes": { "POSITION": positions, "NORMAL": normals }, "indices": indices })
    });
    // Zero normals count as missing.
    let expected = fingerprint(&SQUARE, &[[0, 1, 2], [2, 1, 3]]);
    assert_eq!(fingerprint_of(&model), expected);
}

#[test]
fn quantised_positions_stand_for_the_specification_s_numbers() {
    // Normalised and plain value of each, computed by hand.
    let cases: [(u32, Vec<u8>, [f32; 3]); 4] = [
        (I8, vec![0x80, 127, 64], [-1.0, 1.0, 64.0 / 127.0]),
        (U8, vec![0, 255, 51], [0.0, 1.0, 0.2]),
        (
            I16,
            words(&[0x8000, 32767, 0xffff]),
            [-1.0, 1.0, -1.0 / 32767.0],
        ),
        (U16, words(&[0, 65535, 13107]), [0.0, 1.0, 0.2]),
    ];
    let plain = [
        [-128.0, 127.0, 64.0],
        [0.0, 255.0, 51.0],
        [-32768.0, 32767.0, -1.0],
        [0.0, 65535.0, 13107.0],
    ];
    for ((component, bytes, normalized), plain) in cases.into_iter().zip(plain) {
        for (is_normalized, numbers) in [(true, normalized), (false, plain)] {
            let [a, b, c] = numbers;
            let element = bytes.len() / 3;
            let turned = [&bytes[element..], &bytes[..element]].concat();
            let twice = [&turned[element..], &turned[..element]].concat();
            // Elements start at multiples of four bytes, as the extension requires.
            let stride = (3 * element).next_multiple_of(4);
            let padded: Vec<u8> = [&bytes, &turned, &twice]
                .into_iter()
                .flat_map(|vector| {
                    let mut vector = vector.clone();
                    vector.resize(stride, 0);
                    vector
                })
                .collect();
            let model = model_of(|model| {
                let positions = model.numbers(component, "VEC3", 3, &padded);
                model.json["accessors"][positions]["normalized"] = json!(is_normalized);
                model.json["bufferViews"][0]["byteStride"] = json!(stride);
                model.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
                json!({ "attributes": { "POSITION": positions } })
            });
            let expected = [a, b, c, b, c, a, c, a, b];
            let found = fingerprint_of(&model);
            assert_eq!(
                found,
                fingerprint(&expected, &[[0, 1, 2]]),
                "{component} {is_normalized}"
            );
        }
    }
}

#[test]
fn vertices_may_be_interleaved_and_shared() {
    // Interleave positions and normals after some other bytes.
    let normal = [0.0_f32, 0.6, 0.8];
    let mut bytes = vec![7; 8];
    for corner in SQUARE.chunks_exact(3) {
        bytes.extend(corner.iter().flat_map(|n| n.to_le_bytes()));
        bytes.extend(normal.iter().flat_map(|n| n.to_le_bytes()));
    }
    let model = model_of(|model| {
        let positions = model.numbers(F32, "VEC3", 4, &bytes);
        model.json["bufferViews"][0]["byteStride"] = json!(24);
        let mut normals = model.json["accessors"][positions].clone();
        normals["byteOffset"] = json!(8 + 12);
        model.json["accessors"][positions]["byteOffset"] = json!(8);
        let normals = model.add("accessors", normals);
        let indices = model.numbers(U16, "SCALAR", 6, &words(&CORNERS));
        json!({ "attributes": { "POSITION": positions, "NORMAL": normals }, "indices": indices })
    });
    let mesh = &scene_of(&model).expect("valid").meshes[0];
    assert_eq!(mesh.positions, vectors(&SQUARE));
    assert_eq!(mesh.normals, [Vec3::from_array(normal); 4]);
    assert_eq!(mesh.triangles, [[0, 1, 2], [2, 1, 3]]);
    // A long list of which one triangle uses three vertices, and a short one of which it uses three
    // of four.
    for count in [4, 40] {
        let list: Vec<f32> = (0..3 * count).map(|i| ((i * i) % 17) as f32).collect();
        let model = model_of(|model| {
            let positions = model.floats("VEC3", 3, &list);
            let normals = model.floats("VEC3", 3, &normal.repeat(count));
            let indices = model.numbers(U16, "SCALAR", 3, &words(&[3, 0, 2]));
            json!({ "attributes": { "POSITION": positions, "NORMAL": normals }, "indices": indices })
        });
        let mesh = &scene_of(&model).expect("valid").meshes[0];
        let used = [&list[0..3], &list[6..9], &list[9..12]].concat();
        assert_eq!(mesh.positions, vectors(&used), "{count}");
        assert_eq!(mesh.normals, [Vec3::from_array(normal); 3], "{count}");
        assert_eq!(mesh.triangles, [[2, 0, 1]], "{count}");
    }
}

fn vectors(numbers: &[f32]) -> Vec<Vec3> {
    numbers.chunks_exact(3).map(Vec3::from_slice).collect()
}

#[test]
fn normals_and_tangents_are_the_file_s_own_if_they_are_usable() {
    let made = |normal: [f32; 3]| {
        let model = model_of(|model| {
            let positions = model.floats("VEC3", 3, &SQUARE);
            let normals = model.floats("VEC3", 3, &normal.repeat(4));
            let indices = model.numbers(U16, "SCALAR", 6, &words(&CORNERS));
            json!({ "attributes": { "POSITION": positions, "NORMAL": normals }, "indices": indices })
        });
        scene_of(&model).expect("valid").meshes[0].normals.clone()
    };
    assert_eq!(made([0.0, 0.6, 0.8]), [Vec3::new(0.0, 0.6, 0.8); 4]);
    assert_eq!(made([0.0; 3]), [], "found by who bakes the mesh");
}

/// Two walls with a common edge keep separate normals.
#[test]
fn surfaces_without_normals_are_flat() {
    let corner = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    let model = model_of(|model| {
        let positions = model.floats("VEC3", 3, &corner);
        let indices = model.numbers(U16, "SCALAR", 6, &words(&[0, 1, 2, 0, 3, 1]));
        json!({ "attributes": { "POSITION": positions }, "indices": indices })
    });
    let geometry = Geometry::bake(&scene_of(&model).expect("valid")).expect("valid");
    let expected = [[Vec3::Z; 3], [Vec3::Y; 3]].concat();
    assert_eq!(geometry.normals(), expected);
}
