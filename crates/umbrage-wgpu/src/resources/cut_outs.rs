//! Alpha-tested triangles on the GPU, as shaders read them.

use crate::{
    frame::FrameInputs,
    resources::{
        bindings::{Binding, Bound, Slot},
        counters::ResourceFactory,
        pipelines::{Pipelines, RAYS_SLOT},
        windows::Windows,
    },
    wgsl::stages::HoleRule,
};
use std::{ops::Range, sync::Arc};
use umbrage_core::{CameraRays, CutOuts};
use wgpu::{Buffer, RenderPass, ShaderStages};

/// A geometry's alpha-tested triangles: its lists of triangles, and the table of their records.
#[derive(Clone, Debug)]
pub(crate) struct GpuCutOuts {
    pub(crate) cut_outs: Arc<CutOuts>,
    pub(crate) positions: Buffer,
    pub(crate) indices: Buffer,
    pub(crate) rows: Buffer,
    /// Mipmapped coverages of alpha textures; `None` if all use the nearest texel.
    pub(crate) coverage: Option<Buffer>,
    pub(crate) casters: Range<u32>,
    pub(crate) triangles: u32,
}

/// Inputs of a frame: the caller's drawables, and alpha-tested triangles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FrameWithHoles<'a> {
    pub(crate) inputs: &'a FrameInputs<'a>,
    /// `None` if there are no alpha-tested triangles.
    pub(crate) holes: Option<&'a GpuCutOuts>,
}

impl GpuCutOuts {
    pub(crate) fn rule(&self) -> HoleRule {
        match self.coverage {
            None => HoleRule::Nearest,
            Some(_) => HoleRule::Hashed,
        }
    }
}

/// The lists, and the rays of each cast.
#[derive(Debug, Default)]
pub(crate) struct CutOutBinding {
    rays: Windows,
    binding: Binding,
}

impl CutOutBinding {
    /// Writes the rays that can be bound. Returns the number of written bytes: 0 if none changed.
    pub(crate) fn write(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        pipelines: &mut Pipelines,
        holes: &GpuCutOuts,
        rays: impl Iterator<Item = CameraRays>,
    ) -> u64 {
        let rows = rays.map(|rays| {
            let CameraRays {
                origin,
                origin_dx,
                origin_dy,
                dir,
                dir_dx,
                dir_dy,
            } = rays;
            [origin, origin_dx, origin_dy, dir, dir_dx, dir_dy]
        });
        let Some((buffer, written)) = self.rays.write(factory, "umbrage texels' rays", rows) else {
            return 0;
        };
        let mut entries = vec![(RAYS_SLOT, Bound::of_slot(RAYS_SLOT, buffer))];
        let tables = [&holes.positions, &holes.indices, &holes.rows];
        for table in tables.into_iter().chain(&holes.coverage) {
            entries.push((Slot::Table, Bound::Buffer(table.clone())));
        }
        let layouts = &mut pipelines.layouts;
        let stages = ShaderStages::VERTEX_FRAGMENT;
        self.binding
            .bind(factory, layouts, stages, "umbrage cut-outs", entries);
        written
    }

    pub(crate) fn bind(&self, pass: &mut RenderPass<'_>, group: u32, cast: usize) {
        pass.set_bind_group(group, self.binding.group(), &[self.rays.offset(cast)]);
    }
}
