//! Recommended settings for one kind of light on one backend: the Pareto front and a choice from
//! it.
//!
//! * **Knee**: the least product of error and time. Up to there, each doubling of the time more
//!   than halves the error. Exact settings are excluded, as their product is 0.
//! * **Best**: the least error. The cheapest exact setting if there is one.
//! * **Cheapest**: error at most half of that without shadows, and time at most eight tenths of the
//!   knee's.
//!
//! `none` is excluded from all of them, as it takes no time, and so are settings that are no better
//! than it ([`SettingGroup::error_of_none`]). If all of them trace rays, which some
//! renderers can't, the knee without rays is named, too.

use super::{
    options::Section,
    relative::{MIN_ERROR, Relative, SceneGroup, relative, scene_groups},
    result::{Comparison, CostBasis},
};
use umbrage_plan::{motion::FrameMotion, pareto};

/// Maximum relative error of the cheapest setting.
const MAX_CHEAP_ERROR: f64 = 0.5;
/// Maximum time of the cheapest setting, as a share of the knee's. A smaller difference is mostly
/// noise.
const MAX_CHEAP_TIME: f64 = 0.8;

/// Settings of one backend over all scenes with one kind of light.
#[derive(Clone, Debug, PartialEq)]
pub struct SettingGroup {
    /// `hard` or `soft`.
    pub light: &'static str,
    /// Purpose of the scenes.
    pub section: Section,
    /// Motion between frames.
    pub motion: FrameMotion,
    /// Indices of the scenes in the comparison.
    pub scenes: Vec<usize>,
    /// Kind of the backend.
    pub backend: String,
    /// Relative error of no shadow: the share of the scenes with shadows that count. In other
    /// scenes, no shadow is exact.
    pub error_of_none: f64,
    /// The settings.
    pub settings: Vec<Relative>,
}

/// Recommended settings, as indices into those of a group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Choice {
    /// The cheapest with at most half of the error without shadows. Equal to [`Self::knee`] if none
    /// is clearly cheaper.
    pub cheapest: usize,
    /// The least product of error and time.
    pub knee: usize,
    /// The least error.
    pub best: usize,
    /// The least product of error and time without rays. `None` unless all others trace rays.
    pub without_rays: Option<usize>,
}

impl Choice {
    /// Returns the settings in the order of [`SettingGroup::advice`], without duplicates.
    pub fn named_settings(&self) -> Vec<usize> {
        let mut out: Vec<usize> = Vec::new();
        let without_rays = self.without_rays.unwrap_or(self.knee);
        for setting in [self.knee, self.cheapest, self.best, without_rays] {
            if !out.contains(&setting) {
                out.push(setting);
            }
        }
        out
    }
}

/// Returns the groups of a comparison, hard shadows first. Kinds of light without results have no
/// group.
pub fn setting_groups(comparison: &Comparison) -> Vec<SettingGroup> {
    let mut out = Vec::new();
    for group in scene_groups(comparison) {
        let all = relative(&group.scenes);
        let mut backends: Vec<&str> = Vec::new();
        for setting in &all {
            if !backends.contains(&setting.backend.as_str()) {
                backends.push(&setting.backend);
            }
        }
        for backend in backends {
            let of_backend = all.iter().filter(|r| r.backend == backend);
            out.push(SettingGroup {
                light: group.light(),
                section: group.section,
                motion: group.scenes[0].motion,
                scenes: places(comparison, &group),
                error_of_none: error_of_none(&group),
                backend: backend.to_owned(),
                settings: of_backend.cloned().collect(),
            });
        }
    }
    out
}

/// Returns the relative error of no shadow over a group's scenes ([`relative`]).
fn error_of_none(group: &SceneGroup<'_>) -> f64 {
    let scenes = || group.scenes.iter().filter(|s| s.error_of_none() > 0.0);
    let with_shadow = scenes().filter(|s| s.rmse_of_none[0] > 0.0).count();
    match scenes().count() {
        0 => 1.0,
        all => with_shadow as f64 / all as f64,
    }
}

/// Returns the indices of a group's scenes in its comparison.
fn places(comparison: &Comparison, group: &SceneGroup<'_>) -> Vec<usize> {
    let scenes = comparison.scenes.iter().enumerate();
    let of_group =
        scenes.filter(|(_, scene)| group.scenes.iter().any(|s| std::ptr::eq(*s, *scene)));
    of_group.map(|(place, _)| place).collect()
}

impl Relative {
    /// Reports whether the error is too small to be visible.
    pub fn is_exact(&self) -> bool {
        self.error < MIN_ERROR
    }
}

impl SettingGroup {
    /// Returns the basis of the choice: measured time, or predicted cost if nothing was timed.
    pub fn clock(&self) -> CostBasis {
        if self.settings.iter().any(|s| s.time.is_some()) {
            CostBasis::Wall
        } else {
            CostBasis::Cost
        }
    }

    /// Returns the settings on the Pareto front, in order of increasing time. Exact ones count as
    /// equally good.
    pub fn front(&self, clock: CostBasis) -> Vec<usize> {
        let mut points = Vec::with_capacity(self.settings.len());
        for setting in &self.settings {
            points.push(match setting.take(clock) {
                Some(time) if setting.technique != "none" => [time, setting.error.max(MIN_ERROR)],
                _ => [f64::NAN; 2],
            });
        }
        pareto::front(&points)
    }

    /// Returns the product of a setting's error and time. Infinite without a time, for `none`, for
    /// exact settings, and for those no better than no shadow.
    fn product(&self, setting: usize) -> f64 {
        let r = &self.settings[setting];
        match r.take(self.clock()) {
            Some(time) if r.technique != "none" && !r.is_exact() && self.helps(setting) => {
                time * r.error
            }
            _ => f64::INFINITY,
        }
    }

    /// Reports whether a setting is better than no shadow.
    fn helps(&self, setting: usize) -> bool {
        self.settings[setting].error < self.error_of_none
    }

    /// Reports whether no shadow is exact in all scenes, since nothing that counts is in shadow.
    pub fn has_no_shadow(&self) -> bool {
        self.error_of_none == 0.0
    }

    /// Reports whether a setting has at most half of the error without shadows.
    pub fn has_good_setting(&self) -> bool {
        let error = |setting: usize| self.settings[setting].error;
        self.choice()
            .is_some_and(|choice| error(choice.best) <= MAX_CHEAP_ERROR * self.error_of_none)
    }

    /// Returns the settings that are better than no shadow and not exact, in order of increasing
    /// product of error and time.
    fn by_product(&self) -> Vec<usize> {
        let mut out: Vec<usize> = (0..self.settings.len()).collect();
        out.retain(|&i| self.product(i).is_finite());
        out.sort_by(|&a, &b| self.product(a).total_cmp(&self.product(b)));
        out
    }

    /// Returns the recommended settings. `None` if nothing is better than no shadow.
    pub fn choice(&self) -> Option<Choice> {
        let clock = self.clock();
        let mut front = self.front(clock);
        front.retain(|&i| self.helps(i));
        let error = |i: &usize| self.settings[*i].error;
        // The front's error falls with increasing time.
        let best = *front.last()?;
        let by_product = self.by_product();
        let knee = by_product.iter().find(|&i| front.contains(i));
        let knee = *knee.unwrap_or(&best);
        let time = |i: &usize| self.settings[*i].take(clock).unwrap_or_default();
        let cheapest = *front
            .iter()
            .find(|i| error(i) <= MAX_CHEAP_ERROR)
            .filter(|i| time(i) <= MAX_CHEAP_TIME * time(&knee))
            .unwrap_or(&knee);
        let traces = |setting: usize| self.settings[setting].traces_rays();
        let all_trace = [cheapest, knee, best].into_iter().all(traces);
        let without_rays = by_product.into_iter().find(|&i| !traces(i));
        Some(Choice {
            cheapest,
            knee,
            best,
            without_rays: without_rays.filter(|_| all_trace),
        })
    }

    /// Returns at most `count` settings, in order of increasing time.
    ///
    /// Their order: [`Self::choice`], settings of other techniques with the least product
    /// of error and time, and settings of the front with the least error.
    pub fn shortlist(&self, count: usize) -> Vec<usize> {
        let Some(choice) = self.choice() else {
            return Vec::new();
        };
        let mut wanted = vec![choice.knee, choice.best];
        wanted.extend(choice.without_rays);
        wanted.push(choice.cheapest);
        for setting in self.by_product() {
            let technique = |i: usize| &self.settings[i].technique;
            if !wanted
                .iter()
                .any(|&other| technique(other) == technique(setting))
            {
                wanted.push(setting);
            }
        }
        let front = self.front(self.clock()).into_iter().rev();
        wanted.extend(front.filter(|&i| self.helps(i)));
        let mut out: Vec<usize> = Vec::new();
        for setting in wanted {
            if out.len() < count && !out.contains(&setting) {
                out.push(setting);
            }
        }
        let time = |setting: usize| {
            self.settings[setting]
                .take(self.clock())
                .unwrap_or_default()
        };
        out.sort_by(|&a, &b| time(a).total_cmp(&time(b)));
        out
    }

    /// Returns the recommendation as a sentence. `None` if nothing is better than no shadow.
    pub fn advice(&self) -> Option<String> {
        let choice = self.choice()?;
        let mut out = self.clause(choice.knee, true);
        if choice.cheapest != choice.knee {
            out += &format!("; cheaper: {}", self.clause(choice.cheapest, false));
        }
        if choice.best != choice.knee {
            let is_exact = self.settings[choice.best].is_exact();
            let word = if is_exact { "exact" } else { "least error" };
            out += &format!("; {word}: {}", self.clause(choice.best, false));
        }
        if let Some(setting) = choice.without_rays {
            out += &format!("; without rays: {}", self.clause(setting, false));
        }
        Some(out + ".")
    }

    /// Formats a setting with its error and time. `in_full` adds the references of both.
    fn clause(&self, setting: usize, in_full: bool) -> String {
        let clock = self.clock();
        let r = &self.settings[setting];
        let [of_none, of_hard] = match (in_full, clock) {
            (false, _) => ["", ""],
            (true, CostBasis::Wall) => [" of the error of no shadow", " the time of a hard map"],
            (true, CostBasis::Cost) => [" of the error of no shadow", " the cost of a hard map"],
        };
        let times = times(r.take(clock).unwrap_or_default());
        let name = r.name();
        if r.is_exact() && in_full {
            return format!("{name}, exact at {times}{of_hard}");
        }
        if r.is_exact() {
            return format!("{name} at {times}");
        }
        let error = percent(r.error);
        format!("{name}, {error}{of_none} at {times}{of_hard}")
    }
}

impl Relative {
    /// Reports whether it traces rays, as a technique or as a preset. Settings of a preset begin
    /// with the technique's name.
    fn traces_rays(&self) -> bool {
        self.technique == "traced" || self.settings.starts_with("traced, ")
    }

    /// Returns the technique with its settings.
    pub fn name(&self) -> String {
        if self.settings.is_empty() {
            self.technique.clone()
        } else {
            format!("{} ({})", self.technique, self.settings)
        }
    }
}

/// Formats a relative error in percent with two digits.
pub fn percent(error: f64) -> String {
    let percent = 100.0 * error;
    if percent < 10.0 {
        format!("{percent:.1} %")
    } else {
        format!("{percent:.0} %")
    }
}

/// Formats a relative time with two digits.
pub fn times(ratio: f64) -> String {
    if ratio < 0.1 {
        format!("{ratio:.2} times")
    } else if ratio < 10.0 {
        format!("{ratio:.1} times")
    } else {
        format!("{ratio:.0} times")
    }
}

/// Formats a count with commas between thousands.
pub(crate) fn thousands(count: u64) -> String {
    let digits = count.to_string();
    let mut out = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::result::{SceneResult, TimingStats};

    fn setting(technique: &str, error: f64, time: f64) -> Relative {
        Relative {
            technique: technique.into(),
            settings: String::new(),
            backend: "cpu".into(),
            error,
            time: Some(TimingStats {
                median: time,
                ..TimingStats::default()
            }),
            cost: 1.0 / time,
            served: 1,
            scenes: 1,
        }
    }

    fn group(settings: Vec<Relative>) -> SettingGroup {
        SettingGroup {
            light: "hard",
            section: Section::Content,
            motion: FrameMotion::CameraMoves,
            scenes: vec![0],
            backend: "cpu".into(),
            error_of_none: 1.0,
            settings,
        }
    }

    fn usual() -> SettingGroup {
        group(vec![
            setting("none", 1.0, 0.001),
            setting("hard", 0.25, 0.7),
            setting("pcf", 0.11, 1.1),
            setting("pcss", 0.1, 4.0),
            setting("beaten", 0.2, 5.0),
            setting("volumes", 0.0, 12.0),
            setting("traced", 0.0001, 20.0),
        ])
    }

    #[test]
    fn what_to_use_is_the_least_product_and_the_cheapest_exact_one() {
        let group = usual();
        assert_eq!(group.front(CostBasis::Wall), [1, 2, 3, 5]);
        let choice = Choice {
            cheapest: 1,
            knee: 2,
            best: 5,
            without_rays: None,
        };
        assert_eq!(group.choice(), Some(choice));
        assert_eq!(choice.named_settings(), [2, 1, 5]);
        assert_eq!(
            group.advice().as_deref(),
            Some(
                "pcf, 11 % of the error of no shadow at 1.1 times the time of a hard map; cheaper: hard, 25 % at 0.7 times; exact: volumes at 12 times."
            )
        );
        assert_eq!(group.shortlist(2), [2, 5]);
        assert_eq!(group.shortlist(5), [1, 2, 3, 4, 5]);
    }

    #[test]
    fn an_exact_setting_that_is_quickest_is_the_only_one() {
        let group = group(vec![setting("hard", 0.2, 1.0), setting("traced", 0.0, 0.5)]);
        assert_eq!(
            group.advice().as_deref(),
            Some(
                "traced, exact at 0.5 times the time of a hard map; without rays: hard, 20 % at 1.0 times."
            )
        );
        assert_eq!(group.shortlist(3), [1, 0]);
    }

    #[test]
    fn where_nothing_helps_nothing_is_named() {
        let of_none = group(vec![setting("none", 1.0, 0.1), setting("hard", 1.2, 1.0)]);
        assert_eq!((of_none.choice(), of_none.advice()), (None, None));
        let poor = group(vec![setting("hard", 0.8, 1.0), setting("pcss", 0.7, 2.0)]);
        let sentence = poor.advice().expect("better than none");
        assert!(
            sentence.starts_with("hard, 80 %") && sentence.contains("least error: pcss, 70 %"),
            "{sentence}"
        );
    }

    /// The front of time and error includes settings that are worse than no shadow.
    #[test]
    fn what_is_worse_than_no_shadow_is_not_named() {
        let worse = group(vec![
            setting("none", 1.0, 0.1),
            setting("acne", 34.0, 0.7),
            setting("hard", 1.0, 1.0),
            setting("volumes", 0.0, 1.7),
        ]);
        assert_eq!(worse.front(CostBasis::Wall), [1, 2, 3]);
        assert_eq!(worse.shortlist(8), [3]);
        assert!(worse.has_good_setting());
        let mut poor = group(vec![setting("hard", 0.8, 1.0)]);
        assert!(!poor.has_good_setting() && !poor.has_no_shadow());
        assert_eq!(poor.shortlist(8), [0]);
        // Where nothing is in shadow, errors are relative to a dark mask, and none helps.
        poor.error_of_none = 0.0;
        poor.settings.push(setting("exact", 0.0, 9.0));
        assert!(poor.has_no_shadow() && !poor.has_good_setting());
        assert_eq!((poor.choice(), poor.shortlist(8)), (None, vec![]));
        // In one of four scenes nothing is in shadow.
        poor.error_of_none = 0.75;
        assert_eq!(poor.shortlist(8), [1]);
    }

    #[test]
    fn no_shadow_is_exact_in_scenes_without_shadow() {
        let scene = |rmse_of_none| SceneResult {
            rmse_of_none,
            ..SceneResult::default()
        };
        let scenes = [[0.3, 0.9], [0.0, 1.0], [0.1, 0.9], [0.2, 0.9], [0.0, 0.0]].map(scene);
        let group = |scenes: &[usize], all: &[SceneResult]| {
            error_of_none(&SceneGroup {
                is_ideal: true,
                section: Section::Check,
                scenes: scenes.iter().map(|&i| &all[i]).collect(),
            })
        };
        // The last one has no pixel that counts.
        assert_eq!(group(&[0, 1, 2, 3, 4], &scenes), 0.75);
        assert_eq!(group(&[1], &scenes), 0.0);
        assert_eq!(group(&[4], &scenes), 1.0);
    }

    #[test]
    fn what_is_hardly_cheaper_is_not_named() {
        let mut group = usual();
        group.settings[1] = setting("hard", 0.25, 1.0);
        let words = group.advice().expect("better than none");
        assert!(!words.contains("cheaper"), "{words}");
    }

    #[test]
    fn without_times_counted_costs_decide() {
        let mut group = usual();
        for setting in &mut group.settings {
            setting.time = None;
        }
        assert_eq!(group.clock(), CostBasis::Cost);
        assert_eq!(group.front(CostBasis::Cost), [6]);
        assert!(
            group
                .advice()
                .expect("exact")
                .contains("the cost of a hard map")
        );
    }

    #[test]
    fn figures_have_two_digits() {
        let figures = [0.034, 0.34, 0.062].map(percent);
        assert_eq!(figures, ["3.4 %", "34 %", "6.2 %"]);
        assert_eq!(
            [0.062, 0.62, 6.25, 62.4].map(times),
            ["0.06 times", "0.6 times", "6.2 times", "62 times"]
        );
    }
}
