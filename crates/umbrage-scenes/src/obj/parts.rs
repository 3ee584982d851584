//! A model's parts: one mesh for each of its materials.

use super::material::{self, Entry, Losses, UNDEFINED};
use crate::{
    Files, SceneError,
    detail::{TextureFiles, with_tangents},
    model_part::ModelPart,
};
use std::collections::{BTreeSet, HashMap, HashSet};
use std::path::{Path, PathBuf};
use umbrage_core::glam::DVec3;
use umbrage_core::{Mesh, Scene};

/// Greatest number of names in a notice.
const MOST_ITEMS: usize = 20;

/// Material statements of a model's text.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Looks {
    /// Names of `.mtl` files.
    pub(super) libraries: Vec<String>,
    /// The first face of each run of faces with one material, and the material's name.
    pub(super) runs: Vec<(usize, String)>,
}

/// Adds a model's mesh to a scene, split by its existing materials.
pub(super) fn add(
    model: Model,
    path: &Path,
    files: Option<&mut TextureFiles<'_>>,
    scene: &mut Scene,
) -> Result<Vec<ModelPart>, SceneError> {
    let name = path.display();
    let notices = model.notices.iter();
    scene
        .notices
        .extend(notices.map(|notice| format!("{name}: {notice}")));
    // Read the materials. Without any, keep one mesh.
    let entries = match &files {
        Some(files) => entries(&model.looks, path, files.files, &mut scene.notices)?,
        None => Vec::new(),
    };
    let mut losses = Losses::new();
    let libraries = model.looks.libraries.iter();
    if let Some(files) = &files
        && libraries
            .map(|library| library_path(library, path))
            .all(|library| files.files.has(&library))
    {
        losses.extend(model.undefined(&entries));
    }
    let (Some(files), false) = (files, entries.is_empty()) else {
        list_losses(&losses, &name.to_string(), scene);
        scene.meshes.push(model.mesh);
        return Ok(vec![ModelPart::new(
            scene.meshes.len() - 1,
            None,
            model.offset,
        )]);
    };
    // Read the textures of all materials.
    let mut split = Vec::new();
    for (entry, mesh) in model.split(&entries) {
        let is_mapped = !mesh.uvs.is_empty();
        let textured = match entry {
            Some(i) => {
                let textures = &mut scene.textures;
                Some(entries[i].textured(is_mapped, files, textures, &mut losses)?)
            }
            None => None,
        };
        split.push((textured, mesh));
    }
    files.decode(&mut scene.textures)?;
    // Add a mesh for each material.
    let mut parts = Vec::new();
    for (textured, mut mesh) in split {
        let material = textured.map(|entry| entry.material(&scene.textures, &mut losses));
        if material.is_some_and(|m| m.normal_map.is_some()) {
            mesh = with_tangents(&mesh).map_err(|fault| SceneError::Invalid {
                file: path.display().to_string(),
                fault,
            })?;
        }
        scene.meshes.push(mesh);
        scene.materials.extend(material);
        let material = material.map(|_| scene.materials.len() - 1);
        parts.push(ModelPart {
            casts: textured.is_none_or(|entry| entry.casts),
            ..ModelPart::new(scene.meshes.len() - 1, material, model.offset)
        });
    }
    list_losses(&losses, &name.to_string(), scene);
    Ok(parts)
}

/// Appends a notice for each reason.
fn list_losses(losses: &Losses, model: &str, scene: &mut Scene) {
    for (reason, items) in losses {
        let items = list_of(items);
        scene.notices.push(format!("{model}: {reason}: {items}"));
    }
}

/// Returns a list of at most [`MOST_ITEMS`] names.
fn list_of(items: &BTreeSet<String>) -> String {
    let mut names: Vec<&str> = items.iter().take(MOST_ITEMS).map(String::as_str).collect();
    let others = format!("and {} others", items.len().saturating_sub(MOST_ITEMS));
    if items.len() > MOST_ITEMS {
        names.push(&others);
    }
    names.join(", ")
}

/// Returns the path of a library that a model names.
fn library_path(library: &str, model: &Path) -> PathBuf {
    let folder = model.parent().unwrap_or(Path::new(""));
    folder.join(library.replace('\\', "/"))
}

fn entries(
    looks: &Looks,
    path: &Path,
    files: &dyn Files,
    notices: &mut Vec<String>,
) -> Result<Vec<Entry>, SceneError> {
    let mut entries = Vec::new();
    for library in &looks.libraries {
        let library = library_path(library, path);
        if !files.has(&library) {
            notices.push(format!(
                "{}: is missing: {}",
                path.display(),
                library.display()
            ));
        }
        entries.extend(material::load(&library, files)?);
    }
    Ok(entries)
}

/// All faces of a file, and the names of their materials.
#[derive(Clone, Debug)]
pub(super) struct Model {
    pub(super) mesh: Mesh,
    /// Position of the mesh's origin in the file.
    pub(super) offset: DVec3,
    /// The face of each triangle.
    pub(super) face: Vec<u32>,
    pub(super) looks: Looks,
    /// Ignored contents of the file, one line each.
    pub(super) notices: Vec<String>,
}

impl Model {
    /// Returns the names of used materials that no entry defines.
    fn undefined(&self, entries: &[Entry]) -> Losses {
        let defined: HashSet<&str> = entries.iter().map(|entry| entry.name.as_str()).collect();
        let is_undefined = |name: &&String| !name.is_empty() && !defined.contains(name.as_str());
        let names = self.looks.runs.iter().map(|(_, name)| name);
        let names: BTreeSet<String> = names.filter(is_undefined).cloned().collect();
        let losses = [(UNDEFINED, names)].into_iter();
        losses.filter(|(_, names)| !names.is_empty()).collect()
    }

    /// Returns a mesh for each used entry, in the order of their first faces. Faces without a known
    /// material share one.
    fn split(&self, entries: &[Entry]) -> Vec<(Option<usize>, Mesh)> {
        // The first face of each run, and the run's entry.
        let mut named: Vec<(usize, Option<usize>)> = Vec::new();
        for (face, name) in &self.looks.runs {
            named.push((*face, entries.iter().position(|e| e.name == *name)));
        }
        let mut parts: Vec<(Option<usize>, Vec<[u32; 3]>)> = Vec::new();
        for (triangle, &face) in self.mesh.triangles.iter().zip(&self.face) {
            let run = named.partition_point(|(first, _)| *first <= face as usize);
            let entry = run.checked_sub(1).and_then(|i| named[i].1);
            match parts.iter_mut().find(|(e, _)| *e == entry) {
                Some((_, triangles)) => triangles.push(*triangle),
                None => parts.push((entry, vec![*triangle])),
            }
        }
        parts
            .into_iter()
            .map(|(entry, triangles)| (entry, self.part(&triangles)))
            .collect()
    }

    /// Returns a mesh of some triangles and their vertices.
    fn part(&self, triangles: &[[u32; 3]]) -> Mesh {
        let old = &self.mesh;
        let mut known = HashMap::new();
        let mut out = Mesh {
            name: old.name.clone(),
            ..Mesh::default()
        };
        let mut vertex = |v: u32| {
            *known.entry(v).or_insert_with(|| {
                out.positions.push(old.positions[v as usize]);
                out.normals.extend(old.normals.get(v as usize));
                out.uvs.extend(old.uvs.get(v as usize));
                out.positions.len() as u32 - 1
            })
        };
        let triangles = triangles.iter().map(|t| t.map(&mut vertex)).collect();
        Mesh { triangles, ..out }
    }
}
