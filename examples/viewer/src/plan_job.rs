//! The least for the view: the planner, beside the frames. On the desktop it has a thread, in browsers a worker.

use crate::measure::cost::prices;
use serde::{Deserialize, Serialize};
use umbrage::plan::catalogue::Catalogue;
use umbrage::{
    Camera, Geometry, Light,
    plan::{Bounds, Cancel, MeasureError, Plan, PlanOptions, Planner, Step, motion::FrameMotion},
};

/// What is asked for. Browsers send it to a worker as bytes.
#[derive(Serialize, Deserialize)]
pub(crate) struct PlanRequest {
    pub geometry: Geometry,
    /// Names of the techniques that the window's light sets refuse: a plan names what can be shown and copied.
    pub refused: Vec<String>,
    pub planned_for: PlannedFor,
}

/// What a plan is for: beside anything else it is stale.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct PlannedFor {
    pub camera: Camera,
    pub light: Light,
    /// The geometry's fingerprint.
    pub scene: u64,
    /// Greatest error, as a share of that of no shadow at all.
    pub error: f64,
    pub motion: FrameMotion,
}

/// What there is to show of a plan.
#[derive(Default)]
struct PlanState {
    /// What the planner is at, in words; none while it rests.
    at: Option<String>,
    outcome: Option<Result<Plan, String>>,
}

impl PlanState {
    fn begun() -> Self {
        Self {
            at: Some("begins".to_owned()),
            outcome: None,
        }
    }

    fn ended(outcome: Option<Result<Plan, String>>) -> Self {
        Self { at: None, outcome }
    }
}

#[cfg(not(target_arch = "wasm32"))]
pub(crate) use thread::PlanJob;

#[cfg(not(target_arch = "wasm32"))]
mod thread {
    use super::*;
    use std::{
        panic::{self, AssertUnwindSafe},
        sync::{Arc, Mutex, MutexGuard, PoisonError},
    };

    /// A plan that is being made, or was made.
    #[derive(Default)]
    pub(crate) struct PlanJob {
        state: Arc<Mutex<PlanState>>,
        cancel: Cancel,
    }

    fn locked(state: &Mutex<PlanState>) -> MutexGuard<'_, PlanState> {
        state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    impl PlanJob {
        /// Begins a plan; one that is being made is called off. `wake` is called when there is something new to show.
        pub(crate) fn start(
            &mut self,
            request: PlanRequest,
            wake: impl Fn() + Send + Sync + 'static,
        ) {
            self.cancel();
            *locked(&self.state) = PlanState::begun();
            let (state, cancel) = (self.state.clone(), self.cancel.clone());
            std::thread::spawn(move || {
                let on_step = |step: Step<'_>| {
                    locked(&state).at = Some(words(step));
                    wake();
                };
                // A panic would leave the window waiting for ever.
                let played = AssertUnwindSafe(|| planned(&request, &cancel, &on_step));
                let outcome = match panic::catch_unwind(played) {
                    Ok(Ok(plan)) => Some(Ok(plan)),
                    Ok(Err(MeasureError::Cancelled)) => None,
                    Ok(Err(error)) => Some(Err(error.to_string())),
                    Err(_) => Some(Err(PANICKED.to_owned())),
                };
                *locked(&state) = PlanState::ended(outcome);
                wake();
            });
        }

        /// Calls off what is being made: its outcome is dropped.
        pub(crate) fn cancel(&mut self) {
            self.cancel.cancel();
            *self = Self::default();
        }

        /// What the planner is at, in words; none while it rests.
        pub(crate) fn at(&self) -> Option<String> {
            locked(&self.state).at.clone()
        }

        /// Returns a plan that was finished since it was asked last.
        pub(crate) fn take(&mut self) -> Option<Result<Plan, String>> {
            locked(&self.state).outcome.take()
        }
    }

    impl Drop for PlanJob {
        /// A window that is closed, or opened again with another device, leaves no thread at work.
        fn drop(&mut self) {
            self.cancel.cancel();
        }
    }

    const PANICKED: &str = "No plan was made: the planner hit an error of this program; please report it, with the scene.";
}

#[cfg(target_arch = "wasm32")]
pub(crate) use page::PlanJob;

#[cfg(target_arch = "wasm32")]
mod page {
    use super::*;
    use crate::web::worker::{PageWorker, Told, WorkerJob};
    use js_sys::{Array, Uint8Array};
    use std::{cell::RefCell, rc::Rc};

    /// A plan that is being made, or was made.
    #[derive(Default)]
    pub(crate) struct PlanJob {
        state: Rc<RefCell<PlanState>>,
        worker: Option<PageWorker>,
    }

    impl PlanJob {
        /// Begins a plan; one that is being made is called off. `wake` is called when there is something new to show.
        pub(crate) fn start(&mut self, request: PlanRequest, wake: impl Fn() + Clone + 'static) {
            *self = Self::default();
            match self.begun(&request, wake) {
                Ok(worker) => self.worker = Some(worker),
                Err(error) => *self.state.borrow_mut() = PlanState::ended(Some(Err(error))),
            }
        }

        fn begun(
            &self,
            request: &PlanRequest,
            wake: impl Fn() + Clone + 'static,
        ) -> Result<PageWorker, String> {
            let bytes = postcard::to_allocvec(request).map_err(|error| error.to_string())?;
            *self.state.borrow_mut() = PlanState::begun();
            let state = self.state.clone();
            let parts = Array::of1(&Uint8Array::from(bytes.as_slice()));
            PageWorker::start(WorkerJob::Plan, &parts, move |told| {
                state.borrow_mut().take_in(told);
                wake();
            })
        }

        /// Calls off what is being made: the worker ends at once.
        pub(crate) fn cancel(&mut self) {
            *self = Self::default();
        }

        /// What the planner is at, in words; none while it rests.
        pub(crate) fn at(&self) -> Option<String> {
            self.state.borrow().at.clone()
        }

        /// Returns a plan that was finished since it was asked last.
        pub(crate) fn take(&mut self) -> Option<Result<Plan, String>> {
            let outcome = self.state.borrow_mut().outcome.take();
            if outcome.is_some() {
                self.worker = None;
            }
            outcome
        }
    }

    impl PlanState {
        fn take_in(&mut self, told: Told) {
            if self.outcome.is_some() {
                // A panic is told first by the program, and again by the worker's script.
                return;
            }
            *self = match told {
                Told::Step(step) => {
                    self.at = Some(step);
                    return;
                }
                Told::Done(plan) => {
                    Self::ended(Some(serde_json::from_slice(&plan).map_err(|error| {
                        format!("the worker's plan can't be read: {error}")
                    })))
                }
                Told::Failed(error) | Told::NeverBegan(error) => {
                    Self::ended(Some(Err(format!("No plan was made: {error}"))))
                }
            };
        }
    }
}

/// Makes the plan.
pub(crate) fn planned(
    request: &PlanRequest,
    cancel: &Cancel,
    on_step: &(dyn Fn(Step<'_>) + Sync),
) -> Result<Plan, MeasureError> {
    let is_playable = |name: &str| !request.refused.iter().any(|refused| refused == name);
    let options = PlanOptions {
        catalogue: Catalogue::built_in().retain(is_playable),
        motion: request.planned_for.motion,
        cancel: cancel.clone(),
        cost: prices(),
        ..PlanOptions::default()
    };
    let PlannedFor {
        camera,
        light,
        error,
        ..
    } = &request.planned_for;
    let mut planner = Planner::new(camera, light, &request.geometry, &options, on_step)?;
    planner.plan(&Bounds::relative_error(*error))
}

pub(crate) fn words(step: Step<'_>) -> String {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stage::Stage;

    /// As workers of a web page do it.
    #[test]
    fn a_request_and_its_plan_go_over_as_bytes() {
        let scene = umbrage::scenes::by_argument("cubes").expect("built in");
        let stage = Stage::of_scene("cubes", "cubes", scene).expect("it can be seen");
        let mut request = PlanRequest {
            geometry: stage.geometry.clone(),
            refused: Vec::new(),
            planned_for: PlannedFor {
                camera: stage.camera,
                light: stage.lights[0],
                scene: stage.geometry.fingerprint(),
                error: 0.25,
                motion: FrameMotion::AllMoves,
            },
        };
        let bytes = postcard::to_allocvec(&request).expect("written");
        let read: PlanRequest = postcard::from_bytes(&bytes).expect("read");
        assert_eq!(read.geometry.fingerprint(), request.geometry.fingerprint());
        assert_eq!(read.planned_for, request.planned_for);
        let plan =
            |request: &PlanRequest| planned(request, &Cancel::default(), &|_| {}).expect("a plan");
        let (here, there) = (plan(&request), plan(&read));
        assert_eq!(here.chosen, there.chosen);
        let chosen = here.chosen.as_ref().expect("a setting");
        // What is refused is not chosen again.
        let name = chosen.preset.technique().name();
        request.refused.push(name.to_owned());
        let other = plan(&request).chosen.expect("another setting");
        assert_ne!(other.preset.technique().name(), name);
        let json = serde_json::to_vec(&there).expect("written");
        let told: Plan = serde_json::from_slice(&json).expect("read");
        assert_eq!(
            told.chosen.map(|setting| setting.label()),
            here.chosen.map(|setting| setting.label())
        );
        let stage_bytes = postcard::to_allocvec(&stage).expect("written");
        let read: Stage = postcard::from_bytes(&stage_bytes).expect("read");
        assert_eq!(read.geometry.fingerprint(), stage.geometry.fingerprint());
        assert_eq!(
            (read.materials, read.textures),
            (stage.materials, stage.textures)
        );
    }
}
