//! Tests of the sources of casts: casters, all geometry, and a technique's faces.

use crate::scene::{BackendScene, gpu};
use glam::{Vec3, Vec4};
use std::sync::Arc;
use umbrage_core::{
    Cast, Faces, LightSpace, Recipe, Source,
    light_space::{look_along, perspective},
};

/// Returns some triangles of the stage, every vertex times `w`.
fn faces(stage: &BackendScene, triangles: std::ops::Range<usize>, w: f32) -> Arc<Faces> {
    let vertices = stage
        .geometry
        .positions()
        .iter()
        .map(|p| p.extend(1.0) * w)
        .collect();
    Arc::new(Faces {
        vertices,
        triangles: stage.geometry.triangles()[triangles].to_vec(),
    })
}

fn casting_recipe(stage: &BackendScene, space: LightSpace, source: Source) -> Recipe {
    Recipe {
        casts: vec![Cast {
            source,
            ..Cast::nearest(0, 0, space)
        }],
        ..stage.recipe(40)
    }
}

#[test]
fn everything_is_more_than_the_casters() {
    let mut stage = BackendScene::new();
    let whole = stage.recipe(40);
    let mut gpu = gpu();
    let expected = stage.render(&mut gpu, &whole).images;
    stage.geometry = stage.geometry.without_casters();
    let casters = stage.render(&mut gpu, &whole).images;
    assert!(casters[0].texels.iter().all(|&d| d == 1.0));
    let everything = stage
        .render(
            &mut gpu,
            &casting_recipe(&stage, stage.space(), Source::Everything),
        )
        .images;
    assert_eq!(everything, expected);
}

#[test]
fn faces_round_as_casters_do() {
    let stage = BackendScene::new();
    let mut gpu = gpu();
    for space in [stage.tilted_space(), stage.camera.space()] {
        let expected = stage
            .render(&mut gpu, &casting_recipe(&stage, space, Source::Casters))
            .images;
        // Powers of two scale exactly, and division by w is exact, too.
        for w in [1.0, 4.0] {
            let source = Source::Faces(faces(&stage, 0..4, w));
            assert_eq!(
                stage
                    .render(&mut gpu, &casting_recipe(&stage, space, source))
                    .images,
                expected,
                "w = {w}"
            );
        }
        let fewer = Source::Faces(faces(&stage, 0..3, 1.0));
        assert_ne!(
            stage
                .render(&mut gpu, &casting_recipe(&stage, space, fewer))
                .images,
            expected,
            "a triangle is missing"
        );
    }
}

#[test]
fn faces_reach_to_infinity() {
    let stage = BackendScene::new();
    let side = 40;
    let near = 0.5;
    let far = 1e6;
    let space = LightSpace {
        view_from_world: look_along(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y).expect("-z is a direction"),
        clip_from_view: perspective(std::f32::consts::FRAC_PI_2, 1.0, near, far)
            .expect("the numbers are in order"),
    };
    // The ground 1 m below the eye, from 1 m ahead to the horizon, as wide as the image everywhere.
    let edge = [
        Vec4::new(-1.0, -1.0, -1.0, 1.0),
        Vec4::new(1.0, -1.0, -1.0, 1.0),
    ];
    let horizon = [
        Vec4::new(1.0, 0.0, -1.0, 0.0),
        Vec4::new(-1.0, 0.0, -1.0, 0.0),
    ];
    let vertices = [edge, horizon].concat();
    let ground = Arc::new(Faces {
        vertices,
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    });
    let images = stage
        .render(
            &mut gpu(),
            &casting_recipe(&stage, space, Source::Faces(ground)),
        )
        .images;
    for (i, &depth) in images[0].texels.iter().enumerate() {
        let y = 1.0 - (f64::from(i as u32 / side) + 0.5) / 20.0;
        if y > 0.0 {
            assert_eq!(depth, 1.0, "texel {i} is sky");
            continue;
        }
        let distance = -1.0 / y;
        let near = f64::from(near);
        let far = f64::from(far);
        let expected = far / (far - near) * (1.0 - near / distance);
        // Ten roundings, no number above 2.
        assert!(
            (f64::from(depth) - expected).abs() < 10.0 * 2.0_f64.powi(-23),
            "{depth}, not {expected}"
        );
    }
}

#[test]
fn faces_are_uploaded_once() {
    let stage = BackendScene::new();
    let mut gpu = gpu();
    let kept = Source::Faces(faces(&stage, 0..4, 1.0));
    let recipe = casting_recipe(&stage, stage.space(), kept);
    stage.render(&mut gpu, &recipe);
    let first = gpu.counters();
    let image = stage.render(&mut gpu, &recipe).images;
    assert_eq!(gpu.counters(), first);
    // Execute techniques that compute new faces each frame.
    for triangles in [0..3, 1..4, 0..2] {
        let recipe = casting_recipe(
            &stage,
            stage.space(),
            Source::Faces(faces(&stage, triangles, 1.0)),
        );
        assert_ne!(stage.render(&mut gpu, &recipe).images, image);
    }
    assert_eq!(
        gpu.counters().buffers,
        first.buffers + 2,
        "one more set, as the first one is still held"
    );
}

#[test]
fn no_faces_leave_the_image_as_it_was() {
    let stage = BackendScene::new();
    let mut gpu = gpu();
    let mut recipe = stage.recipe(40);
    let before = stage.render(&mut gpu, &recipe).images;
    let nothing = Source::Faces(Arc::default());
    recipe.casts.push(Cast {
        source: nothing.clone(),
        ..Cast::nearest(0, 0, stage.space())
    });
    assert_eq!(stage.render(&mut gpu, &recipe).images, before);
    recipe.casts.remove(0);
    assert_eq!(
        stage.render(&mut gpu, &recipe).images[0].texels,
        vec![1.0; 1600]
    );
}
