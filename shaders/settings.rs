//! Which settings of each technique are worth comparing, and which reach every path of its code.

use crate::{
    Midpoint, Pattern, PcfDisc, PcfDithered, PcfHardware, PcfMerged, Planar, SecondDepth,
    ShadowVolumes, Traced, Unshadowed,
    catalogue::Settings,
    shadow_map::{BeyondFar, Bias, Border, MapFormat, ShadowMap, Surface},
    techniques::{hard::Hard, pcf::Pcf, pcss::Pcss},
};
use std::sync::Arc;
use umbrage_core::{Fit, Layout, ShadowTechnique};

/// One comparison shows best what each bias does. The first is compared at every map size.
const HARD_BIASES: [Bias; 8] = [
    Bias::ADAPTIVE,
    Bias::RECEIVER_PLANE,
    Bias::NONE,
    Bias::CONSTANT,
    Bias::SLOPE,
    Bias::POLYGON_OFFSET,
    Bias::NORMAL_OFFSET,
    Bias::FRONT_CULL,
];

/// Kernels that reach beyond the receiver's texel need more; the textbooks' slope bias is theirs for 3x3.
fn wide_biases(reach: f32) -> [Bias; 4] {
    [
        Bias::ADAPTIVE,
        Bias::SLOPE,
        Bias::polygon_offset(reach),
        Bias::normal_offset(reach),
    ]
}

/// Two of them, for kernels whose neighbours in the list show the others.
fn two_biases(reach: f32) -> [Bias; 2] {
    [Bias::ADAPTIVE, Bias::polygon_offset(reach)]
}

pub(crate) fn none(_: &[u32], _: Fit) -> Settings {
    vec![Arc::new(Unshadowed::default())]
}

pub(crate) fn all_none(_: u32) -> Settings {
    vec![Arc::new(Unshadowed::default())]
}

pub(crate) fn hard(sizes: &[u32], fit: Fit) -> Settings {
    let stored = |format| {
        middle(sizes, fit, &[Bias::SLOPE], move |map| Hard {
            map: ShadowMap { format, ..map },
        })
    };
    [
        sweep(sizes, fit, &HARD_BIASES, |map| Hard { map }),
        stored(MapFormat::Depth16),
        stored(MapFormat::Rgba8),
    ]
    .concat()
}

pub(crate) fn all_hard(size: u32) -> Settings {
    let kinds = kinds_of_map(size)
        .into_iter()
        .map(|map| Arc::new(Hard { map }) as Arc<dyn ShadowTechnique>);
    every_bias(size, |map| Hard { map })
        .into_iter()
        .chain(kinds)
        .collect()
}

pub(crate) fn pcf_dithered(sizes: &[u32], fit: Fit) -> Settings {
    sweep(sizes, fit, &two_biases(1.5), |map| PcfDithered { map })
}

pub(crate) fn all_pcf_dithered(size: u32) -> Settings {
    every_bias(size, |map| PcfDithered { map })
}

pub(crate) fn pcf(sizes: &[u32], fit: Fit) -> Settings {
    let of = |radius: u32| {
        sweep(sizes, fit, &wide_biases(radius as f32), move |map| Pcf {
            map,
            radius,
        })
    };
    let between = middle(sizes, fit, &[Bias::ADAPTIVE], |map| Pcf { map, radius: 2 });
    [of(1), between, of(3)].concat()
}

pub(crate) fn all_pcf(size: u32) -> Settings {
    [0, 1, 2, 3, 6]
        .map(|radius| every_bias(size, move |map| Pcf { map, radius }))
        .concat()
}

pub(crate) fn pcf_hardware(sizes: &[u32], fit: Fit) -> Settings {
    let of = |samples| {
        sweep(
            sizes,
            fit,
            &two_biases(PcfHardware::reach(samples)),
            move |map| PcfHardware { map, samples },
        )
    };
    let between = middle(sizes, fit, &[Bias::ADAPTIVE], |map| PcfHardware {
        map,
        samples: 2,
    });
    [of(1), between, of(3)].concat()
}

pub(crate) fn all_pcf_hardware(size: u32) -> Settings {
    let few = [1, 3]
        .map(|samples| two(size, move |map| PcfHardware { map, samples }))
        .concat();
    let kinds = sampled_maps(size)
        .map(|map| Arc::new(PcfHardware { map, samples: 2 }) as Arc<dyn ShadowTechnique>);
    every_bias(size, |map| PcfHardware { map, samples: 2 })
        .into_iter()
        .chain(few)
        .chain(kinds)
        .collect()
}

pub(crate) fn pcf_merged(sizes: &[u32], fit: Fit) -> Settings {
    let of = |radius| {
        sweep(
            sizes,
            fit,
            &two_biases(PcfMerged::reach(radius)),
            move |map| PcfMerged { map, radius },
        )
    };
    [
        of(1),
        of(2),
        middle(sizes, fit, &[Bias::ADAPTIVE], |map| PcfMerged {
            map,
            radius: 3,
        }),
    ]
    .concat()
}

pub(crate) fn all_pcf_merged(size: u32) -> Settings {
    let few = [2, 3]
        .map(|radius| two(size, move |map| PcfMerged { map, radius }))
        .concat();
    let kinds = sampled_maps(size)
        .map(|map| Arc::new(PcfMerged { map, radius: 2 }) as Arc<dyn ShadowTechnique>);
    every_bias(size, |map| PcfMerged { map, radius: 1 })
        .into_iter()
        .chain(few)
        .chain(kinds)
        .collect()
}

pub(crate) fn pcf_disc(sizes: &[u32], fit: Fit) -> Settings {
    let of = |map, pattern, taps| PcfDisc {
        map,
        pattern,
        taps,
        ..PcfDisc::default()
    };
    let bias = [Bias::ADAPTIVE];
    let taps = |taps| middle(sizes, fit, &bias, move |map| of(map, Pattern::Vogel, taps));
    let poisson = middle(sizes, fit, &bias, |map| PcfDisc {
        map,
        pattern: Pattern::Poisson,
        ..PcfDisc::default()
    });
    [
        taps(8),
        sweep(sizes, fit, &bias, |map| of(map, Pattern::Vogel, 16)),
        taps(32),
        poisson,
    ]
    .concat()
}

pub(crate) fn all_pcf_disc(size: u32) -> Settings {
    let fixed = |pattern| {
        two(size, move |map| PcfDisc {
            map,
            pattern,
            rotate: false,
            taps: 9,
            ..PcfDisc::default()
        })
    };
    let turned = every_bias(size, |map| PcfDisc {
        map,
        ..PcfDisc::default()
    });
    [turned, fixed(Pattern::Grid), fixed(Pattern::Poisson)].concat()
}

pub(crate) fn pcss(sizes: &[u32], fit: Fit) -> Settings {
    let of = |[blocker_taps, filter_taps]: [u32; 2]| {
        move |map| Pcss {
            map,
            blocker_taps,
            filter_taps,
            ..Pcss::default()
        }
    };
    let taps = |counts| middle(sizes, fit, &[Bias::ADAPTIVE], of(counts));
    let sizes_too = sweep(sizes, fit, &[Bias::ADAPTIVE, Bias::SLOPE], of([16, 32]));
    [taps([8, 16]), sizes_too, taps([32, 64])].concat()
}

pub(crate) fn all_pcss(size: u32) -> Settings {
    let fixed = |pattern| {
        let soft = Pcss {
            pattern,
            rotate: false,
            blocker_taps: 7,
            filter_taps: 9,
            ..Pcss::default()
        };
        two(size, move |map| Pcss { map, ..soft })
    };
    let turned = every_bias(size, |map| Pcss {
        map,
        ..Pcss::default()
    });
    let kinds = kinds_of_map(size).map(|map| {
        Arc::new(Pcss {
            map,
            ..Pcss::default()
        }) as Arc<dyn ShadowTechnique>
    });
    [
        turned,
        fixed(Pattern::Grid),
        fixed(Pattern::Poisson),
        kinds.to_vec(),
    ]
    .concat()
}

pub(crate) fn second_depth(sizes: &[u32], fit: Fit) -> Settings {
    sweep(sizes, fit, &[Bias::FRONT_CULL], |map| SecondDepth {
        map,
        radius: 0,
    })
}

pub(crate) fn all_second_depth(size: u32) -> Settings {
    every_bias(size, |map| SecondDepth { map, radius: 1 })
}

pub(crate) fn midpoint(sizes: &[u32], fit: Fit) -> Settings {
    sweep(sizes, fit, &[Bias::NONE, Bias::ADAPTIVE], |map| Midpoint {
        map,
        radius: 0,
    })
}

pub(crate) fn all_midpoint(size: u32) -> Settings {
    every_bias(size, |map| Midpoint { map, radius: 1 })
}

pub(crate) fn planar(_: &[u32], _: Fit) -> Settings {
    vec![Arc::new(Planar::default())]
}

pub(crate) fn all_planar(_: u32) -> Settings {
    vec![Arc::new(Planar { planes: 64 })]
}

pub(crate) fn volumes(_: &[u32], _: Fit) -> Settings {
    vec![Arc::new(ShadowVolumes::default())]
}

pub(crate) fn all_volumes(_: u32) -> Settings {
    vec![Arc::new(ShadowVolumes::default())]
}

pub(crate) fn traced(_: &[u32], _: Fit) -> Settings {
    [1, 4, 32]
        .map(|samples| Arc::new(Traced { samples }) as Arc<dyn ShadowTechnique>)
        .to_vec()
}

pub(crate) fn all_traced(_: u32) -> Settings {
    vec![Arc::new(Traced { samples: 3 })]
}

/// A technique with its first bias over maps of all sizes, and with the others at the middle one: what a size does and what
/// a bias does are seen apart, in far fewer settings than all pairs would be.
fn sweep<T: ShadowTechnique + 'static>(
    sizes: &[u32],
    fit: Fit,
    biases: &[Bias],
    make: impl Fn(ShadowMap) -> T,
) -> Settings {
    let (first, others) = biases.split_at(biases.len().min(1));
    [
        maps(sizes, fit, first, &make),
        middle(sizes, fit, others, &make),
    ]
    .concat()
}

/// A technique at the middle map size alone, with all of these biases.
fn middle<T: ShadowTechnique + 'static>(
    sizes: &[u32],
    fit: Fit,
    biases: &[Bias],
    make: impl Fn(ShadowMap) -> T,
) -> Settings {
    let size: Vec<u32> = sizes.get(sizes.len() / 2).copied().into_iter().collect();
    maps(&size, fit, biases, make)
}

/// A technique over maps of all sizes, with all of these biases.
fn maps<T: ShadowTechnique + 'static>(
    sizes: &[u32],
    fit: Fit,
    biases: &[Bias],
    make: impl Fn(ShadowMap) -> T,
) -> Settings {
    let each = |&size: &u32| {
        biases.iter().map(move |&bias| ShadowMap {
            size,
            fit,
            bias,
            ..ShadowMap::default()
        })
    };
    sizes
        .iter()
        .flat_map(each)
        .map(|map| Arc::new(make(map)) as Arc<dyn ShadowTechnique>)
        .collect()
}

/// A technique with every bias, and with all at once, since they must also agree together.
fn every_bias<T: ShadowTechnique + 'static>(size: u32, make: impl Fn(ShadowMap) -> T) -> Settings {
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

/// A technique with two biases: for kernels that treat depth as another setting of theirs does.
fn two<T: ShadowTechnique + 'static>(size: u32, make: impl Fn(ShadowMap) -> T) -> Settings {
    maps(&[size], Fit::Tight, &[Bias::SLOPE, Bias::ADAPTIVE], make)
}

/// Every kind of map that differs in code path.
fn kinds_of_map(size: u32) -> [ShadowMap; 6] {
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
    ]
}

/// Those that comparison samplers can read.
fn sampled_maps(size: u32) -> impl Iterator<Item = ShadowMap> {
    let readable =
        |map: &ShadowMap| map.surface == Surface::Nearest && map.format != MapFormat::Rgba8;
    kinds_of_map(size).into_iter().filter(readable)
}
