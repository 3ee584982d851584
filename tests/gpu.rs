//! The wgpu backends that the tests share.

use crate::{adapter::HELP, driver_model::DriverModel};
use std::{
    ops::{Deref, DerefMut},
    sync::{Condvar, Mutex, MutexGuard, PoisonError},
};
use umbrage_core::BackendError;
use umbrage_wgpu::{AdapterChoice, Gpu, Software};

/// Number of devices that the tests of one program share, enough to keep two cores busy. Each
/// device compiles its own pipelines.
const DEVICES: usize = 2;

/// The shared backends.
struct Pool {
    /// Backends that no test uses at present.
    free: Vec<Gpu>,
    /// Number of backends, at most [`DEVICES`].
    opened: usize,
}

static POOL: Mutex<Pool> = Mutex::new(Pool {
    free: Vec::new(),
    opened: 0,
});
/// Notified when a test returns a backend.
static RETURNED: Condvar = Condvar::new();

fn lock_pool() -> MutexGuard<'static, Pool> {
    // A test that failed while it held the lock reports that itself. Continue the other tests.
    POOL.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A backend for the exclusive use of one test. Dropping it returns the backend.
#[derive(Debug)]
pub struct SharedGpu(Option<Gpu>);

/// Returns a shared backend that no other test uses. Waits until one is free.
///
/// A test must drop its backend before it requests another one: two tests that each hold one and
/// wait for a second would wait forever.
///
/// # Panics
/// Panics if there is no adapter. A test that needs one fails and is never skipped.
pub fn gpu() -> SharedGpu {
    let mut pool = lock_pool();
    loop {
        if let Some(gpu) = pool.free.pop() {
            return SharedGpu(Some(gpu));
        }
        if pool.opened < DEVICES {
            let gpu = open().unwrap_or_else(|why| {
                panic!("no graphics adapter for the tests ({why}); {HELP}");
            });
            pool.opened += 1;
            return SharedGpu(Some(gpu));
        }
        pool = RETURNED.wait(pool).unwrap_or_else(PoisonError::into_inner);
    }
}

impl Deref for SharedGpu {
    type Target = Gpu;

    fn deref(&self) -> &Gpu {
        self.0.as_ref().expect("only dropping takes it")
    }
}

impl DerefMut for SharedGpu {
    fn deref_mut(&mut self) -> &mut Gpu {
        self.0.as_mut().expect("only dropping takes it")
    }
}

impl Drop for SharedGpu {
    fn drop(&mut self) {
        lock_pool().free.extend(self.0.take());
        RETURNED.notify_one();
    }
}

/// Returns the adapter of `WGPU_ADAPTER_NAME`. `None` if the variable is not set.
pub fn adapter_by_name() -> Option<AdapterChoice> {
    Some(AdapterChoice::from_env()).filter(|choice| choice.name.is_some())
}

/// Opens a backend, preferably on a software driver, as for [`device`](crate::adapter::device),
/// since those can be required to be bit-equal.
fn open() -> Result<Gpu, BackendError> {
    DriverModel::install();
    if let Some(named) = adapter_by_name() {
        return Gpu::new(&named);
    }
    let software = AdapterChoice {
        software: Software::Only,
        ..AdapterChoice::default()
    };
    Gpu::new(&software).or_else(|_| Gpu::new(&AdapterChoice::default()))
}
