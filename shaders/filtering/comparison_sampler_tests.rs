use crate::{
    filtering::{
        bilinear_weights,
        comparison_sampler::{Axis, Samples, WEIGHT_ERROR},
    },
    shadow_map::{Border, coord::*, layers::*, texel_compare::*},
    techniques::{
        pcf_hardware::{HardwareKernel, HardwareUniforms},
        pcf_merged::{MergedKernel, MergedUniforms},
    },
};
use glam::{Mat4, UVec2, Vec2, Vec3, Vec4};
use umbrage_core::{Format, Image, ImageDesc, Inputs, ReceiveKernel, Simd, Span};

const SIZE: i32 = 23;

fn layer(receiver_plane: f32) -> MapLayer {
    MapLayer {
        clip_from_world: Mat4::IDENTITY,
        texel: 1.0,
        far: 1.0,
        constant: 0.0,
        slope: 0.0,
        slope_min: 0.0,
        normal_offset: 0.0,
        receiver_plane,
        deepest_tap: 1.0,
        depth_in_texels: 1.0,
        deepest: f32::MAX,
    }
}

/// Clip space equals world space here: x and y are -1..1 across the map, z is the depth.
fn lookup(border: Border, receiver_plane: f32) -> ShadowMapUniforms {
    ShadowMapUniforms {
        layer_count: 1,
        packed: 0,
        clamped: u32::from(border == Border::Clamp),
        pick_reach: 0.0,
        blend: 0.0,
        layers: [layer(receiver_plane); MAX_LAYERS],
        light: Vec4::NEG_Z,
        size: SIZE as f32,
        sample_gain: 1.0,
    }
}

fn noise(i: u32) -> f32 {
    let x = i.wrapping_mul(0x9E37_79B9);
    let x = (x ^ (x >> 15)).wrapping_mul(0x85EB_CA6B);
    ((x ^ (x >> 13)) >> 8) as f32 / 16_777_216.0
}

fn image(depth: impl Fn(i32, i32) -> f32) -> Image {
    let size = UVec2::splat(SIZE as u32);
    let texels = (0..SIZE * SIZE)
        .map(|i| depth(i % SIZE, i / SIZE))
        .collect();
    Image {
        desc: ImageDesc {
            label: "test",
            size,
            layers: 1,
            format: Format::Depth32,
        },
        texels,
    }
}

fn noisy() -> Image {
    image(|x, y| noise((y * SIZE + x) as u32))
}

/// Returns the visibility at points (texels) with these depths and this normal.
fn visibilities_at(
    kernel: &dyn ReceiveKernel,
    image: &Image,
    points: &[Vec3],
    n: Vec3,
    simd: Simd,
) -> Vec<f32> {
    let column = |f: &dyn Fn(&Vec3) -> f32| points.iter().map(f).collect::<Vec<f32>>();
    let side = SIZE as f32;
    let x = column(&|p| p.x / side * 2.0 - 1.0);
    let y = column(&|p| 1.0 - p.y / side * 2.0);
    let z = column(&|p| p.z);
    let normal = n.to_array().map(|v| vec![v; points.len()]);
    let triangle = vec![0; points.len()];
    let [nx, ny, nz] = &normal;
    let span = Span {
        first: UVec2::ZERO,
        x: &x,
        y: &y,
        z: &z,
        nx,
        ny,
        nz,
        triangle: &triangle,
    };
    let mut out = vec![9.0; points.len()];
    kernel.receive(
        &Inputs {
            images: &[image.view()],
            simd,
        },
        &span,
        &mut out,
    );
    out
}

/// Returns points on and around the map, at random depths.
fn points() -> Vec<Vec3> {
    let at = |i: u32| noise(i) * (SIZE as f32 + 8.0) - 4.0;
    (0..4000)
        .map(|i| Vec3::new(at(3 * i), at(3 * i + 1), noise(7 * i + 5)))
        .collect()
}

fn hardware(samples: i32, border: Border) -> HardwareKernel {
    HardwareKernel(HardwareUniforms {
        lookup: lookup(border, 0.0),
        samples,
    })
}

fn merged_kernel(radius: i32, border: Border) -> MergedKernel {
    let rows = bilinear_weights::merged_rows(radius as usize);
    MergedKernel(MergedUniforms {
        lookup: lookup(border, 0.0),
        rows,
        samples: radius + 1,
    })
}

/// Computes the filter explicitly over texels: each has a tent's share of the row's two nearest
/// weights.
fn explicit(image: &Image, row: &[f32], border: Border, p: Vec3) -> f64 {
    let reach = row.len() as f64 / 2.0 + 1.0;
    let weight = |d: f64| -> f64 {
        let tent =
            |i: usize| (1.0 - (d - (i as f64 - (row.len() as f64 - 1.0) / 2.0)).abs()).max(0.0);
        row.iter()
            .enumerate()
            .map(|(i, k)| f64::from(*k) * tent(i))
            .sum()
    };
    let answer = |x: i32, y: i32| {
        let inside = |v: i32| v.clamp(0, SIZE - 1);
        let adjacent = (x, y) != (inside(x), inside(y));
        let lit = p.z <= image.view().load(inside(x), inside(y), 0);
        f64::from(u8::from(lit || (adjacent && border == Border::Lit)))
    };
    let range = |at: f32| {
        (f64::from(at) - 0.5 - reach).floor() as i32..=(f64::from(at) - 0.5 + reach).ceil() as i32
    };
    let mut lit = 0.0;
    let mut total = 0.0;
    for y in range(p.y) {
        for x in range(p.x) {
            let w = weight(f64::from(x) + 0.5 - f64::from(p.x))
                * weight(f64::from(y) + 0.5 - f64::from(p.y));
            (lit, total) = (lit + w * answer(x, y), total + w);
        }
    }
    lit / total
}

/// Returns the greatest difference from the explicit filter.
fn kernel_error(kernel: &dyn ReceiveKernel, row: &[f32], border: Border) -> f64 {
    let image = noisy();
    let points = points();
    let mask = visibilities_at(kernel, &image, &points, Vec3::Z, Simd::Native);
    assert!(mask.iter().all(|v| (0.0..=1.0).contains(v)));
    let wrong = |(p, v): (&Vec3, &f32)| (f64::from(*v) - explicit(&image, row, border, *p)).abs();
    points.iter().zip(&mask).map(wrong).fold(0.0, f64::max)
}

/// Rounding bound. Coordinates up to 27 texels round to 2^-20, when divided and multiplied by the
/// map's side and twice in the sampler. Each texel's weight follows them with slope 1. Comparisons
/// differ by 1 along each of two axes.
const ROUNDING: f64 = 2.0 * 4.0 / 1_048_576.0;

#[test]
fn square_of_samples_is_the_sum_over_texels() {
    for border in [Border::Lit, Border::Clamp] {
        for samples in 1..=4 {
            let off = kernel_error(
                &hardware(samples, border),
                &vec![1.0; samples as usize],
                border,
            );
            assert!(off < ROUNDING, "{samples} {border:?}: {off}");
        }
    }
}

#[test]
fn merged_samples_are_the_sum_over_texels() {
    for border in [Border::Lit, Border::Clamp] {
        for radius in 1..=3 {
            let off = kernel_error(
                &merged_kernel(radius, border),
                &bilinear_weights::filter_row(radius as usize),
                border,
            );
            assert!(off < ROUNDING, "{radius} {border:?}: {off}");
        }
    }
}

#[test]
fn spoilt_weights_are_caught() {
    let mut spoilt = merged_kernel(2, Border::Lit);
    spoilt.0.rows[1].x *= 1.01;
    assert!(
        kernel_error(&spoilt, &bilinear_weights::filter_row(2), Border::Lit) > 100.0 * ROUNDING
    );
    assert!(
        kernel_error(
            &merged_kernel(2, Border::Lit),
            &[1.0, 4.0, 6.0, 4.0, 1.0],
            Border::Lit
        ) > 100.0 * ROUNDING
    );
    assert!(kernel_error(&hardware(2, Border::Lit), &[1.0, 1.0], Border::Clamp) > 100.0 * ROUNDING);
}

#[test]
fn lanes_equal_the_plain_loop() {
    let image = noisy();
    let mut in_lanes = 0;
    for p in points() {
        let l = ShadowCoord {
            texel: p.truncate(),
            depth: p.z,
            deepest: p.z.max(1.0),
            covered: true,
            ..ShadowCoord::default()
        };
        let map = lookup(Border::Lit, 0.0).map(&image.view());
        in_lanes += u32::from(same::<2, 1>(map, &l)) + u32::from(same::<3, 1>(map, &l));
        in_lanes += u32::from(same::<3, 2>(map, &l)) + u32::from(same::<4, 2>(map, &l));
    }
    assert!(in_lanes > 3000, "only {in_lanes} lookups ran in lanes");
}

/// Returns whether the lookup runs in lanes, where it must give the same bits.
fn same<const N: usize, const STRIDE: usize>(map: DepthMap<'_>, l: &ShadowCoord) -> bool {
    let axis = |at: f32| Axis {
        at: std::array::from_fn(|i| {
            at + ((STRIDE * i) as f32 + noise(i as u32) * (STRIDE - 1) as f32)
        }),
        weight: std::array::from_fn(|i| {
            if i < N {
                1.0 + noise(i as u32 + 9)
            } else {
                0.0
            }
        }),
    };
    let samples = Samples::<N, STRIDE, false> { map };
    let x = axis(l.texel.x);
    let y = axis(l.texel.y);
    let lanes = samples.in_lanes(l, &x, &y);
    lanes
        .inspect(|lanes| {
            assert_eq!(
                lanes.to_bits(),
                samples.one_by_one(l, &x, &y).to_bits(),
                "{l:?}"
            )
        })
        .is_some()
}

#[test]
fn instructions_do_not_matter() {
    let image = noisy();
    let points = points();
    for kernel in [
        &merged_kernel(3, Border::Lit) as &dyn ReceiveKernel,
        &hardware(3, Border::Clamp),
    ] {
        let [a, b] = [Simd::Native, Simd::Baseline]
            .map(|simd| visibilities_at(kernel, &image, &points, Vec3::Z, simd));
        assert_eq!(a, b);
    }
}

/// Around a map that holds depth 0, everything is lit, or dark if the edge repeats.
#[test]
fn borders() {
    let black = image(|_, _| 0.0);
    let far = [
        Vec3::new(-3.0, 5.0, 0.5),
        Vec3::new(90.0, 5.0, 0.5),
        Vec3::new(5.0, -1e9, 0.5),
    ];
    for (border, visibility) in [(Border::Lit, 1.0), (Border::Clamp, 0.0)] {
        assert_eq!(
            visibilities_at(&hardware(3, border), &black, &far, Vec3::Z, Simd::Native),
            [visibility; 3]
        );
    }
    // A sample a quarter of a texel within the edge contains a quarter of the border.
    let near = [
        Vec3::new(0.25, 5.5, 0.5),
        Vec3::new(SIZE as f32 - 0.25, 5.5, 0.5),
        Vec3::new(0.0, 0.0, 0.5),
    ];
    let mask = visibilities_at(
        &hardware(1, Border::Lit),
        &black,
        &near,
        Vec3::Z,
        Simd::Native,
    );
    assert!(
        [0.25, 0.25, 0.75]
            .iter()
            .zip(&mask)
            .all(|(a, b)| (a - b).abs() < 1e-5),
        "{mask:?}"
    );
}

/// A sloping plane, stored exactly at texel centres, is fully lit if its depth is followed. It is
/// not if its depth isn't followed or the footprint's own reach is ignored.
#[test]
fn receiver_planes_are_free_of_acne() {
    let slope = Vec2::new(0.011, -0.007);
    let depth = |at: Vec2| 0.5 + slope.x * (at.x - 11.0) + slope.y * (at.y - 11.0);
    let plane = image(|x, y| depth(Vec2::new(x as f32 + 0.5, y as f32 + 0.5)));
    // Allow for rounding: depths near .5, coordinates near 20.
    let on_plane = |p: &Vec3| p.truncate().extend(depth(p.truncate()) - 1e-6);
    let inside = |p: &&Vec3| {
        p.truncate().min_element() > 4.0 && p.truncate().max_element() < SIZE as f32 - 4.0
    };
    let points: Vec<Vec3> = points().iter().filter(inside).map(on_plane).collect();
    // z = slope . texels, with texels of 2 / SIZE and y upwards.
    let n = Vec3::new(
        -slope.x * SIZE as f32 / 2.0,
        slope.y * SIZE as f32 / 2.0,
        1.0,
    )
    .normalize();
    let acne = |receiver_plane: f32, n: Vec3| {
        let mut kernels = (hardware(3, Border::Lit), merged_kernel(3, Border::Lit));
        kernels.0.0.lookup.layers = [layer(receiver_plane); MAX_LAYERS];
        kernels.1.0.lookup.layers = [layer(receiver_plane); MAX_LAYERS];
        let masks = [&kernels.0 as &dyn ReceiveKernel, &kernels.1]
            .map(|k| visibilities_at(k, &plane, &points, n, Simd::Native));
        masks.map(|mask| mask.iter().filter(|v| **v < 1.0).count())
    };
    assert_eq!(acne(0.1, n), [0, 0]);
    assert!(
        acne(0.0, n).iter().all(|dark| *dark > points.len() / 2),
        "without a bias there must be acne"
    );
    assert!(
        acne(0.1, Vec3::Z)
            .iter()
            .all(|dark| *dark > points.len() / 2),
        "another plane must cause acne"
    );
    let l = ShadowCoord {
        texel: Vec2::new(9.9, 9.9),
        depth: depth(Vec2::new(9.9, 9.9)),
        gradient: slope,
        ..ShadowCoord::default()
    };
    let reference = bilinear_weights::reference_depth(l.depth, slope, 1.0, 1.0, Vec2::ZERO);
    let least =
        [(9.5, 9.5), (10.5, 9.5), (9.5, 10.5), (10.5, 10.5)].map(|(x, y)| depth(Vec2::new(x, y)));
    assert!(least.iter().all(|d| reference < *d) && least.iter().any(|d| l.depth > *d));
}

/// Weights truncated to 8 bits stay within the bound, and the bound is tight.
#[test]
fn weights_of_chips_stay_within_the_bound() {
    let cut = |v: f32| (v * 256.0).floor() / 256.0;
    let blend = |c: [f32; 4], s: f32, t: f32| {
        let top = c[0] + (c[1] - c[0]) * s;
        let bottom = c[2] + (c[3] - c[2]) * s;
        top + (bottom - top) * t
    };
    let off = |i: u32| {
        let lit: [f32; 4] = std::array::from_fn(|k| (i >> k & 1) as f32);
        let s = noise(2 * i);
        let t = noise(2 * i + 1);
        (blend(lit, s, t) - blend(lit, cut(s), cut(t))).abs()
    };
    let most = (0..200_000).map(off).fold(0.0, f32::max);
    assert!(most <= WEIGHT_ERROR && most > 0.9 * WEIGHT_ERROR, "{most}");
}
