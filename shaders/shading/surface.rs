//! Surface at a visible point: interpolated vertex attributes, textures, and normals perturbed by a
//! normal map. Only shading uses it. Shadow lookups use the geometric normal for their bias,
//! because a shadow map stores the depth of the geometry without the relief of a normal map.
//!
//! From behind, a bump appears as a dent. The perturbed normal is flipped as a whole to the side of
//! the geometric normal, which faces the camera. (Flipping it against the pixel's ray instead would
//! invert smooth silhouettes.)

use crate::shading::{
    interpolation::{barycentric, bent, on_side_of, unit_or, weighted},
    surface_tables::{MATERIAL_ROWS, SurfaceTables, VERTEX_ROWS},
    texture::bilinear,
};
use glam::{UVec4, Vec2, Vec3, Vec4};
use umbrage_core::{Module, module};

/// The WGSL half; it needs `texture`, `interpolation` and the tables of [`SurfaceTables`].
pub(crate) const SURFACE: Module = module!("surface");

/// Surface properties of a visible point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SurfacePoint {
    /// Unit shading normal, on the camera's side of the triangle.
    pub(crate) normal: Vec3,
    /// Linear colour of diffuse reflection, texture included.
    pub(crate) diffuse: Vec3,
    /// Linear colour of the highlight.
    pub(crate) specular: Vec3,
    /// The highlight's power as a power of two.
    pub(crate) shininess_log2: u32,
    /// Emitted light.
    pub(crate) emissive: Vec3,
}

impl SurfaceTables {
    /// Returns the surface at the point `p` (world space) of triangle `id`; `None` if there is no
    /// such triangle. `facing` is the geometric unit normal towards the camera.
    #[inline(always)]
    pub(crate) fn surface(&self, id: u32, p: Vec3, facing: Vec3) -> Option<SurfacePoint> {
        let triangle = UVec4::from_array(*self.triangles.get(id as usize)?);
        let at = self.corners(triangle, 0);
        let normals = self.corners(triangle, 1);
        let weights = barycentric(p, at[0].truncate(), at[1].truncate(), at[2].truncate());
        let position_u = weighted(weights, at[0], at[1], at[2]);
        let normal_v = weighted(weights, normals[0], normals[1], normals[2]);
        let uv = Vec2::new(position_u.w, normal_v.w);
        let rows = &self.materials[MATERIAL_ROWS * triangle.w as usize..][..MATERIAL_ROWS];
        let mut diffuse = color(rows[0]);
        if rows[3][1] > 0 {
            diffuse *= bilinear(&self.texels, UVec4::from_array(rows[3]), uv).truncate();
        }
        let normal = self.shading_normal(
            weights,
            normal_v,
            triangle,
            UVec4::from_array(rows[4]),
            uv,
            facing,
        );
        Some(SurfacePoint {
            normal,
            diffuse,
            specular: color(rows[1]),
            shininess_log2: rows[0][3],
            emissive: color(rows[2]),
        })
    }

    /// Returns the unit shading normal. `n` is the interpolated vertex normal, not of unit length.
    /// `map` is the normal map's location in the texel table; a width of 0 means no map.
    #[inline(always)]
    fn shading_normal(
        &self,
        weights: Vec3,
        n: Vec4,
        triangle: UVec4,
        map: UVec4,
        uv: Vec2,
        facing: Vec3,
    ) -> Vec3 {
        let mut v = n.truncate();
        if map.y > 0 {
            let t = self.corners(triangle, 2);
            let texel = bilinear(&self.texels, map, uv);
            let m = Vec3::new(
                texel.x * 2.0 - 1.0,
                texel.y * 2.0 - 1.0,
                texel.z * 2.0 - 1.0,
            );
            v = bent(n.truncate(), weighted(weights, t[0], t[1], t[2]), m);
        }
        unit_or(on_side_of(n.truncate(), v, facing), facing)
    }

    /// Returns row `row` of each of the triangle's three vertices.
    #[inline(always)]
    fn corners(&self, triangle: UVec4, row: usize) -> [Vec4; 3] {
        [triangle.x, triangle.y, triangle.z].map(|v| {
            let words = self.vertices[VERTEX_ROWS * v as usize + row];
            Vec4::from_array(words.map(f32::from_bits))
        })
    }
}

/// Returns the colour in a material's row.
#[inline(always)]
fn color(row: [u32; 4]) -> Vec3 {
    let [red, green, blue, _] = row.map(f32::from_bits);
    Vec3::new(red, green, blue)
}
