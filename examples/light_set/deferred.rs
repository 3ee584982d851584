//! The same picture deferred: depth and normals first, then one pass that shades, with lookups in it or with masks made before.

use super::{
    by_hand::bind_group_layout,
    scene::{
        COLOR, DEPTH, Device, LIGHTS, SIZE, Shared, depth_attachment, layer_views, scene_pipeline,
        uniform_entry,
    },
};
use anyhow::Result;
use umbrage::{
    Camera,
    glam::Mat4,
    wgpu::{DepthBuffer, LightId, MaskFormat, MaskInputs, SetReceivers, wgpu},
};

const NORMAL: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
const MASK: wgpu::TextureFormat = wgpu::TextureFormat::R8Unorm;

/// How the picture is drawn.
#[derive(Clone, Copy)]
pub(crate) enum Picture<'a> {
    /// Lookups where surfaces are drawn.
    Forward,
    /// Lookups in the pass that shades from depth and normals.
    Deferred(&'a GBuffer),
    /// Lookups in passes of their own, one a light, before the one that shades.
    Masks(&'a GBuffer),
}

impl Picture<'_> {
    /// Returns the pipeline of the shader that has `lit`.
    pub(crate) fn pipeline(
        self,
        d: &Device,
        shared: &Shared,
        lit: &str,
        shadows: &wgpu::BindGroupLayout,
    ) -> wgpu::RenderPipeline {
        match self {
            Self::Forward => shared.pipeline(d, lit, shadows),
            Self::Deferred(gbuffer) | Self::Masks(gbuffer) => {
                gbuffer.shading(d, shared, lit, shadows)
            }
        }
    }

    /// Records the passes that draw the picture with such a pipeline.
    pub(crate) fn draw(
        self,
        encoder: &mut wgpu::CommandEncoder,
        shared: &Shared,
        pipeline: &wgpu::RenderPipeline,
        shadows: &wgpu::BindGroup,
    ) {
        match self {
            Self::Forward => shared.draw(encoder, pipeline, shadows),
            Self::Deferred(gbuffer) | Self::Masks(gbuffer) => {
                gbuffer.draw(encoder, shared);
                gbuffer.shade(encoder, shared, pipeline, shadows);
            }
        }
    }
}

/// Depth and normals of what the camera sees.
pub(crate) struct GBuffer {
    pipeline: wgpu::RenderPipeline,
    depth: wgpu::TextureView,
    normals: wgpu::TextureView,
    receivers: wgpu::BindGroup,
    receivers_layout: wgpu::BindGroupLayout,
}

impl GBuffer {
    pub(crate) fn new(d: &Device) -> Result<Self> {
        let shared = Shared::new(d)?;
        let pipeline = geometry_pipeline(d, &shared);
        let depth = picture(d, DEPTH, 1);
        let normals = picture(d, NORMAL, 1);
        let view =
            |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        let (depth, normals) = (view(&depth), view(&normals));
        let receivers_layout = bind_group_layout(
            d,
            &[
                uniform_entry(0, false),
                floats_entry(1, wgpu::TextureViewDimension::D2),
                floats_entry(2, wgpu::TextureViewDimension::D2),
            ],
        );
        let world_from_clip: Mat4 = shared.camera.space().clip_from_world().inverse();
        let camera = d.buffer(
            wgpu::BufferUsages::UNIFORM,
            bytemuck::bytes_of(&world_from_clip),
        );
        let entry = |binding, resource| wgpu::BindGroupEntry { binding, resource };
        let receivers = d.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &receivers_layout,
            entries: &[
                entry(0, camera.as_entire_binding()),
                entry(1, wgpu::BindingResource::TextureView(&depth)),
                entry(2, wgpu::BindingResource::TextureView(&normals)),
            ],
        });
        Ok(Self {
            pipeline,
            depth,
            normals,
            receivers,
            receivers_layout,
        })
    }

    /// Records the pass that draws depth and normals.
    pub(crate) fn draw(&self, encoder: &mut wgpu::CommandEncoder, shared: &Shared) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(cleared(&self.normals))],
            depth_stencil_attachment: Some(depth_attachment(&self.depth)),
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.set_pipeline(&self.pipeline);
        shared.draw_boxes(&mut pass);
    }

    /// Returns what the set makes masks of.
    pub(crate) fn mask_inputs<'a>(
        &'a self,
        camera: &Camera,
        lights: &'a [LightId],
    ) -> MaskInputs<'a> {
        MaskInputs {
            size: SIZE,
            receivers: SetReceivers::Depth {
                depth: DepthBuffer {
                    depth: &self.depth,
                    world_from_clip: camera.space().clip_from_world().inverse(),
                    empty: 1.0,
                },
                // A constant bias asks for no normals, and the program written by hand reads none for its masks.
                normals: None,
            },
            lights,
            format: MaskFormat::Unorm8,
        }
    }

    /// Returns the pipeline that shades the picture with a shader that has `lit`.
    fn shading(
        &self,
        d: &Device,
        shared: &Shared,
        lit: &str,
        shadows: &wgpu::BindGroupLayout,
    ) -> wgpu::RenderPipeline {
        let text = format!(
            "{lit}{}{}{}",
            include_str!("scene.wgsl"),
            include_str!("receivers.wgsl"),
            include_str!("deferred.wgsl")
        );
        let groups = [
            Some(&shared.scene_layout),
            Some(shadows),
            Some(&self.receivers_layout),
        ];
        fullscreen_pipeline(d, text, "shade_pixel", &groups, COLOR)
    }

    /// Records the pass that shades.
    fn shade(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        shared: &Shared,
        pipeline: &wgpu::RenderPipeline,
        shadows: &wgpu::BindGroup,
    ) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(cleared(&shared.color_view))],
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &shared.scene_group, &[]);
        pass.set_bind_group(1, shadows, &[]);
        pass.set_bind_group(2, &self.receivers, &[]);
        pass.draw(0..3, 0..1);
    }
}

/// Shades the picture from masks, whoever made them.
#[derive(Default)]
pub(crate) struct MaskShading {
    made_for: Option<wgpu::TextureView>,
    pipeline: Option<(wgpu::RenderPipeline, wgpu::BindGroup)>,
}

impl MaskShading {
    /// Records the pass that shades.
    pub(crate) fn shade(
        &mut self,
        d: &Device,
        encoder: &mut wgpu::CommandEncoder,
        gbuffer: &GBuffer,
        shared: &Shared,
        masks: &wgpu::TextureView,
    ) {
        let made = match self.pipeline.take() {
            Some(made) if self.made_for.as_ref() == Some(masks) => made,
            _ => {
                let entry = floats_entry(0, wgpu::TextureViewDimension::D2Array);
                let layout = bind_group_layout(d, &[entry]);
                let group = d.device.create_bind_group(&wgpu::BindGroupDescriptor {
                    label: None,
                    layout: &layout,
                    entries: &[wgpu::BindGroupEntry {
                        binding: 0,
                        resource: wgpu::BindingResource::TextureView(masks),
                    }],
                });
                let lit = include_str!("by_masks.wgsl");
                (gbuffer.shading(d, shared, lit, &layout), group)
            }
        };
        gbuffer.shade(encoder, shared, &made.0, &made.1);
        self.made_for = Some(masks.clone());
        self.pipeline = Some(made);
    }
}

/// Masks by a shader that was written for this picture alone.
pub(crate) struct HandMasks {
    pipeline: wgpu::RenderPipeline,
    layers: Vec<wgpu::TextureView>,
    pub(crate) whole: wgpu::TextureView,
}

impl HandMasks {
    /// `lit` is the text of the lookup, which reads these bindings.
    pub(crate) fn new(
        d: &Device,
        gbuffer: &GBuffer,
        lit: &str,
        shadows: &wgpu::BindGroupLayout,
    ) -> Self {
        let text = format!(
            "{lit}{}{}",
            include_str!("receivers.wgsl"),
            include_str!("hand_masks.wgsl")
        );
        let groups = [None, Some(shadows), Some(&gbuffer.receivers_layout)];
        let texture = picture(d, MASK, LIGHTS as u32);
        Self {
            pipeline: fullscreen_pipeline(d, text, "store_mask", &groups, MASK),
            layers: layer_views(&texture),
            whole: texture.create_view(&wgpu::TextureViewDescriptor::default()),
        }
    }

    /// Records a pass a light.
    pub(crate) fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        gbuffer: &GBuffer,
        shadows: &wgpu::BindGroup,
    ) {
        for (light, layer) in (0..).zip(&self.layers) {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                color_attachments: &[Some(cleared(layer))],
                ..wgpu::RenderPassDescriptor::default()
            });
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(1, shadows, &[]);
            pass.set_bind_group(2, &gbuffer.receivers, &[]);
            pass.draw(0..3, light..light + 1);
        }
    }
}

fn geometry_pipeline(d: &Device, shared: &Shared) -> wgpu::RenderPipeline {
    // The scene's text shades, too, and that asks for the light.
    let lit =
        "fn lit(light: u32, position: vec3f, normal: vec3f, pixel: vec2u) -> f32 { return 1.0; }\n";
    let text = format!(
        "{lit}{}{}",
        include_str!("scene.wgsl"),
        include_str!("gbuffer.wgsl")
    );
    scene_pipeline(
        d,
        text,
        &[Some(&shared.scene_layout)],
        "store_normal",
        NORMAL,
    )
}

/// Returns the pipeline that runs a fragment shader at every pixel.
fn fullscreen_pipeline(
    d: &Device,
    text: String,
    fragment: &str,
    groups: &[Option<&wgpu::BindGroupLayout>],
    format: wgpu::TextureFormat,
) -> wgpu::RenderPipeline {
    let module = d.shader(text);
    let layout = d
        .device
        .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            bind_group_layouts: groups,
            ..wgpu::PipelineLayoutDescriptor::default()
        });
    d.device
        .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: None,
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("whole_picture"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some(fragment),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(format.into())],
            }),
            multiview_mask: None,
            cache: None,
        })
}

/// Returns a texture of the picture's size.
fn picture(d: &Device, format: wgpu::TextureFormat, layers: u32) -> wgpu::Texture {
    d.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d {
            width: SIZE.x,
            height: SIZE.y,
            depth_or_array_layers: layers,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    })
}

fn floats_entry(
    binding: u32,
    view_dimension: wgpu::TextureViewDimension,
) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty: wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: false },
            view_dimension,
            multisampled: false,
        },
        count: None,
    }
}

fn cleared(view: &wgpu::TextureView) -> wgpu::RenderPassColorAttachment<'_> {
    wgpu::RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations {
            load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
            store: wgpu::StoreOp::Store,
        },
    }
}
