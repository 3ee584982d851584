//! [`CutOutBuffers`]: a geometry's alpha-tested triangles, for light sets and for passes of the
//! caller.

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

/// Greatest number of triangles in a part of the casters: small enough that a map skips invisible
/// parts.
const PART: u32 = 4096;

/// Greatest number of storage buffers that the alpha test reads.
const MOST_BUFFERS: u32 = 4;

/// A geometry's alpha-tested triangles, on the device.
///
/// [`LightSet::set_cut_outs`](crate::LightSet::set_cut_outs) casts them. For a pass of the program,
/// such as the camera's, [`wgsl`](Self::wgsl) is the alpha test, and
/// [`bind_group`](Self::bind_group) its bindings.
#[derive(Clone, Debug)]
pub struct CutOutBuffers {
    pub(crate) lists: GpuCutOuts,
    /// Alpha-tested casters, in parts that are consecutive in the list, with the box around each.
    pub(crate) parts: Vec<(Range<u32>, Aabb)>,
}

impl CutOutBuffers {
    /// Uploads a geometry's alpha-tested triangles; `None` if there are none, at no cost.
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
            let why =
                format!("need up to {MOST_BUFFERS} storage buffers, and the device allows {stage}");
            let help =
                format!("request `max_storage_buffers_per_shader_stage` of {MOST_BUFFERS} or more");
            return Err(Invalid::new("alpha-tested triangles", why, help));
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
                let bounds = Aabb::from_points(geometry.vertices_of(part.clone()));
                parts.push((part, bounds));
            }
        }
        Ok(uploaded.cut_outs.map(|lists| Self { lists, parts }))
    }

    /// Returns the WGSL of the alpha test, to insert before your shader. Bind
    /// [`bind_group`](Self::bind_group) at `group`.
    ///
    /// * `is_hole(rays: CameraRays, at: vec4f, triangle: u32) -> bool` returns whether a pixel is
    ///   in a hole of a triangle. `at` is `@builtin(position)`. `rays` are
    ///   [`Camera::rays`](umbrage_core::Camera::rays) or
    ///   [`CastTarget::rays`](crate::CastTarget::rays), in a uniform of yours. `triangle` is the id
    ///   in the geometry; with `draw(3 * first..3 * end, ..)` that is `vertex_index / 3`.
    /// * `corner(i: u32) -> vec3f` returns the position of the i-th corner of all triangles.
    ///
    /// `prefix` is prepended to every name that the text declares, including these.
    ///
    /// # Errors
    /// Errors if the prefix can't begin a WGSL identifier.
    pub fn wgsl(&self, group: u32, prefix: &str) -> Result<String, Invalid> {
        let rule = self.lists.rule();
        with_prefix(&holes_wgsl(rule, group), prefix)
    }

    /// Returns the bind group of [`wgsl`](Self::wgsl), and its layout for pipelines.
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
