//! Catalogue entry of `evsm`.

use super::{
    Candidate, CataloguedTechnique, ClosedFormDemand, PlannedBiases, RandomParameter,
    kernel::{self, CataloguedKernel},
    moments, sweeps,
};
use umbrage_core::{FilterKernel, Fit, Light, ReceiveKernel};
use umbrage_techniques::{
    Bias, Evsm, EvsmKernel, EvsmMoments, MapFilter as _, MapTechnique, MomentPrecision, ShadowMap,
};

impl CataloguedTechnique for MapTechnique<Evsm> {
    fn kernel_reach(&self) -> Option<f32> {
        Some(moments::kernel_reach(self.filter.blur))
    }

    fn filter_loads(filter: &dyn FilterKernel) -> Option<u32> {
        moments::filter_loads(filter)
    }

    fn kernel(kernel: &dyn ReceiveKernel) -> Option<&dyn CataloguedKernel> {
        kernel::downcast::<EvsmKernel>(kernel)
    }

    // Filters take longer than most techniques' lookups, especially on software drivers.
    const IS_PREVIEWED: bool = false;

    fn compared_settings(map_sizes: &[u32], fit: Fit) -> Vec<Self> {
        sweeps::blurs(map_sizes, fit, |map, blur| {
            Evsm {
                blur,
                ..Evsm::default()
            }
            .on(map)
        })
    }

    fn exhaustive(map_size: u32) -> Vec<Self> {
        let mut out = Vec::new();
        for moments in [EvsmMoments::Two, EvsmMoments::Four] {
            out.extend(sweeps::slope_and_adaptive(map_size, |map| {
                Evsm {
                    moments,
                    ..Evsm::default()
                }
                .on(map)
            }));
        }
        for (precision, mipmaps) in moments::STORAGES {
            out.extend(sweeps::slope_and_adaptive(map_size, |map| {
                Evsm {
                    precision,
                    mipmaps,
                    ..Evsm::default()
                }
                .on(map)
            }));
        }
        out.extend(sweeps::middle(
            &[map_size],
            Fit::Tight,
            &[Bias::ADAPTIVE],
            |map| {
                Evsm {
                    moments: EvsmMoments::Two,
                    precision: MomentPrecision::Bits16,
                    ..Evsm::default()
                }
                .on(map)
            },
        ));
        out
    }

    fn candidates(map: ShadowMap, _: &Light) -> Vec<Candidate<Self>> {
        [3, 8]
            .map(|blur| {
                Candidate::from_setting(
                    Evsm {
                        blur,
                        ..Evsm::default()
                    }
                    .on(map),
                )
            })
            .to_vec()
    }

    // A blend of a plane's depths is the plane's depth, so no bias is needed.
    const PLANNED_BIASES: PlannedBiases = PlannedBiases::Own;

    fn closed_form(map: ShadowMap) -> Option<ClosedFormDemand<Self>> {
        let technique = Evsm::default().on(moments::closed_form_map(map));
        moments::closed_form_demand(technique)
    }

    fn random_parameters() -> Vec<RandomParameter> {
        vec![
            RandomParameter::Count(0..8),
            RandomParameter::Length(0.0..0.01),
            RandomParameter::Length(0.0..0.9),
            RandomParameter::Switch,
            RandomParameter::Length(0.0..42.0),
            RandomParameter::Length(0.0..42.0),
            RandomParameter::Switch,
            RandomParameter::Count(0..4),
        ]
    }

    fn random(map: ShadowMap, numbers: &[f32]) -> MapTechnique<Evsm> {
        Evsm {
            blur: numbers[0] as u32,
            mipmaps: numbers[7] as u32,
            precision: moments::precision_of_switch(numbers[6]),
            least_deviation: Some(numbers[1]),
            bleeding_reduction: numbers[2],
            moments: if numbers[3] > 0.0 {
                EvsmMoments::Four
            } else {
                EvsmMoments::Two
            },
            positive_exponent: numbers[4],
            negative_exponent: numbers[5],
        }
        .on(map)
    }
}

moments::catalogued_kernel!(EvsmKernel);
