//! Tests of depth-fail counting.

use crate::{
    kernels::Same,
    scene::{BackendScene, gpu},
};
use glam::{UVec2, Vec4};
use std::sync::Arc;
use umbrage_core::{
    Backend, Cast, CastMode, Faces, Filter, Format, ImageDesc, Recipe, Shadows, Source,
};
use umbrage_wgpu::Gpu;

pub(crate) const SIDE: u32 = 40;

/// Returns a closed box of 4 m each way around the y axis, between two heights, in metres; floor
/// and plate are at 0 and 1.
pub(crate) fn column(bottom: f32, top: f32) -> Faces {
    let mut vertices = Vec::new();
    for z in [-2.0, 2.0] {
        for y in [bottom, top] {
            for x in [-2.0, 2.0] {
                vertices.push(Vec4::new(x, y, z, 1.0));
            }
        }
    }
    // Counter-clockwise seen from outside: -x, +x, -y, +y, -z, +z.
    let sides = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    let mut triangles = Vec::new();
    for [a, b, c, d] in sides {
        triangles.push([a, b, c]);
        triangles.push([a, c, d]);
    }
    Faces {
        vertices,
        triangles,
    }
}

pub(crate) fn desc(label: &'static str, format: Format) -> ImageDesc {
    ImageDesc {
        label,
        size: UVec2::splat(SIDE),
        layers: 1,
        format,
    }
}

/// Returns a recipe that counts the volumes around the surfaces visible from above, with a filter
/// that copies the counts.
pub(crate) fn counting_recipe(stage: &BackendScene, volumes: Vec<Faces>) -> Recipe {
    let mut casts = vec![Cast::nearest(0, 0, stage.space())];
    for faces in volumes {
        casts.push(Cast {
            mode: CastMode::StencilDepthFail { depth: 0 },
            source: Source::Faces(Arc::new(faces)),
            ..Cast::nearest(1, 0, stage.space())
        });
    }
    let same = Arc::new(Same(stage.numbers(Vec4::ZERO)));
    Recipe {
        images: vec![
            desc("depth", Format::Depth32),
            desc("counts", Format::Stencil8),
            desc("loaded", Format::R32),
        ],
        casts,
        filters: vec![Filter {
            kernel: same,
            inputs: vec![1],
            tables: vec![],
            output: 2,
        }],
        ..stage.recipe(SIDE)
    }
}

/// Returns the counts on the plate, on the floor within the columns, and elsewhere; checks that
/// each is uniform.
fn counts(shadows: &Shadows) -> [f32; 3] {
    let texels = &shadows.images[1].texels;
    assert_eq!(*texels, shadows.images[2].texels, "kernels load the counts");
    // Texels are 0.25 m: the plate covers 8 in the centre, columns 16.
    let at = |(x, y): (usize, usize)| texels[y * SIDE as usize + x];
    let places = [(20, 20), (13, 20), (3, 20)];
    let within =
        |x: usize, y: usize, half: usize| [x, y].iter().all(|v| (20 - half..20 + half).contains(v));
    for (i, &count) in texels.iter().enumerate() {
        let x = i % SIDE as usize;
        let y = i / SIDE as usize;
        let place = if within(x, y, 4) {
            0
        } else {
            1 + usize::from(!within(x, y, 8))
        };
        assert_eq!(count, at(places[place]), "texel {x}, {y}");
    }
    places.map(at)
}

fn render(gpu: &mut Gpu, volumes: Vec<Faces>) -> [f32; 3] {
    let stage = BackendScene::new();
    counts(&stage.render(gpu, &counting_recipe(&stage, volumes)))
}

#[test]
fn counts_tell_which_volumes_a_surface_is_in() {
    let gpu = &mut gpu();
    assert_eq!(render(gpu, vec![]), [0.0; 3]);
    assert_eq!(
        render(gpu, vec![column(-0.5, 0.5)]),
        [0.0, 1.0, 0.0],
        "around the floor"
    );
    assert_eq!(
        render(gpu, vec![column(0.5, 1.5)]),
        [1.0, 0.0, 0.0],
        "around the plate"
    );
    assert_eq!(
        render(gpu, vec![column(-0.5, 1.5)]),
        [1.0, 1.0, 0.0],
        "around both"
    );
    assert_eq!(render(gpu, vec![column(2.0, 3.0)]), [0.0; 3], "above");
    assert_eq!(render(gpu, vec![column(-2.0, -1.0)]), [0.0; 3], "below");
    assert_eq!(
        render(
            gpu,
            vec![column(-0.5, 0.5), column(-1.0, 1.5), column(0.25, 2.0)]
        ),
        [2.0, 2.0, 0.0]
    );
}

#[test]
fn faces_turned_inside_out_count_down() {
    let mut column = column(-0.5, 0.5);
    column.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    assert_eq!(render(&mut gpu(), vec![column]), [0.0, 255.0, 0.0]);
}

#[test]
fn counts_wrap_at_256() {
    let one = column(-0.5, 0.5);
    let many = Faces {
        triangles: vec![one.triangles.clone(); 300].concat(),
        ..one
    };
    assert_eq!(render(&mut gpu(), vec![many]), [0.0, 44.0, 0.0]);
}

#[test]
fn depth_is_what_it_is_without_counting() {
    let stage = BackendScene::new();
    let mut gpu = gpu();
    let plain = stage.render(&mut gpu, &stage.recipe(SIDE));
    let counted = stage.render(&mut gpu, &counting_recipe(&stage, vec![column(-0.5, 0.5)]));
    assert_eq!(counted.images[0].texels, plain.images[0].texels);
    assert_eq!(counted.mask, plain.mask, "kernels load the depth");
}

#[test]
fn a_second_frame_starts_from_zero_and_makes_nothing() {
    let stage = BackendScene::new();
    let mut gpu = gpu();
    let recipe = counting_recipe(&stage, vec![column(-0.5, 0.5)]);
    stage.render(&mut gpu, &recipe);
    let first = gpu.counters();
    assert_eq!(counts(&stage.render(&mut gpu, &recipe)), [0.0, 1.0, 0.0]);
    assert_eq!(gpu.counters(), first);
    // Count against unwritten depth: everything is at depth 1, behind all faces.
    let mut recipe = counting_recipe(&stage, vec![column(-0.5, 0.5)]);
    recipe.casts.remove(0);
    assert!(
        stage.render(&mut gpu, &recipe).images[1]
            .texels
            .iter()
            .all(|&v| v == 0.0)
    );
}

#[test]
fn casters_can_be_counted_in_layers() {
    let stage = BackendScene::new();
    let mut gpu = gpu();
    let mut recipe = counting_recipe(&stage, vec![]);
    (
        recipe.images[0].layers,
        recipe.images[1].layers,
        recipe.images[2].layers,
    ) = (2, 2, 2);
    let mode = CastMode::StencilDepthFail { depth: 0 };
    // Layer 0 has no depth, but layer 1 has. There, floor and plate are front faces that are not
    // before themselves.
    recipe.casts[0].layer = 1;
    recipe.casts.extend((0..2).map(|layer| Cast {
        mode,
        ..Cast::nearest(1, layer, stage.space())
    }));
    let images = stage.render(&mut gpu, &recipe).images;
    let (first, second) = images[1].texels.split_at(1600);
    assert!(first.iter().all(|&v| v == 0.0));
    let at = |x: usize| second[20 * SIDE as usize + x];
    assert_eq!([at(20), at(13), at(2)], [254.0, 255.0, 0.0]);
    assert_eq!(images[2].texels, images[1].texels);
}

#[test]
fn two_counts_of_one_depth_are_refused() {
    let stage = BackendScene::new();
    let mut gpu = gpu();
    let mut recipe = counting_recipe(&stage, vec![column(-0.5, 0.5)]);
    recipe.images.push(desc("more counts", Format::Stencil8));
    let other = Cast {
        image: 3,
        ..recipe.casts[1].clone()
    };
    recipe.casts.push(other);
    let error = gpu
        .render(&stage.view(), &recipe)
        .expect_err("they cannot share");
    assert!(
        error
            .to_string()
            .contains("use a separate depth image for each image of counts"),
        "{error}"
    );
}
