//! Types of the failure catalogue: rows and their cases.

use super::measure::Measure;
use umbrage_core::Fit;
use umbrage_scenes::{
    SceneEntry,
    motion::{Motion, MovingScene},
};
use umbrage_techniques::TechniquePreset;

/// A failure of shadow methods, and the scenes that provoke it.
#[derive(Clone, Copy, Debug)]
pub struct StabilityRow {
    /// Number in the failure catalogue.
    pub number: u8,
    /// Title of a few words.
    pub title: &'static str,
    /// Failure and its cause, in one sentence.
    pub weakness: &'static str,
    /// Techniques that the row concerns and that umbrage doesn't have yet.
    pub not_yet: Option<&'static str>,
    /// Scenes, each with its measure.
    pub cases: &'static [StabilityCase],
}

/// One scene, still or moving, with the measure that shows the failure.
#[derive(Clone, Copy, Debug)]
pub struct StabilityCase {
    /// Name for files and the command line: the scene's name, and the motion if there is one.
    pub name: &'static str,
    /// Name of the built-in scene.
    pub scene: &'static str,
    /// Number of the scene's lights that count, from the first on; masks are means over them.
    pub lights: usize,
    /// The motion.
    pub motion: Motion,
    /// The measure.
    pub measure: Measure,
    /// Fit of the maps. With another fit than the tight one, only techniques with a map run. They
    /// are judged by the limits of the tight fit, so coarser texels count as error.
    pub fit: Fit,
    /// Scene that limits are derived from, if not the case's own: the same scene where coordinates
    /// are fine enough to trace truth at texel centres. See [`Measure::limits_from`].
    pub limits_from: Option<&'static str>,
    /// Settings that run in addition to those of the catalogue, for this map size.
    pub extra: Option<fn(map_size: u32) -> Vec<TechniquePreset>>,
}

impl StabilityCase {
    /// Returns a case of a still scene.
    pub(super) const fn still(scene: &'static str, measure: Measure) -> Self {
        Self {
            name: scene,
            scene,
            lights: 1,
            motion: Motion::Still,
            measure,
            fit: Fit::Tight,
            limits_from: None,
            extra: None,
        }
    }

    /// Returns a case of a moving scene. While light and casters stand still nothing may change;
    /// otherwise as much may change as in truth.
    pub(super) const fn moving_case(moving: MovingScene) -> Self {
        let measure = if moving.motion.moves_shadows() {
            Measure::ChangeError
        } else {
            Measure::Shimmer
        };
        Self {
            name: moving.name,
            motion: moving.motion,
            ..Self::still(moving.scene, measure)
        }
    }

    /// Returns the same case under another name, for a scene with two measures.
    pub(super) const fn with_name(self, name: &'static str) -> Self {
        Self { name, ..self }
    }

    /// Returns the case under another name, with maps whose fit moves by whole texels:
    /// [`Fit::Stable`] with this `range`.
    pub(super) const fn stable(self, name: &'static str, range: f32) -> Self {
        Self {
            name,
            fit: Fit::Stable { range },
            ..self
        }
    }

    /// Returns the case with the limits of another scene: [`StabilityCase::limits_from`].
    pub(super) const fn limits_from(self, scene: &'static str) -> Self {
        Self {
            limits_from: Some(scene),
            ..self
        }
    }

    /// Returns the case with settings that run in addition to those of the catalogue:
    /// [`StabilityCase::extra`].
    pub(super) const fn with_settings(
        self,
        extra: fn(map_size: u32) -> Vec<TechniquePreset>,
    ) -> Self {
        Self {
            extra: Some(extra),
            ..self
        }
    }

    /// Returns the scene's entry in the scene catalogue. A test checks that it is never `None`.
    pub fn entry(&self) -> Option<&'static SceneEntry> {
        umbrage_scenes::find(self.scene)
    }
}

impl StabilityRow {
    /// Reports whether `word` is this row's number, as `3` or `#3`.
    pub fn is_called(&self, word: &str) -> bool {
        word.trim_start_matches('#').parse() == Ok(self.number)
    }
}
