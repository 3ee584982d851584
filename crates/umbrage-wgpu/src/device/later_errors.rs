//! Immediate or deferred reporting of errors of the graphics API.

use crate::device::error_scopes::{ClosedScopes, Scopes};
use umbrage_core::BackendError;

/// Time at which errors of the graphics API are reported, such as out-of-memory errors or invalid
/// WGSL of a kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ApiErrors {
    /// Reported by the call that caused the error. It waits for the device's response, which is
    /// immediate except in browsers. In browsers the response can't arrive during a call, and
    /// [`Later`](Self::Later) is used.
    AtOnce,
    /// Reported by `take_error`, in the same frame or a later one.
    Later,
}

impl Default for ApiErrors {
    /// Returns `AtOnce`, or `Later` in browsers.
    fn default() -> Self {
        if cfg!(target_arch = "wasm32") {
            Self::Later
        } else {
            Self::AtOnce
        }
    }
}

/// Closed scopes whose errors have not arrived yet.
#[derive(Debug, Default)]
pub(crate) struct LaterErrors(Vec<ClosedScopes>);

impl LaterErrors {
    /// Closes scopes. Returns their result immediately, or stores them.
    pub(crate) fn close(&mut self, scopes: Scopes, when: ApiErrors) -> Result<(), BackendError> {
        if when == ApiErrors::AtOnce && cfg!(not(target_arch = "wasm32")) {
            return scopes.close();
        }
        self.0.push(scopes.close_later());
        Ok(())
    }

    /// Returns the first error that has arrived.
    pub(crate) fn take(&mut self) -> Option<BackendError> {
        while let Some(first) = self.0.first_mut() {
            match first.poll() {
                // The scopes behind it were closed later.
                None => return None,
                Some(result) => {
                    self.0.remove(0);
                    if let Err(error) = result {
                        return Some(error);
                    }
                }
            }
        }
        None
    }
}
