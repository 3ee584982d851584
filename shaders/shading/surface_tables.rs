//! Geometry and materials of a scene as tables for both languages: vertices, triangles, materials,
//! texels.

use crate::shading::texture;
use glam::{UVec4, Vec2, Vec3, Vec4};
use std::{collections::HashSet, sync::Arc};
use umbrage_core::{Geometry, Invalid, Material, NO_MATERIAL, Scene, Table};

/// Rows per vertex: position and u; shading normal and v; tangent and handedness.
pub(crate) const VERTEX_ROWS: usize = 3;
/// Rows per material: diffuse colour and shininess (an integer); specular colour; emission; diffuse
/// texture; normal map.
pub(crate) const MATERIAL_ROWS: usize = 5;

/// Rows of four words.
type SurfaceRows = Arc<[[u32; 4]]>;

/// Tables of one scene. Cheap to clone.
#[derive(Clone, Debug)]
pub(crate) struct SurfaceTables {
    pub(crate) vertices: SurfaceRows,
    /// One row per triangle: its vertices, and the material in the fourth word.
    pub(crate) triangles: SurfaceRows,
    pub(crate) materials: SurfaceRows,
    pub(crate) texels: SurfaceRows,
}

impl SurfaceTables {
    /// Returns the tables of a valid scene and the geometry that was baked from it.
    ///
    /// # Errors
    /// Errors if the geometry refers to materials that the scene doesn't have.
    pub(crate) fn new(scene: &Scene, geometry: &Geometry) -> Result<Self, Invalid> {
        let count = scene.materials.len() as u32;
        if let Some(id) = geometry
            .materials()
            .iter()
            .find(|&&id| id >= count && id != NO_MATERIAL)
        {
            let why = format!("uses material {id}, but scene `{}` has {count}", scene.name);
            return Err(Invalid::new(
                "geometry",
                why,
                "shade it with the scene that it was baked from",
            ));
        }
        // Leave out the textures that are not shown: masks and heights are large.
        let shown: HashSet<usize> = scene
            .materials
            .iter()
            .flat_map(|material| [material.diffuse_texture, material.normal_map])
            .flatten()
            .collect();
        let textures = scene.textures.iter().enumerate();
        let textures: Vec<_> = textures
            .map(|(i, texture)| shown.contains(&i).then_some(texture))
            .collect();
        let (texels, places) = texture::rows(&textures);
        let mut materials = Vec::new();
        for material in &scene.materials {
            materials.extend(material_rows(material, &places));
        }
        // The default material comes last.
        materials.extend(material_rows(&Material::default(), &places));
        Ok(Self {
            vertices: or_zeros(vertex_rows(geometry), VERTEX_ROWS),
            triangles: or_zeros(triangle_rows(geometry, count), 1),
            materials: materials.into(),
            texels,
        })
    }

    /// Returns the tables in the order in which `surface.wgsl` numbers them.
    pub(crate) fn tables(&self) -> [Table; 4] {
        [
            Table {
                label: "vertices",
                rows: self.vertices.clone().into(),
            },
            Table {
                label: "triangles",
                rows: self.triangles.clone().into(),
            },
            Table {
                label: "materials",
                rows: self.materials.clone().into(),
            },
            Table {
                label: "texels",
                rows: self.texels.clone().into(),
            },
        ]
    }
}

/// Pads an empty table with `least` zero rows, because tables need at least one row. They are never
/// read.
fn or_zeros(rows: Vec<[u32; 4]>, least: usize) -> SurfaceRows {
    if rows.is_empty() {
        vec![[0; 4]; least].into()
    } else {
        rows.into()
    }
}

/// Returns each vertex's rows; see [`VERTEX_ROWS`].
fn vertex_rows(geometry: &Geometry) -> Vec<[u32; 4]> {
    let mut rows = Vec::with_capacity(VERTEX_ROWS * geometry.positions().len());
    let vertices = geometry.positions().iter().zip(geometry.normals());
    for (i, (position, normal)) in vertices.enumerate() {
        let uv = geometry.uvs().get(i).copied().unwrap_or(Vec2::ZERO);
        let tangent = geometry.tangents().get(i).copied().unwrap_or(Vec4::ZERO);
        rows.push(float_row(position.extend(uv.x)));
        rows.push(float_row(normal.extend(uv.y)));
        rows.push(float_row(tangent));
    }
    rows
}

fn float_row(v: Vec4) -> [u32; 4] {
    v.to_array().map(f32::to_bits)
}

/// Returns a row for each triangle: its vertices and its material, or `default` if it has none.
fn triangle_rows(geometry: &Geometry, default: u32) -> Vec<[u32; 4]> {
    let mut rows = Vec::with_capacity(geometry.triangles().len());
    for (i, &[a, b, c]) in geometry.triangles().iter().enumerate() {
        let material = match geometry.materials().get(i) {
            Some(&id) if id != NO_MATERIAL => id,
            _ => default,
        };
        rows.push([a, b, c, material]);
    }
    rows
}

/// Returns a material's rows; see [`MATERIAL_ROWS`]. `places` are the textures' locations in the
/// texel table.
fn material_rows(m: &Material, places: &[UVec4]) -> [[u32; 4]; MATERIAL_ROWS] {
    [
        color_row(m.diffuse, m.shininess_log2),
        color_row(m.specular, 0),
        color_row(m.emissive, 0),
        texture_row(m.diffuse_texture, places),
        texture_row(m.normal_map, places),
    ]
}

fn color_row(color: Vec3, last_word: u32) -> [u32; 4] {
    let [red, green, blue] = color.to_array().map(f32::to_bits);
    [red, green, blue, last_word]
}

/// Returns a texture's location in the texel table, or zeros for no texture.
fn texture_row(id: Option<usize>, places: &[UVec4]) -> [u32; 4] {
    match id.and_then(|id| places.get(id)) {
        Some(place) => place.to_array(),
        None => [0; 4],
    }
}
