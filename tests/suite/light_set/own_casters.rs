//! Tests of casters that the program draws into the set's layers with its own shaders.

use super::floor::{Block, SIZE, add_block, box_corners, camera, expected, wrong_points};
use bytemuck::cast_slice;
use glam::{Vec3, Vec4};
use std::{collections::HashMap, sync::Arc};
use umbrage_core::{Aabb, Cascades, Geometry, Layout, Light, ShadowTechnique};
use umbrage_techniques::{Exact, Hard, MapFilter as _, Midpoint, Pcf, SecondDepth, ShadowMap};
use umbrage_tests::{
    adapter::device,
    foreign,
    light_program::{Forward, ForwardProgram},
};
use umbrage_wgpu::{
    CastTarget, CastTargetKey, FrameGeometry, LightId, LightSet, OwnCasterId, SetBudget, SetFrame,
    ShadowedLight, StillLayers, Unserved,
};
use wgpu::{BindGroup, BindGroupLayout, Buffer, BufferUsages, RenderPass, RenderPipeline};

/// A skinned figure of two bones, which may be cut out where local x > 0.
const SHADER: &str = "
@group(0) @binding(0) var<uniform> clip_from_world: mat4x4f;
@group(1) @binding(0) var<uniform> bones: array<vec4f, 2>;
@group(2) @binding(0) var behind: texture_2d<f32>;
struct Corner {
    @builtin(position) at: vec4f,
    @location(0) local_x: f32,
}
@vertex fn skinned(@location(0) p: vec3f) -> Corner {
    let bone = bones[select(0, 1, p.y > 0.0)];
    return Corner(clip_from_world * vec4f(p + bone.xyz, 1.0), p.x);
}
fn is_hole(corner: Corner) -> bool { return corner.local_x > 0.0; }
fn is_peeled(corner: Corner) -> bool {
    return corner.at.z <= textureLoad(behind, vec2i(corner.at.xy), 0).x;
}
@fragment fn cut_out(corner: Corner) {
    if is_hole(corner) { discard; }
}
@fragment fn peel(corner: Corner) {
    if is_peeled(corner) { discard; }
}
@fragment fn peel_cut_out(corner: Corner) {
    if is_hole(corner) || is_peeled(corner) { discard; }
}
";

/// The figure's half size around its own origin.
const HALF: Vec3 = Vec3::new(2.0, 0.5, 1.5);

/// A program's figure with its own pipelines.
pub(super) struct Figure {
    has_holes: bool,
    vertices: Buffer,
    vertex_count: u32,
    bones: Buffer,
    bone_layout: BindGroupLayout,
    group: BindGroup,
    pipelines: HashMap<CastTargetKey, RenderPipeline>,
    /// Number of passes that drew it.
    draws: usize,
}

impl Figure {
    pub(super) fn new(has_holes: bool) -> Self {
        let d = device();
        let corners = box_corners(HALF);
        let usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        let bones = foreign::buffer(d, usage, cast_slice(&[Vec4::ZERO; 2]));
        let bone_layout = d
            .device
            .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: None,
                entries: &[wgpu::BindGroupLayoutEntry {
                    binding: 0,
                    visibility: wgpu::ShaderStages::VERTEX,
                    ty: wgpu::BindingType::Buffer {
                        ty: wgpu::BufferBindingType::Uniform,
                        has_dynamic_offset: false,
                        min_binding_size: None,
                    },
                    count: None,
                }],
            });
        let group = d.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &bone_layout,
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: bones.as_entire_binding(),
            }],
        });
        Self {
            has_holes,
            vertices: foreign::buffer(d, BufferUsages::VERTEX, cast_slice(&corners)),
            vertex_count: corners.len() as u32,
            bones,
            bone_layout,
            group,
            pipelines: HashMap::new(),
            draws: 0,
        }
    }

    /// Moves both bones, and returns the box around the figure.
    pub(super) fn pose(&self, center: Vec3) -> Aabb {
        let bones = [center.extend(0.0); 2];
        device()
            .queue
            .write_buffer(&self.bones, 0, cast_slice(&bones));
        Aabb {
            min: center - HALF,
            max: center + HALF,
        }
    }

    /// Returns the block that the figure fills at a place.
    fn block(&self, center: Vec3) -> Block {
        if !self.has_holes {
            return Block { center, half: HALF };
        }
        let half = HALF * Vec3::new(0.5, 1.0, 1.0);
        Block {
            center: center - Vec3::X * half.x,
            half,
        }
    }

    pub(super) fn draw(
        &mut self,
        layout: &BindGroupLayout,
        pass: &mut RenderPass<'_>,
        target: &CastTarget,
    ) {
        self.draws += 1;
        let groups = [layout, &self.bone_layout];
        let make = || pipeline(target, self.has_holes, groups);
        pass.set_pipeline(self.pipelines.entry(target.key()).or_insert_with(make));
        pass.set_bind_group(1, &self.group, &[]);
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.draw(0..self.vertex_count, 0..1);
    }
}

/// Returns the layout of the bind group of [`CastTarget::behind`].
fn peeled_layout() -> BindGroupLayout {
    let device = &device().device;
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: None,
        entries: &[wgpu::BindGroupLayoutEntry {
            binding: 0,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty: wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Float { filterable: false },
                view_dimension: wgpu::TextureViewDimension::D2,
                multisampled: false,
            },
            count: None,
        }],
    })
}

fn pipeline(target: &CastTarget, has_holes: bool, groups: [&BindGroupLayout; 2]) -> RenderPipeline {
    let device = &device().device;
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(SHADER.into()),
    });
    let peeled = peeled_layout();
    let peeled = target.behind.is_some().then_some(&peeled);
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        bind_group_layouts: &[Some(groups[0]), Some(groups[1]), peeled],
        ..wgpu::PipelineLayoutDescriptor::default()
    });
    let fragment = match (has_holes, peeled.is_some()) {
        (false, false) => None,
        (true, false) => Some("cut_out"),
        (false, true) => Some("peel"),
        (true, true) => Some("peel_cut_out"),
    };
    let compilation_options = wgpu::PipelineCompilationOptions::default();
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: None,
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("skinned"),
            compilation_options: compilation_options.clone(),
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: 12,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &wgpu::vertex_attr_array![0 => Float32x3],
            })],
        },
        primitive: target.primitive(),
        depth_stencil: Some(target.depth_stencil()),
        multisample: wgpu::MultisampleState::default(),
        fragment: fragment.map(|entry| wgpu::FragmentState {
            module: &module,
            entry_point: Some(entry),
            compilation_options,
            targets: &[],
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// A set under one light for each technique, and a figure of the program.
struct Stage {
    program: ForwardProgram,
    set: LightSet,
    lights: Vec<LightId>,
    figure: Figure,
    forward: Forward,
}

impl Stage {
    fn new(
        light: Light,
        techniques: &[Arc<dyn ShadowTechnique>],
        still_layers: StillLayers,
        has_holes: bool,
    ) -> Self {
        let program = ForwardProgram::floor(device(), SIZE);
        let mut set = program.set(SetBudget::default(), still_layers);
        let add = |technique: &Arc<dyn ShadowTechnique>| {
            set.add_light(ShadowedLight {
                light,
                technique: technique.clone(),
                priority: 1.0,
            })
            .expect("valid")
        };
        Self {
            lights: techniques.iter().map(add).collect(),
            program,
            set,
            figure: Figure::new(has_holes),
            forward: Forward::default(),
        }
    }

    /// Renders a frame. Returns the ids that each call of `own_draws` was given.
    fn update(&mut self) -> Vec<Vec<OwnCasterId>> {
        self.update_with(None)
    }

    fn update_with(&mut self, triangles: Option<&Geometry>) -> Vec<Vec<OwnCasterId>> {
        let d = device();
        let frame = SetFrame {
            camera: &camera(),
            geometry: triangles.map(|triangles| FrameGeometry {
                triangles,
                revision: 0,
            }),
        };
        self.set.prepare(&frame).expect("prepares");
        let layout = self.set.cast_layout().clone();
        let mut encoder = self.program.encoder();
        let mut calls = Vec::new();
        let figure = &mut self.figure;
        self.set
            .encode_with(&mut encoder, |pass, target, casters| {
                calls.push(casters.to_vec());
                figure.draw(&layout, pass, target);
            })
            .expect("was prepared");
        d.queue.submit([encoder.finish()]);
        calls
    }

    /// Asserts that all masks are the analytic one, up to the border of the shadow.
    fn check_masks(&mut self, light: &Light, center: Vec3, label: &str) {
        assert_eq!(self.set.unserved_lights().count(), 0);
        let expected = expected(light, &self.figure.block(center), 2);
        for (i, &id) in self.lights.iter().enumerate() {
            let index = self.set.index_of(id).expect("is there");
            let mask = self.forward.mask(&self.program, &self.set, index);
            let wrong = wrong_points(&mask, &expected, 0.0);
            assert_eq!(wrong, 0, "technique {i} under {light:?}, {label}");
        }
    }
}

fn sun() -> Light {
    Light::Directional {
        direction: Vec3::new(0.3, -1.0, 0.2).normalize(),
        angular_diameter: 0.0,
    }
}

fn lamp() -> Light {
    Light::Spot {
        position: Vec3::Y * 7.0,
        direction: Vec3::NEG_Y,
        inner: 1.0,
        outer: 1.1,
        radius: 0.0,
    }
}

/// Returns the place at a height whose shadow is at the floor's centre, moved by `offset`.
fn place(light: &Light, height: f32, offset: Vec3) -> Vec3 {
    let center = match light.position() {
        Some(position) => position.with_y(height),
        None => {
            let from_light = -light.direction_from(Vec3::ZERO);
            from_light * (height / from_light.y)
        }
    };
    center + offset
}

/// Returns techniques on one map and on several, one of which peels.
fn techniques(light: &Light) -> Vec<Arc<dyn ShadowTechnique>> {
    let one = ShadowMap {
        size: 256,
        ..ShadowMap::default()
    };
    let layout = if light.position().is_some() {
        Layout::Cube
    } else {
        Layout::Cascades(Cascades {
            count: 3,
            ..Cascades::default()
        })
    };
    let several = ShadowMap { layout, ..one };
    vec![
        Arc::new(Hard {}.on(one)),
        Arc::new(Pcf::new(1).on(several)),
        Arc::new(SecondDepth { radius: 0 }.on(one)),
        Arc::new(Midpoint { radius: 0 }.on(one)),
    ]
}

/// A skinned figure is the only caster of the set, so lights are planned for its box alone.
#[test]
fn a_figure_of_the_program_casts_its_shadow_and_moves() {
    for light in [sun(), lamp()] {
        for has_holes in [false, true] {
            let techniques = techniques(&light);
            let mut stage = Stage::new(light, &techniques, StillLayers::Auto, has_holes);
            let center = place(&light, 3.0, Vec3::new(0.5, 0.0, 0.2));
            let bounds = stage.figure.pose(center);
            let id = stage.set.add_own_caster(bounds).expect("valid");
            let calls = stage.update();
            assert!(calls.len() >= 3, "{} layers", calls.len());
            assert!(calls.iter().all(|casters| casters == &[id]));
            stage.check_masks(&light, center, "at first");
            // Nothing moves, so nothing is drawn.
            assert_eq!(stage.update().len(), 0);
            // The figure leaves the box that lights were planned for.
            let center = place(&light, 3.5, Vec3::new(-1.2, 0.0, 0.3));
            let bounds = stage.figure.pose(center);
            stage.set.move_own_caster(id, bounds).expect("valid");
            assert!(stage.update().len() >= 3);
            stage.check_masks(&light, center, "moved");
            stage.set.remove_own_caster(id).expect("is there");
            assert_eq!(stage.update().len(), 0);
            let index = stage.set.index_of(stage.lights[0]).expect("is there");
            let mask = stage.forward.mask(&stage.program, &stage.set, index);
            assert!(mask.iter().all(|&lit| lit == 1.0), "the figure is gone");
        }
    }
}

/// Among still casters, the figure is drawn on a copy of their layer, and only where it may be
/// visible.
#[test]
fn figures_are_drawn_on_copies_of_still_casters() {
    let light = sun();
    let techniques: [Arc<dyn ShadowTechnique>; 1] = [Arc::new(Hard {}.on(ShadowMap {
        size: 512,
        ..ShadowMap::default()
    }))];
    let mut stage = Stage::new(light, &techniques, StillLayers::Always, false);
    let still = Block {
        center: place(&light, 3.0, Vec3::X * 2.5),
        half: Vec3::splat(0.9),
    };
    add_block(&mut stage.set, &still);
    let center = place(&light, 3.0, Vec3::X * -1.5);
    let bounds = stage.figure.pose(center);
    let id = stage.set.add_own_caster(bounds).expect("valid");
    stage.update();
    for step in 0..3 {
        let center = center + Vec3::X * (0.3 * step as f32);
        let bounds = stage.figure.pose(center);
        stage.set.move_own_caster(id, bounds).expect("valid");
        assert_eq!(stage.update().len(), 1, "step {step}");
        let index = stage.set.index_of(stage.lights[0]).expect("is there");
        let mask = stage.forward.mask(&stage.program, &stage.set, index);
        let of_figure = expected(&light, &stage.figure.block(center), 2);
        let of_still = expected(&light, &still, 2);
        // Ignore the points that only the other one shadows.
        let without = |expected: &[Option<f32>], other: &[Option<f32>]| -> Vec<Option<f32>> {
            let pairs = expected.iter().zip(other);
            let is_free = |(&e, &o): (&Option<f32>, &Option<f32>)| {
                if o == Some(1.0) {
                    e
                } else {
                    e.filter(|&e| e == 0.0)
                }
            };
            pairs.map(is_free).collect()
        };
        assert_eq!(wrong_points(&mask, &without(&of_figure, &of_still), 0.0), 0);
        assert_eq!(wrong_points(&mask, &without(&of_still, &of_figure), 0.0), 0);
    }
}

/// Triangles of a frame don't contain the figure. Maps must show it all the same.
#[test]
fn maps_show_figures_that_the_triangles_of_the_frame_lack() {
    let light = sun();
    let techniques = techniques(&light);
    let mut stage = Stage::new(light, &techniques, StillLayers::Auto, false);
    let scene = (umbrage_scenes::find("cubes")
        .expect("a built-in scene")
        .build)();
    let geometry = Geometry::bake(&scene).expect("valid");
    let center = place(&light, 3.0, Vec3::new(0.5, 0.0, 0.2));
    let bounds = stage.figure.pose(center);
    stage.set.add_own_caster(bounds).expect("valid");
    stage.update_with(Some(&geometry));
    stage.check_masks(&light, center, "with other triangles");
}

/// A missing shadow is an error or a reason, never silent.
#[test]
fn what_would_lose_a_shadow_of_the_program_is_refused() {
    let exact: [Arc<dyn ShadowTechnique>; 1] = [Arc::new(Exact::default())];
    let mut stage = Stage::new(sun(), &exact, StillLayers::Auto, false);
    let bounds = stage.figure.pose(Vec3::Y * 3.0);
    assert!(stage.set.add_own_caster(Aabb::EMPTY).is_err());
    let id = stage.set.add_own_caster(bounds).expect("valid");
    assert!(stage.set.move_own_caster(id, Aabb::EMPTY).is_err());
    // `exact` uses a hierarchy of casters, which can't contain the figure.
    stage.update();
    let reasons: Vec<Unserved> = stage.set.unserved_lights().map(|(_, why)| why).collect();
    let [Unserved::Refused(reason)] = &reasons[..] else {
        panic!("{reasons:?}");
    };
    assert!(reason.to_string().contains("add_own_caster"), "{reason}");
    // `encode` calls no function that draws the figure.
    let mut encoder = stage.program.encoder();
    let error = stage.set.encode(&mut encoder).expect_err("has a figure");
    assert!(error.to_string().contains("encode_with"), "{error}");
    stage.set.remove_own_caster(id).expect("is there");
    assert!(stage.set.remove_own_caster(id).is_err());
    stage.update();
    stage.set.encode(&mut encoder).expect("has no figure");
}

/// A figure that was removed after `prepare` is not passed to the program.
#[test]
fn removed_figures_are_not_drawn() {
    let light = sun();
    let mut stage = Stage::new(light, &techniques(&light), StillLayers::Auto, false);
    let bounds = stage.figure.pose(place(&light, 3.0, Vec3::ZERO));
    let [first, second, third] = [0; 3].map(|_| stage.set.add_own_caster(bounds).expect("valid"));
    let frame = SetFrame {
        camera: &camera(),
        geometry: None,
    };
    stage.set.prepare(&frame).expect("prepares");
    stage.set.remove_own_caster(second).expect("is there");
    let mut encoder = stage.program.encoder();
    let mut passes = 0;
    stage
        .set
        .encode_with(&mut encoder, |_, _, casters| {
            passes += 1;
            assert_eq!(casters, [first, third]);
        })
        .expect("was prepared");
    assert!(passes > 0);
}

/// Depth peeling has a bind group of its own, and another pipeline.
#[test]
fn targets_that_peel_have_another_key() {
    let map = ShadowMap {
        size: 64,
        ..ShadowMap::default()
    };
    let peeling: [Arc<dyn ShadowTechnique>; 1] = [Arc::new(Midpoint { radius: 0 }.on(map))];
    let mut stage = Stage::new(sun(), &peeling, StillLayers::Auto, false);
    let bounds = stage.figure.pose(Vec3::Y * 3.0);
    stage.set.add_own_caster(bounds).expect("valid");
    let camera = camera();
    let frame = SetFrame {
        camera: &camera,
        geometry: None,
    };
    stage.set.prepare(&frame).expect("prepares");
    let mut keys = Vec::new();
    let mut encoder = stage.program.encoder();
    stage
        .set
        .encode_with(&mut encoder, |_, target, _| {
            keys.push((target.key(), target.behind.is_some()))
        })
        .expect("was prepared");
    assert_eq!(keys.len(), 2);
    assert_ne!(keys[0].0, keys[1].0);
    assert_eq!([keys[0].1, keys[1].1], [false, true]);
}
