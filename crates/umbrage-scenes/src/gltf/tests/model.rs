//! glTF files made in code, for tests and for the fuzzer's initial inputs (`tests/fuzz`).

use serde_json::{Value, json};

/// Component types of accessors, as the format numbers them.
pub(crate) const I8: u32 = 5120;
pub(crate) const U8: u32 = 5121;
pub(crate) const I16: u32 = 5122;
pub(crate) const U16: u32 = 5123;
pub(crate) const U32: u32 = 5125;
pub(crate) const F32: u32 = 5126;

/// A document, and the bytes of its one buffer.
#[derive(Clone, Debug)]
pub(crate) struct TestModel {
    pub(crate) json: Value,
    pub(crate) bytes: Vec<u8>,
}

impl TestModel {
    /// A document with one scene, without nodes.
    pub(crate) fn new() -> Self {
        Self {
            json: json!({ "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [] }] }),
            bytes: Vec::new(),
        }
    }

    /// A square of side 2 in the plane z = 0, as one node.
    pub(crate) fn square() -> Self {
        let mut model = Self::new();
        let positions = model.floats("VEC3", 3, &SQUARE);
        let indices = model.numbers(U16, "SCALAR", 6, &words(&[0, 1, 2, 2, 1, 3]));
        model.mesh(json!({ "attributes": { "POSITION": positions }, "indices": indices }));
        model.node(json!({ "mesh": 0 }));
        model
    }

    /// Adds an element to one of the document's lists, and returns its index.
    pub(crate) fn add(&mut self, list: &str, value: Value) -> usize {
        let document = self.json.as_object_mut().expect("an object");
        let list = document.entry(list).or_insert_with(|| json!([]));
        let list = list.as_array_mut().expect("a list");
        list.push(value);
        list.len() - 1
    }

    /// Adds a root node to the first scene.
    pub(crate) fn node(&mut self, node: Value) -> usize {
        let index = self.add("nodes", node);
        let roots = self.json["scenes"][0]["nodes"].as_array_mut();
        roots.expect("a list").push(json!(index));
        index
    }

    /// Adds a mesh of one primitive.
    pub(crate) fn mesh(&mut self, primitive: Value) -> usize {
        self.add("meshes", json!({ "primitives": [primitive] }))
    }

    /// Adds a view of bytes that are appended to the buffer.
    pub(crate) fn view(&mut self, bytes: &[u8]) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let offset = self.bytes.len();
        self.bytes.extend(bytes);
        self.add(
            "bufferViews",
            json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() }),
        )
    }

    /// Adds an accessor with its bytes.
    pub(crate) fn numbers(
        &mut self,
        component: u32,
        kind: &str,
        count: usize,
        bytes: &[u8],
    ) -> usize {
        let view = self.view(bytes);
        self.add(
            "accessors",
            json!({ "bufferView": view, "componentType": component, "type": kind, "count": count }),
        )
    }

    /// Adds an accessor of floats, `width` for each element.
    pub(crate) fn floats(&mut self, kind: &str, width: usize, numbers: &[f32]) -> usize {
        let bytes: Vec<u8> = numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
        self.numbers(F32, kind, numbers.len() / width, &bytes)
    }

    /// Returns the document with its buffer. `uri` is the URI of the buffer.
    pub(crate) fn text(&self, uri: Option<&str>) -> String {
        let mut json = self.json.clone();
        if !self.bytes.is_empty() {
            let mut buffer = json!({ "byteLength": self.bytes.len() });
            if let Some(uri) = uri {
                buffer["uri"] = json!(uri);
            }
            json["buffers"] = json!([buffer]);
        }
        json.to_string()
    }

    /// Returns the model in one file.
    pub(crate) fn glb(&self) -> Vec<u8> {
        glb(self.text(None).as_bytes(), &self.bytes)
    }
}

/// Combines a document and a buffer into one file.
pub(crate) fn glb(json: &[u8], bytes: &[u8]) -> Vec<u8> {
    let mut out = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
    for (kind, chunk, filler) in [(b"JSON", json, b' '), (b"BIN\0", bytes, 0)] {
        let length = chunk.len().next_multiple_of(4);
        out.extend((length as u32).to_le_bytes());
        out.extend(kind);
        out.extend(chunk);
        out.resize(out.len() + length - chunk.len(), filler);
    }
    let length = (out.len() as u32).to_le_bytes();
    out[8..12].copy_from_slice(&length);
    out
}

/// Returns the bytes of 16-bit numbers.
pub(crate) fn words(numbers: &[u16]) -> Vec<u8> {
    numbers.iter().flat_map(|n| n.to_le_bytes()).collect()
}

/// Corners of a square.
pub(crate) const SQUARE: [f32; 12] = [
    -1.0, -1.0, 0.0, 1.0, -1.0, 0.0, -1.0, 1.0, 0.0, 1.0, 1.0, 0.0,
];

/// Returns models that together cover everything that is read, as initial inputs for fuzzers.
pub(crate) fn first_inputs() -> Vec<TestModel> {
    vec![
        scene_with_all(),
        looks(),
        sparse_and_quantised(),
        TestModel::square(),
    ]
}

/// Nodes below nodes, cameras, lights, several scenes.
fn scene_with_all() -> TestModel {
    let mut model = TestModel::square();
    let lamp = |kind: &str| json!({ "type": kind, "intensity": 5, "color": [1, 0.5, 0.25], "extras": { "radius": 0.25 } });
    let mut spot = lamp("spot");
    spot["spot"] = json!({ "innerConeAngle": 0.2, "outerConeAngle": 0.6 });
    model.json["extensions"] = json!({
        "KHR_lights_punctual": { "lights": [lamp("directional"), lamp("point"), spot] },
    });
    model.add(
        "cameras",
        json!({ "type": "perspective", "perspective": { "yfov": 0.8, "znear": 0.1, "aspectRatio": 1.5 } }),
    );
    model.add(
        "cameras",
        json!({ "type": "orthographic", "orthographic": { "xmag": 3, "ymag": 2, "znear": 0, "zfar": 50 } }),
    );
    let light = |i: usize| json!({ "KHR_lights_punctual": { "light": i } });
    let child = model.add(
        "nodes",
        json!({ "mesh": 0, "name": "child", "scale": [1, -2, 1] }),
    );
    model.node(
        json!({ "children": [child], "rotation": [0, 0.6, 0, 0.8], "translation": [1, 2, 3] }),
    );
    model.node(json!({ "camera": 0, "translation": [0, 0, 9] }));
    model.node(json!({ "camera": 1, "translation": [0, 0, 9] }));
    for i in 0..3 {
        model.node(json!({ "extensions": light(i), "translation": [0, 3, 4], "rotation": [-0.6, 0, 0, 0.8] }));
    }
    model.add("scenes", json!({ "name": "other", "nodes": [child] }));
    model
}

/// Textures, an alpha test, normals, tangents, and transformed coordinates.
fn looks() -> TestModel {
    let mut model = TestModel::new();
    let positions = model.floats("VEC3", 3, &SQUARE);
    let normals = model.floats("VEC3", 3, &[0.0, 0.0, 1.0].repeat(4));
    let tangents = model.floats("VEC4", 4, &[1.0, 0.0, 0.0, 1.0].repeat(4));
    let uvs = model.floats("VEC2", 2, &[0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0]);
    model.mesh(json!({
        "attributes": { "POSITION": positions, "NORMAL": normals, "TANGENT": tangents, "TEXCOORD_0": uvs },
        "mode": 5, "material": 0,
    }));
    let moved =
        json!({ "KHR_texture_transform": { "offset": [0.5, 0], "rotation": 1, "scale": [2, 3] } });
    model.add("materials", json!({
        "alphaMode": "MASK", "alphaCutoff": 0.25, "emissiveFactor": [0.1, 0, 0], "normalTexture": { "index": 0, "extensions": moved },
        "pbrMetallicRoughness": { "baseColorFactor": [1, 0.5, 0.25, 0.75], "baseColorTexture": { "index": 0, "extensions": moved } },
    }));
    model.add("textures", json!({ "source": 0 }));
    let view = model.view(PICTURE);
    model.add(
        "images",
        json!({ "bufferView": view, "mimeType": "image/png" }),
    );
    model.node(json!({ "mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 5, 6, 7, 1] }));
    model
}

/// 8-bit positions, sparse elements, and a fan without indices.
fn sparse_and_quantised() -> TestModel {
    let mut model = TestModel::new();
    let positions = model.numbers(
        I8,
        "VEC3",
        5,
        &[
            0, 0, 0, 0, 127, 0, 0, 0, 127, 127, 0, 0, 129, 0, 0, 0, 127, 129, 0, 0,
        ],
    );
    let (stride, normalized) = (json!(4), json!(true));
    model.json["bufferViews"][0]["byteStride"] = stride;
    model.json["accessors"][0]["normalized"] = normalized;
    let at = model.view(&[1, 3]);
    let values = model.view(&[10, 20, 30, 40, 50, 60]);
    model.json["accessors"][0]["sparse"] = json!({
        "count": 2,
        "indices": { "bufferView": at, "componentType": U8 },
        "values": { "bufferView": values },
    });
    model.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    model.mesh(json!({ "attributes": { "POSITION": positions }, "mode": 6 }));
    model.node(json!({ "mesh": 0 }));
    model
}

/// A PNG file of 2 x 1 texels: grey with alpha, 8 bits; an opaque white one, and a transparent
/// black one.
pub(crate) const PICTURE: &[u8] = &[
    137, 80, 78, 71, 13, 10, 26, 10, 0, 0, 0, 13, 73, 72, 68, 82, 0, 0, 0, 2, 0, 0, 0, 1, 8, 4, 0,
    0, 0, 94, 43, 183, 1, 0, 0, 0, 13, 73, 68, 65, 84, 120, 218, 99, 248, 255, 159, 129, 1, 0, 6,
    254, 1, 255, 42, 220, 71, 245, 0, 0, 0, 0, 73, 69, 78, 68, 174, 66, 96, 130,
];
