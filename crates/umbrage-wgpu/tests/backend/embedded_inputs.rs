//! Tests of invalid buffers, textures and matrices of the caller. Each is reported as an error of
//! this crate before wgpu reports its own.

use crate::{embedded::Embedded, foreign::Foreign, scene::BackendScene};
use glam::{Affine3A, Mat4, Vec3};
use umbrage_core::BackendError;
use umbrage_wgpu::{
    DepthBuffer, Drawable, FrameInputs, GBuffer, GBufferFromDepth, Indices, PositionFormat,
    RendererOptions, VertexLayout,
    wgpu::{BufferUsages, TextureFormat, TextureUsages, TextureView},
};

/// Checks that a frame is rejected with an `Invalid` error that contains `words`.
fn check_refused(e: &Embedded, frame: &FrameInputs<'_>, words: &str) {
    let mut renderer = e.renderer(RendererOptions::default());
    let prepared = renderer.prepare(&e.stage.recipe(64), frame);
    let error = prepared.expect_err(words);
    assert!(matches!(error, BackendError::Invalid(_)), "{error:?}");
    assert!(error.to_string().contains(words), "{error}");
}

fn refused_caster(e: &Embedded, caster: Drawable<'_>, words: &str) {
    let casters = [e.casters(), caster];
    check_refused(e, &e.frame(&casters), words);
}

#[test]
fn buffers_need_their_usages() {
    let e = Embedded::new();
    let bytes = [0; 240];
    let elsewhere = e.foreign.buffer(BufferUsages::COPY_SRC, &bytes);
    let words =
        "caster 1, vertex buffer: was created without the usage `BufferUsages::VERTEX`; add it";
    refused_caster(
        &e,
        Drawable {
            vertices: &elsewhere,
            ..e.casters()
        },
        words,
    );
    let indices = Some(Indices {
        buffer: &elsewhere,
        ..e.casters().indices.expect("it has some")
    });
    let words =
        "caster 1, index buffer: was created without the usage `BufferUsages::INDEX`; add it";
    refused_caster(
        &e,
        Drawable {
            indices,
            ..e.casters()
        },
        words,
    );
    let casters = [e.casters()];
    let everything = [Drawable {
        vertices: &elsewhere,
        ..e.casters()
    }];
    check_refused(
        &e,
        &FrameInputs {
            everything: &everything,
            ..e.frame(&casters)
        },
        "everything 0, vertex buffer: was created without",
    );
}

#[test]
fn vertices_hold_a_position() {
    let e = Embedded::new();
    for stride in [0, 2, 6, 8, 14, 4096] {
        let layout = VertexLayout {
            format: PositionFormat::Float32x3,
            stride,
            position_offset: 0,
        };
        let words = format!(
            "caster 1, vertex layout's stride: is {stride} bytes; use a multiple of 4 from 12 to 2048"
        );
        refused_caster(
            &e,
            Drawable {
                layout,
                ..e.casters()
            },
            &words,
        );
    }
    for position_offset in [2, 10, 12, 20, u64::MAX] {
        let layout = VertexLayout {
            format: PositionFormat::Float32x3,
            stride: 20,
            position_offset,
        };
        let words = format!(
            "caster 1, vertex layout's position offset: is {position_offset} bytes, in vertices of 20"
        );
        refused_caster(
            &e,
            Drawable {
                layout,
                ..e.casters()
            },
            &words,
        );
    }
}

/// Triangles without indices, in a buffer that ends with the last position.
#[test]
fn ranges_end_with_the_last_position() {
    let e = Embedded::new();
    let layout = VertexLayout {
        format: PositionFormat::Float32x3,
        stride: 20,
        position_offset: 0,
    };
    let vertices = e.foreign.buffer(BufferUsages::VERTEX, &[0; 2 * 20 + 12]);
    let caster = |range| Drawable {
        vertices: &vertices,
        layout,
        indices: None,
        range,
        world_from_local: None,
        triangles: None,
    };
    refused_caster(
        &e,
        caster(0..4),
        "caster 1, vertices: end at 4, and the buffer holds 3",
    );
    let late = VertexLayout {
        format: PositionFormat::Float32x3,
        stride: 20,
        position_offset: 8,
    };
    refused_caster(
        &e,
        Drawable {
            layout: late,
            ..caster(0..3)
        },
        "caster 1, vertices: end at 3, and the buffer holds 2",
    );
    #[expect(clippy::reversed_empty_ranges, reason = "that is what is refused")]
    refused_caster(
        &e,
        caster(3..0),
        "caster 1, vertices: start at 3 and end at 0",
    );
    let casters = [caster(0..3)];
    let mut renderer = e.renderer(RendererOptions::default());
    let frame = e.frame(&casters);
    renderer
        .prepare(&e.stage.recipe(64), &frame)
        .expect("all is there");
    let mut encoder = e.foreign.encoder();
    renderer.encode(&mut encoder).expect("it was prepared");
    e.foreign.queue.submit([encoder.finish()]);
}

#[test]
fn places_are_finite() {
    let e = Embedded::new();
    for bad in [f32::NAN, f32::INFINITY] {
        let world_from_local = Some(Affine3A::from_translation(Vec3::new(0.0, bad, 0.0)));
        let words = format!("caster 1, world from local: holds {bad}");
        refused_caster(
            &e,
            Drawable {
                world_from_local,
                ..e.casters()
            },
            &words,
        );
    }
}

#[test]
fn gbuffers_can_be_read() {
    let e = Embedded::new();
    let pixels = vec![0; 16 * (e.size().x * e.size().y) as usize];
    let texture = |format: TextureFormat, pixels: &[u8]| {
        e.foreign.texture_for(
            TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_DST,
            format,
            e.size(),
            pixels,
        )
    };
    let floats = texture(TextureFormat::Rgba32Float, &pixels);
    let ids = texture(TextureFormat::R32Uint, &pixels[..pixels.len() / 4]);
    let frame = |receivers| FrameInputs {
        receivers,
        ..e.frame(&[])
    };
    let without = |what: &str| {
        format!(
            "receivers' {what} texture: was created without the usage `TextureUsages::TEXTURE_BINDING`"
        )
    };
    check_refused(
        &e,
        &frame(GBuffer {
            position: &floats,
            ..e.receivers()
        }),
        &without("position"),
    );
    check_refused(
        &e,
        &frame(GBuffer {
            normal: &floats,
            ..e.receivers()
        }),
        &without("normal"),
    );
    check_refused(
        &e,
        &frame(GBuffer {
            triangle: Some(&ids),
            ..e.receivers()
        }),
        &without("triangle"),
    );
}

fn refused_depth(foreign: &Foreign, source: &DepthBuffer<'_>, words: &str) {
    let error = GBufferFromDepth::new(&foreign.device, &foreign.queue)
        .prepare(source)
        .expect_err(words);
    assert!(matches!(error, BackendError::Invalid(_)), "{error:?}");
    assert!(error.to_string().contains(words), "{error}");
}

#[test]
fn depth_buffers_can_be_read() {
    let stage = BackendScene::new();
    let foreign = Foreign::new();
    let size = stage.camera.size;
    let bytes = vec![0; 4 * (size.x * size.y) as usize];
    let world_from_clip = stage.camera.space().clip_from_world().inverse();
    let source = |depth| DepthBuffer {
        depth,
        world_from_clip,
        empty: 1.0,
    };
    let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_DST;
    let unread = foreign.texture_for(usage, TextureFormat::R32Float, size, &bytes);
    refused_depth(
        &foreign,
        &source(&unread),
        "depth buffer: was created without the usage `TextureUsages::TEXTURE_BINDING`",
    );
    let whole = foreign.texture(TextureFormat::R32Uint, size, &bytes);
    refused_depth(
        &foreign,
        &source(&whole),
        "depth buffer: is R32Uint; use a depth format",
    );
    let good = foreign.texture(TextureFormat::R32Float, size, &bytes);
    for bad in [f32::NAN, f32::INFINITY] {
        let mut source = source(&good);
        source.world_from_clip.w_axis.x = bad;
        refused_depth(&foreign, &source, &format!("world from clip: holds {bad}"));
    }
    for empty in [f32::NAN, 0.5, 2.0] {
        let source = DepthBuffer {
            empty,
            ..source(&good)
        };
        refused_depth(
            &foreign,
            &source,
            &format!("depth where nothing was drawn: is {empty}"),
        );
    }
}

/// Covers perspective, usual and reversed, with and without a far plane.
#[test]
fn empty_depth_is_not_the_nearest() {
    let stage = BackendScene::new();
    let foreign = Foreign::new();
    let depth: TextureView = foreign.texture(
        TextureFormat::R32Float,
        stage.camera.size,
        &vec![0; 97 * 61 * 4],
    );
    let usual = stage.camera.space();
    for (reversed, endless) in [(false, false), (true, false), (false, true), (true, true)] {
        let mut rows = usual.clip_from_view.transpose();
        if endless {
            (rows.z_axis.z, rows.z_axis.w) = (-1.0, -0.5);
        }
        if reversed {
            rows.z_axis = rows.w_axis - rows.z_axis;
        }
        let clip_from_world: Mat4 = rows.transpose() * usual.view_from_world;
        let world_from_clip = clip_from_world.as_dmat4().inverse().as_mat4();
        let [right, wrong] = if reversed { [0.0, 1.0] } else { [1.0, 0.0] };
        let source = |empty| DepthBuffer {
            depth: &depth,
            world_from_clip,
            empty,
        };
        let words = format!(
            "is {wrong}, but for this camera that is the depth of the nearest geometry; use {right}"
        );
        refused_depth(&foreign, &source(wrong), &words);
        GBufferFromDepth::new(&foreign.device, &foreign.queue)
            .prepare(&source(right))
            .expect("the camera is a camera");
    }
}

/// Without perspective, the matrix doesn't reveal which end is near, so every value of `empty` is
/// accepted.
#[test]
fn flat_cameras_take_either_empty_depth() {
    let stage = BackendScene::new();
    let foreign = Foreign::new();
    let depth: TextureView = foreign.texture(
        TextureFormat::R32Float,
        stage.camera.size,
        &vec![0; 97 * 61 * 4],
    );
    for space in [stage.space(), stage.tilted_space()] {
        // Invert in 32 bits, as programs do.
        let world_from_clip = space.clip_from_world().inverse();
        for empty in [0.0, 1.0] {
            let source = DepthBuffer {
                depth: &depth,
                world_from_clip,
                empty,
            };
            GBufferFromDepth::new(&foreign.device, &foreign.queue)
                .prepare(&source)
                .expect("the camera is a camera");
        }
    }
}
