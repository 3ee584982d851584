//! Conversion of wgpu's error scopes to [`BackendError`].

use std::{
    pin::Pin,
    sync::{Mutex, PoisonError},
    task::{Context, Poll, Waker},
};
use umbrage_core::BackendError;
use wgpu::{Device, Error, ErrorFilter, ErrorScopeGuard};

/// Catches all errors of a device on this thread until closed. Otherwise, wgpu would panic on them.
///
/// Fields are in the order in which scopes must be closed: the last one opened comes first.
#[derive(Debug)]
pub(crate) struct Scopes {
    validation: ErrorScopeGuard,
    memory: ErrorScopeGuard,
    internal: ErrorScopeGuard,
}

impl Scopes {
    pub(crate) fn open(device: &Device) -> Self {
        let internal = device.push_error_scope(ErrorFilter::Internal);
        let memory = device.push_error_scope(ErrorFilter::OutOfMemory);
        let validation = device.push_error_scope(ErrorFilter::Validation);
        Self {
            validation,
            memory,
            internal,
        }
    }

    /// Closes the scopes without waiting for their errors.
    pub(crate) fn close_later(self) -> ClosedScopes {
        // Pop all scopes now, since scopes must nest.
        let validation = self.validation.pop();
        let memory = self.memory.pop();
        let internal = self.internal.pop();
        ClosedScopes {
            pending: Mutex::new(Box::pin(async move {
                let validation = validation.await;
                let memory = memory.await;
                let internal = internal.await;
                worst(validation, memory, internal)
            })),
        }
    }

    /// Closes the scopes and returns the worst error. If memory ran out, validation errors only
    /// follow from that.
    pub(crate) fn close(self) -> Result<(), BackendError> {
        // On native devices, these futures are ready immediately.
        let validation = pollster::block_on(self.validation.pop());
        let memory = pollster::block_on(self.memory.pop());
        let internal = pollster::block_on(self.internal.pop());
        worst(validation, memory, internal)
    }
}

/// Errors with the worst of three errors. If memory ran out, the others only follow from that.
fn worst(
    validation: Option<Error>,
    memory: Option<Error>,
    internal: Option<Error>,
) -> Result<(), BackendError> {
    memory
        .or(internal)
        .or(validation)
        .map_or(Ok(()), |e| Err(backend_error(&e)))
}

/// Result of closed scopes, once it is available. Browsers have one thread, to which the futures
/// are bound.
#[cfg(not(target_arch = "wasm32"))]
type CaughtErrors = dyn Future<Output = Result<(), BackendError>> + Send;
#[cfg(target_arch = "wasm32")]
type CaughtErrors = dyn Future<Output = Result<(), BackendError>>;

/// Closed scopes whose errors may not have arrived yet.
pub(crate) struct ClosedScopes {
    /// Behind a lock that never blocks, so that the struct is `Sync`.
    pending: Mutex<Pin<Box<CaughtErrors>>>,
}

impl std::fmt::Debug for ClosedScopes {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("ClosedScopes")
    }
}

impl ClosedScopes {
    /// Returns the scopes' result, or `None` while it is not available. Must not be called again
    /// after that.
    pub(crate) fn poll(&mut self) -> Option<Result<(), BackendError>> {
        let mut context = Context::from_waker(Waker::noop());
        let pending = self
            .pending
            .get_mut()
            .unwrap_or_else(PoisonError::into_inner);
        match pending.as_mut().poll(&mut context) {
            Poll::Ready(result) => Some(result),
            Poll::Pending => None,
        }
    }
}

/// Converts a wgpu error.
pub(crate) fn backend_error(error: &Error) -> BackendError {
    match error {
        Error::OutOfMemory { source } => BackendError::OutOfMemory(source.to_string()),
        Error::Validation { description, .. } | Error::Internal { description, .. } => {
            BackendError::Validation(description.clone())
        }
    }
}
