//! Kinds and amounts of bias in the search for the least estimated error.

use crate::catalogue::PlannedBiases;
use serde::{Deserialize, Serialize};
use std::f32::consts::SQRT_2;
use umbrage_core::RasterBias;
use umbrage_techniques::Bias;

/// A kind of bias with an amount.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BiasKind {
    /// The receiver moves along its normal: [`Bias::normal_offset`](struct@Bias), texels.
    NormalOffset,
    /// [`Bias::ADAPTIVE`], plus an offset along the receiver's normal, texels.
    Adaptive,
    /// Casters move away by their own slope: [`RasterBias::slope`], the depth that a surface gains
    /// over this many texels.
    PolygonOffset,
    /// The technique's own bias; there is nothing to search.
    Own,
}

impl BiasKind {
    /// Returns a short display name.
    pub fn name(self) -> &'static str {
        match self {
            Self::NormalOffset => "normal offset",
            Self::Adaptive => "adaptive and normal offset",
            Self::PolygonOffset => "polygon offset",
            Self::Own => "default of the technique",
        }
    }

    /// Returns a bias of this kind with this amount, texels. Returns `own` for [`BiasKind::Own`].
    pub fn bias(self, texels: f32, own: Bias) -> Bias {
        match self {
            Self::NormalOffset => Bias {
                normal_offset: texels,
                ..Bias::NORMAL_OFFSET
            },
            Self::Adaptive => Bias {
                normal_offset: texels,
                ..Bias::ADAPTIVE
            },
            Self::PolygonOffset => {
                let raster = RasterBias {
                    slope: texels,
                    ..Bias::POLYGON_OFFSET.raster
                };
                Bias {
                    raster,
                    ..Bias::NONE
                }
            }
            Self::Own => own,
        }
    }
}

/// Amounts of one kind of bias to choose from, and the first one to evaluate.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct BiasAmounts {
    pub(super) kind: BiasKind,
    /// Texels, rising.
    pub(super) amounts: Vec<f32>,
    /// Index into `amounts` of the first one to evaluate.
    pub(super) first_index: usize,
}

impl BiasAmounts {
    /// Returns the first amount to evaluate, texels.
    pub(super) fn first(&self) -> f32 {
        self.amounts[self.first_index]
    }
}

/// Returns the kinds of bias to evaluate for a technique with this kernel reach (texels).
///
/// The amounts surround the one that removes acne from every plane.
pub(super) fn bias_amounts(kernel_reach: Option<f32>, planned: PlannedBiases) -> Vec<BiasAmounts> {
    let Some(reach) = kernel_reach.filter(|_| planned != PlannedBiases::Own) else {
        return vec![BiasAmounts {
            kind: BiasKind::Own,
            amounts: vec![0.0],
            first_index: 0,
        }];
    };
    let mut out = vec![BiasAmounts {
        kind: BiasKind::Adaptive,
        amounts: vec![0.0, 0.25, 0.5, 1.0, 2.0],
        first_index: 0,
    }];
    // These are the amounts of `Bias::normal_offset` and `Bias::polygon_offset`. They remove acne
    // from every plane, and are often larger than needed.
    let sure_offset = (reach + 0.5) * SQRT_2;
    let sure_slope = 2.0 * reach + 1.0;
    let offsets = [0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0];
    out.push(BiasAmounts {
        kind: BiasKind::NormalOffset,
        amounts: offsets.map(|factor| sure_offset * factor).to_vec(),
        first_index: 4,
    });
    if planned == PlannedBiases::All {
        let slopes = [0.25, 0.5, 1.0, 2.0];
        out.push(BiasAmounts {
            kind: BiasKind::PolygonOffset,
            amounts: slopes.map(|factor| sure_slope * factor).to_vec(),
            first_index: 2,
        });
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalogue::CataloguedTechnique as _;
    use umbrage_techniques::{MapTechnique, Pcf};

    #[test]
    fn first_tries_are_the_biases_that_free_planes_of_acne() {
        let reach = MapTechnique::<Pcf>::default().kernel_reach();
        let firsts: Vec<Bias> = bias_amounts(reach, PlannedBiases::All)
            .iter()
            .map(|biases| biases.kind.bias(biases.first(), Bias::NONE))
            .collect();
        assert_eq!(
            firsts,
            [
                Bias::ADAPTIVE,
                Bias::normal_offset(1.0),
                Bias::polygon_offset(1.0)
            ]
        );
    }

    #[test]
    fn amounts_rise() {
        for biases in crate::catalogue::all().iter().flat_map(|entry| {
            let reach = (entry.kernel_reach)(&(entry.technique.preset)());
            bias_amounts(reach, entry.planned_biases)
        }) {
            assert!(
                biases.amounts.windows(2).all(|w| w[0] < w[1])
                    && biases.first_index < biases.amounts.len(),
                "{biases:?}"
            );
        }
    }
}
