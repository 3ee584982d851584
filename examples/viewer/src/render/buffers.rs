//! A scene's triangles and looks on the device.

use super::{
    coarse::{self, CoarseLevel},
    convex,
    holes::Leaves,
    pipelines::{Forward, HOLES_GROUP, Layouts, group},
};
use anyhow::{Context as _, Result};
use std::ops::Range;
use umbrage::{
    Aabb, Geometry, Material, NO_MATERIAL, Texture,
    glam::{Mat4, UVec2, Vec2, Vec3, Vec4},
    picture,
    wgpu::{CasterMesh, Indices, LightSet, VertexLayout},
};
use wgpu::util::DeviceExt as _;

/// Triangles that are one caster of the light sets: few enough that a lamp leaves out what it can't reach.
const CASTER_TRIANGLES: u32 = 16_384;
/// Triangles that are drawn together: few enough that a camera leaves out what it doesn't see, and that all are about as far away.
const DRAWN_TRIANGLES: u32 = 1024;
/// Bytes from one material's numbers to the next, as dynamic offsets of uniform buffers ask.
const MATERIAL_STRIDE: u64 = 256;

/// A vertex beside its position: normal and texture coordinate.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct Looks {
    normal: [f32; 3],
    uv: [f32; 2],
}

/// Triangles of one material, near each other.
struct Draw {
    indices: Range<u32>,
    /// The same with fewer triangles.
    coarser: Vec<CoarseLevel>,
    bounds: Aabb,
    material: u32,
    /// Index among the bind groups.
    group: usize,
    /// A box outside of which no back of these triangles is seen, if there is one.
    convex: Option<Aabb>,
}

/// What the renderer and the light sets draw.
pub(crate) struct SceneBuffers {
    positions: wgpu::Buffer,
    looks: wgpu::Buffer,
    /// In the order of the geometry's triangles.
    indices: wgpu::Buffer,
    /// Sorted by material; coarser levels follow.
    sorted: wgpu::Buffer,
    draws: Vec<Draw>,
    groups: Vec<wgpu::BindGroup>,
    casters: Vec<(Range<u32>, Aabb)>,
    /// For each material, and for triangles without one, its bind group.
    group_of: Vec<usize>,
    leaves: Option<Leaves>,
}

impl SceneBuffers {
    /// Uploads a scene.
    ///
    /// # Errors
    /// Errors if a buffer would be larger than the device allows.
    pub(crate) fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        layouts: &Layouts,
        geometry: &Geometry,
        materials: &[Material],
        textures: &[Texture],
    ) -> Result<Self> {
        let most = device.limits().max_buffer_size;
        let largest = (geometry.positions().len() * size_of::<Looks>())
            .max(size_of_val(geometry.triangles()));
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
        let triangles = geometry.triangles();
        let (mut sorted, runs) = sorted_by_material(geometry);
        let ranges: Vec<Range<u32>> = runs.iter().map(|run| run.indices.clone()).collect();
        // Elsewhere triangles cost little, and the levels would only take memory.
        let levels = if device.adapter_info().device_type == wgpu::DeviceType::Cpu {
            coarse::add_levels(geometry, &mut sorted, &ranges)
        } else {
            Vec::new()
        };
        let looks_of_materials = MaterialGroups::new(device, queue, layouts, materials, textures)?;
        let draw = |(run, coarser): (Run, Vec<CoarseLevel>)| {
            let without = materials.len() as u32;
            let material = if run.material == NO_MATERIAL {
                without
            } else {
                run.material
            };
            Draw {
                indices: run.indices,
                coarser,
                bounds: run.bounds,
                material,
                group: looks_of_materials.group_of[material as usize],
                convex: run.convex,
            }
        };
        let levels = levels.into_iter().chain(std::iter::repeat_with(Vec::new));
        let draws = runs.into_iter().zip(levels).map(draw).collect();
        Ok(Self {
            positions: buffer(
                "positions",
                vertex | storage,
                bytemuck::cast_slice(geometry.positions()),
            ),
            looks: buffer("looks", vertex, bytemuck::cast_slice(&looks(geometry))),
            indices: buffer(
                "triangles",
                index | storage,
                bytemuck::cast_slice(triangles),
            ),
            sorted: buffer(
                "triangles by material",
                index,
                bytemuck::cast_slice(&sorted),
            ),
            draws,
            groups: looks_of_materials.groups,
            casters: casters(geometry),
            group_of: looks_of_materials.group_of,
            leaves: Leaves::new(device, queue, geometry)?,
        })
    }

    /// Draws all triangles that may be seen. Materials are at bind group `group`.
    pub(crate) fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        forward: &Forward,
        group: u32,
        seen: &SeenPart,
    ) {
        let mut with_backs = None;
        pass.set_vertex_buffer(0, self.positions.slice(..));
        pass.set_vertex_buffer(1, self.looks.slice(..));
        pass.set_index_buffer(self.sorted.slice(..), wgpu::IndexFormat::Uint32);
        for draw in &self.draws {
            if !seen.may_show(&draw.bounds) {
                continue;
            }
            let shows_backs = !draw.convex.is_some_and(|part| seen.is_outside(&part));
            if with_backs != Some(shows_backs) {
                with_backs = Some(shows_backs);
                pass.set_pipeline(if shows_backs {
                    &forward.all
                } else {
                    &forward.fronts
                });
            }
            let offset = draw.material * MATERIAL_STRIDE as u32;
            pass.set_bind_group(group, &self.groups[draw.group], &[offset]);
            let pixel = seen.pixel_at(&draw.bounds);
            let coarse = pixel.and_then(|pixel| coarse::level_for(&draw.coarser, pixel));
            let indices = coarse.map_or(&draw.indices, |level| &level.indices);
            pass.draw_indexed(indices.clone(), 0, 0..1);
        }
        let (Some(leaves), Some(pipeline)) = (&self.leaves, &forward.leaves) else {
            return;
        };
        pass.set_pipeline(pipeline);
        pass.set_bind_group(HOLES_GROUP, &leaves.group, &[]);
        leaves.draw(pass, seen, |pass, material| {
            let without = self.group_of.len() as u32 - 1;
            let material = material.unwrap_or(without);
            let looks = &self.groups[self.group_of[material as usize]];
            pass.set_bind_group(group, looks, &[material * MATERIAL_STRIDE as u32]);
        });
    }

    /// Returns the triangles with holes, if there are any.
    pub(crate) fn leaves(&self) -> Option<&Leaves> {
        self.leaves.as_ref()
    }

    /// Adds all casters to a set.
    ///
    /// # Errors
    /// Errors if the set refuses one.
    pub(crate) fn add_casters(&self, set: &mut LightSet) -> Result<()> {
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
            set.add_caster(mesh, umbrage::glam::Affine3A::IDENTITY)?;
        }
        set.set_cut_outs(self.leaves.as_ref().map(|leaves| &leaves.buffers))?;
        Ok(())
    }
}

fn looks(geometry: &Geometry) -> Vec<Looks> {
    let uvs = geometry.uvs();
    let uv_of = |i: usize| uvs.get(i).copied().unwrap_or(Vec2::ZERO);
    let vertex = |(i, normal): (usize, &Vec3)| Looks {
        normal: normal.to_array(),
        uv: uv_of(i).to_array(),
    };
    geometry.normals().iter().enumerate().map(vertex).collect()
}

/// Triangles that are drawn together.
struct Run {
    material: u32,
    indices: Range<u32>,
    bounds: Aabb,
    convex: Option<Aabb>,
}

/// Returns the vertex indices of all triangles without holes sorted by their materials, by whether they are closed convex parts and, in each, by where
/// they are; and the runs of that list that are drawn together.
fn sorted_by_material(geometry: &Geometry) -> (Vec<[u32; 3]>, Vec<Run>) {
    let triangles = geometry.triangles();
    let materials = geometry.materials();
    let material_of = |id: u32| materials.get(id as usize).copied().unwrap_or(NO_MATERIAL);
    let bounds = geometry.bounds();
    let all = 0..triangles.len() as u32;
    let mut order: Vec<u32> = all.filter(|&id| !geometry.has_holes(id)).collect();
    let convex = convex::boxes(geometry);
    order.sort_by_cached_key(|&id| {
        let [a, b, c] = geometry.corners(id);
        let place = place_on_curve((a + b + c) / 3.0, &bounds);
        (material_of(id), convex[id as usize].is_some(), place)
    });
    let sorted = order.iter().map(|&id| triangles[id as usize]).collect();
    let mut runs: Vec<Run> = Vec::new();
    for (place, &id) in (0_u32..).zip(&order) {
        let [begin, end] = [3 * place, 3 * (place + 1)];
        let around = Aabb::around(geometry.corners(id));
        let part = convex[id as usize];
        match runs.last_mut() {
            Some(run)
                if run.material == material_of(id)
                    && run.convex.is_some() == part.is_some()
                    && end - run.indices.start <= 3 * DRAWN_TRIANGLES =>
            {
                run.indices.end = end;
                run.bounds = run.bounds.union(&around);
                run.convex = run.convex.zip(part).map(|(all, part)| all.union(&part));
            }
            _ => runs.push(Run {
                material: material_of(id),
                indices: begin..end,
                bounds: around,
                convex: part,
            }),
        }
    }
    (sorted, runs)
}

/// Returns where a point lies along a curve through all of a box that stays near where it is: the bits of its coordinates in turn
/// (Morton 1966, "A computer oriented geodetic data base and a new technique in file sequencing").
pub(super) fn place_on_curve(point: Vec3, bounds: &Aabb) -> u32 {
    let size = (bounds.max - bounds.min).max(Vec3::splat(1e-20));
    let cell = ((point - bounds.min) / size * 1023.0).clamp(Vec3::ZERO, Vec3::splat(1023.0));
    let mut place = 0;
    for bit in (0..10).rev() {
        for coordinate in cell.to_array() {
            place = place << 1 | (coordinate as u32 >> bit & 1);
        }
    }
    place
}

/// What a camera sees in a part of its picture.
pub(crate) struct SeenPart {
    pub clip_from_world: Mat4,
    /// From one share of the width to another, 0..=1.
    pub part: [f32; 2],
    /// Where the camera stands; none if its lines are parallel.
    pub eye: Option<Vec3>,
    /// How far from the eye things may be cut off, metres.
    pub near: f32,
    /// How many metres a pixel spans where details smaller than that may be left out; in perspective, a metre away.
    pub coarse_pixel: Option<f32>,
}

impl SeenPart {
    /// Whether the camera stands outside a box, and nothing of it is cut off before the camera.
    fn is_outside(&self, bounds: &Aabb) -> bool {
        let Some(eye) = self.eye else {
            return false;
        };
        let nearest = eye.clamp(bounds.min, bounds.max);
        nearest.distance(eye) > self.near
    }

    /// Returns how many metres a pixel spans at the nearest point of a box, where details may be left out.
    fn pixel_at(&self, bounds: &Aabb) -> Option<f32> {
        let pixel = self.coarse_pixel?;
        let nearest = |eye: Vec3| eye.clamp(bounds.min, bounds.max).distance(eye);
        Some(pixel * self.eye.map_or(1.0, nearest))
    }

    /// Whether something of a box may be seen: it is not, if all of its corners are beyond one side.
    pub(super) fn may_show(&self, bounds: &Aabb) -> bool {
        let [left, right] = self.part.map(|share| 2.0 * share - 1.0);
        let mut outside = [true; 5];
        for i in 0..8 {
            let pick = |bit: u32, axis: usize| {
                if i >> bit & 1 == 0 {
                    bounds.min[axis]
                } else {
                    bounds.max[axis]
                }
            };
            let corner = Vec4::new(pick(0, 0), pick(1, 1), pick(2, 2), 1.0);
            let clip = self.clip_from_world * corner;
            // Depth is reversed: what is behind the eye is nearer than the near plane.
            let beyond = [
                clip.x < left * clip.w,
                clip.x > right * clip.w,
                clip.y < -clip.w,
                clip.y > clip.w,
                clip.z > clip.w,
            ];
            for (outside, beyond) in outside.iter_mut().zip(beyond) {
                *outside &= beyond;
            }
        }
        !outside.contains(&true)
    }
}

fn casters(geometry: &Geometry) -> Vec<(Range<u32>, Aabb)> {
    let mut parts = Vec::new();
    for run in geometry.casters_without_holes() {
        for begin in run.clone().step_by(CASTER_TRIANGLES as usize) {
            let part = begin..(begin + CASTER_TRIANGLES).min(run.end);
            let bounds = Aabb::around(geometry.vertices_of(part.clone()));
            parts.push((part, bounds));
        }
    }
    parts
}

/// Bind groups with the looks of materials; the last material is that of triangles without one.
struct MaterialGroups {
    groups: Vec<wgpu::BindGroup>,
    /// For each material.
    group_of: Vec<usize>,
}

impl MaterialGroups {
    fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        layouts: &Layouts,
        materials: &[Material],
        textures: &[Texture],
    ) -> Result<Self> {
        let none = Material::default();
        let all: Vec<&Material> = materials.iter().chain([&none]).collect();
        let mut numbers = vec![0_u8; all.len() * MATERIAL_STRIDE as usize];
        for (material, bytes) in all.iter().zip(numbers.chunks_mut(MATERIAL_STRIDE as usize)) {
            let shininess = (1_u32 << material.shininess_log2) as f32;
            let floats: [[f32; 4]; 3] = [
                material.diffuse.extend(1.0).to_array(),
                material.specular.extend(shininess).to_array(),
                material.emissive.extend(0.0).to_array(),
            ];
            bytes[..48].copy_from_slice(bytemuck::cast_slice(&floats));
        }
        let numbers = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("materials"),
            contents: &numbers,
            usage: wgpu::BufferUsages::UNIFORM,
        });
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            address_mode_u: wgpu::AddressMode::Repeat,
            address_mode_v: wgpu::AddressMode::Repeat,
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            mipmap_filter: wgpu::MipmapFilterMode::Linear,
            ..wgpu::SamplerDescriptor::default()
        });
        let white = Texture {
            name: "white".to_owned(),
            size: UVec2::ONE,
            texels: vec![[1.0; 4]],
        };
        let mut kinds: Vec<Option<usize>> = Vec::new();
        let mut groups = Vec::new();
        let mut group_of = Vec::new();
        for material in all {
            let kind = material.diffuse_texture;
            if let Some(known) = kinds.iter().position(|other| *other == kind) {
                group_of.push(known);
                continue;
            }
            let texture = match kind {
                Some(index) => textures
                    .get(index)
                    .context("a material names a texture that isn't there")?,
                None => &white,
            };
            let view = upload(device, queue, texture);
            let bytes = wgpu::BufferBinding {
                buffer: &numbers,
                offset: 0,
                size: std::num::NonZeroU64::new(48),
            };
            let resources = [
                wgpu::BindingResource::Buffer(bytes),
                wgpu::BindingResource::TextureView(&view),
                wgpu::BindingResource::Sampler(&sampler),
            ];
            group_of.push(groups.len());
            groups.push(group(device, &layouts.material, resources));
            kinds.push(kind);
        }
        Ok(Self { groups, group_of })
    }
}

/// Uploads a texture of colours, with smaller and smaller copies down to a texel.
fn upload(device: &wgpu::Device, queue: &wgpu::Queue, texture: &Texture) -> wgpu::TextureView {
    let most = device.limits().max_texture_dimension_2d;
    let mut size = texture.size;
    let mut texels = texture.texels.clone();
    while size.max_element() > most {
        (size, texels) = halved(size, &texels);
    }
    let levels = 32 - size.max_element().leading_zeros();
    let uploaded = device.create_texture(&wgpu::TextureDescriptor {
        label: Some(&texture.name),
        size: extent(size),
        mip_level_count: levels,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8UnormSrgb,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    for level in 0..levels {
        let bytes: Vec<u8> = texels
            .iter()
            .flat_map(|&[r, g, b, _]| {
                [
                    picture::encode(r),
                    picture::encode(g),
                    picture::encode(b),
                    255,
                ]
            })
            .collect();
        let place = wgpu::TexelCopyTextureInfo {
            mip_level: level,
            ..uploaded.as_image_copy()
        };
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(4 * size.x),
            rows_per_image: None,
        };
        queue.write_texture(place, &bytes, layout, extent(size));
        (size, texels) = halved(size, &texels);
    }
    uploaded.create_view(&wgpu::TextureViewDescriptor::default())
}

fn extent(size: UVec2) -> wgpu::Extent3d {
    wgpu::Extent3d {
        width: size.x,
        height: size.y,
        depth_or_array_layers: 1,
    }
}

/// Returns an image of half the size: means of four texels.
fn halved(size: UVec2, texels: &[[f32; 4]]) -> (UVec2, Vec<[f32; 4]>) {
    let smaller = (size / 2).max(UVec2::ONE);
    let at = |x: u32, y: u32| {
        let x = x.min(size.x - 1);
        let y = y.min(size.y - 1);
        Vec4::from(texels[(y * size.x + x) as usize])
    };
    let mut out = Vec::with_capacity((smaller.x * smaller.y) as usize);
    for y in 0..smaller.y {
        for x in 0..smaller.x {
            let upper = at(2 * x, 2 * y) + at(2 * x + 1, 2 * y);
            let lower = at(2 * x, 2 * y + 1) + at(2 * x + 1, 2 * y + 1);
            out.push((0.25 * (upper + lower)).to_array());
        }
    }
    (smaller, out)
}
