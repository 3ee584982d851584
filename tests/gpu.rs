//! The wgpu backends that the tests share.

use crate::{adapter::HELP, driver_model::DriverModel};
use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError, TryLockError};
use umbrage_core::BackendError;
use umbrage_wgpu::{AdapterChoice, Gpu, Software};

/// Tests of one program share this many devices: enough to keep two cores busy. Each device compiles its own pipelines.
const DEVICES: usize = 2;

/// Returns a shared backend that no other test uses now, or waits until one is free.
///
/// # Panics
/// Panics if there is no adapter: a test that needs one fails, it is never skipped.
pub fn gpu() -> MutexGuard<'static, Gpu> {
    static GPUS: [LazyLock<Mutex<Gpu>>; DEVICES] = [const { LazyLock::new(open_or_panic) }; DEVICES];
    let free = GPUS.iter().find_map(|gpu| match gpu.try_lock() {
        Ok(gpu) => Some(gpu),
        // A test that failed while it held the lock reports that itself; the others go on.
        Err(TryLockError::Poisoned(poisoned)) => Some(poisoned.into_inner()),
        Err(TryLockError::WouldBlock) => None,
    });
    free.unwrap_or_else(|| GPUS[0].lock().unwrap_or_else(PoisonError::into_inner))
}

fn open_or_panic() -> Mutex<Gpu> {
    match open() {
        Ok(gpu) => Mutex::new(gpu),
        Err(why) => panic!("no graphics adapter for the tests ({why}); {HELP}"),
    }
}

/// The adapter that `WGPU_ADAPTER_NAME` asks for, and no other; none if it asks for none.
pub fn named() -> Option<AdapterChoice> {
    Some(AdapterChoice::from_env()).filter(|choice| choice.name.is_some())
}

/// Software drivers come first, as for [`device`](crate::adapter::device): of them bit-equality can be asked.
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
