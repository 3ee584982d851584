//! Comparison of techniques, settings and backends on scenes against truth.
//!
//! Source files in the order of a row's way from the command line to the report:
//!
//! 1. `cli/compare.rs`: arguments, and the options made from them.
//! 2. This file: [`compare`], scene by scene.
//! 3. `settings.rs`: the technique settings of a scene.
//! 4. `scene.rs`: truth, then each setting.
//! 5. `row.rs`: the recipe, its execution on each backend, its error and its agreement.
//! 6. `timing.rs`: runs in turn with a yardstick.
//! 7. `result.rs`: the row as plain data.
//! 8. `report/mod.rs`: a scene's figures and images on disk.
//! 9. `report/assemble.rs`: `results.json`, charts and the page of all scenes.
//! 10. `report/table.rs`: the row's line in `rows.csv`. `report/page_rows.rs` is its counterpart
//!     for the page.
//!
//! Other files: `kept_truth` (truth of earlier runs), `seen` (pixels visible to a backend),
//! `agreement` and `nudges` (rounding), `control` and `horizon` (negative controls), `map_uses`,
//! `expected` (cost of a comparison), `relative` and `choice` (settings over many scenes).

pub(crate) mod agreement;
mod backends;
mod choice;
mod commit;
mod control;
mod enclosed;
mod environment;
mod event;
mod expected;
mod horizon;
mod kept_truth;
mod map_uses;
mod nudges;
mod options;
mod relative;
mod result;
mod row;
mod scene;
mod seen;
mod settings;
mod timing;

pub use agreement::agree;
pub use backends::Backends;
pub(crate) use choice::thousands;
pub use choice::{Choice, SettingGroup, percent, setting_groups, times};
pub use event::{CompareEvent, OnEvent};
pub use expected::{Expected, pilot};
pub use kept_truth::KeptTruth;
pub use options::{CompareOptions, MIN_JUDGED_RUNS, NamedPreset, Runs, SceneInput, Section};
pub use relative::{MIN_ERROR, Relative, SceneGroup, relative, scene_groups};
pub use result::{
    CompareRow, Comparison, Control, CostBasis, Environment, Measured, Preparation, Ranks,
    RowOutcome, RowTimes, SCHEMA, SceneResult, TimingStats, TruthSummary,
};
pub use row::RowImages;
pub use scene::SceneImages;
pub use timing::CALM;
pub(crate) use timing::{Again, time_rows_again};
pub use umbrage_plan::motion::FrameMotion;

use crate::error::LabError;
use settings::settings_of;
use umbrage_core::Fit;

/// Maximum number of scenes for which every row gets its images.
pub(crate) const FEW_SCENES: usize = 3;

/// Callback that receives a scene's figures and images when they are complete.
pub type Sink<'a> = dyn FnMut(&SceneResult, &SceneImages) -> Result<(), LabError> + 'a;

/// Compares the techniques of the options on the scenes.
///
/// Passes scenes to `sink` one by one, since the images of all scenes may exceed the memory.
///
/// # Errors
/// Errors if input is invalid, a backend fails, or truth and a technique see different triangles.
pub fn compare(
    inputs: &[SceneInput],
    options: &CompareOptions,
    backends: &mut Backends,
    sink: &mut Sink<'_>,
    on_event: &OnEvent<'_>,
) -> Result<Comparison, LabError> {
    // Validate all scenes first: errors must not come after minutes of comparing other scenes.
    for input in inputs {
        input.scene.validate()?;
    }
    // Refuse unknown names even if there is nothing to compare.
    options.settings(Fit::Tight)?;
    let mut parts = Vec::new();
    for input in inputs {
        let one = std::slice::from_ref(input);
        parts.push(Expected::new(one, options, backends.backends.len())?);
    }
    on_event(CompareEvent::Started {
        scenes: inputs.len(),
        work: parts.iter().map(Expected::work).sum(),
    });
    let mut scenes = Vec::new();
    // The final report may have more scenes than this run (from other shards), and then ignores
    // these.
    let heat = inputs.len() <= FEW_SCENES;
    for (index, input) in inputs.iter().enumerate() {
        on_event(CompareEvent::Scene {
            name: &input.scene.name,
            index,
            rows: parts[index].rows,
            work: parts[index].work(),
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

#[cfg(test)]
mod tests;
#[cfg(test)]
mod throttled_tests;
