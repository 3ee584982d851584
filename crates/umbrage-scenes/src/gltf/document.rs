//! The JSON of a file, after a check that all its indices are valid.

use gltf::{
    Document, Scene,
    json::{
        Path, Root,
        camera::Type,
        mesh::Semantic,
        validation::{Checked, Error, Validate as _},
    },
};
use serde_json::Value;
use umbrage_core::Invalid;

/// Extensions that a file may require because they are supported.
const READ: [&str; 3] = [
    "KHR_lights_punctual",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];
/// Start of the names of material extensions. These have no effect on the images here, so a file
/// may require them, too.
const LOOKS: &str = "KHR_materials_";

/// Reads and checks a document.
pub(super) fn parse(json: &[u8]) -> Result<Document, Invalid> {
    let mut root: Root = match serde_json::from_slice(json) {
        Ok(root) => root,
        Err(error) => return Err(unparsed_document(json, &error)),
    };
    check_version(&root)?;
    check_extensions(&root)?;
    strip(&mut root);
    check_indices(&root).map_err(|(path, why)| {
        let name = name_on(json, &path).map_or_else(String::new, |name| format!(" of `{name}`"));
        broken_element(format!("`{path}`{name}"), why)
    })?;
    Ok(Document::from_json_without_validation(root))
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
    root.skins.clear();
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
    for node in &mut root.nodes {
        node.skin = None;
    }
    for primitive in root.meshes.iter_mut().flat_map(|mesh| &mut mesh.primitives) {
        primitive.targets = None;
        primitive.attributes.retain(|semantic, _| {
            matches!(
                semantic,
                Checked::Valid(
                    Semantic::Positions
                        | Semantic::Normals
                        | Semantic::Tangents
                        | Semantic::TexCoords(_)
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
