//! Searches for the cheapest technique for the view. On the desktop it runs on a thread, in
//! browsers on a worker.

use crate::{
    job::Job,
    measure::{cost::prices, subject::Subject},
};
use anyhow::Result;
use serde::{Deserialize, Serialize};
use umbrage::plan::{
    Bounds, Cancel, MeasureError, Plan, PlanOptions, Planner, Step, catalogue::Catalogue,
    motion::FrameMotion,
};

/// Input of a plan. A plan of another input is stale.
#[derive(Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct PlanRequest {
    pub subject: Subject,
    /// Greatest error, as a fraction of the error without shadows.
    pub error: f64,
    pub motion: FrameMotion,
}

/// Starts a plan, excluding techniques that light sets refuse, so that its result can be shown and
/// copied.
#[cfg(not(target_arch = "wasm32"))]
pub(crate) fn start(
    ctx: &egui::Context,
    request: &PlanRequest,
    refused: &[String],
) -> Result<Job<Plan>> {
    let (request, refused) = (request.clone(), refused.to_vec());
    Ok(Job::start(ctx, move |progress| {
        let on_step = |step: Step<'_>| {
            progress.step(step_label(step));
        };
        plan(&request, &refused, &progress.cancel, &on_step)
    }))
}

/// Starts a plan, excluding techniques that light sets refuse, so that its result can be shown and
/// copied.
#[cfg(target_arch = "wasm32")]
pub(crate) fn start(
    ctx: &egui::Context,
    request: &PlanRequest,
    refused: &[String],
) -> Result<Job<Plan>> {
    use crate::web::worker::{self, WorkerTask};
    use anyhow::Context as _;
    let bytes = postcard::to_allocvec(&(request, refused))?;
    let parts = js_sys::Array::of1(&js_sys::Uint8Array::from(bytes.as_slice()));
    let read =
        |bytes: &[u8]| serde_json::from_slice(bytes).context("the worker's plan can't be read");
    Ok(worker::start(ctx, WorkerTask::Plan, &parts, read, Err))
}

/// Makes a plan. Returns `None` if it was cancelled.
pub(crate) fn plan(
    request: &PlanRequest,
    refused: &[String],
    cancel: &Cancel,
    on_step: &(dyn Fn(Step<'_>) + Sync),
) -> Result<Option<Plan>> {
    let is_allowed = |name: &str| !refused.iter().any(|refused| refused == name);
    let options = PlanOptions {
        catalogue: Catalogue::built_in().retain(is_allowed),
        motion: request.motion,
        cancel: cancel.clone(),
        cost: prices(),
        ..PlanOptions::default()
    };
    let Subject {
        camera,
        light,
        geometry,
        ..
    } = &request.subject;
    let plan = Planner::new(camera, light, geometry, &options, on_step)
        .and_then(|mut planner| planner.plan(&Bounds::relative_error(request.error)));
    match plan {
        Err(MeasureError::Cancelled) => Ok(None),
        plan => Ok(Some(plan?)),
    }
}

pub(crate) fn step_label(step: Step<'_>) -> String {
    match step {
        Step::Looking => "searching for varying visibility".to_owned(),
        Step::Truth(done, total) => {
            let percent = 100.0 * done as f64 / total.max(1) as f64;
            format!("tracing the reference: {percent:.0} %")
        }
        Step::Trying(technique, tried) => {
            format!("evaluating {technique} ({tried} settings so far)")
        }
        Step::Timing(count) => format!("timing {count} finalists"),
        Step::Explaining => "writing the reasons".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stage::ViewerScene;

    /// Workers of a web page exchange bytes in this way.
    #[test]
    fn a_request_and_its_plan_go_over_as_bytes() {
        let scene = umbrage::scenes::by_argument("cubes").expect("built in");
        let stage = ViewerScene::of_scene("cubes", "cubes", scene).expect("it can be seen");
        let request = PlanRequest {
            subject: Subject {
                camera: stage.camera,
                light: stage.lights[0],
                geometry: stage.geometry.clone(),
                casters: stage.bounds,
            },
            error: 0.25,
            motion: FrameMotion::AllMoves,
        };
        let bytes = postcard::to_allocvec(&request).expect("written");
        let read: PlanRequest = postcard::from_bytes(&bytes).expect("read");
        assert!(read == request);
        let plan = |request: &PlanRequest, refused: &[String]| {
            plan(request, refused, &Cancel::default(), &|_| {})
                .expect("a plan")
                .expect("not cancelled")
        };
        let (here, there) = (plan(&request, &[]), plan(&read, &[]));
        assert_eq!(here.chosen, there.chosen);
        let chosen = here.chosen.as_ref().expect("a setting");
        // A refused technique is not chosen again.
        let name = chosen.preset.technique().name();
        let other = plan(&request, &[name.to_owned()]).chosen;
        let other = other.expect("another setting");
        assert_ne!(other.preset.technique().name(), name);
        let json = serde_json::to_vec(&there).expect("written");
        let read: Plan = serde_json::from_slice(&json).expect("read");
        assert_eq!(
            read.chosen.map(|setting| setting.label()),
            here.chosen.map(|setting| setting.label())
        );
        let stage_bytes = postcard::to_allocvec(&stage).expect("written");
        let read: ViewerScene = postcard::from_bytes(&stage_bytes).expect("read");
        assert_eq!(read.geometry.fingerprint(), stage.geometry.fingerprint());
        assert_eq!(
            (read.materials, read.textures),
            (stage.materials, stage.textures)
        );
    }
}
