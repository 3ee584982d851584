//! Deferred readback: data of the device is read some frames later, without waiting.

use std::sync::{
    Arc,
    atomic::{AtomicU8, Ordering},
};
use wgpu::{Buffer, BufferDescriptor, BufferUsages, CommandEncoder, Device, MapMode};

const IDLE: u8 = 0;
const WAITING: u8 = 1;
const READY: u8 = 2;

/// A buffer that is mapped once the commands that write it have finished.
#[derive(Debug)]
pub(crate) struct LateRead {
    read: Buffer,
    state: Arc<AtomicU8>,
}

/// Sets the state when dropped, because callbacks of dropped encoders are dropped without a call.
struct Outcome {
    state: Arc<AtomicU8>,
    becomes: u8,
}

impl Drop for Outcome {
    fn drop(&mut self) {
        self.state.store(self.becomes, Ordering::Release);
    }
}

impl LateRead {
    pub(crate) fn new(device: &Device, label: &str, bytes: u64) -> Self {
        Self {
            read: device.create_buffer(&BufferDescriptor {
                label: Some(label),
                size: bytes,
                usage: BufferUsages::MAP_READ | BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
            state: Arc::new(AtomicU8::new(IDLE)),
        }
    }

    /// Returns whether no readback is pending.
    pub(crate) fn is_idle(&self) -> bool {
        self.state.load(Ordering::Acquire) == IDLE
    }

    /// Records a copy of the first bytes of `from`. The readback must be idle.
    pub(crate) fn record(&self, encoder: &mut CommandEncoder, from: &Buffer) {
        let read = &self.read;
        encoder.copy_buffer_to_buffer(from, 0, read, 0, read.size());
        self.state.store(WAITING, Ordering::Release);
        let outcome = Outcome {
            state: self.state.clone(),
            becomes: IDLE,
        };
        encoder.map_buffer_on_submit(read, MapMode::Read, .., move |mapped| {
            // Move the whole struct, so that it is dropped with the closure in any case.
            let mut outcome = outcome;
            if mapped.is_ok() {
                outcome.becomes = READY;
            }
        });
    }

    /// Returns the result of `look` for the bytes, if they have arrived, and becomes idle.
    pub(crate) fn take<T>(&self, look: impl FnOnce(&[u8]) -> T) -> Option<T> {
        if self.state.load(Ordering::Acquire) != READY {
            return None;
        }
        let seen = self
            .read
            .get_mapped_range(..)
            .ok()
            .map(|bytes| look(&bytes));
        self.read.unmap();
        self.state.store(IDLE, Ordering::Release);
        seen
    }
}
