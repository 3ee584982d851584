//! Tests of one renderer with several lights.

use crate::{
    embedded::Embedded,
    foreign::{Foreign, read},
    kernels::{Compare, Numbers},
};
use glam::Vec4;
use std::sync::Arc;
use umbrage_core::{BackendError, Cast, Faces, LightSpace, Recipe, Source};
use umbrage_wgpu::{
    RendererOptions, ShadowRenderer, receive_wgsl,
    wgpu::{CommandEncoder, Texture},
};

/// Returns a recipe with a map of this side that is drawn from a space and looked up there.
fn light(e: &Embedded, space: LightSpace, side: u32) -> Recipe {
    let numbers = Numbers {
        clip_from_world: space.clip_from_world(),
        numbers: Vec4::splat(0.0125),
    };
    let recipe = e.stage.recipe_with(side, Arc::new(Compare(numbers)));
    Recipe {
        casts: vec![Cast::nearest(0, 0, space)],
        ..recipe
    }
}

/// Returns lights from straight above and from an angle: same shape, different numbers.
fn lights(e: &Embedded) -> [Recipe; 2] {
    [
        light(e, e.stage.space(), 64),
        light(e, e.stage.tilted_space(), 64),
    ]
}

fn prepare(e: &Embedded, renderer: &mut ShadowRenderer, recipe: &Recipe) {
    let casters = [e.casters()];
    renderer
        .prepare(recipe, &e.frame(&casters))
        .expect("all is valid");
}

/// Prepares and encodes. Returns the mask.
fn encode(
    e: &Embedded,
    renderer: &mut ShadowRenderer,
    encoder: &mut CommandEncoder,
    recipe: &Recipe,
) -> Texture {
    prepare(e, renderer, recipe);
    renderer
        .encode(encoder)
        .expect("it was prepared")
        .texture()
        .clone()
}

fn submit(e: &Embedded, encoder: CommandEncoder) {
    e.foreign.queue.submit([encoder.finish()]);
}

fn pixels(e: &Embedded, mask: &Texture) -> Vec<f32> {
    read(&e.foreign, e.foreign.encoder(), mask)
}

/// Returns the mask of a recipe executed by a separate renderer.
fn render_alone(e: &Embedded, recipe: &Recipe) -> Vec<f32> {
    let mut renderer = e.renderer(RendererOptions::default());
    let mut encoder = e.foreign.encoder();
    let mask = encode(e, &mut renderer, &mut encoder, recipe);
    read(&e.foreign, encoder, &mask)
}

#[test]
fn two_lights_in_one_encoder_get_their_own_shadows() {
    let e = Embedded::new();
    let [above, aslant] = lights(&e);
    let of_above = render_alone(&e, &above);
    let of_aslant = render_alone(&e, &aslant);
    assert_ne!(of_above, of_aslant, "lights that shine alike prove nothing");
    for (first, second, expected) in [
        (&above, &aslant, [&of_above, &of_aslant]),
        (&aslant, &above, [&of_aslant, &of_above]),
    ] {
        let mut renderer = e.renderer(RendererOptions::default());
        let mut encoder = e.foreign.encoder();
        let masks = [first, second].map(|recipe| encode(&e, &mut renderer, &mut encoder, recipe));
        submit(&e, encoder);
        assert_eq!([&pixels(&e, &masks[0]), &pixels(&e, &masks[1])], expected);
    }
}

#[test]
fn encoders_may_be_submitted_in_any_order() {
    let e = Embedded::new();
    let recipes = lights(&e);
    let mut renderer = e.renderer(RendererOptions::default());
    let mut encoders = [e.foreign.encoder(), e.foreign.encoder()];
    let masks = [0, 1].map(|i| encode(&e, &mut renderer, &mut encoders[i], &recipes[i]));
    let [first, second] = encoders;
    submit(&e, second);
    submit(&e, first);
    for (mask, recipe) in masks.iter().zip(&recipes) {
        assert_eq!(pixels(&e, mask), render_alone(&e, recipe));
    }
}

/// Create both bind groups before drawing with them.
#[test]
fn forward_shaders_may_read_the_maps_of_both() {
    let e = Embedded::new();
    let recipes = lights(&e);
    let mut renderer = e.renderer(RendererOptions {
        kernel_group: 1,
        ..RendererOptions::default()
    });
    let mut encoder = e.foreign.encoder();
    let groups = recipes.each_ref().map(|recipe| {
        prepare(&e, &mut renderer, recipe);
        renderer
            .encode_casts(&mut encoder)
            .expect("it was prepared");
        renderer
            .encode_filters(&mut encoder)
            .expect("it was prepared");
        let (group, layout) = renderer.receive_bind_group().expect("it was prepared");
        (group.clone(), layout.clone())
    });
    let images = [0, 1].map(|i| {
        let text = receive_wgsl(&recipes[i], 1, "").expect("no prefix");
        let (group, layout) = &groups[i];
        e.foreign.shade(
            &mut encoder,
            &text,
            (group, layout),
            e.receivers().position,
            e.size(),
        )
    });
    submit(&e, encoder);
    for (image, recipe) in images.iter().zip(&recipes) {
        assert_eq!(pixels(&e, image), render_alone(&e, recipe));
    }
}

/// Buffers of faces are reused once no recipe can refer to them, but not while an unsubmitted
/// encoder draws them.
#[test]
fn faces_stay_until_they_are_drawn() {
    let e = Embedded::new();
    let part = |triangles: std::ops::Range<usize>| {
        let vertices = e
            .stage
            .geometry
            .positions()
            .iter()
            .map(|p| p.extend(1.0))
            .collect();
        let faces = Faces {
            vertices,
            triangles: e.stage.geometry.triangles()[triangles].to_vec(),
        };
        let mut recipe = light(&e, e.stage.space(), 64);
        recipe.casts[0].source = Source::Faces(Arc::new(faces));
        recipe
    };
    let parts = [0..2, 2..4];
    let expected = parts
        .clone()
        .map(|triangles| render_alone(&e, &part(triangles)));
    assert_ne!(expected[0], expected[1]);
    let mut renderer = e.renderer(RendererOptions::default());
    let mut encoder = e.foreign.encoder();
    let masks = parts.map(|triangles| encode(&e, &mut renderer, &mut encoder, &part(triangles)));
    submit(&e, encoder);
    assert_eq!(masks.map(|mask| pixels(&e, &mask)), expected);
}

/// Renders one frame of two lights, without waiting for the device.
fn frame(e: &Embedded, renderer: &mut ShadowRenderer, recipes: &[Recipe; 2]) -> [Texture; 2] {
    let mut encoder = e.foreign.encoder();
    let masks = recipes
        .each_ref()
        .map(|recipe| encode(e, renderer, &mut encoder, recipe));
    submit(e, encoder);
    masks
}

#[test]
fn later_frames_of_two_lights_make_nothing() {
    let e = Embedded::new();
    // Use two sizes, so that each light has to find its own textures again.
    let above = light(&e, e.stage.space(), 64);
    let aslant = light(&e, e.stage.tilted_space(), 32);
    let mut renderer = e.renderer(RendererOptions::default());
    let both = [above, aslant];
    let first = frame(&e, &mut renderer, &both);
    let made = renderer.counters();
    assert_eq!(
        (made.pipelines, made.textures),
        (2, 4),
        "pipelines are shared, maps and masks are not"
    );
    for _ in 0..4 {
        assert_eq!(frame(&e, &mut renderer, &both), first);
        assert_eq!(renderer.counters(), made);
    }
    let [above, aslant] = both;
    let turned = frame(&e, &mut renderer, &[aslant, above]);
    assert_eq!(renderer.counters(), made);
    assert_eq!([&turned[1], &turned[0]], [&first[0], &first[1]]);
}

#[test]
fn lights_that_are_submitted_one_by_one_share_all() {
    let e = Embedded::new();
    let recipes = lights(&e);
    let mut renderer = e.renderer(RendererOptions::default());
    for (i, recipe) in [0, 1, 0, 1].map(|i| (i, &recipes[i])) {
        let mut encoder = e.foreign.encoder();
        let mask = encode(&e, &mut renderer, &mut encoder, recipe);
        submit(&e, encoder);
        assert_eq!(renderer.counters().textures, 2, "light {i}");
        assert_eq!(pixels(&e, &mask), render_alone(&e, recipe));
    }
}

#[test]
fn encoders_that_are_dropped_hold_nothing() {
    let e = Embedded::new();
    let recipes = lights(&e);
    let mut renderer = e.renderer(RendererOptions::default());
    for recipe in recipes.iter().cycle().take(4) {
        encode(&e, &mut renderer, &mut e.foreign.encoder(), recipe);
        assert_eq!(renderer.counters().textures, 2);
    }
}

#[test]
fn buffers_of_another_device_are_refused() {
    let [foreign, other] = Foreign::two();
    let e = Embedded::on_device(foreign);
    let mut renderer = ShadowRenderer::new(&other.device, &other.queue, RendererOptions::default())
        .expect("group 0 is there");
    let casters = [e.casters()];
    let prepared = renderer.prepare(&e.stage.recipe(64), &e.frame(&casters));
    let error = prepared.expect_err("its textures are another device's");
    assert!(matches!(error, BackendError::Validation(_)), "{error}");
}

/// Resources recorded twice, stage by stage or into two encoders, wait for the last submission.
#[test]
fn all_encoders_count() {
    let e = Embedded::new();
    let [above, aslant] = lights(&e);
    let expected = [render_alone(&e, &above), render_alone(&e, &aslant)];
    let mut renderer = e.renderer(RendererOptions::default());
    let mut encoders = [e.foreign.encoder(), e.foreign.encoder()];
    prepare(&e, &mut renderer, &above);
    renderer
        .encode_casts(&mut encoders[0])
        .expect("it was prepared");
    let mask = renderer
        .encode_filters_and_receive(&mut encoders[1])
        .expect("it was prepared")
        .texture()
        .clone();
    let [casts, rest] = encoders;
    submit(&e, casts);
    let mut encoder = e.foreign.encoder();
    let other = encode(&e, &mut renderer, &mut encoder, &aslant);
    submit(&e, rest);
    submit(&e, encoder);
    assert_eq!([pixels(&e, &mask), pixels(&e, &other)], expected);
}
