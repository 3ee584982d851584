//! Requirements of recipes on adapters, and limits of devices.

use crate::{
    hierarchy::one::check_hierarchy,
    resources::{counts::check_counting, images::texture_format},
};
use umbrage_core::{BackendError, BackendLimits, Invalid, Recipe};
use wgpu::{Adapter, Device, DownlevelFlags, Limits, TextureFormat, TextureUsages};

/// Checks whether an adapter can execute a recipe: draw into its float images, clamp a polygon
/// offset, count into 32-bit depth, use comparison samplers, and build its hierarchy. Useful before
/// [`ShadowRenderer::prepare`](crate::ShadowRenderer::prepare), which only has access to the
/// device.
///
/// # Errors
/// Errors with the first missing feature, and advice.
pub fn check_adapter(adapter: &Adapter, recipe: &Recipe) -> Result<(), BackendError> {
    check_compute(recipe, &adapter.limits())?;
    check_hierarchy(recipe, &adapter.limits())?;
    check_drawable(adapter, TextureFormat::R32Float)?;
    if recipe.shade.is_some() {
        check_drawable(adapter, TextureFormat::Rgba32Float)?;
    }
    check_counting(recipe, adapter.features())?;
    for filter in &recipe.filters {
        let Some(image) = recipe.images.get(filter.output) else {
            continue;
        };
        let format = texture_format(image.format);
        check_drawable(adapter, format)?;
        if filter.kernel.tile().is_some() {
            check_storable(adapter, format)?;
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

/// Limits of compute filters and masks: those of WebGL 2, which has no compute shaders, are raised.
/// WebGPU guarantees them.
pub(crate) const COMPUTE_LIMITS: Limits = Limits {
    max_storage_textures_per_shader_stage: 1,
    max_compute_workgroup_storage_size: 16_352,
    max_compute_invocations_per_workgroup: 64,
    max_compute_workgroup_size_x: 64,
    max_compute_workgroup_size_y: 8,
    max_compute_workgroup_size_z: 1,
    max_compute_workgroups_per_dimension: 65_535,
    ..Limits::downlevel_webgl2_defaults()
};

/// Errors if a recipe has compute passes that exceed the limits of a device.
pub(crate) fn check_compute(recipe: &Recipe, limits: &Limits) -> Result<(), Invalid> {
    let computes = recipe.receive.kernel.in_compute();
    if computes || recipe.filters.iter().any(|f| f.kernel.tile().is_some()) {
        return check_limits(&COMPUTE_LIMITS, limits, "ShadowRenderer");
    }
    Ok(())
}

/// Errors with the first limit of a device that is below a required one. `owner` is the type with
/// the constant of required limits.
pub(crate) fn check_limits(required: &Limits, device: &Limits, owner: &str) -> Result<(), Invalid> {
    let mut missing = None;
    required.check_limits_with_fail_fn(device, false, |name, needed, held| {
        let why = format!("has `{name}` {held}, and `{owner}` needs {needed}");
        let help = format!("request it with `{owner}::REQUIRED_LIMITS`");
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

fn check_storable(adapter: &Adapter, format: TextureFormat) -> Result<(), BackendError> {
    let usages = adapter.get_texture_format_features(format).allowed_usages;
    if usages.contains(TextureUsages::STORAGE_BINDING) {
        return Ok(());
    }
    Err(missing_requirement(
        adapter,
        &format!("cannot store to {format:?} in compute shaders"),
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
