//! Meshes displaced by a texture, see [`displacement`](crate::geometry::displacement).

use crate::{
    geometry::{
        displacement::{displaced, height},
        subdivide::MAX_SUBDIVIDED_TRIANGLES,
        weld::{WeldedVertices, corner_normals, unit},
    },
    invalid::Invalid,
    scene::{Instance, Mesh, Scene, material::Texture},
};
use glam::{DVec3, Vec3};
use std::borrow::Cow;

/// Least cosine between the normals of two vertices at one position that counts as smooth: 60
/// degrees, between the seams of curved surfaces and the edges of boxes.
const MIN_SMOOTH_COSINE: f32 = 0.5;
/// Greatest number of vertices at one position whose normals are compared pairwise. More vertices
/// are a fan, not an edge, and the comparison is quadratic.
const MAX_COMPARED: usize = 64;

/// Returns the mesh of a valid scene's instance, displaced if its material requires it. `baked` is
/// the number of triangles that the geometry already has.
pub(crate) fn apply_displacement<'a>(
    scene: &'a Scene,
    instance: &Instance,
    baked: usize,
) -> Result<Cow<'a, Mesh>, Invalid> {
    let mesh = &scene.meshes[instance.mesh];
    let Some(id) = instance.material else {
        return Ok(Cow::Borrowed(mesh));
    };
    let material = &scene.materials[id];
    let Some(relief) = material.displacement else {
        return Ok(Cow::Borrowed(mesh));
    };
    let room = MAX_SUBDIVIDED_TRIANGLES.saturating_sub(baked);
    mesh.check_subdivisions(relief.subdivisions, room)?;
    let fine = with_normals(mesh).subdivide(relief.subdivisions)?;
    let positions = displaced_positions(&fine, &scene.textures[relief.texture], relief.lambda);
    let displaced = if material.normal_map.is_some() {
        Mesh { positions, ..fine }
    } else {
        with_fitting_normals(fine, positions)
    };
    Ok(Cow::Owned(displaced))
}

impl Mesh {
    /// Returns the mesh with each vertex moved along its unit normal by `lambda (2 h - 1)` metres.
    /// Here h is the first channel of `heights` at the vertex's texture coordinate. Shading normals
    /// fit the result. See [`displacement`](crate::geometry::displacement).
    ///
    /// # Errors
    /// Errors if the mesh or the texture is invalid, the mesh has no texture coordinates, or lambda
    /// is not finite.
    pub fn displace_mesh(&self, heights: &Texture, lambda: f32) -> Result<Self, Invalid> {
        self.validate()?;
        heights.validate()?;
        crate::invalid::finite("lambda of the displacement", &[lambda])?;
        if self.uvs.is_empty() {
            let what = format!("mesh `{}`", self.name);
            let why = "has no texture coordinates for its heights";
            return Err(Invalid::new(what, why, "give it uvs"));
        }
        let mesh = with_normals(self).into_owned();
        let positions = displaced_positions(&mesh, heights, lambda);
        let mesh = with_fitting_normals(mesh, positions);
        mesh.validate()?;
        Ok(mesh)
    }
}

/// Returns the mesh with its own normals, or with averaged ones if it has none.
fn with_normals(mesh: &Mesh) -> Cow<'_, Mesh> {
    if !mesh.normals.is_empty() {
        return Cow::Borrowed(mesh);
    }
    let normals = normal_sums(mesh).into_iter().map(unit).collect();
    Cow::Owned(Mesh {
        normals,
        ..mesh.clone()
    })
}

/// Returns, for each vertex, the sum of its triangles' normals, weighted by twice the triangle's
/// area.
fn normal_sums(mesh: &Mesh) -> Vec<DVec3> {
    let mut sums = vec![DVec3::ZERO; mesh.positions.len()];
    for (vertex, normal) in corner_normals(mesh) {
        sums[vertex as usize] += normal;
    }
    sums
}

/// Returns the displaced positions of the vertices; those that share a position stay together.
fn displaced_positions(mesh: &Mesh, heights: &Texture, lambda: f32) -> Vec<Vec3> {
    let places = WeldedVertices::new(&mesh.positions);
    let mut offsets = Vec::with_capacity(mesh.positions.len());
    for (normal, &uv) in mesh.normals.iter().zip(&mesh.uvs) {
        let normal = unit(normal.as_dvec3());
        offsets.push(displaced(Vec3::ZERO, normal, height(heights, uv), lambda));
    }
    // Use the exact offset for a lone vertex, so that it is bit-equal to `displace_mesh`.
    let mut positions = mesh.positions.clone();
    for (position, offset) in positions.iter_mut().zip(places.shared_mean(&offsets)) {
        *position += offset;
    }
    positions
}

/// Returns the mesh at new positions, with normals averaged from them. Averages all vertices of one
/// original position between which the surface was smooth.
fn with_fitting_normals(mesh: Mesh, positions: Vec<Vec3>) -> Mesh {
    let places = WeldedVertices::new(&mesh.positions);
    let old: Vec<Vec3> = mesh.normals.iter().map(|n| unit(n.as_dvec3())).collect();
    let mut out = Mesh { positions, ..mesh };
    let sums = normal_sums(&out);
    for place in 0..places.count() as u32 {
        let vertices = places.vertices(place);
        for &v in vertices {
            let mut sum = DVec3::ZERO;
            for &w in vertices {
                let is_smooth = vertices.len() > MAX_COMPARED
                    || w == v
                    || old[v as usize].dot(old[w as usize]) > MIN_SMOOTH_COSINE;
                if is_smooth {
                    sum += sums[w as usize];
                }
            }
            out.normals[v as usize] = unit(sum);
        }
    }
    out
}

#[cfg(test)]
#[path = "displaced_mesh_tests.rs"]
mod tests;
