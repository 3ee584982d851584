//! Meshes: each primitive becomes a mesh, since it has one material.

use super::{
    accessor::AccessorNumbers,
    broken,
    budget::ReadBudget,
    buffers::Buffers,
    material::{Materials, SurfaceLook},
    told, wrap,
};
use crate::detail::with_tangents;
use gltf::{Mesh as FileMesh, Primitive, Semantic, mesh::Mode};
use std::collections::{HashMap, hash_map::Entry};
use umbrage_core::glam::{Vec3, Vec4};
use umbrage_core::{Invalid, Mesh, Scene};

/// Vertices are read whole if there are at most so many for each index. Files that give many primitives one long list of vertices would take
/// as long for each as for all, so there only those are read that are used.
const VERTICES_AN_INDEX: usize = 4;

/// A mesh of the scene, and what it wears.
#[derive(Clone, Copy, Debug)]
pub(super) struct PrimitiveMesh {
    pub(super) mesh: usize,
    pub(super) material: Option<usize>,
    pub(super) casts: bool,
}

/// The meshes of a file that were read, by their number.
#[derive(Debug, Default)]
pub(super) struct FileMeshes {
    known: HashMap<usize, Vec<PrimitiveMesh>>,
}

impl FileMeshes {
    /// Returns a mesh's parts: those of its primitives that have triangles and are not cut out altogether.
    pub(super) fn parts(
        &mut self,
        mesh: &FileMesh<'_>,
        buffers: &mut Buffers<'_>,
        materials: &mut Materials<'_>,
        budget: &mut ReadBudget,
        scene: &mut Scene,
    ) -> Result<&[PrimitiveMesh], Invalid> {
        let index = mesh.index();
        let place = match self.known.entry(index) {
            Entry::Occupied(known) => return Ok(known.into_mut()),
            Entry::Vacant(place) => place,
        };
        let mut parts = Vec::new();
        for primitive in mesh.primitives() {
            let within = |e: Invalid| {
                let mesh = told("mesh", index, mesh.name());
                e.within(format!("{mesh}, primitive {}", primitive.index()))
            };
            let part = part(&primitive, buffers, materials, budget, scene).map_err(within)?;
            if let Some(part) = part {
                scene.meshes[part.mesh].name = name_of_part(mesh, &primitive);
                parts.push(part);
            }
        }
        Ok(place.insert(parts))
    }
}

fn part(
    primitive: &Primitive<'_>,
    buffers: &mut Buffers<'_>,
    materials: &mut Materials<'_>,
    budget: &mut ReadBudget,
    scene: &mut Scene,
) -> Result<Option<PrimitiveMesh>, Invalid> {
    let Some((corners, positions)) = shape(primitive, buffers, budget)? else {
        return Ok(None);
    };
    let look = materials.look_of(primitive, buffers, budget, scene)?;
    let SurfaceLook::Visible {
        material,
        coordinates,
        casts,
        wraps,
    } = look
    else {
        return Ok(None);
    };
    let needs_tangents = material.is_some_and(|i| scene.materials[i].normal_map.is_some());
    let mut read = Attributes {
        corners: &corners,
        buffers,
        budget,
    };
    let mut mesh = Mesh {
        positions,
        normals: read.normals(primitive)?,
        ..Mesh::default()
    };
    if let Some(coordinates) = coordinates {
        let uvs: Vec<[f32; 2]> = read.vectors(primitive, &Semantic::TexCoords(coordinates.set))?;
        mesh.uvs = uvs.into_iter().map(|uv| coordinates.at(uv)).collect();
        if mesh.uvs.iter().any(|uv| !uv.is_finite()) {
            return Err(broken(
                "texture transform",
                "leaves the range of 32-bit floats",
            ));
        }
        if let Some(alpha) = material.and_then(|i| scene.materials[i].alpha) {
            let texture = &scene.textures[alpha.texture];
            wrap::check(&mesh.uvs, wraps, texture, &alpha, read.budget)?;
        }
        if needs_tangents && !coordinates.is_transformed {
            mesh.tangents = read.tangents(primitive)?;
        }
    }
    mesh.triangles = corners.triangles;
    if mesh.normals.is_empty() {
        mesh = flat(&mesh);
    }
    if needs_tangents && mesh.tangents.is_empty() {
        mesh = with_tangents(&mesh)?;
    }
    scene.meshes.push(mesh);
    Ok(Some(PrimitiveMesh {
        mesh: scene.meshes.len() - 1,
        material,
        casts,
    }))
}

/// Returns a mesh without normals and tangents whose triangles share no vertices. Normals that are averaged at its vertices are then those
/// of the triangles, which the specification asks for where a file has none (section 3.7.2.1).
fn flat(mesh: &Mesh) -> Mesh {
    fn of_corners<T: Copy>(corners: &[u32], values: &[T]) -> Vec<T> {
        match values {
            [] => Vec::new(),
            _ => corners.iter().map(|&v| values[v as usize]).collect(),
        }
    }
    let corners = mesh.triangles.as_flattened();
    let apart: Vec<u32> = (0..corners.len() as u32).collect();
    Mesh {
        positions: of_corners(corners, &mesh.positions),
        uvs: of_corners(corners, &mesh.uvs),
        triangles: apart.as_chunks::<3>().0.to_vec(),
        ..Mesh::default()
    }
}

/// Returns the name that errors tell a part by.
fn name_of_part(mesh: &FileMesh<'_>, primitive: &Primitive<'_>) -> String {
    let name = mesh.name().unwrap_or("mesh");
    match primitive.index() {
        0 => name.to_owned(),
        i => format!("{name} {i}"),
    }
}

/// Which vertices make up the triangles.
#[derive(Debug)]
struct PrimitiveTriangles {
    triangles: Vec<[u32; 3]>,
    /// The vertices that are read, in rising order, if these are not all: triangles count them.
    read: Option<Vec<u32>>,
    /// Vertices of the file.
    count: usize,
}

/// Returns the triangles and the positions of a primitive; none if it has no triangles.
fn shape(
    primitive: &Primitive<'_>,
    buffers: &mut Buffers<'_>,
    budget: &mut ReadBudget,
) -> Result<Option<(PrimitiveTriangles, Vec<Vec3>)>, Invalid> {
    let Some(accessor) = primitive.get(&Semantic::Positions) else {
        return Ok(None);
    };
    let positions = AccessorNumbers::open(&accessor, buffers, budget)?;
    if positions.is_without_bytes() {
        return Err(
            positions.fault("holds no positions: it has neither a buffer view nor sparse elements")
        );
    }
    let count = positions.count();
    let indices = match primitive.indices() {
        Some(accessor) => {
            let indices = AccessorNumbers::open(&accessor, buffers, budget)?;
            let list = indices.indices(budget)?;
            if let Some(beyond) = list.iter().find(|&&i| i as usize >= count) {
                return Err(indices.fault(format!("names vertex {beyond} of {count}")));
            }
            list
        }
        None => {
            budget.read(count as u64)?;
            (0..count as u32).collect()
        }
    };
    let mut triangles = triangles(primitive.mode(), &indices)?;
    if triangles.is_empty() {
        return Ok(None);
    }
    let read = used(&triangles, count);
    if let Some(read) = &read {
        // What is looked for is there: the list is made of it.
        let place = |v: u32| read.partition_point(|&other| other < v) as u32;
        for triangle in &mut triangles {
            *triangle = triangle.map(place);
        }
    }
    let corners = PrimitiveTriangles {
        triangles,
        read,
        count,
    };
    let positions = positions.vectors(corners.read.as_deref(), budget)?;
    let positions = positions.into_iter().map(Vec3::from_array).collect();
    Ok(Some((corners, positions)))
}

/// Returns the vertices that triangles use, in rising order; none if these are all of so many.
fn used(triangles: &[[u32; 3]], count: usize) -> Option<Vec<u32>> {
    let corners = triangles.as_flattened();
    if count <= VERTICES_AN_INDEX * corners.len() {
        let mut is_used = vec![false; count];
        for &corner in corners {
            is_used[corner as usize] = true;
        }
        if is_used.iter().all(|&used| used) {
            return None;
        }
        let used = (0..count as u32).filter(|&v| is_used[v as usize]);
        return Some(used.collect());
    }
    let mut used = corners.to_vec();
    used.sort_unstable();
    used.dedup();
    Some(used)
}

/// Returns the triangles of a list of vertices; none for points and lines.
fn triangles(mode: Mode, list: &[u32]) -> Result<Vec<[u32; 3]>, Invalid> {
    match mode {
        Mode::Triangles => {
            let (triangles, rest) = list.as_chunks::<3>();
            if !rest.is_empty() {
                let why = format!("are made of {} corners, no multiple of 3", list.len());
                return Err(broken("its triangles", why));
            }
            Ok(triangles.to_vec())
        }
        Mode::TriangleStrip => {
            // Every second one is turned over, so that all face one way.
            let corners = |(i, three): (usize, &[u32])| match i % 2 {
                0 => [three[0], three[1], three[2]],
                _ => [three[0], three[2], three[1]],
            };
            let strip = list.windows(3).enumerate().map(corners);
            Ok(strip.filter(has_three_corners).collect())
        }
        Mode::TriangleFan => {
            let Some((&first, rim)) = list.split_first() else {
                return Ok(Vec::new());
            };
            let fan = rim.windows(2).map(|pair| [pair[0], pair[1], first]);
            Ok(fan.filter(has_three_corners).collect())
        }
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => Ok(Vec::new()),
    }
}

/// Strips jump by triangles that have a corner twice.
fn has_three_corners(triangle: &[u32; 3]) -> bool {
    let [a, b, c] = *triangle;
    a != b && b != c && c != a
}

/// Reads what vertices have besides positions.
struct Attributes<'a, 'b> {
    corners: &'a PrimitiveTriangles,
    buffers: &'a mut Buffers<'b>,
    budget: &'a mut ReadBudget,
}

impl Attributes<'_, '_> {
    /// Returns an attribute of the vertices that are read; empty if the primitive hasn't got it.
    fn vectors<const N: usize>(
        &mut self,
        primitive: &Primitive<'_>,
        semantic: &Semantic,
    ) -> Result<Vec<[f32; N]>, Invalid> {
        let Some(accessor) = primitive.get(semantic) else {
            return Ok(Vec::new());
        };
        let numbers = AccessorNumbers::open(&accessor, self.buffers, self.budget)?;
        if numbers.count() != self.corners.count {
            let why = format!(
                "has {} elements for {} vertices",
                numbers.count(),
                self.corners.count
            );
            return Err(numbers.fault(why));
        }
        numbers.vectors(self.corners.read.as_deref(), self.budget)
    }

    /// Returns the normals; empty if they are missing or one of them is zero: then those of the triangles are taken.
    fn normals(&mut self, primitive: &Primitive<'_>) -> Result<Vec<Vec3>, Invalid> {
        let normals = self.vectors(primitive, &Semantic::Normals)?;
        let normals: Vec<Vec3> = normals.into_iter().map(Vec3::from_array).collect();
        match normals.contains(&Vec3::ZERO) {
            true => Ok(Vec::new()),
            false => Ok(normals),
        }
    }

    /// Returns the tangents; empty if they are missing or one of them is none: then they are made.
    fn tangents(&mut self, primitive: &Primitive<'_>) -> Result<Vec<Vec4>, Invalid> {
        let tangents = self.vectors(primitive, &Semantic::Tangents)?;
        let tangents: Vec<Vec4> = tangents.into_iter().map(Vec4::from_array).collect();
        let is_tangent = |t: &Vec4| t.w.abs() == 1.0 && t.truncate() != Vec3::ZERO;
        match tangents.iter().all(is_tangent) {
            true => Ok(tangents),
            false => Ok(Vec::new()),
        }
    }
}
