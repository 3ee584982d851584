//! From wgpu's error scopes to [`BackendError`].

use umbrage_core::BackendError;
use wgpu::{Device, Error, ErrorFilter, ErrorScopeGuard};

/// Catches all errors of a device on this thread until closed. wgpu would panic on them otherwise.
///
/// The fields are in the order in which scopes must be closed: the last one opened comes first.
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

    /// The worst error since the scopes were opened: without memory, validation errors are only what follows from it.
    pub(crate) fn close(self) -> Result<(), BackendError> {
        // On native devices, these futures are ready at once.
        let validation = pollster::block_on(self.validation.pop());
        let memory = pollster::block_on(self.memory.pop());
        let internal = pollster::block_on(self.internal.pop());
        memory
            .or(internal)
            .or(validation)
            .map_or(Ok(()), |e| Err(backend_error(&e)))
    }
}

/// Words wgpu's error in ours.
pub(crate) fn backend_error(error: &Error) -> BackendError {
    match error {
        Error::OutOfMemory { source } => BackendError::OutOfMemory(source.to_string()),
        Error::Validation { description, .. } | Error::Internal { description, .. } => {
            BackendError::Validation(description.clone())
        }
    }
}
