//! Shadows in a forward renderer: `cargo run --release --example forward [PRESET.toml]` writes
//! `forward.png`. `docs/add_shadows.md` explains it.

use anyhow::{Context as _, Result};
use std::sync::Arc;
use umbrage::{
    Cascades, Layout, Light, ShadowTechnique,
    gpu::{
        SetFrame, ShadowedLight,
        wgpu::{self, CommandEncoder, RenderPipeline, TextureView},
    },
    techniques::{MapFilter as _, Pcf, ShadowMap},
};
use umbrage_examples::{
    renderer::{self, BoxScene, Boxes, COLOR, DEPTH, Graphics},
    set::BoxShadows,
};

/// A renderer with shadows.
struct Forward {
    boxes: Boxes,
    shadows: BoxShadows,
    /// The pipeline, and the revision of the set's WGSL that it was built for.
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
        let frame = SetFrame {
            camera: &self.boxes.scene.camera,
            geometry: None,
        };
        // Record the shadow passes into your encoder. Only what changed is drawn again.
        let set = &mut self.shadows.set;
        set.prepare(&frame)?;
        set.encode(encoder)?;
        let (shadows, layout) = set.bind_group()?;

        // Put the set's WGSL before the program's. It changes with the kinds of techniques and the
        // number of map sizes.
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

/// Adds a sun with cascades, and a spot with one map.
fn add_lights(shadows: &mut BoxShadows, sun: Light, spot: Light) -> Result<()> {
    let set = &mut shadows.set;
    // A sun with four cascades of 1024 x 1024 texels and 3x3 comparisons. There is no bias to tune.
    let cascades = ShadowMap {
        layout: Layout::Cascades(Cascades::default()),
        ..ShadowMap::default()
    };
    let technique = Pcf::new(1).on(cascades);
    let sun = set.add_light(ShadowedLight::new(sun, technique))?;

    // A spot with one such map.
    let technique = Pcf::new(1).on(ShadowMap::default());
    let spot = set.add_light(ShadowedLight::new(spot, technique))?;
    shadows.lights = vec![sun, spot];
    Ok(())
}

/// Draws two frames, between which boxes turn, and returns the second one's pixels. All lights have
/// the technique, if there is one.
pub(crate) fn picture(technique: Option<&Arc<dyn ShadowTechnique>>) -> Result<Vec<u8>> {
    let graphics = Graphics::open()?;
    let boxes = Boxes::new(&graphics, BoxScene::small()?);
    let mut shadows = BoxShadows::new(&graphics, &boxes)?;
    match technique {
        Some(technique) => shadows.add_lights(&boxes.scene.lights, technique)?,
        None => {
            let lights = boxes.scene.lights[..].try_into();
            let [sun, spot]: [Light; 2] = lights.context("the scene has a sun and a spot")?;
            add_lights(&mut shadows, sun, spot)?;
        }
    }
    let size = boxes.scene.camera.size;
    let mut program = Forward {
        shadows,
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
    let pixels = picture(technique.as_ref())?;
    let label = match &technique {
        Some(technique) => technique.name(),
        None => "pcf: a sun with cascades, a spot with one map",
    };
    renderer::save("forward.png", &pixels, &BoxScene::small()?, label)
}
