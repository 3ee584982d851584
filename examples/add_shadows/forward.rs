//! Shadows in a forward renderer: `cargo run --release --example forward` writes `forward.png`. `docs/add_shadows.md` explains it.

mod renderer;

use anyhow::Result;
use renderer::{Boxes, COLOR, DEPTH, Graphics, SCENE_WGSL, VERTEX_BYTES};
use std::sync::Arc;
use umbrage::{
    Aabb, Camera,
    glam::{Affine3A, Vec3},
    techniques::{MapFilter as _, Pcf, ShadowMap},
    wgpu::{
        CasterId, CasterMesh, LightSet, LightSetOptions, PositionFormat, SetFrame, SetLight,
        VertexLayout,
        wgpu::{self, CommandEncoder, RenderPipeline, TextureView},
    },
};

/// A renderer with shadows.
struct Forward {
    boxes: Boxes,
    set: LightSet,
    /// One for each box.
    casters: Vec<CasterId>,
    /// Made for this revision of the set's WGSL.
    pipeline: Option<(u64, RenderPipeline)>,
}

impl Forward {
    fn new(graphics: &Graphics, boxes: Boxes) -> Result<Self> {
        // The bind group that the set's WGSL declares; the program has group 0.
        let options = LightSetOptions {
            group: 1,
            ..LightSetOptions::default()
        };
        let mut set = LightSet::new(&graphics.device, options)?;

        let mesh = set.add_mesh(&CasterMesh {
            // Names the mesh in errors.
            label: "box",
            // The buffer that the program draws from itself, usage VERTEX.
            vertices: &boxes.vertices,
            layout: VertexLayout {
                format: PositionFormat::Float32x3,
                stride: VERTEX_BYTES,
                position_offset: 0,
            },
            indices: None,
            range: 0..boxes.vertex_count,
            base_vertex: 0,
            // Around the mesh's positions, as they are in the buffer: casters outside a map are not drawn into it.
            bounds: Aabb {
                min: Vec3::NEG_ONE,
                max: Vec3::ONE,
            },
        })?;
        // Casters of one mesh become instances.
        let mut casters = Vec::new();
        for world_from_local in renderer::placements(0.0) {
            casters.push(set.add_caster(mesh, world_from_local)?);
        }

        for light in renderer::lights() {
            set.add_light(SetLight {
                light,
                technique: Arc::new(Pcf { radius: 1 }.on(ShadowMap::default())),
                priority: 1.0,
            })?;
        }
        Ok(Self {
            boxes,
            set,
            casters,
            pipeline: None,
        })
    }

    fn frame(
        &mut self,
        graphics: &Graphics,
        encoder: &mut CommandEncoder,
        camera: &Camera,
        placements: &[Affine3A],
        color: &TextureView,
        depth: &TextureView,
    ) -> Result<()> {
        // Say what moved. Nothing is drawn again for casters that stay.
        for (&caster, &world_from_local) in self.casters.iter().zip(placements) {
            self.set.move_caster(caster, world_from_local)?;
        }
        self.boxes.place(graphics, placements);

        // Record the shadows' passes into your encoder: none if nothing changed.
        let frame = SetFrame {
            camera,
            geometry: None,
        };
        self.set
            .prepare(&graphics.device, &graphics.queue, &frame)?;
        self.set.encode(encoder)?;

        // The set's text stands before the program's. It changes with the kinds of techniques and the sizes of maps.
        let (shadows, layout) = self.set.bind_group()?;
        let revision = self.set.wgsl_revision();
        if self.pipeline.as_ref().is_none_or(|made| made.0 != revision) {
            let text = format!(
                "{}{SCENE_WGSL}{}",
                self.set.wgsl(),
                include_str!("forward.wgsl")
            );
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
pub(crate) fn picture() -> Result<Vec<u8>> {
    let graphics = Graphics::open()?;
    let camera = renderer::camera()?;
    let boxes = Boxes::new(&graphics, &camera);
    let mut program = Forward::new(&graphics, boxes)?;
    let color = graphics.target(COLOR);
    let depth = graphics.target(DEPTH);
    let mut pixels = Vec::new();
    for seconds in [0.0, 1.0] {
        let placements = renderer::placements(seconds);
        let mut encoder = graphics.encoder();
        program.frame(
            &graphics,
            &mut encoder,
            &camera,
            &placements,
            &color,
            &depth,
        )?;
        // Submits. The set's next `prepare` comes after that.
        pixels = graphics.read(encoder, &color)?;
    }
    Ok(pixels)
}

fn main() -> Result<()> {
    renderer::save("forward.png", &picture()?)
}
