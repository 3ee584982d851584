//! Immediate or deferred reporting of errors of the graphics API.

use crate::device::error_scopes::{ClosedScopes, Scopes};
use std::collections::VecDeque;
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

/// Results of closed scopes that were not reported at once.
#[derive(Debug, Default)]
pub(crate) struct LaterErrors {
    /// Scopes whose results have not arrived yet, in the order in which they were closed.
    pending: VecDeque<ClosedScopes>,
    /// The first error that has arrived. Further ones usually follow from it and are dropped until
    /// it is taken.
    first: Option<BackendError>,
}

impl LaterErrors {
    /// Closes scopes. Returns their result immediately, or stores them.
    pub(crate) fn close(&mut self, scopes: Scopes, when: ApiErrors) -> Result<(), BackendError> {
        if when == ApiErrors::AtOnce && cfg!(not(target_arch = "wasm32")) {
            return scopes.close();
        }
        self.pending.push_back(scopes.close_later());
        // Most frames close scopes: their results must not pile up until they are taken.
        self.collect();
        Ok(())
    }

    /// Returns the first error that has arrived.
    pub(crate) fn take(&mut self) -> Option<BackendError> {
        self.collect();
        self.first.take()
    }

    /// Removes the scopes whose results have arrived.
    fn collect(&mut self) {
        while let Some(result) = self.pending.front_mut().and_then(ClosedScopes::poll) {
            self.pending.pop_front();
            if let Err(error) = result {
                self.first.get_or_insert(error);
            }
        }
    }
}
