//! The wgpu backend that the tests share.

use crate::{adapter::HELP, driver_model::DriverModel};
use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};
use umbrage_core::BackendError;
use umbrage_wgpu::{AdapterChoice, Gpu, Software};

/// The shared backend; tests take turns.
///
/// # Panics
/// Panics if there is no adapter: a test that needs one fails, it is never skipped.
pub fn gpu() -> MutexGuard<'static, Gpu> {
    static GPU: LazyLock<Mutex<Gpu>> = LazyLock::new(|| match open() {
        Ok(gpu) => Mutex::new(gpu),
        Err(why) => panic!("no graphics adapter for the tests ({why}); {HELP}"),
    });
    // A test that failed while it held the lock says so itself; the others go on.
    GPU.lock().unwrap_or_else(PoisonError::into_inner)
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
