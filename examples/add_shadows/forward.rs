//! Shadows in a forward renderer: `cargo run --release --example forward [PRESET.toml]` writes
//! `forward.png`. `docs/add_shadows.md` explains it.

use anyhow::Result;
use std::sync::Arc;
use umbrage::{
    ShadowTechnique,
    wgpu::wgpu::{self, CommandEncoder, RenderPipeline, TextureView},
};
use umbrage_examples::{
    renderer::{self, BoxScene, Boxes, COLOR, DEPTH, Graphics},
    set::BoxShadows,
};

/// A renderer with shadows.
struct Forward {
    boxes: Boxes,
    shadows: BoxShadows,
    /// Made for this revision of the set's WGSL.
    pipeline: Option<(u64, RenderPipeline)>,
}

impl Forward {
    fn frame(
        &mut self,
        graphics: &Graphics,
        encoder: &mut CommandEncoder,
        seconds: f32,
        color: &TextureView,
        depth: &TextureView,
    ) -> Result<()> {
        let placements = self.boxes.scene.placements(seconds);
        self.boxes.place(graphics, &placements);
        self.shadows.place(&placements)?;
        // Record the shadows' passes into your encoder: none if nothing changed.
        self.shadows.prepare(graphics, &self.boxes)?;
        self.shadows.set.encode(encoder)?;

        // The set's text stands before the program's. It changes with the kinds of techniques and
        // the sizes of maps.
        let set = &self.shadows.set;
        let (shadows, layout) = set.bind_group()?;
        let revision = set.wgsl_revision();
        if self.pipeline.as_ref().is_none_or(|made| made.0 != revision) {
            let scene = self.boxes.scene.wgsl();
            let text = format!("{}{scene}{}", set.wgsl(), include_str!("forward.wgsl"));
            let groups = [Some(&self.boxes.layout), Some(layout)];
            let pipeline = graphics.pipeline(text, "shade", true, &groups, &[COLOR]);
            self.pipeline = Some((revision, pipeline));
        }

        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[renderer::color_attachment(color)],
            depth_stencil_attachment: renderer::depth_attachment(depth),
            ..wgpu::RenderPassDescriptor::default()
        });
        if let Some((_, pipeline)) = &self.pipeline {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(1, shadows, &[]);
            self.boxes.draw(&mut pass);
        }
        Ok(())
    }
}

/// Draws two frames, between which boxes turn, and returns the second one's pixels.
pub(crate) fn picture(technique: &Arc<dyn ShadowTechnique>) -> Result<Vec<u8>> {
    let graphics = Graphics::open()?;
    let boxes = Boxes::new(&graphics, BoxScene::small()?);
    let size = boxes.scene.camera.size;
    let mut program = Forward {
        shadows: BoxShadows::new(&graphics, &boxes, technique)?,
        boxes,
        pipeline: None,
    };
    let color = graphics.target(size, COLOR);
    let depth = graphics.target(size, DEPTH);
    let mut pixels = Vec::new();
    for seconds in [0.0, 1.0] {
        let mut encoder = graphics.encoder();
        program.frame(&graphics, &mut encoder, seconds, &color, &depth)?;
        // Submits. The set's next `prepare` comes after that.
        pixels = graphics.read(encoder, &color)?;
    }
    Ok(pixels)
}

fn main() -> Result<()> {
    let technique = renderer::technique_by_argument()?;
    let pixels = picture(&technique)?;
    renderer::save("forward.png", &pixels, &BoxScene::small()?, &*technique)
}
