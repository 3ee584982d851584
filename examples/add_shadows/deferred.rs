//! Shadows in a deferred renderer: `cargo run --release --example deferred` writes `deferred.png`. `docs/add_shadows.md` explains it.

mod renderer;

use anyhow::Result;
use renderer::{Boxes, COLOR, DEPTH, Graphics, SCENE_WGSL, SIZE, VERTEX_BYTES};
use std::sync::Arc;
use umbrage::{
    Aabb, Camera,
    glam::{Affine3A, Vec3},
    techniques::{MapFilter as _, Pcf, ShadowMap},
    wgpu::{
        CasterId, CasterMesh, DepthBuffer, LightId, LightSet, LightSetOptions, MaskFormat,
        MaskInputs, NormalCoding, PositionFormat, SetFrame, SetLight, SetNormals, SetReceivers,
        VertexLayout,
        wgpu::{
            self, BindGroupLayout, BindingResource, CommandEncoder, RenderPipeline, TextureFormat,
            TextureSampleType, TextureView, TextureViewDimension,
        },
    },
};

/// Of the program's normals. Any float or normalised format will do.
const NORMAL: TextureFormat = TextureFormat::Rgba16Float;

/// A renderer with shadows.
struct Deferred {
    boxes: Boxes,
    set: LightSet,
    /// One for each box.
    casters: Vec<CasterId>,
    /// In the order of the scene's lights.
    lights: Vec<LightId>,
    gbuffer: RenderPipeline,
    lighting: RenderPipeline,
    /// Depth, normals and masks.
    lighting_layout: BindGroupLayout,
    depth: TextureView,
    normal: TextureView,
}

impl Deferred {
    fn new(graphics: &Graphics, boxes: Boxes) -> Result<Self> {
        // The set's WGSL stays in the set's own shaders.
        let mut set = LightSet::new(&graphics.device, LightSetOptions::default())?;
        let mesh = set.add_mesh(&CasterMesh {
            label: "box",
            vertices: &boxes.vertices,
            layout: VertexLayout {
                format: PositionFormat::Float32x3,
                stride: VERTEX_BYTES,
                position_offset: 0,
            },
            indices: None,
            range: 0..boxes.vertex_count,
            base_vertex: 0,
            bounds: Aabb {
                min: Vec3::NEG_ONE,
                max: Vec3::ONE,
            },
        })?;
        let mut casters = Vec::new();
        for world_from_local in renderer::placements(0.0) {
            casters.push(set.add_caster(mesh, world_from_local)?);
        }
        let mut lights = Vec::new();
        for light in renderer::lights() {
            lights.push(set.add_light(SetLight {
                light,
                technique: Arc::new(Pcf { radius: 1 }.on(ShadowMap::default())),
                priority: 1.0,
            })?);
        }

        let lighting_layout = lighting_layout(graphics);
        let stored = format!("{SCENE_WGSL}{}", include_str!("gbuffer.wgsl"));
        let lit = format!("{SCENE_WGSL}{}", include_str!("deferred.wgsl"));
        let groups = [Some(&boxes.layout), Some(&lighting_layout)];
        Ok(Self {
            gbuffer: graphics.pipeline(stored, "store", true, &groups[..1], &[NORMAL]),
            lighting: graphics.pipeline(lit, "shade", false, &groups, &[COLOR]),
            depth: graphics.target(DEPTH),
            normal: graphics.target(NORMAL),
            lighting_layout,
            boxes,
            set,
            casters,
            lights,
        })
    }

    fn frame(
        &mut self,
        graphics: &Graphics,
        encoder: &mut CommandEncoder,
        camera: &Camera,
        placements: &[Affine3A],
        color: &TextureView,
    ) -> Result<()> {
        for (&caster, &world_from_local) in self.casters.iter().zip(placements) {
            self.set.move_caster(caster, world_from_local)?;
        }
        self.boxes.place(graphics, placements);
        let frame = SetFrame {
            camera,
            geometry: None,
        };
        self.set
            .prepare(&graphics.device, &graphics.queue, &frame)?;
        self.set.encode(encoder)?;

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
            size: SIZE,
            receivers: SetReceivers::Depth {
                depth: DepthBuffer {
                    depth: &self.depth,
                    world_from_clip: renderer::clip_from_world(camera).inverse(),
                    // The depth where nothing was drawn: 1, or 0 with reversed z.
                    empty: 1.0,
                },
                normals: Some(SetNormals {
                    texture: &self.normal,
                    coding: NormalCoding::Components,
                }),
            },
            lights: &self.lights,
            format: MaskFormat::Unorm8,
        };
        self.set.prepare_masks(&graphics.queue, &inputs)?;
        // A texture with a layer for each light. It may be another one in the next frame.
        let masks = self.set.encode_masks(encoder)?;

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

/// The bind group of depth, normals and masks.
fn lighting_layout(graphics: &Graphics) -> BindGroupLayout {
    let image = |sample_type, view_dimension| wgpu::BindingType::Texture {
        sample_type,
        view_dimension,
        multisampled: false,
    };
    let floats = TextureSampleType::Float { filterable: false };
    graphics.layout(&[
        image(TextureSampleType::Depth, TextureViewDimension::D2),
        image(floats, TextureViewDimension::D2),
        image(floats, TextureViewDimension::D2Array),
    ])
}

/// Draws two frames, between which boxes turn, and returns the second one's pixels.
pub(crate) fn picture() -> Result<Vec<u8>> {
    let graphics = Graphics::open()?;
    let camera = renderer::camera()?;
    let boxes = Boxes::new(&graphics, &camera);
    let mut program = Deferred::new(&graphics, boxes)?;
    let color = graphics.target(COLOR);
    let mut pixels = Vec::new();
    for seconds in [0.0, 1.0] {
        let placements = renderer::placements(seconds);
        let mut encoder = graphics.encoder();
        program.frame(&graphics, &mut encoder, &camera, &placements, &color)?;
        pixels = graphics.read(encoder, &color)?;
    }
    Ok(pixels)
}

fn main() -> Result<()> {
    renderer::save("deferred.png", &picture()?)
}
