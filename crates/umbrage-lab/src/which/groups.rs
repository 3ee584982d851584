//! Groups scenes by kind of light and size, and selects the best setting within each budget.

use super::card::{CARD_MOTIONS, time_by_card};
use crate::{
    card::Card,
    compare::{CostBasis, FrameMotion, MIN_ERROR, Relative, SceneResult, Section, relative},
    report::MeasuredScene,
};

/// A motion that the page distinguishes, and its label.
pub(super) type LabelledMotion = (FrameMotion, &'static str);

/// Motions of a backend that was measured by a comparison.
pub(super) const MOTIONS: [LabelledMotion; 3] = [
    (FrameMotion::Still, "nothing moves"),
    (FrameMotion::CameraMoves, "the camera moves"),
    (FrameMotion::AllMoves, "all moves"),
];

/// Frame budgets, as multiples of the time of a `hard` map in the same scene under the same motion.
/// The first leaves a margin for timing noise.
pub(super) const BUDGETS: [f64; 5] = [1.25, 2.0, 5.0, 20.0, f64::INFINITY];

/// Greatest ratio to the least error at which a faster setting is preferred.
pub(super) const AS_GOOD: f64 = 1.1;

/// Relative error above which the page recommends no setting: half as wrong as no shadow.
pub(super) const POOR: f64 = 0.5;

/// Class of scene sizes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct SizeClass {
    pub(super) words: &'static str,
    /// Exclusive upper bound of the triangle count.
    pub(super) below: u64,
}

pub(super) const SIZES: [SizeClass; 3] = [
    SizeClass {
        words: "up to 300,000 triangles",
        below: 300_000,
    },
    SizeClass {
        words: "300,000 to 1 million triangles",
        below: 1_000_000,
    },
    SizeClass {
        words: "over 1 million triangles",
        below: u64::MAX,
    },
];

/// Kinds of light as results name them, and their labels.
pub(super) const LIGHTS: [(&str, &str); 3] = [
    ("directional", "Sun"),
    ("spot", "Spot"),
    ("point", "Point light"),
];

/// A setting that is selected for some motion and budget.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Answer {
    pub(super) technique: String,
    pub(super) settings: String,
}

impl Answer {
    /// Returns the setting without its results.
    pub(super) fn from_setting(setting: &Relative) -> Self {
        Self {
            technique: setting.technique.clone(),
            settings: setting.settings.clone(),
        }
    }
}

/// Answers on one backend or graphics card.
#[derive(Clone, Debug)]
pub(super) struct OfBackend {
    /// Kind of the backend, or the card's name.
    pub(super) backend: String,
    /// Motions that were measured.
    pub(super) motions: &'static [LabelledMotion],
    /// Results of the group's scenes that were measured.
    pub(super) scenes: Vec<SceneResult>,
    /// Index of the answer for each budget and motion; `None` if no setting within the budget is
    /// better than no shadow.
    pub(super) table: Vec<Vec<Option<usize>>>,
    /// Results of each setting, for each motion.
    pub(super) settings: Vec<Vec<Relative>>,
    /// Basis of the budgets: measured times or counted costs.
    pub(super) clock: CostBasis,
}

/// Scenes of one kind of light and one size, with the answers.
#[derive(Clone, Debug)]
pub(super) struct WhichGroup {
    /// Index in [`LIGHTS`].
    pub(super) light: usize,
    pub(super) is_ideal: bool,
    /// Index in [`SIZES`].
    pub(super) size: usize,
    /// Indices of the group's scenes.
    pub(super) scenes: Vec<usize>,
    /// Answers by backend.
    pub(super) backends: Vec<OfBackend>,
    /// Distinct answers of all backends.
    pub(super) answers: Vec<Answer>,
}

impl WhichGroup {
    /// Returns the group's heading.
    pub(super) fn heading(&self) -> String {
        heading(self.light, self.is_ideal, self.size)
    }
}

/// Returns a group's heading; `light` and `size` are indices in [`LIGHTS`] and [`SIZES`].
pub(super) fn heading(light: usize, is_ideal: bool, size: usize) -> String {
    let extent = if is_ideal {
        "without extent"
    } else {
        "with extent"
    };
    format!("{} {extent}, {}", LIGHTS[light].1, SIZES[size].words)
}

/// Returns the index of a scene's size in [`SIZES`].
fn size_of(scene: &SceneResult) -> usize {
    let fits = SIZES.iter().position(|size| scene.triangles < size.below);
    fits.unwrap_or(SIZES.len() - 1)
}

/// Returns the groups that have full-size scenes, ordered by light, extent and size.
///
/// Times on software drivers are not representative of cards, so wgpu's are omitted if
/// `omits_wgpu`. `card` adds its times.
pub(super) fn groups(
    scenes: &[MeasuredScene],
    omits_wgpu: bool,
    card: Option<&Card>,
) -> Vec<WhichGroup> {
    let mut out = Vec::new();
    for (light, (kind, _)) in LIGHTS.iter().enumerate() {
        for is_ideal in [true, false] {
            for size in 0..SIZES.len() {
                let is_of = |scene: &SceneResult| {
                    scene.section == Section::Content
                        && scene.light == *kind
                        && scene.is_ideal == is_ideal
                        && size_of(scene) == size
                };
                let places: Vec<usize> = (0..scenes.len())
                    .filter(|&i| is_of(&scenes[i].result))
                    .collect();
                let results: Vec<SceneResult> = places
                    .iter()
                    .map(|&i| without_backends(&scenes[i].result, omits_wgpu))
                    .collect();
                let mut group = WhichGroup {
                    light,
                    is_ideal,
                    size,
                    scenes: places,
                    backends: Vec::new(),
                    answers: Vec::new(),
                };
                if let Some(card) = card {
                    group.add_answers(&time_by_card(&results, card), &CARD_MOTIONS);
                }
                group.add_answers(&results, &MOTIONS);
                if !group.answers.is_empty() {
                    out.push(group);
                }
            }
        }
    }
    out
}

/// Returns a scene's results without those of wgpu, if they are to be omitted.
fn without_backends(scene: &SceneResult, omits_wgpu: bool) -> SceneResult {
    let mut scene = scene.clone();
    scene
        .rows
        .retain(|row| !(omits_wgpu && row.backend == "wgpu"));
    scene
}

impl WhichGroup {
    /// Adds the answers of each backend of some scenes.
    fn add_answers(&mut self, scenes: &[SceneResult], motions: &'static [LabelledMotion]) {
        let under_motion = |motion| {
            let moving = scenes.iter().map(|scene| SceneResult {
                motion,
                ..scene.clone()
            });
            let moving: Vec<SceneResult> = moving.collect();
            relative(&moving.iter().collect::<Vec<_>>())
        };
        let by_motion: Vec<Vec<Relative>> = motions.iter().map(|m| under_motion(m.0)).collect();
        let mut backends: Vec<&String> = Vec::new();
        for setting in by_motion.iter().flatten() {
            if !backends.contains(&&setting.backend) {
                backends.push(&setting.backend);
            }
        }
        for backend in backends {
            let of_backend = |all: &Vec<Relative>| {
                let settings = all.iter().filter(|setting| setting.backend == *backend);
                settings.cloned().collect()
            };
            let settings: Vec<Vec<Relative>> = by_motion.iter().map(of_backend).collect();
            let is_timed = settings.iter().flatten().any(|s| s.time.is_some());
            let clock = if is_timed {
                CostBasis::Wall
            } else {
                CostBasis::Cost
            };
            let mut table = Vec::new();
            for budget in BUDGETS {
                let answers = settings.iter().map(|all| best_within(all, clock, budget));
                table.push(
                    answers
                        .map(|answer| answer.map(|a| self.place_of(a)))
                        .collect(),
                );
            }
            self.backends.push(OfBackend {
                backend: backend.clone(),
                motions,
                scenes: scenes.to_vec(),
                table,
                settings,
                clock,
            });
        }
    }

    /// Returns the index of an answer; adds a new one.
    fn place_of(&mut self, setting: &Relative) -> usize {
        let answer = Answer::from_setting(setting);
        let known = self.answers.iter().position(|other| *other == answer);
        known.unwrap_or_else(|| {
            self.answers.push(answer);
            self.answers.len() - 1
        })
    }
}

impl OfBackend {
    /// Reports whether the times are those of a card.
    pub(super) fn is_card(&self) -> bool {
        self.motions == CARD_MOTIONS
    }

    /// Returns the index of the motion that the short table shows: the camera moves.
    pub(super) fn usual_motion(&self) -> usize {
        let motions = self.motions.iter();
        let usual = motions.map(|(motion, _)| *motion == FrameMotion::CameraMoves);
        usual.take_while(|is_usual| !is_usual).count()
    }

    /// Returns the fastest setting under a motion, by its index, that is not [`POOR`]. `None` if all
    /// are.
    pub(super) fn fastest_good(&self, motion: usize) -> Option<&Relative> {
        let time = |s: &Relative| s.take(self.clock).unwrap_or(f64::INFINITY);
        let all = self.settings[motion].iter();
        let good = all.filter(|s| s.technique != "none" && s.error <= POOR);
        good.min_by(|a, b| time(a).total_cmp(&time(b)))
    }

    /// Returns an answer's results under a motion, by its index.
    pub(super) fn setting(&self, answer: &Answer, motion: usize) -> Option<&Relative> {
        self.settings[motion]
            .iter()
            .find(|s| s.technique == answer.technique && s.settings == answer.settings)
    }
}

/// Returns the fastest setting within a budget whose error is at most [`AS_GOOD`] times the least.
/// `None` if no setting within it is better than no shadow.
fn best_within(settings: &[Relative], clock: CostBasis, budget: f64) -> Option<&Relative> {
    let time = |s: &Relative| s.take(clock).unwrap_or(f64::INFINITY);
    // Errors below this are invisible.
    let error = |s: &Relative| s.error.max(MIN_ERROR);
    let within = settings
        .iter()
        .filter(|s| s.technique != "none" && s.error < 1.0)
        .filter(|s| s.take(clock).is_some_and(|time| time <= budget));
    let within: Vec<&Relative> = within.collect();
    let least = within.iter().map(|s| error(s)).min_by(f64::total_cmp)?;
    let good = within.into_iter().filter(|s| error(s) <= AS_GOOD * least);
    good.min_by(|a, b| time(a).total_cmp(&time(b)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::TimingStats;

    fn setting(technique: &str, error: f64, time: f64) -> Relative {
        let stats = TimingStats {
            median: time,
            ..TimingStats::default()
        };
        Relative {
            technique: technique.to_owned(),
            settings: String::new(),
            backend: "cpu".to_owned(),
            error,
            time: Some(stats),
            cost: 1.0,
            served: 1,
            scenes: 1,
        }
    }

    #[test]
    fn the_least_error_within_the_budget_and_of_equals_the_quickest() {
        let all = [
            setting("none", 0.0, 0.1),
            setting("worse", 1.0, 0.1),
            setting("hard", 0.3, 1.0),
            setting("pcf", 0.21, 1.5),
            setting("pcf_disc", 0.2, 1.8),
            setting("traced", 0.0, 12.0),
            setting("volumes", 0.0005, 9.0),
        ];
        let best = |budget| best_within(&all, CostBasis::Wall, budget).map(|s| &s.technique[..]);
        assert_eq!(best(0.5), None);
        assert_eq!(best(1.25), Some("hard"));
        // `pcf_disc` is better by less than a tenth.
        assert_eq!(best(2.0), Some("pcf"));
        // Both are exact to the eye.
        assert_eq!(best(f64::INFINITY), Some("volumes"));
    }
}
