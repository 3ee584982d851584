//! Whether what was recorded has been submitted.
//!
//! Writes to the queue run before all that is submitted after them. So what an encoder reads must
//! not be written while the encoder waits to be submitted, and wgpu doesn't report when that
//! happens. But [`CommandEncoder::map_buffer_on_submit`] maps a buffer as soon as the encoder's
//! commands are submitted, and a buffer that no command uses is mapped at the device's next poll,
//! however long the commands take.

use std::sync::{
    Arc, Mutex, MutexGuard, PoisonError,
    atomic::{AtomicU32, Ordering},
};
use wgpu::{Buffer, BufferDescriptor, BufferUsages, CommandEncoder, Device, MapMode, PollType};

/// Watches encoders.
#[derive(Debug)]
pub(crate) struct Submissions {
    device: Device,
    /// Buffers that wait for no submission.
    spare: Arc<Mutex<Vec<Buffer>>>,
    made: AtomicU32,
}

/// Whether anything that was recorded waits to be submitted.
#[derive(Debug, Default)]
pub(crate) struct Pending(Arc<()>);

impl Pending {
    /// Whether nothing waits.
    pub(crate) fn is_over(&self) -> bool {
        // Each encoder that waits holds one more.
        Arc::strong_count(&self.0) == 1
    }
}

impl Submissions {
    pub(crate) fn of(device: &Device) -> Self {
        Self {
            device: device.clone(),
            spare: Arc::default(),
            made: AtomicU32::new(0),
        }
    }

    pub(crate) fn device(&self) -> &Device {
        &self.device
    }

    /// Buffers made.
    #[cfg(feature = "testing")]
    pub(crate) fn made(&self) -> u32 {
        self.made.load(Ordering::Relaxed)
    }

    /// Keeps `pending` from being over before the encoder's commands are submitted or thrown away.
    pub(crate) fn watch(&self, encoder: &CommandEncoder, pending: &Pending) {
        let waiting = pending.0.clone();
        self.call_on_submit(encoder, move || drop(waiting));
    }

    /// Lets `call` be called once the encoder's commands are submitted. Where they never are it is
    /// dropped without a call.
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
                locked(&spare).push(mapped);
            }
        });
    }

    /// Runs the callbacks of encoders that have been submitted.
    pub(crate) fn poll(&self) {
        // Without waiting, the one error is that of a lost device, which all that follows meets as
        // well.
        let _ = self.device.poll(PollType::Poll);
    }

    fn buffer(&self) -> Buffer {
        if let Some(buffer) = locked(&self.spare).pop() {
            return buffer;
        }
        self.made.fetch_add(1, Ordering::Relaxed);
        // It is never read: only that it is mapped counts.
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

/// Locks the list. A thread that panicked while it held the lock has left a list of whole buffers,
/// so poisoning is ignored.
fn locked(spare: &Mutex<Vec<Buffer>>) -> MutexGuard<'_, Vec<Buffer>> {
    spare.lock().unwrap_or_else(PoisonError::into_inner)
}
