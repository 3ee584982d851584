//! Cancellation of a plan that is no longer needed.

use crate::error::MeasureError;
use std::sync::{
    Arc,
    atomic::{AtomicBool, Ordering},
};

/// Cancellation flag of a plan. Clones share it: one goes into [`PlanOptions`](crate::PlanOptions),
/// another stays with the code that may cancel, on any thread.
#[derive(Clone, Debug, Default)]
pub struct Cancel(Arc<AtomicBool>);

/// All flags are equal: two options for the same plan are equal, cancelled or not.
impl PartialEq for Cancel {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Cancel {
    /// Cancels the plan: planning returns [`MeasureError::Cancelled`] before it evaluates another
    /// setting.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Returns whether the plan is cancelled.
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// Errors if the plan is cancelled.
    pub(crate) fn check(&self) -> Result<(), MeasureError> {
        if self.is_cancelled() {
            return Err(MeasureError::Cancelled);
        }
        Ok(())
    }
}
