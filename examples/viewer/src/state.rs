//! What the user set, and what of it is kept from one time to the next.

use crate::{
    camera::ViewCamera,
    lights::{EditLight, MAX_LIGHTS},
    measure::figures::Picture,
    settings::{SavedSide, SideSettings, entry},
    stage::Stage,
};
use anyhow::Result;
use serde::{Deserialize, Serialize};
use umbrage::plan::motion::FrameMotion;

/// How the program begins.
#[derive(Default)]
pub(crate) struct Start {
    pub scene: Option<String>,
    pub techniques: [Option<String>; 2],
    /// Whether the scene's fault is shown on the left, and its cure on the right.
    pub shows_failure: bool,
    /// Whether the settings of the last time are forgotten.
    pub is_fresh: bool,
    /// Shown at first.
    pub message: Option<String>,
    /// When the device is given away, seconds: for tests.
    #[cfg(not(target_arch = "wasm32"))]
    pub loses_device_after: Option<f32>,
    /// Where what is told goes, for tests.
    #[cfg(not(target_arch = "wasm32"))]
    pub told: Option<std::path::PathBuf>,
}

/// What is kept from one time to the next.
#[derive(Serialize, Deserialize)]
pub(crate) struct Saved {
    pub scene: String,
    sides: Vec<SavedSide>,
    pub view: ViewCamera,
    split: Option<f32>,
    picture: Picture,
    /// Files of older programs don't have it.
    #[serde(default)]
    zoom: Option<f32>,
}

/// What the panel shows and changes.
#[derive(Clone)]
pub(crate) struct Settings {
    pub sides: [SideSettings; 2],
    pub lights: Vec<EditLight>,
    /// Index of the light whose handles are shown, and which is measured.
    pub chosen: usize,
    /// Where the two sides meet, as a share of the width; none if one side is shown.
    pub split: Option<f32>,
    /// Which side is shown alone.
    pub shown_side: usize,
    pub picture: Picture,
    pub opacity: f32,
    pub view: ViewCamera,
    pub shows_help: bool,
    pub shows_maps: bool,
    /// Greatest error of a plan, as a share of that of no shadow.
    pub plan_error: f32,
    /// What moves from frame to frame, in costs.
    pub motion: FrameMotion,
    /// How large text is, if the user chose it: 1 is usual.
    pub zoom: Option<f32>,
}

impl Settings {
    pub(crate) fn new(
        stage: &Stage,
        saved: Option<&Saved>,
        techniques: &[Option<String>; 2],
    ) -> Self {
        let range = 0.5 * stage.bounds.diagonal();
        let side = |i: usize, usual: &str| {
            if let Some(name) = &techniques[i] {
                return SideSettings::new(entry(name), range);
            }
            let kept = saved.and_then(|saved| SideSettings::of_saved(saved.sides.get(i)?).ok());
            kept.unwrap_or_else(|| SideSettings::new(entry(usual), range))
        };
        let mut out = Self {
            sides: [side(0, "pcf"), side(1, "exact")],
            lights: Vec::new(),
            chosen: 0,
            split: saved.map_or(Some(0.5), |saved| saved.split),
            shown_side: 0,
            picture: saved.map_or(Picture::Nothing, |saved| saved.picture),
            opacity: 1.0,
            view: ViewCamera::new(&stage.camera, &stage.bounds),
            shows_help: false,
            shows_maps: false,
            plan_error: 0.25,
            motion: FrameMotion::default(),
            zoom: saved.and_then(|saved| saved.zoom),
        };
        out.show(stage);
        out
    }

    /// Takes a scene's lights and camera.
    pub(crate) fn show(&mut self, stage: &Stage) {
        let count = stage.lights.len();
        self.lights = stage
            .lights
            .iter()
            .take(MAX_LIGHTS)
            .map(|light| EditLight::of_scene(*light, count))
            .collect();
        self.chosen = 0;
        self.view = ViewCamera::new(&stage.camera, &stage.bounds);
        for side in &mut self.sides {
            side.range = 0.5 * stage.bounds.diagonal();
        }
    }

    /// Returns what is kept.
    ///
    /// # Errors
    /// Errors if a technique's settings can't be written down.
    pub(crate) fn saved(&self, stage: &Stage) -> Result<Saved> {
        let sides: Result<Vec<SavedSide>> = self.sides.iter().map(SideSettings::saved).collect();
        Ok(Saved {
            scene: stage.argument.clone(),
            sides: sides?,
            view: self.view,
            split: self.split,
            picture: self.picture,
            zoom: self.zoom,
        })
    }
}
