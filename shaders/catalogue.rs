//! The one list of techniques: command line, help, tests, charts and tables all come from it.

use crate::{
    BeyondFar, Bias, Border, Hard, MapFormat, Midpoint, Pattern, Pcf, PcfDisc, PcfDithered, PcfHardware, PcfMerged,
    Pcss, Planar, SecondDepth, ShadowMap, ShadowVolumes, Surface, Traced,
};
use std::sync::Arc;
use umbrage_core::{Fit, Layout, ShadowTechnique};

/// Techniques with their settings, ready to plan.
pub type Settings = Vec<Arc<dyn ShadowTechnique>>;

/// A technique of the list.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// Its name, as [`ShadowTechnique::name`] gives it.
    pub name: &'static str,
    /// What it does, in one line.
    pub summary: &'static str,
    /// The settings worth comparing, for the given map sizes and fit. Techniques without a map ignore both.
    pub settings: fn(map_sizes: &[u32], fit: Fit) -> Settings,
    /// Every setting that differs in code path: all kernels with all biases, at one small map size, for tests.
    pub exhaustive: fn(map_size: u32) -> Settings,
}

/// All built-in techniques, cheapest first.
pub fn all() -> &'static [Entry] {
    &[
        Entry {
            name: "hard",
            summary: "one comparison with one texel (Williams 1978)",
            settings: |sizes, fit| {
                let mut all = settings((sizes, fit), &HARD_BIASES, |map| Hard { map });
                for format in [MapFormat::Depth16, MapFormat::Rgba8] {
                    all.extend(settings((sizes, fit), &[Bias::SLOPE], |map| Hard { map: ShadowMap { format, ..map } }));
                }
                all
            },
            exhaustive: |size| {
                let mut all = exhaustive(size, |map| Hard { map });
                all.extend(kinds_of_map(size).map(|map| Arc::new(Hard { map }) as Arc<dyn ShadowTechnique>));
                all
            },
        },
        Entry {
            name: "pcf_dithered",
            summary: "four comparisons, placed by the pixel's parity (Bunnell, Pellacini 2004)",
            settings: |sizes, fit| settings((sizes, fit), &wide_biases(1.5), |map| PcfDithered { map }),
            exhaustive: |size| exhaustive(size, |map| PcfDithered { map }),
        },
        Entry {
            name: "pcf",
            summary: "the mean of a square of comparisons (Reeves, Salesin, Cook 1987)",
            settings: |sizes, fit| {
                let of_radius =
                    |radius: u32| settings((sizes, fit), &wide_biases(radius as f32), move |map| Pcf { map, radius });
                [1, 3].into_iter().flat_map(of_radius).collect()
            },
            exhaustive: |size| {
                [0, 1, 2, 3, 6]
                    .into_iter()
                    .flat_map(|radius| exhaustive(size, move |map| Pcf { map, radius }))
                    .collect()
            },
        },
        Entry {
            name: "pcf_hardware",
            summary: "comparison samplers, each blending 2x2 texels",
            settings: |sizes, fit| {
                let of = |samples| {
                    let biases = soft_biases(PcfHardware::reach(samples));
                    settings((sizes, fit), &biases, move |map| PcfHardware { map, samples })
                };
                [1, 3].into_iter().flat_map(of).collect()
            },
            exhaustive: |size| {
                let mut all = exhaustive(size, |map| PcfHardware { map, samples: 2 });
                all.extend([1, 3].into_iter().flat_map(|samples| few(size, move |map| PcfHardware { map, samples })));
                all.extend(sampled_maps(size).map(|map| Arc::new(PcfHardware { map, samples: 2 }) as _));
                all
            },
        },
        Entry {
            name: "pcf_merged",
            summary: "tent-like kernels of (2r + 1)² texels in (r + 1)² comparison samples (Castaño 2013)",
            settings: |sizes, fit| {
                let of = |radius| {
                    let biases = soft_biases(PcfMerged::reach(radius));
                    settings((sizes, fit), &biases, move |map| PcfMerged { map, radius })
                };
                [1, 2].into_iter().flat_map(of).collect()
            },
            exhaustive: |size| {
                let mut all = exhaustive(size, |map| PcfMerged { map, radius: 1 });
                all.extend([2, 3].into_iter().flat_map(|radius| few(size, move |map| PcfMerged { map, radius })));
                all.extend(sampled_maps(size).map(|map| Arc::new(PcfMerged { map, radius: 2 }) as _));
                all
            },
        },
        Entry {
            name: "pcf_disc",
            summary: "comparisons spread over a disc, turned at every pixel (Vogel, Poisson)",
            settings: |sizes, fit| {
                let of = |pattern| {
                    settings((sizes, fit), &[Bias::RECEIVER_PLANE], move |map| PcfDisc {
                        map,
                        pattern,
                        ..PcfDisc::default()
                    })
                };
                [Pattern::Vogel, Pattern::Poisson].into_iter().flat_map(of).collect()
            },
            exhaustive: |size| {
                let turned = exhaustive(size, |map| PcfDisc { map, ..PcfDisc::default() });
                let of = |pattern| {
                    let fixed = PcfDisc { pattern, rotate: false, taps: 9, ..PcfDisc::default() };
                    few(size, move |map| PcfDisc { map, ..fixed })
                };
                turned.into_iter().chain([Pattern::Grid, Pattern::Poisson].into_iter().flat_map(of)).collect()
            },
        },
        Entry {
            name: "pcss",
            summary: "soft shadows: looks for blockers, then filters as widely as they ask for (Fernando 2005)",
            settings: |sizes, fit| {
                let of = |[blocker_taps, filter_taps]: [u32; 2]| {
                    let soft = Pcss { blocker_taps, filter_taps, ..Pcss::default() };
                    settings((sizes, fit), &[Bias::RECEIVER_PLANE], move |map| Pcss { map, ..soft })
                };
                [[16, 32], [32, 64]].into_iter().flat_map(of).collect()
            },
            exhaustive: |size| {
                let turned = exhaustive(size, |map| Pcss { map, ..Pcss::default() });
                let of = |pattern| {
                    let fixed = Pcss { pattern, rotate: false, blocker_taps: 7, filter_taps: 9, ..Pcss::default() };
                    few(size, move |map| Pcss { map, ..fixed })
                };
                let mut all: Settings =
                    turned.into_iter().chain([Pattern::Grid, Pattern::Poisson].into_iter().flat_map(of)).collect();
                all.extend(kinds_of_map(size).map(|map| Arc::new(Pcss { map, ..Pcss::default() }) as _));
                all
            },
        },
        Entry {
            name: "second_depth",
            summary: "comparisons with the far sides of closed casters, no bias (Wang, Molnar 1994)",
            settings: |sizes, fit| settings((sizes, fit), &[Bias::FRONT_CULL], |map| SecondDepth { map, radius: 1 }),
            exhaustive: |size| exhaustive(size, |map| SecondDepth { map, radius: 1 }),
        },
        Entry {
            name: "midpoint",
            summary: "comparisons with the middle of the nearest two surfaces, no bias (Woo 1992)",
            settings: |sizes, fit| {
                settings((sizes, fit), &[Bias::NONE, Bias::RECEIVER_PLANE], |map| Midpoint { map, radius: 1 })
            },
            exhaustive: |size| exhaustive(size, |map| Midpoint { map, radius: 1 }),
        },
        Entry {
            name: "planar",
            summary: "casters flattened onto each flat receiver, exact (Blinn 1988)",
            settings: |_, _| vec![Arc::new(Planar::default())],
            exhaustive: |_| vec![Arc::new(Planar { planes: 64 })],
        },
        Entry {
            name: "volumes",
            summary: "stencil shadow volumes, exact (Crow 1977; Everitt, Kilgard 2002)",
            settings: |_, _| vec![Arc::new(ShadowVolumes::default())],
            exhaustive: |_| vec![Arc::new(ShadowVolumes::default())],
        },
        Entry {
            name: "traced",
            summary: "any-hit rays, no map (Whitted 1980; Cook, Porter, Carpenter 1984)",
            settings: |_, _| vec![Arc::new(Traced { samples: 4 }), Arc::new(Traced { samples: 32 })],
            exhaustive: |_| vec![Arc::new(Traced { samples: 3 })],
        },
    ]
}

/// The technique with this name.
pub fn find(name: &str) -> Option<&'static Entry> {
    all().iter().find(|e| e.name == name)
}

/// One comparison shows best what each bias does.
const HARD_BIASES: [Bias; 7] = [
    Bias::NONE,
    Bias::CONSTANT,
    Bias::SLOPE,
    Bias::POLYGON_OFFSET,
    Bias::NORMAL_OFFSET,
    Bias::RECEIVER_PLANE,
    Bias::FRONT_CULL,
];

/// Kernels that reach beyond the receiver's texel need more; the textbooks' slope bias is theirs for 3x3.
fn wide_biases(reach: f32) -> [Bias; 4] {
    [Bias::SLOPE, Bias::polygon_offset(reach), Bias::normal_offset(reach), Bias::RECEIVER_PLANE]
}

/// For kernels that follow the receiver's plane well.
fn soft_biases(reach: f32) -> [Bias; 2] {
    [Bias::polygon_offset(reach), Bias::RECEIVER_PLANE]
}

fn settings<T: ShadowTechnique + 'static>(
    (sizes, fit): (&[u32], Fit),
    biases: &[Bias],
    make: impl Fn(ShadowMap) -> T,
) -> Settings {
    let maps = sizes
        .iter()
        .flat_map(|&size| biases.iter().map(move |&bias| ShadowMap { size, fit, bias, ..ShadowMap::default() }));
    maps.map(|map| Arc::new(make(map)) as Arc<dyn ShadowTechnique>).collect()
}

/// Every kind of map that differs in code path.
fn kinds_of_map(size: u32) -> impl Iterator<Item = ShadowMap> {
    let map = ShadowMap { size, bias: Bias::CONSTANT, ..ShadowMap::default() };
    [
        ShadowMap { layout: Layout::Cube, ..map },
        ShadowMap { surface: Surface::Midpoint, ..map },
        ShadowMap { format: MapFormat::Depth16, ..map },
        ShadowMap { format: MapFormat::Rgba8, ..map },
        ShadowMap { border: Border::Clamp, beyond_far: BeyondFar::Compared, ..map },
        ShadowMap { layout: Layout::Cube, surface: Surface::Midpoint, format: MapFormat::Rgba8, ..map },
    ]
    .into_iter()
}

/// Those that comparison samplers can read.
fn sampled_maps(size: u32) -> impl Iterator<Item = ShadowMap> {
    kinds_of_map(size).filter(|map| map.surface == Surface::Nearest && map.format != MapFormat::Rgba8)
}

/// As [`exhaustive`] with two biases: for kernels that treat depth as another setting of theirs does.
fn few<T: ShadowTechnique + 'static>(size: u32, make: impl Fn(ShadowMap) -> T) -> Settings {
    settings((&[size], Fit::Tight), &[Bias::SLOPE, Bias::RECEIVER_PLANE], make)
}

fn exhaustive<T: ShadowTechnique + 'static>(size: u32, make: impl Fn(ShadowMap) -> T) -> Settings {
    let mut biases = Bias::PRESETS.map(|(_, bias)| bias).to_vec();
    // All at once, since they must also agree together.
    biases.push(Bias { constant: 1e-3, receiver_plane: 0.05, ..Bias { normal_offset: 1.0, ..Bias::SLOPE } });
    settings((&[size], Fit::Tight), &biases, make)
}
