//! The wgpu backends that the tests share.

use crate::{adapter::HELP, driver_model::DriverModel};
use std::{
    ops::{Deref, DerefMut},
    sync::{Condvar, Mutex, MutexGuard, PoisonError},
};
use umbrage_core::BackendError;
use umbrage_wgpu::{AdapterChoice, Gpu, Software};

/// Tests of one program share this many devices: enough to keep two cores busy. Each device
/// compiles its own pipelines.
const DEVICES: usize = 2;

/// The shared backends.
struct Pool {
    /// Those that no test uses now.
    free: Vec<Gpu>,
    /// How many there are, [`DEVICES`] at most.
    opened: usize,
}

static POOL: Mutex<Pool> = Mutex::new(Pool {
    free: Vec::new(),
    opened: 0,
});
/// Notified when a test returns a backend.
static RETURNED: Condvar = Condvar::new();

fn lock_pool() -> MutexGuard<'static, Pool> {
    // A test that failed while it held the lock reports that itself; the others go on.
    POOL.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A backend that one test uses alone. Dropping this returns it.
#[derive(Debug)]
pub struct SharedGpu(Option<Gpu>);

/// Returns a shared backend that no other test uses. Waits until one is free.
///
/// A test drops its backend before it takes another one: two tests that each hold one and wait for
/// a second would wait forever.
///
/// # Panics
/// Panics if there is no adapter: a test that needs one fails, it is never skipped.
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

/// The adapter that `WGPU_ADAPTER_NAME` asks for, and no other; none if it asks for none.
pub fn named() -> Option<AdapterChoice> {
    Some(AdapterChoice::from_env()).filter(|choice| choice.name.is_some())
}

/// Software drivers come first, as for [`device`](crate::adapter::device): of them bit-equality can
/// be asked.
fn open() -> Result<Gpu, BackendError> {
    DriverModel::install();
    if let Some(named) = named() {
        return Gpu::new(&named);
    }
    let software = AdapterChoice {
        software: Software::Only,
        ..AdapterChoice::default()
    };
    Gpu::new(&software).or_else(|_| Gpu::new(&AdapterChoice::default()))
}
