//! Estimated cost of settings from counts and prices, as in plans.

use super::subject::Subject;
use anyhow::Result;
use umbrage::{
    Receivers, ShadowTechnique as _,
    plan::{
        catalogue::Catalogue,
        cost::{CostModel, Work},
        motion::{FrameMotion, follows_camera},
    },
    techniques::TechniquePreset,
};

/// Returns the prices of wgpu devices.
pub(crate) fn prices() -> CostModel {
    CostModel::for_backend("wgpu")
}

/// The cost of settings.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Cost {
    /// Cost of maps and lists, milliseconds.
    pub draw_ms: f64,
    /// Cost of the lookups of all pixels, milliseconds.
    pub lookup_ms: f64,
    /// `true` if maps or lists change when the camera moves.
    pub follows_camera: bool,
}

impl Cost {
    /// Counts the work of settings.
    ///
    /// # Errors
    /// Returns an error if the technique refuses the light.
    pub(crate) fn of_settings(
        preset: &TechniquePreset,
        subject: &Subject,
        receivers: &Receivers,
    ) -> Result<Self> {
        let view = subject.view();
        let recipe = preset.recipe(&view)?;
        let view_of_receivers = view.with_receivers(receivers);
        let work = Work::of_recipe(&view_of_receivers, &recipe, &Catalogue::built_in());
        let prices = prices();
        let lookup_ms = prices.lookup_milliseconds(&work);
        Ok(Self {
            draw_ms: prices.milliseconds(&work) - lookup_ms,
            lookup_ms,
            follows_camera: follows_camera(preset, &recipe, &view),
        })
    }

    /// Reports whether maps and lists are redrawn in each frame.
    pub(crate) fn draws(&self, motion: FrameMotion) -> bool {
        match motion {
            FrameMotion::Still => false,
            FrameMotion::CameraMoves => self.follows_camera,
            FrameMotion::AllMoves => true,
        }
    }

    /// Returns the cost of a frame, milliseconds.
    pub(crate) fn milliseconds(&self, motion: FrameMotion) -> f64 {
        if self.draws(motion) {
            self.lookup_ms + self.draw_ms
        } else {
            self.lookup_ms
        }
    }
}
