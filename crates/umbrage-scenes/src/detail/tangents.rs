//! Tangent frames for normal maps.

use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use std::collections::HashMap;
use umbrage_core::glam::Vec4;
use umbrage_core::{Invalid, Mesh, WeldedVertices};

/// Returns the mesh with tangents for tangent-space normal maps, green up (OpenGL's convention).
/// The algorithm is Mikkelsen's (2008, "Simulation of Wrinkled Surfaces Revisited", `MikkTSpace`),
/// which programs that bake such maps use. A vertex is doubled where the frames of its triangles
/// differ: at mirrored texture coordinates and at hard edges of the texture. Missing shading
/// normals are averaged first, over all vertices of one position.
///
/// Texture coordinates count v from the top (like [`Mesh::uvs`]), and green points up. The
/// bitangent `w n x t` is therefore opposite to growing v. Triangles without area, in space or in
/// the texture, inherit the frames of their neighbours. Without neighbours, they have an arbitrary
/// frame around the normal.
///
/// # Errors
/// Returns an error if the mesh is invalid or has no texture coordinates.
pub fn with_tangents(mesh: &Mesh) -> Result<Mesh, Invalid> {
    mesh.validate()?;
    if mesh.uvs.is_empty() {
        let what = format!("mesh `{}`", mesh.name);
        let why = "has no texture coordinates for tangents to run along";
        return Err(Invalid::new(what, why, "add uvs"));
    }
    let mut frames = Frames {
        mesh: smooth(mesh),
        corners: vec![Vec4::ZERO; 3 * mesh.triangles.len()],
    };
    let made = generate_tangents(&mut frames);
    made.map_err(|e| {
        Invalid::new(
            format!("mesh `{}`", mesh.name),
            format!("{e:?}"),
            "check its texture coordinates",
        )
    })?;
    Ok(split(&frames))
}

fn smooth(mesh: &Mesh) -> Mesh {
    let mut mesh = mesh.clone();
    if mesh.normals.is_empty() {
        let places = WeldedVertices::new(&mesh.positions);
        let normals = places.normals(&mesh);
        mesh.normals = places
            .group_of()
            .iter()
            .map(|&place| normals[place as usize])
            .collect();
    }
    mesh.normals
        .iter_mut()
        .for_each(|n| *n = n.normalize_or_zero());
    mesh
}

struct Frames {
    mesh: Mesh,
    /// Tangents of the corners of all triangles.
    corners: Vec<Vec4>,
}

impl Frames {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.mesh.triangles[face][corner] as usize
    }
}

impl Geometry for Frames {
    fn num_faces(&self) -> usize {
        self.mesh.triangles.len()
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.mesh.positions[self.vertex(face, corner)].to_array()
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.mesh.normals[self.vertex(face, corner)].to_array()
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        let uv = self.mesh.uvs[self.vertex(face, corner)];
        // Count v upwards, like green.
        [uv.x, 1.0 - uv.y]
    }

    fn set_tangent(&mut self, tangent: Option<TangentSpace>, face: usize, corner: usize) {
        let normal = self.mesh.normals[self.vertex(face, corner)];
        let frame = tangent.map_or(Vec4::ZERO, |t| Vec4::from_array(t.tangent_encoded()));
        let usable = frame.is_finite() && frame.truncate().length_squared() > 0.5;
        let any = || {
            normal
                .try_normalize()
                .map_or(Vec4::new(1.0, 0.0, 0.0, 1.0), |n| {
                    n.any_orthonormal_vector().extend(1.0)
                })
        };
        self.corners[3 * face + corner] = if usable { frame } else { any() };
    }
}

/// Splits vertices, one for each distinct frame.
fn split(frames: &Frames) -> Mesh {
    let old = &frames.mesh;
    let mut out = Mesh {
        name: old.name.clone(),
        ..Mesh::default()
    };
    let mut known = HashMap::with_capacity(old.positions.len());
    let corners = old.triangles.iter().flatten().zip(&frames.corners);
    let vertices: Vec<u32> = corners
        .map(|(&v, &frame)| {
            *known
                .entry((v, frame.to_array().map(f32::to_bits)))
                .or_insert_with(|| {
                    out.positions.push(old.positions[v as usize]);
                    out.normals.push(old.normals[v as usize]);
                    out.uvs.push(old.uvs[v as usize]);
                    out.tangents.push(frame);
                    out.positions.len() as u32 - 1
                })
        })
        .collect();
    out.triangles = vertices.as_chunks::<3>().0.to_vec();
    out
}

#[cfg(test)]
#[path = "tangents_tests.rs"]
mod tests;
