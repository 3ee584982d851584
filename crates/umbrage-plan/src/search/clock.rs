//! Times settings by the clock, in turn, so that what slows the machine down slows all of them.

use crate::{MeasureError, estimate::scene::PlanScene, motion::FrameMotion};
use std::time::{Duration, Instant};
use umbrage_core::{Backend, BackendError, Geometry, Recipe, Timings, View};
use umbrage_techniques::TechniquePreset;

/// Rounds in which every setting is played once, at most.
const MAX_ROUNDS: u32 = 24;
/// Rounds after which what is quick has been played often enough, if so many seconds have gone.
const ENOUGH: (u32, f64) = (5, 4.0);
/// Rounds after which what is slow has, if so many seconds have gone.
const ENOUGH_OF_SLOW: (u32, f64) = (2, 15.0);

/// A setting that is timed.
struct Runner {
    preset: TechniquePreset,
    recipe: Recipe,
    is_kept: bool,
    /// What is made once for a scene and again if all moves, milliseconds.
    scene_ms: f64,
    /// The least of all rounds.
    best_ms: f64,
}

/// Returns the time of a frame of each preset, milliseconds: the least of some rounds, since what else runs on the machine only ever
/// adds to it. None for a preset that is not supported or that the backend can't hold. `is_kept` says of each whether what it draws
/// is kept from frame to frame.
///
/// # Errors
/// Errors if the backend fails.
pub(super) fn times(
    backend: &mut dyn Backend,
    scene: &PlanScene<'_>,
    motion: FrameMotion,
    presets: &[(TechniquePreset, bool)],
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
        for runner in runners.iter_mut().flatten() {
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
        .map(|runner| runner.map(|runner| runner.best_ms))
        .collect())
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
    match backend.render(&scene.played_view(), &recipe) {
        Ok(_) => {}
        Err(BackendError::Invalid(_)) => return Ok(None),
        Err(e) => return Err(e.into()),
    }
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
        best_ms: f64::INFINITY,
    }))
}

/// Returns how long a preset takes to make its recipe, milliseconds; without a memory of fits, which no program has across frames.
fn time_of_recipe(scene: &PlanScene<'_>, preset: &TechniquePreset) -> f64 {
    let view = View {
        fits: None,
        ..scene.view()
    };
    let start = Instant::now();
    let recipe = preset.technique().recipe(&view);
    let elapsed = start.elapsed();
    drop(recipe);
    milliseconds(elapsed)
}

/// Returns by how many milliseconds the first recipe for fresh triangles takes longer than a later one: hierarchies, welded edges.
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
        *time = milliseconds(start.elapsed());
        drop(recipe);
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
    use umbrage_techniques::{Hard, Traced, Unshadowed};

    #[test]
    fn what_is_kept_is_not_timed_and_all_that_moves_is() {
        let scene = umbrage_scenes::by_argument("cubes").expect("built in");
        let camera = scene.cameras[0].resized(UVec2::new(64, 48));
        let geometry = Geometry::bake(&scene).expect("valid");
        let planned =
            PlanScene::new(&camera, &scene.lights[0], &geometry, Weighting::Even).expect("valid");
        let hard = TechniquePreset::from(Hard::default());
        let presets = [
            (Unshadowed::default().into(), true),
            (hard.clone(), true),
            (hard, false),
            (Traced::default().into(), false),
        ];
        let timed = |motion| {
            times(&mut Cpu::new(), &planned, motion, &presets)
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
}
