//! Errors of files, one by one, and files that exceed limits.

use super::{
    model::{F32, TestModel, U16, glb, words},
    read_plain, scene_of,
};
use crate::{Files, FilesInMemory, OpenFile, damage::damaged_texts, scene_of_file::SceneOfFile};
use serde_json::{Value, json};
use std::{
    io::{self, Cursor},
    path::Path,
};
use umbrage_core::Scene;

/// Returns the error of a changed square.
fn error(change: impl Fn(&mut TestModel)) -> String {
    let mut model = TestModel::square();
    model.json["nodes"][0]["name"] = json!("wall");
    model.json["accessors"][0]["name"] = json!("corners");
    change(&mut model);
    scene_of(&model).expect_err("this is no model")
}

/// Errors of changed members of the document: pointer, new value, part of the error.
#[test]
fn documents_that_contradict_themselves_are_refused_by_name() {
    let accessor = "node 0 `wall`, mesh 0, primitive 0, accessor 0 `corners`";
    let cases: &[(&str, Value, &str)] = &[
        (
            "/asset/version",
            json!("1.0"),
            "asset: is of version 1.0 of the format; export the model as glTF 2.0",
        ),
        (
            "/asset/minVersion",
            json!("2.1"),
            "asset: is of version 2.1",
        ),
        (
            "/extensionsRequired",
            json!(["KHR_draco_mesh_compression"]),
            "extension `KHR_draco_mesh_compression`: is required by the file",
        ),
        ("/scene", json!(7), "`scene`: points to a missing element"),
        (
            "/scenes/0/nodes/0",
            json!(7),
            "`scenes[0].nodes[0]`: points to a missing element",
        ),
        (
            "/nodes/0/mesh",
            json!(7),
            "`nodes[0].mesh` of `wall`: points to a missing element",
        ),
        (
            "/meshes/0/primitives/0/attributes/POSITION",
            json!(7),
            "`meshes[0].primitives[0].attributes[\"POSITION\"]`: points to",
        ),
        (
            "/meshes/0/primitives/0/indices",
            json!(7),
            "`meshes[0].primitives[0].indices`: points to",
        ),
        (
            "/meshes/0/primitives/0/mode",
            json!(7),
            "`meshes[0].primitives[0].mode`: is not among",
        ),
        (
            "/meshes/0/primitives/0/material",
            json!(7),
            "`meshes[0].primitives[0].material`: points to",
        ),
        (
            "/accessors/0/bufferView",
            json!(7),
            "`accessors[0].bufferView` of `corners`: points to",
        ),
        (
            "/accessors/0/bufferView",
            json!(null),
            "accessor 0 `corners`: holds no positions",
        ),
        (
            "/accessors/0/componentType",
            json!(5124),
            "`accessors[0].componentType` of `corners`: is not among",
        ),
        (
            "/accessors/0/type",
            json!("VEC5"),
            "`accessors[0].type` of `corners`: is not among",
        ),
        (
            "/accessors/0/type",
            json!("VEC2"),
            "holds no vectors of 3 numbers",
        ),
        (
            "/accessors/0/componentType",
            json!(5125),
            "holds whole numbers of 32 bits",
        ),
        (
            "/accessors/1/componentType",
            json!(5126),
            "accessor 1, buffer view 1: has 12 bytes, and element 5 would end at byte 24",
        ),
        (
            "/accessors/1/componentType",
            json!(5122),
            "accessor 1: holds no indices",
        ),
        (
            "/accessors/1/count",
            json!(5),
            "its triangles: have 5 corners, which is not a multiple of 3",
        ),
        (
            "/accessors/0/count",
            json!(3),
            "accessor 1: names vertex 3 of 3",
        ),
        (
            "/accessors/0/count",
            json!(5),
            "buffer view 0: has 48 bytes, and element 4 would end at byte 60",
        ),
        (
            "/accessors/0/count",
            json!(u64::MAX),
            "its count: states 18446744073709551615 elements",
        ),
        (
            "/accessors/0/count",
            json!(4_294_967_295_u64),
            "has 48 bytes, and element 4294967294 would end at byte 51539607540",
        ),
        (
            "/accessors/0/count",
            json!(-1),
            "its JSON: can't be read: invalid value: integer `-1`",
        ),
        (
            "/accessors/0/byteOffset",
            json!(u64::MAX),
            "element 3 would end at byte 18446744073709551663",
        ),
        (
            "/bufferViews/0/byteStride",
            json!(4),
            "the stride of its view: is 4, less than an element's 12 bytes",
        ),
        (
            "/bufferViews/0/byteStride",
            json!(64),
            "has 48 bytes, and element 3 would end at byte 204",
        ),
        (
            "/bufferViews/0/buffer",
            json!(1),
            "`bufferViews[0].buffer`: points to",
        ),
        (
            "/bufferViews/0/byteLength",
            json!(61),
            "accessor 0 `corners`, buffer view 0: ends at byte 61 of buffer 0, which has 60",
        ),
        (
            "/bufferViews/0/byteOffset",
            json!(u64::MAX),
            "ends at byte 18446744073709551615 of buffer 0",
        ),
        (
            "/nodes/0/matrix",
            json!([1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]),
            "node 0 `wall`, matrix: ends in the row [1, 0, 0, 1]",
        ),
        (
            "/nodes/0/matrix",
            json!([1, 0, 0, 0, 0, 1e39, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]),
            "node 0 `wall`, matrix: holds inf",
        ),
        (
            "/nodes/0/rotation",
            json!([0, 0, 0, 0]),
            "node 0 `wall`, rotation: is zero",
        ),
        (
            "/nodes/0/translation",
            json!([1e39, 0, 0]),
            "node 0 `wall`, translation: holds inf",
        ),
    ];
    for (pointer, value, expected) in cases {
        let message = error(|model| set(&mut model.json, pointer, value.clone()));
        assert!(message.contains(expected), "{pointer} = {value}: {message}");
        let is_of_accessor = message.contains("accessor 0") && !message.contains("accessors[0]");
        assert!(!is_of_accessor || message.contains(accessor), "{message}");
    }
}

/// Sets a member that may not exist yet.
fn set(json: &mut Value, pointer: &str, value: Value) {
    let (outer, last) = pointer.rsplit_once('/').expect("a pointer");
    let outer = json.pointer_mut(outer).expect("it is there");
    match last.parse::<usize>() {
        Ok(index) => outer[index] = value,
        Err(_) => outer[last] = value,
    }
}

#[test]
fn trees_that_are_none_are_refused() {
    let with_nodes = |nodes: Value| error(|model| model.json["nodes"] = nodes.clone());
    let itself = with_nodes(json!([{ "name": "snake", "children": [0] }]));
    assert!(
        itself.contains("node 0 `snake`: is below itself: it is a child of node 0 `snake`"),
        "{itself}"
    );
    let round = with_nodes(
        json!([{ "name": "head", "children": [1] }, { "children": [2] }, { "name": "tail", "children": [0] }]),
    );
    assert!(
        round.contains("node 0 `head`: is below itself: it is a child of node 2 `tail`"),
        "{round}"
    );
    let shared = with_nodes(
        json!([{ "children": [1, 2] }, { "name": "left", "children": [3] }, { "name": "right", "children": [3] }, { "name": "child" }]),
    );
    assert!(shared.contains("node 3 `child`: has two parents: node 1 `left` and node 2 `right`; list each node once, below one parent"), "{shared}");
    let root = error(|model| {
        model.add("nodes", json!({}));
        model.json["nodes"][0]["children"] = json!([1]);
        model.json["scenes"][0]["nodes"] = json!([0, 1]);
    });
    assert!(
        root.contains("node 1: has two parents: node 0 `wall` and the scene"),
        "{root}"
    );
    let twice = with_nodes(json!([{ "name": "wall", "children": [1, 1] }, {}]));
    assert!(
        twice.contains("node 1: is listed twice by node 0 `wall`"),
        "{twice}"
    );
    let root_twice = error(|model| model.json["scenes"][0]["nodes"] = json!([0, 0]));
    assert!(
        root_twice.contains("node 0 `wall`: is listed twice by the scene"),
        "{root_twice}"
    );
    // A long chain is valid.
    let mut model = TestModel::new();
    for i in 0..100_000 {
        model.add("nodes", json!({ "children": [i + 1] }));
    }
    model.add("nodes", json!({}));
    model.json["scenes"][0]["nodes"] = json!([0]);
    let message = scene_of(&model).expect_err("nothing to see");
    assert!(message.contains("has no triangles"), "{message}");
}

#[test]
fn sparse_elements_out_of_range_are_refused() {
    let with = |at: &[u8], count: u64, values: usize| {
        error(|model| {
            let at = model.view(at);
            let values = model.view(&vec![0; values]);
            model.json["accessors"][0]["sparse"] = json!({
                "count": count,
                "indices": { "bufferView": at, "componentType": 5121 },
                "values": { "bufferView": values },
            });
        })
    };
    for (message, expected) in [
        (
            with(&[4], 1, 12),
            "accessor 0 `corners`, sparse indices: hold 4, of 4 elements",
        ),
        (
            with(&[1], 2, 24),
            "sparse indices, buffer view 2: has 1 bytes, and element 1 would end at byte 2",
        ),
        (
            with(&[1], 1, 11),
            "sparse values, buffer view 3: has 11 bytes, and element 0 would end at byte 12",
        ),
        (with(&[1], 5, 60), "sparse: replaces 5 of 4 elements"),
        (
            with(&[2, 1], 2, 24),
            "sparse indices: hold 1 after 2, and must rise",
        ),
    ] {
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn numbers_that_are_none_are_refused() {
    for number in [f32::NAN, f32::INFINITY] {
        let message = error(|model| model.bytes[16..20].copy_from_slice(&number.to_le_bytes()));
        let expected = format!("accessor 0 `corners`: holds [1.0, {number:?}, 0.0] as element 1");
        assert!(message.contains(&expected), "{message}");
    }
    let message = error(|model| {
        let normals = model.floats("VEC3", 3, &[0.0, 0.0, 1.0]);
        model.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
    });
    assert!(
        message.contains("accessor 2: has 1 elements for 4 vertices"),
        "{message}"
    );
}

/// Returns the error of the first of these files.
fn of_files(files: &[(&str, &[u8])]) -> String {
    let first = files[0].0;
    let files: FilesInMemory = files.iter().map(|&(path, bytes)| (path, bytes)).collect();
    read_plain(first, &files).expect_err("no model").to_string()
}

/// Files with a buffer `long.bin` that is longer than it should be read. Reading the excess returns
/// an error.
struct WithLongFile {
    others: FilesInMemory,
    bytes: Vec<u8>,
}

/// Bytes followed by a read error.
struct ThenFault<'a>(Cursor<&'a [u8]>);

impl io::Read for ThenFault<'_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        match self.0.read(out)? {
            0 if !out.is_empty() => Err(io::Error::other("was read too far")),
            count => Ok(count),
        }
    }
}

impl io::BufRead for ThenFault<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        match self.0.fill_buf()? {
            [] => Err(io::Error::other("was read too far")),
            bytes => Ok(bytes),
        }
    }

    fn consume(&mut self, count: usize) {
        self.0.consume(count);
    }
}

impl io::Seek for ThenFault<'_> {
    fn seek(&mut self, to: io::SeekFrom) -> io::Result<u64> {
        self.0.seek(to)
    }
}

impl Files for WithLongFile {
    fn open(&self, path: &Path) -> io::Result<Box<dyn OpenFile + '_>> {
        match path.ends_with("long.bin") {
            true => Ok(Box::new(ThenFault(Cursor::new(&self.bytes)))),
            false => self.others.open(path),
        }
    }
}

/// A file next to the model is read up to the length of its buffer. A file of two buffers is read
/// up to the longer one.
#[test]
fn files_are_read_as_far_as_buffers_tell() {
    let model = TestModel::square();
    let text = model.text(Some("long.bin"));
    let read = |json: &Value, bytes: &[u8]| {
        let others = [("a.gltf", json.to_string().into_bytes())];
        let files = WithLongFile {
            others: others.into_iter().collect(),
            bytes: bytes.to_vec(),
        };
        let wanted = SceneOfFile::of_path(Path::new("a.gltf")).expect("a glTF file");
        super::super::read(json.to_string().as_bytes(), &wanted, &files).map_err(|e| e.to_string())
    };
    let json: Value = serde_json::from_str(&text).expect("JSON");
    let alone = scene_of(&model).expect("valid");
    let same = |read: Result<Scene, String>| read.expect("valid").meshes == alone.meshes;
    assert!(same(read(&json, &model.bytes)));
    // Negative control: a longer buffer reads on.
    let mut longer = json.clone();
    longer["buffers"][0]["byteLength"] = json!(model.bytes.len() + 1);
    let message = read(&longer, &model.bytes).expect_err("too far");
    assert!(message.contains("was read too far"), "{message}");
    // Positions from a buffer of their length, and then the indices after them in the same file.
    let mut shared = json.clone();
    let positions = json["bufferViews"][0]["byteLength"].clone();
    shared["buffers"] = json!([json["buffers"][0], { "byteLength": positions, "uri": "long.bin" }]);
    shared["bufferViews"][0]["buffer"] = json!(1);
    assert!(same(read(&shared, &model.bytes)));
}

#[test]
fn buffers_that_lie_or_are_missing_are_refused() {
    let model = TestModel::square();
    let with_uri = |uri: &str| {
        of_files(&[
            ("a.gltf", model.text(Some(uri)).as_bytes()),
            ("short.bin", &[0; 59]),
        ])
    };
    for (uri, expected) in [
        (
            "gone.bin",
            "node 0, mesh 0, primitive 0, accessor 0, buffer view 0, buffer 0, gone.bin: can't be read: is not among the given files; provide it together with the file that names it",
        ),
        (
            "short.bin",
            "buffer 0, its length: states 60 bytes, and there are 59",
        ),
        (
            "data:;base64,AAAA",
            "buffer 0, its length: states 60 bytes, and there are 3",
        ),
        ("data:;base64,A$AA", "buffer 0, its data URI: is not base64"),
        ("data:;base64", "buffer 0, its data URI: has no comma"),
        ("http://a/b.bin", "buffer 0, its URI: begins with `http:`"),
        ("C:\\b.bin", "buffer 0, its URI: begins with `C:`"),
    ] {
        let message = with_uri(uri);
        assert!(message.contains(expected), "{message}");
    }
    let message = of_files(&[("a.gltf", model.text(None).as_bytes())]);
    assert!(
        message.contains("buffer 0, its bytes: are missing"),
        "{message}"
    );
}

#[test]
fn files_that_are_cut_off_or_no_models_are_refused() {
    let whole = TestModel::square().glb();
    for end in 0..whole.len() {
        let message = of_files(&[("a.glb", &whole[..end])]);
        let expected = match end {
            0 => "file: is empty",
            // Without its magic word, the file counts as text.
            1..4 => "its JSON: can't be read",
            _ => "is cut off",
        };
        assert!(message.contains(expected), "{end}: {message}");
    }
    let mut other = whole.clone();
    other[4] = 1;
    assert!(of_files(&[("a.glb", &other)]).contains("header: states version 1 of the format"));
    let mut turned = whole.clone();
    turned[16..20].copy_from_slice(b"BIN\0");
    assert!(of_files(&[("a.glb", &turned)]).contains("first chunk: is not JSON"));
    let mut small = whole.clone();
    small[8..12].copy_from_slice(&3_u32.to_le_bytes());
    assert!(of_files(&[("a.glb", &small)]).contains("first chunk: is not JSON"));
    let old = br#"{ "asset": { "version": "1.0" }, "meshes": {} }"#;
    assert!(of_files(&[("a.gltf", old)]).contains("asset: is of version 1.0"));
    let brackets = "[".repeat(100_000);
    let deep =
        format!("{{ \"asset\": {{ \"version\": \"2.0\" }}, \"extensions\": {{ \"x\": {brackets}");
    assert!(of_files(&[("a.gltf", deep.as_bytes())]).contains("recursion limit exceeded"));
    assert!(
        of_files(&[("a.gltf", br#"{ "asset": { "version": "2.0" } }"#)])
            .contains("file: has no scene")
    );
}

#[test]
fn small_files_that_need_much_memory_are_refused() {
    // Zeros without bytes.
    let zeros = error(|model| {
        let at = model.view(&[0]);
        let values = model.view(&[0; 12]);
        let sparse = json!({ "count": 1, "indices": { "bufferView": at, "componentType": 5121 }, "values": { "bufferView": values } });
        model.json["accessors"][0] = json!({ "componentType": F32, "type": "VEC3", "count": 3_000_000_000_u64, "sparse": sparse });
        model.json["meshes"][0]["primitives"][0] = json!({ "attributes": { "POSITION": 0 } });
    });
    assert!(
        zeros.contains("its vertices and indices: would make 300000000"),
        "{zeros}"
    );
    // One mesh many times.
    let mut model = TestModel::new();
    let corners = 30_000;
    let positions = model.floats("VEC3", 3, &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    let list: Vec<u16> = (0..corners).map(|i| i % 3).collect();
    let indices = model.numbers(U16, "SCALAR", list.len(), &words(&list));
    let primitive = json!({ "attributes": { "POSITION": positions }, "indices": indices });
    let mut many = model.clone();
    model.mesh(primitive.clone());
    for _ in 0..5_000 {
        model.node(json!({ "mesh": 0 }));
    }
    let message = scene_of(&model).expect_err("too many");
    assert!(message.contains("its mesh: would make"), "{message}");
    // One list many times.
    let primitives = vec![primitive; 5_000];
    many.add("meshes", json!({ "primitives": primitives }));
    many.node(json!({ "mesh": 0 }));
    let message = scene_of(&many).expect_err("too many");
    assert!(
        message.contains("its vertices and indices: would make"),
        "{message}"
    );
}

#[test]
fn damaged_files_never_panic() {
    for (i, model) in super::model::first_inputs().into_iter().enumerate() {
        let text = model.text(None);
        scene_of(&model).unwrap_or_else(|e| panic!("input {i} is sound: {e}"));
        for json in damaged_texts(&text, 1_500) {
            let files: FilesInMemory = [("a.glb", glb(&json, &model.bytes))].into_iter().collect();
            if let Ok(scene) = read_plain("a.glb", &files) {
                // Numbers may only be out of range if baking reports it.
                let _ = umbrage_core::Geometry::bake(&scene);
            }
        }
    }
}
