//! Settings over maps and biases, for comparisons and tests.

use umbrage_core::{Cascades, Fit, Layout, Split};
use umbrage_techniques::{BeyondFar, Bias, Border, MapFormat, ShadowMap, Surface};

/// Returns biases for kernels that reach `reach` texels beyond the receiver's own, and need larger
/// amounts. The standard slope bias is that for 3x3.
pub fn wide_biases(reach: f32) -> [Bias; 4] {
    [
        Bias::ADAPTIVE,
        Bias::SLOPE,
        Bias::polygon_offset(reach),
        Bias::normal_offset(reach),
    ]
}

/// Returns two of [`wide_biases`], for kernels similar to others in the list that cover the rest.
pub fn two_biases(reach: f32) -> [Bias; 2] {
    [Bias::ADAPTIVE, Bias::polygon_offset(reach)]
}

/// Returns a technique with its first bias over maps of all sides (`sizes`, texels), and with the
/// others at the middle side. This separates the effects of size and bias, with far fewer settings
/// than all pairs.
pub fn sweep<T>(sizes: &[u32], fit: Fit, biases: &[Bias], make: impl Fn(ShadowMap) -> T) -> Vec<T> {
    let (first, others) = biases.split_at(biases.len().min(1));
    let mut out = maps(sizes, fit, first, &make);
    out.extend(middle(sizes, fit, others, &make));
    out
}

/// Returns a technique at the middle map side only, with all of these biases.
pub fn middle<T>(
    sizes: &[u32],
    fit: Fit,
    biases: &[Bias],
    make: impl Fn(ShadowMap) -> T,
) -> Vec<T> {
    let size: Vec<u32> = sizes.get(sizes.len() / 2).copied().into_iter().collect();
    maps(&size, fit, biases, make)
}

/// Returns a technique over maps of all sides, with all of these biases.
pub fn maps<T>(sizes: &[u32], fit: Fit, biases: &[Bias], make: impl Fn(ShadowMap) -> T) -> Vec<T> {
    let mut out = Vec::new();
    for &size in sizes {
        for &bias in biases {
            out.push(make(ShadowMap {
                size,
                fit,
                bias,
                ..ShadowMap::default()
            }));
        }
    }
    out
}

/// Blur of moment maps that are compared on maps of all sides, texels to each side: 3x3, which has
/// the least error in most full-size scenes.
const NARROW_BLUR: u32 = 1;
/// Blur of moment maps that are compared at the middle side only, texels to each side.
const WIDE_BLUR: u32 = 3;

/// Returns a technique that blurs its map, with both blurs and the default bias. With one side
/// only, as in quick comparisons, it uses only the narrow blur. On software drivers a wide blur
/// takes as long as ten other techniques.
pub fn blurs<T>(sizes: &[u32], fit: Fit, make: impl Fn(ShadowMap, u32) -> T) -> Vec<T> {
    let bias = [Bias::ADAPTIVE];
    let mut out = sweep(sizes, fit, &bias, |map| make(map, NARROW_BLUR));
    if sizes.len() > 1 {
        out.extend(middle(sizes, fit, &bias, |map| make(map, WIDE_BLUR)));
    }
    out
}

/// Returns a technique with four cascades of half the middle map side, which take the memory of one
/// map of that side. Returns nothing for fits that don't follow the camera.
pub fn cascades<T>(sizes: &[u32], fit: Fit, bias: Bias, make: impl Fn(ShadowMap) -> T) -> Vec<T> {
    if matches!(fit, Fit::Whole | Fit::Manual { .. }) {
        return Vec::new();
    }
    let side = sizes.get(sizes.len() / 2).map(|side| (side / 2).max(1));
    let map = side.map(|size| ShadowMap {
        size,
        fit,
        bias,
        layout: Layout::Cascades(Cascades::default()),
        ..ShadowMap::default()
    });
    map.map(make).into_iter().collect()
}

/// Returns a technique with every bias, and with all biases combined, to test their interaction.
pub fn every_bias<T>(size: u32, make: impl Fn(ShadowMap) -> T) -> Vec<T> {
    let mut biases = Bias::PRESETS.map(|(_, bias)| bias).to_vec();
    biases.push(Bias {
        constant: 1e-3,
        receiver_plane: 0.05,
        ..Bias {
            normal_offset: 1.0,
            ..Bias::SLOPE
        }
    });
    maps(&[size], Fit::Tight, &biases, make)
}

/// Returns a technique with two biases, for kernels that share the depth code with another of their
/// settings.
pub fn slope_and_adaptive<T>(size: u32, make: impl Fn(ShadowMap) -> T) -> Vec<T> {
    maps(&[size], Fit::Tight, &[Bias::SLOPE, Bias::ADAPTIVE], make)
}

/// Returns every kind of map with a different code path.
pub fn kinds_of_map(size: u32) -> [ShadowMap; 8] {
    let map = ShadowMap {
        size,
        bias: Bias::CONSTANT,
        ..ShadowMap::default()
    };
    [
        ShadowMap {
            layout: Layout::Cube,
            ..map
        },
        ShadowMap {
            surface: Surface::Midpoint,
            ..map
        },
        ShadowMap {
            format: MapFormat::Depth16,
            ..map
        },
        ShadowMap {
            format: MapFormat::Rgba8,
            ..map
        },
        ShadowMap {
            border: Border::Clamp,
            beyond_far: BeyondFar::Compared,
            ..map
        },
        ShadowMap {
            layout: Layout::Cube,
            surface: Surface::Midpoint,
            format: MapFormat::Rgba8,
            ..map
        },
        ShadowMap {
            layout: Layout::Cascades(Cascades {
                count: 3,
                split: Split::Receivers,
                ..Cascades::default()
            }),
            ..map
        },
        ShadowMap {
            layout: Layout::Cascades(Cascades {
                blend: 8.0,
                ..Cascades::default()
            }),
            fit: Fit::Stable { range: 40.0 },
            ..map
        },
    ]
}

/// Returns those of [`kinds_of_map`] that comparison samplers can read.
pub fn sampled_maps(size: u32) -> Vec<ShadowMap> {
    let mut maps = kinds_of_map(size).to_vec();
    maps.retain(|map| map.surface == Surface::Nearest && map.format != MapFormat::Rgba8);
    maps
}
