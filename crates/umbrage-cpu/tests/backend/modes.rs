//! Tests of casts of all sources and modes, and of images of all formats.

use crate::stage::{bits, execute_recipe, geometry, recipe, same_on_all_backends, space};
use std::sync::Arc;
use umbrage_core::{
    Cast, CastMode, Cull, Faces, Filter, FilterKernel, Format, Geometry, Image, ImageDesc, Inputs,
    Kernel, Module, RasterBias, Recipe, Source,
    glam::{UVec2, Vec3, Vec4},
};
use umbrage_cpu::Cpu;

/// Filter that writes numbers from -0.25 to 1.25, and one NaN.
#[derive(Clone, Copy, Debug)]
struct Ramp;

impl Kernel for Ramp {
    fn modules(&self) -> Vec<Module> {
        Vec::new()
    }
}

impl FilterKernel for Ramp {
    fn filter(&self, _: &Inputs<'_>, start: UVec2, _: u32, out: &mut [f32]) {
        let n = (SIZE.x * SIZE.y * 4) as f32;
        for (i, out) in out.iter_mut().enumerate() {
            *out = ((start.y * SIZE.x * 4) as usize + i) as f32 / n * 1.5 - 0.25;
        }
        out[7] = f32::NAN;
    }
}

const SIZE: UVec2 = UVec2::new(130, 75);

const DEPTH: usize = 0;
const SECOND: usize = 1;
const STEPS: usize = 2;
const COUNTS: usize = 3;
const BYTES: usize = 4;
const SECOND_STEPS: usize = 5;

/// Returns a pyramid under the sheet, and a slanted prism that intersects the ground.
fn faces() -> Arc<Faces> {
    let point = |x: f32, y: f32, z: f32| Vec4::new(x, y, z, 1.0);
    let base = [[-0.5, -0.5], [-0.5, 0.5], [0.5, 0.5], [0.5, -0.5]];
    let mut vertices: Vec<Vec4> = base.map(|[x, z]| point(x, 0.7, z)).into();
    vertices.push(point(0.0, -0.4, 0.0));
    let top = [
        point(0.8, 0.9, 0.8),
        point(1.4, 0.9, 0.8),
        point(1.0, 0.9, 1.4),
    ];
    vertices.extend(
        top.into_iter()
            .chain(top.map(|p| p + Vec4::new(-0.1, -1.9, 0.2, 0.0))),
    );
    let mut triangles = vec![[0, 1, 2], [0, 2, 3], [5, 7, 6], [8, 9, 10]];
    triangles.extend((0..4).map(|i| [(i + 1) % 4, i, 4]));
    triangles.extend(
        [[5, 7], [7, 6], [6, 5]]
            .iter()
            .flat_map(|&[a, b]| [[b, a, a + 3], [b, a + 3, b + 3]]),
    );
    Arc::new(Faces {
        vertices,
        triangles,
    })
}

/// Returns a recipe with every mode, source and format.
fn every_mode() -> Recipe {
    let image = |label, format| ImageDesc {
        label,
        size: SIZE,
        layers: 1,
        format,
    };
    let all = |image, mode| Cast {
        source: Source::Everything,
        mode,
        ..Cast::nearest(image, 0, space())
    };
    let bias = RasterBias {
        constant: 3,
        slope: 1.5,
        clamp: 0.0,
    };
    let counts = Source::Faces(faces());
    let output = BYTES;
    Recipe {
        images: vec![
            image("depth", Format::Depth32),
            image("second", Format::Depth32),
            image("steps", Format::Depth16),
            image("counts", Format::Stencil8),
            image("bytes", Format::Rgba8),
            image("second steps", Format::Depth16),
        ],
        casts: vec![
            all(DEPTH, CastMode::Depth),
            all(SECOND, CastMode::DepthPeel(DEPTH)),
            Cast {
                bias,
                cull: Cull::Back,
                ..all(STEPS, CastMode::Depth)
            },
            Cast {
                cull: Cull::Back,
                ..all(SECOND_STEPS, CastMode::DepthPeel(STEPS))
            },
            Cast {
                source: counts,
                ..all(COUNTS, CastMode::StencilDepthFail { depth: DEPTH })
            },
        ],
        filters: vec![Filter {
            kernel: Arc::new(Ramp),
            inputs: vec![DEPTH],
            tables: Vec::new(),
            output,
        }],
        receive: umbrage_core::Receive {
            inputs: vec![DEPTH],
            ..recipe().receive
        },
        ..recipe()
    }
}

#[test]
fn threads_and_instructions_change_no_bit_of_any_mode() {
    let shadows = same_on_all_backends(&every_mode());
    for image in &shadows.images {
        let mut values = bits(&image.texels);
        values.sort_unstable();
        values.dedup();
        let least = if image.desc.format == Format::Stencil8 {
            2
        } else {
            100
        };
        assert!(
            values.len() >= least,
            "{} has {} values",
            image.desc.label,
            values.len()
        );
    }
}

#[test]
fn the_second_layer_lies_behind_the_first() {
    let images = execute_recipe(&mut Cpu::new(), &every_mode()).images;
    let pairs = || images[DEPTH].texels.iter().zip(&images[SECOND].texels);
    assert!(pairs().all(|(a, b)| a < b || *b == 1.0));
    assert!(
        pairs().filter(|(_, b)| **b < 1.0).count() > 200,
        "the sheet is above the ground"
    );
}

#[test]
fn sixteen_bits_are_the_same_depth_in_whole_steps() {
    let mut recipe = every_mode();
    recipe.casts[STEPS] = Cast {
        image: STEPS,
        ..recipe.casts[DEPTH].clone()
    };
    let images = execute_recipe(&mut Cpu::new(), &recipe).images;
    for (z, steps) in images[DEPTH].texels.iter().zip(&images[STEPS].texels) {
        // Half a step, plus the rounding of the division to f32.
        assert!(
            (z - steps).abs() <= 0.5 / 65_535.0 + f32::EPSILON,
            "{z} became {steps}"
        );
        let k = f64::from(*steps) * 65_535.0;
        assert!((k - k.round()).abs() < 1e-2, "{steps} is {k} steps");
    }
}

#[test]
fn counts_are_the_volumes_that_end_behind_the_surface() {
    let shadows = execute_recipe(&mut Cpu::new(), &every_mode());
    let counts = &shadows.images[COUNTS].texels;
    let of = |n: f32| counts.iter().filter(|&&c| c == n).count();
    // The pyramid is behind the sheet, front and back.
    assert!(of(1.0) > 30, "ground within the prism");
    assert_eq!(
        of(0.0) + of(1.0),
        counts.len(),
        "closed volumes are left as often as they are entered"
    );
}

#[test]
fn bytes_are_rounded_to_what_shaders_load() {
    let shadows = execute_recipe(&mut Cpu::new(), &every_mode());
    let texels = &shadows.images[BYTES].texels;
    let k = |v: f32| (v * 255.0).round() as i32;
    assert!(
        texels
            .iter()
            .all(|&v| v == k(v) as f32 * (1.0 / 255.0) && (0..=255).contains(&k(v)))
    );
    assert!((0..=255).all(|n| texels.iter().any(|&v| k(v) == n)));
    assert_eq!(texels[7], 0.0, "NaN becomes 0");
}

#[test]
fn sources_draw_what_they_say() {
    let geometry = geometry();
    let mut cpu = Cpu::new();
    let casters = Cast::nearest(0, 0, space());
    let everything = Cast {
        source: Source::Everything,
        ..casters.clone()
    };
    let vertices = geometry.positions().iter().map(|p| p.extend(1.0)).collect();
    let faces = Arc::new(Faces {
        vertices,
        triangles: geometry.triangles().to_vec(),
    });
    let faces = Cast {
        source: Source::Faces(faces),
        ..casters.clone()
    };
    let mut draw =
        |geometry: &Geometry, cast| bits(&cpu.cast(geometry, cast, SIZE).unwrap().texels);
    let expected = draw(&geometry, &casters);
    assert!(expected.iter().any(|&z| z != 1.0_f32.to_bits()));
    let none = geometry.without_casters();
    assert!(
        draw(&none, &casters)
            .iter()
            .all(|&z| z == 1.0_f32.to_bits())
    );
    assert_eq!(draw(&none, &everything), expected);
    assert_eq!(draw(&Geometry::default(), &faces), expected);
}

#[test]
fn what_is_read_before_it_is_drawn_is_clear() {
    let mut recipe = every_mode();
    recipe.casts.swap(0, 1);
    let mut cpu = Cpu::new();
    let first = execute_recipe(&mut cpu, &recipe).images;
    assert!(
        first[SECOND].texels.iter().all(|&z| z == 1.0),
        "nothing is behind the far plane"
    );
    assert_eq!(
        bits(&execute_recipe(&mut cpu, &recipe).images[SECOND].texels),
        bits(&first[SECOND].texels)
    );
}

#[test]
fn replayed_casts_give_what_the_whole_gave() {
    let mut cpu = Cpu::new();
    let mut recipe = every_mode();
    // A second cast into a layer continues from the first.
    recipe.casts.push(Cast {
        source: Source::Faces(faces()),
        ..recipe.casts[SECOND].clone()
    });
    let whole = execute_recipe(&mut cpu, &recipe).images;
    let spoilt = |image: &Image| Image::filled_with(image.desc, 0.625);
    let mut images: Vec<Image> = whole.iter().map(spoilt).collect();
    for (index, cast) in recipe.casts.iter().enumerate() {
        images[cast.image] = cpu
            .replay_cast(&geometry(), &recipe, index, &images)
            .unwrap();
    }
    for (a, b) in images
        .iter()
        .zip(&whole)
        .filter(|(image, _)| image.desc.format != Format::Rgba8)
    {
        assert!(bits(&a.texels) == bits(&b.texels), "{}", a.desc.label);
    }
    images[DEPTH].texels.fill(0.0);
    let other = cpu
        .replay_cast(&geometry(), &recipe, SECOND, &images)
        .unwrap();
    assert!(
        bits(&other.texels) != bits(&whole[SECOND].texels),
        "the other image is read"
    );
}

#[test]
fn errors_tell_what_cannot_be_cast() {
    let mut cpu = Cpu::new();
    let geometry = geometry();
    let recipe = every_mode();
    let images = execute_recipe(&mut cpu, &recipe).images;
    let refused = |result: Result<Image, umbrage_core::BackendError>, text: &str| {
        let error = result.unwrap_err().to_string();
        assert!(error.contains(text), "{error}");
    };
    let mut itself = recipe.clone();
    itself.casts[SECOND].mode = CastMode::DepthPeel(SECOND);
    refused(
        cpu.replay_cast(&geometry, &itself, 1, &images),
        "another depth image",
    );
    refused(cpu.replay_cast(&geometry, &recipe, 9, &images), "number 9");
    refused(
        cpu.replay_cast(&geometry, &recipe, 0, &images[1..]),
        "images",
    );
    refused(
        cpu.cast(&geometry, &recipe.casts[SECOND], SIZE),
        "replay_cast",
    );
    let hole = Faces {
        vertices: vec![Vec3::ZERO.extend(1.0)],
        triangles: vec![[0, 0, 1]],
    };
    let hole = Cast {
        source: Source::Faces(Arc::new(hole)),
        ..recipe.casts[0].clone()
    };
    refused(cpu.cast(&geometry, &hole, SIZE), "beyond their 1 vertices");
}
