//! Comparing techniques, settings and backends on scenes against truth.

pub(crate) mod agreement;
mod backends;
mod control;
mod environment;
mod event;
mod expected;
mod horizon;
mod options;
mod relative;
mod result;
mod scene;
mod seen;
mod slug;
mod timing;
mod yardstick;

pub use agreement::agree;
pub use backends::Backends;
pub use event::{CompareEvent, OnEvent};
pub use expected::{Expected, pilot};
pub use options::{CompareOptions, Runs, SceneInput};
pub use relative::{MIN_ERROR, Relative, relative};
pub use result::{
    CompareRow, Comparison, Control, CostBasis, Environment, Measured, Ranks, RowOutcome, RowTimes,
    SCHEMA, SceneResult, TimingStats, TruthSummary,
};
pub use scene::SceneImages;
pub use timing::CALM;
pub(crate) use timing::{Again, again, calm};
pub use yardstick::{Yardstick, YardstickKernel, YardstickUniforms};

use crate::LabError;
use std::sync::Arc;
use umbrage_core::{Fit, ShadowTechnique};
use umbrage_techniques::ConfiguredTechniques;

/// Of so many scenes, every row gets its pictures: whoever names a scene wants to see it.
pub(crate) const FEW_SCENES: usize = 3;

/// Takes a scene's figures and images as soon as they are there.
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
    // What can't be compared must not be found out after minutes of comparing others.
    inputs.iter().try_for_each(|input| input.scene.validate())?;
    let tight = options.settings(Fit::Tight)?;
    on_event(CompareEvent::Started {
        scenes: inputs.len(),
        rows_per_scene: tight.len() * backends.playing.len(),
    });
    let mut scenes = Vec::new();
    // Not the report's own count, which may be greater: of fewer scenes it never writes more.
    let heat = inputs.len() <= FEW_SCENES;
    for (index, input) in inputs.iter().enumerate() {
        on_event(CompareEvent::Scene {
            name: &input.scene.name,
            index,
        });
        let settings = settings_of(input, options)?;
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

/// All that is played on a scene.
fn settings_of(
    input: &SceneInput,
    options: &CompareOptions,
) -> Result<Vec<slug::NamedSetting>, LabError> {
    Ok(slug::with_slugs(&with_fit(
        &options.settings(Fit::Tight)?,
        input.fit,
        options,
    )?))
}

/// The settings, and those with the scene's own fit; settings without a map are alike and stay single.
fn with_fit(
    tight: &[Arc<dyn ShadowTechnique>],
    fit: Option<Fit>,
    options: &CompareOptions,
) -> Result<ConfiguredTechniques, LabError> {
    let by_hand = fit.map_or(Ok(ConfiguredTechniques::new()), |fit| options.settings(fit))?;
    let label = |s: &Arc<dyn ShadowTechnique>| (s.name(), s.settings());
    let new = by_hand
        .into_iter()
        .filter(|s| tight.iter().all(|t| label(t) != label(s)));
    Ok(tight.iter().cloned().chain(new).collect())
}

#[cfg(test)]
mod tests;
