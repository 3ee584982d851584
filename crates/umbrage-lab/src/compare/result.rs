//! Results of a comparison: plain data, written to `results.json`.

use super::options::Section;
use serde::{Deserialize, Serialize};
use umbrage_core::metrics::{Agreement, Causes, Errors};
use umbrage_plan::{
    cost::{Work, rank_correlation},
    footprint::MapUse,
    motion::FrameMotion,
    statistics::Sorted,
};

/// Version of this data's format. Increases with every change that concerns programs that read it.
pub const SCHEMA: u32 = 7;

/// A whole comparison.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    /// [`SCHEMA`] when it was written.
    pub schema: u32,
    /// Environment of the comparison.
    pub environment: Environment,
    /// Notices for the reader, such as a missing adapter.
    pub notices: Vec<String>,
    /// One entry for each scene, in the order of comparison.
    pub scenes: Vec<SceneResult>,
}

impl Comparison {
    /// Returns a line for each fault: backends that differ at decided pixels, and failed negative
    /// controls.
    pub fn faults(&self) -> Vec<String> {
        self.scenes.iter().flat_map(SceneResult::faults).collect()
    }

    /// Returns a line for each row in which rounding alone changes many pixels, as expected for its
    /// settings. This is not a fault.
    pub fn rows_sensitive_to_rounding(&self) -> Vec<String> {
        let mut out = Vec::new();
        for scene in &self.scenes {
            for row in &scene.rows {
                let agreement = row.measured_figures().and_then(|m| m.agreement);
                if let Some(agreement) = agreement.filter(|a| !a.is_decided())
                    && let Some(expected) = ExpectedUndecided::of_row(row)
                    && expected.holds(&agreement)
                {
                    let (scene, label, why) = (&scene.name, row.label(), expected.why);
                    let Agreement {
                        undecided,
                        compared,
                        ..
                    } = agreement;
                    out.push(format!(
                        "{scene}: {label}: {undecided} of {compared} pixels, as {why}"
                    ));
                }
            }
        }
        out
    }
}

/// The environment of a comparison.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Environment {
    /// Version of umbrage.
    pub version: String,
    /// The working tree's commit, with `+` if files were changed. `None` outside a repository.
    pub commit: Option<String>,
    /// UTC date and time, `2026-11-21 03:45`. `None` for reproducible comparisons.
    pub date: Option<String>,
    /// The processor's name.
    pub cpu: String,
    /// Threads used.
    pub threads: usize,
    /// Operating system and architecture.
    pub system: String,
    /// The graphics adapter. `None` if there is none or it wasn't requested.
    pub adapter: Option<String>,
    /// The adapter's vertex rounding in words. `None` without an adapter.
    #[serde(default)]
    pub snapping: Option<String>,
    /// Names of the compared backends.
    pub backends: Vec<String>,
}

/// Results of one scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SceneResult {
    /// The scene's name.
    pub name: String,
    /// One line about the scene. May be empty.
    pub summary: String,
    /// The scene's purpose.
    #[serde(default)]
    pub section: Section,
    /// Motion between frames, which decides the parts of a row's frame time.
    #[serde(default)]
    pub motion: FrameMotion,
    /// Kind of the light.
    pub light: String,
    /// Whether the light has no extent, so that its shadows are hard.
    #[serde(default)]
    pub is_ideal: bool,
    /// Image width and height, pixels.
    pub size: [u32; 2],
    /// Number of triangles.
    pub triangles: u64,
    /// Fingerprint of the triangles, hexadecimal.
    pub fingerprint: String,
    /// Summary of truth.
    pub truth: TruthSummary,
    /// Why rows have no errors. `None` if they have.
    #[serde(default)]
    pub nothing_compared: Option<String>,
    /// A likely mistake in the scene. `None` without one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hint: Option<String>,
    /// RMSE of a fully lit mask, and of a fully dark one.
    pub rmse_of_none: [f64; 2],
    /// One entry for each technique setting and backend.
    pub rows: Vec<CompareRow>,
    /// One entry for each technique and backend.
    pub controls: Vec<Control>,
}

impl SceneResult {
    /// Returns the kinds of backend, in the order of their first rows.
    pub fn backends(&self) -> Vec<&str> {
        let mut out: Vec<&str> = Vec::new();
        for row in &self.rows {
            if !out.contains(&row.backend.as_str()) {
                out.push(&row.backend);
            }
        }
        out
    }

    /// Returns Spearman's rank correlation of predicted cost and measured time over the rows of a
    /// backend. `None` with fewer than three rows or without times.
    pub fn cost_ranks(&self, backend: &str) -> Option<f64> {
        let mut pairs = Vec::new();
        for row in self.rows.iter().filter(|row| row.backend == backend) {
            if let Some(m) = row.measured_figures()
                && let Some(times) = m.times
                && row.same_as.is_none()
            {
                pairs.push([
                    m.executed_cost_ms.unwrap_or(m.cost_ms),
                    times.milliseconds(&times.total),
                ]);
            }
        }
        rank_correlation(&pairs)
    }

    /// Sets the rows' [times at full clock](RowTimes::full_clock_factor) on devices whose yardstick
    /// takes at least `yardstick_ms` milliseconds per unit.
    pub(super) fn set_full_clock(&mut self, yardstick_ms: f64) {
        for row in &mut self.rows {
            if let RowOutcome::Measured(m) = &mut row.outcome
                && has_device_clock(&row.backend)
                && let Some(times) = &mut m.times
                && let Some(ratio) = times.ratio
            {
                let factor = ratio.median * yardstick_ms / times.total.median;
                // Timestamps may be 0.
                times.full_clock_factor = Some(factor).filter(|f| f.is_finite() && *f > 0.0);
            }
        }
    }

    /// Returns the number of rows [at an unknown clock](CompareRow::is_at_unknown_clock), without
    /// those that repeat other rows.
    pub fn rows_at_unknown_clock(&self) -> usize {
        let rows = self.rows.iter().filter(|row| row.same_as.is_none());
        rows.filter(|row| row.is_at_unknown_clock()).count()
    }

    fn faults(&self) -> Vec<String> {
        let mut out = Vec::new();
        let scene = &self.name;
        for row in &self.rows {
            let Some(measured) = row.measured_figures() else {
                continue;
            };
            let label = row.label();
            let expected = ExpectedUndecided::of_row(row);
            if let Some(what) = measured.agreement.and_then(|a| disagreement(a, expected)) {
                out.push(format!("{scene}: {label}: {what}"));
            }
            let colors = measured.color_differing.unwrap_or(0);
            if colors > 0 {
                out.push(format!(
                    "{scene}: {label}: the colours of {colors} pixels differ from the CPU's"
                ));
            }
        }
        // If nothing faces the light, there is nothing to compare, which is no fault. If truth is
        // ambiguous everywhere, nothing was tested, which is a fault.
        if let Some(why) = &self.nothing_compared
            && self.truth.ambiguous > 0
        {
            out.push(format!("{scene}: {why}"));
        }
        for control in self.controls.iter().filter(|c| !c.holds) {
            let why = match control.wrong_without {
                0 => format!(
                    "the mask stays the same, though they shadow {} pixels",
                    control.shadowed
                ),
                n => format!("{n} pixels of the mask differ from what their own horizon implies"),
            };
            out.push(format!(
                "{scene}: {} {}: without casters {why}",
                control.backend, control.technique
            ));
        }
        out
    }
}

/// Settings for which rounding alone may change more pixels than
/// [`MAX_UNDECIDED_SHARE`](umbrage_core::metrics::MAX_UNDECIDED_SHARE).
#[derive(Clone, Copy, Debug)]
struct ExpectedUndecided {
    /// The technique. `None` for all.
    technique: Option<&'static str>,
    /// One of its settings, as spelt in reports.
    setting: &'static str,
    /// Maximum share of a scene's pixels.
    share: f64,
    why: &'static str,
}

const EXPECTED_UNDECIDED: [ExpectedUndecided; 2] = [
    // `hard` on an H100: 28 of 19,200 pixels of `cubes`, 2,944 of 19,200 (0.15) of `lamp-in-room`.
    // Twice that allows for other adapters. A mask of noise would differ at half of its pixels.
    ExpectedUndecided {
        technique: None,
        setting: "bias: none",
        share: 0.3,
        why: "surfaces are compared with their own depth without a bias",
    },
    // 36 of 19,200 pixels of `cubes` on an H200, 27 on SwiftShader.
    ExpectedUndecided {
        technique: Some("msm"),
        setting: "hausdorff",
        share: 0.003,
        why: "four moments of 32 bits are a nearly singular system where depths are alike",
    },
];

impl ExpectedUndecided {
    fn of_row(row: &CompareRow) -> Option<Self> {
        let is_of_row = |expected: &Self| {
            let mut settings = row.settings.split(", ");
            expected.technique.is_none_or(|name| name == row.technique)
                && settings.any(|setting| setting == expected.setting)
        };
        EXPECTED_UNDECIDED.into_iter().find(is_of_row)
    }

    fn holds(self, agreement: &Agreement) -> bool {
        agreement.undecided as f64 <= self.share * agreement.compared as f64
    }
}

/// Returns what is wrong with an agreement. `None` if nothing is.
fn disagreement(agreement: Agreement, expected: Option<ExpectedUndecided>) -> Option<String> {
    let is_expected = expected.is_some_and(|expected| expected.holds(&agreement));
    if !agreement.holds() {
        Some(format!(
            "{} decided pixels differ from the CPU's",
            agreement.violations
        ))
    } else if !agreement.is_accurate() {
        Some(format!(
            "RMSE is {:.4} above that of the CPU's mask at the same pixels",
            agreement.excess
        ))
    } else if !agreement.is_decided() && !is_expected {
        Some(format!(
            "rounding alone makes {} of {} pixels differ from the CPU's, which is too many",
            agreement.undecided, agreement.compared
        ))
    } else {
        None
    }
}

/// Summary of truth and its uncertainty.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TruthSummary {
    /// Rays for each receiver; more in penumbrae.
    pub samples: u32,
    /// Mean standard error over the pixels that count.
    pub mean_error: f32,
    /// Greatest standard error.
    pub largest_error: f32,
    /// Pixels that count.
    pub counted: u64,
    /// Pixels excluded as ambiguous.
    pub ambiguous: u64,
    /// Pixels in shadow that count or are ambiguous: those that see less than half of the light.
    #[serde(default)]
    pub shadowed: u64,
    /// Those of `shadowed` that are ambiguous.
    #[serde(default)]
    pub shadowed_ambiguous: u64,
    /// Pixels excluded as facing away from the light or outside its cone.
    pub unlit: u64,
    /// Pixels excluded as not sampled; 0 if all are judged.
    #[serde(default)]
    pub unsampled: u64,
    /// Tracing time, seconds. `None` without times.
    pub seconds: Option<f64>,
}

impl TruthSummary {
    /// Returns the share of the pixels facing the light that are excluded as ambiguous, 0..=1.
    pub fn share_left_out(&self) -> f64 {
        let facing = self.counted + self.ambiguous + self.unsampled;
        match facing {
            0 => 0.0,
            facing => self.ambiguous as f64 / facing as f64,
        }
    }

    /// Returns a line about the pixels excluded as ambiguous. `None` if there are none.
    pub fn left_out_words(&self) -> Option<String> {
        if self.ambiguous == 0 {
            return None;
        }
        let shadow = match (self.shadowed_ambiguous, self.shadowed) {
            (_, 0) => String::new(),
            (all, shadowed) if all == shadowed => ", all of the shadow among them".to_owned(),
            (some, shadowed) => {
                let share = 100.0 * some as f64 / shadowed as f64;
                format!(", among them {share:.1} % of the shadow")
            }
        };
        Some(format!(
            "left out as ambiguous: {} pixels, {:.1} % of those facing the light{shadow}",
            self.ambiguous,
            100.0 * self.share_left_out()
        ))
    }
}

/// One technique setting on one backend.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CompareRow {
    /// The technique's name.
    pub technique: String,
    /// Settings in words.
    pub settings: String,
    /// Stem of a file name, unique among rows of this technique: `pcf` or `pcf-3x3-1024-slope`.
    pub slug: String,
    /// Kind of backend, `cpu` or `wgpu`.
    pub backend: String,
    /// Technique and settings of an earlier row with the same recipe, whose figures these are.
    /// `None` if there is none.
    #[serde(default)]
    pub same_as: Option<String>,
    /// Figures, or the reason why there are none.
    pub outcome: RowOutcome,
}

impl CompareRow {
    /// Returns the figures. `None` if the row isn't measured.
    pub fn measured_figures(&self) -> Option<&Measured> {
        match &self.outcome {
            RowOutcome::Measured(m) => Some(m),
            RowOutcome::Unsupported { .. } => None,
        }
    }

    /// Reports whether the row was timed in turn with a yardstick on a device, but its time at full
    /// clock is unknown. Long rows are timed without a yardstick and don't count.
    pub fn is_at_unknown_clock(&self) -> bool {
        let times = self.measured_figures().and_then(|m| m.times);
        has_device_clock(&self.backend)
            && times.is_some_and(|t| t.yardstick.is_some() && t.full_clock_factor.is_none())
    }

    /// Returns the stem of a file name, unique among rows of the scene.
    pub fn stem(&self) -> String {
        stem_of(&self.slug, &self.backend)
    }

    /// Returns the row's name for readers: `pcf (3x3, 1024, slope) on wgpu`.
    pub fn label(&self) -> String {
        format!("{} ({}) on {}", self.technique, self.settings, self.backend)
    }
}

/// Reports whether a kind of backend runs on a device with its own clock, which slows down while
/// the CPU works.
pub(super) fn has_device_clock(backend: &str) -> bool {
    backend != "cpu"
}

/// Returns [`CompareRow::stem`] for a slug and a kind of backend.
pub(super) fn stem_of(slug: &str, backend: &str) -> String {
    format!("{slug}.{backend}")
}

/// A row's figures, or why it has none.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RowOutcome {
    /// It was rendered and measured.
    Measured(Box<Measured>),
    /// The technique or the backend doesn't support it.
    Unsupported {
        /// Why.
        reason: String,
    },
}

/// A row's figures.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// Errors against truth. `None` if no pixel counts ([`SceneResult::nothing_compared`] is the
    /// reason): errors of 0 would mean a correct mask.
    pub errors: Option<Errors>,
    /// Causes of the errors. `None` if no pixel counts.
    pub causes: Option<Causes>,
    /// Times of execution on the backend, without compilation, upload and read-back. `None` if not
    /// measured.
    pub times: Option<RowTimes>,
    /// Times of preparation, equal on every backend. `None` if not measured.
    #[serde(default)]
    pub preparation: Option<Preparation>,
    /// Whether the drawn images stay the same while the camera moves.
    #[serde(default)]
    pub kept_as_camera_moves: bool,
    /// The recipe's counted work.
    pub work: Work,
    /// Predicted cost of the work by the [prices](umbrage_plan::cost::PriceList) of this kind of
    /// backend, milliseconds. The same on every run.
    pub cost_ms: f64,
    /// The part of `cost_ms` that backends execute, to compare with [`times`](Self::times).
    /// Excludes triangles put into lists. `None` in files from before there were lists.
    #[serde(default, rename = "played_cost_ms")]
    pub executed_cost_ms: Option<f64>,
    /// The part of `cost_ms` for the lookup.
    #[serde(default)]
    pub lookup_cost_ms: f64,
    /// Bytes of images, tables and receivers.
    pub bytes: u64,
    /// Agreement with the CPU's mask. `None` on the CPU or without it.
    pub agreement: Option<Agreement>,
    /// Pixels whose colour differs from that of the first backend by more than a step of 255 though
    /// the masks agree. `None` without colours, and for the first backend.
    pub color_differing: Option<u64>,
    /// Use of the maps, equal on every backend. `None` without maps.
    pub maps: Option<MapUse>,
}

impl Measured {
    /// Returns the root mean square error, 0..=1. `None` if no pixel counts.
    pub fn rmse(&self) -> Option<f64> {
        self.errors.map(|e| e.rmse)
    }

    /// Returns the time of a frame or its cost, milliseconds. `None` if times weren't measured. If
    /// the drawn images are kept between frames, costs are those of the lookup only.
    pub fn milliseconds(&self, clock: CostBasis, motion: FrameMotion) -> Option<f64> {
        match clock {
            CostBasis::Wall => self.frame_ms(motion),
            CostBasis::Cost if self.is_kept(motion) => Some(self.lookup_cost_ms),
            CostBasis::Cost => Some(self.cost_ms),
        }
    }

    /// Returns the time of a frame, milliseconds. `None` without times, or if the lookup was not
    /// timed separately.
    fn frame_ms(&self, motion: FrameMotion) -> Option<f64> {
        let times = self.times.as_ref()?;
        if self.is_kept(motion) {
            return times.receive.map(|receive| times.milliseconds(&receive));
        }
        let preparation = self.preparation.unwrap_or_default();
        let drawn = preparation.recipe.median + times.milliseconds(&times.total);
        match motion {
            FrameMotion::Still | FrameMotion::CameraMoves => Some(drawn),
            FrameMotion::AllMoves => Some(preparation.scene_ms + drawn),
        }
    }

    /// Reports whether the drawn images are kept between frames.
    fn is_kept(&self, motion: FrameMotion) -> bool {
        match motion {
            FrameMotion::Still => true,
            FrameMotion::CameraMoves => self.kept_as_camera_moves,
            FrameMotion::AllMoves => false,
        }
    }
}

/// The basis of a row's time: measured or predicted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CostBasis {
    /// Measured time. Depends on the machine and its load.
    Wall,
    /// Counted work times its price. The same on every run.
    Cost,
}

/// Times of preparation before a backend executes, for one setting on one scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Preparation {
    /// Once per scene: acceleration structures, welded edges and the like, milliseconds. It is the
    /// additional time of the first recipe of new triangles.
    pub scene_ms: f64,
    /// Making the recipe: after each change of its inputs.
    pub recipe: TimingStats,
}

/// Times of the stages. `None` if a stage doesn't occur or can't be measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RowTimes {
    /// All casts.
    pub cast: Option<TimingStats>,
    /// All filters.
    pub filter: Option<TimingStats>,
    /// The lookup.
    pub receive: Option<TimingStats>,
    /// Casts, filters and lookup of each run together.
    pub total: TimingStats,
    /// Times of the [yardstick](umbrage_yardstick::Yardstick) that runs in turn with the row,
    /// milliseconds per unit of its work. `None` if nothing receives, if the adapter can't time it,
    /// and in results of schema 4 and before.
    pub yardstick: Option<TimingStats>,
    /// Time of each run divided by the mean of the yardsticks before and after it, for comparison
    /// with results of other runs.
    ///
    /// Only calm runs count. On the CPU, neither adjacent yardstick took more than
    /// [`CALM`](super::CALM) times the fastest one. On a device, neither took more than that times
    /// the other. `None` if no run was calm.
    pub ratio: Option<Ranks>,
    /// The row's time at the device's full clock divided by the median of [`total`](Self::total),
    /// more than 0.
    ///
    /// It is the median ratio times the yardstick's least time on the device in this comparison.
    /// `None` on the CPU, if no run was calm, and in older files.
    #[serde(default, rename = "full_clock")]
    pub full_clock_factor: Option<f64>,
    /// Units of work of the yardstick on a device. [Ratios](Self::ratio) to yardsticks of different
    /// lengths are not comparable. `None` on the CPU, without a yardstick, and before schema 7.
    #[serde(default)]
    pub device_units: Option<f64>,
}

impl RowTimes {
    /// Returns the median time of a stage, milliseconds: at the device's full clock if that is
    /// known.
    pub fn milliseconds(&self, stage: &TimingStats) -> f64 {
        stage.median * self.full_clock_factor.unwrap_or(1.0)
    }
}

/// Quantiles of some figures, which are robust against outliers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Ranks {
    /// 10 % quantile.
    pub tenth: f64,
    /// Lower quartile.
    pub low: f64,
    /// Median.
    pub median: f64,
    /// Upper quartile.
    pub high: f64,
    /// Maximum.
    #[serde(rename = "greatest")]
    pub max: f64,
    /// Number of figures.
    pub runs: u32,
}

impl Ranks {
    /// Returns the quantiles of some figures, with linear interpolation. `None` without figures.
    pub fn from_figures(figures: Vec<f64>) -> Option<Self> {
        let runs = figures.len() as u32;
        let sorted = Sorted::new(figures);
        Some(Self {
            tenth: sorted.quantile(0.1)?,
            low: sorted.quantile(0.25)?,
            median: sorted.quantile(0.5)?,
            high: sorted.quantile(0.75)?,
            max: sorted.quantile(1.0)?,
            runs,
        })
    }
}

/// Times of several runs, milliseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TimingStats {
    /// Median.
    pub median: f64,
    /// Fastest run.
    #[serde(rename = "least")]
    pub min: f64,
    /// Slowest run.
    #[serde(rename = "greatest")]
    pub max: f64,
    /// Number of runs.
    pub runs: u32,
}

impl TimingStats {
    /// Returns the statistics of times in milliseconds. `None` without times.
    pub fn from_times(times: Vec<f64>) -> Option<Self> {
        let runs = times.len() as u32;
        let sorted = Sorted::new(times);
        Some(Self {
            median: sorted.quantile(0.5)?,
            min: sorted.quantile(0.0)?,
            max: sorted.quantile(1.0)?,
            runs,
        })
    }
}

/// Negative control of one technique on one backend. Without casters its mask must change where the
/// shadow was, and contain nothing but the receivers' own horizon.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Control {
    /// Kind of backend.
    pub backend: String,
    /// The technique, in its first measured setting.
    pub technique: String,
    /// Counted pixels that casters shadow fully, and that the technique must light without casters.
    pub shadowed: u64,
    /// Those of them that brightened by more than a quarter without casters.
    pub changed: u64,
    /// Counted pixels that are wrong without casters. The correct value is the share of the
    /// technique's light samples above the receiver's own horizon. Must be 0.
    #[serde(alias = "dark_without")]
    pub wrong_without: u64,
    /// Whether the control passed.
    ///
    /// Nothing may be wrong without casters. Something must change, if truth has a shadow that the
    /// technique can't miss. (Maps may miss shadows narrower than their texels, and maps of far
    /// sides may miss open casters.)
    pub holds: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Coarse timestamps may measure 0 for a row.
    #[test]
    fn rows_of_no_time_have_no_factor() {
        for (median, factor) in [(4.0, Some(0.5)), (0.0, None)] {
            let stats = |median| TimingStats {
                median,
                ..TimingStats::default()
            };
            let times = RowTimes {
                total: stats(median),
                ratio: Ranks::from_figures(vec![median]),
                ..RowTimes::default()
            };
            let mut scene = SceneResult {
                rows: vec![CompareRow {
                    technique: "hard".to_owned(),
                    settings: "1024".to_owned(),
                    slug: "hard".to_owned(),
                    backend: "wgpu".to_owned(),
                    same_as: None,
                    outcome: RowOutcome::Measured(Box::new(Measured {
                        times: Some(times),
                        ..Measured::default()
                    })),
                }],
                ..SceneResult::default()
            };
            scene.set_full_clock(0.5);
            let times = scene.rows[0].measured_figures().and_then(|m| m.times);
            assert_eq!(times.and_then(|t| t.full_clock_factor), factor);
        }
    }
}
