//! The JSON of a file, after a check that all its indices are valid.

use gltf::{
    Document, Scene,
    json::{
        Path, Root,
        camera::Type,
        material::Material,
        mesh::{Mode, Semantic},
        validation::{Checked, Error, Validate as _},
    },
};
use serde_json::Value;
use std::collections::BTreeSet;
use umbrage_core::{Anchor, Invalid};

/// Extensions that a file may require because they are supported.
const READ: [&str; 5] = [
    "EXT_mesh_gpu_instancing",
    "KHR_lights_punctual",
    "KHR_mesh_quantization",
    "KHR_node_visibility",
    "KHR_texture_transform",
];
/// Start of the names of material extensions. These have no effect on the images here, so a file
/// may require them, too.
const LOOKS: &str = "KHR_materials_";

/// Reads and checks a document, and lists its ignored contents.
pub(super) fn parse(json: &[u8]) -> Result<(Document, Vec<String>), Invalid> {
    let (mut root, animations) = match Root::from_slice(json) {
        Ok(root) => {
            let animations = root.animations.len();
            (root, animations)
        }
        Err(error) => lenient_root(json).ok_or_else(|| unparsed_document(json, &error))?,
    };
    check_version(&root)?;
    check_extensions(&root)?;
    let notices = left_aside(&root, animations);
    strip(&mut root);
    check_indices(&root).map_err(|(path, why)| {
        let name = name_on(json, &path).map_or_else(String::new, |name| format!(" of `{name}`"));
        broken_element(format!("`{path}`{name}"), why)
    })?;
    Ok((Document::from_json_without_validation(root), notices))
}

/// Reads a document that the crate `gltf` refuses for a part that shadows don't need: animations of
/// other properties than those of nodes, and scenes without nodes. Returns it without animations,
/// and their number.
fn lenient_root(json: &[u8]) -> Option<(Root, usize)> {
    let mut document: Value = serde_json::from_slice(json).ok()?;
    let members = document.as_object_mut()?;
    let animations = members.remove("animations");
    let animations = animations
        .as_ref()
        .and_then(Value::as_array)
        .map_or(0, Vec::len);
    let scenes = members.get_mut("scenes").and_then(Value::as_array_mut);
    for scene in scenes
        .into_iter()
        .flatten()
        .filter_map(Value::as_object_mut)
    {
        scene
            .entry("nodes")
            .or_insert_with(|| Value::Array(Vec::new()));
    }
    let json = serde_json::to_vec(&document).ok()?;
    Some((Root::from_slice(&json).ok()?, animations))
}

/// Returns the nodes of a document as JSON, whose numbers have 64 bits. Empty if no node is far
/// from the origin.
pub(super) fn far_nodes(document: &Document, json: &[u8]) -> Vec<Value> {
    let is_far = |node: gltf::Node<'_>| {
        let [x, y, z, _] = node.transform().matrix()[3];
        let most = x.abs().max(y.abs()).max(z.abs());
        f64::from(most) > Anchor::REACH
    };
    if !document.nodes().any(is_far) {
        return Vec::new();
    }
    match serde_json::from_slice::<Value>(json) {
        Ok(mut value) => match value["nodes"].take() {
            Value::Array(nodes) => nodes,
            _ => Vec::new(),
        },
        Err(_) => Vec::new(),
    }
}

/// Returns a line for each feature that the document uses and the reader leaves aside.
fn left_aside(root: &Root, animations: usize) -> Vec<String> {
    let mut out = Vec::new();
    if animations > 0 {
        out.push(format!(
            "animations are ignored ({animations}): nodes keep their rest pose"
        ));
    }
    let primitives = || root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let flat_modes = [Mode::Points, Mode::Lines, Mode::LineLoop, Mode::LineStrip];
    let is_flat = |mode| flat_modes.map(Checked::Valid).contains(mode);
    let flat = primitives()
        .filter(|primitive| is_flat(&primitive.mode))
        .count();
    if flat > 0 {
        out.push(format!("points and lines are ignored ({flat} primitives)"));
    }
    let has = |is: fn(&Semantic) -> bool| {
        primitives()
            .flat_map(|primitive| primitive.attributes.keys())
            .any(|semantic| matches!(semantic, Checked::Valid(semantic) if is(semantic)))
    };
    if has(|semantic| matches!(semantic, Semantic::Colors(_))) {
        out.push("vertex colours (COLOR_n) are ignored".to_owned());
    }
    if has(|semantic| matches!(semantic, Semantic::Extras(_))) {
        out.push("attributes of applications (_NAME) are ignored".to_owned());
    }
    let textures = |is: fn(&Material) -> bool| root.materials.iter().any(is);
    let kinds = [
        (
            "metalness and roughness",
            textures(|m| {
                m.pbr_metallic_roughness
                    .metallic_roughness_texture
                    .is_some()
            }),
        ),
        ("occlusion", textures(|m| m.occlusion_texture.is_some())),
        ("emission", textures(|m| m.emissive_texture.is_some())),
    ];
    let kinds: Vec<&str> = kinds
        .iter()
        .filter(|(_, is)| *is)
        .map(|(kind, _)| *kind)
        .collect();
    if !kinds.is_empty() {
        out.push(format!("textures are ignored of: {}", kinds.join(", ")));
    }
    let is_ignored = |name: &&str| !READ.contains(name);
    let extensions: BTreeSet<&str> = root.extensions_used.iter().map(String::as_str).collect();
    let extensions: Vec<&str> = extensions.into_iter().filter(is_ignored).collect();
    if !extensions.is_empty() {
        out.push(format!("extensions are ignored: {}", extensions.join(", ")));
    }
    out
}

/// Returns the error of text that is not a document of version 2. Version 1 is named in the error,
/// since its lists have another syntax.
fn unparsed_document(json: &[u8], error: &serde_json::Error) -> Invalid {
    let document: Value = serde_json::from_slice(json).unwrap_or_default();
    match document["asset"]["version"].as_str() {
        Some(version) if !version.starts_with("2.") => other_version(version),
        _ => broken_element("its JSON", format!("can't be read: {error}")),
    }
}

fn other_version(version: &str) -> Invalid {
    Invalid::new(
        "asset",
        format!("is of version {version} of the format"),
        "export the model as glTF 2.0",
    )
}

fn check_version(root: &Root) -> Result<(), Invalid> {
    let version = &root.asset.version;
    if !version.starts_with("2.") {
        return Err(other_version(version));
    }
    match &root.asset.min_version {
        Some(least) if least != "2.0" => Err(other_version(least)),
        _ => Ok(()),
    }
}

fn check_extensions(root: &Root) -> Result<(), Invalid> {
    let is_known = |name: &str| READ.contains(&name) || name.starts_with(LOOKS);
    match root.extensions_required.iter().find(|name| !is_known(name)) {
        None => Ok(()),
        Some(name) => Err(Invalid::new(
            format!("extension `{name}`"),
            "is required by the file and not supported",
            format!(
                "export the model without it; supported extensions: {}",
                READ.join(", ")
            ),
        )),
    }
}

/// Removes everything that is not read, so that errors in it don't count.
fn strip(root: &mut Root) {
    root.animations.clear();
    for skin in &mut root.skins {
        skin.skeleton = None;
    }
    for sampler in &mut root.samplers {
        // Only the wrapping of samplers is read, where it is known.
        sampler.min_filter = None;
        sampler.mag_filter = None;
        for wrap in [&mut sampler.wrap_s, &mut sampler.wrap_t] {
            if matches!(wrap, Checked::Invalid) {
                *wrap = Checked::default();
            }
        }
    }
    for primitive in root.meshes.iter_mut().flat_map(|mesh| &mut mesh.primitives) {
        primitive.attributes.retain(|semantic, _| {
            matches!(
                semantic,
                Checked::Valid(
                    Semantic::Positions
                        | Semantic::Normals
                        | Semantic::Tangents
                        | Semantic::TexCoords(_)
                        | Semantic::Joints(_)
                        | Semantic::Weights(_)
                )
            )
        });
    }
    let samplers = root.samplers.len();
    for texture in &mut root.textures {
        texture.sampler = texture.sampler.filter(|index| index.value() < samplers);
    }
    for view in &mut root.buffer_views {
        view.target = None;
    }
    for accessor in &mut root.accessors {
        // The crate can't read empty lists.
        accessor.sparse = accessor.sparse.take().filter(|sparse| sparse.count.0 > 0);
    }
    for material in &mut root.materials {
        material.occlusion_texture = None;
        material.pbr_metallic_roughness.metallic_roughness_texture = None;
    }
}

/// Returns an error, with its path, if an index is out of range, or a word is not in the format.
fn check_indices(root: &Root) -> Result<(), (String, &'static str)> {
    // Check these two, which the crate's own check assumes.
    for (i, mesh) in root.meshes.iter().enumerate() {
        for (j, primitive) in mesh.primitives.iter().enumerate() {
            let positions = primitive
                .attributes
                .get(&Checked::Valid(Semantic::Positions));
            if positions.is_some_and(|index| index.value() >= root.accessors.len()) {
                let path = format!("meshes[{i}].primitives[{j}].attributes[\"POSITION\"]");
                return Err((path, reason(Error::IndexOutOfBounds)));
            }
        }
    }
    for (i, camera) in root.cameras.iter().enumerate() {
        let is_there = match camera.type_ {
            Checked::Valid(Type::Perspective) => camera.perspective.is_some(),
            Checked::Valid(Type::Orthographic) => camera.orthographic.is_some(),
            // Other values are found below.
            Checked::Invalid => true,
        };
        if !is_there {
            let why = "names a projection that the camera doesn't have";
            return Err((format!("cameras[{i}].type"), why));
        }
    }
    let mut first = None;
    root.validate(root, Path::new, &mut |path, error| {
        if first.is_none() {
            let path = path();
            if is_fault(path.as_str(), error) {
                first = Some((path.as_str().to_owned(), reason(error)));
            }
        }
    });
    first.map_or(Ok(()), Err)
}

/// Reports whether an error of the crate matters for the data that are read. Bounds of positions
/// are computed, not read; strides are checked at their use; extensions have been checked; an
/// accessor without a view contains zeros, by the specification.
fn is_fault(path: &str, error: Error) -> bool {
    let is_unread = [".min", ".max", ".byteStride"]
        .iter()
        .any(|end| path.ends_with(end));
    let is_view_of_accessor = path.starts_with("accessors[") && path.ends_with("].bufferView");
    let holds_zeros = is_view_of_accessor && error == Error::Missing;
    !is_unread && !holds_zeros && error != Error::Unsupported
}

fn reason(error: Error) -> &'static str {
    match error {
        Error::IndexOutOfBounds => "points to a missing element",
        Error::Missing => "is missing",
        Error::Oversize => "is too large",
        Error::Invalid | Error::Unsupported => "is not among the values that the format knows",
    }
}

/// Returns the name of the first element of a path such as `nodes[3].mesh`, if it has one.
fn name_on(json: &[u8], path: &str) -> Option<String> {
    let (list, rest) = path.split_once('[')?;
    let index: usize = rest.split_once(']')?.0.parse().ok()?;
    let document: Value = serde_json::from_slice(json).ok()?;
    Some(document[list][index]["name"].as_str()?.to_owned())
}

/// Returns the scene with the requested name or number, or else the default one, or else the first.
pub(super) fn scene<'a>(
    document: &'a Document,
    wanted: Option<&str>,
) -> Result<Scene<'a>, Invalid> {
    let Some(wanted) = wanted else {
        let first = || document.scenes().next();
        return document
            .default_scene()
            .or_else(first)
            .ok_or_else(|| Invalid::new("file", "has no scene", "export the model with a scene"));
    };
    let by_name = document.scenes().find(|scene| scene.name() == Some(wanted));
    let by_number = || document.scenes().nth(wanted.parse().ok()?);
    by_name.or_else(by_number).ok_or_else(|| {
        let there: Vec<String> = document
            .scenes()
            .take(20)
            .map(|scene| element_name("scene", scene.index(), scene.name()))
            .collect();
        Invalid::new(
            "file",
            format!("has no scene `{wanted}`"),
            format!(
                "there are: {}; name one after `#`, by its name or number",
                there.join(", ")
            ),
        )
    })
}

/// Returns the error of a damaged file, or one from a faulty program.
pub(super) fn broken_element(what: impl Into<String>, why: impl Into<String>) -> Invalid {
    let help = "export the model again; https://github.khronos.org/glTF-Validator lists all errors of a file";
    Invalid::new(what, why, help)
}

/// Returns the name of an element of a document for errors: ``node 3 `lamp` ``.
pub(super) fn element_name(kind: &str, index: usize, name: Option<&str>) -> String {
    match name {
        Some(name) if !name.is_empty() => format!("{kind} {index} `{name}`"),
        _ => format!("{kind} {index}"),
    }
}
