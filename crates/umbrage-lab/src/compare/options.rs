//! Options of a comparison.

use glam::UVec2;
use std::time::Duration;
use umbrage_core::{Camera, Fit, Invalid, Light, Scene};
use umbrage_plan::{
    catalogue::Catalogue, cost::PriceList, motion::FrameMotion, truth::TruthOptions,
};
use umbrage_techniques::TechniquePreset;

/// The purpose of a scene in a comparison.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize,
)]
#[serde(rename_all = "snake_case")]
pub enum Section {
    /// A full-size scene, as in typical programs. Charts over all scenes show these.
    Content,
    /// A small scene in which something can go wrong. Charts over all scenes show it only if there
    /// is no content.
    #[default]
    Check,
}

/// A scene to compare.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneInput {
    /// The scene. Its first camera and first light are used.
    pub scene: Scene,
    /// One line about it for the report. May be empty.
    pub summary: String,
    /// Manual fit, as in textbooks. Techniques with a map are also compared under it.
    pub fit: Option<Fit>,
    /// The scene's purpose.
    pub section: Section,
    /// The scene's own options. `None` for those of the comparison.
    pub options: Option<Box<CompareOptions>>,
}

impl SceneInput {
    /// Returns a scene that is a [check](Section::Check), with the comparison's options and without
    /// a manual fit.
    pub fn new(scene: Scene, summary: impl Into<String>) -> Self {
        Self {
            scene,
            summary: summary.into(),
            fit: None,
            section: Section::Check,
            options: None,
        }
    }

    /// Returns the scene's first camera and first light, which are used.
    pub(super) fn camera_and_light(&self) -> Result<(&Camera, &Light), Invalid> {
        let scene = &self.scene;
        let camera = scene.cameras.first();
        let light = scene.lights.first();
        let camera = camera.ok_or_else(|| missing_input(scene, "camera"))?;
        let light = light.ok_or_else(|| missing_input(scene, "light"))?;
        Ok((camera, light))
    }

    /// Returns the scene's options, or else these.
    pub fn options_or<'a>(&'a self, of_all: &'a CompareOptions) -> &'a CompareOptions {
        self.options.as_deref().unwrap_or(of_all)
    }
}

fn missing_input(scene: &Scene, what: &str) -> Invalid {
    Invalid::new(
        format!("scene `{}`", scene.name),
        format!("has no {what}"),
        "add one",
    )
}

/// A technique with the user's settings, compared under its own name.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedPreset {
    /// Name in rows, charts and file names. Differs from all techniques and other presets.
    pub name: String,
    /// The technique and its settings.
    pub preset: TechniquePreset,
}

/// Options of a comparison.
#[derive(Clone, Debug, PartialEq)]
pub struct CompareOptions {
    /// The available techniques.
    pub catalogue: Catalogue,
    /// Names of the techniques to compare. Empty for all.
    pub techniques: Vec<String>,
    /// Whether expensive techniques are skipped unless they are named, as in previews: see
    /// [`IS_PREVIEWED`](umbrage_plan::catalogue::CataloguedTechnique::IS_PREVIEWED).
    pub is_preview: bool,
    /// The user's settings, compared before all others. [`max_settings`](Self::max_settings) and
    /// the map sizes don't apply to them.
    pub presets: Vec<NamedPreset>,
    /// Sides of the shadow maps, texels.
    pub map_sizes: Vec<u32>,
    /// Maximum number of settings per technique. `None` for all.
    pub max_settings: Option<usize>,
    /// Whether only the representative settings of each technique are compared: see
    /// [`CataloguedTechnique::headline`](umbrage_plan::catalogue::CataloguedTechnique::headline).
    pub headline: bool,
    /// Whether recipes are made with the visible receivers, for a tight fit of maps. Programs
    /// rarely have them, since a GPU renderer would have to read them back.
    pub knows_receivers: bool,
    /// Motion between frames, which decides the parts of a frame time.
    pub motion: FrameMotion,
    /// Prices of work.
    pub prices: PriceList,
    /// Image size that replaces that of the cameras, pixels. The vertical field of view is kept.
    pub size: Option<UVec2>,
    /// Options for tracing truth.
    pub truth: TruthOptions,
    /// Number of timed runs of each row, after one that compiles and uploads. The median is
    /// reported. `None` omits times and date, so that results are the same on every run.
    pub runs: Option<Runs>,
    /// Whether every row is also rendered in colour.
    pub color: bool,
}

/// Number of timed runs of a row. Fast rows get more runs than slow ones, since their noise is
/// greater.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Runs {
    /// Minimum number of runs, at least 1.
    #[serde(rename = "least")]
    pub min: u32,
    /// Maximum number of runs.
    #[serde(rename = "most")]
    pub max: u32,
    /// Time budget of a row between both limits, milliseconds. A quarter more is spent on its
    /// yardstick, if `min` is as many runs as baselines need.
    pub budget_ms: u32,
    /// Duration of a first run from which on the row is timed once, without a yardstick,
    /// milliseconds.
    #[serde(default = "never")]
    pub once_from_ms: u32,
}

/// Returns a duration that no row reaches, milliseconds.
fn never() -> u32 {
    u32::MAX
}

/// Minimum number of runs of a row that is judged by [baselines](crate::baseline::times).
pub const MIN_JUDGED_RUNS: u32 = 5;

impl Runs {
    /// Reports whether one timed run suffices for a row with this first run.
    pub(super) fn one_is_enough(&self, first: Duration) -> bool {
        first >= Duration::from_millis(self.once_from_ms.into())
    }

    /// Reports whether the first run took so long that the compilation in it matters little.
    pub(super) fn dwarfs_compilation(&self, first: Duration) -> bool {
        first >= Duration::from_millis(self.once_from_ms.into()) * 4
    }

    /// Returns options for exactly this number of runs.
    pub fn exactly(count: u32) -> Self {
        Self {
            min: count,
            max: count,
            budget_ms: 0,
            once_from_ms: never(),
        }
    }

    /// Reports whether every row gets as many runs as a baseline needs to judge it.
    pub(super) fn suffice_for_baselines(&self) -> bool {
        self.min >= MIN_JUDGED_RUNS
    }

    /// Reports whether `done` runs that took `spent` suffice.
    pub(super) fn suffice(&self, done: usize, spent: Duration) -> bool {
        let min = self.min.max(1) as usize;
        let is_spent = done >= self.max as usize || spent >= self.budget();
        done >= min && is_spent
    }

    /// Reports whether a row disturbed by other programs may be run again, for up to twice the
    /// budget.
    pub(super) fn may_repeat(&self, done: usize, spent: Duration) -> bool {
        done < self.max as usize && spent < 2 * self.budget()
    }

    fn budget(&self) -> Duration {
        Duration::from_millis(self.budget_ms.into())
    }
}

impl Default for Runs {
    /// Returns as many runs as a [baseline](crate::baseline::times) needs. Fast rows get up to
    /// fifteen.
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
    /// Returns options for a quick preview: small images, one map size, few settings, samples and
    /// runs, and no expensive techniques.
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

    /// Returns options for full-size scenes: the scene's image size, the representative settings of
    /// each technique on larger maps, and truth at one of each 5 x 5 pixels.
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
            // Run rows of seconds once only: otherwise the suite would take an hour.
            runs: Some(Runs {
                min: 1,
                max: 5,
                budget_ms: 150,
                once_from_ms: 400,
            }),
            ..Self::default()
        }
    }

    /// Returns options for a quick preview of full-size scenes: small images, one map size.
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

    /// Returns a scene's camera with the image size of the options.
    pub(super) fn camera(&self, camera: &Camera) -> Camera {
        self.size.map_or(*camera, |size| camera.with_size(size))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quick_rows_are_rendered_more_often_than_slow_ones() {
        let runs = Runs::default();
        let executed =
            |ms: u64| (0..).find(|&n| runs.suffice(n, Duration::from_millis(ms * n as u64)));
        assert_eq!([0, 4, 10, 1_000].map(executed), [15, 8, 5, 5].map(Some));
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
        let may_repeat = |n, ms| runs.may_repeat(n, Duration::from_millis(ms));
        assert!(
            may_repeat(14, 59)
                && !may_repeat(15, 50)
                && !may_repeat(5, 60)
                && !Runs::exactly(3).may_repeat(3, Duration::ZERO)
        );
    }
}
