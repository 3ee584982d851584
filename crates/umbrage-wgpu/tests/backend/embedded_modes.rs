//! Tests of peeling, counting, faces and colour images on a caller's device.

use crate::{
    counting::{column, counting_recipe, desc},
    embedded::Embedded,
    foreign::{Foreign, read, read_four},
    scene::gpu,
    shading::shaded_recipe,
};
use glam::Vec4;
use umbrage_core::{BackendError, Cast, CastMode, Faces, Format, Recipe, Source};
use umbrage_wgpu::{
    FrameInputs, GBuffer, RendererOptions, ShadowRenderer,
    wgpu::{self, Features, Limits},
};

/// Returns a recipe that peels one layer of casters off another, and counts faces and casters
/// against the first.
fn modes(e: &Embedded) -> Recipe {
    let mut recipe = counting_recipe(&e.stage, vec![column(-0.5, 1.5)]);
    recipe.images.push(desc("peeled", Format::Depth32));
    recipe.casts.push(Cast {
        mode: CastMode::DepthPeel(0),
        ..Cast::nearest(3, 0, e.stage.space())
    });
    recipe.casts.push(Cast {
        mode: CastMode::StencilDepthFail { depth: 0 },
        ..Cast::nearest(1, 0, e.stage.space())
    });
    recipe
}

fn counting_device() -> Foreign {
    Foreign::with(Features::DEPTH32FLOAT_STENCIL8, Limits::default())
}

/// Returns the results: depth behind depth, and the counts loaded by a filter.
fn draw_masks(
    e: &Embedded,
    renderer: &ShadowRenderer,
    encoder: wgpu::CommandEncoder,
) -> [Vec<f32>; 2] {
    let texture = |id: usize| {
        renderer
            .image(id)
            .expect("the recipe has it")
            .texture()
            .clone()
    };
    [
        read(&e.foreign, encoder, &texture(3)),
        read(&e.foreign, e.foreign.encoder(), &texture(2)),
    ]
}

#[test]
fn callers_may_draw_casters_while_the_backend_draws_faces() {
    let e = Embedded::on_device(counting_device());
    let recipe = modes(&e);
    let expected = e.stage.render(&mut gpu(), &recipe).images;
    let mut renderer = e.renderer(RendererOptions::default());
    renderer
        .prepare(&recipe, &e.frame(&[]))
        .expect("all is valid");
    let mut encoder = e.foreign.encoder();
    let mut calls = Vec::new();
    let draw = |encoder: &mut wgpu::CommandEncoder, target: &umbrage_wgpu::CastTarget| {
        calls.push((target.behind.is_some(), target.everything));
        e.foreign.draw_casters(encoder, target, &e.stage.geometry);
    };
    renderer
        .encode_casts_with(&mut encoder, draw)
        .expect("it was prepared");
    renderer
        .encode_filters_and_receive(&mut encoder)
        .expect("it was prepared");
    assert_eq!(
        calls,
        [(false, false), (true, false), (false, false)],
        "the faces are none of the caller's"
    );
    let [peeled, counts] = draw_masks(&e, &renderer, encoder);
    assert_eq!(
        (&peeled, &counts),
        (&expected[3].texels, &expected[1].texels)
    );
    assert!(peeled.iter().any(|&d| d < 1.0) && counts.contains(&255.0) && counts.contains(&0.0));
    let error = renderer
        .cast_targets()
        .expect_err("the targets are not enough");
    assert!(error.to_string().contains("encode_casts_with"), "{error}");
}

#[test]
fn the_backend_draws_all_modes_on_a_foreign_device_and_makes_nothing_twice() {
    let e = Embedded::on_device(counting_device());
    let recipe = modes(&e);
    let expected = e.stage.render(&mut gpu(), &recipe).images;
    let mut renderer = e.renderer(RendererOptions::default());
    let casters = [e.casters()];
    let mut counters = Vec::new();
    for _ in 0..2 {
        renderer
            .prepare(&recipe, &e.frame(&casters))
            .expect("all is valid");
        let mut encoder = e.foreign.encoder();
        renderer.encode(&mut encoder).expect("it was prepared");
        let [peeled, counts] = draw_masks(&e, &renderer, encoder);
        assert_eq!(
            (&peeled, &counts),
            (&expected[3].texels, &expected[1].texels)
        );
        counters.push(renderer.counters());
    }
    assert_eq!(counters[0], counters[1]);
}

#[test]
fn a_device_that_cannot_count_says_so() {
    let e = Embedded::on_device(Foreign::new());
    let mut renderer = e.renderer(RendererOptions::default());
    let recipe = modes(&e);
    let error = renderer
        .prepare(&recipe, &e.frame(&[]))
        .expect_err("no feature");
    assert!(matches!(error, BackendError::Invalid(_)), "{error:?}");
    assert!(
        error
            .to_string()
            .contains("request the feature `DEPTH32FLOAT_STENCIL8`"),
        "{error}"
    );
}

#[test]
fn a_picture_on_a_foreign_device_is_the_same() {
    let e = Embedded::on_device(Foreign::new());
    let casters = [e.casters()];
    let recipe = shaded_recipe(&e.stage);
    let expected = e
        .stage
        .render(&mut gpu(), &recipe)
        .picture
        .expect("the recipe shades");
    for kernel_group in [0, 2] {
        let mut renderer = e.renderer(RendererOptions {
            kernel_group,
            ..RendererOptions::default()
        });
        assert!(renderer.picture().is_none());
        renderer
            .prepare(&recipe, &e.frame(&casters))
            .expect("all is valid");
        let mut encoder = e.foreign.encoder();
        renderer.encode(&mut encoder).expect("it was prepared");
        let picture = renderer
            .picture()
            .expect("the recipe shades")
            .texture()
            .clone();
        let expected: Vec<Vec4> = expected.iter().copied().map(Vec4::from).collect();
        assert_eq!(read_four(&e.foreign, encoder, &picture), expected);
    }
}

#[test]
fn missing_input_is_named() {
    let e = Embedded::on_device(Foreign::new());
    let casters = [e.casters()];
    let mut renderer = e.renderer(RendererOptions::default());
    let frame = FrameInputs {
        receivers: GBuffer {
            triangle: None,
            ..e.receivers()
        },
        ..e.frame(&casters)
    };
    let error = renderer
        .prepare(&shaded_recipe(&e.stage), &frame)
        .expect_err("no ids");
    assert!(
        error
            .to_string()
            .contains("add triangle ids as `GBuffer::triangle`"),
        "{error}"
    );
    let mut recipe = e.stage.recipe(40);
    recipe.casts[0].source = Source::Everything;
    let error = renderer
        .prepare(&recipe, &e.frame(&casters))
        .expect_err("casters alone");
    assert!(
        error
            .to_string()
            .contains("list all that the camera may see in `FrameInputs::everything`"),
        "{error}"
    );
    let frame = FrameInputs {
        everything: &casters,
        ..e.frame(&casters)
    };
    renderer.prepare(&recipe, &frame).expect("all is there");
    // Without any drawables, the caller draws.
    renderer
        .prepare(&recipe, &e.frame(&[]))
        .expect("nothing is drawn");
    assert!(renderer.cast_targets().expect("it was prepared")[0].everything);
}

#[test]
fn faces_beyond_a_buffer_are_refused() {
    let most = 1 << 20;
    let limits = Limits {
        max_buffer_size: most,
        ..Limits::downlevel_defaults()
    };
    let e = Embedded::on_device(Foreign::with(Features::empty(), limits));
    let vertices = vec![Vec4::W; (most / 16 + 1) as usize];
    let faces = Faces {
        vertices,
        triangles: vec![[0, 1, 2]],
    };
    let mut recipe = e.stage.recipe(40);
    recipe.casts[0].source = Source::Faces(faces.into());
    let mut renderer = e.renderer(RendererOptions::default());
    let error = renderer
        .prepare(&recipe, &e.frame(&[]))
        .expect_err("too many");
    assert!(error.to_string().contains("faces of a cast"), "{error}");
}
