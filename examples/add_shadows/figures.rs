//! A skinned figure and an alpha-tested one, drawn into the maps by the program's own shaders:
//! `cargo run --release --example figures [PRESET.toml]` writes `figures.png`. `docs/light_sets.md`
//! explains it.

use anyhow::Result;
use std::{collections::HashMap, sync::Arc};
use umbrage::{
    Aabb, ShadowTechnique,
    glam::{Mat4, Vec3},
    gpu::{
        CastTarget, CastTargetKey, OwnCasterId, SetFrame,
        wgpu::{self, BindGroup, BindGroupLayout, Buffer, RenderPass, RenderPipeline},
    },
    techniques::{MapFilter as _, Pcf, ShadowMap},
};
use umbrage_examples::{
    renderer::{self, BoxScene, Boxes, COLOR, DEPTH, Graphics},
    set::BoxShadows,
};

/// A corner: position, normal, texture coordinates, and the share of the second bone.
type Corner = [f32; 9];
/// The vertex buffer of figures.
const CORNERS: wgpu::VertexBufferLayout<'static> = wgpu::VertexBufferLayout {
    array_stride: size_of::<Corner>() as u64,
    step_mode: wgpu::VertexStepMode::Vertex,
    attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x2, 3 => Float32],
};
/// Index of the figure's bind group in casts and in shading.
const FIGURE_GROUP: u32 = 3;
/// Side of the cloth, texels.
const CLOTH: u32 = 64;

/// A figure with its own shaders.
struct Figure {
    corners: Vec<Corner>,
    buffer: Buffer,
    /// Placement of each bone.
    bones: Buffer,
    group: BindGroup,
}

impl Figure {
    fn new(
        graphics: &Graphics,
        layout: &BindGroupLayout,
        cloth: &wgpu::TextureView,
        corners: Vec<Corner>,
    ) -> Self {
        let usage = wgpu::BufferUsages::UNIFORM;
        let bones = graphics.buffer(usage, bytemuck::cast_slice(&[Mat4::IDENTITY; 2]));
        let sampler = graphics.device.create_sampler(&wgpu::SamplerDescriptor {
            mag_filter: wgpu::FilterMode::Linear,
            ..wgpu::SamplerDescriptor::default()
        });
        let resources = [
            bones.as_entire_binding(),
            wgpu::BindingResource::TextureView(cloth),
            wgpu::BindingResource::Sampler(&sampler),
        ];
        let group = graphics.group(layout, &resources);
        let usage = wgpu::BufferUsages::VERTEX;
        Self {
            buffer: graphics.buffer(usage, bytemuck::cast_slice(&corners)),
            corners,
            bones,
            group,
        }
    }

    /// Moves the bones, and returns the box around the figure (world space).
    fn pose(&self, graphics: &Graphics, bones: [Mat4; 2]) -> Aabb {
        let bytes = bytemuck::cast_slice(&bones);
        graphics.queue.write_buffer(&self.bones, 0, bytes);
        // A corner is between its places by either bone.
        let places = self.corners.iter().flat_map(|corner| {
            let position = Vec3::from_slice(corner);
            bones.map(|bone| bone.transform_point3(position))
        });
        Aabb::from_points(places)
    }

    fn draw(&self, pass: &mut RenderPass<'_>) {
        pass.set_bind_group(FIGURE_GROUP, &self.group, &[]);
        pass.set_vertex_buffer(0, self.buffer.slice(..));
        pass.draw(0..self.corners.len() as u32, 0..1);
    }
}

/// A renderer of boxes and figures with shadows.
struct Renderer {
    graphics: Graphics,
    boxes: Boxes,
    shadows: BoxShadows,
    figures: HashMap<OwnCasterId, Figure>,
    figure_layout: BindGroupLayout,
    /// Pipelines of casts.
    casts: HashMap<CastTargetKey, RenderPipeline>,
    /// Pipelines that shade boxes and figures, by the number of the set's text.
    shading: HashMap<u64, [RenderPipeline; 2]>,
}

impl Renderer {
    /// Moves the figures' bones.
    fn pose(&mut self, seconds: f32) -> Result<()> {
        let bones = [Mat4::IDENTITY, bend(seconds)];
        for (&id, figure) in &self.figures {
            let bounds = figure.pose(&self.graphics, bones);
            self.shadows.set.move_own_caster(id, bounds)?;
        }
        Ok(())
    }

    fn frame(&mut self, color: &wgpu::TextureView, depth: &wgpu::TextureView) -> Result<Vec<u8>> {
        let mut encoder = self.graphics.encoder();
        let frame = SetFrame {
            camera: &self.boxes.scene.camera,
            geometry: None,
        };
        let set = &mut self.shadows.set;
        set.prepare(&frame)?;
        if let Some((_, reason)) = set.unserved_lights().next() {
            anyhow::bail!("a light has no shadows: {reason}");
        }
        let mut peels = false;
        let layout = set.cast_layout().clone();
        set.encode_with(&mut encoder, |pass, target, ids| {
            // `midpoint` would need another shader.
            peels |= target.behind.is_some();
            // Targets with equal keys need equal pipelines.
            let pipeline = || cast_pipeline(&self.graphics, target, &layout, &self.figure_layout);
            pass.set_pipeline(self.casts.entry(target.key()).or_insert_with(pipeline));
            for id in ids {
                self.figures[id].draw(pass);
            }
        })?;

        anyhow::ensure!(!peels, "this example does not peel; use another technique");

        // Shade boxes and figures.
        let (shadows, layout) = set.bind_group()?;
        let pipelines = || {
            let scene = self.boxes.scene.wgsl();
            let text = format!("{}{scene}{}", set.wgsl(), include_str!("forward.wgsl"));
            let groups = [Some(&self.boxes.layout), Some(layout)];
            let graphics = &self.graphics;
            let of_boxes = graphics.pipeline(text.clone(), "shade", true, &groups, &[COLOR]);
            let of_figures = shade_pipeline(graphics, text, groups, &self.figure_layout);
            [of_boxes, of_figures]
        };
        let shading = self.shading.entry(set.wgsl_revision());
        let [of_boxes, of_figures] = shading.or_insert_with(pipelines);
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[renderer::color_attachment(color)],
            depth_stencil_attachment: renderer::depth_attachment(depth),
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.set_pipeline(of_boxes);
        pass.set_bind_group(1, shadows, &[]);
        self.boxes.draw(&mut pass);
        pass.set_pipeline(of_figures);
        for figure in self.figures.values() {
            figure.draw(&mut pass);
        }
        drop(pass);
        // Submits. The set's next `prepare` comes after that.
        self.graphics.read(encoder, color)
    }
}

/// Returns the pipeline that draws figures into a map.
fn cast_pipeline(
    graphics: &Graphics,
    target: &CastTarget,
    set: &BindGroupLayout,
    figure: &BindGroupLayout,
) -> RenderPipeline {
    let groups = [Some(set), None, None, Some(figure)];
    let text = [
        include_str!("figures.wgsl"),
        include_str!("figures_cast.wgsl"),
    ]
    .concat();
    pipeline(
        graphics,
        text,
        ["cast_figure", "discard_holes"],
        &groups,
        &[],
        |desc| {
            desc.primitive = target.primitive();
            desc.depth_stencil = Some(target.depth_stencil());
        },
    )
}

/// Returns the pipeline that shades figures.
fn shade_pipeline(
    graphics: &Graphics,
    text: String,
    scene_and_set: [Option<&BindGroupLayout>; 2],
    figure: &BindGroupLayout,
) -> RenderPipeline {
    let groups = [scene_and_set[0], scene_and_set[1], None, Some(figure)];
    let text = text + include_str!("figures.wgsl") + include_str!("figures_shade.wgsl");
    let entries = ["figure_surface", "shade_figure"];
    pipeline(
        graphics,
        text,
        entries,
        &groups,
        &[Some(COLOR.into())],
        |desc| {
            desc.depth_stencil = Some(renderer::depth_state());
        },
    )
}

fn pipeline(
    graphics: &Graphics,
    text: String,
    entries: [&str; 2],
    groups: &[Option<&BindGroupLayout>],
    targets: &[Option<wgpu::ColorTargetState>],
    complete: impl FnOnce(&mut wgpu::RenderPipelineDescriptor<'_>),
) -> RenderPipeline {
    let device = &graphics.device;
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(text.into()),
    });
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        bind_group_layouts: groups,
        ..wgpu::PipelineLayoutDescriptor::default()
    });
    let compilation_options = wgpu::PipelineCompilationOptions::default();
    let mut desc = wgpu::RenderPipelineDescriptor {
        label: None,
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some(entries[0]),
            compilation_options: compilation_options.clone(),
            buffers: &[Some(CORNERS)],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some(entries[1]),
            compilation_options,
            targets,
        }),
        multiview_mask: None,
        cache: None,
    };
    complete(&mut desc);
    device.create_render_pipeline(&desc)
}

/// Returns the placement of the column's upper half.
pub(crate) fn bend(seconds: f32) -> Mat4 {
    let joint = Mat4::from_translation(Vec3::new(1.5, 2.0, 6.0));
    joint * Mat4::from_rotation_z(-0.3 - 0.8 * seconds.sin()) * joint.inverse()
}

/// Returns a column around x = 1.5, z = 6, 4 m high, that bends at 2 m.
fn column() -> Vec<Corner> {
    const RINGS: u32 = 24;
    const SIDES: u32 = 16;
    let corner = |ring: u32, side: u32| -> Corner {
        let height = 4.0 * ring as f32 / RINGS as f32;
        let angle = std::f32::consts::TAU * (side % SIDES) as f32 / SIDES as f32;
        let (z, x) = angle.sin_cos();
        let weight = (height - 1.5).clamp(0.0, 1.0);
        // Its texture coordinates are those of an opaque texel.
        [
            1.5 + 0.4 * x,
            height,
            6.0 + 0.4 * z,
            x,
            0.0,
            z,
            0.0,
            0.0,
            weight,
        ]
    };
    let mut corners = Vec::new();
    for ring in 0..RINGS {
        for side in 0..SIDES {
            let [a, b] = [corner(ring, side), corner(ring, side + 1)];
            let [c, d] = [corner(ring + 1, side), corner(ring + 1, side + 1)];
            corners.extend([a, c, b, b, c, d]);
        }
    }
    corners
}

/// Returns an upright cloth, 3 m wide and 2.4 m high.
fn curtain() -> Vec<Corner> {
    let corner = |u: f32, v: f32| -> Corner {
        [3.0 + 3.0 * u, 0.2 + 2.4 * v, 4.5, 0.0, 0.0, 1.0, u, v, 0.0]
    };
    let [a, b, c, d] = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(|(u, v)| corner(u, v));
    vec![a, b, c, c, b, d]
}

/// Returns a cloth with round holes.
fn cloth(graphics: &Graphics) -> wgpu::TextureView {
    let texel = |i: u32| {
        let from_hole = |k: u32| (k % 16) as f32 - 7.5;
        let (x, y) = (from_hole(i % CLOTH), from_hole(i / CLOTH));
        let is_hole = x.hypot(y) < 5.0;
        if is_hole { 0_u8 } else { 255 }
    };
    let texels: Vec<u8> = (0..CLOTH * CLOTH).map(texel).collect();
    let size = wgpu::Extent3d {
        width: CLOTH,
        height: CLOTH,
        depth_or_array_layers: 1,
    };
    let texture = graphics.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::R8Unorm,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let rows = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(CLOTH),
        rows_per_image: None,
    };
    (graphics.queue).write_texture(texture.as_image_copy(), &texels, rows, size);
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// Draws two frames, the first and the one after some seconds, between which the column bends, and
/// returns the second one's pixels. All lights have the technique.
pub(crate) fn picture(technique: &Arc<dyn ShadowTechnique>, seconds: f32) -> Result<Vec<u8>> {
    let graphics = Graphics::open()?;
    let boxes = Boxes::new(&graphics, BoxScene::small()?);
    let mut shadows = BoxShadows::new(&graphics, &boxes)?;
    shadows.add_lights(&boxes.scene.lights, technique)?;
    let figure_layout = graphics.layout(&[
        renderer::UNIFORMS,
        wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: true },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        },
        wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
    ]);
    // Add the figures to the set.
    let cloth = cloth(&graphics);
    let mut figures = HashMap::new();
    for corners in [column(), curtain()] {
        let figure = Figure::new(&graphics, &figure_layout, &cloth, corners);
        let bounds = figure.pose(&graphics, [Mat4::IDENTITY; 2]);
        figures.insert(shadows.set.add_own_caster(bounds)?, figure);
    }
    let size = boxes.scene.camera.size;
    let color = graphics.target(size, COLOR);
    let depth = graphics.target(size, DEPTH);
    let mut renderer = Renderer {
        graphics,
        boxes,
        shadows,
        figures,
        figure_layout,
        casts: HashMap::new(),
        shading: HashMap::new(),
    };
    let mut pixels = Vec::new();
    for seconds in [0.0, seconds] {
        renderer.pose(seconds)?;
        pixels = renderer.frame(&color, &depth)?;
    }
    Ok(pixels)
}

fn main() -> Result<()> {
    let given = renderer::technique_by_argument()?;
    let technique = given.unwrap_or_else(|| Arc::new(Pcf::new(1).on(ShadowMap::default())));
    let pixels = picture(&technique, 1.0)?;
    renderer::save(
        "figures.png",
        &pixels,
        &BoxScene::small()?,
        technique.name(),
    )
}
