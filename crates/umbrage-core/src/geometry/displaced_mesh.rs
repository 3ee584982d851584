//! Meshes displaced by a texture: see [`displacement`](crate::geometry::displacement).

use crate::{
    Instance, Invalid, Mesh, Scene, Texture,
    geometry::{
        displacement::{displaced, height},
        subdivide::MAX_SUBDIVIDED_TRIANGLES,
        weld::{WeldedVertices, corner_normals, unit},
    },
};
use glam::{DVec3, Vec3};
use std::borrow::Cow;

/// Least cosine between two normals at one place that counts as smooth: 60 degrees, between the seams of bent surfaces
/// and the edges of boxes.
const SMOOTH: f32 = 0.5;
/// More vertices than this at one place are a fan, not an edge: comparing each with each would take forever.
const FAN: usize = 64;

/// The mesh of a valid scene's instance, displaced if its material says so. `baked` triangles are there already.
pub(crate) fn applied<'a>(
    scene: &'a Scene,
    instance: &Instance,
    baked: usize,
) -> Result<Cow<'a, Mesh>, Invalid> {
    let mesh = &scene.meshes[instance.mesh];
    let material = instance.material.map(|id| &scene.materials[id]);
    let Some((material, relief)) = material.and_then(|m| Some((m, m.displacement?))) else {
        return Ok(Cow::Borrowed(mesh));
    };
    mesh.check_subdivisions(
        relief.subdivisions,
        MAX_SUBDIVIDED_TRIANGLES.saturating_sub(baked),
    )?;
    let fine = with_normals(mesh).subdivided(relief.subdivisions)?;
    let moved = moved(&fine, &scene.textures[relief.texture], relief.lambda);
    Ok(Cow::Owned(if material.normal_map.is_some() {
        Mesh {
            positions: moved,
            ..fine
        }
    } else {
        with_fitting_normals(fine, moved)
    }))
}

impl Mesh {
    /// Each vertex moved along its unit normal by `lambda (2 h - 1)` metres, where h is the first channel of `heights`
    /// at its texture coordinates; shading normals fit the result. See [`displacement`](crate::geometry::displacement).
    ///
    /// # Errors
    /// Errors if the mesh or the texture is invalid, when the mesh has no texture coordinates, and when lambda is not
    /// finite.
    pub fn displaced(&self, heights: &Texture, lambda: f32) -> Result<Self, Invalid> {
        self.validate()?;
        heights.validate()?;
        crate::invalid::finite("lambda of the displacement", &[lambda])?;
        if self.uvs.is_empty() {
            let what = format!("mesh `{}`", self.name);
            let why = "has no texture coordinates to look up heights with";
            return Err(Invalid::new(what, why, "give it uvs"));
        }
        let mesh = with_normals(self).into_owned();
        let moved = moved(&mesh, heights, lambda);
        let mesh = with_fitting_normals(mesh, moved);
        mesh.validate()?;
        Ok(mesh)
    }
}

/// The mesh with its normals, or with averaged ones.
fn with_normals(mesh: &Mesh) -> Cow<'_, Mesh> {
    if !mesh.normals.is_empty() {
        return Cow::Borrowed(mesh);
    }
    let mut sums = vec![DVec3::ZERO; mesh.positions.len()];
    corner_normals(mesh).for_each(|(v, n)| sums[v as usize] += n);
    Cow::Owned(Mesh {
        normals: sums.into_iter().map(unit).collect(),
        ..mesh.clone()
    })
}

/// Where the vertices go; those of one place stay together.
fn moved(mesh: &Mesh, heights: &Texture, lambda: f32) -> Vec<Vec3> {
    let places = WeldedVertices::new(&mesh.positions);
    let offset = |(&n, &uv): (&Vec3, _)| {
        displaced(Vec3::ZERO, unit(n.as_dvec3()), height(heights, uv), lambda)
    };
    let offsets: Vec<Vec3> = mesh.normals.iter().zip(&mesh.uvs).map(offset).collect();
    // A mean of one is itself: a lone vertex goes where `displaced` would send it, bit for bit.
    mesh.positions
        .iter()
        .zip(places.shared_mean(&offsets))
        .map(|(&p, offset)| p + offset)
        .collect()
}

/// The mesh at new positions, its normals averaged from them: over all vertices of a place between which the surface
/// was smooth.
fn with_fitting_normals(mesh: Mesh, positions: Vec<Vec3>) -> Mesh {
    let places = WeldedVertices::new(&mesh.positions);
    let old = mesh
        .normals
        .iter()
        .map(|n| unit(n.as_dvec3()))
        .collect::<Vec<_>>();
    let mut out = Mesh { positions, ..mesh };
    let mut sums = vec![DVec3::ZERO; old.len()];
    corner_normals(&out).for_each(|(v, n)| sums[v as usize] += n);
    for place in 0..places.count() as u32 {
        let vertices = places.vertices(place);
        for &v in vertices {
            let smooth = |&&w: &&u32| {
                vertices.len() > FAN || w == v || old[v as usize].dot(old[w as usize]) > SMOOTH
            };
            let sum: DVec3 = vertices
                .iter()
                .filter(smooth)
                .map(|&w| sums[w as usize])
                .sum();
            out.normals[v as usize] = unit(sum);
        }
    }
    out
}

#[cfg(test)]
#[path = "displaced_mesh_tests.rs"]
mod tests;
