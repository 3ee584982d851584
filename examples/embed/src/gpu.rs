//! The device, and what it reports behind the program's back.

use anyhow::{Context as _, Result, bail};
use std::sync::{Arc, Mutex, PoisonError};
use umbrage::glam::UVec2;

pub struct OpenDevice {
    pub name: String,
    pub adapter: wgpu::Adapter,
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    pub errors: DeviceErrors,
}

/// The first error that no call returned: a fault of validation, memory that ran out, a lost device.
#[derive(Clone, Default)]
pub struct DeviceErrors(Arc<Mutex<Option<String>>>);

impl DeviceErrors {
    fn set(&self, error: String) {
        let mut first = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        first.get_or_insert(error);
    }

    /// DeviceErrors if there was an error.
    pub fn check(&self) -> Result<()> {
        let mut first = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        match first.take() {
            Some(error) => bail!("{error}"),
            None => Ok(()),
        }
    }
}

/// Opens a device, one that can draw to the surface if there is one.
pub fn open(instance: &wgpu::Instance, surface: Option<&wgpu::Surface<'_>>) -> Result<OpenDevice> {
    let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions {
        power_preference: wgpu::PowerPreference::HighPerformance,
        compatible_surface: surface,
        ..wgpu::RequestAdapterOptions::default()
    }))
    .context(
        "no graphics adapter; install a graphics driver, such as Debian's mesa-vulkan-drivers",
    )?;
    // Windows may be larger than what every adapter has.
    let limits = wgpu::Limits::default().using_resolution(adapter.limits());
    let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        required_limits: limits,
        ..wgpu::DeviceDescriptor::default()
    }))
    .context("the graphics adapter gives no device")?;
    let errors = DeviceErrors::default();
    let of_device = errors.clone();
    device.on_uncaptured_error(Arc::new(move |error| of_device.set(error.to_string())));
    let of_loss = errors.clone();
    device.set_device_lost_callback(move |reason, message| {
        if reason != wgpu::DeviceLostReason::Destroyed {
            of_loss.set(format!(
                "the graphics device was lost; start the program again ({message})"
            ));
        }
    });
    Ok(OpenDevice {
        name: adapter.get_info().name,
        adapter,
        device,
        queue,
        errors,
    })
}

impl OpenDevice {
    /// DeviceErrors if the device can't draw pictures of this size.
    pub fn check_size(&self, size: UVec2) -> Result<()> {
        let most = self.device.limits().max_texture_dimension_2d;
        if size.max_element() <= most {
            return Ok(());
        }
        bail!(
            "{} draws pictures of at most {most} pixels along each side",
            self.name
        )
    }
}
