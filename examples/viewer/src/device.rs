//! Requirements of the device, and values from its callbacks.

use std::sync::{Arc, Mutex, PoisonError};

/// A value from a callback for the program.
#[derive(Clone)]
pub(crate) struct Slot<T>(Arc<Mutex<Option<T>>>);

impl<T> Default for Slot<T> {
    fn default() -> Self {
        Self(Arc::default())
    }
}

impl<T> Slot<T> {
    /// Reports whether there is a value.
    pub(crate) fn is_full(&self) -> bool {
        let slot = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        slot.is_some()
    }

    /// Removes and returns the value, if there is one.
    pub(crate) fn take(&self) -> Option<T> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    /// Stores a value, unless there is one already.
    pub(crate) fn put(&self, value: T) {
        let mut slot = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        slot.get_or_insert(value);
    }
}

/// Returns the requirements for an adapter's device: its greatest sizes, for large scenes and
/// windows, and timestamps if available.
pub(crate) fn device_descriptor(adapter: &wgpu::Adapter) -> wgpu::DeviceDescriptor<'static> {
    let has = adapter.limits();
    let timed = wgpu::Features::TIMESTAMP_QUERY | wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS;
    wgpu::DeviceDescriptor {
        label: Some("umbrage viewer"),
        required_features: adapter.features() & timed,
        required_limits: wgpu::Limits {
            max_buffer_size: has.max_buffer_size,
            max_storage_buffer_binding_size: has.max_storage_buffer_binding_size,
            ..wgpu::Limits::default().using_resolution(has)
        },
        ..wgpu::DeviceDescriptor::default()
    }
}
