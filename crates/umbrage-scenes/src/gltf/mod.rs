//! glTF 2.0 models: `.gltf`, and `.glb` with all in one file. The specification is by the Khronos
//! Group, <https://registry.khronos.org/glTF>.
//!
//! The crate `gltf` reads the JSON and the numbers of accessors. All references, lengths and counts
//! are checked here first, since the crate panics on some files.

mod accessor;
mod budget;
mod camera;
mod container;
mod document;
mod file_bytes;
mod instancing;
mod light;
mod material;
mod nodes;
mod picture;
mod pose;
mod primitive;
#[cfg(test)]
pub(crate) mod tests;
mod wrap;

use crate::{
    Files, SceneError,
    error::Place,
    far::{self, Box64},
    lone_model,
    model_part::ModelPart,
    obj::name_of,
    scene_of_file::SceneOfFile,
};
use budget::ReadBudget;
use file_bytes::FileBytes;
use gltf::Document;
use material::Materials;
use nodes::PlacedNode;
use pose::Pose;
use primitive::FileMeshes;
use std::{collections::HashMap, io::Read as _};
use umbrage_core::glam::DAffine3;
use umbrage_core::{Geometry, Invalid, Scene};

/// Reads one scene of a file. Missing cameras and lights are added as for any lone model: see
/// [`lone_model`].
pub(crate) fn read_scene(wanted: &SceneOfFile, files: &dyn Files) -> Result<Scene, SceneError> {
    let bytes = bytes_of(wanted, files)?;
    let mut scene = read(&bytes, wanted, files).map_err(|fault| invalid(wanted, fault))?;
    let geometry = Geometry::bake(&scene).map_err(|fault| invalid(wanted, fault))?;
    let place = Place {
        file: wanted.file.display().to_string(),
        line: None,
        key: None,
    };
    lone_model::add_missing(&mut scene, &geometry, &place)?;
    Ok(scene)
}

/// Adds the meshes of one scene of a file to another scene, with their materials if the model
/// `has_looks`. The file's cameras and lights are ignored, with a notice.
pub(crate) fn add(
    wanted: &SceneOfFile,
    files: &dyn Files,
    has_looks: bool,
    scene: &mut Scene,
) -> Result<Vec<ModelPart>, SceneError> {
    let bytes = bytes_of(wanted, files)?;
    let file = wanted.file.display();
    let ignore = |_: &[ModelPart], nodes: Vec<PlacedNode<'_>>, scene: &mut Scene| {
        let notice = ignored_nodes(&nodes).map(|what| format!("{file}: {what}"));
        scene.notices.extend(notice);
        Ok(())
    };
    parts(&bytes, wanted, files, has_looks, ignore, scene).map_err(|fault| invalid(wanted, fault))
}

/// Returns a line about the cameras and lights that a scene file replaces. `None` without any.
fn ignored_nodes(nodes: &[PlacedNode<'_>]) -> Option<String> {
    let cameras = nodes.iter().filter(|node| node.node.camera().is_some());
    // Lights that are off are absent everywhere. Invalid ones count.
    let is_on = |node: &&PlacedNode<'_>| {
        let light = node.node.light().filter(|_| node.is_visible);
        light.is_some_and(|light| !matches!(light::light(&light, node), Ok(None)))
    };
    let lights = nodes.iter().filter(is_on).count();
    let kinds: Vec<String> = [("cameras", cameras.count()), ("lights", lights)]
        .iter()
        .filter(|(_, count)| *count > 0)
        .map(|(kind, count)| format!("{kind} ({count})"))
        .collect();
    (!kinds.is_empty()).then(|| {
        let kinds = kinds.join(" and ");
        format!("{kinds} are ignored: those of the scene file are used")
    })
}

/// Reports whether one scene of a file has a light that is on. Its meshes are not read.
pub(crate) fn brings_light(wanted: &SceneOfFile, files: &dyn Files) -> Result<bool, SceneError> {
    let bytes = bytes_of(wanted, files)?;
    has_light(&bytes, wanted).map_err(|fault| invalid(wanted, fault))
}

fn has_light(bytes: &[u8], wanted: &SceneOfFile) -> Result<bool, Invalid> {
    let (document, _) = document::parse(container::split(bytes)?.json)?;
    let chosen = document::scene(&document, wanted.scene.as_deref())?;
    let mut lights = Scene::default();
    for node in nodes::placed_nodes(&document, chosen, &[])? {
        add_cameras_and_lights(&node, &mut lights)
            .map_err(|e| e.within_context(node.error_name()))?;
    }
    Ok(!lights.lights.is_empty())
}

fn bytes_of(wanted: &SceneOfFile, files: &dyn Files) -> Result<Vec<u8>, SceneError> {
    let mut bytes = Vec::new();
    files
        .open(&wanted.file)
        .and_then(|mut source| source.read_to_end(&mut bytes))
        .map_err(|e| SceneError::unreadable_file(&wanted.file, &e, files))?;
    Ok(bytes)
}

fn invalid(wanted: &SceneOfFile, fault: Invalid) -> SceneError {
    SceneError::Invalid {
        file: wanted.file.display().to_string(),
        fault,
    }
}

/// Reads a scene without the additions for a lone model.
fn read(bytes: &[u8], wanted: &SceneOfFile, files: &dyn Files) -> Result<Scene, Invalid> {
    let file = name_of(&wanted.file);
    let mut scene = Scene {
        name: match &wanted.scene {
            Some(chosen) => format!("{file}-{chosen}"),
            None => file,
        },
        ..Scene::default()
    };
    let file = wanted.file.display().to_string();
    let place = |parts: &[ModelPart], nodes: Vec<PlacedNode<'_>>, scene: &mut Scene| {
        place(parts, nodes, &file, scene)
    };
    parts(bytes, wanted, files, true, place, &mut scene)?;
    Ok(scene)
}

/// Adds instances of a file's parts, and the cameras and lights of its nodes, relative to an anchor
/// near the first camera if they are far from the origin.
fn place(
    parts: &[ModelPart],
    nodes: Vec<PlacedNode<'_>>,
    file: &str,
    scene: &mut Scene,
) -> Result<(), Invalid> {
    let mut bounds = Box64::EMPTY;
    parts
        .iter()
        .for_each(|part| part.add_to(&mut bounds, &scene.meshes));
    let camera = nodes.iter().find(|node| node.node.camera().is_some());
    let anchor = bounds.anchor(camera.map(|node| node.world_from_node.translation));
    scene.anchor = anchor;
    scene.notices.extend(far::notice(file, anchor));
    scene
        .instances
        .extend(parts.iter().map(|part| part.instance(anchor)));
    for mut node in nodes {
        node.world_from_node.translation -= anchor.point();
        add_cameras_and_lights(&node, scene).map_err(|e| e.within_context(node.error_name()))?;
    }
    Ok(())
}

/// Adds the meshes of a file's scene to a scene, with their materials if the model `has_looks`.
/// `add_others` receives the parts, and the nodes with their other contents.
fn parts(
    bytes: &[u8],
    wanted: &SceneOfFile,
    files: &dyn Files,
    has_looks: bool,
    add_others: impl FnOnce(&[ModelPart], Vec<PlacedNode<'_>>, &mut Scene) -> Result<(), Invalid>,
    scene: &mut Scene,
) -> Result<Vec<ModelPart>, Invalid> {
    let container = container::split(bytes)?;
    let (document, notices) = document::parse(container.json)?;
    let chosen = document::scene(&document, wanted.scene.as_deref())?;
    let budget = ReadBudget::new(bytes.len());
    let mut reader = Reader {
        data: FileBytes::new(&document, container.binary, budget, &wanted.file, files),
        materials: Materials::new(&document, has_looks),
        meshes: FileMeshes::default(),
        parts: Vec::new(),
        notices,
    };
    let far = document::far_nodes(&document, container.json);
    let nodes = nodes::placed_nodes(&document, chosen, &far)?;
    let place = |node: &PlacedNode<'_>| (node.node.index(), node.world_from_node);
    let joints = nodes.iter().map(place).collect();
    for node in &nodes {
        reader
            .add(node, &document, &joints, scene)
            .map_err(|e| e.within_context(node.error_name()))?;
    }
    reader.materials.decode_images(scene)?;
    if reader.parts.is_empty() {
        return Err(Invalid::new(
            "scene",
            "has no triangles",
            "export it with a mesh, or name another scene of the file: model.glb#1",
        ));
    }
    add_others(&reader.parts, nodes, scene)?;
    let file = wanted.file.display();
    let notices = reader.notices.into_iter().chain(reader.materials.notices());
    scene
        .notices
        .extend(notices.map(|notice| format!("{file}: {notice}")));
    Ok(reader.parts)
}

/// Data of a file that have been read.
struct Reader<'a> {
    data: FileBytes<'a>,
    materials: Materials<'a>,
    meshes: FileMeshes,
    parts: Vec<ModelPart>,
    /// Ignored contents of the file.
    notices: Vec<String>,
}

impl Reader<'_> {
    /// Adds the instances of a node's mesh, unless the node is hidden or scaled to nothing.
    /// `joints` has the placements of all nodes.
    fn add(
        &mut self,
        node: &PlacedNode<'_>,
        document: &Document,
        joints: &HashMap<usize, DAffine3>,
        scene: &mut Scene,
    ) -> Result<(), Invalid> {
        let Some(mesh) = node.node.mesh().filter(|_| node.is_visible) else {
            return Ok(());
        };
        let pose = Pose::of_node(node, joints, &mut self.data, &mut self.notices)?;
        // Joints place a skinned mesh, and its node doesn't.
        let places = if pose.skin.is_some() {
            vec![DAffine3::IDENTITY]
        } else {
            let mut places = Vec::new();
            for instance in instancing::instances(&node.node, document, &mut self.data)? {
                places.extend(node.placement(instance, &mut self.notices)?);
            }
            places
        };
        if places.is_empty() {
            return Ok(());
        }
        let primitives =
            self.meshes
                .parts(&mesh, &pose, &mut self.data, &mut self.materials, scene)?;
        for place in places {
            for primitive in primitives {
                let triangles = scene.meshes[primitive.mesh].triangles.len();
                self.data.budget.place(triangles)?;
                self.parts.push(ModelPart {
                    model_from_mesh: place * primitive.model_from_mesh,
                    ..*primitive
                });
            }
        }
        Ok(())
    }
}

fn add_cameras_and_lights(node: &PlacedNode<'_>, scene: &mut Scene) -> Result<(), Invalid> {
    if let Some(camera) = node.node.camera() {
        scene.cameras.push(camera::camera(&camera, node)?);
    }
    if let Some(light) = node.node.light().filter(|_| node.is_visible) {
        scene.lights.extend(light::light(&light, node)?);
    }
    Ok(())
}
