//! Catalogue entry of `msm`.

use super::{
    Candidate, CataloguedTechnique, ClosedFormDemand, PlannedBiases, RandomParameter,
    kernel::{self, CataloguedKernel},
    moments, sweeps,
};
use umbrage_core::{FilterKernel, Fit, Light, ReceiveKernel};
use umbrage_techniques::{MapFilter as _, MapTechnique, Msm, MsmKernel, Reconstruction, ShadowMap};

impl CataloguedTechnique for MapTechnique<Msm> {
    fn kernel_reach(&self) -> Option<f32> {
        Some(moments::kernel_reach(self.filter.blur))
    }

    fn filter_loads(filter: &dyn FilterKernel) -> Option<u32> {
        moments::filter_loads(filter)
    }

    fn kernel(kernel: &dyn ReceiveKernel) -> Option<&dyn CataloguedKernel> {
        kernel::downcast::<MsmKernel>(kernel)
    }

    // Filters take longer than most techniques' lookups, especially on software drivers.
    const IS_PREVIEWED: bool = false;

    fn compared_settings(map_sizes: &[u32], fit: Fit) -> Vec<Self> {
        sweeps::blurs(map_sizes, fit, |map, blur| {
            Msm {
                blur,
                ..Msm::default()
            }
            .on(map)
        })
    }

    fn exhaustive(map_size: u32) -> Vec<Self> {
        let mut out = Vec::new();
        for reconstruction in [Reconstruction::Hamburger, Reconstruction::Hausdorff] {
            out.extend(sweeps::slope_and_adaptive(map_size, |map| {
                Msm {
                    reconstruction,
                    ..Msm::default()
                }
                .on(map)
            }));
        }
        for (precision, mipmaps) in moments::STORAGES {
            out.extend(sweeps::slope_and_adaptive(map_size, |map| {
                Msm {
                    precision,
                    mipmaps,
                    ..Msm::default()
                }
                .on(map)
            }));
        }
        out
    }

    fn candidates(map: ShadowMap, _: &Light) -> Vec<Candidate<Self>> {
        [3, 8]
            .map(|blur| {
                Candidate::from_setting(
                    Msm {
                        blur,
                        ..Msm::default()
                    }
                    .on(map),
                )
            })
            .to_vec()
    }

    // The default bias follows the receiver's plane, and no other bias is needed.
    const PLANNED_BIASES: PlannedBiases = PlannedBiases::Own;

    fn closed_form(map: ShadowMap) -> Option<ClosedFormDemand<Self>> {
        let technique = Msm::default().on(moments::closed_form_map(map));
        moments::closed_form_demand(technique)
    }

    fn random_parameters() -> Vec<RandomParameter> {
        vec![
            RandomParameter::Count(0..8),
            RandomParameter::Length(0.0..1e-4),
            RandomParameter::Length(0.0..0.9),
            RandomParameter::Switch,
            RandomParameter::Switch,
            RandomParameter::Count(0..4),
        ]
    }

    fn random(map: ShadowMap, numbers: &[f32]) -> MapTechnique<Msm> {
        Msm {
            blur: numbers[0] as u32,
            mipmaps: numbers[5] as u32,
            precision: moments::precision_of_switch(numbers[4]),
            moment_bias: Some(numbers[1]),
            bleeding_reduction: numbers[2],
            reconstruction: if numbers[3] > 0.0 {
                Reconstruction::Hausdorff
            } else {
                Reconstruction::Hamburger
            },
        }
        .on(map)
    }
}

moments::catalogued_kernel!(MsmKernel);
