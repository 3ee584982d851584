//! What the user set, and what of it is kept from one time to the next.

use crate::{
    camera::ViewCamera,
    lights::{EditLight, MAX_LIGHTS},
    measure::figures::Picture,
    render::Shown,
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

/// How the first scene is shown, beyond what comes with it.
#[derive(Clone, Copy, Default)]
pub(crate) struct FirstShown {
    pub shown: Option<Shown>,
    pub picture: Option<Picture>,
}

impl FirstShown {
    pub(crate) fn apply(self, settings: &mut Settings) {
        match self.shown {
            Some(Shown::Both(divider)) => settings.split = Some(divider),
            Some(Shown::One(side)) => {
                settings.split = None;
                settings.shown_side = side;
            }
            None => {}
        }
        if let Some(picture) = self.picture {
            settings.picture = picture;
        }
    }
}

/// What is kept from one time to the next.
#[derive(Serialize, Deserialize)]
pub(crate) struct Saved {
    pub scene: String,
    sides: Vec<SavedSide>,
    view: ViewCamera,
    split: Option<f32>,
    picture: Picture,
    // Files of older programs don't have what follows.
    #[serde(default)]
    zoom: Option<f32>,
    /// Whether `lights` are those of the scene, though there may be none.
    #[serde(default)]
    has_lights: bool,
    #[serde(default)]
    lights: Vec<EditLight>,
    #[serde(default)]
    chosen: usize,
    #[serde(default)]
    shown_side: usize,
    #[serde(default)]
    opacity: Option<f32>,
    #[serde(default)]
    shows_maps: bool,
    #[serde(default)]
    plan_error: Option<f32>,
    #[serde(default)]
    motion: FrameMotion,
    #[serde(default)]
    panel_is_folded: Option<bool>,
}

/// How a scene was left the last time: what another scene has for itself.
#[derive(Clone)]
pub(crate) struct SceneAsLeft {
    view: ViewCamera,
    /// None if they weren't kept.
    lights: Option<Vec<EditLight>>,
    chosen: usize,
    /// Of each side's fit, metres.
    ranges: [f32; 2],
}

impl Saved {
    /// Returns how the scene was left.
    pub(crate) fn scene_as_left(&self) -> SceneAsLeft {
        let is_valid = |light: &&EditLight| light.light.validate().is_ok();
        let valid: Vec<_> = self.lights.iter().filter(is_valid).copied().collect();
        // A scene that was left in the dark stays dark; one whose lights are all broken has its own.
        let are_lights = self.has_lights && (!valid.is_empty() || self.lights.is_empty());
        let range = |i: usize| self.sides.get(i).map_or(1.0, SavedSide::range);
        SceneAsLeft {
            view: self.view,
            lights: are_lights.then_some(valid),
            chosen: self.chosen,
            ranges: [range(0), range(1)],
        }
    }
}

impl SceneAsLeft {
    /// Brings settings that show the scene to how it was left.
    pub(crate) fn apply(&self, settings: &mut Settings) {
        settings.view = self.view;
        // Older programs kept no lights.
        if let Some(lights) = &self.lights {
            settings.lights = lights.iter().take(MAX_LIGHTS).copied().collect();
            settings.chosen = self.chosen.min(settings.lights.len().saturating_sub(1));
        }
        for (side, range) in settings.sides.iter_mut().zip(self.ranges) {
            side.range = range;
        }
    }
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
    /// Whether the panel is folded, if the user said so.
    pub panel_is_folded: Option<bool>,
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
            shown_side: saved.map_or(0, |saved| saved.shown_side.min(1)),
            picture: saved.map_or(Picture::Nothing, |saved| saved.picture),
            opacity: saved.and_then(|saved| saved.opacity).unwrap_or(1.0),
            view: ViewCamera::new(&stage.camera, &stage.bounds),
            shows_help: false,
            shows_maps: saved.is_some_and(|saved| saved.shows_maps),
            plan_error: saved.and_then(|saved| saved.plan_error).unwrap_or(0.25),
            motion: saved.map(|saved| saved.motion).unwrap_or_default(),
            zoom: saved.and_then(|saved| saved.zoom),
            panel_is_folded: saved.and_then(|saved| saved.panel_is_folded),
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
            has_lights: true,
            lights: self.lights.clone(),
            chosen: self.chosen,
            shown_side: self.shown_side,
            opacity: Some(self.opacity),
            shows_maps: self.shows_maps,
            plan_error: Some(self.plan_error),
            motion: self.motion,
            panel_is_folded: self.panel_is_folded,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage::{Light, glam::Vec3};

    #[test]
    fn what_is_kept_comes_back() {
        let scene = umbrage::scenes::by_argument("cubes").expect("built in");
        let stage = Stage::of_scene("cubes", "cubes", scene).expect("it can be seen");
        let none = [None, None];
        let mut left = Settings::new(&stage, None, &none);
        left.show(&stage);
        left.sides[0].range = 7.5;
        left.shown_side = 1;
        left.opacity = 0.5;
        left.plan_error = 0.125;
        left.motion = FrameMotion::AllMoves;
        left.shows_maps = true;
        left.panel_is_folded = Some(true);
        left.lights[0].light = Light::Point {
            position: Vec3::new(1.0, 2.0, 3.0),
            radius: 0.25,
        };
        left.lights.push(EditLight::above(&stage.bounds));
        left.lights[1].is_on = false;
        left.chosen = 1;
        let text = serde_json::to_string(&left.saved(&stage).expect("kept")).expect("written");
        let saved: Saved = serde_json::from_str(&text).expect("read");
        let mut again = Settings::new(&stage, Some(&saved), &none);
        again.show(&stage);
        saved.scene_as_left().apply(&mut again);
        assert_eq!(again.sides, left.sides);
        assert_eq!(again.lights, left.lights);
        assert_eq!((again.chosen, again.shown_side), (1, 1));
        assert_eq!((again.opacity, again.plan_error), (0.5, 0.125));
        assert_eq!(again.motion, left.motion);
        assert!(again.shows_maps);
        assert_eq!(again.panel_is_folded, Some(true));
    }

    #[test]
    fn files_of_older_programs_are_read() {
        let scene = umbrage::scenes::by_argument("cubes").expect("built in");
        let stage = Stage::of_scene("cubes", "cubes", scene).expect("it can be seen");
        let settings = Settings::new(&stage, None, &[None, None]);
        let saved = settings.saved(&stage).expect("kept");
        let mut old = serde_json::to_value(&saved).expect("written");
        let of_old = ["scene", "sides", "view", "split", "picture"];
        let object = old.as_object_mut().expect("an object");
        object.retain(|name, _| of_old.contains(&name.as_str()));
        let read: Saved = serde_json::from_value(old).expect("read");
        let mut again = settings.clone();
        read.scene_as_left().apply(&mut again);
        assert_eq!(again.lights, settings.lights, "the scene's own");
    }

    #[test]
    fn broken_lights_are_left_out() {
        let scene = umbrage::scenes::by_argument("cubes").expect("built in");
        let stage = Stage::of_scene("cubes", "cubes", scene).expect("it can be seen");
        let mut settings = Settings::new(&stage, None, &[None, None]);
        settings.lights.push(EditLight::above(&stage.bounds));
        settings.lights[0].light = Light::Point {
            position: Vec3::ZERO,
            radius: -1.0,
        };
        let left = settings.saved(&stage).expect("kept").scene_as_left();
        assert_eq!(left.lights.as_deref(), Some(&settings.lights[1..]));
        settings.lights.truncate(1);
        let left = settings.saved(&stage).expect("kept").scene_as_left();
        assert_eq!(left.lights, None, "the scene's own are better than none");
    }

    #[test]
    fn a_scene_without_lights_stays_dark() {
        let scene = umbrage::scenes::by_argument("cubes").expect("built in");
        let stage = Stage::of_scene("cubes", "cubes", scene).expect("it can be seen");
        let mut settings = Settings::new(&stage, None, &[None, None]);
        let mut again = settings.clone();
        settings.lights.clear();
        let left = settings.saved(&stage).expect("kept").scene_as_left();
        left.apply(&mut again);
        assert!(again.lights.is_empty() && again.chosen == 0);
    }
}
