//! Prices for [`Work`]: milliseconds that are the same on every run, since they come from counts,
//! not from a clock.
//!
//! A model is a unit price for each kind of work, fitted ([`fit`]) to times measured once
//! ([`time_work`]). Rays are priced by the depth of the hierarchy that they descend, log2 of the
//! casters' triangles. Prices from another machine still rank settings well, since they contain the
//! ratio of the costs of a ray and a tap. Absolute times need calibration on the target machine.

mod calibrate;
mod least_squares;
mod price_list;
mod ranks;
#[cfg(test)]
mod recorded;
mod work;

pub use calibrate::{Calibration, CostSample, fit, time_work};
pub use price_list::PriceList;
pub use ranks::rank_correlation;
pub use work::Work;

use serde::{Deserialize, Serialize};

/// Number of kinds of work that have a price.
pub const KINDS: usize = 15;

/// Names of the kinds, in the order of [`CostModel::nanoseconds`].
pub const KIND_NAMES: [&str; KINDS] = [
    "pass",
    "triangle drawn",
    "texel covered",
    "texel cleared",
    "texel filtered",
    "receiver",
    "tap",
    "comparison sample",
    "ray, per level of the hierarchy",
    "shadow volume's face drawn",
    "texel counted",
    "texel loaded by a filter, beyond the first",
    "texel covered, with an alpha test",
    "caster of a device's hierarchy",
    "walk through it, per level",
];

/// Indices in [`KIND_NAMES`] of the kinds that are priced per level of a hierarchy.
const PER_LEVEL: [usize; 2] = [8, 14];

/// Price of a listed triangle, nanoseconds: that of a triangle drawn by the CPU ([`CostModel::CPU`]).
/// The CPU builds lists for all backends.
const LISTED_NANOSECONDS: f64 = CostModel::CPU.nanoseconds[1];

/// Prices of work on one backend.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "price_list::NamedPrices", into = "price_list::NamedPrices")]
pub struct CostModel {
    /// Nanoseconds for one of each kind, 0 or more, in the order of [`KIND_NAMES`].
    pub nanoseconds: [f64; KINDS],
}

impl CostModel {
    /// The CPU backend on 2 threads of an Intel Xeon (family 6, model 167; AVX2), fitted to the
    /// times of `recorded.csv`.
    ///
    /// Half of the parts of recipes are predicted within a factor of 1.2, nine of ten within 1.95.
    /// A texel with an alpha test costs 50 times as much as one without, since it is tested
    /// individually instead of in a vector. The prices of hierarchies are not fitted: the CPU queries
    /// lists instead, which cost less, so that plans for the CPU choose lists.
    pub const CPU: Self = Self {
        nanoseconds: [
            16_300.0, 21.4, 0.319, 0.543, 0.379, 5.10, 1.17, 7.32, 3.73, 254.0, 1.33, 0.426, 16.7,
            500.0, 10.0,
        ],
    };

    /// Mesa's software driver (llvmpipe, LLVM 15) on the same machine: half within a factor of
    /// 1.14, nine of ten within 1.61.
    pub const SOFTWARE_GPU: Self = Self {
        nanoseconds: [
            164_000.0, 86.0, 1.33, 0.321, 7.62, 11.2, 3.03, 8.76, 27.5, 351.0, 1.93, 1.17, 27.3,
            3500.0, 23.9,
        ],
    };

    /// Returns the prices for a kind of backend: those of `cpu`, or of the software driver for all
    /// others.
    pub fn for_backend(kind: &str) -> Self {
        if kind == "cpu" {
            Self::CPU
        } else {
            Self::SOFTWARE_GPU
        }
    }

    /// Returns the factor within which [`CostModel::for_backend`] predicts nine of ten times of its
    /// calibration.
    pub fn factor_of_nine_in_ten(kind: &str) -> f64 {
        if kind == "cpu" { 1.95 } else { 1.61 }
    }

    /// Returns the cost of the work, milliseconds.
    pub fn milliseconds(&self, work: &Work) -> f64 {
        let products = counts(work)
            .into_iter()
            .zip(self.nanoseconds)
            .map(|(count, price)| count * price);
        let listed = work.listed as f64 * LISTED_NANOSECONDS;
        (products.sum::<f64>() + listed) * 1e-6
    }

    /// Returns the cost of the work's lookups only, milliseconds: the cost of a frame while the
    /// images are kept.
    pub fn lookup_milliseconds(&self, work: &Work) -> f64 {
        self.milliseconds(&work.lookup())
    }
}

/// Returns the amount of work of each kind. Rays and walks count once for each level.
fn counts(work: &Work) -> [f64; KINDS] {
    let levels = (work.casters.max(1) as f64).log2() + 1.0;
    let counts = [
        work.passes,
        work.triangles,
        work.covered,
        work.cleared,
        work.filtered,
        work.receivers,
        work.taps,
        work.samples,
        work.rays,
        work.faces,
        work.counted,
        work.filter_taps,
        work.cut_out,
        work.placed,
        work.walks,
    ];
    let mut counts = counts.map(|count| count as f64);
    for kind in PER_LEVEL {
        counts[kind] *= levels;
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Building lists is not work of backends: it is part of neither drawing nor lookup.
    #[test]
    fn listed_triangles_are_priced_apart() {
        let rendered = Work {
            passes: 1,
            receivers: 1000,
            ..Work::default()
        };
        let with_lists = Work {
            listed: 5000,
            ..rendered
        };
        assert_eq!(with_lists.without_lists(), rendered);
        assert_eq!(with_lists.lookup(), rendered.lookup());
        assert_eq!(with_lists.drawing_only(), rendered.drawing_only());
        let drawn = Work {
            triangles: 5000,
            ..rendered
        };
        let by_cpu = CostModel::CPU.milliseconds(&drawn) - CostModel::CPU.milliseconds(&rendered);
        for prices in [CostModel::CPU, CostModel::SOFTWARE_GPU] {
            let listing = prices.milliseconds(&with_lists) - prices.milliseconds(&rendered);
            assert!(
                (listing - by_cpu).abs() < 1e-9,
                "{listing} instead of {by_cpu}"
            );
        }
    }

    #[test]
    fn more_work_costs_more() {
        let little = Work {
            passes: 1,
            receivers: 1000,
            taps: 1000,
            casters: 100,
            ..Work::default()
        };
        for model in [CostModel::CPU, CostModel::SOFTWARE_GPU] {
            let base = model.milliseconds(&little);
            for more in [
                Work {
                    taps: 9000,
                    ..little
                },
                Work { rays: 1, ..little },
                Work {
                    listed: 1,
                    ..little
                },
                Work {
                    cleared: 1 << 20,
                    ..little
                },
                Work {
                    triangles: 100,
                    ..little
                },
                Work {
                    filter_taps: 1 << 20,
                    ..little
                },
                Work {
                    cut_out: 1 << 20,
                    ..little
                },
            ] {
                assert!(model.milliseconds(&more) > base, "{more:?}");
            }
        }
    }

    #[test]
    fn prices_come_a_piece() {
        let mut model = CostModel {
            nanoseconds: [0.0; KINDS],
        };
        model.nanoseconds[6] = 2.0;
        model.nanoseconds[PER_LEVEL[0]] = 10.0;
        let work = Work {
            taps: 500_000,
            rays: 1000,
            casters: 8,
            ..Work::default()
        };
        // 500,000 taps of 2 ns, and 1,000 rays down 3 + 1 levels of 10 ns.
        assert!((model.milliseconds(&work) - 1.04).abs() < 1e-12);
    }
}
