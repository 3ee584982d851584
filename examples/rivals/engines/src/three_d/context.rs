//! OpenGL without a window: a context on an EGL device.

use anyhow::{Context as _, Result, anyhow};
use glutin::{
    api::egl::{context::PossiblyCurrentContext, device::Device, display::Display},
    config::{ConfigSurfaceTypes, ConfigTemplateBuilder},
    context::{ContextApi, ContextAttributesBuilder, Version},
    prelude::*,
};
use std::{ffi::CString, sync::Arc};
use three_d::{Context, HasContext as _, context};

/// OpenGL version of three-d's shaders: `#version 330 core`.
const OPENGL: Version = Version { major: 3, minor: 3 };

/// Returns an OpenGL context on the first device that has one, and three-d's context for it. The
/// first must outlive the second.
///
/// # Errors
/// Returns an error if no device has OpenGL 3.3.
pub fn headless() -> Result<(PossiblyCurrentContext, Context)> {
    let devices = Device::query_devices().context(
        "EGL lists no devices: install a driver, such as Debian's packages libegl1 and libgl1-mesa-dri",
    )?;
    let mut why = anyhow!("EGL's list of devices is empty");
    for device in devices {
        match on_device(&device) {
            Ok(both) => return Ok(both),
            Err(error) => why = error,
        }
    }
    Err(why.context("no device has OpenGL 3.3 without a window"))
}

fn on_device(device: &Device) -> Result<(PossiblyCurrentContext, Context)> {
    // SAFETY: no handle of a display server is passed.
    let display = unsafe { Display::with_device(device, None) }?;
    let template = ConfigTemplateBuilder::new()
        .with_surface_type(ConfigSurfaceTypes::empty())
        .build();
    // SAFETY: the template has no window handle.
    let mut configs = unsafe { display.find_configs(template) }?;
    let config = configs.next().context("no configuration")?;
    let attributes = ContextAttributesBuilder::new()
        .with_context_api(ContextApi::OpenGl(Some(OPENGL)))
        .build(None);
    // SAFETY: the attributes have no window handle.
    let context = unsafe { display.create_context(&config, &attributes) }?;
    let current = context.make_current_surfaceless()?;
    let load = |name: &str| {
        let name = CString::new(name).expect("names of functions have no zero");
        display.get_proc_address(&name)
    };
    // SAFETY: the context is current on this thread and stays so, since the program makes no other.
    let functions = unsafe { context::Context::from_loader_function(load) };
    let three_d = Context::from_gl_context(Arc::new(functions))?;
    Ok((current, three_d))
}

/// Returns the name of the OpenGL renderer.
pub fn renderer_name(context: &Context) -> String {
    // SAFETY: only reads a string.
    unsafe { context.get_parameter_string(context::RENDERER) }
}
