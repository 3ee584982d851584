//! Waits for callbacks.

use wgpu::{Device, PollError, PollType};

/// Polls the device until `is_over`, which callbacks of what was submitted bring about.
///
/// One poll is not enough: where several threads poll one device, another thread may have taken a
/// callback, and still be about to call it when this thread's poll returns.
///
/// # Errors
/// If polling fails.
pub(crate) fn poll_until(device: &Device, is_over: impl Fn() -> bool) -> Result<(), PollError> {
    loop {
        device.poll(PollType::wait_indefinitely())?;
        // The thread of a page can't wait: callbacks run after it has gone back to the browser.
        if is_over() || cfg!(target_arch = "wasm32") {
            return Ok(());
        }
        std::thread::yield_now();
    }
}
