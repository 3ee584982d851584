//! The cast stage: every caster into every light space.

use crate::{
    bindings::{Binding, Bound, Slot},
    counters::Maker,
    frame::Drawable,
    images::GpuImage,
    pipelines::{CastKey, Pipelines},
    stamps::{Stage, Stamps, pass_stamps},
    targets::CastTarget,
};
use glam::Mat4;
use std::{num::NonZeroU64, ops::Range};
use umbrage_core::Cast;
use wgpu::{
    BindGroupLayout, Buffer, BufferUsages, CommandEncoder, IndexFormat, RenderPass, RenderPassDescriptor,
    RenderPipeline, ShaderStages,
};

/// Ready to be encoded.
#[derive(Debug, Default)]
pub(crate) struct CastStage {
    pub(crate) targets: Vec<CastTarget>,
    /// For each target, and in it for each draw.
    pipelines: Vec<Vec<RenderPipeline>>,
    draws: Vec<Draw>,
    spaces: Matrices,
    places: Matrices,
}

/// A drawable that outlives the borrow.
#[derive(Debug)]
struct Draw {
    vertices: Buffer,
    indices: Option<(Buffer, IndexFormat)>,
    range: Range<u32>,
    placed: bool,
}

impl CastStage {
    pub(crate) fn prepare(
        &mut self,
        maker: &mut Maker<'_>,
        pipelines: &mut Pipelines,
        casts: &[Cast],
        images: &[GpuImage],
        casters: &[Drawable<'_>],
    ) {
        self.targets = (0..casts.len()).map(|i| target(casts, i, images)).collect();
        let drawn = || casters.iter().filter(|d| !d.range.is_empty());
        self.draws = drawn().map(Draw::new).collect();
        self.spaces.write(maker, pipelines, self.targets.iter().map(|t| t.clip_from_world));
        self.places.write(maker, pipelines, drawn().map(|d| d.world_from_local.map_or(Mat4::IDENTITY, Mat4::from)));
        let layout = matrix_layout(maker, pipelines);
        let mut pipeline = |target: &CastTarget, drawable: &Drawable<'_>| {
            let placed = drawable.world_from_local.is_some();
            let key = CastKey { depth: target.state(), layout: drawable.layout, placed };
            pipelines.cast(maker, key, &[Some(&layout), placed.then_some(&layout)])
        };
        self.pipelines = self.targets.iter().map(|t| drawn().map(|d| pipeline(t, d)).collect()).collect();
    }

    pub(crate) fn encode(&self, encoder: &mut CommandEncoder, stamps: Option<&Stamps<'_>>) {
        for (i, target) in self.targets.iter().enumerate() {
            let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
                label: Some("umbrage cast"),
                depth_stencil_attachment: Some(target.attachment()),
                timestamp_writes: pass_stamps(stamps, Stage::Cast, i, self.targets.len()),
                ..RenderPassDescriptor::default()
            });
            self.spaces.bind(&mut pass, 0, i);
            self.draw(&mut pass, &self.pipelines[i]);
        }
    }

    fn draw(&self, pass: &mut RenderPass<'_>, pipelines: &[RenderPipeline]) {
        for (i, (draw, pipeline)) in self.draws.iter().zip(pipelines).enumerate() {
            if i == 0 || pipelines[i - 1] != *pipeline {
                pass.set_pipeline(pipeline);
            }
            if draw.placed {
                self.places.bind(pass, 1, i);
            }
            pass.set_vertex_buffer(0, draw.vertices.slice(..));
            match &draw.indices {
                Some((buffer, format)) => {
                    pass.set_index_buffer(buffer.slice(..), *format);
                    pass.draw_indexed(draw.range.clone(), 0, 0..1);
                }
                None => pass.draw(draw.range.clone(), 0..1),
            }
        }
    }
}

fn target(casts: &[Cast], index: usize, images: &[GpuImage]) -> CastTarget {
    let image = &images[casts[index].image];
    CastTarget::new(casts, index, &image.layers[casts[index].layer as usize], image.desc.size)
}

impl Draw {
    fn new(drawable: &Drawable<'_>) -> Self {
        Self {
            vertices: drawable.vertices.clone(),
            indices: drawable.indices.map(|i| (i.buffer.clone(), i.format)),
            range: drawable.range.clone(),
            placed: drawable.world_from_local.is_some(),
        }
    }
}

const MATRIX: NonZeroU64 = NonZeroU64::new(64).unwrap();

fn matrix_layout(maker: &Maker<'_>, pipelines: &mut Pipelines) -> BindGroupLayout {
    pipelines.layouts.get(maker, ShaderStages::VERTEX, &[Slot::Window(MATRIX)])
}

/// A uniform buffer of matrices, bound one at a time.
#[derive(Debug, Default)]
struct Matrices {
    buffer: Option<Buffer>,
    binding: Binding,
    stride: u32,
}

impl Matrices {
    fn write(&mut self, maker: &mut Maker<'_>, pipelines: &mut Pipelines, matrices: impl Iterator<Item = Mat4>) {
        self.stride = maker.device.limits().min_uniform_buffer_offset_alignment.max(64);
        let mut bytes = Vec::new();
        for (i, matrix) in matrices.enumerate() {
            bytes.resize(i * self.stride as usize, 0);
            bytes.extend_from_slice(bytemuck::bytes_of(&matrix));
        }
        if bytes.is_empty() {
            return;
        }
        let buffer = maker.write(&mut self.buffer, "umbrage matrices", BufferUsages::UNIFORM, &bytes);
        let layout = matrix_layout(maker, pipelines);
        self.binding.set(maker, "umbrage matrices", &layout, vec![Bound::Window(buffer, MATRIX)]);
    }

    fn bind(&self, pass: &mut RenderPass<'_>, group: u32, index: usize) {
        pass.set_bind_group(group, self.binding.group(), &[self.stride * index as u32]);
    }
}
