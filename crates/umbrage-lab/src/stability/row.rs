//! The types of the catalogue of failures: rows and their cases.

use super::measure::Measure;
use umbrage_core::Fit;
use umbrage_scenes::{
    SceneEntry,
    motion::{Motion, MovingScene},
};
use umbrage_techniques::TechniquePreset;

/// A way in which shadow methods fail, and the scenes that provoke it.
#[derive(Clone, Copy, Debug)]
pub struct StabilityRow {
    /// Its number in the catalogue of failures.
    pub number: u8,
    /// A few words.
    pub title: &'static str,
    /// What fails, and why, in a sentence.
    pub weakness: &'static str,
    /// Techniques that the row is about and that umbrage doesn't have yet.
    pub not_yet: Option<&'static str>,
    /// Scenes, each with its measure.
    pub cases: &'static [StabilityCase],
}

/// One scene, still or moving, with the measure that shows the failure.
#[derive(Clone, Copy, Debug)]
pub struct StabilityCase {
    /// For file names and the command line; the scene's name, and the motion if there is one.
    pub name: &'static str,
    /// The built-in scene.
    pub scene: &'static str,
    /// The scene's lights that count, from the first on; masks are means over them.
    pub lights: usize,
    /// What moves.
    pub motion: Motion,
    /// What is measured.
    pub measure: Measure,
    /// How maps are fitted. With another fit than the tight one, only techniques with a map are
    /// played, by the limits of the tight one: what another costs in texels is charged as error.
    pub fit: Fit,
    /// The scene that limits are taken from, if not the case's own: the same where coordinates are
    /// fine enough for truth to be traced at texels' centres. See [`Measure::limits_from`].
    pub limits_from: Option<&'static str>,
    /// Settings tried in addition to those of the catalogue, for this map size.
    pub extra: Option<fn(map_size: u32) -> Vec<TechniquePreset>>,
}

impl StabilityCase {
    /// A still scene.
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

    /// A moving scene. While light and casters stand still nothing may change; else as much may
    /// change as in truth.
    pub(super) const fn moving(moving: MovingScene) -> Self {
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

    /// The same case under another name: a scene with two measures.
    pub(super) const fn named(self, name: &'static str) -> Self {
        Self { name, ..self }
    }

    /// Returns the case under another name, with maps whose fit moves by whole texels:
    /// [`Fit::Stable`], also for `range`.
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

    /// Returns the case with settings tried in addition to those of the catalogue:
    /// [`StabilityCase::extra`].
    pub(super) const fn also(self, extra: fn(map_size: u32) -> Vec<TechniquePreset>) -> Self {
        Self {
            extra: Some(extra),
            ..self
        }
    }

    /// Returns the scene's entry in the catalogue of scenes; none if there is no scene of that
    /// name, which a test rules out.
    pub fn entry(&self) -> Option<&'static SceneEntry> {
        umbrage_scenes::find(self.scene)
    }
}

impl StabilityRow {
    /// Whether `word` is this row's number, as `3` or `#3`.
    pub fn is_called(&self, word: &str) -> bool {
        word.trim_start_matches('#').parse() == Ok(self.number)
    }
}
