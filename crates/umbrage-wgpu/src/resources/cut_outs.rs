//! Triangles with holes on the GPU: what the shaders that leave the holes out read.

use crate::{
    frame::FrameInputs,
    resources::{
        bindings::{Binding, Bound, Slot},
        counters::ResourceFactory,
        pipelines::Pipelines,
    },
};
use std::{num::NonZeroU64, sync::Arc};
use umbrage_core::{
    CameraRays, CutOuts, MATH, Module,
    bvh::{RAY_BOX, RAY_TRIANGLE},
    cut_out::{CUT_OUT, HOLE},
    hashed_alpha::{HASHED_ALPHA, HASHED_HOLE},
    join,
    resolve::RESOLVE,
};
use wgpu::{BindGroupLayout, Buffer, BufferUsages, RenderPass, ShaderStages};

/// A geometry's cut-outs: its lists of triangles, and the table of holes.
#[derive(Clone, Debug)]
pub(crate) struct GpuCutOuts {
    pub(crate) cut_outs: Arc<CutOuts>,
    pub(crate) positions: Buffer,
    pub(crate) indices: Buffer,
    pub(crate) rows: Buffer,
    /// Mipmapped coverages of alpha textures; none where all are asked for the nearest texel.
    pub(crate) coverage: Option<Buffer>,
    pub(crate) casters: std::ops::Range<u32>,
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
