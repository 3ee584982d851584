//! Device errors that arrive outside of calls.

use crate::device::error_scopes::backend_error;
use std::sync::{Arc, Mutex, PoisonError};
use umbrage_core::BackendError;
use wgpu::Device;

/// Errors of a device since its creation.
#[derive(Clone, Debug, Default)]
pub(crate) struct DeviceErrors(Arc<Mutex<State>>);

#[derive(Debug, Default)]
struct State {
    lost: Option<String>,
    uncaptured: Option<BackendError>,
}

impl DeviceErrors {
    /// Registers as listener of a device. Without a listener, wgpu panics on errors outside of
    /// scopes.
    pub(crate) fn of_device(device: &Device) -> Self {
        let errors = Self::default();
        let listener = errors.clone();
        device.set_device_lost_callback(move |reason, message| {
            listener.change(|s| s.lost = Some(format!("{reason:?}: {message}")));
        });
        let listener = errors.clone();
        device.on_uncaptured_error(Arc::new(move |error| {
            listener.change(|s| s.uncaptured = Some(backend_error(&error)));
        }));
        errors
    }

    /// Reports errors since the last call.
    ///
    /// # Errors
    /// Errors if the device is lost, or failed since the last call.
    pub(crate) fn check(&self) -> Result<(), BackendError> {
        self.change(|s| match (&s.lost, s.uncaptured.take()) {
            (Some(message), _) => Err(BackendError::DeviceLost(message.clone())),
            (None, Some(error)) => Err(error),
            (None, None) => Ok(()),
        })
    }

    fn change<R>(&self, f: impl FnOnce(&mut State) -> R) -> R {
        f(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}
