//! Bias in texels, by kind: what is searched for the least acne plus gap.

use serde::{Deserialize, Serialize};
use std::f32::consts::SQRT_2;
use umbrage_core::RasterBias;
use umbrage_techniques::{Bias, PlannedBiases, TechniquePreset};

/// A way to bias, of which there can be more or less.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BiasKind {
    /// The receiver moves along its normal: [`Bias::normal_offset`](struct@Bias), texels.
    NormalOffset,
    /// [`Bias::ADAPTIVE`], and the receiver moves by so many texels besides.
    Adaptive,
    /// Casters move away by their own slope: [`RasterBias::slope`], the depth that a surface gains over so many texels.
    PolygonOffset,
    /// Whatever the technique brings; there is nothing to find.
    Own,
}

impl BiasKind {
    /// A few words for people.
    pub fn name(self) -> &'static str {
        match self {
            Self::NormalOffset => "normal offset",
            Self::Adaptive => "adaptive and normal offset",
            Self::PolygonOffset => "polygon offset",
            Self::Own => "the technique's own",
        }
    }

    /// This kind of bias, so many texels of it; `own` for [`BiasKind::Own`].
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

/// Amounts of one kind of bias to choose from, and the one to try first.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Scale {
    pub(super) kind: BiasKind,
    /// Rising, texels.
    pub(super) texels: Vec<f32>,
    pub(super) first: usize,
}

/// The kinds of bias worth trying with a technique, with amounts about what frees a plane of acne.
pub(super) fn scales(preset: &TechniquePreset) -> Vec<Scale> {
    let Some(reach) = reach(preset) else {
        return vec![Scale {
            kind: BiasKind::Own,
            texels: vec![0.0],
            first: 0,
        }];
    };
    let times = |unit: f32, factors: &[f32]| factors.iter().map(|f| unit * f).collect();
    // As in `Bias::normal_offset` and `Bias::polygon_offset`, which are sure on planes and often too much.
    let offset = times(
        (reach + 0.5) * SQRT_2,
        &[0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0],
    );
    let slope = times(2.0 * reach + 1.0, &[0.25, 0.5, 1.0, 2.0]);
    let plane = vec![0.0, 0.25, 0.5, 1.0, 2.0];
    let mut out = vec![Scale {
        kind: BiasKind::Adaptive,
        texels: plane,
        first: 0,
    }];
    out.push(Scale {
        kind: BiasKind::NormalOffset,
        texels: offset,
        first: 4,
    });
    if preset.planned_biases() == PlannedBiases::All {
        out.push(Scale {
            kind: BiasKind::PolygonOffset,
            texels: slope,
            first: 2,
        });
    }
    out
}

/// How far a kernel reaches beyond the receiver's texel, texels; none where there is no bias to choose.
fn reach(preset: &TechniquePreset) -> Option<f32> {
    if preset.planned_biases() == PlannedBiases::Own {
        None
    } else {
        preset.technique().kernel_reach()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage_techniques::Pcf;

    #[test]
    fn first_tries_are_the_biases_that_free_planes_of_acne() {
        let pcf = TechniquePreset::from(Pcf::default());
        let firsts: Vec<Bias> = scales(&pcf)
            .iter()
            .map(|s| s.kind.bias(s.texels[s.first], Bias::NONE))
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
        for scale in TechniquePreset::defaults().iter().flat_map(scales) {
            assert!(
                scale.texels.windows(2).all(|w| w[0] < w[1]) && scale.first < scale.texels.len(),
                "{scale:?}"
            );
        }
    }
}
