//! How long a row takes, in turn with a yardstick.

use super::{
    Backends, CompareOptions, Ranks, RowTimes, Runs, SceneInput, TimingStats, Yardstick,
    result::stem_of, scene::camera_and_light, settings_of,
};
use crate::LabError;
use std::time::{Duration, Instant};
use umbrage_core::{
    Backend, BackendError, Geometry, Receivers, Recipe, Shadows, Timings, View, Work,
};
use umbrage_plan::cost::CostModel;

/// Plays a recipe: once for the mask, which compiles, uploads and finds receivers, then until its time is known. The timed
/// runs are given the receivers of the first, so that finding and reading them back costs no time again.
pub(super) fn measure(
    backend: &mut dyn Backend,
    view: &View<'_>,
    recipe: &Recipe,
    (runs, cost_ms): (Option<&Runs>, f64),
) -> Result<(Shadows, Option<RowTimes>), BackendError> {
    let first = backend.render(view, recipe)?;
    let Some(runs) = runs else {
        return Ok((first, None));
    };
    let receivers = first.receivers.as_ref().or(view.receivers);
    let times = time(backend, (view, receivers), recipe, (runs, cost_ms))?.times();
    Ok((first, Some(times)))
}

/// Times a recipe that has been played before: yardstick, row, yardstick, row, .., yardstick.
fn time(
    backend: &mut dyn Backend,
    (view, receivers): (&View<'_>, Option<&Receivers>),
    recipe: &Recipe,
    (runs, cost_ms): (&Runs, f64),
) -> Result<Timed, BackendError> {
    let view = receivers.map_or(*view, |r| view.with_receivers(r));
    let yardstick = receivers.and_then(|r| Yardstick::new(recipe, r, cost_ms));
    let measure = |backend: &mut dyn Backend| -> Result<Option<f64>, BackendError> {
        let Some(yardstick) = &yardstick else {
            return Ok(None);
        };
        let timings = backend.render(&view, &yardstick.recipe)?.timings;
        Ok(timings
            .receive
            .map(|took| milliseconds(took) / yardstick.units))
    };
    // The first one compiles and uploads.
    measure(backend)?;
    let mut out = Timed {
        timings: Vec::new(),
        yards: vec![measure(backend)?],
    };
    let mut spent = Duration::ZERO;
    while !runs.suffice(out.timings.len(), spent)
        || runs.hopes(out.timings.len(), spent) && !out.is_calm(runs)
    {
        let start = Instant::now();
        out.timings.push(backend.render(&view, recipe)?.timings);
        spent += start.elapsed();
        out.yards.push(measure(backend)?);
    }
    Ok(out)
}

/// Yardsticks beside a run that took more than this times the quickest of them tell that others held up the machine: such
/// runs say nothing about the row.
pub const CALM: f64 = 1.3;

/// A run between two yardsticks, milliseconds; the yardsticks' a unit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Window {
    run: f64,
    around: [f64; 2],
}

/// Ratios of the runs beside which no yardstick took more than [`CALM`] times `least`.
pub(crate) fn calm(windows: &[Window], least: f64) -> Vec<f64> {
    let calm = |w: &&Window| {
        w.around[0].max(w.around[1]) <= CALM * least && w.around[0].min(w.around[1]) > 0.0
    };
    windows
        .iter()
        .filter(calm)
        .map(|w| 2.0 * w.run / (w.around[0] + w.around[1]))
        .collect()
}

/// Runs of a row, and the yardstick's times before the first and after each, milliseconds a unit.
struct Timed {
    timings: Vec<Timings>,
    yards: Vec<Option<f64>>,
}

impl Timed {
    fn times(&self) -> RowTimes {
        let stage = |of: fn(&Timings) -> Option<Duration>| {
            TimingStats::of(
                self.timings
                    .iter()
                    .filter_map(of)
                    .map(milliseconds)
                    .collect(),
            )
        };
        RowTimes {
            cast: stage(|t| t.cast),
            filter: stage(|t| t.filter),
            receive: stage(|t| t.receive),
            total: stage(|t| Some(t.total())).unwrap_or_default(),
            yardstick: TimingStats::of(self.yards.iter().copied().flatten().collect()),
            ratio: Ranks::of(calm(&self.windows(), self.least())),
        }
    }

    fn windows(&self) -> Vec<Window> {
        let window = |(run, pair): (&Timings, &[Option<f64>])| {
            Some(Window {
                run: milliseconds(run.total()),
                around: [pair[0]?, pair[1]?],
            })
        };
        self.timings
            .iter()
            .zip(self.yards.windows(2))
            .filter_map(window)
            .collect()
    }

    /// The quickest yardstick.
    fn least(&self) -> f64 {
        self.yards
            .iter()
            .copied()
            .flatten()
            .fold(f64::INFINITY, f64::min)
    }

    /// Whether as many runs as are the least were calm, or the yardstick can't be timed.
    fn is_calm(&self, runs: &Runs) -> bool {
        let windows = self.windows();
        windows.is_empty() || calm(&windows, self.least()).len() >= runs.min as usize
    }
}

/// What timing a row again finds.
#[derive(Clone, Debug)]
pub(crate) struct Again {
    /// Its runs.
    pub(crate) windows: Vec<Window>,
    /// The quickest run, milliseconds.
    pub(crate) least_ms: f64,
    /// The quickest yardstick, milliseconds a unit.
    pub(crate) yardstick: f64,
}

impl Default for Again {
    fn default() -> Self {
        Self {
            windows: Vec::new(),
            least_ms: f64::INFINITY,
            yardstick: f64::INFINITY,
        }
    }
}

impl Again {
    /// Takes in another round.
    pub(crate) fn add(&mut self, more: Self) {
        self.windows.extend(more.windows);
        self.least_ms = self.least_ms.min(more.least_ms);
        self.yardstick = self.yardstick.min(more.yardstick);
    }
}

/// Times rows of a scene once more, by their [stems](super::CompareRow::stem); none where a row can't be played any more.
pub(crate) fn again(
    input: &SceneInput,
    stems: &[String],
    options: &CompareOptions,
    runs: &Runs,
    backends: &mut Backends,
) -> Result<Vec<Option<Again>>, LabError> {
    let (camera, light) = camera_and_light(&input.scene)?;
    let (camera, geometry) = (options.camera(camera), Geometry::bake(&input.scene)?);
    let receivers = backends.receivers.receivers(&camera, &geometry)?;
    let view = View::new(&camera, light, &geometry).with_receivers(&receivers);
    let settings = settings_of(input, options)?;
    let mut out = Vec::new();
    for stem in stems {
        let mut found = None;
        let kind = stem.rsplit_once('.').map_or("", |(_, kind)| kind);
        let backend = backends.playing.iter_mut().find(|b| b.kind() == kind);
        let setting = settings.iter().find(|s| *stem == stem_of(&s.slug, kind));
        if let (Some(setting), Some(backend)) = (setting, backend)
            && let Ok(recipe) = setting.technique.recipe(&view)
        {
            let cost_ms = CostModel::of(kind).milliseconds(&Work::of(&view, &recipe));
            // Once before, since the first run compiles and uploads.
            backend.render(&view, &recipe)?;
            let timed = time(
                &mut **backend,
                (&view, Some(&receivers)),
                &recipe,
                (runs, cost_ms),
            )?;
            let (windows, least_ms, yardstick) =
                (timed.windows(), timed.times().total.min, timed.least());
            found = Some(Again {
                windows,
                least_ms,
                yardstick,
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

    fn timed(timings: Vec<Timings>, yards: &[Option<f64>]) -> RowTimes {
        Timed {
            timings,
            yards: yards.to_vec(),
        }
        .times()
    }

    /// A machine that gets slower, and a row that takes three yardsticks all the time.
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
        let found = timed(runs, &yards.map(Some));
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

    /// The third yardstick was held up, and so may have been the runs beside it.
    #[test]
    fn runs_beside_a_yardstick_that_was_held_up_do_not_count() {
        let found = timed(
            vec![run(6), run(60), run(600), run(6)],
            &[2.0, 2.0, 9.0, 2.0, 2.0].map(Some),
        );
        assert_eq!(found.ratio, Ranks::of(vec![3.0, 3.0]));
        assert_eq!(
            (found.total.max, found.total.runs),
            (600.0, 4),
            "plain times tell all"
        );
        assert_eq!(
            timed(vec![run(6)], &[2.0, 9.0].map(Some)).ratio,
            None,
            "never calm"
        );
    }

    #[test]
    fn without_a_yardstick_there_is_no_ratio() {
        let found = timed(vec![run(6)], &[None, None]);
        assert_eq!(
            (found.ratio, found.yardstick, found.total.median),
            (None, None, 6.0)
        );
        assert_eq!(
            timed(vec![run(6)], &[Some(0.0), Some(0.0)]).ratio,
            None,
            "a clock that didn't move"
        );
    }
}
