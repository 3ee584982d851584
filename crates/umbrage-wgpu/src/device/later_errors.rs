//! When errors of the graphics API are reported.

use crate::device::error_scopes::{ClosedScopes, Scopes};
use umbrage_core::BackendError;

/// When errors of the graphics API are reported: memory that runs out, a kernel's WGSL that the
/// compiler refuses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ApiErrors {
    /// By the call that made the error: it waits for the device's answer, which on all systems but
    /// browsers is there at once. In browsers that answer can't arrive while a call waits for it,
    /// and [`Later`](Self::Later) is meant.
    AtOnce,
    /// By `take_error`, in the same frame or one of the next.
    Later,
}

impl Default for ApiErrors {
    /// At once, but later in browsers.
    fn default() -> Self {
        if cfg!(target_arch = "wasm32") {
            Self::Later
        } else {
            Self::AtOnce
        }
    }
}

/// Scopes whose errors are not known yet.
#[derive(Debug, Default)]
pub(crate) struct LaterErrors(Vec<ClosedScopes>);

impl LaterErrors {
    /// Closes scopes. What they caught is returned at once, or remembered.
    pub(crate) fn close(&mut self, scopes: Scopes, when: ApiErrors) -> Result<(), BackendError> {
        if when == ApiErrors::AtOnce && cfg!(not(target_arch = "wasm32")) {
            return scopes.close();
        }
        self.0.push(scopes.close_later());
        Ok(())
    }

    /// Returns the first error that is known by now.
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
