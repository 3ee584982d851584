//! Render pipelines, each built once.

use crate::{bindings::Layouts, counters::Maker, frame::VertexLayout, targets::DepthState};
use std::collections::HashMap;
use umbrage_core::{MATH, join};
use wgpu::{
    BindGroupLayout, Device, FragmentState, MultisampleState, PipelineCompilationOptions, PipelineLayoutDescriptor,
    PrimitiveState, RenderPipeline, RenderPipelineDescriptor, ShaderModule, ShaderModuleDescriptor, ShaderSource,
    TextureFormat, VertexAttribute, VertexBufferLayout, VertexFormat, VertexState, VertexStepMode,
};

/// What distinguishes the pipelines that draw casters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct CastKey {
    pub(crate) depth: DepthState,
    pub(crate) layout: VertexLayout,
    /// Whether vertices need placing into the world.
    pub(crate) placed: bool,
}

/// All that was built.
#[derive(Debug, Default)]
pub(crate) struct Pipelines {
    pub(crate) layouts: Layouts,
    casts: HashMap<CastKey, RenderPipeline>,
    /// By shader text and target; the text tells the bindings.
    kernels: HashMap<(String, TextureFormat), RenderPipeline>,
    cast_shader: Option<ShaderModule>,
}

impl Pipelines {
    pub(crate) fn cast(
        &mut self,
        maker: &mut Maker<'_>,
        key: CastKey,
        groups: &[Option<&BindGroupLayout>],
    ) -> RenderPipeline {
        if let Some(pipeline) = self.casts.get(&key) {
            return pipeline.clone();
        }
        let shader = self
            .cast_shader
            .get_or_insert_with(|| shader(maker.device, "umbrage cast", &(join(&[MATH]) + include_str!("cast.wgsl"))));
        maker.counters.pipelines += 1;
        let pipeline = cast_pipeline(maker.device, shader, key, groups);
        self.casts.entry(key).insert_entry(pipeline).get().clone()
    }

    /// A full-screen pipeline for a kernel.
    pub(crate) fn kernel(
        &mut self,
        maker: &mut Maker<'_>,
        label: &str,
        (text, entry): (String, &str),
        target: TextureFormat,
        groups: &[Option<&BindGroupLayout>],
    ) -> RenderPipeline {
        let key = (text, target);
        if let Some(pipeline) = self.kernels.get(&key) {
            return pipeline.clone();
        }
        maker.counters.pipelines += 1;
        let pipeline =
            fullscreen_pipeline(maker.device, label, &key.0, ["umbrage_fullscreen", entry], &[target], groups);
        self.kernels.entry(key).insert_entry(pipeline).get().clone()
    }
}

pub(crate) fn shader(device: &Device, label: &str, text: &str) -> ShaderModule {
    let source = ShaderSource::Wgsl(text.into());
    device.create_shader_module(ShaderModuleDescriptor { label: Some(label), source })
}

fn cast_pipeline(
    device: &Device,
    module: &ShaderModule,
    key: CastKey,
    groups: &[Option<&BindGroupLayout>],
) -> RenderPipeline {
    let attribute =
        VertexAttribute { format: VertexFormat::Float32x3, offset: key.layout.position_offset, shader_location: 0 };
    let buffer = VertexBufferLayout {
        array_stride: key.layout.stride,
        step_mode: VertexStepMode::Vertex,
        attributes: &[attribute],
    };
    let vertex = VertexState {
        module,
        entry_point: Some(if key.placed { "from_local" } else { "from_world" }),
        compilation_options: PipelineCompilationOptions::default(),
        buffers: &[Some(buffer)],
    };
    device.create_render_pipeline(&RenderPipelineDescriptor {
        label: Some("umbrage cast"),
        layout: Some(&pipeline_layout(device, groups)),
        vertex,
        primitive: key.depth.primitive(),
        depth_stencil: Some(key.depth.depth_stencil()),
        multisample: MultisampleState::default(),
        fragment: None,
        multiview_mask: None,
        cache: None,
    })
}

/// A pipeline whose one triangle covers the targets; `entries` are its vertex and its fragment shader.
pub(crate) fn fullscreen_pipeline(
    device: &Device,
    label: &str,
    text: &str,
    entries: [&str; 2],
    targets: &[TextureFormat],
    groups: &[Option<&BindGroupLayout>],
) -> RenderPipeline {
    let module = &shader(device, label, text);
    let options = PipelineCompilationOptions::default;
    let targets: Vec<_> = targets.iter().map(|&format| Some(format.into())).collect();
    device.create_render_pipeline(&RenderPipelineDescriptor {
        label: Some(label),
        layout: Some(&pipeline_layout(device, groups)),
        vertex: VertexState { module, entry_point: Some(entries[0]), compilation_options: options(), buffers: &[] },
        primitive: PrimitiveState::default(),
        depth_stencil: None,
        multisample: MultisampleState::default(),
        fragment: Some(FragmentState {
            module,
            entry_point: Some(entries[1]),
            compilation_options: options(),
            targets: &targets,
        }),
        multiview_mask: None,
        cache: None,
    })
}

pub(crate) fn pipeline_layout(device: &Device, groups: &[Option<&BindGroupLayout>]) -> wgpu::PipelineLayout {
    let desc = PipelineLayoutDescriptor { label: Some("umbrage"), bind_group_layouts: groups, immediate_size: 0 };
    device.create_pipeline_layout(&desc)
}
