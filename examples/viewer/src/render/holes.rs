//! Triangles with holes: leaves, fences. They are drawn apart from all others, by a shader that asks each pixel for holes.

use super::buffers::{SeenPart, place_on_curve};
use anyhow::Result;
use std::ops::Range;
use umbrage::{
    Aabb, CutOuts, Geometry, NO_MATERIAL,
    glam::{Vec2, Vec3},
    wgpu::CutOutBuffers,
};
use wgpu::util::DeviceExt as _;

/// What stands before the names of the library's rule for holes.
pub(crate) const PREFIX: &str = "holes_";
/// Triangles that are drawn together: few enough that a camera leaves out what it doesn't see.
const DRAWN_TRIANGLES: usize = 1024;

/// A corner of a triangle with holes.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct LeafVertex {
    position: [f32; 3],
    normal: [f32; 3],
    uv: [f32; 2],
    /// The triangle's id in the geometry.
    triangle: u32,
}

impl LeafVertex {
    pub(crate) const ATTRIBUTES: [wgpu::VertexAttribute; 4] =
        wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x2, 3 => Uint32];
}

/// Triangles with holes of one material, near each other.
pub(crate) struct LeafDraw {
    pub vertices: Range<u32>,
    pub bounds: Aabb,
    /// Index among the scene's materials; none for those without one.
    pub material: Option<u32>,
}

/// All triangles with holes of a scene.
pub(crate) struct Leaves {
    pub buffers: CutOutBuffers,
    /// What the library's rule reads.
    pub group: wgpu::BindGroup,
    pub layout: wgpu::BindGroupLayout,
    vertices: wgpu::Buffer,
    draws: Vec<LeafDraw>,
}

impl Leaves {
    /// Uploads a scene's triangles with holes; none if it has none.
    ///
    /// # Errors
    /// Errors if the device has no room for them.
    pub(crate) fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        geometry: &Geometry,
    ) -> Result<Option<Self>> {
        let Some(buffers) = CutOutBuffers::new(device, queue, geometry)? else {
            return Ok(None);
        };
        let Some(cut_outs) = geometry.cut_outs() else {
            return Ok(None);
        };
        let (vertices, draws) = leaves(geometry, cut_outs);
        let bytes: &[u8] = bytemuck::cast_slice(&vertices);
        let most = device.limits().max_buffer_size;
        anyhow::ensure!(
            bytes.len() as u64 <= most,
            "triangles with holes take a buffer of {} bytes, and this device has at most {most}; use a smaller scene",
            bytes.len()
        );
        let (group, layout) = buffers.bind_group(device);
        Ok(Some(Self {
            vertices: device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("triangles with holes"),
                contents: bytes,
                usage: wgpu::BufferUsages::VERTEX,
            }),
            buffers,
            group,
            layout,
            draws,
        }))
    }

    /// Draws what may be seen. `bind_material` binds a material's looks.
    pub(crate) fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        seen: &SeenPart,
        mut bind_material: impl FnMut(&mut wgpu::RenderPass<'_>, Option<u32>),
    ) {
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        for draw in self.draws.iter().filter(|draw| seen.may_show(&draw.bounds)) {
            bind_material(pass, draw.material);
            pass.draw(draw.vertices.clone(), 0..1);
        }
    }
}

/// Returns the corners of all triangles with holes, sorted by material and place, and the parts of that list that are drawn together.
fn leaves(geometry: &Geometry, cut_outs: &CutOuts) -> (Vec<LeafVertex>, Vec<LeafDraw>) {
    let materials = geometry.materials();
    let material_of = |id: u32| materials.get(id as usize).copied().unwrap_or(NO_MATERIAL);
    let bounds = geometry.bounds();
    let mut order: Vec<u32> = cut_outs.runs().iter().cloned().flatten().collect();
    order.sort_by_cached_key(|&id| {
        let [a, b, c] = geometry.corners(id);
        (
            material_of(id),
            place_on_curve((a + b + c) / 3.0, &bounds),
            id,
        )
    });
    let vertices: Vec<LeafVertex> = order.iter().flat_map(|&id| corners(geometry, id)).collect();
    let mut draws = Vec::new();
    let mut first = 0;
    for same in order.chunk_by(|&a, &b| material_of(a) == material_of(b)) {
        for part in same.chunks(DRAWN_TRIANGLES) {
            let end = first + 3 * part.len() as u32;
            let points = part.iter().flat_map(|&id| geometry.corners(id));
            let material = material_of(part[0]);
            draws.push(LeafDraw {
                vertices: first..end,
                bounds: Aabb::around(points),
                material: (material != NO_MATERIAL).then_some(material),
            });
            first = end;
        }
    }
    (vertices, draws)
}

fn corners(geometry: &Geometry, triangle: u32) -> [LeafVertex; 3] {
    let normals = geometry.normals();
    let uvs = geometry.uvs();
    let positions = geometry.corners(triangle);
    let vertices = geometry.triangles()[triangle as usize];
    [0, 1, 2].map(|corner| {
        let vertex = vertices[corner] as usize;
        let normal = normals.get(vertex).copied().unwrap_or(Vec3::Y);
        let uv = uvs.get(vertex).copied().unwrap_or(Vec2::ZERO);
        LeafVertex {
            position: positions[corner].to_array(),
            normal: normal.to_array(),
            uv: uv.to_array(),
            triangle,
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage::scenes;

    #[test]
    fn each_triangle_with_holes_is_drawn_once() {
        let entry = scenes::find("wire-fence").expect("built in");
        let geometry = Geometry::bake(&(entry.build)()).expect("valid");
        let cut_outs = geometry.cut_outs().expect("has holes");
        let (vertices, draws) = leaves(&geometry, cut_outs);
        let drawn: Vec<u32> = draws.iter().flat_map(|d| d.vertices.clone()).collect();
        assert!(drawn.iter().copied().eq(0..vertices.len() as u32));
        let mut ids: Vec<u32> = vertices.iter().map(|v| v.triangle).collect();
        ids.sort_unstable();
        let expected: Vec<u32> = (0..geometry.triangles().len() as u32)
            .filter(|&id| geometry.has_holes(id))
            .flat_map(|id| [id; 3])
            .collect();
        assert_eq!(ids, expected);
        assert!(!ids.is_empty());
    }
}
