//! Result of the planner.

use super::{bias::BiasKind, bounds::Bounds, setting::Setting};
use crate::{
    estimate::{error::Estimate, sampled_truth::Coverage},
    motion::FrameMotion,
};
use serde::{Deserialize, Serialize};
use umbrage_techniques::{FrameRules, LightPreset, TechniquePreset, Update};

/// A plan: the setting to use, and the reasons.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// The scene's name; empty for plans made from a camera and light only.
    pub scene: String,
    /// The light's kind.
    pub light: String,
    /// Number of the light in the scene, from 1.
    pub light_number: usize,
    /// Image width and height, pixels.
    pub size: [u32; 2],
    /// Number of cameras that it was made for.
    pub cameras: usize,
    /// Motion from frame to frame.
    pub motion: FrameMotion,
    /// The bounds that it meets.
    pub bounds: Bounds,
    /// The cheapest setting within the bounds, or the most accurate one without a bound of the
    /// error. `None` if nothing is within the bounds.
    pub chosen: Option<Setting>,
    /// The bound that fails and by how much, if nothing is within the bounds.
    pub miss: Option<Miss>,
    /// Other evaluated settings that no other one beats in both cost and error, by rising cost.
    pub runners_up: Vec<Setting>,
    /// Cheaper settings that are closest to the bounds and break one: at most two, of different
    /// techniques, the better first.
    pub failing: Vec<Setting>,
    /// Settings timed by the clock, the fastest first; empty if none was timed.
    pub timed: Vec<Setting>,
    /// Error of no shadow at all, from the first sample.
    pub error_of_no_shadow: Estimate,
    /// Reasons for the choice in plain words, built from measurements.
    pub reasons: Vec<String>,
    /// Further work that a renderer can omit; empty for plans made from a camera and light only.
    pub left_out: Vec<LeftOut>,
    /// The chosen setting with other biases; empty for techniques without a bias.
    pub curve: Vec<CurvePoint>,
    /// Number of pixels for which the plan holds.
    pub coverage: Coverage,
    /// The sample that it was computed from.
    pub sampled: Sampled,
}

impl Plan {
    /// Returns the setting to use.
    ///
    /// # Errors
    /// Errors if nothing is within the bounds.
    pub fn preset(&self) -> Result<TechniquePreset, Box<Miss>> {
        self.chosen
            .as_ref()
            .map(|chosen| chosen.preset.clone())
            .ok_or_else(|| Box::new(self.miss.clone().unwrap_or_default()))
    }

    /// Returns the setting to use, with the rules for work that can be omitted.
    ///
    /// # Errors
    /// Errors if nothing is within the bounds.
    pub fn light_preset(&self) -> Result<LightPreset, Box<Miss>> {
        Ok(LightPreset {
            technique: self.preset()?,
            frame: self.frame_rules(),
        })
    }

    /// Returns the rules for work of its light that can be omitted, as in its
    /// [`LightPreset`](umbrage_techniques::LightPreset).
    pub fn frame_rules(&self) -> FrameRules {
        let mut rules = FrameRules::default();
        for left_out in self.left_out.iter().filter(|left_out| left_out.is_taken) {
            match left_out.what {
                Omission::Shadow => {}
                Omission::SmallCasters { below_pixels, .. } => {
                    rules.skip_casters_below_pixels = below_pixels;
                }
                Omission::Redrawing(update) => rules.update = update,
            }
        }
        rules
    }
}

/// Work that a renderer can omit, and the effect on time and error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LeftOut {
    /// The omitted work.
    pub what: Omission,
    /// Time saved per frame, milliseconds by the price list.
    pub saved_ms: f64,
    /// Error without the omission.
    pub error_before: f64,
    /// Error with the omission.
    pub estimate: Estimate,
    /// True if the plan's preset omits it: the error stays within the bounds.
    pub is_taken: bool,
}

/// Work that can be omitted.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Omission {
    /// The light's whole shadow, since it is not visible. The saving is the cost of a default map.
    Shadow,
    /// Casters that are less than this many pixels wide.
    SmallCasters {
        /// The width, pixels.
        below_pixels: f32,
        /// Number of instances.
        instances: usize,
        /// Number of their triangles.
        triangles: usize,
    },
    /// Redrawing in frames in which nothing changes.
    Redrawing(Update),
}

impl LeftOut {
    /// Returns a description for display.
    pub fn words(&self) -> String {
        let saved_ms = self.saved_ms;
        let errors = format!(
            "error {:.4} instead of {:.4}",
            self.estimate.error, self.error_before
        );
        let what = match self.what {
            Omission::Shadow => "the whole shadow, which is not visible".to_owned(),
            Omission::SmallCasters {
                below_pixels,
                instances,
                triangles,
            } => format!(
                "{instances} casters ({triangles} triangles) less than {below_pixels} pixels wide"
            ),
            Omission::Redrawing(Update::Once) => "redrawing, since nothing moves".to_owned(),
            Omission::Redrawing(_) => "redrawing while only the camera moves".to_owned(),
        };
        let verb = if self.is_taken {
            "omitted"
        } else {
            "could be omitted, but is not"
        };
        format!("{verb}: {what}; saves {saved_ms:.3} ms a frame ({errors})")
    }
}

/// Point of the error curve over the bias: acne falls as the bias grows, and the gap grows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CurvePoint {
    /// The kind of bias.
    pub kind: BiasKind,
    /// The amount of bias, texels.
    pub texels: f32,
    /// Estimate from the first sample, or from the second sample for the chosen bias. `too_dark` is
    /// acne; `too_light` is the gap.
    pub estimate: Estimate,
    /// True if this is the chosen bias.
    pub chosen: bool,
}

/// Reason why nothing is within the bounds.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[error("{reason}")]
pub struct Miss {
    /// The bound that fails, by how much, and what to change.
    pub reason: String,
    /// The closest setting: the most accurate one within the other bounds.
    pub best: Option<Setting>,
}

/// Sample and evaluations that a plan was computed from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sampled {
    /// Number of sampled receivers that count.
    pub receivers: usize,
    /// Number of receivers whose truth was traced, including those of verification samples.
    pub traced: usize,
    /// Number of settings evaluated on them.
    pub settings: usize,
    /// Seconds for receivers, sample and truth.
    pub looking: f64,
    /// Seconds for evaluating settings.
    pub trying: f64,
}
