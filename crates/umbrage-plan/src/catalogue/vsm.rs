//! Catalogue entry of `vsm`.

use super::{
    Candidate, CataloguedTechnique, ClosedFormDemand, PlannedBiases, RandomParameter,
    kernel::{self, CataloguedKernel},
    moments, sweeps,
};
use umbrage_core::{FilterKernel, Fit, Light, ReceiveKernel};
use umbrage_techniques::{Bias, MapFilter as _, MapTechnique, ShadowMap, Vsm, VsmKernel};

impl CataloguedTechnique for MapTechnique<Vsm> {
    fn kernel_reach(&self) -> Option<f32> {
        Some(moments::kernel_reach(self.filter.blur))
    }

    fn filter_loads(filter: &dyn FilterKernel) -> Option<u32> {
        moments::filter_loads(filter)
    }

    fn kernel(kernel: &dyn ReceiveKernel) -> Option<&dyn CataloguedKernel> {
        kernel::downcast::<VsmKernel>(kernel)
    }

    // Filters take longer than most techniques' lookups, especially on software drivers.
    const IS_PREVIEWED: bool = false;

    fn compared_settings(map_sizes: &[u32], fit: Fit) -> Vec<Self> {
        sweeps::blurs(map_sizes, fit, |map, blur| {
            Vsm {
                blur,
                ..Vsm::default()
            }
            .on(map)
        })
    }

    fn exhaustive(map_size: u32) -> Vec<Self> {
        let mut out = sweeps::slope_and_adaptive(map_size, |map| Vsm::default().on(map));
        for blur in [0, 9] {
            out.extend(sweeps::middle(
                &[map_size],
                Fit::Tight,
                &[Bias::NONE],
                |map| {
                    Vsm {
                        blur,
                        ..Vsm::default()
                    }
                    .on(map)
                },
            ));
        }
        let kinds = sweeps::kinds_of_map(map_size).into_iter();
        out.extend(kinds.map(|map| Vsm::default().on(map)));
        for (precision, mipmaps) in moments::STORAGES {
            out.extend(sweeps::slope_and_adaptive(map_size, |map| {
                Vsm {
                    precision,
                    mipmaps,
                    ..Vsm::default()
                }
                .on(map)
            }));
        }
        out
    }

    fn candidates(map: ShadowMap, _: &Light) -> Vec<Candidate<Self>> {
        // A wider blur causes more light bleeding; `evsm` and `msm` cover it.
        vec![Candidate::from_setting(Vsm::default().on(map))]
    }

    // A blend of a plane's depths is the plane's depth, so no bias is needed.
    const PLANNED_BIASES: PlannedBiases = PlannedBiases::Own;

    fn closed_form(map: ShadowMap) -> Option<ClosedFormDemand<Self>> {
        let technique = Vsm::default().on(moments::closed_form_map(map));
        moments::closed_form_demand(technique)
    }

    fn random_parameters() -> Vec<RandomParameter> {
        vec![
            RandomParameter::Count(0..8),
            RandomParameter::Length(0.0..0.01),
            RandomParameter::Length(0.0..0.9),
            RandomParameter::Switch,
            RandomParameter::Count(0..4),
        ]
    }

    fn random(map: ShadowMap, numbers: &[f32]) -> MapTechnique<Vsm> {
        Vsm {
            blur: numbers[0] as u32,
            mipmaps: numbers[4] as u32,
            precision: moments::precision_of_switch(numbers[3]),
            least_deviation: Some(numbers[1]),
            bleeding_reduction: numbers[2],
        }
        .on(map)
    }
}

moments::catalogued_kernel!(VsmKernel);
