//! The results of a comparison: plain data, written to `results.json` as it is.

use super::options::Section;
use serde::{Deserialize, Serialize};
use umbrage_core::metrics::{Agreement, Causes, Errors};
use umbrage_plan::{
    cost::{Work, rank_correlation},
    footprint::MapUse,
    motion::FrameMotion,
    statistics::Sorted,
};

/// Version of this data's format; grows with every change that programs which read it would notice.
pub const SCHEMA: u32 = 7;

/// A whole comparison.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    /// [`SCHEMA`] when it was written.
    pub schema: u32,
    /// Where and with what it was made.
    pub environment: Environment,
    /// What the reader must know, such as that an adapter is missing.
    pub notices: Vec<String>,
    /// One entry for each scene, in the order compared.
    pub scenes: Vec<SceneResult>,
}

impl Comparison {
    /// Returns a line for each fault: decided pixels on which backends differ, and negative
    /// controls that fail.
    pub fn faults(&self) -> Vec<String> {
        self.scenes.iter().flat_map(SceneResult::faults).collect()
    }

    /// Returns a line for each row of which rounding alone changes many pixels, as is expected of
    /// its settings. That is no fault.
    pub fn rows_sensitive_to_rounding(&self) -> Vec<String> {
        let mut out = Vec::new();
        for scene in &self.scenes {
            for row in &scene.rows {
                let agreement = row.measured().and_then(|m| m.agreement);
                if let Some(agreement) = agreement.filter(|a| !a.is_decided())
                    && let Some(expected) = ExpectedUndecided::of(row)
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

/// Where and with what a comparison was made.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Environment {
    /// Version of umbrage.
    pub version: String,
    /// The working tree's commit, with `+` if files were changed since; none outside a repository.
    pub commit: Option<String>,
    /// Coordinated universal time, `2026-11-21 03:45`; none of a comparison that is to come out the
    /// same whenever it is made.
    pub date: Option<String>,
    /// The processor's name.
    pub cpu: String,
    /// Threads used.
    pub threads: usize,
    /// Operating system and architecture.
    pub system: String,
    /// The graphics adapter; none if there is none or it wasn't asked for.
    pub adapter: Option<String>,
    /// How it rounds vertices, in words; none without it.
    #[serde(default)]
    pub snapping: Option<String>,
    /// Names of the backends compared.
    pub backends: Vec<String>,
}

/// One scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SceneResult {
    /// The scene's name.
    pub name: String,
    /// One line about it, maybe empty.
    pub summary: String,
    /// What it is compared for.
    #[serde(default)]
    pub section: Section,
    /// What moves from frame to frame, and so what the rows' sums of times are made of.
    #[serde(default)]
    pub motion: FrameMotion,
    /// Kind of the light compared.
    pub light: String,
    /// Whether the light has no extent, so that its shadows are hard.
    #[serde(default)]
    pub is_ideal: bool,
    /// Image width and height, pixels.
    pub size: [u32; 2],
    /// Triangles in all.
    pub triangles: u64,
    /// Tells the triangles apart from others, hexadecimal.
    pub fingerprint: String,
    /// How truth was made.
    pub truth: TruthSummary,
    /// Why rows have no errors; none if they have.
    #[serde(default)]
    pub nothing_compared: Option<String>,
    /// RMSE of a mask that is lit everywhere, and of one that is dark everywhere.
    pub rmse_of_none: [f64; 2],
    /// One entry a technique setting and backend.
    pub rows: Vec<CompareRow>,
    /// One entry a technique and backend.
    pub controls: Vec<Control>,
}

impl SceneResult {
    /// Returns the kinds of backend that played, in the order of their first rows.
    pub fn backends(&self) -> Vec<&str> {
        let mut out: Vec<&str> = Vec::new();
        for row in &self.rows {
            if !out.contains(&row.backend.as_str()) {
                out.push(&row.backend);
            }
        }
        out
    }

    /// Returns how well counted costs rank the rows of a backend as the clock does: Spearman's rank
    /// correlation of cost and time of all that backends execute; `None` with fewer than three rows
    /// or without times.
    pub fn cost_ranks(&self, backend: &str) -> Option<f64> {
        let mut pairs = Vec::new();
        for row in self.rows.iter().filter(|row| row.backend == backend) {
            if let Some(m) = row.measured()
                && let Some(times) = m.times
                && row.same_as.is_none()
            {
                pairs.push([
                    m.played_cost_ms.unwrap_or(m.cost_ms),
                    times.milliseconds(&times.total),
                ]);
            }
        }
        rank_correlation(&pairs)
    }

    /// Sets the rows' [times at full clock](RowTimes::full_clock_factor) on devices, whose
    /// yardstick takes at least `yardstick_ms` milliseconds a unit.
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
    /// those that repeat the figures of another row.
    pub fn rows_at_unknown_clock(&self) -> usize {
        let rows = self.rows.iter().filter(|row| row.same_as.is_none());
        rows.filter(|row| row.is_at_unknown_clock()).count()
    }

    fn faults(&self) -> Vec<String> {
        let mut out = Vec::new();
        let scene = &self.name;
        for row in &self.rows {
            let Some(measured) = row.measured() else {
                continue;
            };
            let label = row.label();
            let expected = ExpectedUndecided::of(row);
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
        // Where nothing faces the light there is nothing to compare, which is no fault. Where truth
        // is ambiguous everywhere, nothing was found out, which is one.
        if let Some(why) = &self.nothing_compared
            && self.truth.ambiguous > 0
        {
            out.push(format!("{scene}: {why}"));
        }
        for control in self.controls.iter().filter(|c| !c.holds) {
            let why = match control.wrong_without {
                0 => format!(
                    "the mask stays the same, though {} pixels are in shadow with them",
                    control.shadowed
                ),
                n => format!("{n} pixels of the mask are not as their own horizon leaves them"),
            };
            out.push(format!(
                "{scene}: {} {}: without casters {why}",
                control.backend, control.technique
            ));
        }
        out
    }
}

/// Settings whose masks rounding alone changes at more pixels than
/// [`MAX_UNDECIDED_SHARE`](umbrage_core::metrics::MAX_UNDECIDED_SHARE) allows.
#[derive(Clone, Copy, Debug)]
struct ExpectedUndecided {
    /// The technique. `None` for all.
    technique: Option<&'static str>,
    /// One of its settings, as reports spell them.
    setting: &'static str,
    /// The greatest share of a scene's pixels.
    share: f64,
    why: &'static str,
}

const EXPECTED_UNDECIDED: [ExpectedUndecided; 2] = [
    // `hard` on an H100: 28 of 19,200 pixels of `cubes`, 2,944 of 19,200 (0.15) of `lamp-in-room`.
    // Twice that leaves room for other adapters. A mask of noise would differ at half of its
    // pixels.
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
    fn of(row: &CompareRow) -> Option<Self> {
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
            "rounding alone lets {} of {} pixels differ from the CPU's: too many",
            agreement.undecided, agreement.compared
        ))
    } else {
        None
    }
}

/// How truth was traced, and how certain it is.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TruthSummary {
    /// Rays for each receiver; more in penumbra.
    pub samples: u32,
    /// Mean standard error over the pixels that count.
    pub mean_error: f32,
    /// Greatest standard error.
    pub largest_error: f32,
    /// Pixels that count.
    pub counted: u64,
    /// Pixels left out as ambiguous.
    pub ambiguous: u64,
    /// Pixels left out as facing away from the light or outside its cone.
    pub unlit: u64,
    /// Pixels left out as only a sample is judged; 0 where all are.
    #[serde(default)]
    pub unsampled: u64,
    /// Seconds it took; none without times.
    pub seconds: Option<f64>,
}

/// One technique setting on one backend.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CompareRow {
    /// The technique's name.
    pub technique: String,
    /// Its settings in words.
    pub settings: String,
    /// A file name's stem that no other row of this technique has: `pcf` or `pcf-3x3-1024-slope`.
    pub slug: String,
    /// Kind of backend, `cpu` or `wgpu`.
    pub backend: String,
    /// The row above whose figures these are, as both have the same recipe: its technique and
    /// settings.
    #[serde(default)]
    pub same_as: Option<String>,
    /// Its figures, or why it has none.
    pub outcome: RowOutcome,
}

impl CompareRow {
    /// Returns the figures; none if the row isn't measured.
    pub fn measured(&self) -> Option<&Measured> {
        match &self.outcome {
            RowOutcome::Measured(m) => Some(m),
            RowOutcome::Unsupported { .. } => None,
        }
    }

    /// Whether the row was timed in turn with a yardstick on a device, and its time at full clock
    /// is not known. Long rows are timed once, without a yardstick: they do not count.
    pub fn is_at_unknown_clock(&self) -> bool {
        let times = self.measured().and_then(|m| m.times);
        has_device_clock(&self.backend)
            && times.is_some_and(|t| t.yardstick.is_some() && t.full_clock_factor.is_none())
    }

    /// Returns a file name's stem that no other row of its scene has.
    pub fn stem(&self) -> String {
        stem_of(&self.slug, &self.backend)
    }

    /// Returns the row's name for people: `pcf (3x3, 1024, slope) on wgpu`.
    pub fn label(&self) -> String {
        format!("{} ({}) on {}", self.technique, self.settings, self.backend)
    }
}

/// Whether a kind of backend runs on a device with a clock of its own, which falls while the CPU
/// works.
pub(super) fn has_device_clock(backend: &str) -> bool {
    backend != "cpu"
}

/// [`CompareRow::stem`] of a slug on a kind of backend.
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
    /// Errors against truth; `None` if no pixel counts ([`SceneResult::nothing_compared`] says
    /// why), as errors of 0 would mean that the mask is right.
    pub errors: Option<Errors>,
    /// What the errors come from; none where no pixel counts.
    pub causes: Option<Causes>,
    /// Times of what the backend executes, without compilation, upload and read-back; `None` if
    /// they were not measured.
    pub times: Option<RowTimes>,
    /// Times of what comes before: the same on every backend; none if they were not measured.
    #[serde(default)]
    pub preparation: Option<Preparation>,
    /// Whether what the recipe draws stays the same while the camera moves.
    #[serde(default)]
    pub kept_as_camera_moves: bool,
    /// The recipe's work, counted.
    pub work: Work,
    /// The cost of that work by the [prices](umbrage_plan::cost::PriceList) of this kind of
    /// backend, milliseconds: the same on every run.
    pub cost_ms: f64,
    /// The part of `cost_ms` that backends execute, which [`times`](Self::times) are of: without
    /// triangles that were put into lists. None in files from before there were lists.
    #[serde(default)]
    pub played_cost_ms: Option<f64>,
    /// The part of `cost_ms` that the lookup costs.
    #[serde(default)]
    pub lookup_cost_ms: f64,
    /// Bytes held for images, tables and receivers.
    pub bytes: u64,
    /// Agreement with the CPU's mask; none on the CPU or without it.
    pub agreement: Option<Agreement>,
    /// Pixels whose colour differs from the first backend's by more than a step of 255 though the
    /// masks agree; none without colours, and for the first backend.
    pub color_differing: Option<u64>,
    /// How the maps are used: the same on every backend; none without maps.
    pub maps: Option<MapUse>,
}

impl Measured {
    /// Returns the root of the mean square error, 0..=1; none where no pixel counts.
    pub fn rmse(&self) -> Option<f64> {
        self.errors.map(|e| e.rmse)
    }

    /// Returns the time of a frame or its cost, milliseconds; `None` if times weren't measured.
    /// Costs are those of the whole recipe, or of its lookup alone where what is drawn is kept.
    pub fn milliseconds(&self, clock: CostBasis, motion: FrameMotion) -> Option<f64> {
        match clock {
            CostBasis::Wall => self.frame_ms(motion),
            CostBasis::Cost if self.is_kept(motion) => Some(self.lookup_cost_ms),
            CostBasis::Cost => Some(self.cost_ms),
        }
    }

    /// Returns the time of a frame, milliseconds; none without times, or if the lookup alone was
    /// not timed.
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

    /// Whether what the recipe draws is kept from frame to frame.
    fn is_kept(&self, motion: FrameMotion) -> bool {
        match motion {
            FrameMotion::Still => true,
            FrameMotion::CameraMoves => self.kept_as_camera_moves,
            FrameMotion::AllMoves => false,
        }
    }
}

/// Two measures of what a row costs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CostBasis {
    /// Measured time: of this machine at that moment.
    Wall,
    /// Counted work times its price: the same on every run.
    Cost,
}

/// The times of what comes before a backend plays, for one setting on one scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Preparation {
    /// Once a scene: hierarchies over its triangles, welded edges and the like, milliseconds. It is
    /// the time by which the first recipe of fresh triangles takes longer than later ones.
    pub scene_ms: f64,
    /// Making the recipe: once a change of what it depends on.
    pub recipe: TimingStats,
}

/// How long the stages took; none where a stage is not played or not measurable.
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
    /// Times of the [yardstick](umbrage_yardstick::Yardstick) that is timed in turn with the runs,
    /// milliseconds for each unit of its work; `None` if nothing receives, where the adapter can't
    /// time it, and in results of schema 4 and before.
    pub yardstick: Option<TimingStats>,
    /// Each run's time over the mean of the yardsticks' right before and after it: what is compared
    /// with other runs' results. Only calm runs count: on the CPU those next to which no yardstick
    /// took more than [`CALM`](super::CALM) times the quickest, on a device those of which neither
    /// yardstick took more than that times the other. `None` if no run was calm.
    pub ratio: Option<Ranks>,
    /// The row's time at the device's full clock over the median of [`total`](Self::total), more
    /// than 0: that ratio times the yardstick's least time on the device in this comparison. `None`
    /// on the CPU, if no run was calm, and in files from before it was measured.
    #[serde(default, rename = "full_clock")]
    pub full_clock_factor: Option<f64>,
    /// Units of work of the yardstick on a device: [ratios](Self::ratio) to yardsticks of different
    /// lengths cannot be compared. `None` on the CPU, without a yardstick, and before schema 7.
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

/// The distribution of some figures as quantiles, which a few outliers do not change.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Ranks {
    /// A tenth lies below.
    pub tenth: f64,
    /// A quarter lies below.
    pub low: f64,
    /// Half lies below.
    pub median: f64,
    /// A quarter lies above.
    pub high: f64,
    /// The greatest.
    #[serde(rename = "greatest")]
    pub max: f64,
    /// How many figures.
    pub runs: u32,
}

impl Ranks {
    /// Returns the quantiles of some figures, linear between neighbors; none without figures.
    pub fn of(figures: Vec<f64>) -> Option<Self> {
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
    /// Half of the runs took longer.
    pub median: f64,
    /// The quickest run.
    #[serde(rename = "least")]
    pub min: f64,
    /// The slowest run.
    #[serde(rename = "greatest")]
    pub max: f64,
    /// How many runs.
    pub runs: u32,
}

impl TimingStats {
    /// Returns the statistics of times in milliseconds; none without times.
    pub fn of(times: Vec<f64>) -> Option<Self> {
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

/// The negative control of one technique on one backend: with the casters removed, its mask must
/// change where the shadow was, and show nothing but the receivers' own horizon.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Control {
    /// Kind of backend.
    pub backend: String,
    /// The technique that was played: the first of its settings that was measured.
    pub technique: String,
    /// Counted pixels from which casters hide all of the light, and which the technique must light
    /// without casters.
    pub shadowed: u64,
    /// Those of them whose mask brightened by more than a quarter when the casters were removed.
    pub changed: u64,
    /// Counted pixels that without casters are darker or lighter than is right for the technique:
    /// the share of its light samples that lie above the receiver's own horizon. Must be 0.
    #[serde(alias = "dark_without")]
    pub wrong_without: u64,
    /// Whether the control passed: nothing is wrong without casters, and something changed if truth
    /// has a shadow that the technique cannot miss. (Maps may miss shadows narrower than their
    /// texels, and so may maps of the far sides of casters.)
    pub holds: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Timestamps may be so coarse that a row takes no time.
    #[test]
    fn rows_of_no_time_have_no_factor() {
        for (median, factor) in [(4.0, Some(0.5)), (0.0, None)] {
            let stats = |median| TimingStats {
                median,
                ..TimingStats::default()
            };
            let times = RowTimes {
                total: stats(median),
                ratio: Ranks::of(vec![median]),
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
            let times = scene.rows[0].measured().and_then(|m| m.times);
            assert_eq!(times.and_then(|t| t.full_clock_factor), factor);
        }
    }
}
