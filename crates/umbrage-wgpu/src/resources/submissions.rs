//! Detection of the submission of encoders.
//!
//! Queue writes are executed before all later submissions. The inputs of an encoder must therefore
//! not be written until it is submitted, and wgpu doesn't report submissions. But
//! [`CommandEncoder::map_buffer_on_submit`] maps a buffer as soon as the encoder's commands are
//! submitted. A buffer that no command uses is mapped at the device's next poll, however long the
//! commands take.

use std::sync::{
    Arc, Mutex, MutexGuard, PoisonError,
    atomic::{AtomicU32, Ordering},
};
use wgpu::{Buffer, BufferDescriptor, BufferUsages, CommandEncoder, Device, MapMode, PollType};

/// Watches encoders.
#[derive(Debug)]
pub(crate) struct Submissions {
    device: Device,
    /// Buffers that are not waiting for a submission.
    spare: Arc<Mutex<Vec<Buffer>>>,
    made: AtomicU32,
}

/// Reports whether any recorded commands wait to be submitted.
#[derive(Debug, Default)]
pub(crate) struct Pending(Arc<()>);

impl Pending {
    /// Returns whether nothing waits.
    pub(crate) fn is_over(&self) -> bool {
        // Each waiting encoder holds one more reference.
        Arc::strong_count(&self.0) == 1
    }
}

impl Submissions {
    pub(crate) fn of_device(device: &Device) -> Self {
        Self {
            device: device.clone(),
            spare: Arc::default(),
            made: AtomicU32::new(0),
        }
    }

    /// Returns the number of buffers created.
    #[cfg(feature = "testing")]
    pub(crate) fn made_count(&self) -> u32 {
        self.made.load(Ordering::Relaxed)
    }

    /// Keeps `pending` active until the encoder's commands are submitted or dropped.
    pub(crate) fn watch(&self, encoder: &CommandEncoder, pending: &Pending) {
        let waiting = pending.0.clone();
        self.call_on_submit(encoder, move || drop(waiting));
    }

    /// Calls `call` once the encoder's commands are submitted. If they never are, drops it without
    /// a call.
    pub(crate) fn call_on_submit(
        &self,
        encoder: &CommandEncoder,
        call: impl FnOnce() + Send + 'static,
    ) {
        let buffer = self.buffer();
        let spare = self.spare.clone();
        let mapped = buffer.clone();
        encoder.map_buffer_on_submit(&buffer, MapMode::Read, .., move |result| {
            call();
            if result.is_ok() {
                mapped.unmap();
                lock_spare(&spare).push(mapped);
            }
        });
    }

    /// Runs the callbacks of submitted encoders.
    pub(crate) fn poll(&self) {
        // Ignore the result: without waiting, the only error is a lost device, which all later
        // calls report, too.
        let _ = self.device.poll(PollType::Poll);
    }

    fn buffer(&self) -> Buffer {
        if let Some(buffer) = lock_spare(&self.spare).pop() {
            return buffer;
        }
        self.made.fetch_add(1, Ordering::Relaxed);
        // The buffer is never read: only its mapping matters.
        let usage = BufferUsages::MAP_READ | BufferUsages::COPY_DST;
        let desc = BufferDescriptor {
            label: Some("umbrage submission"),
            size: 4,
            usage,
            mapped_at_creation: false,
        };
        self.device.create_buffer(&desc)
    }
}

/// Locks the list. Ignores poisoning: a panic in another thread leaves a list of complete buffers.
fn lock_spare(spare: &Mutex<Vec<Buffer>>) -> MutexGuard<'_, Vec<Buffer>> {
    spare.lock().unwrap_or_else(PoisonError::into_inner)
}
