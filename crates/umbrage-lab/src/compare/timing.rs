//! How long a row takes, in turn with a yardstick.

use super::{
    Backends, Options, Ranks, Runs, SceneInput, Spread, Times, Yardstick, result::stem_of, scene::camera_and_light,
    settings_of,
};
use crate::{LabError, cost::CostModel};
use std::time::{Duration, Instant};
use umbrage_core::{Backend, BackendError, Geometry, Receivers, Recipe, Shadows, Timings, View, Work};

/// Plays a recipe: once for the mask, which compiles, uploads and finds receivers, then until its time is known. The timed
/// runs are given the receivers of the first, so that finding and reading them back costs no time again.
pub(super) fn measure(
    backend: &mut dyn Backend,
    view: &View<'_>,
    recipe: &Recipe,
    (runs, cost_ms): (Option<&Runs>, f64),
) -> Result<(Shadows, Option<Times>), BackendError> {
    let first = backend.render(view, recipe)?;
    let Some(runs) = runs else { return Ok((first, None)) };
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
        let Some(yardstick) = &yardstick else { return Ok(None) };
        let timings = backend.render(&view, &yardstick.recipe)?.timings;
        Ok(timings.receive.map(|took| milliseconds(took) / yardstick.units))
    };
    // The first one compiles and uploads.
    measure(backend)?;
    let (mut spent, mut timings) = (Duration::ZERO, Vec::new());
    let mut yards = vec![measure(backend)?];
    while !runs.suffice(timings.len(), spent) {
        let start = Instant::now();
        timings.push(backend.render(&view, recipe)?.timings);
        spent += start.elapsed();
        yards.push(measure(backend)?);
    }
    Ok(Timed { timings, yards })
}

/// Runs of a row, and the yardstick's times before the first and after each, milliseconds a unit.
struct Timed {
    timings: Vec<Timings>,
    yards: Vec<Option<f64>>,
}

impl Timed {
    fn times(&self) -> Times {
        let stage = |of: fn(&Timings) -> Option<Duration>| {
            Spread::of(self.timings.iter().filter_map(of).map(milliseconds).collect())
        };
        Times {
            cast: stage(|t| t.cast),
            filter: stage(|t| t.filter),
            receive: stage(|t| t.receive),
            total: stage(|t| Some(t.total())).unwrap_or_default(),
            yardstick: Spread::of(self.yards.iter().copied().flatten().collect()),
            ratio: Ranks::of(self.ratios()),
        }
    }

    /// Each run over the mean of its two yardsticks.
    fn ratios(&self) -> Vec<f64> {
        let beside = |pair: &[Option<f64>]| Some((pair[0]? + pair[1]?) / 2.0).filter(|&mean| mean > 0.0);
        let ratio = |(run, pair): (&Timings, &[Option<f64>])| Some(milliseconds(run.total()) / beside(pair)?);
        self.timings.iter().zip(self.yards.windows(2)).filter_map(ratio).collect()
    }
}

/// A row's ratios to its yardstick, and its quickest run in milliseconds.
type TimedRow = (Vec<f64>, f64);

/// Times rows of a scene once more, by their [stems](super::Row::stem): each row's ratios, and its quickest run in milliseconds;
/// none where it can't be played any more.
pub(crate) fn again(
    input: &SceneInput,
    stems: &[String],
    options: &Options,
    runs: &Runs,
    backends: &mut Backends,
) -> Result<Vec<Option<TimedRow>>, LabError> {
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
            && let Ok(recipe) = setting.technique.plan(&view)
        {
            let cost_ms = CostModel::of(kind).milliseconds(&Work::of(&view, &recipe));
            // Once before, since the first run compiles and uploads.
            backend.render(&view, &recipe)?;
            let timed = time(&mut **backend, (&view, Some(&receivers)), &recipe, (runs, cost_ms))?;
            found = Some((timed.ratios(), timed.times().total.least));
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
        Timings { receive: Some(Duration::from_millis(ms)), ..Timings::default() }
    }

    fn timed(timings: Vec<Timings>, yards: &[Option<f64>]) -> Times {
        Timed { timings, yards: yards.to_vec() }.times()
    }

    /// A machine that gets slower and slower, and a row that takes three yardsticks all the time.
    #[test]
    fn what_slows_both_down_leaves_the_ratio() {
        let found = timed(vec![run(6), run(12), run(18)], &[1.0, 3.0, 5.0, 7.0].map(Some));
        assert_eq!(found.ratio, Ranks::of(vec![3.0; 3]));
        assert_eq!((found.total.least, found.total.greatest), (6.0, 18.0));
        assert_eq!(found.yardstick.map(|y| (y.median, y.runs)), Some((4.0, 4)));
    }

    #[test]
    fn without_a_yardstick_there_is_no_ratio() {
        let found = timed(vec![run(6)], &[None, None]);
        assert_eq!((found.ratio, found.yardstick, found.total.median), (None, None, 6.0));
        assert_eq!(timed(vec![run(6)], &[Some(0.0), Some(0.0)]).ratio, None, "a clock that didn't move");
    }
}
