//! A scene's triangles on the device.

use super::{
    coarse::{self, CoarseLevel},
    convex, materials,
    pipelines::{ForwardPipelines, HOLES_GROUP, Layouts, MATERIAL_GROUP},
    seen::SeenPart,
};
use crate::stage::ViewerScene;
use anyhow::Result;
use std::ops::Range;
use umbrage::{
    Aabb, Geometry, NO_MATERIAL,
    glam::{Affine3A, Vec2, Vec3},
    gpu::{CasterMesh, CutOutBuffers, Indices, LightSet, VertexLayout},
};
use wgpu::util::DeviceExt as _;

/// Triangles of a caster of the light sets: few enough to cull casters out of the reach of a spot
/// or point light.
const CASTER_TRIANGLES: u32 = 16_384;
/// Triangles of a draw: few enough to cull draws outside the view, and to have similar distances.
const DRAWN_TRIANGLES: u32 = 1024;

/// A vertex without its position.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct Looks {
    normal: [f32; 3],
    uv: [f32; 2],
    /// The triangle's id in the geometry, for vertices of alpha-tested triangles.
    triangle: u32,
}

/// Nearby triangles of one material.
struct BufferDraw {
    run: DrawRun,
    /// Levels with fewer triangles.
    coarser: Vec<CoarseLevel>,
}

/// Inputs of the library's alpha test.
pub(crate) struct AlphaTest {
    pub buffers: CutOutBuffers,
    pub group: wgpu::BindGroup,
    pub layout: wgpu::BindGroupLayout,
}

/// Triangles for the renderer and the light sets.
pub(crate) struct SceneBuffers {
    positions: wgpu::Buffer,
    looks: wgpu::Buffer,
    /// Indices in the order of the geometry's triangles.
    indices: wgpu::Buffer,
    /// Indices in the order of `draws`, followed by coarser levels.
    sorted: wgpu::Buffer,
    draws: Vec<BufferDraw>,
    /// Bind groups of the materials, and of triangles without one.
    materials: Vec<wgpu::BindGroup>,
    casters: Vec<(Range<u32>, Aabb)>,
    pub alpha_test: Option<AlphaTest>,
}

impl SceneBuffers {
    /// Uploads a scene.
    ///
    /// # Errors
    /// Returns an error if a buffer would be larger than the device allows.
    pub(super) fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        layouts: &Layouts,
        stage: &ViewerScene,
    ) -> Result<Self> {
        let geometry = &stage.geometry;
        let (mut sorted, runs) = sorted_triangles(geometry);
        let (positions, looks) = vertices(geometry, &runs, &mut sorted);
        // Only build levels for software drivers. Elsewhere triangles cost little, and the levels
        // would only take memory.
        let mut levels = if device.adapter_info().device_type == wgpu::DeviceType::Cpu {
            let whole = runs.iter().filter(|run| !run.has_holes);
            let ranges: Vec<_> = whole.map(|run| run.indices.clone()).collect();
            coarse::add_levels(geometry, &mut sorted.corners, &ranges)
        } else {
            Vec::new()
        }
        .into_iter();
        // Alpha-tested runs are the last ones.
        let draw = |run| BufferDraw {
            run,
            coarser: levels.next().unwrap_or_default(),
        };
        let draws = runs.into_iter().map(draw).collect();
        let largest = size_of_val(looks.as_slice()).max(size_of_val(sorted.corners.as_slice()));
        let most = device.limits().max_buffer_size;
        anyhow::ensure!(
            largest as u64 <= most,
            "the scene takes buffers of {largest} bytes, and this device has at most {most}; use a smaller scene"
        );
        let buffer = |label, usage, contents: &[u8]| {
            // Buffers can't be empty.
            let contents = if contents.is_empty() {
                &[0; 12]
            } else {
                contents
            };
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some(label),
                contents,
                usage,
            })
        };
        let storage = wgpu::BufferUsages::STORAGE;
        let vertex = wgpu::BufferUsages::VERTEX;
        let index = wgpu::BufferUsages::INDEX;
        let alpha_test = CutOutBuffers::new(device, queue, geometry)?.map(|buffers| {
            let (group, layout) = buffers.bind_group(device);
            AlphaTest {
                buffers,
                group,
                layout,
            }
        });
        Ok(Self {
            positions: buffer(
                "positions",
                vertex | storage,
                bytemuck::cast_slice(&positions),
            ),
            looks: buffer("looks", vertex, bytemuck::cast_slice(&looks)),
            indices: buffer(
                "triangles",
                index | storage,
                bytemuck::cast_slice(geometry.triangles()),
            ),
            sorted: buffer(
                "sorted triangles",
                index,
                bytemuck::cast_slice(&sorted.corners),
            ),
            draws,
            materials: materials::groups(
                device,
                queue,
                layouts,
                &stage.materials,
                &stage.textures,
            )?,
            casters: casters(geometry),
            alpha_test,
        })
    }

    /// Draws all triangles that may be visible.
    pub(super) fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        forward: &ForwardPipelines,
        seen: &SeenPart,
    ) {
        let mut bound = None;
        pass.set_vertex_buffer(0, self.positions.slice(..));
        pass.set_vertex_buffer(1, self.looks.slice(..));
        pass.set_index_buffer(self.sorted.slice(..), wgpu::IndexFormat::Uint32);
        if let Some(test) = &self.alpha_test {
            pass.set_bind_group(HOLES_GROUP, &test.group, &[]);
        }
        for BufferDraw { run, coarser } in &self.draws {
            if !seen.may_show(&run.bounds) {
                continue;
            }
            let hides_backs = run.convex.is_some_and(|part| seen.is_outside(&part));
            let pipeline = match &forward.alpha_tested {
                Some(pipeline) if run.has_holes => pipeline,
                _ if hides_backs => &forward.fronts,
                _ => &forward.all,
            };
            if bound != Some(pipeline) {
                bound = Some(pipeline);
                pass.set_pipeline(pipeline);
            }
            let without_material = self.materials.len() - 1;
            let material = (run.material as usize).min(without_material);
            pass.set_bind_group(MATERIAL_GROUP, &self.materials[material], &[]);
            let pixel = seen.pixel_at(&run.bounds);
            let level = pixel.and_then(|pixel| coarse::level_for(coarser, pixel));
            let indices = level.map_or(&run.indices, |level| &level.indices);
            pass.draw_indexed(indices.clone(), 0, 0..1);
        }
    }

    /// Adds all casters to a set.
    ///
    /// # Errors
    /// Returns an error if the set refuses one.
    pub(super) fn add_casters(&self, set: &mut LightSet) -> Result<()> {
        for (triangles, bounds) in &self.casters {
            let mesh = set.add_mesh(&CasterMesh {
                label: "part of the scene",
                vertices: &self.positions,
                layout: VertexLayout::PACKED,
                indices: Some(Indices {
                    buffer: &self.indices,
                    format: wgpu::IndexFormat::Uint32,
                }),
                range: 3 * triangles.start..3 * triangles.end,
                base_vertex: 0,
                bounds: *bounds,
            })?;
            set.add_caster(mesh, Affine3A::IDENTITY)?;
        }
        set.set_cut_outs(self.alpha_test.as_ref().map(|test| &test.buffers))?;
        Ok(())
    }
}

/// Triangles in drawing order.
struct SortedTriangles {
    ids: Vec<u32>,
    corners: Vec<[u32; 3]>,
}

/// Triangles of one draw.
struct DrawRun {
    /// Index of the material, or a greater value for triangles without one.
    material: u32,
    /// `true` if the triangles are alpha-tested.
    has_holes: bool,
    indices: Range<u32>,
    bounds: Aabb,
    /// A box outside of which no back face of these triangles is visible. `None` if there is none.
    convex: Option<Aabb>,
}

/// Returns all triangles sorted by alpha test, by material, by whether they are closed convex
/// parts, and by position; and the runs of that list that are drawn together.
fn sorted_triangles(geometry: &Geometry) -> (SortedTriangles, Vec<DrawRun>) {
    let triangles = geometry.triangles();
    let materials = geometry.materials();
    let material_of = |id: u32| materials.get(id as usize).copied().unwrap_or(NO_MATERIAL);
    let bounds = geometry.bounds();
    let convex = convex::boxes(geometry);
    let mut ids: Vec<u32> = (0..triangles.len() as u32).collect();
    ids.sort_by_cached_key(|&id| {
        let [a, b, c] = geometry.corners(id);
        let position = position_on_curve((a + b + c) / 3.0, &bounds);
        let is_convex = convex[id as usize].is_some();
        (geometry.has_holes(id), material_of(id), is_convex, position)
    });
    let mut runs: Vec<DrawRun> = Vec::new();
    for (i, &id) in (0_u32..).zip(&ids) {
        let around = Aabb::from_points(geometry.corners(id));
        let part = convex[id as usize];
        let end = 3 * (i + 1);
        match runs.last_mut() {
            Some(run)
                if run.material == material_of(id)
                    && run.has_holes == geometry.has_holes(id)
                    && run.convex.is_some() == part.is_some()
                    && end - run.indices.start <= 3 * DRAWN_TRIANGLES =>
            {
                run.indices.end = end;
                run.bounds = run.bounds.union(&around);
                run.convex = run.convex.zip(part).map(|(all, part)| all.union(&part));
            }
            _ => runs.push(DrawRun {
                material: material_of(id),
                has_holes: geometry.has_holes(id),
                indices: 3 * i..end,
                bounds: around,
                convex: part,
            }),
        }
    }
    let corners = ids.iter().map(|&id| triangles[id as usize]).collect();
    (SortedTriangles { ids, corners }, runs)
}

/// Returns the vertices of a geometry, followed by those of alpha-tested triangles, which don't
/// share vertices.
fn vertices(
    geometry: &Geometry,
    runs: &[DrawRun],
    sorted: &mut SortedTriangles,
) -> (Vec<Vec3>, Vec<Looks>) {
    let uvs = geometry.uvs();
    let mut positions = geometry.positions().to_vec();
    let normals = geometry.normals().iter().enumerate();
    let mut looks: Vec<Looks> = normals
        .map(|(i, normal)| Looks {
            normal: normal.to_array(),
            uv: uvs.get(i).copied().unwrap_or(Vec2::ZERO).to_array(),
            triangle: 0,
        })
        .collect();
    for run in runs.iter().filter(|run| run.has_holes) {
        for i in run.indices.start / 3..run.indices.end / 3 {
            let triangle = sorted.ids[i as usize];
            for corner in &mut sorted.corners[i as usize] {
                let old = *corner as usize;
                *corner = positions.len() as u32;
                positions.push(positions[old]);
                looks.push(Looks {
                    triangle,
                    ..looks[old]
                });
            }
        }
    }
    (positions, looks)
}

/// Returns the position of a point along a curve that fills a box and keeps neighbours together, by
/// interleaving the bits of its coordinates (Morton 1966, "A computer oriented geodetic data base
/// and a new technique in file sequencing").
fn position_on_curve(point: Vec3, bounds: &Aabb) -> u32 {
    let size = (bounds.max - bounds.min).max(Vec3::splat(1e-20));
    let cell = ((point - bounds.min) / size * 1023.0).clamp(Vec3::ZERO, Vec3::splat(1023.0));
    let mut position = 0;
    for bit in (0..10).rev() {
        for coordinate in cell.to_array() {
            position = position << 1 | (coordinate as u32 >> bit & 1);
        }
    }
    position
}

fn casters(geometry: &Geometry) -> Vec<(Range<u32>, Aabb)> {
    let mut parts = Vec::new();
    for run in geometry.casters_without_holes() {
        for begin in run.clone().step_by(CASTER_TRIANGLES as usize) {
            let part = begin..(begin + CASTER_TRIANGLES).min(run.end);
            let bounds = Aabb::from_points(geometry.vertices_of(part.clone()));
            parts.push((part, bounds));
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage::scenes;

    #[test]
    fn each_triangle_is_drawn_once_and_those_with_holes_name_themselves() {
        let entry = scenes::find("wire-fence").expect("built in");
        let geometry = Geometry::bake(&(entry.build)()).expect("valid");
        let (mut sorted, runs) = sorted_triangles(&geometry);
        let (positions, looks) = vertices(&geometry, &runs, &mut sorted);
        let drawn: Vec<u32> = runs.iter().flat_map(|run| run.indices.clone()).collect();
        assert!(drawn.iter().copied().eq(0..3 * sorted.ids.len() as u32));
        let mut ids = sorted.ids.clone();
        ids.sort_unstable();
        assert!(ids.into_iter().eq(0..geometry.triangles().len() as u32));
        let mut with_holes = 0;
        for run in runs {
            for i in run.indices.step_by(3) {
                let id = sorted.ids[i as usize / 3];
                assert_eq!(geometry.has_holes(id), run.has_holes);
                let corners = sorted.corners[i as usize / 3].map(|corner| corner as usize);
                assert_eq!(
                    corners.map(|corner| positions[corner]),
                    geometry.corners(id)
                );
                if run.has_holes {
                    assert_eq!(corners.map(|corner| looks[corner].triangle), [id; 3]);
                    with_holes += 1;
                }
            }
        }
        assert!(with_holes > 0);
    }
}
