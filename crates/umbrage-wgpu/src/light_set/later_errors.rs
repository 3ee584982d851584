//! Errors of the graphics API that are asked for without waiting.

use crate::device::error_scopes::{ClosedScopes, Scopes};
use umbrage_core::BackendError;

/// Scopes whose errors are not known yet.
#[derive(Debug, Default)]
pub(crate) struct LaterErrors(Vec<ClosedScopes>);

impl LaterErrors {
    /// Closes scopes, and remembers to ask for what they caught.
    pub(crate) fn wait_for(&mut self, scopes: Scopes) {
        self.0.push(scopes.close_later());
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
