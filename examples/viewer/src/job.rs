//! Work that takes longer than a frame. On the desktop it runs on a thread. In browsers, which have
//! none, it runs at once or on a worker of the page.

use anyhow::Result;
use std::{
    panic::{self, AssertUnwindSafe},
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};
use umbrage::plan::Cancel;

const PANICKED: &str = "a bug of this program stopped it; please report the bug with the scene";

/// State that the work shares with the window.
struct JobState<T> {
    step: String,
    outcome: Option<Result<T>>,
}

/// The half of a job that does the work.
pub(crate) struct JobProgress<T> {
    pub cancel: Cancel,
    state: Mutex<JobState<T>>,
    ctx: egui::Context,
}

impl<T> JobProgress<T> {
    fn state(&self) -> MutexGuard<'_, JobState<T>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Reports the next step. Returns false once the job is cancelled.
    pub(crate) fn step(&self, step: String) -> bool {
        self.state().step = step;
        self.ctx.request_repaint();
        !self.cancel.is_cancelled()
    }

    /// Publishes an outcome to the window. It replaces one that was not yet received.
    pub(crate) fn publish(&self, outcome: Result<T>) {
        self.state().outcome = Some(outcome);
        self.ctx.request_repaint();
    }
}

/// Work in progress. Dropping it cancels the work.
pub(crate) struct Job<T> {
    progress: Arc<JobProgress<T>>,
    /// The worker, which is terminated on drop.
    #[cfg(target_arch = "wasm32")]
    pub worker: Option<crate::web::worker::PageWorker>,
}

impl<T> Job<T> {
    /// Returns a job without work, and the half that the work needs.
    pub(crate) fn new(ctx: &egui::Context) -> (Self, Arc<JobProgress<T>>) {
        let progress = Arc::new(JobProgress {
            cancel: Cancel::default(),
            state: Mutex::new(JobState {
                step: "begins".to_owned(),
                outcome: None,
            }),
            ctx: ctx.clone(),
        });
        let job = Self {
            progress: progress.clone(),
            #[cfg(target_arch = "wasm32")]
            worker: None,
        };
        (job, progress)
    }

    /// Returns a description of the current step.
    pub(crate) fn step(&self) -> String {
        self.progress.state().step.clone()
    }

    /// Reports a step of the window itself.
    #[cfg(target_arch = "wasm32")]
    pub(crate) fn set_step(&self, step: String) {
        self.progress.step(step);
    }

    /// Returns an outcome that was published since the last call.
    pub(crate) fn take(&mut self) -> Option<Result<T>> {
        self.progress.state().outcome.take()
    }
}

impl<T: Send + 'static> Job<T> {
    /// Starts the work, which returns `None` if it has nothing more to publish.
    pub(crate) fn start(
        ctx: &egui::Context,
        work: impl FnOnce(&JobProgress<T>) -> Result<Option<T>> + Send + 'static,
    ) -> Self {
        let (job, progress) = Self::new(ctx);
        let run = move || {
            // Catch panics, which would leave the window waiting for ever.
            let outcome = panic::catch_unwind(AssertUnwindSafe(|| work(&progress)));
            let outcome = outcome.unwrap_or_else(|_| Err(anyhow::anyhow!(PANICKED)));
            if let Some(outcome) = outcome.transpose() {
                progress.publish(outcome);
            }
        };
        #[cfg(not(target_arch = "wasm32"))]
        std::thread::spawn(run);
        #[cfg(target_arch = "wasm32")]
        run();
        job
    }
}

impl<T> Drop for Job<T> {
    fn drop(&mut self) {
        self.progress.cancel.cancel();
    }
}

#[cfg(all(test, not(target_arch = "wasm32")))]
mod tests {
    use super::*;

    fn outcome(work: impl FnOnce() -> Result<u32> + Send + 'static) -> Result<u32> {
        let (sender, receiver) = std::sync::mpsc::channel();
        let context = egui::Context::default();
        context.set_request_repaint_callback(move |_| sender.send(()).unwrap_or(()));
        let mut job = Job::start(&context, move |_| work().map(Some));
        receiver.recv().expect("a repaint at the end");
        let outcome = job.take().expect("there");
        assert!(job.take().is_none(), "twice");
        outcome
    }

    #[test]
    fn outcomes_come_and_panics_are_errors() {
        assert_eq!(outcome(|| Ok(7)).expect("an outcome"), 7);
        assert!(outcome(|| panic!("for the test")).is_err());
    }

    #[test]
    fn dropped_jobs_are_cancelled() {
        let (job, progress) = Job::<u32>::new(&egui::Context::default());
        assert!(progress.step("works".to_owned()));
        drop(job);
        assert!(!progress.step("works".to_owned()));
    }
}
