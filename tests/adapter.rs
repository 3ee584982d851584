//! The graphics device that the tests run on.

use crate::driver_model::DriverModel;
use std::sync::LazyLock;

/// What to do where there is none.
pub const HELP: &str =
    "on Debian or Ubuntu, `cargo xtask test --install-driver` installs a software one";

/// A device, and the name of its adapter.
#[derive(Debug)]
pub struct TestDevice {
    /// For messages.
    pub adapter: String,
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
}

/// The one device that all tests share.
///
/// # Panics
/// Panics if there is no adapter: a test that needs one fails, it is never skipped.
pub fn device() -> &'static TestDevice {
    static DEVICE: LazyLock<TestDevice> =
        LazyLock::new(|| open().unwrap_or_else(|why| panic!("{why}; {HELP}")));
    &DEVICE
}

/// Opens a device on the adapter that suits the tests best, or on the one that `WGPU_ADAPTER_NAME`
/// asks for. OpenGL does not count: see `umbrage_wgpu::AdapterChoice`.
///
/// # Errors
/// Errors if there is none, or it doesn't open; in words.
pub fn open() -> Result<TestDevice, String> {
    open_with(&wgpu::DeviceDescriptor::default())
}

/// Opens a device with these features and limits on the same adapter.
///
/// # Errors
/// Errors if there is none, or it doesn't open; in words.
pub fn open_with(desc: &wgpu::DeviceDescriptor<'_>) -> Result<TestDevice, String> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let mut adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY));
    adapters.sort_by_key(|a| preference(&a.get_info()));
    let name = crate::gpu::named()
        .and_then(|choice| choice.name)
        .unwrap_or_default();
    let fits = |a: &&wgpu::Adapter| {
        a.get_info()
            .name
            .to_lowercase()
            .contains(&name.to_lowercase())
    };
    let adapter = adapters
        .iter()
        .find(fits)
        .ok_or("no graphics adapter found")?;
    let info = adapter.get_info();
    let name = format!("{} ({:?}, {})", info.name, info.backend, info.driver_info);
    let desc = wgpu::DeviceDescriptor {
        required_features: desc.required_features
            | DriverModel::install().map_or(wgpu::Features::empty(), DriverModel::features),
        ..desc.clone()
    };
    let opened = pollster::block_on(adapter.request_device(&desc));
    let (device, queue) =
        opened.map_err(|e| format!("the graphics adapter {name} gives no device: {e}"))?;
    Ok(TestDevice {
        adapter: name,
        device,
        queue,
    })
}

/// Software adapters come first: they neither contract nor reorder, so that twins can be asked to
/// be bit-equal.
fn preference(info: &wgpu::AdapterInfo) -> (bool, bool) {
    (
        info.device_type != wgpu::DeviceType::Cpu,
        info.backend != wgpu::Backend::Vulkan,
    )
}
