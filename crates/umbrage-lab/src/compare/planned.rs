//! Making the recipe of a setting, and finding out whether it has been played under another name.

use super::{
    Backends, CompareRow,
    preparation::{Preparation, play_alike, time_of_scene, time_recipe},
    scene::SceneRun,
    slug::NamedSetting,
};
use crate::LabError;
use umbrage_core::{Recipe, RecipeError, ShadowTechnique, View};
use umbrage_plan::motion::follows_camera;

/// A setting that has been played.
pub(super) struct PlayedSetting {
    pub(super) recipe: Recipe,
    /// The first of its rows; it has one for each backend.
    pub(super) first_row: usize,
}

/// A recipe, and what is known of how it comes about.
pub(super) struct Planned {
    pub(super) recipe: Recipe,
    /// None if times aren't measured.
    pub(super) preparation: Option<Preparation>,
    pub(super) kept_as_camera_moves: bool,
}

impl SceneRun<'_> {
    /// Returns the view that recipes are made for.
    fn planning_view(&self) -> View<'_> {
        let view = self.view.core();
        if self.options.knows_receivers {
            view.with_receivers(&self.truth.receivers)
        } else {
            view
        }
    }

    /// Returns why a technique is left out where the few settings of all scenes are compared; `None` if it isn't.
    fn too_slow(&self, technique: &dyn ShadowTechnique) -> Option<String> {
        let entry = self.options.catalogue.find(technique.name())?;
        let most = entry.max_compared_triangles?;
        let triangles = self.view.core().geometry?.triangles().len();
        if !self.options.headline || triangles <= most {
            return None;
        }
        Some(format!(
            "left out of scenes of over {most} triangles, where it takes minutes: name the scene, or ask for all settings"
        ))
    }

    /// Makes a setting's recipe; the inner error is the technique's.
    pub(super) fn planned(
        &mut self,
        technique: &dyn ShadowTechnique,
    ) -> Result<Result<Planned, RecipeError>, LabError> {
        if let Some(reason) = self.too_slow(technique) {
            return Ok(Err(RecipeError::unsupported(reason)));
        }
        let view = self.planning_view();
        if self.options.runs.is_none() {
            return Ok(technique.recipe(&view).map(|recipe| Planned {
                kept_as_camera_moves: !follows_camera(technique, &recipe, &view),
                recipe,
                preparation: None,
            }));
        }
        let (recipe, times) = match time_recipe(technique, &view) {
            Ok(timed) => timed,
            Err(e) => return Ok(Err(e)),
        };
        let kept_as_camera_moves = !follows_camera(technique, &recipe, &view);
        let name = technique.name();
        let known = self.scene_times.iter().find(|known| known.0 == name);
        let scene_ms = match known {
            Some(&(_, ms)) => ms,
            None => {
                let ms = time_of_scene(technique, &view, times.median);
                self.scene_times.push((name, ms));
                ms
            }
        };
        Ok(Ok(Planned {
            recipe,
            preparation: Some(Preparation {
                scene_ms,
                recipe: times,
            }),
            kept_as_camera_moves,
        }))
    }

    /// Returns the first row of a setting that played the same recipe; none if there is none.
    pub(super) fn played_alike(&self, recipe: &Recipe) -> Option<usize> {
        let alike = self
            .played
            .iter()
            .find(|played| play_alike(&played.recipe, recipe))?;
        Some(alike.first_row)
    }

    /// Adds rows with the figures of those from `first_row` on, since they would play the same.
    pub(super) fn repeat(&mut self, setting: &NamedSetting, first_row: usize, backends: &Backends) {
        for i in 0..backends.playing.len() {
            let like = &self.rows[first_row + i];
            let row = CompareRow {
                technique: setting.name.clone(),
                settings: setting.settings.clone(),
                slug: setting.slug.clone(),
                backend: like.backend.clone(),
                same_as: Some(format!("{} ({})", like.technique, like.settings)),
                outcome: like.outcome.clone(),
            };
            self.rows.push(row);
            self.masks.push(self.masks[first_row + i].clone());
            self.colors.push(self.colors[first_row + i].clone());
            self.lookups.push(self.lookups[first_row + i].clone());
        }
    }
}
