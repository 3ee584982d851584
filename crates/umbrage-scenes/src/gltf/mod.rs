//! glTF 2.0 models: `.gltf`, and `.glb` with all in one file. The specification is by the Khronos Group, <https://registry.khronos.org/glTF>.
//!
//! The crate `gltf` reads the JSON; everything that it refers to is checked here before it is followed, since the crate's own checks
//! and readers panic on some files. Numbers are read by [`accessor`], which knows how many bytes there are.

mod accessor;
mod budget;
mod buffers;
mod camera;
mod container;
mod document;
mod light;
mod material;
mod nodes;
mod picture;
mod primitive;
mod sparse;
#[cfg(test)]
mod tests;

use crate::{Files, SceneError, error::Place, lone_model, obj::name_of};
use budget::ReadBudget;
use buffers::Buffers;
use material::Materials;
use nodes::PlacedNode;
use primitive::FileMeshes;
use std::{
    io::Read as _,
    path::{Path, PathBuf},
};
use umbrage_core::glam::Affine3A;
use umbrage_core::{Geometry, Instance, Invalid, Scene};

/// What an argument names: a file, and one of its scenes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct SceneOfFile {
    pub(crate) file: PathBuf,
    /// The name or the number of a scene; the file's default scene if there is none.
    pub(crate) scene: Option<String>,
}

impl SceneOfFile {
    /// Parts `model.glb#2` or `model.glb#night` at the last `#`. None if it names no glTF file.
    pub(crate) fn of(path: &Path) -> Option<Self> {
        let whole = || Self {
            file: path.to_path_buf(),
            scene: None,
        };
        if is_gltf(path) {
            return Some(whole());
        }
        let (file, scene) = path.to_str()?.rsplit_once('#')?;
        is_gltf(Path::new(file)).then(|| Self {
            file: PathBuf::from(file),
            scene: Some(scene.to_owned()),
        })
    }
}

/// Returns whether a path ends as glTF files do.
fn is_gltf(path: &Path) -> bool {
    path.extension().is_some_and(|ending| {
        ending.eq_ignore_ascii_case("glb") || ending.eq_ignore_ascii_case("gltf")
    })
}

/// Reads one scene of a file. Cameras and lights that it lacks are found as for any model alone: see [`lone_model`].
pub(crate) fn read_scene(wanted: &SceneOfFile, files: &dyn Files) -> Result<Scene, SceneError> {
    let path = wanted.file.as_path();
    let file = path.display().to_string();
    let mut bytes = Vec::new();
    files
        .open(path)
        .and_then(|mut source| source.read_to_end(&mut bytes))
        .map_err(|e| SceneError::unreadable(path, &e, files))?;
    let invalid = |fault| SceneError::Invalid {
        file: file.clone(),
        fault,
    };
    let mut scene = read(&bytes, wanted, files).map_err(invalid)?;
    let geometry = Geometry::bake(&scene).map_err(invalid)?;
    let place = Place {
        file,
        line: None,
        key: None,
    };
    lone_model::add_missing(&mut scene, &geometry, &place)?;
    Ok(scene)
}

/// Reads what the file itself says.
fn read(bytes: &[u8], wanted: &SceneOfFile, files: &dyn Files) -> Result<Scene, Invalid> {
    let container = container::split(bytes)?;
    let document = document::parse(container.json)?;
    let chosen = document::scene(&document, wanted.scene.as_deref())?;
    let name = match &wanted.scene {
        Some(chosen) => format!("{}-{chosen}", name_of(&wanted.file)),
        None => name_of(&wanted.file),
    };
    let mut reader = Reader {
        buffers: Buffers::new(&document, container.binary, &wanted.file, files),
        materials: Materials::new(&document),
        meshes: FileMeshes::default(),
        budget: ReadBudget::new(bytes.len()),
        scene: Scene {
            name,
            ..Scene::default()
        },
    };
    for node in nodes::placed(&document, chosen)? {
        reader.add(&node).map_err(|e| e.within(node.told()))?;
    }
    let scene = reader.scene;
    if scene.instances.is_empty() {
        return Err(Invalid::new(
            "scene",
            "has no triangles",
            "export it with a mesh, or name another scene of the file: model.glb#1",
        ));
    }
    Ok(scene)
}

/// What was read of a file, and the scene that it becomes.
struct Reader<'a> {
    buffers: Buffers<'a>,
    materials: Materials<'a>,
    meshes: FileMeshes,
    budget: ReadBudget,
    scene: Scene,
}

impl Reader<'_> {
    /// Adds a node's camera, its light and its mesh.
    fn add(&mut self, node: &PlacedNode<'_>) -> Result<(), Invalid> {
        add_cameras_and_lights(node, &mut self.scene)?;
        let Some(mesh) = node.node.mesh() else {
            return Ok(());
        };
        // None: nodes that are scaled to nothing are hidden.
        let Some(world_from_local) = node.placement()? else {
            return Ok(());
        };
        let parts = self.meshes.parts(
            &mesh,
            &mut self.buffers,
            &mut self.materials,
            &mut self.budget,
            &mut self.scene,
        )?;
        place(parts, world_from_local, &mut self.budget, &mut self.scene)
    }
}

fn add_cameras_and_lights(node: &PlacedNode<'_>, scene: &mut Scene) -> Result<(), Invalid> {
    if let Some(camera) = node.node.camera() {
        scene.cameras.push(camera::camera(&camera, node)?);
    }
    if let Some(light) = node.node.light() {
        scene.lights.extend(light::light(&light, node)?);
    }
    Ok(())
}

/// Adds an instance for each part of a mesh.
fn place(
    parts: &[primitive::PrimitiveMesh],
    world_from_local: Affine3A,
    budget: &mut ReadBudget,
    scene: &mut Scene,
) -> Result<(), Invalid> {
    for part in parts {
        budget.place(scene.meshes[part.mesh].triangles.len())?;
        scene.instances.push(Instance {
            material: part.material,
            casts: part.casts,
            ..Instance::new(part.mesh, world_from_local)
        });
    }
    Ok(())
}

/// The error of a file that only damage or a faulty program could have made so.
fn broken(what: impl Into<String>, why: impl Into<String>) -> Invalid {
    let help = "export the model again; https://github.khronos.org/glTF-Validator tells all faults of a file";
    Invalid::new(what, why, help)
}

/// Tells a thing of a document in errors: ``node 3 `lamp` ``.
fn told(kind: &str, index: usize, name: Option<&str>) -> String {
    match name {
        Some(name) if !name.is_empty() => format!("{kind} {index} `{name}`"),
        _ => format!("{kind} {index}"),
    }
}
