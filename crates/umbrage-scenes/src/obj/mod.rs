//! Wavefront OBJ models. Names, lines and points are ignored; all faces of one material become one
//! mesh.

mod clean;
mod material;
#[cfg(test)]
mod material_tests;
mod parts;
#[cfg(test)]
mod tests;

use crate::{
    Files, SceneError,
    detail::TextureFiles,
    error::Place,
    far::{self, Box64},
    framing::frame,
    lone_model,
    model_part::ModelPart,
    model_triangles::ModelTriangles,
    polygon::triangulate,
};
use clean::CleanText;
use parts::Model;
use std::io::BufRead;
use std::path::Path;
use umbrage_core::glam::{DVec3, Vec2, Vec3};
use umbrage_core::{Camera, Geometry, Mesh, Scene};

/// Reads a lone model, with a floor, a camera and a sun: see [`lone_model`].
pub(crate) fn read_scene(path: &Path, files: &dyn Files) -> Result<Scene, SceneError> {
    let file = path.display().to_string();
    let invalid = |fault| SceneError::Invalid {
        file: file.clone(),
        fault,
    };
    let mut scene = Scene {
        name: name_of(path),
        ..Scene::default()
    };
    let parts = add(path, &mut TextureFiles::new(files), true, &mut scene)?;
    let mut bounds = Box64::EMPTY;
    parts
        .iter()
        .for_each(|part| part.add_to(&mut bounds, &scene.meshes));
    let anchor = bounds.anchor(None);
    scene
        .instances
        .extend(parts.iter().map(|part| part.instance(anchor)));
    scene.anchor = anchor;
    scene.notices.extend(far::notice(&file, anchor));
    let geometry = Geometry::bake(&scene).map_err(invalid)?;
    let place = Place {
        file: file.clone(),
        line: None,
        key: None,
    };
    lone_model::complete(&mut scene, &geometry, &place)?;
    Ok(scene)
}

/// Returns a camera that sees all of the geometry.
pub(crate) fn framing_camera(geometry: &Geometry, place: Place) -> Result<Camera, SceneError> {
    lone_model::check_size(geometry, &place)?;
    match frame(
        geometry,
        lone_model::FOV_Y_DEGREES.to_radians(),
        lone_model::SIZE,
    ) {
        Some(shot) => shot
            .camera(geometry, [None, None])
            .map_err(|fault| SceneError::Invalid {
                file: place.file,
                fault,
            }),
        None => Err(lone_model::too(geometry, &place)),
    }
}

/// Returns a scene's name for its file.
pub(crate) fn name_of(path: &Path) -> String {
    path.file_stem().map_or_else(
        || "scene".to_owned(),
        |stem| stem.to_string_lossy().into_owned(),
    )
}

/// Adds the faces of an OBJ file to a scene: a mesh for each material, or one mesh without looks
/// unless it `has_looks`.
pub(crate) fn add(
    path: &Path,
    textures: &mut TextureFiles<'_>,
    has_looks: bool,
    scene: &mut Scene,
) -> Result<Vec<ModelPart>, SceneError> {
    let files = textures.files;
    let unreadable = |e: &std::io::Error| SceneError::unreadable_file(path, e, files);
    let source = files.open(path).map_err(|e| unreadable(&e))?;
    let model = parse(path, source, &unreadable)?;
    parts::add(model, path, has_looks.then_some(textures), scene)
}

/// Reads the triangles of a model, in 64 bits.
pub(crate) fn read_triangles(path: &Path, files: &dyn Files) -> Result<ModelTriangles, SceneError> {
    let unreadable = |e: &std::io::Error| SceneError::unreadable_file(path, e, files);
    let source = files.open(path).map_err(|e| unreadable(&e))?;
    let (clean, mesh) = parse_faces(path, source, &unreadable)?;
    let vertices: Vec<DVec3> = mesh
        .positions
        .chunks_exact(3)
        .map(DVec3::from_slice)
        .collect();
    let (near, _) = far::near_origin(&vertices);
    let (triangles, _) = triangles(&mesh, &near);
    Ok(ModelTriangles {
        vertices,
        triangles,
        notices: clean.notices,
    })
}

/// Reads a model. `unreadable` creates the error of a source that fails.
fn parse(
    path: &Path,
    source: impl BufRead,
    unreadable: &dyn Fn(&std::io::Error) -> SceneError,
) -> Result<Model, SceneError> {
    let (clean, mesh) = parse_faces(path, source, unreadable)?;
    let mut notices = clean.notices;
    let (mesh, face, offset) = convert(name_of(path), &mesh, &mut notices);
    Ok(Model {
        mesh,
        offset,
        face,
        looks: clean.looks,
        notices,
    })
}

/// Returns the statements and the faces of a model, of which there is at least one.
fn parse_faces(
    path: &Path,
    source: impl BufRead,
    unreadable: &dyn Fn(&std::io::Error) -> SceneError,
) -> Result<(CleanText, tobj::Mesh), SceneError> {
    let clean = clean::clean(source, path, unreadable)?;
    let fault = |why: String, help: &str| SceneError::Fault {
        place: Place {
            file: path.display().to_string(),
            line: None,
            key: None,
        },
        why,
        help: help.to_owned(),
    };
    let options = tobj::LoadOptions {
        single_index: true,
        triangulate: false,
        ..tobj::GPU_LOAD_OPTIONS
    };
    let mut statements = clean.statements.as_slice();
    let parsed = tobj::load_obj_buf(&mut statements, &options, |_| Ok(Default::default()));
    let (models, _) =
        parsed.map_err(|e| fault(format!("can't be parsed: {e}"), "export the model again"))?;
    // There is one mesh, since no statement that would split it was kept.
    match models.into_iter().next() {
        Some(model) if clean.faces > 0 => Ok((clean, model.mesh)),
        _ => Err(fault(
            "has no face".to_owned(),
            "export the model with its faces (`f` lines)",
        )),
    }
}

/// Returns the mesh near the origin, the face of each triangle, and the mesh's offset.
fn convert(name: String, mesh: &tobj::Mesh, notices: &mut Vec<String>) -> (Mesh, Vec<u32>, DVec3) {
    let vectors = |numbers: &[f64]| -> Vec<DVec3> {
        numbers.chunks_exact(3).map(DVec3::from_slice).collect()
    };
    let (positions, offset) = far::near_origin(&vectors(&mesh.positions));
    // `tobj` skips attributes that some corners lack, so that the rest no longer lines up. Drop
    // such attributes.
    let mut normals: Vec<Vec3> = vectors(&mesh.normals).iter().map(|n| n.as_vec3()).collect();
    let are_unit = normals.iter().all(|n| n.is_finite() && *n != Vec3::ZERO);
    if normals.len() != positions.len() || !are_unit {
        if !normals.is_empty() {
            notices.push("normals are ignored: some corners have none, or zero, or NaN".to_owned());
        }
        normals.clear();
    }
    // OBJ counts v from the bottom.
    let mut uvs: Vec<Vec2> = mesh
        .texcoords
        .chunks_exact(2)
        .map(|uv| Vec2::new(uv[0] as f32, 1.0 - uv[1] as f32))
        .collect();
    if uvs.len() != positions.len() || uvs.iter().any(|uv| !uv.is_finite()) {
        if !uvs.is_empty() {
            let why = "texture coordinates are ignored: some corners have none, or NaN";
            notices.push(why.to_owned());
        }
        uvs.clear();
    }
    let (triangles, face) = triangles(mesh, &positions);
    let mesh = Mesh {
        name,
        normals,
        uvs,
        positions,
        triangles,
        ..Mesh::default()
    };
    (mesh, face, offset)
}

/// Returns the triangles, and the face of each.
fn triangles(mesh: &tobj::Mesh, positions: &[Vec3]) -> (Vec<[u32; 3]>, Vec<u32>) {
    if mesh.face_arities.is_empty() {
        let triangles = mesh.indices.as_chunks::<3>().0.to_vec();
        let count = triangles.len() as u32;
        return (triangles, (0..count).collect());
    }
    let mut triangles = Vec::with_capacity(mesh.indices.len() / 2);
    let mut faces = Vec::with_capacity(mesh.indices.len() / 2);
    let mut rest = mesh.indices.as_slice();
    for (i, &arity) in (0..).zip(&mesh.face_arities) {
        let (face, others) = rest.split_at(arity as usize);
        rest = others;
        let corners: Vec<Vec3> = face.iter().map(|&v| positions[v as usize]).collect();
        for triangle in triangulate(&corners) {
            triangles.push(triangle.map(|corner| face[corner as usize]));
            faces.push(i);
        }
    }
    (triangles, faces)
}
