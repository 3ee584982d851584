//! Settings of the user, mostly saved.

use crate::{
    camera::ViewCamera,
    lights::{EditLight, MAX_LIGHTS},
    measure::pictures::Picture,
    side::{SideSettings, entry},
    stage::ViewerScene,
};
use serde::{Deserialize, Serialize};
use umbrage::{Aabb, plan::motion::FrameMotion};

/// Options of the program's start.
#[derive(Default)]
pub(crate) struct Start {
    pub scene: Option<String>,
    pub techniques: [Option<String>; 2],
    /// `true` to show the scene's artefact on the left, and its fix on the right.
    pub shows_failure: bool,
    /// `true` to ignore saved settings.
    pub is_fresh: bool,
    /// First message.
    pub message: Option<String>,
    /// Seconds until the device is destroyed, for tests.
    #[cfg(not(target_arch = "wasm32"))]
    pub loses_device_after: Option<f32>,
    /// File for reports, for tests.
    #[cfg(not(target_arch = "wasm32"))]
    pub report: Option<std::path::PathBuf>,
}

/// Changes to the settings of the first scene.
#[derive(Clone, Copy, Default)]
pub(crate) struct FirstShown {
    /// [`Settings::split`] and [`Settings::shown_side`].
    pub sides: Option<(Option<f32>, usize)>,
    pub picture: Option<Picture>,
}

impl FirstShown {
    pub(crate) fn apply(self, settings: &mut Settings) {
        if let Some(sides) = self.sides {
            (settings.split, settings.shown_side) = sides;
        }
        if let Some(picture) = self.picture {
            settings.picture = picture;
        }
    }
}

/// Settings of the user. Files of older versions have fewer of them.
#[derive(Clone, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct Settings {
    /// Argument of the scene at the time of saving.
    scene: String,
    #[serde(with = "list_of_two")]
    pub sides: [SideSettings; 2],
    /// `true` if `lights` are those of the scene, even if there are none.
    has_lights: bool,
    pub lights: Vec<EditLight>,
    /// Index of the selected light, which is measured and has handles.
    pub chosen: usize,
    /// Position of the divider, as a fraction of the width. `None` if one side is shown.
    pub split: Option<f32>,
    /// Index of the side that is shown alone.
    pub shown_side: usize,
    pub picture: Picture,
    /// Opacity of overlays. `None` for the default.
    pub opacity: Option<f32>,
    pub view: ViewCamera,
    #[serde(skip)]
    pub shows_help: bool,
    pub shows_maps: bool,
    /// Greatest error of a plan, as a fraction of the error without shadows. `None` for the
    /// default.
    pub plan_error: Option<f32>,
    /// Motion from frame to frame, for costs.
    pub motion: FrameMotion,
    /// Size of text relative to the usual one. `None` for the default.
    pub zoom: Option<f32>,
    /// State of the panel: folded or not. `None` for the default.
    pub panel_is_folded: Option<bool>,
}

/// Saves sides as a list.
mod list_of_two {
    use crate::side::SideSettings;
    use serde::{Deserialize as _, Deserializer, Serialize as _, Serializer, de::Error as _};

    pub(super) fn serialize<S: Serializer>(
        sides: &[SideSettings; 2],
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        sides.as_slice().serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<[SideSettings; 2], D::Error> {
        let sides = Vec::<SideSettings>::deserialize(deserializer)?;
        <[SideSettings; 2]>::try_from(sides)
            .map_err(|_| D::Error::custom("settings have two sides"))
    }
}

impl Default for Settings {
    fn default() -> Self {
        let stage = ViewerScene::nothing();
        Self {
            scene: String::new(),
            sides: ["pcf", "exact"].map(|name| SideSettings::new(entry(name), 1.0)),
            has_lights: false,
            lights: Vec::new(),
            chosen: 0,
            split: Some(0.5),
            shown_side: 0,
            picture: Picture::Nothing,
            opacity: None,
            view: ViewCamera::new(&stage.camera, &stage.bounds),
            shows_help: false,
            shows_maps: false,
            plan_error: None,
            motion: FrameMotion::default(),
            zoom: None,
            panel_is_folded: None,
        }
    }
}

impl Settings {
    /// Returns the settings of a new window without a scene.
    pub(crate) fn new(saved: Option<&Self>, techniques: &[Option<String>; 2]) -> Self {
        let mut out = saved.cloned().unwrap_or_default();
        for (side, name) in out.sides.iter_mut().zip(techniques) {
            if let Some(name) = name {
                *side = SideSettings::new(entry(name), side.range);
            }
            side.cascades = side.cascades.clamp(1, 8);
        }
        out.shown_side = out.shown_side.min(1);
        out.show(&ViewerScene::nothing());
        out
    }

    /// Adopts a scene's lights and camera.
    pub(crate) fn show(&mut self, stage: &ViewerScene) {
        let count = stage.lights.len();
        let lights = stage.lights.iter().take(MAX_LIGHTS);
        self.lights = lights
            .map(|light| EditLight::of_scene(*light, count))
            .collect();
        self.chosen = 0;
        self.view = ViewCamera::new(&stage.camera, &stage.bounds);
        for side in &mut self.sides {
            side.range = 0.5 * stage.bounds.diagonal();
        }
    }

    /// Adopts view and lights from saved settings of the same scene.
    pub(crate) fn show_as_left(&mut self, saved: &Self) {
        self.view = saved.view;
        let is_valid = |light: &&EditLight| light.light.validate().is_ok();
        let valid = saved.lights.iter().filter(is_valid);
        let valid: Vec<_> = valid.take(MAX_LIGHTS).copied().collect();
        // Keep a saved scene without lights dark. Use the scene's lights if all saved ones are
        // invalid or none were saved.
        if saved.has_lights && (!valid.is_empty() || saved.lights.is_empty()) {
            self.lights = valid;
            self.chosen = saved.chosen.min(self.lights.len().saturating_sub(1));
        }
        for (side, saved) in self.sides.iter_mut().zip(&saved.sides) {
            side.range = saved.range;
        }
    }

    /// Returns the settings to save.
    pub(crate) fn to_save(&self, stage: &ViewerScene) -> Self {
        Self {
            scene: stage.argument.clone(),
            has_lights: true,
            ..self.clone()
        }
    }

    /// Returns the argument of the scene in the saved settings.
    pub(crate) fn saved_scene(&self) -> &str {
        &self.scene
    }

    /// Adds a light above the scene, unless there are too many, and selects it.
    pub(crate) fn add_light(&mut self, bounds: &Aabb) {
        if self.lights.len() < MAX_LIGHTS {
            self.chosen = self.lights.len();
            self.lights.push(EditLight::above_bounds(bounds));
        }
    }

    /// Removes the selected light.
    pub(crate) fn remove_light(&mut self) {
        if self.chosen < self.lights.len() {
            self.lights.remove(self.chosen);
            self.chosen = self.chosen.saturating_sub(1);
        }
    }

    pub(crate) fn opacity(&self) -> f32 {
        self.opacity.unwrap_or(1.0)
    }

    pub(crate) fn plan_error(&self) -> f32 {
        self.plan_error.unwrap_or(0.25)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage::{Light, glam::Vec3};

    /// Returns a built-in scene, and settings for it.
    fn shown_settings() -> (ViewerScene, Settings) {
        let scene = umbrage::scenes::by_argument("cubes").expect("built in");
        let stage = ViewerScene::of_scene("cubes", "cubes", scene).expect("it can be seen");
        let mut settings = Settings::new(None, &[None, None]);
        settings.show(&stage);
        (stage, settings)
    }

    #[test]
    fn what_is_kept_comes_back() {
        let (stage, mut left) = shown_settings();
        left.sides[0].range = 7.5;
        left.shown_side = 1;
        left.opacity = Some(0.5);
        left.plan_error = Some(0.125);
        left.motion = FrameMotion::AllMoves;
        left.shows_maps = true;
        left.panel_is_folded = Some(true);
        left.lights[0].light = Light::Point {
            position: Vec3::new(1.0, 2.0, 3.0),
            radius: 0.25,
        };
        left.lights.push(EditLight::above_bounds(&stage.bounds));
        left.lights[1].is_on = false;
        left.chosen = 1;
        let text = serde_json::to_string(&left.to_save(&stage)).expect("written");
        let saved: Settings = serde_json::from_str(&text).expect("read");
        assert_eq!(saved.saved_scene(), "cubes");
        let mut again = Settings::new(Some(&saved), &[None, None]);
        again.show(&stage);
        again.show_as_left(&saved);
        assert_eq!(again.sides, left.sides);
        assert_eq!(again.lights, left.lights);
        assert_eq!((again.chosen, again.shown_side), (1, 1));
        assert_eq!((again.opacity(), again.plan_error()), (0.5, 0.125));
        assert_eq!(again.motion, left.motion);
        assert!(again.shows_maps);
        assert_eq!(again.panel_is_folded, Some(true));
    }

    #[test]
    fn files_of_older_programs_are_read() {
        let (stage, settings) = shown_settings();
        let saved = settings.to_save(&stage);
        let mut old = serde_json::to_value(&saved).expect("written");
        let of_old = ["scene", "sides", "view", "split", "picture"];
        let object = old.as_object_mut().expect("an object");
        object.retain(|name, _| of_old.contains(&name.as_str()));
        let read: Settings = serde_json::from_value(old).expect("read");
        let mut again = settings.clone();
        again.show_as_left(&read);
        assert_eq!(again.lights, settings.lights, "the scene's own");
    }

    #[test]
    fn broken_lights_are_left_out() {
        let (stage, mut settings) = shown_settings();
        let mut again = settings.clone();
        settings.lights[0].light = Light::Point {
            position: Vec3::ZERO,
            radius: -1.0,
        };
        let own = again.lights.clone();
        settings.lights.truncate(1);
        again.show_as_left(&settings.to_save(&stage));
        assert_eq!(again.lights, own, "the scene's own are better than none");
        settings.lights.push(EditLight::above_bounds(&stage.bounds));
        again.show_as_left(&settings.to_save(&stage));
        assert_eq!(again.lights, settings.lights[1..]);
    }

    #[test]
    fn a_scene_without_lights_stays_dark() {
        let (stage, mut settings) = shown_settings();
        let mut again = settings.clone();
        settings.lights.clear();
        again.show_as_left(&settings.to_save(&stage));
        assert!(again.lights.is_empty() && again.chosen == 0);
    }
}
