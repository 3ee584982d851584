//! The triangles of a model alone.

use crate::{Files, SceneError, gltf, scene_of_file::SceneOfFile};
use umbrage_core::{Scene, glam::DVec3};

/// Triangles of a model in 64 bits, in the axes and the unit of its file. Nothing is added to them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ModelTriangles {
    /// Vertices.
    pub vertices: Vec<DVec3>,
    /// Three vertices each, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Ignored contents of the file, one line each.
    pub notices: Vec<String>,
}

/// Reads one scene of a glTF file. Alpha tests are ignored: all surfaces are opaque.
pub(crate) fn of_gltf(
    wanted: &SceneOfFile,
    files: &dyn Files,
) -> Result<ModelTriangles, SceneError> {
    let mut scene = Scene::default();
    let parts = gltf::add(wanted, files, false, &mut scene)?;
    let mut out = ModelTriangles {
        notices: scene.notices,
        ..ModelTriangles::default()
    };
    for part in parts {
        let mesh = &scene.meshes[part.mesh];
        let place = part.model_from_mesh;
        let first = out.vertices.len() as u32;
        let positions = mesh.positions.iter();
        out.vertices
            .extend(positions.map(|p| place.transform_point3(p.as_dvec3())));
        // Mirrored triangles keep their outside.
        let is_mirrored = place.matrix3.determinant() < 0.0;
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|corner| first + corner);
            out.triangles
                .push(if is_mirrored { [a, c, b] } else { [a, b, c] });
        }
    }
    Ok(out)
}
