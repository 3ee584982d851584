//! The least for the view: the planner, on a thread of its own.

use crate::measure::cost::prices;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use umbrage::{
    Camera, Geometry, Light,
    plan::{Bounds, Cancel, MeasureError, Plan, PlanOptions, Planner, Step, motion::FrameMotion},
};

/// What is asked for.
pub(crate) struct PlanRequest {
    pub camera: Camera,
    pub geometry: Geometry,
    pub light: Light,
    /// Greatest error, as a share of that of no shadow at all.
    pub error: f64,
    pub motion: FrameMotion,
}

/// A plan that is being made, or was made.
#[derive(Default)]
pub(crate) struct PlanJob {
    shared: Arc<Mutex<Shared>>,
    cancel: Cancel,
}

#[derive(Default)]
struct Shared {
    /// What the planner is at, in words; none while it rests.
    at: Option<String>,
    outcome: Option<Result<Plan, String>>,
}

fn locked(shared: &Mutex<Shared>) -> MutexGuard<'_, Shared> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

impl PlanJob {
    /// Begins a plan; one that is being made is called off. `wake` is called when there is something new to show.
    pub(crate) fn start(&mut self, request: PlanRequest, wake: impl Fn() + Send + Sync + 'static) {
        self.cancel.cancel();
        *self = Self::default();
        locked(&self.shared).at = Some("begins".to_owned());
        let (shared, cancel) = (self.shared.clone(), self.cancel.clone());
        let play = move || {
            let outcome = planned(&request, &cancel, &|step| {
                locked(&shared).at = Some(words(step));
                wake();
            });
            let mut shared = locked(&shared);
            shared.at = None;
            shared.outcome = match outcome {
                Ok(plan) => Some(Ok(plan)),
                Err(MeasureError::Cancelled) => None,
                Err(error) => Some(Err(error.to_string())),
            };
            drop(shared);
            wake();
        };
        #[cfg(not(target_arch = "wasm32"))]
        std::thread::spawn(play);
        // Browsers have no threads here: the page stands still until the plan is made.
        #[cfg(target_arch = "wasm32")]
        play();
    }

    /// Calls off what is being made.
    pub(crate) fn cancel(&mut self) {
        self.cancel.cancel();
    }

    /// What the planner is at, in words; none while it rests.
    pub(crate) fn at(&self) -> Option<String> {
        locked(&self.shared).at.clone()
    }

    /// Returns a plan that was finished since it was asked last.
    pub(crate) fn take(&mut self) -> Option<Result<Plan, String>> {
        locked(&self.shared).outcome.take()
    }
}

fn planned(
    request: &PlanRequest,
    cancel: &Cancel,
    on_step: &(dyn Fn(Step<'_>) + Sync),
) -> Result<Plan, MeasureError> {
    let options = PlanOptions {
        motion: request.motion,
        cancel: cancel.clone(),
        cost: prices(),
        ..PlanOptions::default()
    };
    let (camera, light, geometry) = (&request.camera, &request.light, &request.geometry);
    let mut planner = Planner::new(camera, light, geometry, &options, on_step)?;
    planner.plan(&Bounds::relative_error(request.error))
}

fn words(step: Step<'_>) -> String {
    match step {
        Step::Looking => "looks for where visibility varies".to_owned(),
        Step::Truth(done, total) => {
            format!(
                "traces truth: {:.0} %",
                100.0 * done as f64 / total.max(1) as f64
            )
        }
        Step::Trying(technique, tried) => format!("tries {technique} ({tried} settings tried)"),
        Step::Timing(count) => format!("times {count} finalists"),
        Step::Explaining => "writes down why".to_owned(),
    }
}
