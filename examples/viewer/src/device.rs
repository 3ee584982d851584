//! What the program asks of the device, and what the device reports behind its back.

use std::sync::{Arc, Mutex, PoisonError};

/// A place for what the device reports behind the program's back.
pub(crate) type Message = Arc<Mutex<Option<String>>>;

/// Whether a message was left.
pub(crate) fn is_left(place: &Message) -> bool {
    place
        .lock()
        .unwrap_or_else(PoisonError::into_inner)
        .is_some()
}

/// Takes a message, if there is one.
pub(crate) fn taken(place: &Message) -> Option<String> {
    place.lock().unwrap_or_else(PoisonError::into_inner).take()
}

/// Leaves a message, unless an earlier one is still there.
pub(crate) fn put(place: &Message, message: String) {
    place
        .lock()
        .unwrap_or_else(PoisonError::into_inner)
        .get_or_insert(message);
}

/// What the program asks of an adapter: all that it has in sizes, so that large scenes and windows have room.
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
