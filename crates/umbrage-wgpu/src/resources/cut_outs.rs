//! Triangles with holes on the GPU: what the shaders that leave the holes out read.

use crate::{
    frame::FrameInputs,
    prefix::with_prefix,
    resources::{
        bindings::{Binding, Bound, Slot},
        counters::{Counters, ResourceFactory},
        geometry::GpuGeometry,
        pipelines::Pipelines,
    },
};
use std::{num::NonZeroU64, ops::Range, sync::Arc};
use umbrage_core::{
    Aabb, CameraRays, CutOuts, Geometry, Invalid, MATH, Module,
    bvh::{RAY_BOX, RAY_TRIANGLE},
    cut_out::{CUT_OUT, HOLE},
    hashed_alpha::{HASHED_ALPHA, HASHED_HOLE},
    join,
    resolve::RESOLVE,
};
use wgpu::{
    BindGroup, BindGroupDescriptor, BindGroupEntry, BindGroupLayout, BindGroupLayoutDescriptor,
    BindGroupLayoutEntry, Buffer, BufferUsages, Device, Queue, RenderPass, ShaderStages,
};

/// A geometry's cut-outs: its lists of triangles, and the table of holes.
#[derive(Clone, Debug)]
pub(crate) struct GpuCutOuts {
    pub(crate) cut_outs: Arc<CutOuts>,
    pub(crate) positions: Buffer,
    pub(crate) indices: Buffer,
    pub(crate) rows: Buffer,
    /// Mipmapped coverages of alpha textures; none where all are asked for the nearest texel.
    pub(crate) coverage: Option<Buffer>,
    pub(crate) casters: Range<u32>,
    pub(crate) triangles: u32,
}

/// Triangles of a part of the casters, so few that a map leaves out those that it can't show.
const PART: u32 = 4096;

/// Storage buffers that the rule for holes reads, at most.
const MOST_BUFFERS: u32 = 4;

/// A geometry's triangles with holes, on the device.
///
/// [`LightSet::set_cut_outs`](crate::LightSet::set_cut_outs) casts them. For a pass of the program's own, such as the camera's,
/// [`wgsl`](Self::wgsl) is the rule that tells holes, and [`bind_group`](Self::bind_group) what it reads.
#[derive(Clone, Debug)]
pub struct CutOutBuffers {
    pub(crate) lists: GpuCutOuts,
    /// Casters with holes, in parts that are near each other in the list, with the box around each.
    pub(crate) parts: Vec<(Range<u32>, Aabb)>,
}

impl CutOutBuffers {
    /// Uploads a geometry's triangles with holes; none if it has none, which costs nothing.
    ///
    /// # Errors
    /// Errors if a list is larger than the device allows, or if its shaders can't read four storage buffers.
    pub fn new(
        device: &Device,
        queue: &Queue,
        geometry: &Geometry,
    ) -> Result<Option<Self>, Invalid> {
        let Some(cut_outs) = geometry.cut_outs() else {
            return Ok(None);
        };
        let stage = device.limits().max_storage_buffers_per_shader_stage;
        if stage < MOST_BUFFERS {
            let why = format!(
                "are read from up to {MOST_BUFFERS} storage buffers, and the device allows {stage}"
            );
            let help =
                format!("ask for `max_storage_buffers_per_shader_stage` of {MOST_BUFFERS} or more");
            return Err(Invalid::new("triangles with holes", why, help));
        }
        let mut counters = Counters::default();
        let mut factory = ResourceFactory {
            device,
            queue,
            counters: &mut counters,
        };
        let uploaded = GpuGeometry::upload(&mut factory, geometry)?;
        let casters = geometry.casters();
        let [_, runs] = cut_outs.split(std::slice::from_ref(&casters));
        let mut parts = Vec::new();
        for run in runs {
            for start in run.clone().step_by(PART as usize) {
                let part = start..(start + PART).min(run.end);
                let bounds = Aabb::around(geometry.vertices_of(part.clone()));
                parts.push((part, bounds));
            }
        }
        Ok(uploaded.cut_outs.map(|lists| Self { lists, parts }))
    }

    /// Returns the WGSL that tells holes, to paste before your own shader. Bind [`bind_group`](Self::bind_group) at `group`.
    ///
    /// * `is_hole(rays: CameraRays, at: vec4f, triangle: u32) -> bool`: whether a pixel lies in a hole of a triangle's. `at` is
    ///   `@builtin(position)`, `rays` are [`Camera::rays`](umbrage_core::Camera::rays) or [`CastTarget::rays`](crate::CastTarget::rays),
    ///   in a uniform of yours, and `triangle` is the id in the geometry; with `draw(3 * first..3 * end, ..)` that is `vertex_index / 3`.
    /// * `corner(i: u32) -> vec3f`: where the i-th corner of all triangles is.
    ///
    /// `prefix` stands before every name that the text declares, these among them.
    ///
    /// # Errors
    /// Errors if the prefix can't begin a WGSL identifier.
    pub fn wgsl(&self, group: u32, prefix: &str) -> Result<String, Invalid> {
        let rule = self.lists.rule();
        let mut tables = format!(
            "\
@group({group}) @binding(0) var<storage> positions: array<f32>;
@group({group}) @binding(1) var<storage> indices: array<u32>;
@group({group}) @binding(2) var<storage> cut_outs: array<vec4u>;
fn corner(i: u32) -> vec3f {{
    let v = 3u * indices[i];
    return vec3f(positions[v], positions[v + 1u], positions[v + 2u]);
}}
"
        );
        if rule == HoleRule::Hashed {
            tables +=
                &format!("@group({group}) @binding(3) var<storage> coverage: array<vec4u>;\n");
        }
        with_prefix(&(holes_wgsl(rule) + &tables), prefix)
    }

    /// Returns what [`wgsl`](Self::wgsl) reads, and its layout for pipelines.
    pub fn bind_group(&self, device: &Device) -> (BindGroup, BindGroupLayout) {
        let lists = &self.lists;
        let mut buffers = vec![&lists.positions, &lists.indices, &lists.rows];
        buffers.extend(&lists.coverage);
        let layout_entry = |binding| BindGroupLayoutEntry {
            binding,
            visibility: ShaderStages::VERTEX_FRAGMENT,
            ty: Slot::Table.ty(),
            count: None,
        };
        let layout_entries: Vec<_> = (0..buffers.len() as u32).map(layout_entry).collect();
        let layout = device.create_bind_group_layout(&BindGroupLayoutDescriptor {
            label: Some("umbrage cut-outs"),
            entries: &layout_entries,
        });
        let entries: Vec<_> = (0..)
            .zip(buffers)
            .map(|(binding, buffer)| BindGroupEntry {
                binding,
                resource: buffer.as_entire_binding(),
            })
            .collect();
        let group = device.create_bind_group(&BindGroupDescriptor {
            label: Some("umbrage cut-outs"),
            layout: &layout,
            entries: &entries,
        });
        (group, layout)
    }
}

/// What a frame draws: the drawables of its inputs, and triangles with holes beside them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FrameWithHoles<'a> {
    pub(crate) inputs: &'a FrameInputs<'a>,
    /// None where nothing has holes.
    pub(crate) holes: Option<&'a GpuCutOuts>,
}

/// Bytes of the rays through an image's pixels.
const RAYS: NonZeroU64 = NonZeroU64::new(96).unwrap();

/// How images ask alpha textures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum HoleRule {
    /// All for the nearest texel.
    Nearest,
    /// Some for mipmapped coverages.
    Hashed,
}

impl GpuCutOuts {
    pub(crate) fn rule(&self) -> HoleRule {
        match self.coverage {
            None => HoleRule::Nearest,
            Some(_) => HoleRule::Hashed,
        }
    }
}

/// Returns the WGSL that tells holes, before whoever declares `cut_outs`, `corner` and, for the hashed rule, `coverage`.
pub(crate) fn holes_wgsl(rule: HoleRule) -> String {
    const MODULES: [Module; 6] = [MATH, RESOLVE, RAY_BOX, RAY_TRIANGLE, CUT_OUT, HOLE];
    let common = join(&MODULES);
    let which = include_str!("../holes.wgsl");
    match rule {
        HoleRule::Nearest => common + which + include_str!("../holes_nearest.wgsl"),
        HoleRule::Hashed => {
            let hashed = join(&[HASHED_ALPHA, HASHED_HOLE]);
            common + &hashed + which + include_str!("../holes_hashed.wgsl")
        }
    }
}

/// Returns the layout of what casts of triangles with holes read, in group 1.
pub(crate) fn cut_out_layout(
    factory: &ResourceFactory<'_>,
    pipelines: &mut Pipelines,
    rule: HoleRule,
) -> BindGroupLayout {
    let mut slots = vec![Slot::Window(RAYS), Slot::Table, Slot::Table, Slot::Table];
    if rule == HoleRule::Hashed {
        slots.push(Slot::Table);
    }
    let stages = ShaderStages::VERTEX_FRAGMENT;
    pipelines.layouts.get(factory, stages, &slots)
}

/// The lists, and the rays of each cast.
#[derive(Debug, Default)]
pub(crate) struct CutOutBinding {
    buffer: Option<Buffer>,
    binding: Binding,
    /// Bytes from one cast's rays to the next.
    stride: u32,
}

impl CutOutBinding {
    pub(crate) fn write(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        layout: &BindGroupLayout,
        holes: &GpuCutOuts,
        rays: impl Iterator<Item = CameraRays>,
    ) {
        let limits = factory.device.limits();
        self.stride = limits.min_uniform_buffer_offset_alignment.max(128);
        let mut bytes = Vec::new();
        for (i, rays) in rays.enumerate() {
            bytes.resize(i * self.stride as usize, 0);
            let CameraRays {
                origin,
                origin_dx,
                origin_dy,
                dir,
                dir_dx,
                dir_dy,
            } = rays;
            let rows = [origin, origin_dx, origin_dy, dir, dir_dx, dir_dy];
            bytes.extend_from_slice(bytemuck::bytes_of(&rows));
        }
        if bytes.is_empty() {
            return;
        }
        let usage = BufferUsages::UNIFORM;
        let buffer = factory.write(&mut self.buffer, "umbrage texels' rays", usage, &bytes);
        let mut bound = vec![
            Bound::Window(buffer, RAYS),
            Bound::Buffer(holes.positions.clone()),
            Bound::Buffer(holes.indices.clone()),
            Bound::Buffer(holes.rows.clone()),
        ];
        bound.extend(holes.coverage.clone().map(Bound::Buffer));
        self.binding.set(factory, "umbrage cut-outs", layout, bound);
    }

    pub(crate) fn bind(&self, pass: &mut RenderPass<'_>, group: u32, cast: usize) {
        pass.set_bind_group(group, self.binding.group(), &[self.stride * cast as u32]);
    }
}
