//! Wavefront OBJ models. Names, lines and points are left aside; all faces of one material become one mesh.

mod clean;
mod material;
#[cfg(test)]
mod material_tests;
mod parts;
#[cfg(test)]
mod tests;

use crate::{SceneError, detail::TextureFiles, error::Place, framing::frame, polygon::triangulate};
use clean::Cleaner;
use parts::Model;
pub(crate) use parts::Part;
use std::io::{BufRead, BufReader};
use std::path::Path;
use umbrage_core::glam::{Affine3A, UVec2, Vec2, Vec3};
use umbrage_core::{Camera, Geometry, Instance, Light, Mesh, Scene};

/// The picture of a model without a camera.
pub(crate) const SIZE: UVec2 = UVec2::new(640, 360);
/// Its full vertical angle, degrees.
pub(crate) const FOV_Y_DEGREES: f32 = 36.0;
/// The way the sun's light travels, in the framed camera's view: from the left, above and a little behind the eye, so
/// that parts throw shadows on each other in plain view.
const SUN_IN_VIEW: Vec3 = Vec3::new(0.75, -1.0, -0.15);
/// The sun's width in the sky, degrees.
const SUN_DEGREES: f32 = 0.53;
/// Sizes in metres between which 32-bit geometry works: areas are squared on the way to unit normals.
pub(crate) const SIZES: [f32; 2] = [1e-6, 1e8];

/// A model alone: framed, in the sun.
pub(crate) fn load_scene(path: &Path) -> Result<Scene, SceneError> {
    let file = path.display().to_string();
    let invalid = |source| SceneError::Invalid {
        file: file.clone(),
        source,
    };
    let mut scene = Scene {
        name: name_of(path),
        ..Scene::default()
    };
    for part in add(path, Some(&mut TextureFiles::default()), &mut scene)? {
        let mut instance = Instance::new(part.mesh, Affine3A::IDENTITY);
        instance.material = part.material;
        scene.instances.push(instance);
    }
    let geometry = Geometry::bake(&scene).map_err(invalid)?;
    let place = Place {
        file: file.clone(),
        line: None,
        key: None,
    };
    let camera = framed(&geometry, place)?;
    let direction = camera.world_from_view.transform_vector3(SUN_IN_VIEW);
    scene.lights.push(Light::Directional {
        direction,
        angular_diameter: SUN_DEGREES.to_radians(),
    });
    scene.cameras.push(camera);
    Ok(scene)
}

/// A camera that sees all of the geometry.
pub(crate) fn framed(geometry: &Geometry, place: Place) -> Result<Camera, SceneError> {
    let extent = geometry.bounds().extent().max_element();
    let shot = frame(geometry, FOV_Y_DEGREES.to_radians(), SIZE);
    match shot.filter(|_| (SIZES[0]..=SIZES[1]).contains(&extent)) {
        Some(shot) => shot
            .camera(geometry, [None, None])
            .map_err(|source| SceneError::Invalid {
                file: place.file,
                source,
            }),
        None => Err(SceneError::Fault {
            place,
            why: format!("is {extent:e} m across"),
            help: format!("scale it to between {:e} and {:e} m", SIZES[0], SIZES[1]),
        }),
    }
}

/// A scene's name from its file's.
pub(crate) fn name_of(path: &Path) -> String {
    path.file_stem().map_or_else(
        || "scene".to_owned(),
        |stem| stem.to_string_lossy().into_owned(),
    )
}

/// Adds the faces of an OBJ file to a scene: a mesh for each material, or one mesh without looks if no `files` are
/// given.
pub(crate) fn add(
    path: &Path,
    files: Option<&mut TextureFiles>,
    scene: &mut Scene,
) -> Result<Vec<Part>, SceneError> {
    parts::add(load(path)?, path, files, scene)
}

fn load(path: &Path) -> Result<Model, SceneError> {
    let open = || {
        let file = std::fs::File::open(path)?;
        // Else a directory opens, and fails on reading with less to say; a pipe might never end.
        if file.metadata()?.is_file() {
            Ok(file)
        } else {
            Err(std::io::Error::other("is not a file"))
        }
    };
    let file = open().map_err(|e| SceneError::unreadable(path, &e))?;
    read(path, BufReader::new(file))
}

fn read(path: &Path, source: impl BufRead) -> Result<Model, SceneError> {
    let mut clean = BufReader::new(Cleaner::new(source));
    let options = tobj::LoadOptions {
        single_index: true,
        triangulate: false,
        ..tobj::GPU_LOAD_OPTIONS
    };
    let parsed = tobj::load_obj_buf(&mut clean, &options, |_| Ok(Default::default()));
    let clean = clean.into_inner();
    let fault = |line, why: String, help: &str| {
        let place = Place {
            file: path.display().to_string(),
            line,
            key: None,
        };
        SceneError::Fault {
            place,
            why,
            help: help.to_owned(),
        }
    };
    if let Some(f) = clean.fault {
        return Err(fault(Some(f.line), f.why, f.help));
    }
    if let Some(error) = clean.failure {
        return Err(SceneError::unreadable(path, &error));
    }
    let (models, _) = parsed.map_err(|e| {
        fault(
            None,
            format!("can't be parsed: {e}"),
            "export the model again",
        )
    })?;
    // Nothing that would split it was handed on, so there is one.
    match models.into_iter().next().map(|model| model.mesh) {
        Some(mesh) if clean.faces > 0 => {
            let (mesh, face) = convert(name_of(path), &mesh);
            Ok(Model {
                mesh,
                face,
                looks: clean.looks,
            })
        }
        _ => Err(fault(
            None,
            "has no face".to_owned(),
            "export the model with its faces (`f` lines)",
        )),
    }
}

/// Returns the mesh, and the face to which each triangle belongs.
fn convert(name: String, mesh: &tobj::Mesh) -> (Mesh, Vec<u32>) {
    let positions: Vec<Vec3> = mesh
        .positions
        .chunks_exact(3)
        .map(Vec3::from_slice)
        .collect();
    // `tobj` skips what some corners lack, and the rest no longer lines up: such attributes are left out.
    let mut normals: Vec<Vec3> = mesh.normals.chunks_exact(3).map(Vec3::from_slice).collect();
    let are_unit = normals.iter().all(|n| n.is_finite() && *n != Vec3::ZERO);
    if normals.len() != positions.len() || !are_unit {
        normals.clear();
    }
    // OBJ counts v from the bottom.
    let mut uvs: Vec<Vec2> = mesh
        .texcoords
        .chunks_exact(2)
        .map(|uv| Vec2::new(uv[0], 1.0 - uv[1]))
        .collect();
    if uvs.len() != positions.len() || uvs.iter().any(|uv| !uv.is_finite()) {
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
    (mesh, face)
}

/// Returns the triangles, and the face to which each belongs.
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
