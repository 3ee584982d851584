//! Tests of the effect of coarse and packed depth.

use super::MapCase;
use umbrage_core::{Backend, Extents, Fit, Light, RasterBias, ShadowTechnique};
use umbrage_cpu::Cpu;
use umbrage_techniques::{Bias, Hard, MapFilter as _, MapFormat, MapTechnique, ShadowMap};

fn hard(format: MapFormat, constant: f32, fit: Fit) -> MapTechnique<Hard> {
    Hard {}.on(ShadowMap {
        format,
        fit,
        bias: Bias {
            constant,
            ..Bias::NONE
        },
        ..ShadowMap::default()
    })
}

/// The sun's tight fit around far-range, with its depth range extended by `factor` in front of the
/// first caster and behind the last receiver.
fn stretched_fit(case: &MapCase, factor: f32) -> Fit {
    let bounds = case.geometry.bounds();
    let reach = (bounds.max - bounds.min).length() * 0.5;
    let center = bounds.center();
    let Light::Directional { direction, .. } = case.light() else {
        unreachable!("far-range has a sun")
    };
    let eye = center - direction.normalize() * reach * factor;
    let extents = Extents {
        left: -reach,
        right: reach,
        bottom: -reach,
        top: reach,
        near: 0.0,
        far: 2.0 * reach * factor,
    };
    Fit::Manual { eye, extents }
}

/// Biases in texels, with the constant for 32-bit floats (a few 2^-24 of a depth near 1). The
/// offset of casters for grids that are coarser than the CPU's is undone.
const FOR_FLOATS: Bias = Bias {
    constant: 1e-6,
    raster: TAKEN_BACK,
    ..Bias::RECEIVER_PLANE
};
const TAKEN_BACK: RasterBias = RasterBias {
    constant: 0,
    slope: -0.125,
    clamp: 0.0,
};

fn false_shadow(case: &MapCase, format: MapFormat, factor: f32) -> f64 {
    let map = ShadowMap {
        format,
        fit: stretched_fit(case, factor),
        bias: FOR_FLOATS,
        ..ShadowMap::default()
    };
    case.errors(&Hard {}.on(map)).false_shadow
}

/// With a longer depth range, the steps of 16 bits become larger in metres, and a bias that follows
/// the receiver's plane doesn't cover them. Floats have sufficient precision, packed or not.
#[test]
fn sixteen_bits_grow_acne_with_range() {
    let case = MapCase::with_name("far-range");
    for factor in [1.0, 4.0, 16.0] {
        let shares = [MapFormat::Depth32, MapFormat::Rgba8, MapFormat::Depth16]
            .map(|f| false_shadow(&case, f, factor));
        assert!(
            shares[0] < 0.5 && shares[0] == shares[1] && shares[2] > 20.0,
            "x{factor}: {shares:?}"
        );
    }
    let coarse = [1.0, 4.0, 16.0].map(|factor| false_shadow(&case, MapFormat::Depth16, factor));
    assert!(coarse[0] < coarse[1] && coarse[1] < coarse[2], "{coarse:?}");
}

/// Packing keeps every bit of depths from 1/256 on, so not one comparison changes.
#[test]
fn packed_depth_is_depth() {
    let case = MapCase::with_name("far-range");
    let technique = |format| hard(format, 1e-4, stretched_fit(&case, 2.0));
    let mut recipe = technique(MapFormat::Depth32)
        .recipe(&case.view())
        .expect("serves the sun");
    recipe.keep_images = true;
    let depth = Cpu::new().render(&case.view(), &recipe).expect("renders");
    let least = depth.images[0].texels.iter().copied().fold(1.0, f32::min);
    assert!(least >= 1.0 / 256.0, "{least}");
    assert_eq!(case.mask(&technique(MapFormat::Rgba8)), depth.mask);
    assert_ne!(
        case.mask(&technique(MapFormat::Depth16)),
        depth.mask,
        "16 bits must make a difference"
    );
}
