//! Tests of the renderer with a caller's device, encoder and buffers.

use crate::{
    foreign::{Foreign, read},
    scene::{BackendScene, gpu},
};
use glam::{Affine3A, UVec2, Vec3};
use umbrage_core::{Geometry, Receivers};
use umbrage_wgpu::{
    Drawable, FrameInputs, GBuffer, Indices, PositionFormat, RendererOptions, ShadowRenderer,
    VertexLayout, receive_wgsl,
    wgpu::{BufferUsages, IndexFormat, TextureFormat, TextureView},
};

/// A stage in the caller's own buffers: 16-bit indices, padded vertices, with a shift and a scale.
pub(crate) struct Embedded {
    pub(crate) stage: BackendScene,
    pub(crate) foreign: Foreign,
    vertices: umbrage_wgpu::wgpu::Buffer,
    indices: umbrage_wgpu::wgpu::Buffer,
    textures: [TextureView; 3],
    size: UVec2,
    mask: Vec<f32>,
}

/// Powers of two and integers, so that the placement restores positions exactly.
const SCALE: f32 = 0.25;
const SHIFT: Vec3 = Vec3::new(1.0, -2.0, 3.0);

impl Embedded {
    pub(crate) fn new() -> Self {
        Self::on_device(Foreign::new())
    }

    pub(crate) fn on_device(foreign: Foreign) -> Self {
        let stage = BackendScene::new();
        let shadows = stage.render(&mut gpu(), &stage.recipe(64));
        let receivers = shadows.receivers.expect("the view had none");
        let (vertices, indices) = buffers(&stage.geometry);
        Self {
            vertices: foreign.buffer(BufferUsages::VERTEX, bytemuck::cast_slice(&vertices)),
            indices: foreign.buffer(BufferUsages::INDEX, bytemuck::cast_slice(&indices)),
            textures: textures(&foreign, &receivers),
            size: receivers.size,
            mask: shadows.mask,
            stage,
            foreign,
        }
    }

    pub(crate) fn casters(&self) -> Drawable<'_> {
        Drawable {
            vertices: &self.vertices,
            layout: VertexLayout {
                format: PositionFormat::Float32x3,
                stride: 20,
                position_offset: 8,
            },
            indices: Some(Indices {
                buffer: &self.indices,
                format: IndexFormat::Uint16,
            }),
            range: 0..12,
            world_from_local: Some(
                Affine3A::from_translation(SHIFT) * Affine3A::from_scale(Vec3::splat(1.0 / SCALE)),
            ),
            triangles: None,
        }
    }

    pub(crate) fn receivers(&self) -> GBuffer<'_> {
        let [position, normal, triangle] = &self.textures;
        GBuffer {
            position,
            normal,
            triangle: Some(triangle),
        }
    }

    pub(crate) fn frame<'a>(&'a self, casters: &'a [Drawable<'a>]) -> FrameInputs<'a> {
        FrameInputs {
            size: self.size,
            casters,
            everything: &[],
            receivers: self.receivers(),
        }
    }

    /// Returns the mask of the stage's light, from a map of 64 texels a side.
    pub(crate) fn mask(&self) -> &[f32] {
        &self.mask
    }

    pub(crate) fn size(&self) -> UVec2 {
        self.size
    }

    pub(crate) fn renderer(&self, options: RendererOptions) -> ShadowRenderer {
        ShadowRenderer::new(&self.foreign.device, &self.foreign.queue, options)
            .expect("the group is one of the device's")
    }
}

fn buffers(geometry: &Geometry) -> (Vec<[f32; 5]>, Vec<u16>) {
    let local = geometry.positions().iter().map(|&p| (p - SHIFT) * SCALE);
    let vertices = local.map(|p| [7.0, 8.0, p.x, p.y, p.z]).collect();
    (
        vertices,
        geometry
            .triangles()
            .iter()
            .flatten()
            .map(|&v| v as u16)
            .collect(),
    )
}

fn textures(foreign: &Foreign, r: &Receivers) -> [TextureView; 3] {
    let flag = |i: usize| f32::from(u8::from(r.receives[i]));
    let positions: Vec<_> = (0..r.len())
        .map(|i| r.position(i).extend(flag(i)))
        .collect();
    let normals: Vec<_> = (0..r.len()).map(|i| r.normal(i).extend(0.0)).collect();
    [
        foreign.texture(
            TextureFormat::Rgba32Float,
            r.size,
            bytemuck::cast_slice(&positions),
        ),
        foreign.texture(
            TextureFormat::Rgba32Float,
            r.size,
            bytemuck::cast_slice(&normals),
        ),
        foreign.texture(
            TextureFormat::R32Uint,
            r.size,
            bytemuck::cast_slice(&r.triangle),
        ),
    ]
}

#[test]
fn a_foreign_device_gives_the_same_mask() {
    let e = Embedded::new();
    let casters = [e.casters()];
    for kernel_group in 0..3 {
        let mut renderer = e.renderer(RendererOptions {
            kernel_group,
            ..RendererOptions::default()
        });
        renderer
            .prepare(&e.stage.recipe(64), &e.frame(&casters))
            .expect("all is valid");
        let mut encoder = e.foreign.encoder();
        let mask = renderer
            .encode(&mut encoder)
            .expect("it was prepared")
            .clone();
        assert_eq!(
            read(&e.foreign, encoder, mask.texture()),
            e.mask,
            "group {kernel_group}"
        );
    }
}

#[test]
fn triangle_ids_may_be_missing() {
    let e = Embedded::new();
    let casters = [e.casters()];
    let receivers = GBuffer {
        triangle: None,
        ..e.receivers()
    };
    let mut renderer = e.renderer(RendererOptions::default());
    let frame = FrameInputs {
        receivers,
        ..e.frame(&casters)
    };
    renderer
        .prepare(&e.stage.recipe(64), &frame)
        .expect("all is valid");
    let mut encoder = e.foreign.encoder();
    let mask = renderer
        .encode(&mut encoder)
        .expect("it was prepared")
        .clone();
    assert_eq!(read(&e.foreign, encoder, mask.texture()), e.mask);
}

#[test]
fn callers_may_draw_the_casts_themselves() {
    let e = Embedded::new();
    let mut renderer = e.renderer(RendererOptions::default());
    renderer
        .prepare(&e.stage.recipe(64), &e.frame(&[]))
        .expect("all is valid");
    let mut encoder = e.foreign.encoder();
    for target in renderer.cast_targets().expect("it was prepared") {
        e.foreign
            .draw_casters(&mut encoder, target, &e.stage.geometry);
    }
    let mask = renderer
        .encode_filters_and_receive(&mut encoder)
        .expect("it was prepared")
        .clone();
    assert_eq!(read(&e.foreign, encoder, mask.texture()), e.mask);
    // Without the caller's draws there are no casters.
    let mut encoder = e.foreign.encoder();
    let mask = renderer
        .encode(&mut encoder)
        .expect("it was prepared")
        .clone();
    assert!(
        read(&e.foreign, encoder, mask.texture())
            .iter()
            .all(|&v| v == 1.0)
    );
}

#[test]
fn pasted_text_gives_the_same_mask() {
    let e = Embedded::new();
    let casters = [e.casters()];
    let recipe = e.stage.recipe(64);
    let mut renderer = e.renderer(RendererOptions {
        kernel_group: 1,
        ..RendererOptions::default()
    });
    renderer
        .prepare(&recipe, &e.frame(&casters))
        .expect("all is valid");
    let mut encoder = e.foreign.encoder();
    renderer
        .encode_casts(&mut encoder)
        .expect("it was prepared");
    renderer
        .encode_filters(&mut encoder)
        .expect("it was prepared");
    let kernel = renderer.receive_bind_group().expect("it was prepared");
    let image = e.foreign.shade(
        &mut encoder,
        &receive_wgsl(&recipe, 1, "").expect("no prefix"),
        kernel,
        &e.textures[0],
        e.size,
    );
    assert_eq!(read(&e.foreign, encoder, &image), e.mask);
}

#[test]
fn a_second_frame_makes_nothing() {
    let e = Embedded::new();
    let mut renderer = e.renderer(RendererOptions::default());
    let mut counts = Vec::new();
    for step in 0..3 {
        let mut casters = e.casters();
        casters.world_from_local = Some(Affine3A::from_translation(Vec3::X * step as f32));
        let mut recipe = e.stage.recipe(64);
        recipe.casts[0].space =
            recipe.casts[0]
                .space
                .nudge_by(glam::Vec2::splat(step as f32), 0.0, UVec2::splat(64));
        let casters = [casters];
        renderer
            .prepare(&recipe, &e.frame(&casters))
            .expect("all is valid");
        counts.push(renderer.counters());
    }
    assert_eq!(counts[0].pipelines, 2, "one cast, one lookup");
    assert_eq!((counts[1], counts[2]), (counts[0], counts[0]));
}

#[test]
fn misuse_is_an_error() {
    let e = Embedded::new();
    let Foreign { device, queue } = &e.foreign;
    let error = ShadowRenderer::new(
        device,
        queue,
        RendererOptions {
            kernel_group: 99,
            ..RendererOptions::default()
        },
    )
    .expect_err("no device has 100 groups");
    assert!(
        error
            .to_string()
            .contains("bind group of the kernel: is 99"),
        "{error}"
    );
    let mut renderer = e.renderer(RendererOptions::default());
    let error = renderer
        .encode(&mut e.foreign.encoder())
        .expect_err("nothing is prepared");
    assert!(
        error.to_string().contains("call `prepare` first"),
        "{error}"
    );
    let frame = FrameInputs {
        size: UVec2::new(8, 8),
        ..e.frame(&[])
    };
    let error = renderer
        .prepare(&e.stage.recipe(64), &frame)
        .expect_err("8 x 8 is not its size");
    assert!(error.to_string().contains("position texture"), "{error}");
    let casters = [Drawable {
        layout: VertexLayout {
            format: PositionFormat::Float32x3,
            stride: 2,
            position_offset: 1,
        },
        ..e.casters()
    }];
    let error = renderer
        .prepare(&e.stage.recipe(64), &e.frame(&casters))
        .expect_err("odd stride");
    assert!(error.to_string().contains("stride"), "{error}");
    assert!(renderer.encode(&mut e.foreign.encoder()).is_err());
    let casters = [Drawable {
        range: 0..13,
        ..e.casters()
    }];
    let error = renderer
        .prepare(&e.stage.recipe(64), &e.frame(&casters))
        .expect_err("there are 12");
    assert!(
        error
            .to_string()
            .contains("caster 0, indices: end at 13, and the buffer holds 12"),
        "{error}"
    );
}
