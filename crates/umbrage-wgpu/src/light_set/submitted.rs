//! Whether what was recorded has been thrown away.

use std::sync::{
    Arc, Mutex, MutexGuard, PoisonError,
    atomic::{AtomicBool, Ordering},
};
use wgpu::{Buffer, BufferDescriptor, BufferUsages, CommandEncoder, Device, MapMode};

/// Watches the encoders that a set records into.
///
/// [`CommandEncoder::map_buffer_on_submit`] keeps a closure that is called once the encoder's commands are submitted, and dropped
/// without a call where they never are.
#[derive(Debug, Default)]
pub(crate) struct Submission {
    dropped: Arc<AtomicBool>,
    /// Buffers that wait for no submission.
    spare: Arc<Mutex<Vec<Buffer>>>,
}

/// Tells on being dropped, unless its commands were submitted.
#[derive(Debug)]
struct Watch {
    dropped: Arc<AtomicBool>,
    submitted: bool,
}

impl Drop for Watch {
    fn drop(&mut self) {
        if !self.submitted {
            self.dropped.store(true, Ordering::Release);
        }
    }
}

impl Submission {
    /// Returns whether an encoder was dropped without being submitted since this was last asked.
    pub(crate) fn was_dropped(&self) -> bool {
        self.dropped.swap(false, Ordering::Acquire)
    }

    /// Watches an encoder that draws layers.
    pub(crate) fn watch(&self, encoder: &CommandEncoder, device: &Device) {
        let spare = locked(&self.spare).pop();
        let buffer = spare.unwrap_or_else(|| marker(device));
        let mapped = buffer.clone();
        let spare = self.spare.clone();
        let mut watch = Watch {
            dropped: self.dropped.clone(),
            submitted: false,
        };
        encoder.map_buffer_on_submit(&buffer, MapMode::Read, .., move |result| {
            watch.submitted = true;
            drop(watch);
            if result.is_ok() {
                mapped.unmap();
                locked(&spare).push(mapped);
            }
        });
    }
}

/// Returns a buffer that nobody reads: only that it is mapped counts.
fn marker(device: &Device) -> Buffer {
    device.create_buffer(&BufferDescriptor {
        label: Some("umbrage submission"),
        size: 4,
        usage: BufferUsages::MAP_READ | BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

/// Locks the list. A thread that panicked while it held the lock has left a list of whole buffers, so poisoning is ignored.
fn locked(spare: &Mutex<Vec<Buffer>>) -> MutexGuard<'_, Vec<Buffer>> {
    spare.lock().unwrap_or_else(PoisonError::into_inner)
}
