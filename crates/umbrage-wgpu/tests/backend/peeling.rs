//! Tests of depth peeling.

use crate::scene::{BackendScene, gpu};
use glam::Vec3;
use std::sync::Arc;
use umbrage_core::{Cast, CastMode, Faces, Format, Image, LightSpace, Recipe, Source};
use umbrage_wgpu::Gpu;

/// Returns a recipe with three layers of depth, peeled one after the other, each in its own image.
fn peels(stage: &BackendScene, space: LightSpace, format: Format) -> Recipe {
    let mut recipe = stage.recipe(40);
    recipe.images[0].format = format;
    recipe.images = vec![recipe.images[0]; 3];
    let behind = |image: usize| Cast {
        mode: CastMode::DepthPeel(image - 1),
        ..Cast::nearest(image, 0, space)
    };
    recipe.casts = vec![Cast::nearest(0, 0, space), behind(1), behind(2)];
    recipe
}

/// Renders the depth of the floor alone.
fn floor(stage: &BackendScene, gpu: &mut Gpu, space: LightSpace, format: Format) -> Image {
    let vertices = stage
        .geometry
        .positions()
        .iter()
        .map(|p: &Vec3| p.extend(1.0))
        .collect();
    let is_floor = |t: &&[u32; 3]| stage.geometry.positions()[t[0] as usize].y == 0.0;
    let triangles = stage
        .geometry
        .triangles()
        .iter()
        .filter(is_floor)
        .copied()
        .collect();
    let source = Source::Faces(Arc::new(Faces {
        vertices,
        triangles,
    }));
    let mut recipe = Recipe {
        casts: vec![Cast {
            source,
            ..Cast::nearest(0, 0, space)
        }],
        ..stage.recipe(40)
    };
    recipe.images[0].format = format;
    stage.render(gpu, &recipe).images.swap_remove(0)
}

#[test]
fn the_floor_is_behind_the_plate_and_nothing_behind_the_floor() {
    let stage = BackendScene::new();
    let mut gpu = gpu();
    for format in [Format::Depth32, Format::Depth16] {
        for space in [stage.space(), stage.tilted_space(), stage.camera.space()] {
            let floor = floor(&stage, &mut gpu, space, format);
            let images = stage.render(&mut gpu, &peels(&stage, space, format)).images;
            let mut plates = 0;
            let mut floors = 0;
            for (i, &nearest) in images[0].texels.iter().enumerate() {
                // Where the plate is in front of the floor, the floor is left. Where there is only
                // one of them, nothing is left.
                let plate = nearest < floor.texels[i];
                let expected = if plate { floor.texels[i] } else { 1.0 };
                assert_eq!(images[1].texels[i], expected, "{format:?}, texel {i}");
                plates += usize::from(plate && expected < 1.0);
                floors += usize::from(!plate && nearest < 1.0);
            }
            assert!(
                plates > 20 && floors > 200,
                "{plates} texels of plate, {floors} of floor"
            );
            assert!(
                images[2].texels.iter().all(|&d| d == 1.0),
                "{format:?}: nothing is behind the floor"
            );
        }
    }
}

#[test]
fn behind_a_layer_that_nothing_wrote_is_nothing() {
    let stage = BackendScene::new();
    let mut gpu = gpu();
    let mut recipe = peels(&stage, stage.space(), Format::Depth32);
    let full = stage.render(&mut gpu, &recipe).images;
    // The images now contain depth, which must not remain in the next frame.
    recipe.casts.remove(0);
    let empty = stage.render(&mut gpu, &recipe).images;
    assert!(full[1].texels.iter().any(|&d| d < 1.0));
    assert!(empty.iter().flat_map(|i| &i.texels).all(|&d| d == 1.0));
}

#[test]
fn a_second_frame_makes_nothing() {
    let stage = BackendScene::new();
    let mut gpu = gpu();
    for format in [Format::Depth32, Format::Depth16] {
        let recipe = peels(&stage, stage.tilted_space(), format);
        let images = stage.render(&mut gpu, &recipe).images;
        let first = gpu.counters();
        assert_eq!(stage.render(&mut gpu, &recipe).images, images);
        assert_eq!(gpu.counters(), first, "{format:?}");
    }
}
