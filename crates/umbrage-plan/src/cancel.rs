//! Calling off a plan that nobody waits for any more.

use crate::error::MeasureError;
use std::sync::{
    Arc,
    atomic::{AtomicBool, Ordering},
};

/// Whether a plan is called off. Copies share the answer: one goes into
/// [`PlanOptions`](crate::PlanOptions), another stays with whoever may call it off, on any thread.
#[derive(Clone, Debug, Default)]
pub struct Cancel(Arc<AtomicBool>);

/// All are equal: options that ask for the same plan are the same, wanted or not.
impl PartialEq for Cancel {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Cancel {
    /// Calls it off: planning returns [`MeasureError::Cancelled`] before it tries another setting.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Returns whether it is called off.
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// Errors if it is called off.
    pub(crate) fn check(&self) -> Result<(), MeasureError> {
        if self.is_cancelled() {
            return Err(MeasureError::Cancelled);
        }
        Ok(())
    }
}
