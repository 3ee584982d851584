//! The graphics device that the tests run on.

use crate::driver_model::DriverModel;
use std::sync::LazyLock;

/// Remedy if there is no adapter.
pub const HELP: &str =
    "on Debian or Ubuntu, `cargo xtask test --install-driver` installs a software one";

/// A device, and the name of its adapter.
#[derive(Debug)]
pub struct TestDevice {
    /// Name of the adapter, for messages.
    pub adapter: String,
    /// The device.
    pub device: wgpu::Device,
    /// The queue.
    pub queue: wgpu::Queue,
}

/// Returns the device that all tests share.
///
/// # Panics
/// Panics if there is no adapter. A test that needs one fails and is never skipped.
pub fn device() -> &'static TestDevice {
    static DEVICE: LazyLock<TestDevice> =
        LazyLock::new(|| open().unwrap_or_else(|why| panic!("{why}; {HELP}")));
    &DEVICE
}

/// Opens a device on the adapter that is most suitable for tests, or on the one of
/// `WGPU_ADAPTER_NAME`. OpenGL is excluded: see `umbrage_wgpu::AdapterChoice`.
///
/// # Errors
/// Returns an error message if there is none, or it can't be opened.
pub fn open() -> Result<TestDevice, String> {
    open_with(&wgpu::DeviceDescriptor::default())
}

/// Opens a device with these features and limits on the adapter of [`open`].
///
/// # Errors
/// Returns an error message if there is none, or it can't be opened.
pub fn open_with(desc: &wgpu::DeviceDescriptor<'_>) -> Result<TestDevice, String> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let mut adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY));
    adapters.sort_by_key(|a| preference(&a.get_info()));
    let name = crate::gpu::adapter_by_name()
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
        opened.map_err(|e| format!("the graphics adapter {name} has no device: {e}"))?;
    Ok(TestDevice {
        adapter: name,
        device,
        queue,
    })
}

/// Returns the sort key of an adapter. Software adapters come first: they neither fuse nor reorder,
/// so that twins can be required to be bit-equal.
fn preference(info: &wgpu::AdapterInfo) -> (bool, bool) {
    (
        info.device_type != wgpu::DeviceType::Cpu,
        info.backend != wgpu::Backend::Vulkan,
    )
}
