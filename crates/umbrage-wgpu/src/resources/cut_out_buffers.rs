//! [`CutOutBuffers`]: a geometry's triangles with holes, for light sets and for passes of the caller's.

use crate::{
    resources::{
        bindings::Slot,
        counters::{Counters, ResourceFactory},
        cut_outs::GpuCutOuts,
        geometry::GpuGeometry,
    },
    wgsl::{resolver::with_prefix, stages::holes_wgsl},
};
use std::ops::Range;
use umbrage_core::{Aabb, Geometry, Invalid};
use wgpu::{
    BindGroup, BindGroupDescriptor, BindGroupEntry, BindGroupLayout, BindGroupLayoutDescriptor,
    BindGroupLayoutEntry, Device, Queue, ShaderStages,
};

/// Triangles of a part of the casters, so few that a map leaves out those that it can't show.
const PART: u32 = 4096;

/// Storage buffers that the rule for holes reads, at most.
const MOST_BUFFERS: u32 = 4;

/// A geometry's triangles with holes, on the device.
///
/// [`LightSet::set_cut_outs`](crate::LightSet::set_cut_outs) casts them. For a pass of the
/// program's own, such as the camera's, [`wgsl`](Self::wgsl) is the rule for holes, and
/// [`bind_group`](Self::bind_group) what it reads.
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
    /// Errors if a list is larger than the device allows, or if its shaders can't read four storage
    /// buffers.
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
                format!("request `max_storage_buffers_per_shader_stage` of {MOST_BUFFERS} or more");
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

    /// Returns the WGSL of the rule for holes, to paste before your own shader. Bind
    /// [`bind_group`](Self::bind_group) at `group`.
    ///
    /// * `is_hole(rays: CameraRays, at: vec4f, triangle: u32) -> bool`: whether a pixel is in a
    ///   hole of a triangle. `at` is `@builtin(position)`, `rays` are
    ///   [`Camera::rays`](umbrage_core::Camera::rays) or
    ///   [`CastTarget::rays`](crate::CastTarget::rays), in a uniform of yours, and `triangle` is
    ///   the id in the geometry; with `draw(3 * first..3 * end, ..)` that is `vertex_index / 3`.
    /// * `corner(i: u32) -> vec3f`: where the i-th corner of all triangles is.
    ///
    /// `prefix` stands before every name that the text declares, these among them.
    ///
    /// # Errors
    /// Errors if the prefix can't begin a WGSL identifier.
    pub fn wgsl(&self, group: u32, prefix: &str) -> Result<String, Invalid> {
        let rule = self.lists.rule();
        with_prefix(&holes_wgsl(rule, group), prefix)
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
