//! On the desktop, scenes are read on a thread of their own.

use super::{Loaded, Outcome, Request, Source, Then};
use crate::stage::Stage;
use anyhow::Result;
use std::{
    panic::{self, AssertUnwindSafe},
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
};
use web_time::Instant;

/// A scene that is being read.
struct Job {
    name: String,
    argument: String,
    then: Then,
    begun: Instant,
    is_given_up: AtomicBool,
    shared: Mutex<Shared>,
}

#[derive(Default)]
struct Shared {
    /// What is being done, in words.
    at: String,
    loaded: Option<Result<Loaded>>,
}

/// Reads one scene at a time; a newer one replaces it.
#[derive(Default)]
pub(crate) struct Loader {
    job: Option<Arc<Job>>,
}

fn locked(job: &Job) -> MutexGuard<'_, Shared> {
    job.shared.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Loader {
    /// Begins; what was being read is given up. `wake` is called at the end.
    pub(crate) fn start(&mut self, request: Request, wake: impl Fn() + Send + 'static) {
        self.cancel();
        let Source::Argument(argument) = &request.source;
        let job = Arc::new(Job {
            name: request.name.clone(),
            argument: argument.clone(),
            then: request.then.clone(),
            begun: Instant::now(),
            is_given_up: AtomicBool::new(false),
            shared: Mutex::default(),
        });
        self.job = Some(job.clone());
        std::thread::spawn(move || {
            // A panic would leave the window waiting for ever.
            let played = panic::catch_unwind(AssertUnwindSafe(|| load(request, &job)));
            let loaded = played.unwrap_or_else(|_| {
                Err(anyhow::anyhow!(
                    "reading it hit an error of this program; please report it, with the file"
                ))
            });
            locked(&job).loaded = loaded.transpose();
            wake();
        });
    }

    /// Gives up what is being read. The thread ends with the step that it is at.
    pub(crate) fn cancel(&mut self) {
        if let Some(job) = self.job.take() {
            job.is_given_up.store(true, Ordering::Release);
        }
    }

    /// What is being read, and what is done with it, in words; none while nothing is.
    pub(crate) fn at(&self) -> Option<String> {
        let job = self.job.as_ref()?;
        let seconds = job.begun.elapsed().as_secs();
        Some(format!("{}: {} ({seconds} s)", job.name, locked(job).at))
    }

    /// The scene or file that is being read.
    pub(crate) fn argument(&self) -> Option<String> {
        self.job.as_ref().map(|job| job.argument.clone())
    }

    /// What follows once it is there.
    pub(crate) fn then(&self) -> Option<&Then> {
        self.job.as_ref().map(|job| &job.then)
    }

    /// Returns what has been read since it was asked last.
    pub(crate) fn take(&mut self) -> Option<Outcome> {
        let job = self.job.as_ref()?;
        let loaded = locked(job).loaded.take()?;
        let (name, then) = (job.name.clone(), job.then.clone());
        self.job = None;
        Some(Outcome { name, then, loaded })
    }
}

impl Drop for Loader {
    fn drop(&mut self) {
        self.cancel();
    }
}

/// Reads and prepares a scene; none if it was given up.
fn load(request: Request, job: &Job) -> Result<Option<Loaded>> {
    let goes_on = |at: String| {
        locked(job).at = at;
        !job.is_given_up.load(Ordering::Acquire)
    };
    let Source::Argument(argument) = &request.source;
    match Stage::of_argument(argument, &goes_on)? {
        Some(stage) => request.prepared(stage, &goes_on),
        None => Ok(None),
    }
}
