//! Options of a comparison.

use crate::LabError;
use glam::UVec2;
use std::{sync::Arc, time::Duration};
use umbrage_core::{Camera, Fit, Invalid, Scene, ShadowTechnique};
use umbrage_plan::truth::TruthOptions;
use umbrage_techniques::Techniques;

/// A scene to be compared.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneInput {
    /// The scene; its first camera and first light count.
    pub scene: Scene,
    /// One line about it for the report, maybe empty.
    pub summary: String,
    /// A fit set by hand, as textbooks do; techniques with a map are compared under it, too.
    pub fit: Option<Fit>,
}

/// How a comparison is made.
#[derive(Clone, Debug, PartialEq)]
pub struct CompareOptions {
    /// The techniques that there are.
    pub registry: Techniques,
    /// Names of those that are compared; all when empty.
    pub techniques: Vec<String>,
    /// Sides of the shadow maps, texels.
    pub map_sizes: Vec<u32>,
    /// The most settings of each technique that are compared; none: all of them.
    pub max_settings: Option<usize>,
    /// Image size instead of the cameras' own, pixels; the vertical field of view stays.
    pub size: Option<UVec2>,
    /// How truth is traced.
    pub truth: TruthOptions,
    /// Timed runs of each row, after one that compiles and uploads; their median counts. None: no times and no date, so that the
    /// results are the same whenever they are made.
    pub runs: Option<Runs>,
    /// Whether every row is rendered in color, too.
    pub color: bool,
}

/// How often a row is played to be timed: slow rows seldom, quick rows often, since their noise is greater.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Runs {
    /// At least this often, 1 or more.
    #[serde(rename = "least")]
    pub min: u32,
    /// Never more often.
    #[serde(rename = "most")]
    pub max: u32,
    /// In between, until this much time has been spent on the row, milliseconds; a quarter more goes into its yardstick.
    pub budget_ms: u32,
}

impl Runs {
    /// Returns options for this many runs, however long they take.
    pub fn exactly(count: u32) -> Self {
        Self {
            min: count,
            max: count,
            budget_ms: 0,
        }
    }

    /// Whether `done` runs that took `spent` are enough.
    pub(super) fn suffice(&self, done: usize, spent: Duration) -> bool {
        let min = self.min.max(1) as usize;
        let is_spent = done >= self.max as usize || spent >= self.budget();
        done >= min && is_spent
    }

    /// Whether a row that other programs held up may be played again in the hope of calmer runs: for up to twice as long.
    pub(super) fn hopes(&self, done: usize, spent: Duration) -> bool {
        done < self.max as usize && spent < 2 * self.budget()
    }

    fn budget(&self) -> Duration {
        Duration::from_millis(self.budget_ms.into())
    }
}

impl Default for Runs {
    /// Five runs are the fewest that a [baseline](crate::baseline::times) judges; quick rows get up to fifteen.
    fn default() -> Self {
        Self {
            min: 5,
            max: 15,
            budget_ms: 60,
        }
    }
}

impl Default for CompareOptions {
    fn default() -> Self {
        Self {
            registry: Techniques::built_in(),
            techniques: Vec::new(),
            map_sizes: vec![512, 1024, 2048],
            max_settings: None,
            size: None,
            truth: TruthOptions::default(),
            runs: Some(Runs::default()),
            color: false,
        }
    }
}

impl CompareOptions {
    /// Returns options for a quick preview: small images, one map size, few settings, few samples, few runs.
    pub fn quick() -> Self {
        Self {
            map_sizes: vec![512],
            max_settings: Some(3),
            size: Some(UVec2::new(160, 120)),
            truth: TruthOptions {
                samples: 64,
                probe_samples: 16,
                ..TruthOptions::default()
            },
            runs: Some(Runs {
                max: 9,
                budget_ms: 20,
                ..Runs::default()
            }),
            ..Self::default()
        }
    }

    /// Returns the technique settings to be compared, their maps under this fit.
    ///
    /// # Errors
    /// Errors if a name is unknown or a map size is missing.
    pub(super) fn settings(&self, fit: Fit) -> Result<Vec<Arc<dyn ShadowTechnique>>, LabError> {
        let chosen = self.registry.select(&self.techniques)?;
        if self.map_sizes.is_empty() {
            return Err(Invalid::new(
                "map sizes",
                "are missing",
                "give at least one, such as 1024",
            )
            .into());
        }
        let max = self.max_settings.unwrap_or(usize::MAX);
        let mut out = Vec::new();
        for entry in chosen {
            let of_entry = (entry.settings)(&self.map_sizes, fit);
            out.extend(of_entry.into_iter().take(max));
        }
        Ok(out)
    }

    /// Returns a scene's camera with the wanted image size.
    pub(super) fn camera(&self, camera: &Camera) -> Camera {
        self.size.map_or(*camera, |size| camera.resized(size))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quick_rows_are_played_more_often_than_slow_ones() {
        let runs = Runs::default();
        let played =
            |ms: u64| (0..).find(|&n| runs.suffice(n, Duration::from_millis(ms * n as u64)));
        assert_eq!([0, 4, 10, 1_000].map(played), [15, 15, 6, 5].map(Some));
        assert!(
            Runs::exactly(2).suffice(2, Duration::ZERO)
                && !Runs::exactly(2).suffice(1, Duration::MAX)
        );
        assert!(
            !Runs::exactly(0).suffice(0, Duration::MAX),
            "no run, no time"
        );
        let hopes = |n, ms| runs.hopes(n, Duration::from_millis(ms));
        assert!(
            hopes(14, 119)
                && !hopes(15, 100)
                && !hopes(5, 120)
                && !Runs::exactly(3).hopes(3, Duration::ZERO)
        );
    }
}
