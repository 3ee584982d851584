//! Shadows in a deferred renderer: `cargo run --release --example deferred [PRESET.toml]` writes
//! `deferred.png`. `docs/add_shadows.md` explains it.

use anyhow::Result;
use std::sync::Arc;
use umbrage::{
    ShadowTechnique,
    gpu::{
        DepthBuffer, MaskFormat, MaskInputs, MaskReceivers, NormalCoding, SetNormals,
        wgpu::{
            self, BindGroupLayout, BindingResource, CommandEncoder, RenderPipeline, TextureView,
            TextureViewDimension,
        },
    },
    techniques::{MapTechnique, Pcf},
};
use umbrage_examples::{
    renderer::{self, BoxScene, Boxes, COLOR, DEPTH, Graphics, NORMAL},
    set::BoxShadows,
};

/// A renderer with shadows.
struct Deferred {
    boxes: Boxes,
    shadows: BoxShadows,
    gbuffer: RenderPipeline,
    lighting: RenderPipeline,
    /// Depth, normals and masks.
    lighting_layout: BindGroupLayout,
    depth: TextureView,
    normal: TextureView,
}

impl Deferred {
    fn new(graphics: &Graphics, boxes: Boxes, shadows: BoxShadows) -> Self {
        let lighting_layout = graphics.layout(&[
            renderer::floats(TextureViewDimension::D2),
            renderer::floats(TextureViewDimension::D2),
            renderer::floats(TextureViewDimension::D2Array),
        ]);
        // The set's WGSL stays in the set's own shaders.
        let scene = boxes.scene.wgsl();
        let stored = format!("{scene}{}", include_str!("gbuffer.wgsl"));
        let lit = format!("{scene}{}", include_str!("deferred.wgsl"));
        let groups = [Some(&boxes.layout), Some(&lighting_layout)];
        let size = boxes.scene.camera.size;
        Self {
            gbuffer: graphics.pipeline(stored, "store", true, &groups[..1], &[NORMAL]),
            lighting: graphics.pipeline(lit, "shade", false, &groups, &[COLOR]),
            depth: graphics.target(size, DEPTH),
            normal: graphics.target(size, NORMAL),
            lighting_layout,
            boxes,
            shadows,
        }
    }

    fn frame(
        &mut self,
        graphics: &Graphics,
        encoder: &mut CommandEncoder,
        seconds: f32,
        color: &TextureView,
    ) -> Result<()> {
        let placements = self.boxes.scene.placements(seconds);
        self.boxes.place(graphics, &placements);
        self.shadows.place(&placements)?;
        // Record the shadow passes into your encoder. Only what changed is drawn again.
        self.shadows.prepare(&self.boxes)?;
        self.shadows.set.encode(encoder)?;

        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[renderer::color_attachment(&self.normal)],
            depth_stencil_attachment: renderer::depth_attachment(&self.depth),
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.set_pipeline(&self.gbuffer);
        self.boxes.draw(&mut pass);
        drop(pass);

        // Masks: positions come from the depth buffer, in the lookup itself.
        let inputs = MaskInputs {
            size: self.boxes.scene.camera.size,
            receivers: MaskReceivers::Depth {
                depth: DepthBuffer {
                    depth: &self.depth,
                    world_from_clip: self.boxes.scene.clip_from_world().inverse(),
                    // The depth where nothing was drawn: 1, or 0 with reversed z.
                    empty: 1.0,
                },
                normals: Some(SetNormals {
                    texture: &self.normal,
                    coding: NormalCoding::Components,
                }),
            },
            lights: &self.shadows.lights,
            format: MaskFormat::Unorm8,
        };
        let set = &mut self.shadows.set;
        set.prepare_masks(&inputs)?;
        // A texture with a layer for each light. It may be another one in the next frame.
        let masks = set.encode_masks(encoder)?;

        let seen = [&self.depth, &self.normal, masks].map(BindingResource::TextureView);
        let seen = graphics.group(&self.lighting_layout, &seen);
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[renderer::color_attachment(color)],
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.set_pipeline(&self.lighting);
        pass.set_bind_group(0, &self.boxes.group, &[]);
        pass.set_bind_group(1, &seen, &[]);
        pass.draw(0..3, 0..1);
        Ok(())
    }
}

/// Draws two frames, between which boxes turn, and returns the second one's pixels.
pub(crate) fn picture(technique: &Arc<dyn ShadowTechnique>) -> Result<Vec<u8>> {
    let graphics = Graphics::open()?;
    let boxes = Boxes::new(&graphics, BoxScene::small()?);
    let color = graphics.target(boxes.scene.camera.size, COLOR);
    let mut shadows = BoxShadows::new(&graphics, &boxes)?;
    shadows.add_lights(&boxes.scene.lights, technique)?;
    let mut program = Deferred::new(&graphics, boxes, shadows);
    let mut pixels = Vec::new();
    for seconds in [0.0, 1.0] {
        let mut encoder = graphics.encoder();
        program.frame(&graphics, &mut encoder, seconds, &color)?;
        pixels = graphics.read(encoder, &color)?;
    }
    Ok(pixels)
}

fn main() -> Result<()> {
    let technique = renderer::technique_by_argument()?;
    let technique = technique.unwrap_or_else(|| Arc::new(MapTechnique::<Pcf>::default()));
    let pixels = picture(&technique)?;
    renderer::save(
        "deferred.png",
        &pixels,
        &BoxScene::small()?,
        technique.name(),
    )
}
