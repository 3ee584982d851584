//! Cache of render pipelines.

use crate::{
    frame::VertexLayout,
    resources::{
        bindings::{self, Layouts, Slot},
        counters::ResourceFactory,
    },
    targets::{CastTarget, DepthState},
    wgsl::stages::{HoleRule, cast_wgsl},
};
use std::{collections::HashMap, num::NonZeroU64};
use umbrage_core::Format;
use wgpu::{
    BindGroupLayout, CompareFunction, ComputePipeline, ComputePipelineDescriptor, DepthBiasState,
    DepthStencilState, Device, FilterMode, FragmentState, MultisampleState,
    PipelineCompilationOptions, PipelineLayoutDescriptor, PrimitiveState, RenderPipeline,
    RenderPipelineDescriptor, Sampler, SamplerDescriptor, ShaderModule, ShaderModuleDescriptor,
    ShaderSource, ShaderStages, StencilState, TextureFormat, VertexAttribute, VertexBufferLayout,
    VertexFormat, VertexState, VertexStepMode,
};

/// A matrix.
pub(crate) const MATRIX_SLOT: Slot = Slot::Window(NonZeroU64::new(64).unwrap());
/// The rays through an image's texels.
pub(crate) const RAYS_SLOT: Slot = Slot::Window(NonZeroU64::new(96).unwrap());
/// A layer to peel.
pub(crate) const PEELED_SLOT: Slot = Slot::Floats { layered: false };

/// Key of the pipelines of casts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct CastKey {
    depth: DepthState,
    layout: VertexLayout,
    vertex: Vertex,
    peel: Peel,
}

/// Source of a vertex's position.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Vertex {
    /// A position in world space.
    World,
    /// A local position, with a matrix of the draw.
    Local,
    /// A local position, with a matrix of the instance.
    Instanced,
    /// Four floats in world space.
    Homogeneous,
    /// The index of a corner in the geometry's lists of alpha-tested triangles.
    CutOut(HoleRule),
}

/// Depth peeling of a cast.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Peel {
    Nothing,
    /// Discards fragments not behind another layer.
    Depth32,
    /// Discards fragments not behind another layer, with depths in steps of 1/65535.
    Depth16,
}

impl Peel {
    fn of_target(target: &CastTarget) -> Self {
        match (&target.behind, target.format()) {
            (None, _) => Self::Nothing,
            (Some(_), Format::Depth16) => Self::Depth16,
            (Some(_), _) => Self::Depth32,
        }
    }

    /// Returns the fragment shader, for opaque or alpha-tested triangles.
    const fn entry(self, has_holes: bool) -> Option<&'static str> {
        match (self, has_holes) {
            (Self::Nothing, false) => None,
            (Self::Depth32, false) => Some("behind"),
            (Self::Depth16, false) => Some("behind_in_steps"),
            (Self::Nothing, true) => Some("not_in_hole"),
            (Self::Depth32, true) => Some("behind_and_not_in_hole"),
            (Self::Depth16, true) => Some("behind_in_steps_and_not_in_hole"),
        }
    }
}

/// All cached pipelines, layouts and samplers.
#[derive(Debug, Default)]
pub(crate) struct Pipelines {
    pub(crate) layouts: Layouts,
    /// In a list, since there are few: comparing keys is faster than hashing one.
    casts: Vec<(CastKey, RenderPipeline)>,
    /// Pipelines by shader text, which declares the bindings, and target format.
    kernels: HashMap<(String, TextureFormat), RenderPipeline>,
    /// Compute pipelines by shader text.
    computes: HashMap<String, Vec<ComputePipeline>>,
    /// Shaders by the kind of alpha test, if any.
    cast_shaders: HashMap<Option<HoleRule>, ShaderModule>,
    sampler: Option<Sampler>,
}

impl Pipelines {
    /// Returns the pipeline that draws such vertices into a target.
    pub(crate) fn cast(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        target: &CastTarget,
        layout: VertexLayout,
        vertex: Vertex,
    ) -> RenderPipeline {
        let key = CastKey {
            depth: target.state(),
            layout,
            vertex,
            peel: Peel::of_target(target),
        };
        if let Some((_, pipeline)) = self.casts.iter().find(|(held, _)| *held == key) {
            return pipeline.clone();
        }
        let holes = match vertex {
            Vertex::CutOut(rule) => Some(rule),
            _ => None,
        };
        let make = || shader(factory.device, "umbrage cast", &cast_wgsl(holes));
        let shader = self.cast_shaders.entry(holes).or_insert_with(make);
        let groups = cast_groups(&mut self.layouts, factory, key);
        let groups = groups.each_ref().map(Option::as_ref);
        factory.counters.pipelines += 1;
        let pipeline = cast_pipeline(factory.device, shader, key, &groups);
        self.casts.push((key, pipeline.clone()));
        pipeline
    }

    /// Returns the sampler of kernels that compare.
    pub(crate) fn sampler(&mut self, device: &Device) -> Sampler {
        let desc = SamplerDescriptor {
            label: Some("umbrage comparison"),
            mag_filter: FilterMode::Linear,
            min_filter: FilterMode::Linear,
            compare: Some(CompareFunction::LessEqual),
            ..SamplerDescriptor::default()
        };
        self.sampler
            .get_or_insert_with(|| device.create_sampler(&desc))
            .clone()
    }

    /// Returns a full-screen pipeline for a kernel, with the fragment shader `entry` of the shader
    /// `text`.
    pub(crate) fn kernel(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        label: &str,
        text: String,
        entry: &str,
        target: TextureFormat,
        groups: &[Option<&BindGroupLayout>],
    ) -> RenderPipeline {
        let key = (text, target);
        if let Some(pipeline) = self.kernels.get(&key) {
            return pipeline.clone();
        }
        factory.counters.pipelines += 1;
        let pipeline = fullscreen_pipeline(
            factory.device,
            label,
            &key.0,
            ["umbrage_fullscreen", entry],
            &Targets::Colors(&[target]),
            groups,
        );
        self.kernels.entry(key).insert_entry(pipeline).get().clone()
    }

    /// Returns the pipelines of the compute shaders `entries` of the shader `text`, which are always
    /// the same for a text.
    pub(crate) fn computes(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        label: &str,
        text: String,
        entries: &[&str],
        groups: &[Option<&BindGroupLayout>],
    ) -> Vec<ComputePipeline> {
        let make = |text: &String| {
            factory.counters.pipelines += entries.len() as u32;
            let module = shader(factory.device, label, text);
            let pipeline = |entry: &&str| compute_pipeline(factory.device, &module, entry, groups);
            entries.iter().map(pipeline).collect()
        };
        self.computes.entry(text).or_insert_with_key(make).clone()
    }

    /// Returns the pipeline of the compute shader `entry`, the only one of the shader `text`.
    pub(crate) fn compute(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        label: &str,
        text: String,
        entry: &str,
        groups: &[Option<&BindGroupLayout>],
    ) -> ComputePipeline {
        self.computes(factory, label, text, &[entry], groups)
            .remove(0)
    }
}

/// Creates the layout of the bind group with clip from world, which all casts have at index 0.
pub(crate) fn cast_layout(device: &Device) -> BindGroupLayout {
    bindings::layout(device, ShaderStages::VERTEX, 0, &[MATRIX_SLOT])
}

/// Returns the layouts of the bind groups of casts: 0 is clip from world; 1 is world from local or
/// the inputs of the alpha test; 2 is the layer to peel.
fn cast_groups(
    layouts: &mut Layouts,
    factory: &ResourceFactory<'_>,
    key: CastKey,
) -> [Option<BindGroupLayout>; 3] {
    let matrix = layouts.get(factory, ShaderStages::VERTEX, &[MATRIX_SLOT]);
    let second = match key.vertex {
        Vertex::Local => Some(matrix.clone()),
        Vertex::CutOut(rule) => {
            let tables = match rule {
                HoleRule::Nearest => 3,
                HoleRule::Hashed => 4,
            };
            let mut slots = vec![RAYS_SLOT];
            slots.extend(vec![Slot::Table; tables]);
            Some(layouts.get(factory, ShaderStages::VERTEX_FRAGMENT, &slots))
        }
        Vertex::World | Vertex::Instanced | Vertex::Homogeneous => None,
    };
    let peels = key.peel != Peel::Nothing;
    let peeled = peels.then(|| layouts.get(factory, ShaderStages::FRAGMENT, &[PEELED_SLOT]));
    [Some(matrix), second, peeled]
}

pub(crate) fn shader(device: &Device, label: &str, text: &str) -> ShaderModule {
    #[cfg(feature = "testing")]
    let text = &*crate::driver_model::rewrite_text(text);
    let source = ShaderSource::Wgsl(text.into());
    device.create_shader_module(ShaderModuleDescriptor {
        label: Some(label),
        source,
    })
}

/// Returns a compute pipeline.
pub(crate) fn compute_pipeline(
    device: &Device,
    module: &ShaderModule,
    entry: &str,
    groups: &[Option<&BindGroupLayout>],
) -> ComputePipeline {
    let layout = device.create_pipeline_layout(&PipelineLayoutDescriptor {
        label: Some(entry),
        bind_group_layouts: groups,
        ..PipelineLayoutDescriptor::default()
    });
    device.create_compute_pipeline(&ComputePipelineDescriptor {
        label: Some(entry),
        layout: Some(&layout),
        module,
        entry_point: Some(entry),
        compilation_options: PipelineCompilationOptions::default(),
        cache: None,
    })
}

fn cast_pipeline(
    device: &Device,
    module: &ShaderModule,
    key: CastKey,
    groups: &[Option<&BindGroupLayout>],
) -> RenderPipeline {
    let options = PipelineCompilationOptions::default;
    // Choose the vertex shader and its buffers.
    let (entry, format) = match key.vertex {
        Vertex::World => ("from_world", key.layout.format.vertex_format()),
        Vertex::Local => ("from_local", key.layout.format.vertex_format()),
        Vertex::Instanced => ("from_instance", key.layout.format.vertex_format()),
        Vertex::Homogeneous => ("from_homogeneous", VertexFormat::Float32x4),
        Vertex::CutOut(_) => ("from_list", VertexFormat::Float32x3),
    };
    let attribute = VertexAttribute {
        format,
        offset: key.layout.position_offset,
        shader_location: 0,
    };
    let buffer = VertexBufferLayout {
        array_stride: key.layout.stride,
        step_mode: VertexStepMode::Vertex,
        attributes: &[attribute],
    };
    let instances = VertexBufferLayout {
        array_stride: 48,
        step_mode: VertexStepMode::Instance,
        attributes: &wgpu::vertex_attr_array![1 => Float32x4, 2 => Float32x4, 3 => Float32x4],
    };
    let buffers = [Some(buffer), Some(instances)];
    let buffers = match key.vertex {
        Vertex::World | Vertex::Local | Vertex::Homogeneous => &buffers[..1],
        Vertex::Instanced => &buffers,
        Vertex::CutOut(_) => &[],
    };
    let vertex = VertexState {
        module,
        entry_point: Some(entry),
        compilation_options: options(),
        buffers,
    };
    // Create the pipeline.
    device.create_render_pipeline(&RenderPipelineDescriptor {
        label: Some("umbrage cast"),
        layout: Some(&pipeline_layout(device, groups)),
        vertex,
        primitive: key.depth.primitive(),
        depth_stencil: Some(key.depth.depth_stencil()),
        multisample: MultisampleState::default(),
        fragment: key
            .peel
            .entry(matches!(key.vertex, Vertex::CutOut(_)))
            .map(|entry| FragmentState {
                module,
                entry_point: Some(entry),
                compilation_options: options(),
                targets: &[],
            }),
        multiview_mask: None,
        cache: None,
    })
}

/// Outputs of a full-screen pipeline.
pub(crate) enum Targets<'a> {
    Colors(&'a [TextureFormat]),
    /// Overwrites depth.
    Depth(TextureFormat),
}

/// Returns a pipeline with one triangle that covers the targets; `entries` are its vertex and its
/// fragment shader.
pub(crate) fn fullscreen_pipeline(
    device: &Device,
    label: &str,
    text: &str,
    entries: [&str; 2],
    targets: &Targets<'_>,
    groups: &[Option<&BindGroupLayout>],
) -> RenderPipeline {
    let module = &shader(device, label, text);
    let options = PipelineCompilationOptions::default;
    let (colors, depth): (&[_], _) = match targets {
        Targets::Colors(formats) => (formats, None),
        Targets::Depth(format) => (&[], Some(*format)),
    };
    let colors: Vec<_> = colors.iter().map(|&format| Some(format.into())).collect();
    device.create_render_pipeline(&RenderPipelineDescriptor {
        label: Some(label),
        layout: Some(&pipeline_layout(device, groups)),
        vertex: VertexState {
            module,
            entry_point: Some(entries[0]),
            compilation_options: options(),
            buffers: &[],
        },
        primitive: PrimitiveState::default(),
        depth_stencil: depth.map(overwrite_depth),
        multisample: MultisampleState::default(),
        fragment: Some(FragmentState {
            module,
            entry_point: Some(entries[1]),
            compilation_options: options(),
            targets: &colors,
        }),
        multiview_mask: None,
        cache: None,
    })
}

fn overwrite_depth(format: TextureFormat) -> DepthStencilState {
    DepthStencilState {
        format,
        depth_write_enabled: Some(true),
        depth_compare: Some(CompareFunction::Always),
        stencil: StencilState::default(),
        bias: DepthBiasState::default(),
    }
}

pub(crate) fn pipeline_layout(
    device: &Device,
    groups: &[Option<&BindGroupLayout>],
) -> wgpu::PipelineLayout {
    let desc = PipelineLayoutDescriptor {
        label: Some("umbrage"),
        bind_group_layouts: groups,
        immediate_size: 0,
    };
    device.create_pipeline_layout(&desc)
}
