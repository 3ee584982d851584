//! Work that takes longer than a frame may: a thread does it on the desktop. Browsers have no threads: there it is done at once.

use anyhow::Result;

#[cfg(not(target_arch = "wasm32"))]
pub(crate) use thread::Beside;

#[cfg(not(target_arch = "wasm32"))]
mod thread {
    use super::*;
    use std::{
        panic::{self, AssertUnwindSafe},
        sync::{Arc, Mutex, PoisonError},
    };

    /// What is being worked out. If it is dropped, its outcome is.
    pub(crate) struct Beside<T>(Arc<Mutex<Option<Result<T>>>>);

    impl<T: Send + 'static> Beside<T> {
        /// Begins. `wake` is called at the end.
        pub(crate) fn start(
            work: impl FnOnce() -> Result<T> + Send + 'static,
            wake: impl FnOnce() + Send + 'static,
        ) -> Self {
            let place = Arc::new(Mutex::new(None));
            let of_thread = place.clone();
            std::thread::spawn(move || {
                let outcome = panic::catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|_| {
                    Err(anyhow::anyhow!(
                        "this hit an error of the program; please report it, with the scene"
                    ))
                });
                *of_thread.lock().unwrap_or_else(PoisonError::into_inner) = Some(outcome);
                wake();
            });
            Self(place)
        }

        /// Returns the outcome once it is there.
        pub(crate) fn take(&mut self) -> Option<Result<T>> {
            self.0.lock().unwrap_or_else(PoisonError::into_inner).take()
        }
    }
}

#[cfg(target_arch = "wasm32")]
pub(crate) use at_once::Beside;

#[cfg(target_arch = "wasm32")]
mod at_once {
    use super::*;

    /// What was worked out.
    pub(crate) struct Beside<T>(Option<Result<T>>);

    impl<T> Beside<T> {
        /// Works it out, and calls `wake`.
        pub(crate) fn start(work: impl FnOnce() -> Result<T>, wake: impl FnOnce()) -> Self {
            let outcome = work();
            wake();
            Self(Some(outcome))
        }

        /// Returns the outcome, once.
        pub(crate) fn take(&mut self) -> Option<Result<T>> {
            self.0.take()
        }
    }
}

#[cfg(all(test, not(target_arch = "wasm32")))]
mod tests {
    use super::*;
    use std::sync::mpsc;

    fn outcome(work: impl FnOnce() -> Result<u32> + Send + 'static) -> Result<u32> {
        let (tell, told) = mpsc::channel();
        let mut job = Beside::start(work, move || tell.send(()).expect("heard"));
        told.recv().expect("told");
        let outcome = job.take().expect("there");
        assert!(job.take().is_none(), "twice");
        outcome
    }

    #[test]
    fn outcomes_come_and_panics_are_errors() {
        assert_eq!(outcome(|| Ok(7)).expect("an outcome"), 7);
        assert!(outcome(|| panic!("for the test")).is_err());
    }
}
