//! Comparing techniques, settings and backends on scenes against truth.

pub(crate) mod agreement;
mod backends;
mod choice;
mod commit;
mod control;
mod environment;
mod event;
mod expected;
mod horizon;
mod kept_truth;
mod nudges;
mod options;
mod planned;
mod preparation;
mod relative;
mod result;
mod scene;
mod seen;
mod slug;
mod timing;

pub use agreement::agree;
pub use backends::Backends;
pub(crate) use choice::thousands;
pub use choice::{Choice, SettingGroup, percent, setting_groups, times};
pub use event::{CompareEvent, OnEvent};
pub use expected::{Expected, pilot};
pub use kept_truth::KeptTruth;
pub use options::{CompareOptions, MIN_JUDGED_RUNS, NamedPreset, Runs, SceneInput, Section};
pub use preparation::Preparation;
pub use relative::{MIN_ERROR, Relative, SceneGroup, relative, scene_groups};
pub use result::{
    CompareRow, Comparison, Control, CostBasis, Environment, Measured, Ranks, RowOutcome, RowTimes,
    SCHEMA, SceneResult, TimingStats, TruthSummary,
};
pub use scene::SceneImages;
pub use timing::CALM;
pub(crate) use timing::{Again, again};
pub use umbrage_plan::motion::FrameMotion;

use crate::LabError;
use umbrage_core::Fit;
use umbrage_techniques::TechniquePreset;

/// In comparisons of at most this many scenes every row gets its pictures: whoever names a scene wants to see it.
pub(crate) const FEW_SCENES: usize = 3;

/// Receives a scene's figures and images as soon as they are there.
pub type Sink<'a> = dyn FnMut(&SceneResult, &SceneImages) -> Result<(), LabError> + 'a;

/// Compares the options' techniques on the scenes. Scenes are handed to `sink` one by one, since all their images together
/// may not fit into memory.
///
/// # Errors
/// Errors if input is not valid, a backend fails, or truth and a technique did not see the same triangles.
pub fn compare(
    inputs: &[SceneInput],
    options: &CompareOptions,
    backends: &mut Backends,
    sink: &mut Sink<'_>,
    on_event: &OnEvent<'_>,
) -> Result<Comparison, LabError> {
    // Before anything is played: an error must not come after minutes of comparing other scenes.
    for input in inputs {
        input.scene.validate()?;
    }
    // Unknown names are refused even where there is nothing to compare.
    options.settings(Fit::Tight)?;
    let mut parts = Vec::new();
    for input in inputs {
        parts.push(Part::of(input, options, backends.playing.len())?);
    }
    on_event(CompareEvent::Started {
        scenes: inputs.len(),
        work: parts.iter().map(|part| part.work).sum(),
    });
    let mut scenes = Vec::new();
    // The report may have more scenes than this run (from other shards), but never fewer: then it doesn't use them.
    let heat = inputs.len() <= FEW_SCENES;
    for (index, input) in inputs.iter().enumerate() {
        on_event(CompareEvent::Scene {
            name: &input.scene.name,
            index,
            rows: parts[index].rows,
            work: parts[index].work,
        });
        let settings = settings_of(input, options)?;
        let options = input.options_or(options);
        let (result, images) = scene::run(input, &settings, options, heat, backends, on_event)?;
        on_event(CompareEvent::SceneDone { result: &result });
        sink(&result, &images)?;
        scenes.push(result);
    }
    let environment = backends.environment(options);
    Ok(Comparison {
        schema: SCHEMA,
        environment,
        notices: backends.notices.clone(),
        scenes,
    })
}

/// A scene's part of a comparison.
struct Part {
    rows: usize,
    /// Pixels of its image times its rows.
    work: u64,
}

impl Part {
    fn of(input: &SceneInput, options: &CompareOptions, backends: usize) -> Result<Self, LabError> {
        let rows = settings_of(input, options)?.len() * backends;
        let (camera, _) = scene::camera_and_light(&input.scene)?;
        let size = input.options_or(options).camera(camera).size;
        let pixels = u64::from(size.x) * u64::from(size.y);
        Ok(Self {
            rows,
            work: pixels * rows as u64,
        })
    }
}

/// Returns all settings that are played on a scene.
fn settings_of(
    input: &SceneInput,
    options: &CompareOptions,
) -> Result<Vec<slug::NamedSetting>, LabError> {
    let options = input.options_or(options);
    let tight = options.settings(Fit::Tight)?;
    let all = with_fit(&tight, input.fit, options)?;
    Ok(slug::with_slugs(&options.presets, &all))
}

/// Returns the settings, then those under the scene's own fit. Settings without a map are the same under both and stay single.
fn with_fit(
    tight: &[TechniquePreset],
    fit: Option<Fit>,
    options: &CompareOptions,
) -> Result<Vec<TechniquePreset>, LabError> {
    let mut out = tight.to_vec();
    let Some(fit) = fit else {
        return Ok(out);
    };
    for setting in options.settings(fit)? {
        if !tight.contains(&setting) {
            out.push(setting);
        }
    }
    Ok(out)
}

#[cfg(test)]
mod tests;
#[cfg(test)]
mod throttled_tests;
