//! Times rows in turn with a yardstick, and the making of their recipes.
//!
//! A graphics device clocks down while the CPU traces truth or prepares a row. So before each row,
//! the device renders the yardstick until its time reaches the least one so far. Rows are compared
//! by the ratio of their time to the yardstick's. This ratio times the yardstick's least time on
//! the device is the row's time at full clock.

use super::{
    backends::Backends,
    options::{CompareOptions, Runs, SceneInput},
    result::{Ranks, RowTimes, TimingStats, has_device_clock, stem_of},
    settings::settings_of,
};
use crate::error::LabError;
use std::time::{Duration, Instant};
use umbrage_core::{
    Backend, BackendError, Geometry, Receivers, Recipe, RecipeError, ShadowTechnique, Shadows,
    Timings, View,
};
use umbrage_plan::cost::Work;
use umbrage_yardstick::{MAX_UNITS, MIN_UNITS, Yardstick};

/// Renders a recipe once for the mask, and then until its time is known.
///
/// The first run compiles, uploads and finds receivers. The timed runs reuse its receivers, which
/// excludes the cost of finding them and reading them back.
pub(super) fn measure(
    backend: &mut dyn Backend,
    view: &View<'_>,
    recipe: &Recipe,
    runs: Option<&Runs>,
    cost_ms: f64,
    clock: &mut DeviceClock,
) -> Result<(Shadows, Option<RowTimes>), BackendError> {
    let first = backend.render(view, recipe)?;
    let Some(runs) = runs else {
        return Ok((first, None));
    };
    if runs.one_is_enough(first.timings.total()) {
        // Discard the first run if it compiled: the CPU compiles nothing, others in less than a
        // second.
        let compiles = backend.kind() != "cpu";
        let timings = if compiles && !runs.dwarfs_compilation(first.timings.total()) {
            backend.render(view, recipe)?.timings
        } else {
            first.timings
        };
        let once = Timed {
            device_units: None,
            timings: vec![timings],
            yardsticks: Vec::new(),
        };
        let times = once.times();
        return Ok((first, Some(times)));
    }
    let receivers = first.receivers.as_ref().or(view.receivers);
    let times = time(backend, view, receivers, recipe, runs, cost_ms, clock)?.times();
    Ok((first, Some(times)))
}

/// Maximum number of timed recipes.
const RECIPES: u32 = 3;
/// Time after which no further recipe is made, seconds.
const MAX_SECONDS: f64 = 0.5;

/// Makes a recipe and measures the time.
///
/// # Errors
/// Errors if the technique can't make it.
pub(super) fn time_recipe(
    technique: &dyn ShadowTechnique,
    view: &View<'_>,
) -> Result<(Recipe, TimingStats), RecipeError> {
    let recipe = technique.recipe(view)?;
    recipe.make_tables();
    let start = Instant::now();
    let mut times = Vec::new();
    for _ in 0..RECIPES {
        let one = Instant::now();
        technique.recipe(view)?.make_tables();
        times.push(one.elapsed().as_secs_f64() * 1e3);
        if start.elapsed().as_secs_f64() > MAX_SECONDS {
            break;
        }
    }
    Ok((recipe, TimingStats::from_times(times).unwrap_or_default()))
}

/// Returns the additional time of a first recipe for the triangles of a scene over `later_ms`,
/// milliseconds. 0 if the technique doesn't support the scene.
pub(super) fn time_of_scene(
    technique: &dyn ShadowTechnique,
    view: &View<'_>,
    later_ms: f64,
) -> f64 {
    let fresh = view.geometry.map(Geometry::without_hierarchies);
    let view = View {
        geometry: fresh.as_ref(),
        ..*view
    };
    let start = Instant::now();
    match technique.recipe(&view) {
        Ok(recipe) => recipe.make_tables(),
        Err(_) => return 0.0,
    }
    let first_ms = start.elapsed().as_secs_f64() * 1e3;
    (first_ms - later_ms).max(0.0)
}

/// Clock of a graphics device over the rows of a scene, which share one yardstick.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DeviceClock {
    /// The yardstick's work, units. `None` until it is chosen.
    units: Option<f64>,
    /// Least time of the yardstick above 0 so far, milliseconds per unit. Infinite at first.
    least: f64,
}

/// Minimum time of a device's yardstick at full clock, milliseconds: far longer than the steps of
/// its timestamps.
const DEVICE_YARDSTICK_MS: f64 = 0.5;
/// Time of rendering yardsticks before one is chosen, so that the device reaches its full clock.
const FIRST_WARM_UP: Duration = Duration::from_millis(300);
/// Maximum time to reach the full clock again before a row.
const MAX_WARM_UP: Duration = Duration::from_millis(100);
/// Number of consecutive yardsticks near the least time at which a device is at full clock.
const STEADY_YARDSTICKS: u32 = 3;

impl DeviceClock {
    /// Returns an unknown clock. `units` are those of an earlier yardstick of the same length.
    /// `None` to choose them.
    pub(super) fn new(units: Option<f64>) -> Self {
        Self {
            units,
            least: f64::INFINITY,
        }
    }

    /// Returns the yardstick's least time, milliseconds per unit. `None` if no row was timed with
    /// it.
    pub(super) fn least_yardstick(&self) -> Option<f64> {
        self.least.is_finite().then_some(self.least)
    }

    /// Renders the yardstick until the device is at full clock, and returns it for the row. `None`
    /// if nothing receives, or the backend can't time it.
    fn warm_up(
        &mut self,
        backend: &mut dyn Backend,
        view: &View<'_>,
        recipe: &Recipe,
        receivers: &Receivers,
    ) -> Result<Option<Yardstick>, BackendError> {
        let mut render = |units: f64| -> Result<_, BackendError> {
            let yardstick = Yardstick::with_units(recipe, receivers, units);
            let per_unit = time_yardstick(backend, view, yardstick.as_ref())?;
            Ok(yardstick.zip(per_unit))
        };
        if self.least.is_infinite() {
            let mut time =
                |units| Ok(render(units)?.map(|(yardstick, per_unit)| per_unit * yardstick.units));
            if !self.reach_full_clock(&mut time)? {
                return Ok(None);
            }
        }
        let units = self.units.unwrap_or(MAX_UNITS);
        let mut steady = 0;
        let start = Instant::now();
        loop {
            let Some((yardstick, per_unit)) = render(units)? else {
                return Ok(None);
            };
            // Timestamps may be 0.
            if per_unit > 0.0 {
                self.least = self.least.min(per_unit);
            }
            let is_near = per_unit <= CALM * self.least;
            steady = if is_near { steady + 1 } else { 0 };
            if steady >= STEADY_YARDSTICKS || start.elapsed() >= MAX_WARM_UP {
                return Ok(Some(yardstick));
            }
        }
    }

    /// Renders yardsticks for [`FIRST_WARM_UP`], then chooses the units if there are none: a low
    /// clock would make the yardstick too short.
    ///
    /// Returns whether yardsticks can be timed. `time` renders a yardstick with this number of
    /// units and returns its time, milliseconds.
    fn reach_full_clock(
        &mut self,
        time: &mut dyn FnMut(f64) -> Result<Option<f64>, BackendError>,
    ) -> Result<bool, BackendError> {
        let start = Instant::now();
        let mut units = MIN_UNITS;
        while start.elapsed() < FIRST_WARM_UP {
            let Some(ms) = time(units)? else {
                return Ok(false);
            };
            // Longer yardsticks leave the device idle for less time between them.
            if ms < DEVICE_YARDSTICK_MS {
                units = MAX_UNITS.min(2.0 * units);
            }
        }
        let mut units = MIN_UNITS;
        while self.units.is_none() {
            let mut least_ms = f64::INFINITY;
            for _ in 0..STEADY_YARDSTICKS {
                let Some(ms) = time(units)? else {
                    return Ok(false);
                };
                least_ms = least_ms.min(ms);
            }
            if least_ms >= DEVICE_YARDSTICK_MS || units >= MAX_UNITS {
                self.units = Some(units);
            }
            units *= 2.0;
        }
        Ok(true)
    }
}

/// Times a recipe that has been rendered before: yardstick, row, yardstick, row, .., yardstick.
///
/// `cost_ms` is the row's predicted time, milliseconds, which sets the yardstick's amount of work
/// on the CPU. If the row gets too few runs to be judged, there are no yardsticks on the CPU.
/// Devices have the same yardstick in all rows, and are warm before the first run.
fn time(
    backend: &mut dyn Backend,
    view: &View<'_>,
    receivers: Option<&Receivers>,
    recipe: &Recipe,
    runs: &Runs,
    cost_ms: f64,
    clock: &mut DeviceClock,
) -> Result<Timed, BackendError> {
    // Choose the yardstick.
    let view = receivers.map_or(*view, |r| view.with_receivers(r));
    let yardstick = match receivers {
        Some(receivers) if has_device_clock(backend.kind()) => {
            clock.warm_up(backend, &view, recipe, receivers)?
        }
        Some(receivers) if runs.suffice_for_baselines() => {
            Yardstick::new(recipe, receivers, cost_ms)
        }
        _ => None,
    };
    // Discard the first yardstick, which compiles and uploads.
    time_yardstick(backend, &view, yardstick.as_ref())?;
    let before = time_yardstick(backend, &view, yardstick.as_ref())?;
    let is_on_device = has_device_clock(backend.kind());
    let mut out = Timed {
        device_units: clock.units.filter(|_| is_on_device && yardstick.is_some()),
        timings: Vec::new(),
        yardsticks: vec![before],
    };
    // Alternate runs and yardsticks.
    let mut spent = Duration::ZERO;
    loop {
        let count = out.timings.len();
        let needs_more = !runs.suffice(count, spent);
        let may_get_calm = runs.may_repeat(count, spent) && !out.is_calm(runs);
        if !needs_more && !may_get_calm {
            if is_on_device {
                clock.least = clock.least.min(out.min_yardstick());
            }
            return Ok(out);
        }
        let start = Instant::now();
        out.timings.push(backend.render(&view, recipe)?.timings);
        spent += start.elapsed();
        let after = time_yardstick(backend, &view, yardstick.as_ref())?;
        out.yardsticks.push(after);
    }
}

/// Returns the time of a yardstick, milliseconds per unit. `None` without a yardstick, or if the
/// backend can't time it.
fn time_yardstick(
    backend: &mut dyn Backend,
    view: &View<'_>,
    yardstick: Option<&Yardstick>,
) -> Result<Option<f64>, BackendError> {
    let Some(yardstick) = yardstick else {
        return Ok(None);
    };
    let timings = backend.render(view, &yardstick.recipe)?.timings;
    Ok(timings
        .receive
        .map(|elapsed| milliseconds(elapsed) / yardstick.units))
}

/// Maximum ratio of an adjacent yardstick to the fastest one. Beyond it, other programs delayed the
/// machine or the device changed its clock, and the run is ignored.
pub const CALM: f64 = 1.3;

/// A run between two yardsticks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TimedRun {
    /// The run's time, milliseconds.
    run: f64,
    /// Time of the yardstick before it, milliseconds per unit.
    before: f64,
    /// Time of the yardstick after it, milliseconds per unit.
    after: f64,
}

impl TimedRun {
    /// Reports whether neither yardstick took more than [`CALM`] times the other or
    /// `min_yardstick`, and both took a measurable time.
    fn is_calm(&self, min_yardstick: f64) -> bool {
        let slower = self.before.max(self.after);
        let quicker = self.before.min(self.after);
        slower <= CALM * quicker.min(min_yardstick) && quicker > 0.0
    }

    /// Returns the run's time divided by the mean of the two yardsticks.
    fn ratio(&self) -> f64 {
        2.0 * self.run / (self.before + self.after)
    }
}

/// Returns the ratios of a row's calm runs.
///
/// On the CPU no adjacent yardstick of a calm run took more than [`CALM`] times `min_yardstick`,
/// the fastest. A device may have a low clock all the time: its two yardsticks only need to be near
/// each other.
fn calm(runs: &[TimedRun], min_yardstick: f64, device_units: Option<f64>) -> Vec<f64> {
    let limit = device_units.map_or(min_yardstick, |_| f64::INFINITY);
    runs.iter()
        .filter(|run| run.is_calm(limit))
        .map(TimedRun::ratio)
        .collect()
}

/// Runs of a row in turn with a yardstick.
struct Timed {
    /// Units of the yardstick on a device with its own clock. `None` on the CPU.
    device_units: Option<f64>,
    timings: Vec<Timings>,
    /// Times of the yardstick before the first run and after each run, milliseconds per unit.
    yardsticks: Vec<Option<f64>>,
}

impl Timed {
    fn times(&self) -> RowTimes {
        RowTimes {
            cast: self.stage(|t| t.cast),
            filter: self.stage(|t| t.filter),
            receive: self.stage(|t| t.receive),
            total: self.stage(|t| Some(t.total())).unwrap_or_default(),
            yardstick: TimingStats::from_times(self.yardsticks.iter().copied().flatten().collect()),
            ratio: Ranks::from_figures(self.calm_ratios()),
            full_clock_factor: None,
            device_units: self.device_units,
        }
    }

    /// Returns the times of one stage over all runs. `None` if it was not timed.
    fn stage(&self, time_of: fn(&Timings) -> Option<Duration>) -> Option<TimingStats> {
        let times = self.timings.iter().filter_map(time_of);
        TimingStats::from_times(times.map(milliseconds).collect())
    }

    /// Returns the runs between two timed yardsticks.
    fn runs(&self) -> Vec<TimedRun> {
        let mut runs = Vec::new();
        for (timings, yardsticks) in self.timings.iter().zip(self.yardsticks.windows(2)) {
            if let (Some(before), Some(after)) = (yardsticks[0], yardsticks[1]) {
                let run = milliseconds(timings.total());
                runs.push(TimedRun { run, before, after });
            }
        }
        runs
    }

    /// Returns the fastest measurable yardstick, milliseconds per unit. Infinite without one.
    fn min_yardstick(&self) -> f64 {
        self.yardsticks
            .iter()
            .copied()
            .flatten()
            .filter(|per_unit| *per_unit > 0.0)
            .fold(f64::INFINITY, f64::min)
    }

    /// Returns the ratios of calm runs.
    fn calm_ratios(&self) -> Vec<f64> {
        calm(&self.runs(), self.min_yardstick(), self.device_units)
    }

    /// Reports whether at least `runs.min` runs were calm, or the yardstick can't be timed.
    fn is_calm(&self, runs: &Runs) -> bool {
        self.runs().is_empty() || self.calm_ratios().len() >= runs.min as usize
    }
}

/// Results of timing a row again.
#[derive(Clone, Debug)]
pub(crate) struct Again {
    /// Runs of the row.
    pub(crate) runs: Vec<TimedRun>,
    /// Fastest run, milliseconds.
    pub(crate) least_ms: f64,
    /// Fastest yardstick, milliseconds per unit.
    pub(crate) yardstick: f64,
    /// The yardstick's units on a device. `None` on the CPU.
    pub(crate) device_units: Option<f64>,
}

impl Default for Again {
    fn default() -> Self {
        Self {
            runs: Vec::new(),
            least_ms: f64::INFINITY,
            yardstick: f64::INFINITY,
            device_units: None,
        }
    }
}

impl Again {
    /// Adds another round.
    pub(crate) fn add(&mut self, more: Self) {
        self.runs.extend(more.runs);
        self.least_ms = self.least_ms.min(more.least_ms);
        self.yardstick = self.yardstick.min(more.yardstick);
        self.device_units = more.device_units;
    }

    /// Returns the ratios of calm runs.
    pub(crate) fn calm_ratios(&self) -> Vec<f64> {
        calm(&self.runs, self.yardstick, self.device_units)
    }
}

/// Times rows of a scene again, by their [stems](super::CompareRow::stem). On a device the
/// yardstick has `device_units`. `None` for rows that can no longer be rendered.
pub(crate) fn time_rows_again(
    input: &SceneInput,
    stems: &[String],
    device_units: Option<f64>,
    options: &CompareOptions,
    runs: &Runs,
    backends: &mut Backends,
) -> Result<Vec<Option<Again>>, LabError> {
    // Find the receivers and views of the scene.
    let (camera, light) = input.camera_and_light()?;
    let settings = settings_of(input, options)?;
    let options = input.options_or(options);
    let camera = options.camera(camera);
    let geometry = Geometry::bake(&input.scene)?;
    let receivers = backends.receivers.receivers(&camera, &geometry)?;
    let unknown = View::new(&camera, light, &geometry);
    let view = unknown.with_receivers(&receivers);
    let planning_view = if options.knows_receivers {
        view
    } else {
        unknown
    };
    backends.device_clock = DeviceClock::new(device_units);
    // Time each row.
    let mut out = Vec::new();
    for stem in stems {
        let mut found = None;
        let kind = stem.rsplit_once('.').map_or("", |(_, kind)| kind);
        let backend = backends.backends.iter_mut().find(|b| b.kind() == kind);
        let setting = settings.iter().find(|s| *stem == stem_of(&s.slug, kind));
        if let (Some(setting), Some(backend)) = (setting, backend)
            && let Ok(recipe) = setting.technique.recipe(&planning_view)
        {
            let cost_ms = options
                .prices
                .model_for_backend(kind)
                .milliseconds(&Work::of_recipe(&view, &recipe, &options.catalogue).without_lists());
            // Render once before timing: the first run compiles and uploads.
            backend.render(&view, &recipe)?;
            let timed = time(
                &mut **backend,
                &view,
                Some(&receivers),
                &recipe,
                runs,
                cost_ms,
                &mut backends.device_clock,
            )?;
            found = Some(Again {
                runs: timed.runs(),
                least_ms: timed.times().total.min,
                yardstick: timed.min_yardstick(),
                device_units: timed.device_units,
            });
        }
        out.push(found);
    }
    Ok(out)
}

fn milliseconds(d: Duration) -> f64 {
    d.as_secs_f64() * 1e3
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(ms: u64) -> Timings {
        Timings {
            receive: Some(Duration::from_millis(ms)),
            ..Timings::default()
        }
    }

    fn from_timings(timings: Vec<Timings>, yardsticks: &[Option<f64>]) -> RowTimes {
        Timed {
            device_units: None,
            timings,
            yardsticks: yardsticks.to_vec(),
        }
        .times()
    }

    /// A machine that slows down, and a row that always takes three yardsticks.
    #[test]
    fn what_slows_both_down_leaves_the_ratio() {
        let yards = [1.0, 1.04, 1.08, 1.12];
        let runs: Vec<Timings> = yards
            .windows(2)
            .map(|pair| Timings {
                receive: Some(Duration::from_secs_f64(1.5e-3 * (pair[0] + pair[1]))),
                ..Timings::default()
            })
            .collect();
        let found = from_timings(runs, &yards.map(Some));
        let ratio = found.ratio.expect("calm");
        assert!(
            ratio.runs == 3 && (ratio.tenth - 3.0).abs() < 1e-5 && (ratio.max - 3.0).abs() < 1e-5,
            "{ratio:?}"
        );
        assert!(
            (found.total.min - 3.06).abs() < 1e-5 && (found.total.max - 3.3).abs() < 1e-5,
            "{:?}",
            found.total
        );
        assert_eq!(found.yardstick.map(|y| (y.median, y.runs)), Some((1.06, 4)));
    }

    /// The third yardstick was delayed, and the adjacent runs may have been, too.
    #[test]
    fn runs_next_to_a_yardstick_that_was_held_up_do_not_count() {
        let found = from_timings(
            vec![run(6), run(60), run(600), run(6)],
            &[2.0, 2.0, 9.0, 2.0, 2.0].map(Some),
        );
        assert_eq!(found.ratio, Ranks::from_figures(vec![3.0, 3.0]));
        assert_eq!(
            (found.total.max, found.total.runs),
            (600.0, 4),
            "plain times include all"
        );
        assert_eq!(
            from_timings(vec![run(6)], &[2.0, 9.0].map(Some)).ratio,
            None,
            "never calm"
        );
    }

    /// A card that was fast once and has had a low clock since, and a card whose clock changes
    /// during a run.
    #[test]
    fn steady_yardsticks_at_a_low_clock_count_on_devices() {
        let ratio = |timings: Vec<Timings>, yardsticks: &[f64]| {
            let timed = Timed {
                device_units: Some(1.0),
                timings,
                yardsticks: yardsticks.iter().copied().map(Some).collect(),
            };
            timed.times().ratio
        };
        let found = ratio(vec![run(6), run(24), run(24)], &[2.0, 8.0, 8.0, 8.0]);
        assert_eq!(found, Ranks::from_figures(vec![3.0, 3.0]));
        assert_eq!(ratio(vec![run(6)], &[2.0, 8.0]), None);
        let slow = TimedRun {
            run: 24.0,
            before: 8.0,
            after: 8.0,
        };
        let again = |device_units| Again {
            runs: vec![slow],
            yardstick: 2.0,
            device_units,
            ..Again::default()
        };
        assert_eq!(again(Some(1.0)).calm_ratios(), [3.0], "timed again");
        assert!(again(None).calm_ratios().is_empty(), "the CPU was held up");
    }

    /// A device that takes 0.1 ms per unit at full clock, and four times as long in its first
    /// renders.
    #[test]
    fn the_yardstick_is_as_long_after_a_cold_start() {
        let units = |cold: u32| {
            let mut clock = DeviceClock::new(None);
            let mut renders = 0;
            let mut time = |units: f64| {
                renders += 1;
                let slowdown = if renders <= cold { 4.0 } else { 1.0 };
                Ok(Some(0.1 * slowdown * units))
            };
            assert!(clock.reach_full_clock(&mut time).expect("renders"));
            clock.units
        };
        assert_eq!((units(0), units(50)), (Some(8.0), Some(8.0)));
        let mut clock = DeviceClock::new(Some(2.0));
        assert!(
            clock
                .reach_full_clock(&mut |_| Ok(Some(0.1)))
                .expect("renders")
        );
        assert_eq!(clock.units, Some(2.0), "as long as an earlier one");
        assert!(!clock.reach_full_clock(&mut |_| Ok(None)).expect("no clock"));
    }

    #[test]
    fn without_a_yardstick_there_is_no_ratio() {
        let found = from_timings(vec![run(6)], &[None, None]);
        assert_eq!(
            (found.ratio, found.yardstick, found.total.median),
            (None, None, 6.0)
        );
        assert_eq!(
            from_timings(vec![run(6)], &[Some(0.0), Some(0.0)]).ratio,
            None,
            "a clock that didn't move"
        );
        let once_unmeasured = from_timings(vec![run(6), run(6)], &[0.0, 2.0, 2.0].map(Some));
        assert_eq!(once_unmeasured.ratio, Ranks::from_figures(vec![3.0]));
    }
}
