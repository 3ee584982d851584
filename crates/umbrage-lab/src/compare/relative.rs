//! Averages over many scenes: error and time of each setting, relative to references of each scene.
//!
//! * **Relative error**: RMSE of a mask divided by that of a fully lit mask (no shadows). If
//!   nothing is in shadow, by that of a fully dark mask. 1 is as wrong as drawing no shadows.
//! * **Relative time**: time divided by that of `hard`, in its first setting with the middle map
//!   size, on the same scene and backend. Relative cost is the same for predicted cost.
//!
//! Errors are averaged arithmetically, so that exact results (0) and failures both count. Times are
//! ratios, so their mean is geometric. A technique that doesn't support a scene draws no shadow:
//! its relative error is 1, and its time is the mean over the other scenes.

use super::{
    options::Section,
    result::{Comparison, CostBasis, Measured, SceneResult, TimingStats},
};
use serde::Serialize;
use std::collections::HashMap;
use umbrage_plan::motion::FrameMotion;

/// Lower limit of relative errors in charts: a thousandth of the error without shadows is
/// invisible, and 0 has no logarithm.
pub const MIN_ERROR: f64 = 1e-3;

/// One setting on one backend over all scenes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Relative {
    /// The technique's name.
    pub technique: String,
    /// Settings in words.
    pub settings: String,
    /// Kind of backend.
    pub backend: String,
    /// Mean of the relative errors.
    pub error: f64,
    /// Geometric means of the relative times: medians, fastest and slowest runs. `None` without
    /// times.
    pub time: Option<TimingStats>,
    /// Geometric mean of the relative costs.
    pub cost: f64,
    /// Number of scenes that the technique supports.
    pub served: usize,
    /// Number of compared scenes.
    pub scenes: usize,
}

impl Relative {
    /// Returns the relative time, or the relative cost. `None` without times.
    pub fn take(&self, clock: CostBasis) -> Option<f64> {
        match clock {
            CostBasis::Wall => self.time.map(|t| t.median),
            CostBasis::Cost => Some(self.cost),
        }
    }
}

/// Sums over the scenes, for one setting on one backend.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    /// Relative errors.
    error: f64,
    /// Logarithms of relative times: median, fastest and slowest run.
    time: [f64; 3],
    runs: u32,
    /// Number of scenes with times.
    timed: usize,
    /// Logarithms of relative costs.
    cost: f64,
    served: usize,
    scenes: usize,
    /// Whether it equals another setting on all scenes so far.
    repeats: bool,
}

/// Scenes of one chart. Hard and soft shadows are in separate charts.
#[derive(Clone, Debug)]
pub struct SceneGroup<'a> {
    /// Whether the lights have no extent.
    pub is_ideal: bool,
    /// Purpose of the scenes.
    pub section: Section,
    /// The scenes, in the comparison's order.
    pub scenes: Vec<&'a SceneResult>,
}

impl SceneGroup<'_> {
    /// Returns the kind of the lights, for file names and headings.
    pub fn light(&self) -> &'static str {
        if self.is_ideal { "hard" } else { "soft" }
    }
}

/// Returns the scenes of content under ideal lights, and those under area lights. Without content,
/// groups all scenes. Groups without scenes are omitted.
pub fn scene_groups(comparison: &Comparison) -> Vec<SceneGroup<'_>> {
    let has_content = comparison
        .scenes
        .iter()
        .any(|scene| scene.section == Section::Content);
    let section = if has_content {
        Section::Content
    } else {
        Section::Check
    };
    let mut out = Vec::new();
    for is_ideal in [true, false] {
        let scenes: Vec<&SceneResult> = comparison
            .scenes
            .iter()
            .filter(|scene| scene.section == section && scene.is_ideal == is_ideal)
            .collect();
        if !scenes.is_empty() {
            out.push(SceneGroup {
                is_ideal,
                section,
                scenes,
            });
        }
    }
    out
}

/// Returns every setting that was compared on all scenes, in the order of the first scene.
///
/// Skips scenes without a receiver that counts, and those without measurements of `hard`. Also
/// skips settings that equal another one on all scenes.
pub fn relative(all: &[&SceneResult]) -> Vec<Relative> {
    let mut sums: HashMap<[&str; 3], Sums> = HashMap::new();
    let mut order: Vec<[&str; 3]> = Vec::new();
    let mut scenes = 0;
    for scene in all {
        let none = scene.error_of_none();
        let references = references(scene);
        if none == 0.0 || references.is_empty() {
            continue;
        }
        scenes += 1;
        for row in &scene.rows {
            let key = [&row.technique, &row.settings, &row.backend].map(String::as_str);
            let Some(reference) = references.get(key[2]) else {
                continue;
            };
            let sum = sums.entry(key).or_insert_with(|| {
                order.push(key);
                Sums {
                    repeats: true,
                    ..Sums::default()
                }
            });
            sum.repeats &= row.same_as.is_some();
            sum.add(row.measured_figures(), none, reference, scene.motion);
        }
    }
    let mut out = Vec::new();
    for key in order {
        let sums = sums[&key];
        if sums.scenes == scenes && sums.served > 0 && !sums.repeats {
            out.push(sums.mean(key[0], key[1], key[2]));
        }
    }
    out
}

/// Returns the reference measurement of each backend.
fn references(scene: &SceneResult) -> HashMap<&str, &Measured> {
    let mut of_backend: HashMap<&str, Vec<&Measured>> = HashMap::new();
    for row in scene.rows.iter().filter(|r| r.technique == "hard") {
        if let Some(m) = row.measured_figures() {
            of_backend.entry(&row.backend).or_default().push(m);
        }
    }
    let mut out = HashMap::new();
    for (backend, settings) in of_backend {
        if let Some(reference) = first_with_middle_map(&settings) {
            out.insert(backend, reference);
        }
    }
    out
}

/// Returns the first measurement with the median map size. Cleared texels identify the size.
fn first_with_middle_map<'a>(settings: &[&'a Measured]) -> Option<&'a Measured> {
    let mut sizes: Vec<u64> = settings.iter().map(|m| m.work.cleared).collect();
    sizes.sort_unstable();
    sizes.dedup();
    let middle = *sizes.get(sizes.len() / 2)?;
    settings.iter().copied().find(|m| m.work.cleared == middle)
}

impl Sums {
    fn add(
        &mut self,
        row: Option<&Measured>,
        none: f64,
        reference: &Measured,
        motion: FrameMotion,
    ) {
        self.scenes += 1;
        let Some(m) = row else { return };
        // If no pixel counts, there is no error.
        let Some(rmse) = m.rmse() else { return };
        self.served += 1;
        self.error += rmse / none;
        let cost = |m: &Measured| m.milliseconds(CostBasis::Cost, motion).unwrap_or(0.0);
        self.cost += log_ratio(cost(m), cost(reference));
        let frame = |m: &Measured| m.milliseconds(CostBasis::Wall, motion);
        if let (Some(times), Some(ms), Some(unit)) = (m.times, frame(m), frame(reference)) {
            let total = times.total;
            // Parts of the frame vary in proportion to casts, filters and lookup together.
            let spread = |run: f64| ms * run / total.median.max(f64::MIN_POSITIVE);
            self.time[0] += log_ratio(ms, unit);
            self.time[1] += log_ratio(spread(total.min), unit);
            self.time[2] += log_ratio(spread(total.max), unit);
            self.timed += 1;
            self.runs += total.runs;
        }
    }

    fn mean(&self, technique: &str, settings: &str, backend: &str) -> Relative {
        // An unsupported scene has no shadow: an error of 1.
        let error_of_unserved = (self.scenes - self.served) as f64;
        let scenes = self.scenes.max(1) as f64;
        let served = self.served.max(1) as f64;
        let timed = self.timed.max(1) as f64;
        let [median, min, max] = self.time.map(|sum| (sum / timed).exp());
        Relative {
            technique: technique.to_owned(),
            settings: settings.to_owned(),
            backend: backend.to_owned(),
            error: (self.error + error_of_unserved) / scenes,
            time: (self.timed > 0).then_some(TimingStats {
                median,
                min,
                max,
                runs: self.runs,
            }),
            cost: (self.cost / served).exp(),
            served: self.served,
            scenes: self.scenes,
        }
    }
}

/// Returns the logarithm of a ratio of two times, which may be 0.
fn log_ratio(time: f64, unit: f64) -> f64 {
    (time.max(f64::MIN_POSITIVE) / unit.max(f64::MIN_POSITIVE)).ln()
}

impl SceneResult {
    /// Returns the RMSE of a fully lit mask, or of a fully dark one if nothing is in shadow. 0 if
    /// no pixel counts.
    pub fn error_of_none(&self) -> f64 {
        let [lit, dark] = self.rmse_of_none;
        if lit > 0.0 { lit } else { dark }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::result::{CompareRow, Preparation, RowOutcome, RowTimes};
    use umbrage_core::metrics::{Causes, Errors};
    use umbrage_plan::cost::Work;

    fn row(technique: &str, rmse: f64, ms: f64) -> CompareRow {
        let receive = TimingStats {
            median: 0.25 * ms,
            ..TimingStats::default()
        };
        let total = TimingStats {
            median: ms,
            min: ms / 2.0,
            max: ms * 2.0,
            runs: 3,
        };
        let measured = Measured {
            errors: Some(Errors {
                rmse,
                ..Errors::default()
            }),
            causes: Some(Causes::default()),
            times: Some(RowTimes {
                total,
                receive: Some(receive),
                ..RowTimes::default()
            }),
            work: Work {
                cleared: 1024,
                ..Work::default()
            },
            cost_ms: 10.0 * ms,
            executed_cost_ms: None,
            lookup_cost_ms: ms,
            ..Measured::default()
        };
        let outcome = RowOutcome::Measured(Box::new(measured));
        CompareRow {
            technique: technique.into(),
            settings: "s".into(),
            slug: technique.into(),
            backend: "cpu".into(),
            same_as: None,
            outcome,
        }
    }

    fn scene(rmse_of_none: [f64; 2], rows: Vec<CompareRow>) -> SceneResult {
        SceneResult {
            rmse_of_none,
            rows,
            ..SceneResult::default()
        }
    }

    fn find<'a>(all: &'a [Relative], technique: &str) -> &'a Relative {
        all.iter()
            .find(|r| r.technique == technique)
            .expect("there")
    }

    #[test]
    fn figures_are_relative_and_times_averaged_as_ratios() {
        let one = scene(
            [0.5, 0.9],
            vec![row("hard", 0.05, 1.0), row("pcf", 0.005, 4.0)],
        );
        let two = scene(
            [0.1, 0.9],
            vec![row("hard", 0.01, 10.0), row("pcf", 0.1, 10.0)],
        );
        let all = relative(&[&one, &two]);
        let hard = find(&all, "hard");
        let pcf = find(&all, "pcf");
        assert!(
            (hard.error - 0.1).abs() < 1e-12 && (pcf.error - 0.505).abs() < 1e-12,
            "{hard:?} {pcf:?}"
        );
        let time = pcf.time.expect("timed");
        assert!(
            (time.median - 2.0).abs() < 1e-12 && (time.min - 1.0).abs() < 1e-12,
            "{time:?}"
        );
        assert!((pcf.cost - 2.0).abs() < 1e-12 && (hard.cost - 1.0).abs() < 1e-12);
    }

    #[test]
    fn where_a_technique_cannot_serve_it_draws_no_shadow() {
        let dash = CompareRow {
            outcome: RowOutcome::Unsupported {
                reason: "no".into(),
            },
            ..row("planar", 0.0, 0.0)
        };
        let one = scene(
            [0.5, 0.9],
            vec![row("hard", 0.05, 1.0), row("planar", 0.0, 1.0)],
        );
        let two = scene([0.5, 0.9], vec![row("hard", 0.05, 1.0), dash]);
        let all = relative(&[&one, &two]);
        let planar = find(&all, "planar");
        assert_eq!((planar.served, planar.scenes), (1, 2));
        assert_eq!(planar.error, 0.5);
    }

    #[test]
    fn scenes_that_tell_nothing_and_settings_not_compared_everywhere_are_left_out() {
        let one = scene(
            [0.5, 0.9],
            vec![row("hard", 0.05, 1.0), row("once", 0.1, 1.0)],
        );
        let two = scene([0.0, 1.0], vec![row("hard", 0.1, 1.0)]);
        let empty = scene([0.0, 0.0], vec![row("hard", 0.0, 1.0)]);
        let all = relative(&[&one, &two, &empty]);
        assert_eq!(all.len(), 1);
        assert!(
            (find(&all, "hard").error - 0.1).abs() < 1e-12,
            "all dark counts where nothing is in shadow"
        );
        assert!(relative(&[]).is_empty());
    }

    #[test]
    fn what_moves_says_what_a_frame_takes() {
        let preparation = Preparation {
            scene_ms: 100.0,
            recipe: TimingStats {
                median: 10.0,
                ..TimingStats::default()
            },
        };
        let mut row = row("hard", 0.1, 4.0);
        let RowOutcome::Measured(m) = &mut row.outcome else {
            panic!("measured")
        };
        m.preparation = Some(preparation);
        let motions = [
            FrameMotion::Still,
            FrameMotion::CameraMoves,
            FrameMotion::AllMoves,
        ];
        let frames = |m: &Measured| motions.map(|motion| m.milliseconds(CostBasis::Wall, motion));
        assert_eq!(frames(m), [1.0, 14.0, 114.0].map(Some));
        m.kept_as_camera_moves = true;
        assert_eq!(frames(m), [1.0, 1.0, 114.0].map(Some));
        let costs = motions.map(|motion| m.milliseconds(CostBasis::Cost, motion));
        assert_eq!(costs, [4.0, 4.0, 40.0].map(Some));
    }

    #[test]
    fn content_is_apart_from_checks_and_hard_light_from_soft() {
        let scene = |section, is_ideal| SceneResult {
            section,
            is_ideal,
            ..SceneResult::default()
        };
        let checks = vec![
            scene(Section::Check, true),
            scene(Section::Check, false),
            scene(Section::Check, true),
        ];
        let mut all = Comparison {
            scenes: checks,
            ..Comparison::default()
        };
        let sizes = |all: &Comparison| {
            let groups = scene_groups(all).into_iter();
            let sizes: Vec<_> = groups.map(|g| (g.light(), g.scenes.len())).collect();
            sizes
        };
        assert_eq!(sizes(&all), [("hard", 2), ("soft", 1)]);
        all.scenes.push(scene(Section::Content, true));
        assert_eq!(sizes(&all), [("hard", 1)]);
    }

    #[test]
    fn what_repeats_another_setting_is_left_out() {
        let same = |rmse| CompareRow {
            same_as: Some("hard (s)".to_owned()),
            ..row("pcss", rmse, 1.0)
        };
        let one = scene([0.5, 0.9], vec![row("hard", 0.05, 1.0), same(0.05)]);
        let two = scene([0.5, 0.9], vec![row("hard", 0.05, 1.0), same(0.05)]);
        assert_eq!(relative(&[&one, &two]).len(), 1);
        let other = scene(
            [0.5, 0.9],
            vec![row("hard", 0.05, 1.0), row("pcss", 0.01, 1.0)],
        );
        assert_eq!(relative(&[&one, &other]).len(), 2, "it differs somewhere");
    }
}
