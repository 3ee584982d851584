//! Triangles with holes on the GPU, as shaders that leave the holes out read them.

use crate::{
    frame::FrameInputs,
    resources::{
        bindings::{Binding, Bound, Slot},
        counters::ResourceFactory,
        pipelines::Pipelines,
        windows::Windows,
    },
    wgsl::stages::HoleRule,
};
use std::{num::NonZeroU64, ops::Range, sync::Arc};
use umbrage_core::{CameraRays, CutOuts};
use wgpu::{BindGroupLayout, Buffer, RenderPass, ShaderStages};

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

/// What a frame draws: the drawables of its inputs, and triangles with holes beside them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FrameWithHoles<'a> {
    pub(crate) inputs: &'a FrameInputs<'a>,
    /// None where nothing has holes.
    pub(crate) holes: Option<&'a GpuCutOuts>,
}

/// Bytes of the rays through an image's pixels.
const RAYS: NonZeroU64 = NonZeroU64::new(96).unwrap();

impl GpuCutOuts {
    pub(crate) fn rule(&self) -> HoleRule {
        match self.coverage {
            None => HoleRule::Nearest,
            Some(_) => HoleRule::Hashed,
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
    rays: Windows,
    binding: Binding,
}

impl CutOutBinding {
    pub(crate) fn write(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        layout: &BindGroupLayout,
        holes: &GpuCutOuts,
        rays: impl Iterator<Item = CameraRays>,
    ) {
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
        let Some(buffer) = self.rays.write(factory, "umbrage texels' rays", rows) else {
            return;
        };
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
        pass.set_bind_group(group, self.binding.group(), &[self.rays.offset(cast)]);
    }
}
