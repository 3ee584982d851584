//! Times of the representative settings of each technique on full-size scenes.

use super::data::{CardTime, built_in};
use crate::{
    compare::{Backends, CompareOptions, OnEvent, Runs, SceneInput, compare},
    error::LabError,
};
use umbrage_plan::truth::TruthOptions;

/// Built-in scenes of 1280x720 pixels: under a sun and under point and area lights, with 170,000 to
/// 1.7 million triangles.
pub const FRAMES: [&str; 4] = ["street", "nave", "valley", "night-room"];

/// Times settings on a warm adapter. `backends` has the adapter only.
///
/// # Errors
/// Errors if a name is not that of a built-in scene, or a backend fails.
pub fn measure_times(
    frames: &[&str],
    backends: &mut Backends,
    on_event: &OnEvent<'_>,
) -> Result<Vec<CardTime>, LabError> {
    let mut inputs = Vec::new();
    for name in frames {
        inputs.push(SceneInput::new((built_in(name)?.build)(), ""));
    }
    let options = CompareOptions {
        // Judge one pixel in 256 with few rays: errors are not reported.
        truth: TruthOptions {
            samples: 1,
            probe_samples: 1,
            block_side: 16,
            ..TruthOptions::default()
        },
        runs: Some(Runs {
            min: 5,
            max: 15,
            budget_ms: 60,
            once_from_ms: 400,
        }),
        ..CompareOptions::content()
    };
    let comparison = compare(&inputs, &options, backends, &mut |_, _| Ok(()), on_event)?;
    let mut out = Vec::new();
    for scene in &comparison.scenes {
        let [width, height] = scene.size;
        for row in scene.rows.iter().filter(|row| row.same_as.is_none()) {
            let Some(times) = row.measured_figures().and_then(|m| m.times) else {
                continue;
            };
            out.push(CardTime {
                frame: format!("{} {width}x{height}", scene.name),
                technique: row.technique.clone(),
                settings: row.settings.clone(),
                milliseconds: times
                    .full_clock_factor
                    .map(|_| times.milliseconds(&times.total)),
                measured_milliseconds: times.total.median,
            });
        }
    }
    Ok(out)
}
