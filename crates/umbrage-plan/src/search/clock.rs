//! Timing of settings by the clock, in turn, so that a slow machine slows all of them.

use crate::{error::MeasureError, estimate::scene::PlanScene, motion::FrameMotion};
use umbrage_core::{Backend, BackendError, Geometry, Recipe, Timings, View};
use umbrage_techniques::TechniquePreset;
use web_time::{Duration, Instant};

/// Greatest number of rounds in which every setting runs once.
const MAX_ROUNDS: u32 = 24;
/// Rounds and seconds after which fast settings have run often enough.
const ENOUGH: (u32, f64) = (5, 4.0);
/// Rounds and seconds after which slow settings have run often enough.
const ENOUGH_OF_SLOW: (u32, f64) = (2, 15.0);

/// Number of rounds after which [`HOPELESS`] decides which settings are dropped. Before it,
/// [`HOPELESS_AT_FIRST`] decides.
const ROUNDS_BEFORE_DROPPING: u32 = 2;
/// A setting that takes more than 1.5 times the least time in the best of
/// [`ROUNDS_BEFORE_DROPPING`] runs can't be the fastest. Other load seldom slows each of two runs
/// by half.
const HOPELESS: Hopeless = Hopeless {
    factor: 1.5,
    more_ms: 0.0,
};
/// Limit for first runs, in which drivers may compile for a fraction of a second.
const HOPELESS_AT_FIRST: Hopeless = Hopeless {
    factor: 4.0,
    more_ms: 1000.0,
};

/// Limit on times that can still be the fastest, relative to the least time.
#[derive(Clone, Copy, Debug)]
struct Hopeless {
    /// Factor of the least time.
    factor: f64,
    /// Milliseconds added to that.
    more_ms: f64,
}

/// Settings of which only the fastest is needed, by index.
#[derive(Clone, Debug)]
pub(super) struct Race {
    pub(super) settings: Vec<usize>,
    /// The setting whose time is needed, however slow it is.
    pub(super) watched: Option<usize>,
}

impl Race {
    /// Returns whether a setting may still be the fastest, or is watched. `best_ms` holds the least
    /// times so far.
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

/// Setting that is timed.
struct Runner {
    preset: TechniquePreset,
    recipe: Recipe,
    is_kept: bool,
    /// Milliseconds of work done once per scene, and again if everything moves.
    scene_ms: f64,
    /// Time of the first run.
    first_ms: f64,
    /// Least time of all rounds; infinite before the first.
    best_ms: f64,
}

impl Runner {
    /// Returns the best known time of a frame.
    fn known_ms(&self) -> f64 {
        if self.best_ms.is_finite() {
            self.best_ms
        } else {
            self.first_ms
        }
    }
}

/// Returns the time of a frame of each preset, milliseconds: the least of several rounds, since
/// other load on the machine only ever adds to it.
///
/// Returns `None` for a preset that is unsupported or that exceeds the backend's limits. The flag
/// of each preset reports whether its images are kept from frame to frame. With `races`, a setting
/// that no race needs runs in the first rounds only, so its time is less exact. Without races, all
/// settings run in all rounds.
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
    let view = scene.rendered_view();
    // Build each recipe and run it once.
    let mut runners: Vec<Option<Runner>> = Vec::new();
    for (preset, is_kept) in presets {
        runners.push(first_run(backend, scene, motion, preset, *is_kept)?);
    }
    let start = Instant::now();
    // Run all needed settings in turn, and keep the least time of each.
    for round in 0..MAX_ROUNDS {
        let elapsed = start.elapsed().as_secs_f64();
        let is_enough = |(rounds, seconds)| round >= rounds && elapsed > seconds;
        if is_enough(ENOUGH) || is_enough(ENOUGH_OF_SLOW) {
            break;
        }
        let needed = needed_runners(&runners, races, round);
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

/// Returns the settings that run in a round: all without races, otherwise those that a race needs.
fn needed_runners(runners: &[Option<Runner>], races: &[Race], round: u32) -> Vec<bool> {
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

/// Builds a recipe and runs it once, which compiles and uploads. Returns `None` if it can't be
/// executed.
fn first_run(
    backend: &mut dyn Backend,
    scene: &PlanScene<'_>,
    motion: FrameMotion,
    preset: &TechniquePreset,
    is_kept: bool,
) -> Result<Option<Runner>, MeasureError> {
    let Ok(recipe) = scene.recipe(preset) else {
        return Ok(None);
    };
    // Tables that a recipe builds on first use are timed separately.
    recipe.make_tables();
    let timings = match backend.render(&scene.rendered_view(), &recipe) {
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

/// Returns the time that a preset takes to build its recipe, milliseconds. Uses no fit cache, since
/// no program keeps one across frames.
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

/// Returns the extra time of the first recipe for new triangles over a later one, milliseconds:
/// hierarchies and welded edges.
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

/// Returns the time of the lookup, or of all stages if the backend can't time it separately.
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
        let camera = scene.cameras[0].with_size(UVec2::new(64, 48));
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
                .expect("valid")
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
        // The last setting is fast but not part of this race.
        assert_eq!(needed, [true, true, false, true, false]);
        let first_ms = [10.0, 1_039.0, 1_041.0, 9_000.0, 1.0];
        let needed: Vec<bool> = (0..5)
            .map(|i| race.needs(i, &first_ms, HOPELESS_AT_FIRST))
            .collect();
        assert_eq!(needed, [true, true, false, true, false]);
    }
}
