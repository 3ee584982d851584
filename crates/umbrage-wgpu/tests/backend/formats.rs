//! Tests of image formats with few bits: returned images equal what shaders load, and so do images
//! passed in.

use crate::{
    kernels::{Paint, Same, kernel},
    scene::{BackendScene, gpu},
};
use glam::{UVec2, Vec4};
use std::sync::Arc;
use umbrage_core::{Cast, Filter, FilterKernel, Format, Image, ImageDesc, Inputs, Recipe};

const SIDE: u32 = 50;

fn desc(label: &'static str, format: Format) -> ImageDesc {
    ImageDesc {
        label,
        size: UVec2::splat(SIDE),
        layers: 1,
        format,
    }
}

/// Returns a recipe that casts into 32 and into 16 bits, with a filter that copies the latter.
fn two_depths(stage: &BackendScene) -> Recipe {
    let same = Same(stage.numbers(Vec4::ZERO));
    Recipe {
        images: vec![
            desc("fine", Format::Depth32),
            desc("coarse", Format::Depth16),
            desc("loaded", Format::R32),
        ],
        casts: (0..2)
            .map(|image| Cast::nearest(image, 0, stage.tilted_space()))
            .collect(),
        filters: vec![Filter {
            kernel: Arc::new(same),
            inputs: vec![1],
            tables: vec![],
            output: 2,
        }],
        ..stage.recipe(SIDE)
    }
}

#[test]
fn depth_of_16_bits_is_rounded_depth_of_32() {
    let stage = BackendScene::new();
    let [fine, coarse, loaded] =
        <[Image; 3]>::try_from(stage.render(&mut gpu(), &two_depths(&stage)).images)
            .expect("three images were requested");
    assert_eq!(
        coarse.texels, loaded.texels,
        "what is handed out is what shaders load"
    );
    let mut off = 0;
    for (fine, coarse) in fine.texels.iter().zip(&coarse.texels) {
        let fine = f64::from(*fine) * 65_535.0;
        let coarse = f64::from(*coarse) * 65_535.0;
        // A step's float has a relative error of at most 2^-23.
        assert!(
            (coarse - coarse.round()).abs() <= coarse * 2.0_f64.powi(-23),
            "{coarse} is no whole step"
        );
        // The driver rounds the product to a float before it rounds to a step: 2^-8 of a step at
        // most.
        assert!(
            (fine - coarse.round()).abs() <= 0.5 + 1.0 / 256.0,
            "{fine} became {coarse}"
        );
        off += usize::from((fine - coarse).abs() > 0.1);
    }
    assert!(
        off > SIDE as usize * 10,
        "only {off} texels were rounded by much"
    );
}

/// Mesa's software driver rounds the product to a float and then to a step, and loads the step
/// times a float.
#[test]
fn the_pinned_driver_rounds_depth_by_a_known_rule() {
    let stage = BackendScene::new();
    let mut gpu = gpu();
    if !gpu.promises_bits() {
        println!("another driver: only its tolerance is tested");
        return;
    }
    let mut fine = vec![];
    let mut coarse = vec![];
    for space in [stage.tilted_space(), stage.camera.space()] {
        let mut recipe = two_depths(&stage);
        recipe.casts.iter_mut().for_each(|cast| cast.space = space);
        let images = stage.render(&mut gpu, &recipe).images;
        fine.extend_from_slice(&images[0].texels);
        coarse.extend_from_slice(&images[1].texels);
    }
    let rule = |z: &f32| (z * 65_535.0).round_ties_even() * (1.0 / 65_535.0);
    assert_eq!(coarse, fine.iter().map(rule).collect::<Vec<_>>());
    let quotient = |z: &f32| (z * 65_535.0).round_ties_even() / 65_535.0;
    assert_ne!(
        coarse,
        fine.iter().map(quotient).collect::<Vec<_>>(),
        "the comparison must notice"
    );
}

/// On that driver, a unit of constant bias is two steps of 16 bits.
#[test]
fn the_pinned_driver_biases_16_bits_by_two_steps_a_unit() {
    let stage = BackendScene::new();
    let mut gpu = gpu();
    if !gpu.promises_bits() {
        println!("another driver: the API leaves the unit to it");
        return;
    }
    for constant in [0, 1, 3, 1000] {
        let mut recipe = two_depths(&stage);
        recipe.casts[1].space = stage.space();
        recipe.casts[1].bias.constant = constant;
        let images = stage.render(&mut gpu, &recipe).images;
        // The floor, at depth 0.5, next to the plate.
        let floor = images[1].texels[8 * SIDE as usize + 8];
        assert_eq!((floor * 65_535.0).round() as i32, 32_768 + 2 * constant);
    }
}

#[test]
fn bytes_of_colour_are_what_shaders_load() {
    let stage = BackendScene::new();
    // Paint x, y, layer and 1, all times 1/100: at most 1 for all of the 50 columns.
    let paint = Paint(stage.numbers(Vec4::splat(0.01)));
    let same = Same(stage.numbers(Vec4::ZERO));
    let recipe = Recipe {
        images: vec![desc("bytes", Format::Rgba8), desc("loaded", Format::Rgba32)],
        casts: Vec::new(),
        filters: vec![
            Filter {
                kernel: Arc::new(paint),
                inputs: vec![],
                tables: vec![],
                output: 0,
            },
            Filter {
                kernel: Arc::new(same),
                inputs: vec![0],
                tables: vec![],
                output: 1,
            },
        ],
        ..stage.recipe(SIDE)
    };
    let images = stage.render(&mut gpu(), &recipe).images;
    assert_eq!(images[0].texels, images[1].texels);
    for (i, texel) in images[0].texels.chunks_exact(4).enumerate() {
        let painted = [(i % 50) as f32, (i / 50) as f32, 0.0, 1.0];
        for (have, painted) in texel.iter().zip(painted) {
            let step = have * 255.0;
            let painted = painted * 0.01 * 255.0;
            assert!(
                (step - step.round()).abs() < 1e-4,
                "texel {i}: {step} is no whole step"
            );
            // Halves may be rounded either way.
            assert!(
                (step - painted).abs() < 0.5001,
                "texel {i} is {step}, painted {painted}"
            );
        }
    }
}

kernel!(
    Scatter,
    "fn filter_texel(texel: vec2i, layer: i32) -> vec4f {
        let h = (u32(texel.y) * 50u + u32(texel.x)) * 0x9e3779b9u;
        return vec4f(f32(h >> 8u) / 16777216.0, f32(h & 0xffffu) / 65535.0, 0.5 / 255.0, 1.5 / 255.0);
    }"
);

impl FilterKernel for Scatter {
    fn filter(&self, _: &Inputs<'_>, _: UVec2, _: u32, out: &mut [f32]) {
        out.fill(0.0);
    }
}

/// The pinned driver rounds bytes of colour like depth.
#[test]
fn the_pinned_driver_rounds_colour_by_a_known_rule() {
    let stage = BackendScene::new();
    let mut gpu = gpu();
    if !gpu.promises_bits() {
        println!("another driver: only its tolerance is tested");
        return;
    }
    let scatter = |output| Filter {
        kernel: Arc::new(Scatter(stage.numbers(Vec4::ZERO))),
        inputs: vec![],
        tables: vec![],
        output,
    };
    let recipe = Recipe {
        images: vec![desc("floats", Format::Rgba32), desc("bytes", Format::Rgba8)],
        casts: vec![],
        filters: vec![scatter(0), scatter(1)],
        ..stage.recipe(SIDE)
    };
    let images = stage.render(&mut gpu, &recipe).images;
    let rule = |v: &f32| (v * 255.0).round_ties_even() * (1.0 / 255.0);
    assert_eq!(
        images[1].texels,
        images[0].texels.iter().map(rule).collect::<Vec<_>>()
    );
    // Negative controls: the comparison detects other roundings, of halves and of the quotient.
    let other_halves = |v: &f32| (v * 255.0 + 0.5).floor() * (1.0 / 255.0);
    let quotient = |v: &f32| (v * 255.0).round_ties_even() / 255.0;
    assert_ne!(
        images[1].texels,
        images[0]
            .texels
            .iter()
            .map(other_halves)
            .collect::<Vec<_>>()
    );
    assert_ne!(
        images[1].texels,
        images[0].texels.iter().map(quotient).collect::<Vec<_>>()
    );
}

kernel!(
    Spread,
    // Of both signs and beyond 1, and halves of steps.
    "fn filter_texel(texel: vec2i, layer: i32) -> vec4f {
        let h = (u32(texel.y) * 50u + u32(texel.x)) * 0x9e3779b9u;
        let any = f32(h >> 8u) / 8388608.0 - 0.5;
        return vec4f(any, f32(h & 0xffffu) / 65535.0, (f32(h >> 20u) + 0.5) / 65535.0, 1.0 - any);
    }"
);

impl FilterKernel for Spread {
    fn filter(&self, _: &Inputs<'_>, _: UVec2, _: u32, out: &mut [f32]) {
        out.fill(0.0);
    }
}

/// Filters write the nearest 16-bit steps on every device that rounds sums and products to floats,
/// independent of its texture conversion.
#[test]
fn filters_write_the_nearest_step_of_16_bits() {
    let stage = BackendScene::new();
    let spread = |output| Filter {
        kernel: Arc::new(Spread(stage.numbers(Vec4::ZERO))),
        inputs: vec![],
        tables: vec![],
        output,
    };
    let recipe = Recipe {
        images: vec![
            desc("floats", Format::Rgba32),
            desc("four", Format::Rgba16),
            desc("two", Format::Rg16),
        ],
        casts: vec![],
        filters: vec![spread(0), spread(1), spread(2)],
        ..stage.recipe(SIDE)
    };
    let images = stage.render(&mut gpu(), &recipe).images;
    let rule = |v: &f32| (v.clamp(0.0, 1.0) * 65_535.0 + 0.5).floor() * (1.0 / 65_535.0);
    let expected: Vec<f32> = images[0].texels.iter().map(rule).collect();
    assert_eq!(images[1].texels, expected);
    let expected_pairs: Vec<f32> = expected
        .chunks_exact(4)
        .flat_map(|texel| [texel[0], texel[1]])
        .collect();
    assert_eq!(images[2].texels, expected_pairs);
    // Negative control: the comparison detects other roundings.
    let other_halves =
        |v: &f32| (v.clamp(0.0, 1.0) * 65_535.0).round_ties_even() * (1.0 / 65_535.0);
    let other: Vec<f32> = images[0].texels.iter().map(other_halves).collect();
    assert_ne!(images[1].texels, other);
    // Two and four channels of 16 bits.
    let bytes = [1, 2].map(|i| recipe.images[i].bytes());
    let texels = u64::from(SIDE * SIDE);
    assert_eq!(bytes, [8 * texels, 4 * texels]);
}

/// Returns all integer steps that fit into the image, times `unit`.
fn steps(desc: ImageDesc, count: usize, unit: f32) -> Image {
    let texels = (0..desc.floats() as usize)
        .map(|i| (i * 37 % count) as f32 * unit)
        .collect();
    Image { desc, texels }
}

/// Returns what a filter loads from a given image.
fn loaded_image(given: &Image, loaded: Format) -> Image {
    let stage = BackendScene::new();
    let same = Same(stage.numbers(Vec4::ZERO));
    let output = ImageDesc {
        format: loaded,
        ..given.desc
    };
    let recipe = Recipe {
        images: vec![stage.recipe(4).images[0], given.desc, output],
        filters: vec![Filter {
            kernel: Arc::new(same),
            inputs: vec![1],
            tables: vec![],
            output: 2,
        }],
        ..stage.recipe(4)
    };
    let images = [
        Image::filled_with(recipe.images[0], 1.0),
        given.clone(),
        Image::filled_with(output, 0.0),
    ];
    gpu()
        .replay_filter(&recipe, 0, &images)
        .expect("the recipe is valid")
}

#[test]
fn given_images_of_all_formats_are_loaded_as_given() {
    let size = UVec2::new(21, 13);
    for (format, loaded, count, unit) in [
        (Format::Depth32, Format::R32, 3000, 1.0 / 3000.0),
        (Format::Depth16, Format::R32, 65_536, 1.0 / 65_535.0),
        (Format::Stencil8, Format::R32, 256, 1.0),
        (Format::Rgba8, Format::Rgba32, 256, 1.0 / 255.0),
        (Format::Rg16, Format::Rg32, 65_536, 1.0 / 65_535.0),
        (Format::Rgba16, Format::Rgba32, 65_536, 1.0 / 65_535.0),
        (Format::R32, Format::R32, 3000, 7.0),
        (Format::Rgba32, Format::Rgba32, 3000, -7.0),
    ] {
        for layers in [1, 3] {
            let given = steps(
                ImageDesc {
                    label: "given",
                    size,
                    layers,
                    format,
                },
                count,
                unit,
            );
            let once = loaded_image(&given, loaded);
            for (have, wanted) in once.texels.iter().zip(&given.texels) {
                // Drivers differ in the last bit of a step's float.
                assert!(
                    (have - wanted).abs() <= f32::EPSILON * wanted.abs(),
                    "{format:?}: {have} for {wanted}"
                );
            }
            let again = loaded_image(
                &Image {
                    desc: given.desc,
                    texels: once.texels.clone(),
                },
                loaded,
            );
            assert_eq!(
                again.texels, once.texels,
                "{format:?}: what was handed out is loaded bit for bit"
            );
            assert!(once.texels.iter().any(|v| *v != once.texels[0]));
        }
    }
}

#[test]
fn counts_that_nothing_writes_are_zero() {
    let stage = BackendScene::new();
    let mut recipe = stage.recipe(8);
    recipe.images.push(desc("counts", Format::Stencil8));
    let images = stage.render(&mut gpu(), &recipe).images;
    assert_eq!(images[1].texels, vec![0.0; 2500]);
    assert_eq!(recipe.images[1].bytes(), 2500, "a count takes a byte");
}
