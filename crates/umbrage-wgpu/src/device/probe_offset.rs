//! Probe of a device's unit of polygon offset in 16-bit images, which Vulkan leaves to devices.
//!
//! Draws a triangle at a known depth into one texel with an offset of many units, and reads the
//! texel back.

use crate::{
    device::probe_image::draw_and_read,
    resources::pipelines::{pipeline_layout, shader},
    targets::{DepthState, attachment},
};
use umbrage_core::{BackendError, Format, OffsetUnit};
use wgpu::{
    Device, MultisampleState, PipelineCompilationOptions, Queue, RenderPassDescriptor,
    RenderPipeline, RenderPipelineDescriptor, TextureFormat, VertexState,
};

const LABEL: &str = "umbrage probe of polygon offset";

/// The triangle's depth, as in `probe_offset.wgsl`.
const DEPTH: f32 = 0.25;

/// Constant of the offset, units: an eighth of the depth range if a unit is a step.
const UNITS: i32 = 8_192;

/// Draws a triangle on a device and returns its offset unit. Takes a few milliseconds.
///
/// # Errors
/// Errors if the device fails.
pub(crate) fn probe_offset_unit(
    device: &Device,
    queue: &Queue,
) -> Result<OffsetUnit, BackendError> {
    let steps = draw(device, queue)?;
    Ok(unit_of(f32::from(steps) / f32::from(u16::MAX)))
}

/// Returns the unit for which [`DEPTH`] moves nearest to the measured depth.
fn unit_of(depth: f32) -> OffsetUnit {
    let distance = |unit: OffsetUnit| (DEPTH + UNITS as f32 * unit.depth() - depth).abs();
    if distance(OffsetUnit::TwoSteps) < distance(OffsetUnit::OneStep) {
        OffsetUnit::TwoSteps
    } else {
        OffsetUnit::OneStep
    }
}

/// Returns the drawn texel, in steps of 1/65535.
fn draw(device: &Device, queue: &Queue) -> Result<u16, BackendError> {
    let pipeline = pipeline(device);
    let format = TextureFormat::Depth16Unorm;
    let texels = draw_and_read(device, queue, LABEL, [1, 1], format, |encoder, view| {
        let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
            label: Some(LABEL),
            depth_stencil_attachment: Some(attachment(view, Format::Depth16, true)),
            ..RenderPassDescriptor::default()
        });
        pass.set_pipeline(&pipeline);
        pass.draw(0..3, 0..1);
    })?;
    Ok(texels[0])
}

fn pipeline(device: &Device) -> RenderPipeline {
    let state = DepthState::with_constant_offset(TextureFormat::Depth16Unorm, UNITS);
    let module = shader(device, LABEL, include_str!("probe_offset.wgsl"));
    device.create_render_pipeline(&RenderPipelineDescriptor {
        label: Some(LABEL),
        layout: Some(&pipeline_layout(device, &[])),
        vertex: VertexState {
            module: &module,
            entry_point: Some("place"),
            compilation_options: PipelineCompilationOptions::default(),
            buffers: &[],
        },
        primitive: state.primitive(),
        depth_stencil: Some(state.depth_stencil()),
        multisample: MultisampleState::default(),
        fragment: None,
        multiview_mask: None,
        cache: None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_separated_from_depths() {
        // Values of Mesa, SwiftShader (1.01 steps), hardware, and a device that ignores offsets.
        assert_eq!(unit_of(0.5), OffsetUnit::TwoSteps);
        assert_eq!(unit_of(0.25 + 1.01 * 0.125), OffsetUnit::OneStep);
        assert_eq!(unit_of(0.375), OffsetUnit::OneStep);
        assert_eq!(unit_of(0.25), OffsetUnit::OneStep);
    }
}
