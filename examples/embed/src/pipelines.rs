//! The program's pipelines, bind groups and textures: what any wgpu program has.

use crate::meshes::Vertex;
use umbrage::glam::UVec2;

/// What the camera sees, whichever way it is lit.
pub const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

const SCENE: &str = include_str!("shaders/scene.wgsl");
const LIGHTING: &str = include_str!("shaders/lighting.wgsl");
const SURFACE: &str = include_str!("shaders/surface.wgsl");

/// Where an object is (three columns and a translation) and its colour.
pub type Placed = [f32; 16];

const VERTEX_BUFFERS: [Option<wgpu::VertexBufferLayout<'static>>; 2] = [
    Some(wgpu::VertexBufferLayout {
        array_stride: size_of::<Vertex>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3],
    }),
    Some(wgpu::VertexBufferLayout {
        array_stride: size_of::<Placed>() as u64,
        step_mode: wgpu::VertexStepMode::Instance,
        attributes: &wgpu::vertex_attr_array![
            2 => Float32x4, 3 => Float32x4, 4 => Float32x4, 5 => Float32x4
        ],
    }),
];

/// A pipeline of the program's.
struct Pass<'a> {
    text: String,
    entries: [&'a str; 2],
    groups: &'a [Option<&'a wgpu::BindGroupLayout>],
    /// Whether it draws the scene's objects, or else one triangle around the screen.
    draws_objects: bool,
    /// None without a depth buffer.
    depth_compare: Option<wgpu::CompareFunction>,
    targets: &'a [wgpu::TextureFormat],
}

/// Draws the sky where nothing else was drawn.
pub fn sky(
    device: &wgpu::Device,
    scene: &wgpu::BindGroupLayout,
    color: wgpu::TextureFormat,
) -> wgpu::RenderPipeline {
    Pass {
        text: [SCENE, include_str!("shaders/sky.wgsl")].concat(),
        entries: ["screen", "shade"],
        groups: &[Some(scene)],
        draws_objects: false,
        depth_compare: Some(wgpu::CompareFunction::Equal),
        targets: &[color],
    }
    .pipeline(device)
}

/// Draws lit objects. The set's text stands before the program's own, and its bind group beside the program's.
pub fn forward(
    device: &wgpu::Device,
    scene: &wgpu::BindGroupLayout,
    set_text: &str,
    set_layout: &wgpu::BindGroupLayout,
    color: wgpu::TextureFormat,
) -> wgpu::RenderPipeline {
    let own = include_str!("shaders/forward.wgsl");
    Pass {
        text: [set_text, SCENE, LIGHTING, SURFACE, own].concat(),
        entries: ["surface", "shade"],
        groups: &[Some(scene), Some(set_layout)],
        draws_objects: true,
        depth_compare: Some(wgpu::CompareFunction::Greater),
        targets: &[color],
    }
    .pipeline(device)
}

/// Draws objects into the G-buffer.
pub fn gbuffer(
    device: &wgpu::Device,
    scene: &wgpu::BindGroupLayout,
    targets: &[wgpu::TextureFormat],
) -> wgpu::RenderPipeline {
    Pass {
        text: [SCENE, SURFACE, include_str!("shaders/gbuffer.wgsl")].concat(),
        entries: ["surface", "store"],
        groups: &[Some(scene)],
        draws_objects: true,
        depth_compare: Some(wgpu::CompareFunction::Greater),
        targets,
    }
    .pipeline(device)
}

/// Lights the screen from the G-buffer and masks.
pub fn lighting(
    device: &wgpu::Device,
    scene: &wgpu::BindGroupLayout,
    gbuffer: &wgpu::BindGroupLayout,
    color: wgpu::TextureFormat,
) -> wgpu::RenderPipeline {
    Pass {
        text: [SCENE, LIGHTING, include_str!("shaders/deferred.wgsl")].concat(),
        entries: ["screen", "shade"],
        groups: &[Some(scene), Some(gbuffer)],
        draws_objects: false,
        depth_compare: None,
        targets: &[color],
    }
    .pipeline(device)
}

impl Pass<'_> {
    fn pipeline(self, device: &wgpu::Device) -> wgpu::RenderPipeline {
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(self.text.into()),
        });
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            bind_group_layouts: self.groups,
            ..wgpu::PipelineLayoutDescriptor::default()
        });
        let targets: Vec<_> = self
            .targets
            .iter()
            .map(|&format| Some(format.into()))
            .collect();
        // Targets that don't encode sRGB get colours that are encoded.
        let encodes = self.targets.iter().all(|format| !format.is_srgb());
        let constants = [("encodes", f64::from(u8::from(encodes)))];
        let compilation_options = wgpu::PipelineCompilationOptions {
            constants: &constants,
            ..wgpu::PipelineCompilationOptions::default()
        };
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(self.entries[1]),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some(self.entries[0]),
                compilation_options: compilation_options.clone(),
                buffers: if self.draws_objects {
                    &VERTEX_BUFFERS
                } else {
                    &[]
                },
            },
            primitive: wgpu::PrimitiveState {
                cull_mode: self.draws_objects.then_some(wgpu::Face::Back),
                ..wgpu::PrimitiveState::default()
            },
            depth_stencil: self.depth_compare.map(|compare| wgpu::DepthStencilState {
                format: DEPTH,
                depth_write_enabled: Some(self.draws_objects),
                depth_compare: Some(compare),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some(self.entries[1]),
                compilation_options,
                targets: &targets,
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

/// The layout of the bind group with the scene's uniforms.
pub fn scene_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let uniforms = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Uniform,
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    layout(device, &[uniforms])
}

/// The layout of the bind group with depth, albedo, normals and masks.
pub fn gbuffer_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let image = |sample_type, view_dimension| wgpu::BindingType::Texture {
        sample_type,
        view_dimension,
        multisampled: false,
    };
    let floats = wgpu::TextureSampleType::Float { filterable: false };
    let flat = wgpu::TextureViewDimension::D2;
    let entries = [
        image(wgpu::TextureSampleType::Depth, flat),
        image(floats, flat),
        image(floats, flat),
        image(floats, wgpu::TextureViewDimension::D2Array),
    ];
    layout(device, &entries)
}

fn layout(device: &wgpu::Device, types: &[wgpu::BindingType]) -> wgpu::BindGroupLayout {
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
pub fn group<const N: usize>(
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

/// Returns a texture without mip levels.
pub fn texture(
    device: &wgpu::Device,
    size: UVec2,
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
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
        view_formats: &[],
    })
}

pub fn color_attachment(view: &wgpu::TextureView) -> Option<wgpu::RenderPassColorAttachment<'_>> {
    Some(wgpu::RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations {
            load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
            store: wgpu::StoreOp::Store,
        },
    })
}

/// Depth is reversed: 0 is endlessly far.
pub fn depth_attachment(
    view: &wgpu::TextureView,
) -> Option<wgpu::RenderPassDepthStencilAttachment<'_>> {
    Some(wgpu::RenderPassDepthStencilAttachment {
        view,
        depth_ops: Some(wgpu::Operations {
            load: wgpu::LoadOp::Clear(0.0),
            store: wgpu::StoreOp::Store,
        }),
        stencil_ops: None,
    })
}
