//! What a setting costs by counts and prices: the same numbers that plans go by.

use super::places::SeenFrom;
use anyhow::Result;
use umbrage::{
    ShadowTechnique as _,
    plan::{
        catalogue::Catalogue,
        cost::{CostModel, Work},
        motion::{FrameMotion, follows_camera},
    },
    techniques::TechniquePreset,
};

/// The prices: those of a device that draws.
pub(crate) fn prices() -> CostModel {
    CostModel::of("wgpu")
}

/// A setting's cost.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Cost {
    /// Of maps and lists, milliseconds.
    pub draw_ms: f64,
    /// Of the lookups of all pixels, milliseconds.
    pub lookup_ms: f64,
    /// Whether something else is drawn once the camera moves.
    pub follows_camera: bool,
}

impl Cost {
    /// Counts a setting's work.
    ///
    /// # Errors
    /// Errors if the technique refuses the light.
    pub(crate) fn of(preset: &TechniquePreset, seen: &SeenFrom<'_>) -> Result<Self> {
        let view = seen.planned_view();
        let recipe = preset.recipe(&view)?;
        let seen_view = view.with_receivers(seen.receivers);
        let work = Work::of(&seen_view, &recipe, &Catalogue::built_in());
        let prices = prices();
        let lookup_ms = prices.lookup_milliseconds(&work);
        Ok(Self {
            draw_ms: prices.milliseconds(&work) - lookup_ms,
            lookup_ms,
            follows_camera: follows_camera(preset, &recipe, &view),
        })
    }

    /// Whether maps and lists are made anew with each frame.
    pub(crate) fn draws(&self, motion: FrameMotion) -> bool {
        match motion {
            FrameMotion::Still => false,
            FrameMotion::CameraMoves => self.follows_camera,
            FrameMotion::AllMoves => true,
        }
    }

    /// Returns what a frame costs, milliseconds.
    pub(crate) fn milliseconds(&self, motion: FrameMotion) -> f64 {
        if self.draws(motion) {
            self.lookup_ms + self.draw_ms
        } else {
            self.lookup_ms
        }
    }
}
