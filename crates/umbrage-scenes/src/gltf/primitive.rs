//! Meshes. Each primitive becomes a mesh, since it has one material.

use super::{
    accessor::AccessorNumbers,
    document::{broken_element, element_name},
    file_bytes::FileBytes,
    material::{Materials, SurfaceLook},
    pose::Pose,
    wrap,
};
use crate::{detail::with_tangents, far, model_part::ModelPart};
use gltf::{Accessor, Mesh as FileMesh, Primitive, Semantic, mesh::Mode};
use std::collections::{HashMap, hash_map::Entry};
use umbrage_core::glam::{DVec3, Vec3, Vec4};
use umbrage_core::{Invalid, Mesh, Scene};

/// The meshes of a file that have been read, by number and pose.
#[derive(Debug, Default)]
pub(super) struct FileMeshes {
    known: HashMap<(usize, PoseKey), Vec<ModelPart>>,
}

/// Weights of morph targets as bits, and a skin.
type PoseKey = (Vec<u32>, Option<usize>);

impl FileMeshes {
    /// Returns a mesh's parts: its primitives that have triangles, unless an alpha test removes all
    /// of them.
    pub(super) fn parts(
        &mut self,
        mesh: &FileMesh<'_>,
        pose: &Pose,
        data: &mut FileBytes<'_>,
        materials: &mut Materials<'_>,
        scene: &mut Scene,
    ) -> Result<&[ModelPart], Invalid> {
        let index = mesh.index();
        let place = match self.known.entry((index, pose.key())) {
            Entry::Occupied(known) => return Ok(known.into_mut()),
            Entry::Vacant(place) => place,
        };
        let mut parts = Vec::new();
        for primitive in mesh.primitives() {
            let within = |e: Invalid| {
                let mesh = element_name("mesh", index, mesh.name());
                e.within_context(format!("{mesh}, primitive {}", primitive.index()))
            };
            let part = part(&primitive, pose, data, materials, scene).map_err(within)?;
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
    pose: &Pose,
    data: &mut FileBytes<'_>,
    materials: &mut Materials<'_>,
    scene: &mut Scene,
) -> Result<Option<ModelPart>, Invalid> {
    // Read the triangles and the look.
    let Some(mut shape) = PrimitiveShape::read(primitive, data)? else {
        return Ok(None);
    };
    let Some(look) = materials.look_of(primitive, data, scene)? else {
        return Ok(None);
    };
    let SurfaceLook {
        material,
        coordinates,
        casts,
        wraps,
    } = look;
    let material_of_scene = material.map(|i| scene.materials[i]);
    let needs_tangents = material_of_scene.is_some_and(|m| m.normal_map.is_some());
    // Read normals, texture coordinates and tangents, as far as the look uses them.
    let normals: Vec<[f32; 3]> = shape.attribute(primitive, &Semantic::Normals, data)?;
    let mut mesh = Mesh {
        normals: normals.into_iter().map(Vec3::from_array).collect(),
        ..Mesh::default()
    };
    if let Some(coordinates) = coordinates {
        let set = Semantic::TexCoords(coordinates.set);
        let uvs: Vec<[f32; 2]> = shape.attribute(primitive, &set, data)?;
        mesh.uvs = uvs
            .into_iter()
            .map(|uv| coordinates.transformed_uv(uv))
            .collect();
        if mesh.uvs.iter().any(|uv| !uv.is_finite()) {
            let why = "exceeds the range of 32-bit floats";
            return Err(broken_element("texture transform", why));
        }
        if let Some(alpha) = material_of_scene.and_then(|m| m.alpha) {
            let texture = &scene.textures[alpha.texture];
            wrap::check(&mesh.uvs, wraps, texture, &alpha, &mut data.budget)?;
        }
        if needs_tangents && !coordinates.is_transformed {
            let tangents: Vec<[f32; 4]> = shape.attribute(primitive, &Semantic::Tangents, data)?;
            mesh.tangents = tangents.into_iter().map(Vec4::from_array).collect();
        }
    }
    // Move the vertices to the mesh's pose.
    let mut positions: Vec<DVec3> = std::mem::take(&mut shape.positions)
        .into_iter()
        .map(Vec3::as_dvec3)
        .collect();
    let is_skinned = pose.apply(primitive, &shape, &mut positions, &mut mesh.normals, data)?;
    if is_skinned {
        // Tangents don't follow the joints, and are recomputed.
        mesh.tangents.clear();
    }
    let offset;
    (mesh.positions, offset) = far::near_origin(&positions);
    mesh.triangles = shape.triangles;
    // Recompute normals and tangents if one of them is invalid.
    if mesh.normals.contains(&Vec3::ZERO) {
        mesh.normals.clear();
    }
    let is_tangent = |t: &Vec4| t.w.abs() == 1.0 && t.truncate() != Vec3::ZERO;
    if !mesh.tangents.iter().all(is_tangent) {
        mesh.tangents.clear();
    }
    // Compute missing normals and tangents.
    if mesh.normals.is_empty() {
        mesh = flat(&mesh);
    }
    if needs_tangents && mesh.tangents.is_empty() {
        mesh = with_tangents(&mesh)?;
    }
    scene.meshes.push(mesh);
    Ok(Some(ModelPart {
        casts,
        ..ModelPart::new(scene.meshes.len() - 1, material, offset)
    }))
}

/// Returns a mesh without normals and tangents whose triangles share no vertices. Averages of
/// normals at its vertices are then those of the triangles, which the specification requires for
/// files without normals (section 3.7.2.1).
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

/// Returns the name of a part for errors.
fn name_of_part(mesh: &FileMesh<'_>, primitive: &Primitive<'_>) -> String {
    let name = mesh.name().unwrap_or("mesh");
    match primitive.index() {
        0 => name.to_owned(),
        i => format!("{name} {i}"),
    }
}

/// The triangles of a primitive, and the positions of the vertices that they use.
#[derive(Debug)]
pub(super) struct PrimitiveShape {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    /// The used vertices of the file in ascending order. `None` if all are used.
    used: Option<Vec<u32>>,
    /// Number of vertices in the file.
    count: usize,
}

impl PrimitiveShape {
    /// Reads a primitive; `None` if it has no triangles.
    fn read(primitive: &Primitive<'_>, data: &mut FileBytes<'_>) -> Result<Option<Self>, Invalid> {
        let Some(accessor) = primitive.get(&Semantic::Positions) else {
            return Ok(None);
        };
        let positions = AccessorNumbers::open(accessor, data)?;
        if positions.is_without_bytes() {
            let why = "holds no positions: it has neither a buffer view nor sparse elements";
            return Err(positions.fault(why));
        }
        let count = positions.count();
        let indices = match primitive.indices() {
            Some(accessor) => {
                let indices = AccessorNumbers::open(accessor, data)?;
                let list = indices.indices(data)?;
                if let Some(beyond) = list.iter().find(|&&i| i as usize >= count) {
                    return Err(indices.fault(format!("names vertex {beyond} of {count}")));
                }
                list
            }
            None => {
                data.budget.read(count as u64)?;
                (0..count as u32).collect()
            }
        };
        let mut triangles = triangles(primitive.mode(), &indices)?;
        if triangles.is_empty() {
            return Ok(None);
        }
        let mut used = triangles.as_flattened().to_vec();
        used.sort_unstable();
        used.dedup();
        let used = (used.len() < count).then_some(used);
        if let Some(used) = &used {
            let place = |v: u32| used.partition_point(|&other| other < v) as u32;
            triangles.iter_mut().for_each(|t| *t = t.map(place));
        }
        let positions = positions.vectors(used.as_deref(), data)?;
        Ok(Some(Self {
            positions: positions.into_iter().map(Vec3::from_array).collect(),
            triangles,
            used,
            count,
        }))
    }

    /// Returns an attribute of the used vertices; empty if the primitive doesn't have it.
    pub(super) fn attribute<const N: usize>(
        &self,
        primitive: &Primitive<'_>,
        semantic: &Semantic,
        data: &mut FileBytes<'_>,
    ) -> Result<Vec<[f32; N]>, Invalid> {
        match primitive.get(semantic) {
            Some(accessor) => self.vectors(accessor, data),
            None => Ok(Vec::new()),
        }
    }

    /// Returns the vectors of an accessor for the used vertices.
    pub(super) fn vectors<const N: usize>(
        &self,
        accessor: Accessor<'_>,
        data: &mut FileBytes<'_>,
    ) -> Result<Vec<[f32; N]>, Invalid> {
        let numbers = AccessorNumbers::open(accessor, data)?;
        if numbers.count() != self.count {
            let (elements, vertices) = (numbers.count(), self.count);
            return Err(numbers.fault(format!("has {elements} elements for {vertices} vertices")));
        }
        numbers.vectors(self.used.as_deref(), data)
    }
}

/// Returns the triangles of a list of vertices; none for points and lines.
fn triangles(mode: Mode, list: &[u32]) -> Result<Vec<[u32; 3]>, Invalid> {
    match mode {
        Mode::Triangles => {
            let (triangles, rest) = list.as_chunks::<3>();
            if !rest.is_empty() {
                let why = format!("have {} corners, which is not a multiple of 3", list.len());
                return Err(broken_element("its triangles", why));
            }
            Ok(triangles.to_vec())
        }
        Mode::TriangleStrip => {
            // Reverse every second one, so that all have the same orientation.
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

/// Reports whether the corners differ. Strips skip ahead by triangles with a repeated corner.
fn has_three_corners(triangle: &[u32; 3]) -> bool {
    let [a, b, c] = *triangle;
    a != b && b != c && c != a
}
