//! Runs one function on many inputs by several threads that share the backends.

use crate::compare::Backends;
use std::{
    num::NonZero,
    panic::resume_unwind,
    sync::{
        Mutex, MutexGuard, PoisonError,
        atomic::{AtomicUsize, Ordering},
    },
    thread,
};

/// Backends that several threads use in turn.
///
/// A thread of rayon's pool must never wait for them. The thread that holds them may itself wait
/// for the pool, since the CPU backend renders there. So [`map`] starts threads of its own.
pub(super) struct SharedBackends<'a>(Mutex<&'a mut Backends>);

impl<'a> SharedBackends<'a> {
    pub(super) fn new(backends: &'a mut Backends) -> Self {
        Self(Mutex::new(backends))
    }

    /// Waits until no other thread uses the backends.
    pub(super) fn lock(&self) -> MutexGuard<'_, &'a mut Backends> {
        // `guard::render` catches the panic of a rendering, so its backend is usable.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Returns `f` of each input, in the inputs' order. It runs as many threads as the machine has
/// cores, and each takes the next input when it is free.
pub(super) fn map<T: Sync, R: Send>(inputs: &[T], f: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let cores = thread::available_parallelism().map_or(1, NonZero::get);
    let next = AtomicUsize::new(0);
    let work = || {
        let mut done = Vec::new();
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(input) = inputs.get(index) else {
                return done;
            };
            done.push((index, f(input)));
        }
    };
    let mut done = thread::scope(|scope| {
        let start = |_| scope.spawn(work);
        let threads: Vec<_> = (0..cores.min(inputs.len())).map(start).collect();
        let mut done = Vec::new();
        for thread in threads {
            done.extend(thread.join().unwrap_or_else(|panic| resume_unwind(panic)));
        }
        done
    });
    done.sort_by_key(|(index, _)| *index);
    done.into_iter().map(|(_, result)| result).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn results_have_the_order_of_the_inputs() {
        // The first inputs take longest.
        let inputs: Vec<u64> = (0..40).collect();
        let doubled = map(&inputs, |&input| {
            thread::sleep(Duration::from_micros(200 * (40 - input)));
            2 * input
        });
        let expected: Vec<u64> = inputs.iter().map(|input| 2 * input).collect();
        assert_eq!(doubled, expected);
        assert!(map(&[], |&input: &u64| input).is_empty());
    }
}
