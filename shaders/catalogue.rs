//! The one list of techniques: command line, help, tests, charts and tables all come from it.

use crate::{Bias, Hard, Pcf, PcfDithered, ShadowMap, Traced};
use std::sync::Arc;
use umbrage_core::{Fit, ShadowTechnique};

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
            settings: |sizes, fit| settings((sizes, fit), &HARD_BIASES, |map| Hard { map }),
            exhaustive: |size| exhaustive(size, |map| Hard { map }),
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

fn settings<T: ShadowTechnique + 'static>(
    (sizes, fit): (&[u32], Fit),
    biases: &[Bias],
    make: impl Fn(ShadowMap) -> T,
) -> Settings {
    let maps = sizes.iter().flat_map(|&size| biases.iter().map(move |&bias| ShadowMap { size, fit, bias }));
    maps.map(|map| Arc::new(make(map)) as Arc<dyn ShadowTechnique>).collect()
}

fn exhaustive<T: ShadowTechnique + 'static>(size: u32, make: impl Fn(ShadowMap) -> T) -> Settings {
    let mut biases = Bias::PRESETS.map(|(_, bias)| bias).to_vec();
    // All at once, since they must also agree together.
    biases.push(Bias { constant: 1e-3, receiver_plane: 0.05, ..Bias { normal_offset: 1.0, ..Bias::SLOPE } });
    settings((&[size], Fit::Tight), &biases, make)
}
