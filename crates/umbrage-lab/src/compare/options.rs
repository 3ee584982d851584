//! Options of a comparison.

use glam::UVec2;
use std::time::Duration;
use umbrage_core::{Camera, Fit, Invalid, Light, Scene};
use umbrage_plan::{
    catalogue::Catalogue, cost::PriceList, motion::FrameMotion, truth::TruthOptions,
};
use umbrage_techniques::TechniquePreset;

/// What a scene is compared for.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize,
)]
#[serde(rename_all = "snake_case")]
pub enum Section {
    /// A frame as programs have them: the charts over all scenes are about these.
    Content,
    /// A small scene in which something can go wrong. It is in charts over all scenes only where
    /// there is no content.
    #[default]
    Check,
}

/// A scene to be compared.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneInput {
    /// The scene; its first camera and first light count.
    pub scene: Scene,
    /// One line about it for the report, maybe empty.
    pub summary: String,
    /// A fit set by hand, as textbooks do; techniques with a map are compared under it, too.
    pub fit: Option<Fit>,
    /// What it is compared for.
    pub section: Section,
    /// How it is compared; none: as the comparison's options say.
    pub options: Option<Box<CompareOptions>>,
}

impl SceneInput {
    /// Returns a scene that is a [check](Section::Check), compared by the comparison's options and
    /// without a fit set by hand.
    pub fn new(scene: Scene, summary: impl Into<String>) -> Self {
        Self {
            scene,
            summary: summary.into(),
            fit: None,
            section: Section::Check,
            options: None,
        }
    }

    /// Returns the scene's first camera and first light, which are the ones compared.
    pub(super) fn camera_and_light(&self) -> Result<(&Camera, &Light), Invalid> {
        let scene = &self.scene;
        let camera = scene.cameras.first();
        let light = scene.lights.first();
        let camera = camera.ok_or_else(|| missing(scene, "camera"))?;
        let light = light.ok_or_else(|| missing(scene, "light"))?;
        Ok((camera, light))
    }

    /// Returns the options by which the scene is compared: its own, or else these.
    pub fn options_or<'a>(&'a self, of_all: &'a CompareOptions) -> &'a CompareOptions {
        self.options.as_deref().unwrap_or(of_all)
    }
}

fn missing(scene: &Scene, what: &str) -> Invalid {
    Invalid::new(
        format!("scene `{}`", scene.name),
        format!("has no {what}"),
        "add one",
    )
}

/// A technique with settings of the user's, compared under a name of its own.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedPreset {
    /// Its name in rows, charts and file names: that of no technique, and of no other preset.
    pub name: String,
    /// The technique and its settings.
    pub preset: TechniquePreset,
}

/// How a comparison is made.
#[derive(Clone, Debug, PartialEq)]
pub struct CompareOptions {
    /// The techniques that there are.
    pub catalogue: Catalogue,
    /// Names of those that are compared; all when empty.
    pub techniques: Vec<String>,
    /// Whether techniques that are not named are left out if they take too long for a preview: see
    /// [`CataloguedTechnique::IS_PREVIEWED`](umbrage_plan::catalogue::CataloguedTechnique::IS_PREVIEWED).
    pub is_preview: bool,
    /// Settings of the user's, played before the others; they are neither cut by
    /// [`max_settings`](Self::max_settings) nor put on other maps.
    pub presets: Vec<NamedPreset>,
    /// Sides of the shadow maps, texels.
    pub map_sizes: Vec<u32>,
    /// The most settings of each technique that are compared; none: all of them.
    pub max_settings: Option<usize>,
    /// Whether only the few settings are compared that stand for each technique: see
    /// [`CataloguedTechnique::headline`](umbrage_plan::catalogue::CataloguedTechnique::headline).
    pub headline: bool,
    /// Whether recipes are made with the receivers that are seen, so that maps lie tightly around
    /// them. Programs rarely have them: a renderer on the GPU would have to read them back.
    pub knows_receivers: bool,
    /// What moves from frame to frame: which times make up a row's sum.
    pub motion: FrameMotion,
    /// What work costs.
    pub prices: PriceList,
    /// Image size instead of the cameras' own, pixels; the vertical field of view stays.
    pub size: Option<UVec2>,
    /// How truth is traced.
    pub truth: TruthOptions,
    /// Timed runs of each row, after one that compiles and uploads; their median counts. None: no
    /// times and no date, so that the results are the same whenever they are made.
    pub runs: Option<Runs>,
    /// Whether every row is rendered in color, too.
    pub color: bool,
}

/// How often a row is played to be timed: slow rows seldom, quick rows often, since their noise is
/// greater.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Runs {
    /// At least this often, 1 or more.
    #[serde(rename = "least")]
    pub min: u32,
    /// Never more often.
    #[serde(rename = "most")]
    pub max: u32,
    /// In between, until this much time has been spent on the row, milliseconds; a quarter more
    /// goes into its yardstick, if the least number of runs is as many as baselines need.
    pub budget_ms: u32,
    /// A row whose first play took this long, milliseconds, is timed once, without a yardstick.
    #[serde(default = "never")]
    pub once_from_ms: u32,
}

/// Returns more milliseconds than a row takes.
fn never() -> u32 {
    u32::MAX
}

/// Rows with fewer runs are not judged by [baselines](crate::baseline::times).
pub const MIN_JUDGED_RUNS: u32 = 5;

impl Runs {
    /// Whether a row whose first play took so long is timed once.
    pub(super) fn one_is_enough(&self, first: Duration) -> bool {
        first >= Duration::from_millis(self.once_from_ms.into())
    }

    /// Whether a first play took so long that what was compiled in it matters little.
    pub(super) fn dwarfs_compilation(&self, first: Duration) -> bool {
        first >= Duration::from_millis(self.once_from_ms.into()) * 4
    }

    /// Returns options for this many runs, however long they take.
    pub fn exactly(count: u32) -> Self {
        Self {
            min: count,
            max: count,
            budget_ms: 0,
            once_from_ms: never(),
        }
    }

    /// Whether every row gets as many runs as a baseline needs to judge it.
    pub(super) fn suffice_for_baselines(&self) -> bool {
        self.min >= MIN_JUDGED_RUNS
    }

    /// Whether `done` runs that took `spent` are enough.
    pub(super) fn suffice(&self, done: usize, spent: Duration) -> bool {
        let min = self.min.max(1) as usize;
        let is_spent = done >= self.max as usize || spent >= self.budget();
        done >= min && is_spent
    }

    /// Whether a row that other programs held up may be played again in the hope of calmer runs:
    /// for up to twice as long.
    pub(super) fn hopes(&self, done: usize, spent: Duration) -> bool {
        done < self.max as usize && spent < 2 * self.budget()
    }

    fn budget(&self) -> Duration {
        Duration::from_millis(self.budget_ms.into())
    }
}

impl Default for Runs {
    /// As many runs as a [baseline](crate::baseline::times) needs; quick rows get up to fifteen.
    fn default() -> Self {
        Self {
            min: MIN_JUDGED_RUNS,
            max: 15,
            budget_ms: 30,
            once_from_ms: never(),
        }
    }
}

impl Default for CompareOptions {
    fn default() -> Self {
        Self {
            catalogue: Catalogue::built_in(),
            techniques: Vec::new(),
            is_preview: false,
            presets: Vec::new(),
            map_sizes: vec![512, 1024, 2048],
            max_settings: None,
            headline: false,
            knows_receivers: true,
            motion: FrameMotion::default(),
            prices: PriceList::default(),
            size: None,
            truth: TruthOptions::default(),
            runs: Some(Runs::default()),
            color: false,
        }
    }
}

impl CompareOptions {
    /// Returns options for a quick preview: small images, one map size, few settings, few samples,
    /// few runs, and only techniques that don't take long.
    pub fn quick() -> Self {
        Self {
            is_preview: true,
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

    /// Returns options for frames of real size: the scene's own image size, the few settings that
    /// stand for each technique on larger maps, and truth at one of each 5 x 5 pixels.
    pub fn content() -> Self {
        Self {
            map_sizes: vec![1024, 2048],
            headline: true,
            knows_receivers: false,
            truth: TruthOptions {
                samples: 128,
                block_side: 5,
                ..TruthOptions::default()
            },
            // Rows of seconds are played once, or the suite would take an hour.
            runs: Some(Runs {
                min: 1,
                max: 5,
                budget_ms: 150,
                once_from_ms: 400,
            }),
            ..Self::default()
        }
    }

    /// Returns options for a quick preview of frames of real size: small images, one map size.
    pub fn quick_content() -> Self {
        Self {
            map_sizes: vec![1024],
            headline: true,
            knows_receivers: false,
            size: Some(UVec2::new(320, 180)),
            truth: TruthOptions {
                block_side: 2,
                ..Self::quick().truth
            },
            ..Self::quick()
        }
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
        assert_eq!([0, 4, 10, 1_000].map(played), [15, 8, 5, 5].map(Some));
        assert!(
            Runs::exactly(2).suffice(2, Duration::ZERO)
                && !Runs::exactly(2).suffice(1, Duration::MAX)
        );
        assert!(runs.suffice_for_baselines() && !Runs::exactly(2).suffice_for_baselines());
        let content = CompareOptions::content().runs.expect("timed");
        let second = Duration::from_secs(1);
        assert!(content.one_is_enough(second) && !runs.one_is_enough(60 * second));
        assert!(!content.one_is_enough(second / 4));
        assert!(
            !Runs::exactly(0).suffice(0, Duration::MAX),
            "no run, no time"
        );
        let hopes = |n, ms| runs.hopes(n, Duration::from_millis(ms));
        assert!(
            hopes(14, 59)
                && !hopes(15, 50)
                && !hopes(5, 60)
                && !Runs::exactly(3).hopes(3, Duration::ZERO)
        );
    }
}
