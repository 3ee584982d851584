//! How long the settings that stand for each technique take in frames of real size.

use super::data::{CardTime, built_in};
use crate::{
    compare::{Backends, CompareOptions, OnEvent, Runs, SceneInput, compare},
    error::LabError,
};
use umbrage_plan::truth::TruthOptions;

/// Built-in frames of 1280x720: under a sun and lamps, of 170,000 to 1.7 million triangles.
pub const FRAMES: [&str; 4] = ["street", "nave", "valley", "night-room"];

/// Times settings on an adapter that is warm. `backends` is the adapter alone.
///
/// # Errors
/// Errors if a frame is no built-in scene, or a backend fails.
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
        // Errors are not reported: a pixel in 256, and few rays.
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
            let Some(times) = row.measured().and_then(|m| m.times) else {
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
