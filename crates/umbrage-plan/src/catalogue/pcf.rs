//! What is measured and planned of `pcf`.

use super::{Candidate, CataloguedTechnique, RandomParameter, sweeps};
use umbrage_core::{Fit, Light};
use umbrage_techniques::{Bias, Pcf, ShadowMap};

impl CataloguedTechnique for Pcf {
    fn compared(map_sizes: &[u32], fit: Fit) -> Vec<Self> {
        let swept = |radius: u32| {
            let biases = sweeps::wide_biases(radius as f32);
            sweeps::sweep(map_sizes, fit, &biases, |map| Self { map, radius })
        };
        let mut out = swept(1);
        let radius = 2;
        out.extend(sweeps::middle(map_sizes, fit, &[Bias::ADAPTIVE], |map| {
            Self { map, radius }
        }));
        out.extend(swept(3));
        out.extend(sweeps::cascades(map_sizes, fit, Bias::ADAPTIVE, |map| {
            Self { map, radius: 1 }
        }));
        out
    }

    fn headline(map_sizes: &[u32], fit: Fit) -> Vec<Self> {
        let bias = [Bias::ADAPTIVE];
        let larger = &map_sizes[map_sizes.len() / 2..];
        let mut out = sweeps::maps(larger, fit, &bias, |map| Self { map, radius: 1 });
        out.extend(sweeps::middle(map_sizes, fit, &bias, |map| Self {
            map,
            radius: 3,
        }));
        out.extend(sweeps::cascades(map_sizes, fit, Bias::ADAPTIVE, |map| {
            Self { map, radius: 1 }
        }));
        out
    }

    fn exhaustive(map_size: u32) -> Vec<Self> {
        let mut out = Vec::new();
        for radius in [0, 1, 2, 3, 6] {
            out.extend(sweeps::every_bias(map_size, |map| Self { map, radius }));
        }
        out
    }

    fn candidates(map: ShadowMap, _: &Light) -> Vec<Candidate<Self>> {
        [1, 2, 3, 5]
            .map(|radius| Candidate::of(Self { map, radius }))
            .to_vec()
    }

    const RANDOM_WEIGHT: u32 = 3;

    fn random_parameters() -> Vec<RandomParameter> {
        vec![RandomParameter::Count(0..8)]
    }

    fn random(map: ShadowMap, numbers: &[f32]) -> Self {
        Self {
            map,
            radius: numbers[0] as u32,
        }
    }
}
