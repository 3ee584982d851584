//! Who plays the small steps of a truth job: a thread on the desktop, the frames themselves in browsers.

use super::truth::{TruthJob, TruthRequest, TruthSoFar};
use anyhow::Result;

/// What came of a job since it was asked last.
pub(crate) enum News {
    Truth(Box<TruthSoFar>),
    Failed(String),
}

#[cfg(not(target_arch = "wasm32"))]
pub(crate) use thread::Worker;

#[cfg(not(target_arch = "wasm32"))]
mod thread {
    use super::*;
    use std::{
        panic::{self, AssertUnwindSafe},
        sync::{
            Arc, Condvar, Mutex, MutexGuard, PoisonError,
            atomic::{AtomicBool, Ordering},
        },
    };

    #[derive(Default)]
    struct Shared {
        wanted: Mutex<Option<TruthRequest>>,
        news: Mutex<Option<News>>,
        asked: Condvar,
        /// Whether what was asked for is wanted no more.
        is_given_up: AtomicBool,
        ends: AtomicBool,
    }

    /// A thread that traces what was asked for last.
    pub(crate) struct Worker(Arc<Shared>);

    const PANICKED: &str =
        "Tracing truth hit an error of this program; please report it, with the scene.";

    fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
        mutex.lock().unwrap_or_else(PoisonError::into_inner)
    }

    impl Worker {
        /// `wake` is called, from the thread, when there is news.
        pub(crate) fn new(wake: impl Fn() + Send + 'static) -> Self {
            let shared = Arc::new(Shared::default());
            let of_thread = shared.clone();
            std::thread::spawn(move || {
                while let Some(request) = next(&of_thread) {
                    // A panic would leave the window without truth for good.
                    let played = AssertUnwindSafe(|| play(&of_thread, request, &wake));
                    let error = match panic::catch_unwind(played) {
                        Ok(Ok(())) => continue,
                        Ok(Err(error)) => format!("{error:#}"),
                        Err(_) => PANICKED.to_owned(),
                    };
                    *locked(&of_thread.news) = Some(News::Failed(error));
                    wake();
                }
            });
            Self(shared)
        }

        /// Asks for truth. What was asked before is given up.
        pub(crate) fn ask(&mut self, request: TruthRequest) {
            *locked(&self.0.news) = None;
            self.0.is_given_up.store(false, Ordering::Release);
            *locked(&self.0.wanted) = Some(request);
            self.0.asked.notify_one();
        }

        /// Gives up what was asked for: frames need the processor.
        pub(crate) fn give_up(&mut self) {
            *locked(&self.0.wanted) = None;
            self.0.is_given_up.store(true, Ordering::Release);
        }

        /// Returns what is new.
        pub(crate) fn news(&mut self) -> Option<News> {
            locked(&self.0.news).take()
        }
    }

    impl Drop for Worker {
        fn drop(&mut self) {
            self.0.ends.store(true, Ordering::Release);
            self.0.asked.notify_one();
        }
    }

    /// Waits for a request; none when the worker is gone.
    fn next(shared: &Shared) -> Option<TruthRequest> {
        let mut wanted = locked(&shared.wanted);
        loop {
            if shared.ends.load(Ordering::Acquire) {
                return None;
            }
            if let Some(request) = wanted.take() {
                return Some(request);
            }
            wanted = shared
                .asked
                .wait(wanted)
                .unwrap_or_else(PoisonError::into_inner);
        }
    }

    fn play(shared: &Shared, request: TruthRequest, wake: &impl Fn()) -> Result<()> {
        let mut job = TruthJob::new(request)?;
        while !job.is_done() {
            let is_given_up = locked(&shared.wanted).is_some()
                || shared.is_given_up.load(Ordering::Acquire)
                || shared.ends.load(Ordering::Acquire);
            if is_given_up {
                return Ok(());
            }
            if job.step()? {
                *locked(&shared.news) = Some(News::Truth(Box::new(job.so_far.clone())));
                wake();
            }
        }
        Ok(())
    }
}

#[cfg(target_arch = "wasm32")]
pub(crate) use frames::Worker;

#[cfg(target_arch = "wasm32")]
mod frames {
    use super::*;
    use web_time::{Duration, Instant};

    /// What a frame gives to truth: half of what the frame itself takes, but no less than the first and no more than the second.
    const SLICES: [Duration; 2] = [Duration::from_millis(10), Duration::from_millis(250)];

    /// Traces a little in each frame.
    pub(crate) struct Worker {
        job: Option<TruthJob>,
        wanted: Option<TruthRequest>,
        /// When the last slice ended.
        last: Option<Instant>,
        wake: Box<dyn Fn()>,
    }

    impl Worker {
        /// `wake` is called when there is more to do in the next frame.
        pub(crate) fn new(wake: impl Fn() + 'static) -> Self {
            Self {
                job: None,
                wanted: None,
                last: None,
                wake: Box::new(wake),
            }
        }

        /// Asks for truth. What was asked before is given up.
        pub(crate) fn ask(&mut self, request: TruthRequest) {
            self.job = None;
            self.wanted = Some(request);
            (self.wake)();
        }

        /// Gives up what was asked for.
        pub(crate) fn give_up(&mut self) {
            self.job = None;
            self.wanted = None;
        }

        /// Traces for a while, and returns what is new.
        pub(crate) fn news(&mut self) -> Option<News> {
            match self.play() {
                Ok(true) => self
                    .job
                    .as_ref()
                    .map(|job| News::Truth(Box::new(job.so_far.clone()))),
                Ok(false) => None,
                Err(error) => {
                    self.job = None;
                    Some(News::Failed(format!("{error:#}")))
                }
            }
        }

        fn play(&mut self) -> Result<bool> {
            if let Some(request) = self.wanted.take() {
                self.job = Some(TruthJob::new(request)?);
                (self.wake)();
                return Ok(false);
            }
            let begin = Instant::now();
            let Some(job) = &mut self.job else {
                return Ok(false);
            };
            let frame = self.last.map_or(Duration::ZERO, |last| begin - last);
            let slice = (frame / 2).clamp(SLICES[0], SLICES[1]);
            let mut is_new = false;
            while !job.is_done() && begin.elapsed() < slice && !is_new {
                is_new = job.step()?;
            }
            self.last = Some(Instant::now());
            if !job.is_done() {
                (self.wake)();
            }
            Ok(is_new)
        }
    }
}
