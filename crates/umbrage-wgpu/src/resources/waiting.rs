//! Waiting for callbacks.

use wgpu::{Device, PollError, PollType};

/// Polls the device until `is_over` returns true, which callbacks of submitted commands cause.
///
/// One poll is not enough if several threads poll one device. Another thread may have taken a
/// callback, but not called it yet, when this thread's poll returns.
///
/// # Errors
/// Errors if polling fails.
pub(crate) fn poll_until(device: &Device, is_over: impl Fn() -> bool) -> Result<(), PollError> {
    loop {
        device.poll(PollType::wait_indefinitely())?;
        // Don't loop in browsers: callbacks run after the thread has returned to the event loop.
        if is_over() || cfg!(target_arch = "wasm32") {
            return Ok(());
        }
        std::thread::yield_now();
    }
}
