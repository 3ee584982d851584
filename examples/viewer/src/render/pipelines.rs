//! The renderer's pipelines, bind groups and textures.

use super::{
    buffers::Looks,
    holes::{self, LeafVertex, Leaves},
};
use anyhow::Result;
use umbrage::{glam::UVec2, wgpu::CutOutBuffers};

/// What the picture is drawn into: colours are encoded as sRGB as they are written.
pub(crate) const COLOR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;
/// The same texels as the panel reads them: as they are.
pub(crate) const COLOR_AS_READ: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
/// Reversed: 1 at the near plane, 0 endlessly far.
pub(crate) const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Bind groups of the forward shader. The light set has one of its own.
pub(crate) const FRAME_GROUP: u32 = 0;
pub(crate) const MATERIAL_GROUP: u32 = 1;
pub(crate) const SET_GROUP: u32 = 2;
/// What tells holes; only where the scene has some.
pub(crate) const HOLES_GROUP: u32 = 3;

/// Layouts of the renderer's own bind groups.
pub(crate) struct Layouts {
    pub frame: wgpu::BindGroupLayout,
    pub material: wgpu::BindGroupLayout,
    pub overlay: wgpu::BindGroupLayout,
}

impl Layouts {
    pub(crate) fn new(device: &wgpu::Device) -> Self {
        let uniforms = |has_dynamic_offset| wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset,
            min_binding_size: None,
        };
        let image = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: true },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
        Self {
            frame: layout(device, &[uniforms(false)]),
            material: layout(device, &[uniforms(true), image, sampler]),
            overlay: layout(device, &[uniforms(false), image]),
        }
    }
}

/// The pipelines that draw lit surfaces with a set's shadows.
pub(crate) struct Forward {
    /// Both sides of triangles.
    pub all: wgpu::RenderPipeline,
    /// Their fronts alone: for closed convex parts, whose backs are hidden.
    pub fronts: wgpu::RenderPipeline,
    /// Triangles with holes; none if the scene has none.
    pub leaves: Option<wgpu::RenderPipeline>,
}

/// Returns the pipelines that draw lit surfaces with a set's shadows. The set's text stands before the renderer's own. `leaves` are
/// the scene's triangles with holes, if it has some.
///
/// # Errors
/// Errors if the library's text can't be had.
pub(crate) fn forward(
    device: &wgpu::Device,
    layouts: &Layouts,
    set_text: &str,
    set_layout: &wgpu::BindGroupLayout,
    leaves: Option<&Leaves>,
) -> Result<Forward> {
    let text = [set_text, include_str!("shaders/forward.wgsl")].concat();
    let groups = [
        Some(&layouts.frame),
        Some(&layouts.material),
        Some(set_layout),
        leaves.map(|leaves| &leaves.layout),
    ];
    let buffers = [
        Some(wgpu::VertexBufferLayout {
            array_stride: 12,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &wgpu::vertex_attr_array![0 => Float32x3],
        }),
        Some(wgpu::VertexBufferLayout {
            array_stride: size_of::<Looks>() as u64,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &wgpu::vertex_attr_array![1 => Float32x3, 2 => Float32x2],
        }),
    ];
    let depth = wgpu::DepthStencilState {
        format: DEPTH,
        depth_write_enabled: Some(true),
        depth_compare: Some(wgpu::CompareFunction::Greater),
        stencil: wgpu::StencilState::default(),
        bias: wgpu::DepthBiasState::default(),
    };
    let one = |cull_mode| {
        let primitive = wgpu::PrimitiveState {
            cull_mode,
            ..wgpu::PrimitiveState::default()
        };
        pipeline(
            device,
            text.clone(),
            ["place", "shade"],
            &groups[..3],
            &buffers,
            primitive,
            Some(depth.clone()),
            COLOR.into(),
        )
    };
    let leaves = match leaves {
        Some(leaves) => Some(pipeline(
            device,
            leaves_text(&text, &leaves.buffers)?,
            ["place_leaf", "shade_leaf"],
            &groups,
            &[Some(wgpu::VertexBufferLayout {
                array_stride: size_of::<LeafVertex>() as u64,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &LeafVertex::ATTRIBUTES,
            })],
            wgpu::PrimitiveState::default(),
            Some(depth.clone()),
            COLOR.into(),
        )),
        None => None,
    };
    Ok(Forward {
        all: one(None),
        fronts: one(Some(wgpu::Face::Back)),
        leaves,
    })
}

/// Returns the text that draws triangles with holes, given that of all others.
fn leaves_text(forward: &str, buffers: &CutOutBuffers) -> Result<String> {
    let rule = buffers.wgsl(HOLES_GROUP, holes::PREFIX)?;
    Ok([forward, &rule, include_str!("shaders/leaves.wgsl")].concat())
}

/// Returns the pipeline that lays a picture of figures over the image.
pub(crate) fn overlay(device: &wgpu::Device, layouts: &Layouts) -> wgpu::RenderPipeline {
    let text = include_str!("shaders/overlay.wgsl").to_owned();
    let target = wgpu::ColorTargetState {
        format: COLOR,
        blend: Some(wgpu::BlendState::ALPHA_BLENDING),
        write_mask: wgpu::ColorWrites::ALL,
    };
    let strip = wgpu::PrimitiveState {
        topology: wgpu::PrimitiveTopology::TriangleStrip,
        ..wgpu::PrimitiveState::default()
    };
    pipeline(
        device,
        text,
        ["place", "shade"],
        &[Some(&layouts.overlay)],
        &[],
        strip,
        None,
        target,
    )
}

/// Returns the pipeline that draws a picture into the window, whose colours have this format.
pub(crate) fn present(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    window: wgpu::TextureFormat,
) -> wgpu::RenderPipeline {
    let encodes = format!("const ENCODES = {};\n", window.is_srgb());
    let text = encodes + include_str!("shaders/present.wgsl");
    let strip = wgpu::PrimitiveState {
        topology: wgpu::PrimitiveTopology::TriangleStrip,
        ..wgpu::PrimitiveState::default()
    };
    pipeline(
        device,
        text,
        ["place", "shade"],
        &[Some(layout)],
        &[],
        strip,
        None,
        window.into(),
    )
}

#[expect(clippy::too_many_arguments, reason = "what the pipelines differ in")]
fn pipeline(
    device: &wgpu::Device,
    text: String,
    entries: [&str; 2],
    groups: &[Option<&wgpu::BindGroupLayout>],
    buffers: &[Option<wgpu::VertexBufferLayout<'_>>],
    primitive: wgpu::PrimitiveState,
    depth_stencil: Option<wgpu::DepthStencilState>,
    target: wgpu::ColorTargetState,
) -> wgpu::RenderPipeline {
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(text.into()),
    });
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        bind_group_layouts: groups,
        ..wgpu::PipelineLayoutDescriptor::default()
    });
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: None,
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some(entries[0]),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers,
        },
        primitive,
        depth_stencil,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some(entries[1]),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(target)],
        }),
        multiview_mask: None,
        cache: None,
    })
}

pub(crate) fn layout(device: &wgpu::Device, types: &[wgpu::BindingType]) -> wgpu::BindGroupLayout {
    let entries: Vec<_> = (0..)
        .zip(types)
        .map(|(binding, &ty)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
            ty,
            count: None,
        })
        .collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: None,
        entries: &entries,
    })
}

/// Returns a bind group with these resources at the bindings 0, 1, ..
pub(crate) fn group<const N: usize>(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    resources: [wgpu::BindingResource<'_>; N],
) -> wgpu::BindGroup {
    let entries: Vec<_> = (0..)
        .zip(resources)
        .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout,
        entries: &entries,
    })
}

/// Returns a texture without smaller copies.
pub(crate) fn texture(
    device: &wgpu::Device,
    size: UVec2,
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
    view_formats: &[wgpu::TextureFormat],
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d {
            width: size.x,
            height: size.y,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats,
    })
}
