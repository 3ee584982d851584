//! Requirements of recipes on adapters, and limits of devices.

use crate::resources::{counts::check_counting, images::texture_format};
use umbrage_core::{BackendError, BackendLimits, Invalid, Recipe};
use wgpu::{Adapter, Device, DownlevelFlags, Limits, TextureFormat, TextureUsages};

/// Checks whether an adapter can execute a recipe: draw into its float images, clamp a polygon
/// offset, count into 32-bit depth, and use comparison samplers. Useful before
/// [`ShadowRenderer::prepare`](crate::ShadowRenderer::prepare), which only has access to the
/// device.
///
/// # Errors
/// Errors with the first missing feature, and advice.
pub fn check_adapter(adapter: &Adapter, recipe: &Recipe) -> Result<(), BackendError> {
    check_drawable(adapter, TextureFormat::R32Float)?;
    if recipe.shade.is_some() {
        check_drawable(adapter, TextureFormat::Rgba32Float)?;
    }
    check_counting(recipe, adapter.features())?;
    for filter in &recipe.filters {
        if let Some(image) = recipe.images.get(filter.output) {
            check_drawable(adapter, texture_format(image.format))?;
        }
    }
    let flags = adapter.get_downlevel_capabilities().flags;
    let clamps = recipe.casts.iter().any(|c| c.bias.clamp != 0.0);
    if clamps && !flags.contains(DownlevelFlags::DEPTH_BIAS_CLAMP) {
        let help = "set the clamp to 0, or choose another adapter or backend";
        return Err(Invalid::new(
            "polygon offset",
            "has a clamp, which this adapter doesn't support",
            help,
        )
        .into());
    }
    if recipe.receive.kernel.compares() && !flags.contains(DownlevelFlags::COMPARISON_SAMPLERS) {
        return Err(missing_requirement(adapter, "has no comparison samplers"));
    }
    Ok(())
}

/// Returns the limits for recipes on a device.
pub(crate) fn limits(device: &Device) -> BackendLimits {
    let limits = device.limits();
    BackendLimits {
        image_side: limits.max_texture_dimension_2d,
        layers: limits.max_texture_array_layers,
        table_bytes: limits
            .max_storage_buffer_binding_size
            .min(limits.max_buffer_size),
    }
}

/// Errors with the first limit of a device that is below a required one.
pub(crate) fn check_limits(required: &Limits, device: &Limits) -> Result<(), Invalid> {
    let mut missing = None;
    required.check_limits_with_fail_fn(device, false, |name, needed, held| {
        let why = format!("has `{name}` {held}, and light sets need {needed}");
        let help = "request it with `LightSet::REQUIRED_LIMITS`";
        missing.get_or_insert_with(|| Invalid::new("device", why, help));
    });
    missing.map_or(Ok(()), Err)
}

/// Errors if an adapter cannot compute receivers, which every [`Gpu`](crate::Gpu) requires.
pub(crate) fn check_receivers(adapter: &Adapter) -> Result<(), BackendError> {
    check_drawable(adapter, TextureFormat::R32Float)?;
    check_drawable(adapter, TextureFormat::Rgba32Float)?;
    check_drawable(adapter, TextureFormat::R32Uint)?;
    let flags = adapter.get_downlevel_capabilities().flags;
    if flags.contains(DownlevelFlags::VERTEX_STORAGE) {
        return Ok(());
    }
    Err(missing_requirement(
        adapter,
        "cannot read storage buffers in vertex shaders",
    ))
}

fn check_drawable(adapter: &Adapter, format: TextureFormat) -> Result<(), BackendError> {
    let usages = adapter.get_texture_format_features(format).allowed_usages;
    if usages.contains(TextureUsages::RENDER_ATTACHMENT) {
        return Ok(());
    }
    Err(missing_requirement(
        adapter,
        &format!("cannot draw into {format:?} images"),
    ))
}

fn missing_requirement(adapter: &Adapter, why: &str) -> BackendError {
    let info = adapter.get_info();
    let what = format!("graphics adapter {} ({})", info.name, info.backend);
    let help = "choose another adapter (WGPU_ADAPTER_NAME) or graphics API (WGPU_BACKEND), or the CPU backend";
    Invalid::new(what, why, help).into()
}
