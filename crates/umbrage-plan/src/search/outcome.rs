//! The result of a planner.

use super::{bias::BiasKind, bounds::Bounds, setting::Setting};
use crate::{
    estimate::{error::Estimate, sampled_truth::Coverage},
    motion::FrameMotion,
};
use serde::{Deserialize, Serialize};
use umbrage_techniques::{FrameRules, LightPreset, TechniquePreset, Update};

/// A plan: what to use, and why.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// The scene's name; empty for plans of a camera and light alone.
    pub scene: String,
    /// The light's kind.
    pub light: String,
    /// Which of the scene's lights it is, from 1.
    pub light_number: usize,
    /// Image width and height, pixels.
    pub size: [u32; 2],
    /// For how many cameras it was made.
    pub cameras: usize,
    /// What moves from frame to frame.
    pub motion: FrameMotion,
    /// The bounds that it keeps.
    pub bounds: Bounds,
    /// The cheapest setting within the bounds (without a bound of the error, the most accurate);
    /// none if nothing is.
    pub chosen: Option<Setting>,
    /// If nothing is within the bounds: which bound fails, and by how much.
    pub miss: Option<Miss>,
    /// Other settings tried, that nothing else tried beats at both cost and error; by rising cost.
    pub runners_up: Vec<Setting>,
    /// Cheaper settings that come nearest to the bounds and break one: two at most, of different
    /// techniques, the better first.
    pub failing: Vec<Setting>,
    /// What was timed by the clock, the quickest first; empty if nothing was.
    pub timed: Vec<Setting>,
    /// What no shadow at all would err by, by the first sample.
    pub error_of_no_shadow: Estimate,
    /// Why, in plain words, built from what was measured.
    pub reasons: Vec<String>,
    /// What more a renderer may leave out; of plans of a camera and light alone nothing is known.
    pub left_out: Vec<LeftOut>,
    /// The chosen setting with other biases; empty for techniques without.
    pub curve: Vec<CurvePoint>,
    /// For how many pixels it holds.
    pub coverage: Coverage,
    /// The sample that it comes from.
    pub sampled: Sampled,
}

impl Plan {
    /// The setting to use.
    ///
    /// # Errors
    /// Errors if nothing is within the bounds.
    pub fn preset(&self) -> Result<TechniquePreset, Box<Miss>> {
        self.chosen
            .as_ref()
            .map(|chosen| chosen.preset.clone())
            .ok_or_else(|| Box::new(self.miss.clone().unwrap_or_default()))
    }

    /// The setting to use, with what of its work may be left out.
    ///
    /// # Errors
    /// Errors if nothing is within the bounds.
    pub fn light_preset(&self) -> Result<LightPreset, Box<Miss>> {
        Ok(LightPreset {
            technique: self.preset()?,
            frame: self.frame_rules(),
        })
    }

    /// Returns what of its light's work may be left out: the rules of its
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

/// Work that a renderer may leave out, and what that changes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LeftOut {
    /// What is left out.
    pub what: Omission,
    /// What that saves a frame, milliseconds by the price list.
    pub saved_ms: f64,
    /// The error with all of it.
    pub error_before: f64,
    /// The error without.
    pub estimate: Estimate,
    /// Whether the plan's preset leaves it out: the error stays within the bounds.
    pub is_taken: bool,
}

/// Something that may be left out.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Omission {
    /// The light's whole shadow, since nobody sees it. It saves what a default map would take.
    Shadow,
    /// Casters that are seen less than so many pixels wide.
    SmallCasters {
        /// The width, pixels.
        below_pixels: f32,
        /// How many instances that are.
        instances: usize,
        /// How many triangles they have.
        triangles: usize,
    },
    /// Drawing again in frames in which nothing of it changes.
    Redrawing(Update),
}

impl LeftOut {
    /// Returns it in words, for people.
    pub fn words(&self) -> String {
        let saved_ms = self.saved_ms;
        let errors = format!(
            "error {:.4}, with it {:.4}",
            self.estimate.error, self.error_before
        );
        let what = match self.what {
            Omission::Shadow => "the shadow as a whole, which nobody sees".to_owned(),
            Omission::SmallCasters {
                below_pixels,
                instances,
                triangles,
            } => format!(
                "{instances} casters of {triangles} triangles that are seen less than {below_pixels} pixels wide"
            ),
            Omission::Redrawing(Update::Once) => "drawing again: nothing moves".to_owned(),
            Omission::Redrawing(_) => "drawing again while the camera alone moves".to_owned(),
        };
        let verb = if self.is_taken {
            "left out"
        } else {
            "could be left out, but is not"
        };
        format!("{verb}: {what}; saves {saved_ms:.3} ms a frame ({errors})")
    }
}

/// A point of the curve that proves a bias: acne falls with it, the gap grows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CurvePoint {
    /// The kind of bias.
    pub kind: BiasKind,
    /// The amount of bias, texels.
    pub texels: f32,
    /// Too dark: acne. Too light: the gap. By the first sample; of what was chosen by its second.
    pub estimate: Estimate,
    /// Whether this is the bias chosen.
    pub chosen: bool,
}

/// Why nothing is within the bounds.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[error("{reason}")]
pub struct Miss {
    /// Which bound fails and by how much, and how to help.
    pub reason: String,
    /// The best that was found: within the other bounds the most accurate.
    pub best: Option<Setting>,
}

/// The sample and the trials that a plan comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sampled {
    /// Receivers sampled that count.
    pub receivers: usize,
    /// Receivers whose truth was traced in all: second looks at what was about to be chosen take
    /// more.
    pub traced: usize,
    /// Settings tried on them.
    pub settings: usize,
    /// Seconds for receivers, sample and truth.
    pub looking: f64,
    /// Seconds for trying.
    pub trying: f64,
}
