//! Pipelines, bind groups and textures of the renderer.

use super::buffers::{AlphaTest, Looks};
use anyhow::Result;
use umbrage::glam::UVec2;

/// Format of the picture: colours are encoded as sRGB as they are written.
pub(crate) const COLOR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;
/// Format in which the same texels are read without decoding.
pub(crate) const COLOR_AS_READ: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
/// Format of the reversed depth: 1 at the near plane, 0 at infinity.
pub(crate) const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Bind groups of the forward shader.
pub(crate) const FRAME_GROUP: u32 = 0;
pub(crate) const MATERIAL_GROUP: u32 = 1;
pub(crate) const SET_GROUP: u32 = 2;
/// Inputs of the alpha test. Only used if the scene has alpha-tested triangles.
pub(crate) const HOLES_GROUP: u32 = 3;
/// Prefix of the names of the library's alpha test.
const HOLES_PREFIX: &str = "holes_";

pub(crate) const IMAGE: wgpu::BindingType = wgpu::BindingType::Texture {
    sample_type: wgpu::TextureSampleType::Float { filterable: true },
    view_dimension: wgpu::TextureViewDimension::D2,
    multisampled: false,
};
pub(crate) const SAMPLER: wgpu::BindingType =
    wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);

/// Layouts of the renderer's bind groups.
pub(crate) struct Layouts {
    pub frame: wgpu::BindGroupLayout,
    pub material: wgpu::BindGroupLayout,
    pub overlay: wgpu::BindGroupLayout,
}

impl Layouts {
    pub(crate) fn new(device: &wgpu::Device) -> Self {
        let uniforms = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        Self {
            frame: layout(device, &[uniforms]),
            material: layout(device, &[uniforms, IMAGE, SAMPLER]),
            overlay: layout(device, &[uniforms, IMAGE]),
        }
    }
}

/// The pipelines that draw lit surfaces with a set's shadows.
pub(crate) struct ForwardPipelines {
    /// Both sides of triangles.
    pub all: wgpu::RenderPipeline,
    /// Front faces only, for closed convex parts, whose back faces are hidden.
    pub fronts: wgpu::RenderPipeline,
    /// Alpha-tested triangles; `None` if the scene has none.
    pub alpha_tested: Option<wgpu::RenderPipeline>,
}

/// Returns the pipelines that draw lit surfaces with a set's shadows. The set's text precedes the
/// renderer's own.
///
/// # Errors
/// Returns an error if the library has no text for the alpha test.
pub(crate) fn forward(
    device: &wgpu::Device,
    layouts: &Layouts,
    set_text: &str,
    set_layout: &wgpu::BindGroupLayout,
    alpha_test: Option<&AlphaTest>,
) -> Result<ForwardPipelines> {
    let text = [set_text, include_str!("shaders/forward.wgsl")].concat();
    let groups = [
        Some(&layouts.frame),
        Some(&layouts.material),
        Some(set_layout),
        alpha_test.map(|test| &test.layout),
    ];
    // Describe the vertex buffers and the reversed depth.
    let buffers = [
        Some(wgpu::VertexBufferLayout {
            array_stride: 12,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &wgpu::vertex_attr_array![0 => Float32x3],
        }),
        Some(wgpu::VertexBufferLayout {
            array_stride: size_of::<Looks>() as u64,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &wgpu::vertex_attr_array![1 => Float32x3, 2 => Float32x2, 3 => Uint32],
        }),
    ];
    let depth = wgpu::DepthStencilState {
        format: DEPTH,
        depth_write_enabled: Some(true),
        depth_compare: Some(wgpu::CompareFunction::Greater),
        stencil: wgpu::StencilState::default(),
        bias: wgpu::DepthBiasState::default(),
    };
    let one = |text, entries, groups: &[_], cull_mode| {
        let primitive = wgpu::PrimitiveState {
            cull_mode,
            ..wgpu::PrimitiveState::default()
        };
        pipeline(
            device,
            text,
            entries,
            groups,
            &buffers,
            primitive,
            Some(depth.clone()),
            COLOR.into(),
        )
    };
    // Append the library's alpha test for alpha-tested triangles.
    let alpha_tested = match alpha_test {
        Some(test) => {
            let rule = test.buffers.wgsl(HOLES_GROUP, HOLES_PREFIX)?;
            let text = [text.as_str(), &rule, include_str!("shaders/leaves.wgsl")].concat();
            let entries = ["place_leaf", "shade_leaf"];
            Some(one(text, entries, &groups, None))
        }
        None => None,
    };
    let entries = ["place", "shade"];
    Ok(ForwardPipelines {
        all: one(text.clone(), entries, &groups[..3], None),
        fronts: one(text, entries, &groups[..3], Some(wgpu::Face::Back)),
        alpha_tested,
    })
}

/// Returns the pipeline that draws an overlay over the image.
pub(crate) fn overlay(device: &wgpu::Device, layouts: &Layouts) -> wgpu::RenderPipeline {
    let text = include_str!("shaders/overlay.wgsl").to_owned();
    let target = wgpu::ColorTargetState {
        format: COLOR,
        blend: Some(wgpu::BlendState::ALPHA_BLENDING),
        write_mask: wgpu::ColorWrites::ALL,
    };
    covering_pipeline(device, text, &layouts.overlay, target)
}

/// Returns the pipeline that draws an image into the window, whose colours have this format.
pub(crate) fn present(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    window: wgpu::TextureFormat,
) -> wgpu::RenderPipeline {
    let encodes = format!("const ENCODES = {};\n", window.is_srgb());
    let text = encodes + include_str!("shaders/present.wgsl");
    covering_pipeline(device, text, layout, window.into())
}

/// Returns a pipeline that covers a rectangle.
fn covering_pipeline(
    device: &wgpu::Device,
    text: String,
    layout: &wgpu::BindGroupLayout,
    target: wgpu::ColorTargetState,
) -> wgpu::RenderPipeline {
    let strip = wgpu::PrimitiveState {
        topology: wgpu::PrimitiveTopology::TriangleStrip,
        ..wgpu::PrimitiveState::default()
    };
    let entries = ["place", "shade"];
    pipeline(
        device,
        text,
        entries,
        &[Some(layout)],
        &[],
        strip,
        None,
        target,
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

/// Returns a texture without mipmaps.
pub(crate) fn texture(
    device: &wgpu::Device,
    size: UVec2,
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
    view_formats: &[wgpu::TextureFormat],
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: extent(size),
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats,
    })
}

/// Uploads an image, rows from the top.
pub(crate) fn upload(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    size: UVec2,
    format: wgpu::TextureFormat,
    bytes: &[u8],
) -> wgpu::TextureView {
    let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
    let texture = texture(device, size, format, usage, &[]);
    write(queue, &texture, 0, size, bytes);
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// Writes a mipmap level, which has this size.
pub(crate) fn write(
    queue: &wgpu::Queue,
    texture: &wgpu::Texture,
    mip_level: u32,
    size: UVec2,
    bytes: &[u8],
) {
    let destination = wgpu::TexelCopyTextureInfo {
        mip_level,
        ..texture.as_image_copy()
    };
    let layout = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some((bytes.len() / size.y as usize) as u32),
        rows_per_image: None,
    };
    queue.write_texture(destination, bytes, layout, extent(size));
}

pub(crate) fn extent(size: UVec2) -> wgpu::Extent3d {
    wgpu::Extent3d {
        width: size.x,
        height: size.y,
        depth_or_array_layers: 1,
    }
}
