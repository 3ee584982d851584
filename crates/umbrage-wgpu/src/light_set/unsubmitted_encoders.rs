//! Detection of recorded commands that were never submitted.

use crate::resources::submissions::Submissions;
use std::sync::{
    Arc,
    atomic::{AtomicBool, Ordering},
};
use wgpu::{CommandEncoder, Device};

/// Detects whether an encoder that a set recorded into was dropped, or not submitted so far.
#[derive(Debug)]
pub(crate) struct UnsubmittedEncoders {
    submissions: Submissions,
    /// Each encoder that waits holds one more reference.
    dropped: Arc<AtomicBool>,
    /// True if an encoder waited at the last call of [`any`](Self::any).
    waited: bool,
}

/// Sets the flag when it is dropped, unless the encoder's commands were submitted.
#[derive(Debug)]
struct Watch {
    dropped: Arc<AtomicBool>,
    submitted: bool,
}

impl Watch {
    fn end(mut self) {
        self.submitted = true;
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        if !self.submitted {
            self.dropped.store(true, Ordering::Release);
        }
    }
}

impl UnsubmittedEncoders {
    pub(crate) fn of_device(device: &Device) -> Self {
        Self {
            submissions: Submissions::of_device(device),
            dropped: Arc::default(),
            waited: false,
        }
    }

    /// Returns whether an encoder was dropped since the last call, waits to be submitted, or waited
    /// then: it may have overwritten newer layers since.
    pub(crate) fn any(&mut self) -> bool {
        let waits = self.has_unsubmitted();
        let waited = std::mem::replace(&mut self.waited, waits);
        self.dropped.swap(false, Ordering::Acquire) | waits | waited
    }

    /// Returns whether an encoder waits to be submitted. Browsers report submissions too late to
    /// know.
    fn has_unsubmitted(&self) -> bool {
        let waits = || Arc::strong_count(&self.dropped) > 1;
        if cfg!(target_arch = "wasm32") || !waits() {
            return false;
        }
        self.submissions.poll();
        waits()
    }

    /// Watches an encoder.
    pub(crate) fn watch(&self, encoder: &CommandEncoder) {
        let watch = Watch {
            dropped: self.dropped.clone(),
            submitted: false,
        };
        self.submissions
            .call_on_submit(encoder, move || watch.end());
    }
}
