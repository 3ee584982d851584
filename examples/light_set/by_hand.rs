//! Shadows written by hand for this image alone. The program keeps nothing from frame to
//! frame: it redraws all maps.

use super::program::{SceneShadows, SurfaceBuffer};
use crate::renderer::{self, BOX_BUFFERS, Boxes, DEPTH, Graphics, UNIFORMS, floats};
use anyhow::Result;
use std::sync::Arc;
use umbrage::{
    Light, ShadowTechnique,
    glam::{Affine3A, Mat4, UVec2},
    gpu::{
        LightSet, SetFrame,
        wgpu::{
            self, BindGroup, BindGroupLayout, BindingResource, CommandEncoder, RenderPipeline,
            Texture, TextureFormat, TextureView, TextureViewDescriptor, TextureViewDimension,
        },
    },
};

const MASK: TextureFormat = TextureFormat::R8Unorm;

/// Bias and radius of the lookup.
#[derive(Clone, Copy)]
pub(crate) struct HandLookup {
    /// Bias in clip depth.
    pub(crate) bias: f32,
    /// Radius in texels.
    pub(crate) radius: i32,
    /// Side of the maps, texels.
    pub(crate) map_size: u32,
}

/// State that is kept from frame to frame.
pub(crate) struct ByHand {
    cast: RenderPipeline,
    /// Bind group of a light's matrix, and the light's layer.
    maps: Vec<(BindGroup, TextureView)>,
    text: String,
    group: BindGroup,
    layout: BindGroupLayout,
    masks: Texture,
    mask_pipeline: Option<RenderPipeline>,
}

impl ByHand {
    /// Places maps like the set does with the technique of each light, so that only the work is
    /// compared. The lookup is for lights with one map.
    pub(crate) fn new(
        graphics: &Graphics,
        boxes: &Boxes,
        technique: impl Fn(&Light) -> Arc<dyn ShadowTechnique>,
        set: &LightSet,
        lookup: HandLookup,
    ) -> Result<Self> {
        // Fit the light spaces.
        let mut spaces: Vec<Mat4> = Vec::new();
        for light in &boxes.scene.lights {
            let frame = SetFrame {
                camera: &boxes.scene.camera,
                geometry: None,
            };
            let recipe = technique(light).recipe(&set.view(&frame, light))?;
            spaces.extend(recipe.casts.iter().map(|cast| cast.space.clip_from_world()));
        }
        // Create the maps, and a matrix for each.
        let layers = spaces.len() as u32;
        let map_array = graphics.target_array(UVec2::splat(lookup.map_size), layers, DEPTH);
        let uniforms = wgpu::BufferUsages::UNIFORM;
        let matrix_layout = graphics.layout(&[UNIFORMS]);
        let mut maps = Vec::new();
        for (space, layer) in spaces.iter().zip(layer_views(&map_array)) {
            let matrix = graphics.buffer(uniforms, bytemuck::bytes_of(space));
            let group = graphics.group(&matrix_layout, &[matrix.as_entire_binding()]);
            maps.push((group, layer));
        }
        // Create the uniforms of the lookup.
        let mut words: Vec<f32> = spaces.iter().flat_map(Mat4::to_cols_array).collect();
        words.extend([lookup.map_size as f32, lookup.bias, 0.0, 0.0]);
        let words = graphics.buffer(uniforms, bytemuck::cast_slice(&words));
        let layout = graphics.layout(&[UNIFORMS, floats(TextureViewDimension::D2Array)]);
        let whole = map_array.create_view(&TextureViewDescriptor::default());
        let resources = [
            words.as_entire_binding(),
            BindingResource::TextureView(&whole),
        ];
        let radius = lookup.radius;
        Ok(Self {
            cast: cast_pipeline(graphics, &matrix_layout),
            maps,
            text: format!("const RADIUS = {radius};\n{}", include_str!("by_hand.wgsl")),
            group: graphics.group(&layout, &resources),
            layout,
            masks: graphics.target_array(boxes.scene.camera.size, layers, MASK),
            mask_pipeline: None,
        })
    }

    /// Returns the number of layers of all maps.
    pub(crate) fn layers(&self) -> usize {
        self.maps.len()
    }
}

impl SceneShadows for ByHand {
    fn place(&mut self, _: &[Affine3A]) -> Result<()> {
        Ok(())
    }

    fn encode(&mut self, _: &Graphics, boxes: &Boxes, encoder: &mut CommandEncoder) -> Result<()> {
        for (matrix, layer) in &self.maps {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                depth_stencil_attachment: renderer::depth_attachment(layer),
                ..wgpu::RenderPassDescriptor::default()
            });
            pass.set_pipeline(&self.cast);
            boxes.draw_with(&mut pass, matrix);
        }
        Ok(())
    }

    fn wgsl(&self) -> (u64, &str) {
        (0, &self.text)
    }

    fn group(&self) -> Result<(&BindGroup, &BindGroupLayout)> {
        Ok((&self.group, &self.layout))
    }

    fn masks(
        &mut self,
        graphics: &Graphics,
        _: &Boxes,
        gbuffer: &SurfaceBuffer,
        encoder: &mut CommandEncoder,
    ) -> Result<TextureView> {
        let pipeline = self.mask_pipeline.get_or_insert_with(|| {
            let own = concat!(
                include_str!("receivers.wgsl"),
                include_str!("hand_masks.wgsl")
            );
            let text = format!("{}{own}", self.text);
            let groups = [None, Some(&self.layout), Some(&gbuffer.layout)];
            graphics.pipeline(text, "store_mask", false, &groups, &[MASK])
        });
        for (light, layer) in (0..).zip(layer_views(&self.masks)) {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                color_attachments: &[renderer::color_attachment(&layer)],
                ..wgpu::RenderPassDescriptor::default()
            });
            pass.set_pipeline(pipeline);
            pass.set_bind_group(1, &self.group, &[]);
            pass.set_bind_group(2, &gbuffer.group, &[]);
            pass.draw(0..3, light..light + 1);
        }
        Ok(self.masks.create_view(&TextureViewDescriptor::default()))
    }
}

fn cast_pipeline(graphics: &Graphics, layout: &BindGroupLayout) -> RenderPipeline {
    let device = &graphics.device;
    let module = device.create_shader_module(wgpu::include_wgsl!("by_hand_cast.wgsl"));
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        bind_group_layouts: &[Some(layout)],
        ..wgpu::PipelineLayoutDescriptor::default()
    });
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: None,
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("cast_box"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &BOX_BUFFERS,
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(renderer::depth_state()),
        multisample: wgpu::MultisampleState::default(),
        fragment: None,
        multiview_mask: None,
        cache: None,
    })
}

/// Returns a view of each layer of an array.
fn layer_views(array: &Texture) -> Vec<TextureView> {
    let view = |layer| {
        array.create_view(&TextureViewDescriptor {
            dimension: Some(TextureViewDimension::D2),
            base_array_layer: layer,
            array_layer_count: Some(1),
            ..TextureViewDescriptor::default()
        })
    };
    (0..array.depth_or_array_layers()).map(view).collect()
}
