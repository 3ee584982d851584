//! Times settings by the clock, in turn, so that what slows the machine down slows all of them.

use crate::{error::MeasureError, estimate::scene::PlanScene, motion::FrameMotion};
use umbrage_core::{Backend, BackendError, Geometry, Recipe, Timings, View};
use umbrage_techniques::TechniquePreset;
use web_time::{Duration, Instant};

/// Rounds in which every setting is played once, at most.
const MAX_ROUNDS: u32 = 24;
/// Rounds after which what is quick has been played often enough, if so many seconds have gone.
const ENOUGH: (u32, f64) = (5, 4.0);
/// Rounds after which what is slow has, if so many seconds have gone.
const ENOUGH_OF_SLOW: (u32, f64) = (2, 15.0);

/// Rounds after which what can no longer be the quickest by [`HOPELESS`] is played no more; before,
/// by [`HOPELESS_AT_FIRST`].
const ROUNDS_BEFORE_DROPPING: u32 = 2;
/// What took more than 1.5 times the least so far, in the best of [`ROUNDS_BEFORE_DROPPING`], can
/// no longer be the quickest: what else runs on a machine seldom holds up each of two runs by half.
const HOPELESS: Hopeless = Hopeless {
    factor: 1.5,
    more_ms: 0.0,
};
/// The same of first plays, in which drivers may compile for a part of a second.
const HOPELESS_AT_FIRST: Hopeless = Hopeless {
    factor: 4.0,
    more_ms: 1000.0,
};

/// Which times are too long for the quickest, beside the least time.
#[derive(Clone, Copy, Debug)]
struct Hopeless {
    /// More than this times the least,
    factor: f64,
    /// and this many milliseconds more.
    more_ms: f64,
}

/// Settings of which only the quickest is wanted, by their indices.
#[derive(Clone, Debug)]
pub(super) struct Race {
    pub(super) settings: Vec<usize>,
    /// The setting whose time is wanted, however slow it is.
    pub(super) watched: Option<usize>,
}

impl Race {
    /// Whether a setting may still be the quickest, or is watched. `best_ms` holds the least times
    /// so far, of which `hopeless` says what is too much.
    fn needs(&self, setting: usize, best_ms: &[f64], hopeless: Hopeless) -> bool {
        if self.watched == Some(setting) {
            return true;
        }
        let least_ms = self
            .settings
            .iter()
            .map(|&i| best_ms[i])
            .fold(f64::INFINITY, f64::min);
        let most_ms = hopeless.factor * least_ms + hopeless.more_ms;
        self.settings.contains(&setting) && best_ms[setting] <= most_ms
    }
}

/// A setting that is timed.
struct Runner {
    preset: TechniquePreset,
    recipe: Recipe,
    is_kept: bool,
    /// What is made once for a scene and again if all moves, milliseconds.
    scene_ms: f64,
    /// The time of the first play.
    first_ms: f64,
    /// The least of all rounds; infinite before the first.
    best_ms: f64,
}

impl Runner {
    /// Returns the time of a frame as far as it is known.
    fn known_ms(&self) -> f64 {
        if self.best_ms.is_finite() {
            self.best_ms
        } else {
            self.first_ms
        }
    }
}

/// Returns the time of a frame of each preset, milliseconds: the least of some rounds, since what
/// else runs on the machine only ever adds to it. None for a preset that is not supported or that
/// the backend can't hold. `is_kept` says of each whether what it draws is kept from frame to
/// frame. With `races`, what no race needs any more is played in the first rounds alone, so that
/// its time is less exact; without any, all are played in all rounds.
///
/// # Errors
/// Errors if the backend fails.
pub(super) fn times(
    backend: &mut dyn Backend,
    scene: &PlanScene<'_>,
    motion: FrameMotion,
    presets: &[(TechniquePreset, bool)],
    races: &[Race],
) -> Result<Vec<Option<f64>>, MeasureError> {
    let view = scene.played_view();
    let mut runners: Vec<Option<Runner>> = Vec::new();
    for (preset, is_kept) in presets {
        runners.push(first_play(backend, scene, motion, preset, *is_kept)?);
    }
    let start = Instant::now();
    for round in 0..MAX_ROUNDS {
        let elapsed = start.elapsed().as_secs_f64();
        let is_enough = |(rounds, seconds)| round >= rounds && elapsed > seconds;
        if is_enough(ENOUGH) || is_enough(ENOUGH_OF_SLOW) {
            break;
        }
        let needed = needed(&runners, races, round);
        for (runner, is_needed) in runners.iter_mut().zip(needed) {
            let Some(runner) = runner.as_mut().filter(|_| is_needed) else {
                continue;
            };
            let recipe_ms = if runner.is_kept {
                0.0
            } else {
                time_of_recipe(scene, &runner.preset)
            };
            let timings = backend.render(&view, &runner.recipe)?.timings;
            let frame_ms = if runner.is_kept {
                lookup_ms(&timings)
            } else {
                recipe_ms + milliseconds(timings.total())
            };
            runner.best_ms = runner.best_ms.min(runner.scene_ms + frame_ms);
        }
    }
    Ok(runners
        .into_iter()
        .map(|runner| runner.map(|runner| runner.known_ms()))
        .collect())
}

/// Returns which settings are played in a round: all without races, else those that a race needs.
fn needed(runners: &[Option<Runner>], races: &[Race], round: u32) -> Vec<bool> {
    let hopeless = if round < ROUNDS_BEFORE_DROPPING {
        HOPELESS_AT_FIRST
    } else {
        HOPELESS
    };
    let known_ms: Vec<f64> = runners
        .iter()
        .map(|runner| runner.as_ref().map_or(f64::INFINITY, Runner::known_ms))
        .collect();
    let is_needed = |i| races.iter().any(|race| race.needs(i, &known_ms, hopeless));
    (0..runners.len())
        .map(|i| races.is_empty() || is_needed(i))
        .collect()
}

/// Makes a recipe and plays it once, which compiles and uploads; none if it can't be played.
fn first_play(
    backend: &mut dyn Backend,
    scene: &PlanScene<'_>,
    motion: FrameMotion,
    preset: &TechniquePreset,
    is_kept: bool,
) -> Result<Option<Runner>, MeasureError> {
    let Ok(recipe) = scene.recipe(preset) else {
        return Ok(None);
    };
    // What a recipe makes on first use is timed apart.
    recipe.make_tables();
    let timings = match backend.render(&scene.played_view(), &recipe) {
        Ok(shadows) => shadows.timings,
        Err(BackendError::Invalid(_)) => return Ok(None),
        Err(e) => return Err(e.into()),
    };
    let frame_ms = if is_kept {
        lookup_ms(&timings)
    } else {
        milliseconds(timings.total())
    };
    let scene_ms = if motion == FrameMotion::AllMoves {
        time_of_scene(scene, preset)
    } else {
        0.0
    };
    Ok(Some(Runner {
        preset: preset.clone(),
        recipe,
        is_kept,
        scene_ms,
        first_ms: scene_ms + frame_ms,
        best_ms: f64::INFINITY,
    }))
}

/// Returns how long a preset takes to make its recipe, milliseconds; without a memory of fits,
/// which no program has across frames.
fn time_of_recipe(scene: &PlanScene<'_>, preset: &TechniquePreset) -> f64 {
    let view = View {
        fits: None,
        ..scene.view()
    };
    let start = Instant::now();
    let recipe = preset.technique().recipe(&view);
    let made = recipe.inspect(Recipe::make_tables);
    let elapsed = start.elapsed();
    drop(made);
    milliseconds(elapsed)
}

/// Returns by how many milliseconds the first recipe for fresh triangles takes longer than a later
/// one: hierarchies, welded edges.
fn time_of_scene(scene: &PlanScene<'_>, preset: &TechniquePreset) -> f64 {
    let fresh: Geometry = scene.geometry.without_hierarchies();
    let unfitted = View {
        fits: None,
        ..scene.view()
    };
    let view = View {
        geometry: unfitted.geometry.map(|_| &fresh),
        ..unfitted
    };
    let mut times = [0.0; 2];
    for time in &mut times {
        let start = Instant::now();
        let recipe = preset.technique().recipe(&view);
        let made = recipe.inspect(Recipe::make_tables);
        *time = milliseconds(start.elapsed());
        drop(made);
    }
    (times[0] - times[1]).max(0.0)
}

/// Returns the time of the lookup; of all stages where the backend can't time it alone.
fn lookup_ms(timings: &Timings) -> f64 {
    milliseconds(timings.receive.unwrap_or_else(|| timings.total()))
}

fn milliseconds(duration: Duration) -> f64 {
    duration.as_secs_f64() * 1e3
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::weighting::Weighting;
    use glam::UVec2;
    use umbrage_core::Geometry;
    use umbrage_cpu::Cpu;
    use umbrage_techniques::{Hard, MapTechnique, Traced, Unshadowed};

    #[test]
    fn what_is_kept_is_not_timed_and_all_that_moves_is() {
        let scene = umbrage_scenes::by_argument("cubes").expect("built in");
        let camera = scene.cameras[0].resized(UVec2::new(64, 48));
        let geometry = Geometry::bake(&scene).expect("valid");
        let planned =
            PlanScene::new(&camera, &scene.lights[0], &geometry, Weighting::Even).expect("valid");
        let hard = TechniquePreset::from(MapTechnique::<Hard>::default());
        let presets = [
            (Unshadowed::default().into(), true),
            (hard.clone(), true),
            (hard, false),
            (Traced::default().into(), false),
        ];
        let timed = |motion| {
            times(&mut Cpu::new(), &planned, motion, &presets, &[])
                .expect("plays")
                .into_iter()
                .map(|ms| ms.expect("supported"))
                .collect::<Vec<_>>()
        };
        let moving = timed(FrameMotion::CameraMoves);
        assert!(
            moving[1] < moving[2],
            "a map of 1024 is not free: {moving:?}"
        );
        assert!(moving.iter().all(|ms| ms.is_finite() && *ms > 0.0));
    }

    #[test]
    fn what_cannot_be_the_quickest_is_dropped_but_not_what_is_watched() {
        let race = Race {
            settings: vec![0, 1, 2],
            watched: Some(3),
        };
        let best_ms = [10.0, 14.9, 15.1, 400.0, 1.0];
        let needed: Vec<bool> = (0..5).map(|i| race.needs(i, &best_ms, HOPELESS)).collect();
        // The last takes no part in this race, quick as it is.
        assert_eq!(needed, [true, true, false, true, false]);
        let first_ms = [10.0, 1_039.0, 1_041.0, 9_000.0, 1.0];
        let needed: Vec<bool> = (0..5)
            .map(|i| race.needs(i, &first_ms, HOPELESS_AT_FIRST))
            .collect();
        assert_eq!(needed, [true, true, false, true, false]);
    }
}
