//! A renderer with shadows from a light set or from code written by hand. Everything else is the
//! same.

use crate::renderer::{self, Boxes, COLOR, DEPTH, Graphics, NORMAL, UNIFORMS, floats};
use anyhow::Result;
use umbrage::{
    glam::Affine3A,
    gpu::wgpu::{
        self, BindGroup, BindGroupLayout, BindingResource, CommandEncoder, RenderPipeline,
        TextureView, TextureViewDimension,
    },
};

/// The stage of a frame that uses the shadows.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum LookupStage {
    /// The pass that draws surfaces.
    Forward,
    /// The pass that shades from depth and normals.
    Deferred,
    /// Separate passes, one for each light, before the one that shades.
    Masks,
}

/// The shadows of the scene.
pub(crate) trait SceneShadows {
    /// Moves all casters.
    fn place(&mut self, placements: &[Affine3A]) -> Result<()>;

    /// Records the passes that draw the maps.
    fn encode(
        &mut self,
        graphics: &Graphics,
        boxes: &Boxes,
        encoder: &mut CommandEncoder,
    ) -> Result<()>;

    /// Returns the text that declares `shadow`, and a number that changes with it.
    fn wgsl(&self) -> (u64, &str);

    /// Returns the bind group of the text, group 1.
    fn group(&self) -> Result<(&BindGroup, &BindGroupLayout)>;

    /// Records the passes that draw masks, and returns them: a layer for each light.
    fn masks(
        &mut self,
        graphics: &Graphics,
        boxes: &Boxes,
        gbuffer: &SurfaceBuffer,
        encoder: &mut CommandEncoder,
    ) -> Result<TextureView>;
}

/// Depth and normals of the camera's visible surfaces.
pub(crate) struct SurfaceBuffer {
    pipeline: RenderPipeline,
    pub(crate) depth: TextureView,
    normal: TextureView,
    pub(crate) group: BindGroup,
    pub(crate) layout: BindGroupLayout,
}

impl SurfaceBuffer {
    fn new(graphics: &Graphics, boxes: &Boxes) -> Self {
        let size = boxes.scene.camera.size;
        let depth = graphics.target(size, DEPTH);
        let normal = graphics.target(size, NORMAL);
        let image = floats(TextureViewDimension::D2);
        let layout = graphics.layout(&[UNIFORMS, image, image]);
        let world_from_clip = boxes.scene.clip_from_world().inverse();
        let usage = wgpu::BufferUsages::UNIFORM;
        let camera = graphics.buffer(usage, bytemuck::bytes_of(&world_from_clip));
        let resources = [
            camera.as_entire_binding(),
            BindingResource::TextureView(&depth),
            BindingResource::TextureView(&normal),
        ];
        let group = graphics.group(&layout, &resources);
        let stored = include_str!("../add_shadows/gbuffer.wgsl");
        let text = format!("{}{stored}", boxes.scene.wgsl());
        let groups = [Some(&boxes.layout)];
        Self {
            pipeline: graphics.pipeline(text, "store", true, &groups, &[NORMAL]),
            depth,
            normal,
            group,
            layout,
        }
    }

    fn draw(&self, boxes: &Boxes, encoder: &mut CommandEncoder) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[renderer::color_attachment(&self.normal)],
            depth_stencil_attachment: renderer::depth_attachment(&self.depth),
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.set_pipeline(&self.pipeline);
        boxes.draw(&mut pass);
    }
}

/// The renderer.
pub(crate) struct TimedRenderer<S> {
    pub(crate) shadows: S,
    pub(crate) color: TextureView,
    stage: LookupStage,
    boxes: Boxes,
    gbuffer: SurfaceBuffer,
    /// The layout of `mask_group`.
    mask_layout: BindGroupLayout,
    /// The bind group, and the masks that it was built for.
    mask_group: Option<(TextureView, BindGroup)>,
    /// The pipeline, and the revision of the text of `shadow` that it was built for.
    pipeline: Option<(u64, RenderPipeline)>,
}

impl<S: SceneShadows> TimedRenderer<S> {
    pub(crate) fn new(graphics: &Graphics, boxes: Boxes, shadows: S, stage: LookupStage) -> Self {
        Self {
            shadows,
            color: graphics.target(boxes.scene.camera.size, COLOR),
            stage,
            gbuffer: SurfaceBuffer::new(graphics, &boxes),
            boxes,
            mask_layout: graphics.layout(&[floats(TextureViewDimension::D2Array)]),
            mask_group: None,
            pipeline: None,
        }
    }

    /// Moves all casters to their positions after some seconds, and draws a frame.
    pub(crate) fn frame(&mut self, graphics: &Graphics, seconds: f32) -> Result<()> {
        let placements = self.boxes.scene.placements(seconds);
        self.shadows.place(&placements)?;
        self.boxes.place(graphics, &placements);
        self.still_frame(graphics)
    }

    /// Draws a frame in which nothing moved.
    pub(crate) fn still_frame(&mut self, graphics: &Graphics) -> Result<()> {
        let mut encoder = graphics.encoder();
        self.shadows.encode(graphics, &self.boxes, &mut encoder)?;
        if self.stage != LookupStage::Forward {
            self.gbuffer.draw(&self.boxes, &mut encoder);
        }
        if self.stage == LookupStage::Masks {
            let masks = self
                .shadows
                .masks(graphics, &self.boxes, &self.gbuffer, &mut encoder)?;
            if self.mask_group.as_ref().is_none_or(|made| made.0 != masks) {
                let view = BindingResource::TextureView(&masks);
                let group = graphics.group(&self.mask_layout, &[view]);
                self.mask_group = Some((masks, group));
            }
        }
        self.shade(graphics, &mut encoder)?;
        graphics.queue.submit([encoder.finish()]);
        Ok(())
    }

    /// Records the pass that shades.
    fn shade(&mut self, graphics: &Graphics, encoder: &mut CommandEncoder) -> Result<()> {
        let ((revision, text), (group, layout)) = match &self.mask_group {
            Some((_, group)) => (
                (0, include_str!("by_masks.wgsl")),
                (group, &self.mask_layout),
            ),
            None => (self.shadows.wgsl(), self.shadows.group()?),
        };
        let is_forward = self.stage == LookupStage::Forward;
        if self.pipeline.as_ref().is_none_or(|made| made.0 != revision) {
            let scene = self.boxes.scene.wgsl();
            let shading = if is_forward {
                include_str!("../add_shadows/forward.wgsl")
            } else {
                concat!(
                    include_str!("receivers.wgsl"),
                    include_str!("deferred.wgsl")
                )
            };
            let text = format!("{text}{scene}{shading}");
            let mut groups = vec![Some(&self.boxes.layout), Some(layout)];
            if !is_forward {
                groups.push(Some(&self.gbuffer.layout));
            }
            let pipeline = graphics.pipeline(text, "shade", is_forward, &groups, &[COLOR]);
            self.pipeline = Some((revision, pipeline));
        }
        let depth = is_forward.then(|| renderer::depth_attachment(&self.gbuffer.depth));
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[renderer::color_attachment(&self.color)],
            depth_stencil_attachment: depth.flatten(),
            ..wgpu::RenderPassDescriptor::default()
        });
        if let Some((_, pipeline)) = &self.pipeline {
            pass.set_pipeline(pipeline);
        }
        pass.set_bind_group(1, group, &[]);
        if is_forward {
            self.boxes.draw(&mut pass);
        } else {
            pass.set_bind_group(0, &self.boxes.group, &[]);
            pass.set_bind_group(2, &self.gbuffer.group, &[]);
            pass.draw(0..3, 0..1);
        }
        Ok(())
    }
}
